//! Dependencies run down: a crate depends only on crates of a lower floor.

use super::Complaint;
use crate::workspace::Metadata;

/// Every crate with its floor; `None` stands above the house and may use all of it.
const FLOORS: [(&str, Option<u8>); 10] = [
    ("reseflow-lie", Some(0)),
    ("reseflow-lie-tensor", Some(1)),
    ("reseflow-data", Some(1)),
    ("reseflow-sim", Some(2)),
    ("reseflow-net", Some(2)),
    ("reseflow-flow", Some(2)),
    ("reseflow-train", Some(3)),
    ("reseflow", Some(4)),
    ("reseflow-tests", None),
    ("xtask", None),
];

fn floor(name: &str) -> Option<&Option<u8>> {
    FLOORS.iter().find(|(known, _)| *known == name).map(|(_, floor)| floor)
}

/// Complains of crates without a floor, and of edges between members that do not run down. Dev-dependencies count.
pub(crate) fn check(metadata: &Metadata) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    for package in &metadata.packages {
        let Some(own) = floor(&package.name) else {
            complaints.push(Complaint::new(
                &package.name,
                "has no floor: give it one in ARCHITECTURE.md and in tidy's table",
            ));
            continue;
        };
        let Some(own) = own else { continue };
        for dependency in &package.dependencies {
            match floor(&dependency.name) {
                Some(Some(other)) if other >= own => complaints.push(Complaint::new(
                    &package.name,
                    format!("floor {own}, must not depend on {}, floor {other}", dependency.name),
                )),
                Some(None) => complaints.push(Complaint::new(
                    &package.name,
                    format!("must not depend on {}, which stands above the house", dependency.name),
                )),
                _ => {}
            }
        }
    }
    complaints
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(package: &str, dependency: &str) -> Vec<Complaint> {
        let json = format!(
            r#"{{"packages": [{{"name": "{package}", "targets": [], "dependencies": [{{"name": "{dependency}"}}]}}]}}"#
        );
        check(&serde_json::from_str(&json).unwrap())
    }

    #[test]
    fn edges_that_run_down_pass() {
        for (package, dependency) in [
            ("reseflow-data", "reseflow-lie"),
            ("reseflow-sim", "reseflow-data"),
            ("reseflow", "reseflow-train"),
            ("reseflow-tests", "reseflow"),
            ("reseflow-lie", "nalgebra"),
        ] {
            assert_eq!(faults(package, dependency), [], "{package} -> {dependency}");
        }
    }

    #[test]
    fn edges_that_run_up_or_sideways_or_to_tooling_fail() {
        for (package, dependency) in [
            ("reseflow-lie", "reseflow-data"),
            ("reseflow-data", "reseflow-lie-tensor"),
            ("reseflow-flow", "reseflow-net"),
            ("reseflow-train", "reseflow"),
            ("reseflow", "xtask"),
        ] {
            assert_eq!(faults(package, dependency).len(), 1, "{package} -> {dependency}");
        }
    }

    #[test]
    fn a_crate_without_a_floor_fails() {
        let complaints = faults("reseflow-attic", "nalgebra");
        assert!(complaints[0].to_string().contains("reseflow-attic: has no floor"), "{complaints:?}");
    }
}
