//! Rust files: short, introduced, finished.

use super::Complaint;
use super::tree::SourceFile;

/// One idea a file; longer than this and it is two.
const MAX_LINES: usize = 400;

/// Signs of unfinished work. Split, so that this file may be checked too.
const UNFINISHED: [&str; 6] = [
    concat!("to", "do!"),
    concat!("unimpl", "emented!"),
    concat!("FIX", "ME"),
    concat!("TO", "DO"),
    concat!("place", "holder"),
    concat!("#[ig", "nore"),
];

/// Complains of a Rust file that is too long, does not say what it is, or is not finished.
pub(crate) fn check(file: &SourceFile) -> Vec<Complaint> {
    if !file.has_extension(&["rs"]) {
        return Vec::new();
    }
    let mut complaints = Vec::new();
    let lines = file.text.lines().count();
    if lines > MAX_LINES && !is_generated_table(file.name()) {
        complaints
            .push(Complaint::new(&file.path, format!("has {lines} lines, at most {MAX_LINES} are allowed")));
    }
    let opening = file.text.lines().next().and_then(|line| line.strip_prefix("//!"));
    if opening.is_none_or(|words| words.trim().is_empty()) {
        complaints.push(Complaint::at(&file.path, 1, "must open with `//!` and say what the file is"));
    }
    for (index, line) in file.text.lines().enumerate() {
        for word in UNFINISHED {
            if line.contains(word) {
                complaints.push(Complaint::at(&file.path, index + 1, format!("unfinished work: `{word}`")));
            }
        }
    }
    complaints
}

/// Tables that a script wrote are exempt from the limit, by name.
fn is_generated_table(name: &str) -> bool {
    name.ends_with("_table.rs") || name.starts_with("generated")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(path: &str, text: &str) -> Vec<String> {
        let file = SourceFile { path: path.to_owned(), text: text.to_owned() };
        check(&file).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_good_file_passes() {
        assert!(faults("a.rs", "//! Rotations.\n\nfn f() {}\n").is_empty());
        assert!(faults("notes.md", "no header needed\n").is_empty());
    }

    #[test]
    fn the_limit_is_400_lines() {
        let of = |lines: usize| format!("//! Long.\n{}", "\n".repeat(lines - 1));
        assert!(faults("a.rs", &of(400)).is_empty());
        assert_eq!(faults("a.rs", &of(401)), ["a.rs: has 401 lines, at most 400 are allowed"]);
        assert!(faults("src/wigner_table.rs", &of(401)).is_empty());
        assert!(faults("src/generated_wigner.rs", &of(401)).is_empty());
        assert_eq!(faults("src/table.rs", &of(401)).len(), 1);
    }

    #[test]
    fn the_first_line_says_what_the_file_is() {
        for text in ["", "use a;\n", "//!\n", "\n//! Late.\n", "// A comment.\n", "/// A doc comment.\n"] {
            assert_eq!(
                faults("a.rs", text),
                ["a.rs:1: must open with `//!` and say what the file is"],
                "{text:?}"
            );
        }
    }

    #[test]
    fn every_sign_of_unfinished_work_is_found() {
        for word in UNFINISHED {
            let complaints = faults("a.rs", &format!("//! A.\n\n    {word}(\"later\")\n"));
            assert_eq!(complaints, [format!("a.rs:3: unfinished work: `{word}`")]);
        }
    }
}
