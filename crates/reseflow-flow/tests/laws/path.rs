//! The screw path: its ends, its velocity, and that it moves with the world.

use reseflow_flow::ScrewPath;
use reseflow_lie::geodesic_distance;

use crate::{apart, chunk, moved, pose, rng};

#[test]
fn the_path_leads_from_noise_to_data() {
    let mut rng = rng(1);
    for _ in 0..50 {
        let (noise, data) = (chunk(6, &mut rng), chunk(6, &mut rng));
        assert!(apart(&ScrewPath.at(&noise, &data, 0.0), &noise) < 1e-13);
        assert!(apart(&ScrewPath.at(&noise, &data, 1.0), &data) < 1e-13);
        assert!(apart(&ScrewPath.at(&noise, &data, 0.5), &noise) > 1e-3, "the middle is elsewhere");
    }
}

#[test]
fn the_body_velocity_is_constant() {
    let mut rng = rng(2);
    for _ in 0..50 {
        let (noise, data) = (chunk(4, &mut rng), chunk(4, &mut rng));
        for (row, (start, end)) in noise.iter().zip(data.iter()).enumerate() {
            let velocity = start.world_from_gripper.body_twist_to(&end.world_from_gripper).vector6();
            let step = 0.01;
            for t in [0.0, 0.2, 0.5, 0.9, 0.99] {
                let [now, then] = [t, t + step].map(|t| ScrewPath.at(&noise, &data, t).0[row]);
                let found = now.world_from_gripper.body_twist_to(&then.world_from_gripper).vector6() / step;
                // Rounding of the poses over the step.
                assert!((found - velocity).norm() < 1e-11 * (1.0 + velocity.norm()), "{found} {velocity}");
                let opening_rate = (then.opening - now.opening) / step;
                assert!((opening_rate - (end.opening - start.opening)).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn a_straight_line_of_origins_would_not_be_a_screw() {
    // Control: the product path has the same ends and turns alike, and the check above would see it.
    let mut rng = rng(3);
    let (start, end) = (pose(&mut rng), pose(&mut rng));
    let [straight, screw] = [start.interpolate_product(&end, 0.5), start.interpolate_screw(&end, 0.5)];
    let found = geodesic_distance(&straight, &screw);
    assert!(found.rotation_rad < 1e-12 && found.translation_m > 1e-2, "{found:?}");
}

#[test]
fn the_path_moves_with_the_world() {
    let mut rng = rng(4);
    for _ in 0..20 {
        let (noise, data, world) = (chunk(4, &mut rng), chunk(4, &mut rng), pose(&mut rng));
        for t in [0.0, 0.3, 0.7] {
            let expected = moved(&world, &ScrewPath.at(&noise, &data, t));
            let found = ScrewPath.at(&moved(&world, &noise), &moved(&world, &data), t);
            assert!(apart(&found, &expected) < 1e-12);
        }
    }
}
