//! Large dependencies stay behind the crate that owns them, so that replacing one changes one room.

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

/// Complains of restricted dependencies, dev-dependencies included, outside their owners.
pub(crate) fn check(metadata: &Metadata) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    for package in metadata.packages.iter().filter(|package| !FREE.contains(&package.name.as_str())) {
        for dependency in &package.dependencies {
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
        let json = format!(
            r#"{{"packages": [{{"name": "{package}", "targets": [], "dependencies": [{{"name": "{dependency}"}}]}}]}}"#
        );
        check(&serde_json::from_str(&json).unwrap()).len()
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
