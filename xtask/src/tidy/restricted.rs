//! Large dependencies stay behind the crate that owns them, so that replacing one changes one room.
//!
//! Dev-dependencies are free: a test may look at a file through a reader that is not ours.

use super::Complaint;
use crate::workspace::Metadata;

/// A dependency and the crates that may name it.
struct Restriction {
    /// A package's name; a trailing `*` stands for any ending.
    dependency: &'static str,
    owners: &'static [&'static str],
}

const TENSOR_CRATES: &[&str] =
    &["reseflow-lie-tensor", "reseflow-net", "reseflow-flow", "reseflow-train", "reseflow"];

const RESTRICTIONS: &[Restriction] = &[
    Restriction { dependency: "burn*", owners: TENSOR_CRATES },
    Restriction { dependency: "rapier3d*", owners: &["reseflow-sim"] },
    Restriction { dependency: "parry3d*", owners: &["reseflow-sim"] },
    Restriction { dependency: "glamx", owners: &["reseflow-sim"] },
    Restriction { dependency: "mcap", owners: &["reseflow-data"] },
    Restriction { dependency: "foxglove", owners: &["reseflow-data"] },
    Restriction { dependency: "npyz", owners: &["reseflow-data"] },
    Restriction { dependency: "clap*", owners: &["reseflow"] },
    Restriction { dependency: "plotters*", owners: &["reseflow"] },
    Restriction { dependency: "anyhow", owners: &["reseflow"] },
];

/// Crates that may use anything: tests look from outside, tooling is no part of the house.
const FREE: [&str; 2] = ["reseflow-tests", "xtask"];

/// Complains of restricted dependencies outside their owners.
pub(crate) fn check(metadata: &Metadata) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    for package in metadata.packages.iter().filter(|package| !FREE.contains(&package.name.as_str())) {
        for dependency in package.dependencies.iter().filter(|dependency| !dependency.is_dev()) {
            for Restriction { dependency: pattern, owners } in RESTRICTIONS {
                if matches(pattern, &dependency.name) && !owners.contains(&package.name.as_str()) {
                    complaints.push(Complaint::new(
                        &package.name,
                        format!("must not depend on {}, which is for {}", dependency.name, owners.join(", ")),
                    ));
                }
            }
        }
    }
    complaints
}

fn matches(pattern: &str, name: &str) -> bool {
    match pattern.strip_suffix('*') {
        Some(stem) => name.starts_with(stem),
        None => name == pattern,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(package: &str, dependency: &str) -> usize {
        faults_of_kind(package, dependency, "null")
    }

    fn faults_of_kind(package: &str, dependency: &str, kind: &str) -> usize {
        let dependency = format!(r#"{{"name": "{dependency}", "kind": {kind}}}"#);
        let json = format!(
            r#"{{"packages": [{{"name": "{package}", "targets": [], "dependencies": [{dependency}]}}]}}"#
        );
        check(&serde_json::from_str(&json).unwrap()).len()
    }

    #[test]
    fn only_dev_dependencies_are_free() {
        assert_eq!(faults_of_kind("reseflow", "npyz", r#""dev""#), 0);
        assert_eq!(faults_of_kind("reseflow", "npyz", r#""build""#), 1);
    }

    #[test]
    fn owners_and_free_crates_pass() {
        for (package, dependency) in [
            ("reseflow-sim", "rapier3d"),
            ("reseflow-net", "burn"),
            ("reseflow-data", "mcap"),
            ("reseflow", "clap"),
            ("reseflow-tests", "npyz"),
            ("xtask", "clap"),
            ("reseflow-flow", "nalgebra"),
        ] {
            assert_eq!(faults(package, dependency), 0, "{package} -> {dependency}");
        }
    }

    #[test]
    fn everyone_else_fails() {
        for (package, dependency) in [
            ("reseflow", "rapier3d"),
            ("reseflow-data", "burn"),
            ("reseflow-sim", "burn-flex"),
            ("reseflow-train", "mcap"),
            ("reseflow-data", "parry3d"),
            ("reseflow-net", "clap"),
            ("reseflow-lie", "anyhow"),
        ] {
            assert_eq!(faults(package, dependency), 1, "{package} -> {dependency}");
        }
    }
}
