//! `reseflow report`: a page that stands alone, tables that say what the results say, and one sentence for what is broken.

use std::fs;

use serde_json::Value;

use crate::report_results::check_results;
use crate::support::{Bench, TINY};

/// A finished tiny run with two flows, a baseline and a regressor in `runs/tiny`.
fn finished_run() -> Bench {
    let bench = Bench::new();
    let top = TINY.replacen("device = \"cpu\"", "device = \"cpu\"\nregressor = true", 1);
    let rest = "\n[baseline]\nupdates = 2\n\n[baseline.diffusion]\nsteps = 5\n\n[reflow]\nupdates = 2\n\n\
                [reflow.pairs]\nwindows = 1\nnoises = 2\nsolver = { kind = \"euler\", steps = 2 }\n";
    fs::write(bench.path("tiny.toml"), format!("{top}{rest}")).unwrap();
    bench.succeed("run tiny.toml --set train.updates=2 --set train.validate_every=1");
    bench
}

/// The cells of every table row of a Markdown text, split at the first column's name.
pub(crate) fn rows(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().filter(|line| line.starts_with('|'));
    lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

#[test]
fn a_report_of_a_run_says_what_its_results_say() {
    let bench = finished_run();
    let summary = bench.json("report runs/tiny --out report --json");
    assert_eq!(summary["runs"], serde_json::json!(["tiny"]));
    let markdown = String::from_utf8(bench.bytes("report/report.md")).unwrap();
    check_scores(&bench, &markdown);

    let rollout = bench.read_json("runs/tiny/rollout.json");
    let all = rows(&markdown);
    let closed_loop =
        all.iter().find(|row| row.len() == 10 && row[0] == "tiny").expect("no row about acting");
    assert_eq!(closed_loop[7], format!("{} of {}", rollout["successes"], rollout["episodes"]));
    let [low, high] = ["success_low", "success_high"].map(|key| 100.0 * rollout[key].as_f64().unwrap());
    assert_eq!(closed_loop[9], format!("{low:.1} % to {high:.1} %"));
    let known = all.iter().find(|row| row[0] == "Flow 2, paper, Table I").expect("the paper's row");
    assert_eq!(known[1..], ["0.450", "0.766", "0.876"]);

    let html = String::from_utf8(bench.bytes("report/report.html")).unwrap();
    check_well_formed(&html);
    assert!(
        !html.contains("http:")
            && !html.contains("https:")
            && !html.contains("<script")
            && !html.contains("<img")
    );
    assert!(html.matches("<svg ").count() >= 10, "figures are missing from the page");
    for file in summary["figures"].as_array().unwrap() {
        let name = file.as_str().unwrap();
        let bytes = bench.bytes(name);
        if name.ends_with(".png") {
            let picture = image::load_from_memory(&bytes).unwrap().to_rgb8();
            assert!(picture.pixels().any(|pixel| pixel != picture.get_pixel(0, 0)), "{name} is blank");
        } else {
            check_well_formed(std::str::from_utf8(&bytes).unwrap());
        }
    }
    let names: Vec<String> = bench.names("report/figures");
    for part in [
        "steps-",
        "bars-",
        "heat-map-",
        "actions-triangle-",
        "nodes-",
        "frontier-",
        "calibration-",
        "overview",
        "straightness",
        "data-tiny",
        "flow-diagram-tiny",
        "training",
    ] {
        for ending in [".svg", ".png"] {
            assert!(
                names.iter().any(|name| name.starts_with(part) && name.ends_with(ending)),
                "no {part}*{ending}: {names:?}"
            );
        }
    }
    assert!(markdown.contains("Left out: the radar chart"), "one task has no radar chart");
    check_frontier(&bench, &summary);
    check_results(&bench, &summary);
    assert!(markdown.contains("token_scalars = 16"), "the configuration is missing");
}

/// The frontier names every number of steps once for each policy that was timed, beside the ticks of its axes.
fn check_frontier(bench: &Bench, summary: &Value) {
    let files = summary["figures"].as_array().unwrap().iter().map(|file| file.as_str().unwrap());
    let file = files.filter(|name| name.contains("frontier-")).find(|name| name.ends_with(".svg")).unwrap();
    let svg = String::from_utf8(bench.bytes(file)).unwrap();
    // Three policies answer in 1 and in 3 steps, and the regressor in one, each in its own colour.
    for (ink, steps) in [("#0072B2", "1 3"), ("#009E73", "1 3"), ("#D55E00", "1 3"), ("#E69F00", "1")] {
        let names = svg.match_indices("<text ").filter_map(|(at, _)| {
            let (head, text) = svg[at..].split_once('>')?;
            head.contains(ink).then(|| text.split('<').next().unwrap().trim())
        });
        assert_eq!(names.collect::<Vec<_>>().join(" "), steps, "names of points in {ink}");
    }
}

/// Each row of `eval*.json` stands in the table of scores, number by number.
fn check_scores(bench: &Bench, markdown: &str) {
    let all = rows(markdown);
    let files = [
        ("Flow 1", "eval"),
        ("Flow 2", "eval-2"),
        ("ET-SEED", "eval-baseline"),
        ("regressor", "eval-regressor"),
    ];
    for (policy, file) in files {
        let report = bench.read_json(&format!("runs/tiny/{file}.json"));
        for scores in report["rows"].as_array().unwrap() {
            let steps = scores["steps"].to_string();
            let row = all.iter().find(|row| row.len() == 11 && row[..3] == [policy, "test", &steps]);
            let row = row.unwrap_or_else(|| panic!("no row of {policy} in {steps} steps in\n{markdown}"));
            check_row(row, scores);
        }
        if file == "eval" {
            let row = all.iter().find(|row| row.len() == 11 && row[0] == "mean trajectory").unwrap();
            check_row(row, &report["trivial"]["mean_trajectory"]);
        }
    }
}

fn check_row(row: &[&str], scores: &Value) {
    let number = |key: &str| scores[key].as_f64().unwrap();
    let columns =
        ["d_geo_mean", "d_geo_std", "d_geo_episode_std", "", "d_geo_half_turn_mean", "rotation_rad"];
    for (cell, key) in row[4..].iter().zip(columns).filter(|(_, key)| !key.is_empty()) {
        let expected = scores[key].as_f64().map_or_else(|| "–".to_owned(), |value| format!("{value:.4}"));
        assert_eq!(*cell, expected, "`{key}` in {row:?}");
    }
    assert_eq!(row[7], format!("{:.4} to {:.4}", number("d_geo_low"), number("d_geo_high")));
    assert_eq!(row[10], format!("{:.2}", 1e3 * number("translation_m")));
}

/// Every tag that is opened is closed, in order.
fn check_well_formed(text: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let end = rest[start..].find('>').unwrap() + start;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if tag.starts_with('!') || tag.ends_with('/') {
            continue;
        }
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "closed out of order, before: {:.80}", rest),
            None => open.push(tag.split_whitespace().next().unwrap()),
        }
        if open.last() == Some(&"style") {
            rest = &rest[rest.find("</style>").unwrap()..];
        }
    }
    assert!(open.is_empty(), "never closed: {open:?}");
}

