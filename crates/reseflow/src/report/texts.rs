//! What the numbers mean, in sentences.

use super::document::Block;
use super::study::{Study, run_title};

/// The sentences before everything else.
pub(super) fn opening(study: &Study) -> Vec<Block> {
    let runs: Vec<String> =
        study.runs.iter().map(|run| format!("{} ({})", run.name, run_title(run))).collect();
    vec![
        Block::text(format!("Runs: {}.", runs.join("; "))),
        Block::text(
            "D_geo is the distance between a predicted and a demonstrated gripper pose, the root of the squared rotation angle (radian) \
             plus the squared distance of the places (metre), as the paper prints it; D̄_geo is its mean over the ten actions of a \
             trajectory, over held-out episodes and over noise seeds. 0 is perfect; a random rotation scores about 2.2. Because it adds \
             radians and metres, its rotation part (rad) and its translation part (mm) stand beside it.",
        ),
        Block::text(
            "“± seeds” is the standard deviation of the means of the noise seeds, as in the paper: how much the luck of the noise \
             matters. “± episodes” is that of the means of the episodes: how much episodes differ. The 95 % interval is a bootstrap over \
             episodes: how sure the mean is. “Half-turn” counts a gripper that is turned by 180° about its approach axis, which grasps as \
             well, as the same.",
        ),
        Block::text(
            "The mean trajectory and the nearest demonstration are predictors without any learning; a policy that does not beat both has \
             learned nothing. The regressor is the same network without noise and flow time, trained to answer at once. ET-SEED is the \
             diffusion baseline on the same network. The paper's numbers were measured in another simulator with other scenes, so that \
             they say what size to expect, not who wins by how much.",
        ),
    ]
}

/// Before the figures over steps.
pub(super) const STEPS: &str = "A step of Euler's rule is one evaluation of the drift; for ET-SEED it is one visited noise level. A rectified flow \
    is meant to lose little in one step against many, and reflow (Flow 2) to lose less than Flow 1.";

/// Before the tables of scores.
pub(super) const SCORES: &str = "“Test” episodes come from the training distribution, “wide” ones have poses, sizes and viewpoints \
    outside it, and “turned” ones are the test episodes moved by rigid motions, on which an equivariant policy scores the same.";

/// Before what is particular to flows.
pub(super) const FLOWS: &str = "Flow 1 learns to carry noise to demonstrations. Flow 2 learns from pairs of noise and of what Flow 1 \
    made of it: where the ways of Flow 1 bend, those of Flow 2 should be straight, and one step then leads as far as many.";

/// Before what training took.
pub(super) const TRAINING: &str = "The paper trains on one window at a time, Flow 1 for 5000 epochs and Flow 2 for 3000, which is 50 000 to \
    2 500 000 updates of Flow 1. Its hyper-parameters are the configurations in configs/paper, where `updates` caps them at 50 000 and \
    30 000. The runs here were trained as their own configurations say, which are folded away at the end of this page.";
