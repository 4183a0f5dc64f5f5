//! Scenes: coloured clouds in every frame, the gripper's states, and a noisy trajectory at some flow time.

use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_net::{CloudGraph, DecoderConfig, GraphConfig, GripperState, SceneState};

use super::world::World;

#[derive(Debug, Clone)]
pub(crate) struct Cloud {
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) colors: Vec<[u8; 3]>,
}

impl Cloud {
    /// Points in a box of 0.5 m, each of a random colour.
    pub(crate) fn in_a_box(count: usize, rng: &mut ChaCha8Rng) -> Cloud {
        Cloud {
            points: (0..count).map(|_| [(); 3].map(|()| rng.random_range(-0.25..0.25))).collect(),
            colors: random_colors(count, rng),
        }
    }

    pub(crate) fn graph(&self, config: &GraphConfig) -> CloudGraph {
        CloudGraph::build(&self.points, &self.colors, config).expect("the cloud is sound")
    }

    /// The same cloud in another order.
    pub(crate) fn shuffled(&self, rng: &mut ChaCha8Rng) -> Cloud {
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        order.shuffle(rng);
        Cloud {
            points: order.iter().map(|&index| self.points[index]).collect(),
            colors: order.iter().map(|&index| self.colors[index]).collect(),
        }
    }

    pub(crate) fn moved(&self, world: &World) -> Cloud {
        let points = self.points.iter().map(|point| world.point(point)).collect();
        Cloud { points, colors: self.colors.clone() }
    }
}

pub(crate) fn random_colors(count: usize, rng: &mut ChaCha8Rng) -> Vec<[u8; 3]> {
    (0..count).map(|_| rng.random()).collect()
}

/// One scene with a trajectory to be denoised.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    /// One cloud for each frame, oldest first.
    pub(crate) clouds: Vec<Cloud>,
    /// The gripper in each frame.
    pub(crate) grippers: Vec<GripperState>,
    /// The gripper when it took hold.
    pub(crate) grasp: GripperState,
    pub(crate) progress: f64,
    /// The flow's state, L poses.
    pub(crate) noise: Vec<GripperState>,
    pub(crate) time: f64,
}

impl Scene {
    /// These clouds, the gripper and the trajectory anywhere within about 0.3 m.
    pub(crate) fn around(clouds: Vec<Cloud>, horizon: usize, rng: &mut ChaCha8Rng) -> Scene {
        let mut anywhere = || gripper(&SE3::identity(), [2.0, 0.2], rng);
        let grippers = clouds.iter().map(|_| anywhere()).collect();
        let noise = (0..horizon).map(|_| anywhere()).collect();
        let grasp = anywhere();
        Scene { clouds, grippers, grasp, progress: rng.random(), noise, time: rng.random() }
    }

    /// Clouds of `count` points in a box, each frame another.
    pub(crate) fn in_a_box(count: usize, config: &DecoderConfig, rng: &mut ChaCha8Rng) -> Scene {
        let clouds = (0..config.frames).map(|_| Cloud::in_a_box(count, rng)).collect();
        Scene::around(clouds, config.horizon, rng)
    }

    /// Three objects of one colour each, a hand's breadth apart, seen from a robot 1 m away; the gripper moves on between the
    /// frames, and the trajectory is noise about it.
    pub(crate) fn on_a_table(config: &DecoderConfig, rng: &mut ChaCha8Rng) -> Scene {
        let middle = Vector3::new(0.8, -0.5, 0.33);
        let mut cloud = Cloud { points: Vec::new(), colors: Vec::new() };
        for color in [[200, 40, 30], [30, 60, 210], [240, 220, 60]] {
            let object = middle + Vector3::from_fn(|_, _| rng.random_range(-0.15..0.15));
            for _ in 0..33 {
                let on_surface = SO3::sample_haar(rng).act(&Vector3::z()) * 0.04;
                cloud.points.push((object + on_surface).into());
                cloud.colors.push(color);
            }
        }
        let mut world_from_gripper = SE3::new(SO3::sample_haar(rng), middle + Vector3::new(0.02, -0.05, 0.2));
        let (mut clouds, mut grippers) = (Vec::new(), Vec::new());
        for _ in 0..config.frames {
            world_from_gripper = SE3::sample_gaussian(&world_from_gripper, 0.05, 0.02, rng);
            let jitter =
                cloud.points.iter().map(|point| point.map(|value| value + rng.random_range(-2e-3..2e-3)));
            clouds.push(Cloud { points: jitter.collect(), colors: cloud.colors.clone() });
            grippers.push(gripper(&world_from_gripper, [0.0, 0.0], rng));
        }
        let noise = (0..config.horizon).map(|_| gripper(&world_from_gripper, [0.5, 0.1], rng)).collect();
        let grasp = gripper(&world_from_gripper, [0.5, 0.05], rng);
        Scene { clouds, grippers, grasp, progress: rng.random(), noise, time: rng.random() }
    }

    pub(crate) fn moved(&self, world: &World) -> Scene {
        Scene {
            clouds: self.clouds.iter().map(|cloud| cloud.moved(world)).collect(),
            grippers: self.grippers.iter().map(|state| world.gripper(state)).collect(),
            grasp: world.gripper(&self.grasp),
            noise: self.noise.iter().map(|state| world.gripper(state)).collect(),
            ..self.clone()
        }
    }

    pub(crate) fn state(&self) -> SceneState {
        SceneState { frames: self.grippers.clone(), grasp: self.grasp, progress: self.progress }
    }
}

/// A gripper drawn about `mean` with standard deviations in radians and metres, anyhow open.
pub(crate) fn gripper<R: Rng + ?Sized>(
    mean: &SE3,
    [rotation_rad, translation_m]: [f64; 2],
    rng: &mut R,
) -> GripperState {
    let pose = SE3::sample_gaussian(mean, rotation_rad, translation_m, rng);
    let rotation = pose.rotation.matrix();
    GripperState {
        columns: [0, 1, 2].map(|column| rotation.column(column).into_owned().into()),
        position_m: pose.translation.into(),
        opening: rng.random(),
    }
}
