//! Augmentations of a training window, drawn anew each time: the whole scene in another size or seen in a mirror, drawn lines along
//! other ways, the gripper elsewhere, colours turned, points left out, points moved, and the whole scene turned.

mod bend;
mod config;
mod gripper;
mod mirror;
mod points;
mod redraw;
mod scaling;
mod turn;
mod warp;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use reseflow_data::{Action, ActionChunk, Observation, gripper_half_turn};
use reseflow_lie::SE3;

pub use config::AugmentConfig;
use gripper::gripper_move;
use mirror::Mirror;
use points::HueTurn;
pub(crate) use points::{drop_points, jitter};
use scaling::Scaling;
use turn::Turn;
use warp::{Recorded, Warp};

/// What is done to a window as a whole: to all its frames, its noise and its actions alike.
///
/// Observations and noise follow the gripper's move, the actions do not, because an expert's commands depend on the scene alone (but
/// for the choice between grasps that are as good as each other). So the gripper moves only while it may be elsewhere ([`may_be_elsewhere`]).
#[derive(Debug)]
pub(crate) struct Augmentation {
    scaling: Option<Scaling>,
    mirror: Option<Mirror>,
    warp: Option<Warp>,
    /// What takes gripper and noise along with the warp.
    warp_move: Option<SE3>,
    /// What the gripper's own move adds on the right of its pose.
    gripper_move: Option<SE3>,
    /// The same as a change of the world, for the noise.
    noise_move: Option<SE3>,
    is_half_turned: bool,
    hue: Option<HueTurn>,
    /// Comes after everything else.
    turn: Option<Turn>,
}

impl Augmentation {
    /// Draws the changes of a window that starts at `step`, whose latest observation is `latest`, whose next action is `next`, and whose
    /// episode's actions are `route`, or none where its line is not to be redrawn; what is switched off draws nothing. Where what is taught
    /// is the same wherever the gripper stands (`is_taught_along_motion`), it is moved across the next action too, and a redrawn line
    /// begins in any direction from it.
    pub(crate) fn draw(
        step: usize,
        latest: &Observation,
        next: &Action,
        route: &[Action],
        is_taught_along_motion: bool,
        config: &AugmentConfig,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let moves = may_be_elsewhere(step, next);
        let scaling = Scaling::draw(&latest.cloud, config.scale_std, rng);
        let gripper = &latest.world_from_gripper;
        let mirror = match (chance(config.mirror_share, rng), config.mirror_upright) {
            (false, _) => None,
            (true, false) => Some(Mirror::of_gripper(gripper)),
            (true, true) => Mirror::upright(gripper),
        };
        let is_half_turned = chance(config.half_turn_share, rng);
        let hue = HueTurn::draw(config.hue_shift, rng);
        let mut drawn = Self {
            scaling,
            mirror,
            warp: None,
            warp_move: None,
            gripper_move: None,
            noise_move: None,
            is_half_turned,
            hue,
            turn: None,
        };
        let reshaped = |pose: &SE3| {
            let mut pose = *pose;
            drawn.reshape(&mut pose);
            pose
        };
        let (mut gripper, mut next) =
            (reshaped(&latest.world_from_gripper), reshaped(&next.world_from_gripper));
        if config.warps() {
            let mut cloud = latest.cloud.clone();
            drawn.points(&mut cloud.points);
            let route = route.iter().map(|action| reshaped(&action.world_from_gripper)).collect();
            let is_under_way = !moves;
            let recorded =
                Recorded { cloud: &cloud, gripper, next, route, is_under_way, is_taught_along_motion };
            if let Some((warp, follow)) = Warp::draw(&recorded, config, rng) {
                (gripper, next) = (follow * gripper, warp.pose(&next));
                (drawn.warp, drawn.warp_move) = (Some(warp), Some(follow));
            }
        }
        let keeps_near = (!is_taught_along_motion).then_some(&next);
        drawn.gripper_move = moves.then(|| gripper_move(&gripper, keeps_near, config, rng)).flatten();
        drawn.noise_move = drawn.gripper_move.map(|gripper_move| gripper * gripper_move * gripper.inverse());
        drawn.turn = config.scene_rotation.then(|| Turn::draw(&latest.cloud, rng)).flatten();
        drawn
    }

