//! The sampler with a denoiser that knows the answer, and how its draws move with the scene.

use rand_chacha::ChaCha8Rng;
use reseflow_data::ActionChunk;
use reseflow_flow::{
    Anchor, AnchoredChunk, Denoiser, Diffusion, DiffusionConfig, FlowError, LeftFactor, denoise,
};
use reseflow_lie::SE3;

use super::{anchored, diffusion};
use crate::{apart, moved, pose, rng};

/// Knows the clean trajectories, in the world and from their anchors, and notes what it is asked.
struct Oracle {
    anchors: Vec<Anchor>,
    clean: Vec<AnchoredChunk>,
    asked: Vec<usize>,
    states: Vec<Vec<AnchoredChunk>>,
}

impl Oracle {
    fn new(anchors: &[Anchor], clean: &[AnchoredChunk]) -> Self {
        Self { anchors: anchors.to_vec(), clean: clean.to_vec(), asked: Vec::new(), states: Vec::new() }
    }
}

impl Denoiser for Oracle {
    fn invariant(
        &mut self,
        states: &[AnchoredChunk],
        level: usize,
    ) -> Result<Vec<Vec<LeftFactor>>, FlowError> {
        self.asked.push(level);
        self.states.push(states.to_vec());
        let factors = |(state, clean): (&AnchoredChunk, &AnchoredChunk)| {
            state.0.iter().zip(&clean.0).map(|(noisy, clean)| LeftFactor::between(noisy, clean)).collect()
        };
        Ok(states.iter().zip(&self.clean).map(factors).collect())
    }

    fn equivariant(&mut self, trajectories: &[ActionChunk]) -> Result<Vec<Vec<LeftFactor>>, FlowError> {
        self.asked.push(1);
        let mut all = Vec::new();
        for (scene, trajectory) in trajectories.iter().enumerate() {
            let clean = self.anchors[scene].place(&self.clean[scene]);
            let pairs = trajectory.iter().zip(clean.iter());
            all.push(pairs.map(|(noisy, clean)| LeftFactor::between_actions(noisy, clean)).collect());
        }
        Ok(all)
    }
}

fn anchors(count: usize, rng: &mut ChaCha8Rng) -> Vec<Anchor> {
    (0..count).map(|scene| Anchor { world_from_anchor: pose(rng), opening: 0.2 * scene as f64 }).collect()
}

fn streams(count: usize) -> Vec<ChaCha8Rng> {
    (0..count as u64).map(|stream| rng(900 + stream)).collect()
}

#[test]
fn an_oracle_recovers_the_data_in_any_number_of_steps() {
    for stochastic in [false, true] {
        let diffusion =
            Diffusion::new(&DiffusionConfig { stochastic, ..DiffusionConfig::default() }).unwrap();
        let mut draws = rng(91);
        let (anchors, clean) = (anchors(3, &mut draws), [(); 3].map(|()| anchored(6, &mut draws)));
        for steps in [1, 2, 3, 10, 50, 99, 100] {
            let mut oracle = Oracle::new(&anchors, &clean);
            let drawn = denoise(&mut oracle, &diffusion, &anchors, 6, steps, &mut streams(3)).unwrap();
            for ((anchor, clean), drawn) in anchors.iter().zip(&clean).zip(&drawn) {
                let error = apart(drawn, &anchor.place(clean));
                assert!(error < 1e-9, "{steps} steps, stochastic {stochastic}: {error}");
            }
            assert_eq!(oracle.asked.len(), steps, "evaluations");
            assert_eq!(oracle.asked[0], 100);
            let equivariant = oracle.asked.iter().filter(|level| **level == 1).count();
            assert_eq!(equivariant, usize::from(steps > 1), "one equivariant step, and it is the last");
            assert!(steps == 1 || oracle.asked[steps - 1] == 1);
        }
    }
}

