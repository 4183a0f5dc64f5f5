//! README.md and docs/results/reproduce.md against the committed results: their tables and pictures are made from the JSON in
//! `docs/results/`, and no other figure stands in their prose.

use std::fs;
use std::path::{Path, PathBuf};

use super::figures::overview;
use super::page;
use super::results::{Results, RunResult};
use super::summary;

/// Where the tables stand.
const MARKERS: [&str; 2] = ["<!-- results -->\n", "<!-- /results -->\n"];
/// Pixels that another machine's arithmetic may draw otherwise.
const ROUNDED_PIXELS: usize = 20;

/// A Markdown file that shows committed results.
struct Page {
    /// The file, the results and the picture, from the workspace's root.
    text: &'static str,
    results: &'static str,
    picture: &'static str,
    /// The environment variable that names a report's `results.json`, whose runs take the place of committed ones of the same names.
    update: &'static str,
    tables: fn(&Results) -> String,
}

const PAGES: [Page; 2] = [
    Page {
        text: "README.md",
        results: "docs/results/benchmark.json",
        picture: "docs/results/overview.png",
        update: "RESEFLOW_RESULTS",
        tables: summary::markdown,
    },
    Page {
        text: "docs/results/reproduce.md",
        results: "docs/results/reproduce.json",
        picture: "docs/results/reproduce.png",
        update: "RESEFLOW_REPRODUCED",
        tables: |results| page::markdown(results, results),
    },
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The text before the tables, the tables, and the text after them.
fn split(text: &str) -> Option<[&str; 3]> {
    let (before, rest) = text.split_once(MARKERS[0])?;
    let (tables, after) = rest.split_once(MARKERS[1])?;
    Some([before, tables, after])
}

/// The text with other tables.
fn updated(text: &str, tables: &str) -> Option<String> {
    let [before, _, after] = split(text)?;
    let [opening, closing] = MARKERS;
    Some(format!("{before}{opening}\n{tables}\n{closing}{after}"))
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
fn readme_and_pages_show_what_the_committed_results_say() {
    for Page { text: name, results, picture: picture_name, update, tables } in PAGES {
        let (committed, path) = (root().join(results), root().join(name));
        let read =
            |path: &Path| -> Results { serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap() };
        let mut parsed = read(&committed);
        if let Ok(newer) = std::env::var(update) {
            parsed.take(read(&root().join(newer)));
        }
        let picture = overview::picture(&parsed).unwrap().unwrap();
        let text = fs::read_to_string(&path).unwrap();
        let expected =
            updated(&text, &tables(&parsed)).unwrap_or_else(|| panic!("{name} has lost its markers"));
        if std::env::var(update).is_ok() {
            fs::write(&committed, serde_json::to_string_pretty(&parsed).unwrap() + "\n").unwrap();
            fs::write(root().join(picture_name), picture.png().unwrap()).unwrap();
            fs::write(&path, &expected).unwrap();
            continue;
        }
        let how = format!(
            "is not what {results} says: `{update}={results} cargo test -p reseflow --lib readme` makes it again, and the path of a \
             report's results.json there takes its runs"
        );
        let [shown, wanted] = [&text, &expected].map(|text| split(text).unwrap()[1]);
        assert!(shown == wanted, "{name}'s table {how}\nexpected:\n{wanted}\nfound:\n{shown}");
        let drawn = picture.image().unwrap();
        let stored = image::open(root().join(picture_name)).unwrap().to_rgb8();
        assert_eq!(stored.dimensions(), drawn.dimensions(), "{picture_name} {how}");
        let other = stored.pixels().zip(drawn.pixels()).filter(|(stored, drawn)| stored != drawn).count();
        assert!(other <= ROUNDED_PIXELS, "{picture_name} {how}; {other} pixels differ");
    }
}

#[test]
fn readme_and_pages_state_no_figure_beside_their_tables() {
    for Page { text: name, .. } in PAGES {
        let text = fs::read_to_string(root().join(name)).unwrap();
        let [before, _, after] = split(&text).unwrap_or_else(|| panic!("{name} has lost its markers"));
        let found = measured(&format!("{before}{after}"));
        assert!(
            found.is_empty(),
            "{name}: figures that no results file holds: {found:?}; they belong into the table or into CHANGELOG.md"
        );
    }
}

#[test]
fn figures_in_prose_are_found_and_those_in_code_are_not() {
    let text = "It comes within 0.018, solves 50 of\n50 scenes in (1.3 ms) and is 95% sure after 20 minutes.\n\
                ```\nreseflow eval --seeds 10 --rtol 0.001\n```\nMIT or Apache 2.0, ten poses, 100 demonstrations. See issue 6.";
    assert_eq!(measured(text), ["0.018 solves", "50 of", "1.3 ms", "95% sure", "20 minutes"]);
}

#[test]
fn newer_runs_take_the_place_of_those_of_their_names_and_the_others_stay() {
    let run = |name: &str, demonstrations: usize| RunResult {
        name: name.to_owned(),
        task: "door".to_owned(),
        variant: None,
        demonstrations: Some(demonstrations),
        training_seed: Some(1),
        two_experts: false,
        made_with: None,
        timed_with: None,
        nearest_demonstration: None,
        nearest_among: None,
        policies: Vec::new(),
        rollouts: Vec::new(),
    };
    let results = |runs: &[(&str, usize)]| Results {
        runs: runs.iter().map(|(name, count)| run(name, *count)).collect(),
    };
    let mut committed = results(&[("a", 1), ("b", 2), ("c", 3)]);
    committed.take(results(&[("d", 40), ("b", 20)]));
    assert_eq!(committed, results(&[("a", 1), ("b", 20), ("c", 3), ("d", 40)]));
}

#[test]
fn new_tables_replace_the_old_ones_and_nothing_else() {
    let text = "# a\n\n<!-- results -->\nold\n<!-- /results -->\n\nb\n";
    let new = updated(text, "new\n").unwrap();
    assert_eq!(split(&new).unwrap()[1], "\nnew\n\n");
    assert!(
        new.starts_with("# a\n\n<!-- results -->\n") && new.ends_with("<!-- /results -->\n\nb\n"),
        "{new}"
    );
    assert_eq!(updated(&new, "new\n").unwrap(), new);
    assert!(updated("# no markers\n", "new\n").is_none());
}