#[test]
fn what_is_missing_is_said_and_what_is_broken_is_refused() {
    let bench = Bench::new();
    fs::create_dir_all(bench.path("runs/bare")).unwrap();
    bench.refuses("report runs/none --out report", &["runs/none", "no such folder"]);
    bench.refuses("report runs/bare --out report", &["runs/bare", "neither config.toml nor a result"]);
    fs::write(bench.path("runs/bare/config.toml"), "name = \"bare\"\ntask = \"door\"\n").unwrap();
    let summary = bench.json("report runs/bare --out report --json");
    let left_out = summary["left_out"].to_string();
    for part in ["eval.json", "rollout.json", "data/train.npz", "the bar chart", "closed-loop success"] {
        assert!(left_out.contains(part), "{part}: {left_out}");
    }
    check_well_formed(std::str::from_utf8(&bench.bytes("report/report.html")).unwrap());
    let policies = ["eval-2.json", "eval-baseline.json"];
    assert!(policies.iter().all(|part| !left_out.contains(part)), "nobody asked for them: {left_out}");
    fs::create_dir_all(bench.path("runs/whole")).unwrap();
    let asked = "name = \"whole\"\ntask = \"door\"\n[reflow]\n[baseline]\n";
    fs::write(bench.path("runs/whole/config.toml"), asked).unwrap();
    let left_out = bench.json("report runs/whole --out whole --json")["left_out"].to_string();
    assert!(policies.iter().all(|part| left_out.contains(part)), "{left_out}");

    let before = bench.bytes("report/report.html");
    let broken = [
        ("eval.json", "{\"rows\": [", "eval.json"),
        ("eval.json", "{\"rows\": [{\"steps\": \"one\"}]}", "rows[0]"),
        ("rollout.json", "[]", "rollout.json"),
        ("summary.json", "nonsense", "summary.json"),
        ("config.toml", "name = ", "config.toml"),
        ("data/test.npz", "no archive", "test.npz"),
    ];
    fs::create_dir_all(bench.path("runs/bare/data")).unwrap();
    for (name, text, part) in broken {
        let path = bench.path(&format!("runs/bare/{name}"));
        let kept = fs::read(&path).ok();
        fs::write(&path, text).unwrap();
        bench.refuses("report runs/bare --out report", &[part]);
        match kept {
            Some(bytes) => fs::write(&path, bytes).unwrap(),
            None => fs::remove_file(&path).unwrap(),
        }
    }
    assert_eq!(bench.bytes("report/report.html"), before, "a refused call leaves what was there");
    fs::write(bench.path("blocker"), "").unwrap();
    bench.refuses("report runs/bare --out blocker/report", &["blocker", "cannot be written"]);
}
