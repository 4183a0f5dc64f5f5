//! Harmonics, Wigner matrices and coefficients against e3nn's: `scripts/irreps_golden.py` made the values.

use reseflow_net::irreps::{WignerMatrices, clebsch_gordan, spherical_harmonics_into};
use serde_json::Value;

use crate::support::{assert_small, worse, worst_difference};

/// e3nn's numbers are rounded to 15 digits.
const TOLERANCE: f64 = 1e-13;

fn entries(key: &str, fewest: usize) -> Vec<Value> {
    let golden: Value =
        serde_json::from_str(include_str!("../golden/irreps.json")).expect("the file is JSON");
    let entries = golden[key].as_array().expect("a list").clone();
    assert!(entries.len() >= fewest, "only {} entries of {key}", entries.len());
    entries
}

fn numbers(value: &Value) -> Vec<f64> {
    let array = value.as_array().expect("an array");
    array.iter().map(|number| number.as_f64().expect("a number")).collect()
}

#[test]
fn spherical_harmonics_are_those_of_e3nn() {
    let mut worst = 0.0;
    for entry in entries("spherical_harmonics", 10) {
        let direction = numbers(&entry["direction"]);
        let mut found = Vec::new();
        spherical_harmonics_into(6, &[direction[0], direction[1], direction[2]], &mut found);
        worst = worse(worst, worst_difference(&found, &numbers(&entry["values"])));
    }
    assert_small("harmonics of degrees 0 to 6 against e3nn", worst, TOLERANCE);
}

#[test]
fn wigner_matrices_are_those_of_e3nn() {
    let mut worst = 0.0;
    for entry in entries("wigner", 5) {
        let rotation = numbers(&entry["rotation"]);
        let rows = [0, 1, 2].map(|row| [0, 1, 2].map(|column| rotation[3 * row + column]));
        let found = WignerMatrices::new(4, &rows);
        let blocks = entry["blocks"].as_array().expect("a list");
        assert_eq!(blocks.len(), found.blocks.len());
        for (found, expected) in found.blocks.iter().zip(blocks) {
            worst = worse(worst, worst_difference(found, &numbers(expected)));
        }
    }
    assert_small("Wigner matrices of degrees 0 to 4 against e3nn", worst, TOLERANCE);
}

#[test]
fn clebsch_gordan_coefficients_are_those_of_e3nn() {
    let (mut worst, mut of_degree_four) = (0.0, 0);
    for entry in entries("clebsch_gordan", 60) {
        let degrees: Vec<usize> =
            numbers(&entry["degrees"]).into_iter().map(|degree| degree as usize).collect();
        of_degree_four += usize::from(degrees.contains(&4));
        let found = clebsch_gordan(degrees[0], degrees[1], degrees[2]);
        let mut expected = vec![0.0; found.values.len()];
        for (index, value) in entry["entries"].as_object().expect("the non-zero entries") {
            expected[index.parse::<usize>().expect("an index")] = value.as_f64().expect("a number");
        }
        worst = worse(worst, worst_difference(&found.values, &expected));
    }
    assert!(of_degree_four >= 20, "only {of_degree_four} triples with degree 4");
    assert_small("real Clebsch–Gordan coefficients against e3nn", worst, TOLERANCE);
}
