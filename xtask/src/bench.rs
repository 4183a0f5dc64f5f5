//! `cargo xtask bench`: the speed measurements. No test asserts a time; these print it.

use anyhow::Result;

use crate::process::{self, Failure, cargo};
use crate::workspace::Metadata;

/// Run the benches of all crates, or of those named (`lie` stands for `reseflow-lie`).
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask bench                       everything\n  \
    cargo xtask bench lie net               two crates\n  \
    cargo xtask bench sim -- triangle       benches with this in their name")]
pub(crate) struct Args {
    /// Crates, by the last part of their names
    crates: Vec<String>,
    /// Handed on to each bench, after `--`
    #[arg(last = true)]
    passed_on: Vec<String>,
}

/// Runs the benches one after another.
pub(crate) fn run(args: &Args) -> Result<()> {
    let metadata = Metadata::load()?;
    for (package, bench) in choose(&metadata, &args.crates)? {
        let mut command = cargo(["bench", "--locked", "--package", package, "--bench", bench, "--"]);
        process::run("cargo bench", command.args(&args.passed_on))?;
    }
    Ok(())
}

/// The (package, bench target) pairs to run.
fn choose<'a>(metadata: &'a Metadata, crates: &[String]) -> Result<Vec<(&'a str, &'a str)>> {
    let mut known = Vec::new();
    for package in &metadata.packages {
        for target in package.targets.iter().filter(|target| target.kind.iter().any(|kind| kind == "bench")) {
            known.push((package.name.as_str(), target.name.as_str()));
        }
    }
    let short = |package: &str| package.strip_prefix("reseflow-").unwrap_or(package).to_owned();
    for name in crates {
        if !known.iter().any(|(package, _)| *name == short(package) || name == package) {
            let mut names: Vec<_> = known.iter().map(|(package, _)| short(package)).collect();
            names.dedup();
            return Err(Failure::new(format!(
                "no benches in `{name}`; there are some in: {}",
                names.join(", ")
            ))
            .into());
        }
    }
    if !crates.is_empty() {
        known.retain(|(package, _)| crates.iter().any(|name| *name == short(package) || name == package));
    }
    if known.is_empty() {
        return Err(Failure::new("the workspace has no benches").into());
    }
    Ok(known)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn workspace() -> Metadata {
        serde_json::from_str(
            r#"{"packages": [
                {"name": "reseflow-lie", "dependencies": [], "targets": [
                    {"name": "reseflow_lie", "kind": ["lib"]}, {"name": "se3", "kind": ["bench"]}]},
                {"name": "reseflow-sim", "dependencies": [], "targets": [{"name": "triangle", "kind": ["bench"]}]},
                {"name": "reseflow", "dependencies": [], "targets": [{"name": "reseflow", "kind": ["bin"]}]}
            ]}"#,
        )
        .unwrap()
    }

    #[test]
    fn names_choose_and_their_absence_means_all() {
        let metadata = workspace();
        let all = choose(&metadata, &[]).unwrap();
        assert_eq!(all, [("reseflow-lie", "se3"), ("reseflow-sim", "triangle")]);
        assert_eq!(choose(&metadata, &["sim".to_owned()]).unwrap(), [("reseflow-sim", "triangle")]);
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_known_ones() {
        let error = choose(&workspace(), &["robot".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("robot") && error.contains("lie, sim"), "{error}");
    }
}
