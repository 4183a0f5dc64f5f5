//! README.md against the committed results: its table and its picture are made from `docs/results/benchmark.json`, and no other figure
//! stands in it.

use std::fs;
use std::path::{Path, PathBuf};

use super::figures::overview;
use super::results::Results;
use super::summary;

/// Where the table stands in README.md.
const MARKERS: [&str; 2] = ["<!-- results -->\n", "<!-- /results -->\n"];
/// Names the file that becomes the committed one, a path from the workspace's root.
const UPDATE: &str = "RESEFLOW_RESULTS";
/// Pixels that another machine's arithmetic may draw otherwise.
const ROUNDED_PIXELS: usize = 20;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The text before the table, the table, and the text after it.
fn split(readme: &str) -> Option<[&str; 3]> {
    let (before, rest) = readme.split_once(MARKERS[0])?;
    let (table, after) = rest.split_once(MARKERS[1])?;
    Some([before, table, after])
}

/// README.md with the table of `results`.
fn updated(readme: &str, results: &Results) -> Option<String> {
    let [before, _, after] = split(readme)?;
    let [opening, closing] = MARKERS;
    Some(format!("{before}{opening}\n{}\n{closing}{after}", summary::markdown(results)))
}

/// The measured figures in the prose of a Markdown text: what has a decimal point, a unit of ours, or counts successes.
fn measured(text: &str) -> Vec<String> {
    let mut fenced = false;
    let mut prose = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            prose.push_str(line);
            prose.push(' ');
        }
    }
    let prose = prose.replace("Apache 2.0", "Apache");
    let words: Vec<&str> =
        prose.split_whitespace().map(|word| word.trim_matches(['(', ')', ',', ':', ';'])).collect();
    let is_number = |word: &str| {
        let word = word.trim_end_matches('.');
        !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.')
    };
    let after = |place: usize| words.get(place + 1).map_or("", |word| word.trim_end_matches('.'));
    let figures = words.iter().enumerate().filter(|(place, word)| {
        let decimal = is_number(word) && word.trim_end_matches('.').contains('.');
        let unit = ["rad", "mm", "m", "ms", "s", "%", "MiB", "GiB", "of", "minutes", "hours", "seconds"];
        decimal
            || (is_number(word) && unit.contains(&after(*place)))
            || word.trim_end_matches('.').ends_with('%')
    });
    figures.map(|(place, word)| format!("{word} {}", after(place))).collect()
}

#[test]
fn readme_shows_what_the_committed_results_say() {
    let (committed, picture_path, readme_path) = (
        root().join("docs/results/benchmark.json"),
        root().join("docs/results/overview.png"),
        root().join("README.md"),
    );
    let source = std::env::var(UPDATE).map_or_else(|_| committed.clone(), |path| root().join(path));
    let text = fs::read_to_string(&source).unwrap();
    let results: Results = serde_json::from_str(&text).unwrap();
    let picture = overview::picture(&results).unwrap().unwrap();
    let readme = fs::read_to_string(&readme_path).unwrap();
    let expected = updated(&readme, &results).expect("README.md has lost its markers");
    if std::env::var(UPDATE).is_ok() {
        fs::write(&committed, &text).unwrap();
        fs::write(&picture_path, picture.png().unwrap()).unwrap();
        fs::write(&readme_path, &expected).unwrap();
        return;
    }
    let how = format!(
        "is not what docs/results/benchmark.json says: `{UPDATE}=docs/results/benchmark.json cargo test -p reseflow --lib readme` makes it \
         again, and the path of a report's results.json there takes new results"
    );
    let [shown, wanted] = [&readme, &expected].map(|text| split(text).unwrap()[1]);
    assert!(shown == wanted, "README.md's table {how}\nexpected:\n{wanted}\nfound:\n{shown}");
    let drawn = picture.image().unwrap();
    let stored = image::open(&picture_path).unwrap().to_rgb8();
    assert_eq!(stored.dimensions(), drawn.dimensions(), "docs/results/overview.png {how}");
    let other = stored.pixels().zip(drawn.pixels()).filter(|(stored, drawn)| stored != drawn).count();
    assert!(other <= ROUNDED_PIXELS, "docs/results/overview.png {how}; {other} pixels differ");
}

#[test]
fn readme_states_no_figure_beside_its_table() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let [before, _, after] = split(&readme).expect("README.md has lost its markers");
    let found = measured(&format!("{before}{after}"));
    assert!(
        found.is_empty(),
        "figures that no results file holds: {found:?}; they belong into the table or into CHANGELOG.md"
    );
}

#[test]
fn figures_in_prose_are_found_and_those_in_code_are_not() {
    let text = "It comes within 0.018, solves 50 of\n50 scenes in (1.3 ms) and is 95% sure after 20 minutes.\n\
                ```\nreseflow eval --seeds 10 --rtol 0.001\n```\nMIT or Apache 2.0, ten poses, 100 demonstrations. See issue 6.";
    assert_eq!(measured(text), ["0.018 solves", "50 of", "1.3 ms", "95% sure", "20 minutes"]);
}

#[test]
fn a_new_table_replaces_the_old_one_and_nothing_else() {
    let results = Results { runs: Vec::new() };
    let readme = "# a\n\n<!-- results -->\nold\n<!-- /results -->\n\nb\n";
    let new = updated(readme, &results).unwrap();
    assert_eq!(split(&new).unwrap()[1], format!("\n{}\n", summary::markdown(&results)));
    assert!(
        new.starts_with("# a\n\n<!-- results -->\n") && new.ends_with("<!-- /results -->\n\nb\n"),
        "{new}"
    );
    assert_eq!(updated(&new, &results).unwrap(), new);
    assert!(updated("# no markers\n", &results).is_none());
}