    /// Cloud and gripper as changed.
    pub(crate) fn observation(&self, observation: &mut Observation) {
        self.points(&mut observation.cloud.points);
        self.warp.iter().for_each(|warp| warp.points(&mut observation.cloud.points));
        self.hue.iter().for_each(|hue| hue.colors(&mut observation.cloud.colors));
        let gripper = &mut observation.world_from_gripper;
        self.reshape(gripper);
        self.follow(gripper);
        if let Some(gripper_move) = self.gripper_move {
            *gripper = *gripper * gripper_move;
        }
        self.half_turn(gripper);
        if let Some(turn) = &self.turn {
            turn.points(&mut observation.cloud.points);
            turn.pose(&mut observation.world_from_gripper);
        }
    }

    /// The gripper's pose in an earlier frame, which the gripper's own move leaves where it was.
    pub(crate) fn earlier(&self, mut pose: SE3) -> SE3 {
        self.reshape(&mut pose);
        self.follow(&mut pose);
        self.half_turn(&mut pose);
        self.turn.iter().for_each(|turn| turn.pose(&mut pose));
        pose
    }

    /// Noise that belongs to the scene as it was recorded. Noise drawn about the gripper follows it; noise about the cloud does not.
    pub(crate) fn noise(&self, noise: &mut ActionChunk, is_about_the_gripper: bool) {
        for action in &mut noise.0 {
            let pose = &mut action.world_from_gripper;
            self.reshape(pose);
            if is_about_the_gripper {
                self.follow(pose);
                self.noise_move.iter().for_each(|noise_move| *pose = *noise_move * *pose);
            }
            self.half_turn(pose);
            self.turn.iter().for_each(|turn| turn.pose(pose));
        }
    }

    /// The actions as changed.
    pub(crate) fn actions(&self, chunk: &mut ActionChunk) {
        chunk.0.iter_mut().for_each(|action| self.reshape(&mut action.world_from_gripper));
        self.warp.iter().for_each(|warp| warp.actions(chunk));
        for action in &mut chunk.0 {
            self.half_turn(&mut action.world_from_gripper);
            self.turn.iter().for_each(|turn| turn.pose(&mut action.world_from_gripper));
        }
    }

    fn points(&self, points: &mut [[f32; 3]]) {
        self.scaling.iter().for_each(|scaling| scaling.points(points));
        self.mirror.iter().for_each(|mirror| mirror.points(points));
    }

    fn reshape(&self, pose: &mut SE3) {
        self.scaling.iter().for_each(|scaling| scaling.pose(pose));
        self.mirror.iter().for_each(|mirror| mirror.pose(pose));
    }

    fn follow(&self, pose: &mut SE3) {
        if let Some(warp_move) = self.warp_move {
            *pose = warp_move * *pose;
        }
    }

    fn half_turn(&self, pose: &mut SE3) {
        if self.is_half_turned {
            *pose = *pose * gripper_half_turn();
        }
    }
}

/// Whether the gripper could as well be elsewhere before it takes the action `next` of an episode's `step`: where the episode begins,
/// and while the fingers are to stay open.
///
/// Later on it holds something, or is on its way along something, and its own pose says how far it has come.
fn may_be_elsewhere(step: usize, next: &Action) -> bool {
    step == 0 || next.opening > 0.5
}

/// True with the chance `share`; certain answers draw nothing.
fn chance(share: f64, rng: &mut ChaCha8Rng) -> bool {
    share > 0.0 && rng.random::<f64>() < share
}

#[cfg(test)]
mod tests;
