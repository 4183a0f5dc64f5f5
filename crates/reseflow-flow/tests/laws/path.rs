//! The paths: their ends, their velocities, and that they move with the world.

use reseflow_data::{Action, ActionChunk};
use reseflow_flow::{FlowError, Path};
use reseflow_lie::geodesic_distance;

use crate::{PATHS, apart, chunk, moved, pose, rng};

fn at(path: Path, noise: &ActionChunk, data: &ActionChunk, t: f64) -> ActionChunk {
    path.at(noise, data, t).expect("equal horizons")
}

#[test]
fn a_path_leads_from_noise_to_data() {
    let mut rng = rng(1);
    for path in PATHS {
        for _ in 0..50 {
            let (noise, data) = (chunk(6, &mut rng), chunk(6, &mut rng));
            assert!(apart(&at(path, &noise, &data, 0.0), &noise) < 1e-13);
            assert!(apart(&at(path, &noise, &data, 1.0), &data) < 1e-13);
            assert!(apart(&at(path, &noise, &data, 0.5), &noise) > 1e-3, "the middle is elsewhere");
        }
    }
}

#[test]
fn the_velocity_is_that_of_the_path() {
    let mut rng = rng(2);
    let step = 1e-4;
    for path in PATHS {
        for _ in 0..50 {
            let (noise, data) = (chunk(4, &mut rng), chunk(4, &mut rng));
            for t in [0.0, 0.2, 0.5, 0.9, 0.99] {
                let velocities = path.velocity(&noise, &data, t).expect("equal horizons");
                let [before, after] = [t - step, t + step].map(|t| at(path, &noise, &data, t));
                for (row, velocity) in velocities.0.iter().enumerate() {
                    let [before, after] = [&before, &after].map(|chunk| chunk.0[row]);
                    let way = before.world_from_gripper.body_twist_to(&after.world_from_gripper).vector6();
                    // A central difference: second order in the step, and rounding over the step.
                    let off = (way / (2.0 * step) - velocity.twist.vector6()).norm();
                    assert!(off < 1e-6 * (1.0 + way.norm() / step), "{path:?} at {t}: {off:e}");
                    let rate = (after.opening - before.opening) / (2.0 * step);
                    assert!((rate - velocity.opening).abs() < 1e-9);
                }
            }
        }
    }
}

#[test]
fn a_screw_has_a_constant_body_twist_and_a_product_a_straight_line_of_origins() {
    let mut rng = rng(3);
    for _ in 0..50 {
        let (noise, data) = (chunk(4, &mut rng), chunk(4, &mut rng));
        let twists = |path: Path, t: f64| path.velocity(&noise, &data, t).expect("equal horizons").0;
        for ((first, last), (start, end)) in
            twists(Path::Screw, 0.0).iter().zip(twists(Path::Screw, 0.9)).zip(noise.iter().zip(data.iter()))
        {
            assert_eq!(first.twist, last.twist);
            let whole = start.world_from_gripper.body_twist_to(&end.world_from_gripper);
            assert!((first.twist - whole).vector6().norm() < 1e-14);
        }
        for t in [0.3, 0.8] {
            let line = |(start, end): (&Action, &Action)| {
                start.world_from_gripper.translation.lerp(&end.world_from_gripper.translation, t)
            };
            let lines: Vec<_> = noise.iter().zip(data.iter()).map(line).collect();
            let off = |path: Path| {
                let found = at(path, &noise, &data, t);
                let off = found
                    .iter()
                    .zip(&lines)
                    .map(|(action, line)| (action.world_from_gripper.translation - line).norm());
                off.fold(0.0, f64::max)
            };
            assert!(off(Path::Product) < 1e-13);
            assert!(off(Path::Screw) > 1e-3, "control: a screw leaves the line");
        }
        let [screw, product] = PATHS.map(|path| at(path, &noise, &data, 0.5));
        for (screw, product) in screw.iter().zip(product.iter()) {
            let apart = geodesic_distance(&screw.world_from_gripper, &product.world_from_gripper);
            assert!(apart.rotation_rad < 1e-12, "both turn alike");
        }
    }
}

#[test]
fn a_path_moves_with_the_world_and_its_velocity_stays() {
    let mut rng = rng(4);
    for path in PATHS {
        for _ in 0..20 {
            let (noise, data, world) = (chunk(4, &mut rng), chunk(4, &mut rng), pose(&mut rng));
            let (moved_noise, moved_data) = (moved(&world, &noise), moved(&world, &data));
            for t in [0.0, 0.3, 0.7] {
                let expected = moved(&world, &at(path, &noise, &data, t));
                assert!(apart(&at(path, &moved_noise, &moved_data, t), &expected) < 1e-12);
                let here = path.velocity(&noise, &data, t).expect("equal horizons");
                let there = path.velocity(&moved_noise, &moved_data, t).expect("equal horizons");
                for (here, there) in here.0.iter().zip(&there.0) {
                    assert!((*here - *there).squared_norm().sqrt() < 1e-10);
                }
            }
        }
    }
}

#[test]
fn horizons_that_differ_are_refused() {
    let mut rng = rng(5);
    let (long, short) = (chunk(5, &mut rng), chunk(4, &mut rng));
    let refused = FlowError::Mismatch { what: "actions", expected: 5, got: 4 };
    for path in PATHS {
        assert_eq!(path.at(&long, &short, 0.5), Err(refused.clone()));
        assert!(path.at(&short, &long, 0.5).is_err());
        assert!(path.velocity(&long, &short, 0.5).is_err());
    }
    assert!(refused.to_string().contains("expected 5, got 4"), "{refused}");
}
