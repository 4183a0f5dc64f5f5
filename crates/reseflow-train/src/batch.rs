//! One shard of a training batch: augmented windows, noise and flow times, drawn from a stream of its own.

use burn::tensor::{Device, Tensor, TensorData};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{ActionChunk, Dataset, Observation, Window};
use reseflow_flow::{
    EndpointTargets, LossContext, LossParts, NodeTargets, PriorFrame, TwistTargets, endpoint_loss, twist_loss,
};
use reseflow_lie::{SE3, Vector3};
use reseflow_net::{DecoderConfig, DriftNet, HeatMap, Parameterisation, TokenBatch};

use crate::augment::{Augmentation, drop_points, jitter};
use crate::convert::{endpoint_tensors, tokens, twist_tensors};
use crate::field::{Seen, encode};
use crate::half_turn::{close_along_motion, closes_along_motion};
use crate::reflow::Example;
use crate::{TrainConfig, TrainError, TrainRequest};

/// A training window as the network is to see it: its observations and its demonstration, augmented.
pub(crate) struct Scene {
    /// The window.
    pub(crate) window: Window,
    /// The O frames, oldest first.
    pub(crate) observed: Vec<Observation>,
    /// Where the gripper took hold.
    world_from_grasp: SE3,
    /// What a prior looks at.
    pub(crate) prior_frame: PriorFrame,
    /// The demonstrated actions.
    pub(crate) clean: ActionChunk,
    /// How much each of them counts.
    pub(crate) weights: Vec<f64>,
    augmentation: Augmentation,
    closes_along_motion: bool,
}

impl Scene {
    /// Augments the window.
    pub(crate) fn draw(
        window: Window,
        data: &Dataset,
        decoder: &DecoderConfig,
        train: &TrainConfig,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let mut observed: Vec<Observation> = window.frames(&data.episodes, decoder.frames).cloned().collect();
        let wanted: Vec<_> = window.targets(&data.episodes, decoder.horizon).collect();
        let (latest, next) = (&observed[observed.len() - 1], wanted[0].action);
        let episode = &data.episodes[window.episode];
        // After a shove the gripper is somewhere beside what is drawn, which a redrawn line has no place for.
        let route = if episode.disturbance.is_none() { episode.actions.as_slice() } else { &[] };
        let closes_along_motion = closes_along_motion(decoder);
        let augmentation =
            Augmentation::draw(window.step, latest, next, route, closes_along_motion, &train.augment, rng);
        observed.iter_mut().for_each(|seen| augmentation.observation(seen));
        observed.iter_mut().for_each(|seen| drop_points(&mut seen.cloud, train.augment.drop_points, rng));
        let prior_frame = PriorFrame::of(&observed[observed.len() - 1]);
        observed.iter_mut().for_each(|seen| jitter(&mut seen.cloud, train.augment.jitter_m, rng));
        let weights = wanted.iter().map(|target| target.weight()).collect();
        let grasp_step = window.grasp_step(&data.episodes);
        let world_from_grasp = match observed.iter().rev().nth(window.step - grasp_step) {
            Some(shown) => shown.world_from_gripper,
            None => {
                let recorded = &data.episodes[window.episode].observations[grasp_step];
                augmentation.earlier(recorded.world_from_gripper)
            }
        };
        let clean = ActionChunk(wanted.iter().map(|target| *target.action).collect());
        let mut scene = Self {
            window,
            observed,
            world_from_grasp,
            prior_frame,
            clean: ActionChunk::default(),
            weights,
            augmentation,
            closes_along_motion,
        };
        scene.clean = scene.taught(clean);
        scene
    }

    /// Actions as the network is to answer with, from those that belong to the scene as it was recorded.
    fn taught(&self, mut actions: ActionChunk) -> ActionChunk {
        self.augmentation.actions(&mut actions);
        if self.closes_along_motion {
            close_along_motion(&mut actions);
        }
        actions
    }

    /// What the network is shown.
    pub(crate) fn seen(&self) -> Seen<'_> {
        Seen {
            frames: self.observed.iter().collect(),
            world_from_grasp: self.world_from_grasp,
            elapsed: self.window.step,
        }
    }
}

