//! `reseflow equiv`: exact for the method, and not for a network that sees the world.

use crate::support::Bench;

#[test]
fn plans_move_with_the_scene_unless_the_policy_sees_the_world() {
    let bench = Bench::with_policy();
    let call = "equiv --data held_out.npz --seeds 3 --checkpoint";
    let report = bench.json(&format!("{call} policy --steps 1,4 --at-most 1e-4 --out e.json --json"));
    assert_eq!(bench.read_json("e.json"), report);
    assert_eq!((&report["episodes"], &report["solver"]), (&3.into(), &"euler".into()));
    assert_eq!(report["rows"].as_array().unwrap().len(), 2);
    for (row, steps) in report["rows"].as_array().unwrap().iter().zip([1, 4]) {
        assert_eq!((&row["steps"], &row["actions"]), (&steps.into(), &(3 * 3 * 10).into()));
        assert!(row["max"].as_f64().unwrap() < 1e-4, "{row}");
    }
    let bound = |row: &str| report["rows"][0][row].as_f64().unwrap();
    assert_eq!(bench.run(&format!("{call} policy --at-most {:e}", bound("p999"))).status.code(), Some(0));
    assert_eq!(
        bench.run(&format!("{call} policy --at-most {:e}", 0.99 * bound("p999"))).status.code(),
        Some(1)
    );
    let train = "train --config tiny.toml --data train.npz --out worldly --set model.network.symmetry=none";
    bench.succeed(train);
    let worldly = bench.json(&format!("{call} worldly --json"));
    assert!(worldly["rows"][0]["p50"].as_f64().unwrap() > 0.05, "the control must fail: {worldly}");
    let output = bench.run(&format!("{call} worldly --at-most 1e-4"));
    assert_eq!(output.status.code(), Some(1));
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(complaint.contains("worldly") && complaint.contains("expected at most"), "{complaint}");
    bench.refuses(&format!("{call} policy --out held_out.npz"), &["held_out.npz", "would replace"]);
    bench.refuses(&format!("{call} nothing"), &["nothing", "no such folder"]);
}
