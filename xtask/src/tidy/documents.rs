//! Documents: what they point at exists, and the map stays short.

use super::Complaint;
use super::tree::SourceFile;

/// A map that is longer than this is not read.
const MAX_ARCHITECTURE_LINES: usize = 200;

/// Top-level folders; code spans that start with one are taken for paths.
const FOLDERS: [&str; 8] =
    ["crates/", "configs/", "assets/", "scripts/", "tests/", "docs/", "xtask/", ".ci/"];

/// Complains of a Markdown file that points at something that is not there (`exists` is asked with the path).
pub(crate) fn check(file: &SourceFile, exists: impl Fn(&str) -> bool) -> Vec<Complaint> {
    if !file.has_extension(&["md"]) {
        return Vec::new();
    }
    let mut complaints = Vec::new();
    let lines = file.text.lines().count();
    if file.path == "ARCHITECTURE.md" && lines > MAX_ARCHITECTURE_LINES {
        let fault = format!("has {lines} lines, at most {MAX_ARCHITECTURE_LINES} are allowed");
        complaints.push(Complaint::new(&file.path, fault));
    }
    let mut fenced = false;
    for (index, line) in file.text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            for path in paths_in(line).filter(|path| !exists(path)) {
                complaints.push(Complaint::at(
                    &file.path,
                    index + 1,
                    format!("points at `{path}`, which does not exist"),
                ));
            }
        }
    }
    complaints
}

/// The code spans of a line that are paths of this workspace; patterns such as `crates/<name>` are none.
fn paths_in(line: &str) -> impl Iterator<Item = &str> {
    line.split('`').skip(1).step_by(2).filter(|span| {
        FOLDERS.iter().any(|folder| span.starts_with(folder)) && !span.contains(['<', '*', '{', ' ', '…'])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(path: &str, text: &str) -> Vec<String> {
        let file = SourceFile { path: path.to_owned(), text: text.to_owned() };
        check(&file, |path| path == "crates/here.rs").iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_pointer_to_nothing_is_found() {
        let complaints = faults("README.md", "`crates/here.rs`\nand `crates/gone.rs`, `cargo`\n");
        assert_eq!(complaints, ["README.md:2: points at `crates/gone.rs`, which does not exist"]);
    }

    #[test]
    fn patterns_fences_and_other_files_are_left_alone() {
        let text = "`crates/<task>/src`, `crates/*/src`, plain crates/gone.rs\n```\n`crates/gone.rs`\n```\n";
        assert!(faults("README.md", text).is_empty());
        assert!(faults("a.rs", "`crates/gone.rs`").is_empty());
    }

    #[test]
    fn the_map_is_at_most_200_lines() {
        assert!(faults("ARCHITECTURE.md", &"\n".repeat(200)).is_empty());
        assert_eq!(faults("ARCHITECTURE.md", &"\n".repeat(201)).len(), 1);
        assert!(faults("CHANGELOG.md", &"\n".repeat(201)).is_empty());
    }
}