/// Nothing that the invariant kernels see knows where the scene is; what the last one returns moves with it.
#[test]
fn moved_anchors_leave_the_invariant_states_and_move_the_trajectories_draw_by_draw() {
    for stochastic in [false, true] {
        let diffusion =
            Diffusion::new(&DiffusionConfig { stochastic, ..DiffusionConfig::default() }).unwrap();
        let mut draws = rng(92);
        let (anchors, clean) = (anchors(2, &mut draws), [(); 2].map(|()| anchored(4, &mut draws)));
        for steps in [1, 2, 10, 100] {
            let world = pose(&mut draws);
            let turned: Vec<_> = anchors
                .iter()
                .map(|anchor| Anchor { world_from_anchor: world * anchor.world_from_anchor, ..*anchor })
                .collect();
            let run = |anchors: &[Anchor]| {
                let mut oracle = Oracle::new(anchors, &clean);
                let drawn = denoise(&mut oracle, &diffusion, anchors, 4, steps, &mut streams(2)).unwrap();
                (drawn, oracle.states)
            };
            let ((still, before), (carried, after)) = (run(&anchors), run(&turned));
            assert_eq!(before, after, "the invariant kernels see the same numbers, to the bit");
            for (still, carried) in still.iter().zip(&carried) {
                assert!(apart(carried, &moved(&world, still)) < 1e-9, "{steps} steps");
                assert!(apart(carried, still) > 1e-3, "control: nothing was moved");
            }
        }
    }
}

/// A denoiser that answers the identity leaves each level's mean: the sampler must not know the data.
#[test]
fn a_denoiser_that_says_nothing_stays_at_the_anchor() {
    struct Silent;
    impl Denoiser for Silent {
        fn invariant(
            &mut self,
            states: &[AnchoredChunk],
            _: usize,
        ) -> Result<Vec<Vec<LeftFactor>>, FlowError> {
            let still = LeftFactor { clean_from_noisy: SE3::identity(), opening: 0.0 };
            Ok(states.iter().map(|state| vec![still; state.0.len()]).collect())
        }

        fn equivariant(&mut self, trajectories: &[ActionChunk]) -> Result<Vec<Vec<LeftFactor>>, FlowError> {
            let still = LeftFactor { clean_from_noisy: SE3::identity(), opening: 0.0 };
            Ok(trajectories.iter().map(|trajectory| vec![still; trajectory.len()]).collect())
        }
    }
    let mut draws = rng(93);
    let anchors = anchors(1, &mut draws);
    let drawn = denoise(&mut Silent, &diffusion(), &anchors, 5, 1, &mut streams(1)).unwrap();
    let noise = diffusion().draw(5, &mut streams(1)[0]);
    assert!(apart(&drawn[0], &anchors[0].place(&noise)) < 1e-12);
}

#[test]
fn requests_and_answers_that_make_no_sense_are_errors() {
    let mut draws = rng(94);
    let (anchors, clean) = (anchors(2, &mut draws), [(); 2].map(|()| anchored(3, &mut draws)));
    let run = |clean: &[AnchoredChunk], steps: usize, generators: usize| {
        let mut oracle = Oracle::new(&anchors, clean);
        denoise(&mut oracle, &diffusion(), &anchors, 3, steps, &mut streams(generators)).unwrap_err()
    };
    assert_eq!(run(&clean, 0, 2), FlowError::NoSteps);
    assert!(run(&clean, 101, 2).to_string().contains("at most that many steps, got 101"));
    assert!(run(&clean, 1, 1).to_string().contains("generators: expected 2, got 1"));
    assert!(run(&clean[..1], 1, 2).to_string().contains("answered for 1 scenes, expected 2"));
    let mut short = clean.clone();
    short[1].0.pop();
    assert!(run(&short, 1, 2).to_string().contains("2 actions for scene 1, expected 3"));
    let mut broken = clean;
    broken[0].0[2].anchor_from_gripper.translation.x = f64::NAN;
    assert!(run(&broken, 1, 2).to_string().contains("action 2 of scene 0 is not finite"));
}