/// Draws windows and the loss's inputs, and evaluates the loss of `net`; `drawn` gets the windows.
pub(crate) fn shard_loss(
    net: &DriftNet,
    request: &TrainRequest<'_>,
    device: &Device,
    rng: &mut ChaCha8Rng,
    drawn: &mut Vec<Window>,
) -> Result<LossParts, TrainError> {
    let TrainRequest { model, train, demonstrations: data, mixture, .. } = *request;
    let decoder = &model.network.decoder;
    let count = train.batch_size / train.shards;
    let (mut scenes, mut noisy, mut ends, mut weights, mut times) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for _ in 0..count {
        let given = mixture.map(|mixture| mixture.draw(data, decoder, train.first_window_share, rng));
        let mixed = given.transpose()?.flatten();
        let window = mixed.as_ref().map_or_else(|| draw_window(data, train, rng), |mixed| mixed.window);
        drawn.push(window);
        let scene = Scene::draw(window, data, decoder, train, rng);
        let (noise, clean) = match mixed {
            Some(Example { mut noise, clean, .. }) => {
                // Both belong to the scene as it was recorded.
                scene.augmentation.noise(&mut noise, model.starts_about_the_gripper());
                (noise, scene.taught(clean))
            }
            None => (model.start(&scene.prior_frame, rng), scene.clean.clone()),
        };
        let t = if model.regression { 0.0 } else { train.time.sample(rng) };
        noisy.push(model.path.at(&noise, &clean, t)?);
        times.push(t);
        weights.extend(scene.weights.iter().copied());
        ends.push((noise, clean));
        scenes.push(scene);
    }
    let seen: Vec<Seen<'_>> = scenes.iter().map(Scene::seen).collect();
    let (encoded, context) = encode(net, &seen, device)?;
    let trajectories: Vec<_> = noisy.iter().map(tokens).collect();
    let batch = TokenBatch::new(&trajectories, &times, &context.origins_m, device)?;
    let overlap = match encoded.last() {
        Some(latest) => HeatMap::overlap(&latest.heat),
        None => Tensor::zeros([1], device),
    };
    let actions = weights.len();
    let judged = LossContext {
        path: model.path,
        states: target_tensors(&noisy, &context.origins_m, device),
        weights: Tensor::from_data(TensorData::new(weights, [actions]), device),
        overlap,
    };
    Ok(match decoder.parameterisation {
        Parameterisation::Endpoint => {
            let prediction = net.decode(&context, &batch)?;
            let targets: Vec<ActionChunk> = ends.into_iter().map(|(_, clean)| clean).collect();
            endpoint_loss(
                &EndpointTargets {
                    rotations: prediction.rotations,
                    positions_m: prediction.positions_m,
                    openings: prediction.openings,
                },
                &NodeTargets {
                    rotations: prediction.node_rotations,
                    positions_m: prediction.node_positions_m,
                },
                &target_tensors(&targets, &context.origins_m, device),
                &judged,
                &train.objective,
            )
        }
        Parameterisation::Twist => {
            let prediction = net.decode_twists(&context, &batch)?;
            let velocities: Result<Vec<_>, _> = (ends.iter().zip(&times))
                .map(|((noise, clean), &t)| model.path.velocity(noise, clean, t))
                .collect();
            twist_loss(
                &TwistTargets { twists: prediction.twists, openings: prediction.openings },
                prediction.node_twists,
                &twist_tensors(&velocities?, device),
                &judged,
                &train.objective,
            )
        }
    })
}

/// Draws an episode, and its first window with the share that the configuration says, else any of its windows; windows begin where the
/// actions suit what is seen.
pub(crate) fn draw_window(data: &Dataset, train: &TrainConfig, rng: &mut ChaCha8Rng) -> Window {
    let episode = rng.random_range(0..data.episodes.len());
    let first: f64 = rng.random();
    let first_step = data.episodes[episode].first_step();
    let step = rng.random_range(first_step..data.episodes[episode].actions.len());
    Window { episode, step: if first < train.first_window_share { first_step } else { step } }
}

