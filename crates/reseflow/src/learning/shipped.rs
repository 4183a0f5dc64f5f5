//! Policies that ship with the program, found by name: `door/flow2` is the folder `assets/pretrained/door/flow2`.

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

use crate::config::nearest;
use crate::error::bad_input;

/// Where they are, in the current folder or in the source tree that this program was built from.
const FOLDER: &str = "assets/pretrained";

/// The policy's folder that `given` is the path of, or else the name.
///
/// # Errors
/// Bad input that lists the names that there are.
pub fn find_policy(given: &Path) -> anyhow::Result<PathBuf> {
    find(given, &roots(), "a checkpoint's", "policy", 2)
}

/// The folder of a task's policies that `given` is the path of, or else the name.
///
/// # Errors
/// Bad input that lists the names that there are.
pub fn find_policies(given: &Path) -> anyhow::Result<PathBuf> {
    find(given, &roots(), "one of trained policies", "task", 1)
}

fn roots() -> [PathBuf; 2] {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(FOLDER);
    [PathBuf::from(FOLDER), std::fs::canonicalize(&source).unwrap_or(source)]
}

/// Names have `depth` parts; `expected` is what a path should be of, `what` that which has a name.
fn find(
    given: &Path,
    roots: &[PathBuf],
    expected: &str,
    what: &str,
    depth: usize,
) -> anyhow::Result<PathBuf> {
    if given.is_dir() {
        return Ok(given.to_owned());
    }
    let is_name = given.components().all(|part| matches!(part, Component::Normal(_)));
    if is_name && given.components().count() == depth {
        let places = roots.iter().map(|root| root.join(given));
        if let Some(found) = places.into_iter().find(|place| place.is_dir()) {
            return Ok(found);
        }
    }
    let place = given.display().to_string();
    let names: BTreeSet<String> = roots.iter().flat_map(|root| names(root, depth)).collect();
    let mut sentence = format!("{place}: there is no such folder, expected {expected}");
    if !names.is_empty() {
        let listed = names.iter().cloned().collect::<Vec<_>>().join(", ");
        sentence += &format!(", or the name of a shipped {what}: {listed}");
    }
    if let Some(near) = nearest(&place, names.iter().map(String::as_str)) {
        sentence += &format!("; did you mean `{near}`?");
    }
    Err(bad_input(sentence))
}

/// The names of `depth` parts under `root`.
fn names(root: &Path, depth: usize) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(root) else { return Vec::new() };
    let folders = entries.flatten().filter(|entry| entry.path().is_dir());
    let folders = folders.map(|entry| (entry.file_name().to_string_lossy().into_owned(), entry.path()));
    if depth == 1 {
        return folders.map(|(name, _)| name).collect();
    }
    let below = |(name, path): (String, PathBuf)| {
        names(&path, depth - 1).into_iter().map(move |part| format!("{name}/{part}"))
    };
    folders.flat_map(below).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policy_is_found_by_path_first_and_then_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let roots = [folder.path().join("here"), folder.path().join("there")];
        for name in ["here/door/flow1", "there/door/flow1", "there/painting/flow2", "elsewhere"] {
            std::fs::create_dir_all(folder.path().join(name)).unwrap();
        }
        let policy = |given: &Path| find(given, &roots, "a checkpoint's", "policy", 2);
        let path = folder.path().join("elsewhere");
        assert_eq!(policy(&path).unwrap(), path);
        assert_eq!(policy(Path::new("door/flow1")).unwrap(), roots[0].join("door/flow1"), "the first root");
        assert_eq!(policy(Path::new("painting/flow2")).unwrap(), roots[1].join("painting/flow2"));
        let fault = policy(Path::new("dor/flow1")).unwrap_err().to_string();
        assert!(
            fault.contains("shipped policy: door/flow1, painting/flow2; did you mean `door/flow1`"),
            "{fault}"
        );
        let fault = policy(Path::new("../door/flow1")).unwrap_err().to_string();
        assert!(fault.contains("no such folder"), "a path is no name: {fault}");
        let fault = find(Path::new("wall"), &roots, "one", "task", 1).unwrap_err().to_string();
        assert!(fault.contains("shipped task: door, painting"), "{fault}");
    }

    #[test]
    fn where_nothing_ships_nothing_is_listed() {
        let fault = find(Path::new("x"), &[PathBuf::from("no such")], "a checkpoint's", "policy", 2);
        assert_eq!(fault.unwrap_err().to_string(), "x: there is no such folder, expected a checkpoint's");
    }
}
