//! Tells the program which commit it is built from, so that results can say so.

use std::path::Path;
use std::process::Command;

fn main() {
    // Asked for when this runs: clones that share a target folder share this program, and each has its own commit.
    let package = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default();
    let root = Path::new(&package).join("../..");
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(&root).args(arguments).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    // A changed source, another commit or another branch: each is another answer.
    println!("cargo::rerun-if-changed=../../crates");
    if let Some(log) = git(&["rev-parse", "--path-format=absolute", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    // A repository around ours, such as one that holds a copy of these sources, has other commits.
    let ours = git(&["ls-files", "--error-unmatch", "crates/reseflow/build.rs"]).is_some();
    if let Some(hash) = git(&["rev-parse", "--short=12", "HEAD"]).filter(|_| ours) {
        let changed =
            git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|text| !text.is_empty());
        println!("cargo::rustc-env=RESEFLOW_COMMIT={hash}{}", if changed { "+" } else { "" });
    }
}