/// Trajectories in the world's axes, each from its scene's origin.
fn target_tensors(chunks: &[ActionChunk], origins_m: &[[f64; 3]], device: &Device) -> EndpointTargets {
    let actions = chunks.iter().zip(origins_m).flat_map(|(chunk, origin)| {
        chunk.iter().map(|action| {
            let mut pose = action.world_from_gripper;
            pose.translation -= Vector3::from(*origin);
            (pose, action.opening)
        })
    });
    endpoint_tensors(actions, device)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;
    use reseflow_data::{Action, Disturbance, Episode, PointCloud};
    use reseflow_lie::{SE3, SO3, geodesic_distance};

    use crate::AugmentConfig;

    const STEPS: usize = 4;

    /// A gripper that goes along +y, closes on something before its last two steps, and closes against its motion.
    fn against_its_motion() -> Dataset {
        let pose = |at: usize| {
            SE3::new(
                SO3::exp(&(Vector3::z() * std::f64::consts::PI)),
                Vector3::new(0.0, 0.05 * at as f64, 0.0),
            )
        };
        let cloud = PointCloud { points: vec![[0.0; 3], [0.1, 0.0, 0.0]], colors: vec![[9; 3]; 2] };
        let opening = |at: usize| if at < 2 { 1.0 } else { 0.3 };
        let observation = |at: usize| Observation {
            cloud: cloud.clone(),
            world_from_gripper: pose(at),
            gripper_opening: opening(at),
        };
        let action = |at: usize| Action { world_from_gripper: pose(at + 1), opening: 0.0 };
        let episode = Episode {
            observations: (0..STEPS).map(observation).collect(),
            actions: (0..STEPS).map(action).collect(),
            alternative: None,
            disturbance: None,
        };
        Dataset { episodes: vec![episode], meta: None }
    }

    fn scene(step: usize, nearest_half_turn: bool, augment: AugmentConfig, seed: u64) -> Scene {
        let decoder =
            DecoderConfig { horizon: STEPS, frames: 1, nearest_half_turn, ..DecoderConfig::default() };
        let train = TrainConfig { augment, ..TrainConfig::default() };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        Scene::draw(Window { episode: 0, step }, &against_its_motion(), &decoder, &train, &mut rng)
    }

    #[test]
    fn grippers_whose_fingers_are_alike_are_taught_to_close_along_their_motion() {
        let augment = AugmentConfig { half_turn_share: 0.5, ..AugmentConfig::NONE };
        let mut against = [0; 2];
        for seed in 0..40 {
            for (alike, against) in [false, true].into_iter().zip(&mut against) {
                let taught = scene(0, alike, augment, seed).clean;
                let closing = taught.0[0].world_from_gripper.rotation.act(&Vector3::y());
                *against += usize::from(closing.y < 0.0);
            }
        }
        assert!((10..30).contains(&against[0]) && against[1] == 0, "{against:?}");
    }

    /// A line that the gripper goes along, seen as the places of the actions.
    fn on_a_line(disturbance: Option<Disturbance>) -> Dataset {
        let mut data = against_its_motion();
        let [episode] = &mut data.episodes[..] else { unreachable!("there is one") };
        // A quarter of a circle, so that its mirror image is another line.
        let pose = |at: usize| {
            let angle = 0.4 * at as f64;
            let turn = SO3::exp(&(Vector3::z() * angle));
            SE3::new(turn, Vector3::new(0.12 * (angle.cos() - 1.0), 0.12 * angle.sin(), 0.0))
        };
        for (at, seen) in episode.observations.iter_mut().enumerate() {
            seen.world_from_gripper = pose(at);
        }
        for (at, action) in episode.actions.iter_mut().enumerate() {
            action.world_from_gripper = pose(at + 1);
        }
        let place = |action: &Action| action.world_from_gripper.translation.map(|value| value as f32).into();
        let points: Vec<[f32; 3]> = episode.actions.iter().map(place).collect();
        for seen in &mut episode.observations {
            seen.cloud = PointCloud { points: points.clone(), colors: vec![[9; 3]; STEPS] };
        }
        episode.disturbance = disturbance;
        data
    }

    #[test]
    fn a_line_is_redrawn_as_a_whole_also_half_way_and_in_a_mirror_and_not_after_a_shove() {
        const STEP: usize = 2;
        let decoder = DecoderConfig { horizon: STEPS - STEP, frames: 1, ..DecoderConfig::default() };
        let window = Window { episode: 0, step: STEP };
        let shoved = Disturbance { before: 1, answered_from: STEP };
        let (line, answered) = (on_a_line(None), on_a_line(Some(shoved)));
        let recorded = &line.episodes[0].observations[STEP];
        let at = |point: &[f32; 3]| Vector3::from(point.map(f64::from));
        for mirror_share in [0.0, 1.0] {
            let augment = AugmentConfig { redraw_share: 1.0, mirror_share, ..AugmentConfig::NONE };
            let train = TrainConfig { augment, ..TrainConfig::default() };
            let mut farthest = [0.0_f64; 2];
            for seed in 0..20 {
                let draw = |data: &Dataset| {
                    Scene::draw(window, data, &decoder, &train, &mut ChaCha8Rng::seed_from_u64(seed))
                };
                let (Scene { observed, clean, .. }, kept) = (draw(&line), draw(&answered));
                for (point, action) in observed[0].cloud.points[STEP..].iter().zip(&clean.0) {
                    let apart = (at(point) - action.world_from_gripper.translation).norm();
                    assert!(apart < 1e-6, "paint and actions are {apart} m apart");
                }
                let gripper = &observed[0].world_from_gripper;
                let off = geodesic_distance(gripper, &recorded.world_from_gripper);
                assert!(off.d_geo() < 1e-9, "the gripper has left its place by {off:?}");
                for (end, farthest) in [0, STEPS - 1].into_iter().zip(&mut farthest) {
                    let [new, old] = [&observed, &kept.observed].map(|seen| at(&seen[0].cloud.points[end]));
                    *farthest = farthest.max((new - old).norm());
                }
                let is_kept = kept.observed[0].cloud == recorded.cloud;
                assert_eq!(is_kept, mirror_share == 0.0, "an answer to a shove is mirrored, not redrawn");
            }
            assert!(farthest.iter().all(|moved| *moved > 0.01), "the ends moved by {farthest:?} m");
        }
    }

    #[test]
    fn the_network_is_shown_where_the_gripper_took_hold() {
        let recorded = against_its_motion().episodes.remove(0).observations;
        for (step, grasp) in [(0, 0), (1, 1), (2, 1), (3, 1)] {
            let scene = scene(step, false, AugmentConfig::NONE, 1);
            let seen = scene.seen();
            let off = geodesic_distance(&seen.world_from_grasp, &recorded[grasp].world_from_gripper);
            assert!(off.d_geo() < 1e-12, "step {step}: {off:?}");
        }
        // Where the gripper is free it is its own pose, however it was moved; later the distance to it stays.
        let augment = AugmentConfig { gripper_std_m: 0.05, mirror_share: 0.5, ..AugmentConfig::NONE };
        for seed in 0..20 {
            let free = scene(0, false, augment, seed);
            let off = geodesic_distance(&free.seen().world_from_grasp, &free.observed[0].world_from_gripper);
            assert!(off.d_geo() < 1e-12, "{off:?}");
            let held = scene(3, false, augment, seed);
            let off = geodesic_distance(&held.seen().world_from_grasp, &held.observed[0].world_from_gripper);
            assert!((off.translation_m - 0.1).abs() < 1e-9 && off.rotation_rad < 1e-9, "{off:?}");
        }
    }

    #[test]
    fn the_grasp_is_where_a_shown_frame_has_the_gripper() {
        // Step 2 is the first with closed fingers, and its fingers are to open, so that its gripper is moved, and all frames with it.
        let mut data = against_its_motion();
        data.episodes[0].actions[2].opening = 1.0;
        let decoder = DecoderConfig { horizon: STEPS, frames: 2, ..DecoderConfig::default() };
        let augment = AugmentConfig { gripper_std_m: 0.05, ..AugmentConfig::NONE };
        let train = TrainConfig { augment, ..TrainConfig::default() };
        let recorded = data.episodes[0].observations[1].world_from_gripper;
        let mut farthest: f64 = 0.0;
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let scene = Scene::draw(Window { episode: 0, step: 2 }, &data, &decoder, &train, &mut rng);
            let (shown, grasp) = (scene.observed[0].world_from_gripper, scene.seen().world_from_grasp);
            assert!(geodesic_distance(&shown, &grasp).d_geo() < 1e-12);
            farthest = farthest.max(geodesic_distance(&shown, &recorded).translation_m);
        }
        assert!(farthest > 0.02, "the gripper was not moved");
    }
}
