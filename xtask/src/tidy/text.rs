//! Any text file: nothing that is true on one machine only.

use std::path::PathBuf;

use super::Complaint;
use super::tree::SourceFile;

/// Where people's home folders lie. Split, so that this file may be checked too.
const HOME_FOLDERS: [&str; 4] =
    [concat!("/ho", "me/"), concat!("/Us", "ers/"), concat!("/ro", "ot/"), concat!("C:\\Us", "ers")];

/// Complains of paths under a home folder or under one of `homes` (this checkout, the user's own home).
pub(crate) fn check(file: &SourceFile, homes: &[PathBuf]) -> Vec<Complaint> {
    let homes = homes.iter().filter(|home| home.components().count() > 2).map(|home| home.to_string_lossy());
    let needles: Vec<String> =
        HOME_FOLDERS.iter().map(|folder| folder.to_string()).chain(homes.map(Into::into)).collect();
    let mut complaints = Vec::new();
    for (index, line) in file.text.lines().enumerate() {
        if let Some(needle) = needles.iter().find(|needle| starts_a_path(line, needle)) {
            complaints.push(Complaint::at(
                &file.path,
                index + 1,
                format!("names a folder of one machine: `{needle}`"),
            ));
        }
    }
    complaints
}

/// Whether `needle` occurs in `line` as the beginning of a path, not as a part of a longer one.
fn starts_a_path(line: &str, needle: &str) -> bool {
    line.match_indices(needle).any(|(at, _)| {
        let before = line[..at].chars().next_back();
        before.is_none_or(|c| !(c.is_alphanumeric() || matches!(c, '/' | '_' | '-' | '.' | '}')))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> usize {
        let file = SourceFile { path: "a.md".to_owned(), text: text.to_owned() };
        check(&file, &[PathBuf::from("/srv/checkout"), PathBuf::from("/")]).len()
    }

    #[test]
    fn a_path_of_one_machine_is_found() {
        for text in [
            concat!("see /ho", "me/someone/notes"),
            concat!("\"/ro", "ot/.cache\""),
            concat!("/Us", "ers/someone"),
            "run /srv/checkout/x",
        ] {
            assert_eq!(faults(text), 1, "{text}");
        }
    }

    #[test]
    fn paths_that_hold_everywhere_pass() {
        for text in [
            "crates/reseflow/src",
            "/tmp/out.npz",
            "topic /world/home/pose",
            "a /srv/other",
            "https://example.org/home/x",
        ] {
            assert_eq!(faults(text), 0, "{text}");
        }
    }
}
