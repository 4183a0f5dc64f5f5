//! Scenes bent within a plane.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_data::{Action, ActionChunk, PointCloud};
use reseflow_lie::{SE3, SO3, Vector3};

use crate::AugmentConfig;

/// Distortions are drawn as they are this far from the middle, metres.
const REFERENCE_M: f64 = 0.15;
/// Largest distortion anywhere in the scene; below one the map stays one to one.
const LARGEST: f64 = 0.6;
/// Sizes of swirls, metres.
const SWIRLS_M: std::ops::Range<f64> = 0.03..0.12;
/// Swirls of a bend.
const SWIRLS: usize = 2;
/// Places between two actions at which the bent path is measured.
const SUBDIVISIONS: usize = 24;

/// A map of the plane across an action's approach axis, the same at every height over it: z ↦ (1 + s) z + a z² + b z³, which keeps angles,
/// and then swirls, which make hooks and waves of lines.
///
/// A pose that stands upright on the plane stays upright and turns as its closing direction does; heights stay as they are. So a
/// pose that follows a drawn curve, closing along it, follows the bent curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bend {
    /// The plane's origin and axes, z along the approach axis.
    world_from_plane: SE3,
    stretch: f64,
    quadratic: Complex,
    cubic: Complex,
    swirls: [Swirl; SWIRLS],
}

/// What turns the surroundings of a place, less and less away from it: by `angle_rad` · exp(−r² / 2 `size_m`²) at the distance r. It keeps
/// areas, and the map stays one to one however large the angle.
#[derive(Debug, Clone, Copy)]
struct Swirl {
    centre_m: Complex,
    angle_rad: f64,
    size_m: f64,
}

impl Swirl {
    const NONE: Self = Self { centre_m: [0.0; 2], angle_rad: 0.0, size_m: 1.0 };

    /// A swirl about one of `places_m`.
    fn draw(places_m: &[Complex], angle_std_rad: f64, rng: &mut ChaCha8Rng) -> Self {
        let normal: f64 = StandardNormal.sample(rng);
        Self {
            centre_m: places_m[rng.random_range(0..places_m.len())],
            angle_rad: angle_std_rad * normal,
            size_m: rng.random_range(SWIRLS_M),
        }
    }

    /// Where a place goes, and where a direction there goes.
    fn map(&self, place: Complex, direction: Complex) -> (Complex, Complex) {
        let from_centre = [place[0] - self.centre_m[0], place[1] - self.centre_m[1]];
        let [x, y] = from_centre;
        let variance = self.size_m * self.size_m;
        let angle = self.angle_rad * (-0.5 * (x * x + y * y) / variance).exp();
        let turn = [angle.cos(), angle.sin()];
        // By how much the angle changes in this direction.
        let change = -angle * (x * direction[0] + y * direction[1]) / variance;
        let moved = times(turn, from_centre);
        let sheared = [direction[0] - change * y, direction[1] + change * x];
        ([self.centre_m[0] + moved[0], self.centre_m[1] + moved[1]], times(turn, sheared))
    }
}

type Complex = [f64; 2];

fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

impl Bend {
    /// A bend in the plane across `action`'s approach axis, about the centroid of `cloud`; `None` where `config` asks for none.
    pub(super) fn draw(
        cloud: &PointCloud,
        action: &SE3,
        config: &AugmentConfig,
        rng: &mut ChaCha8Rng,
    ) -> Option<Self> {
        let AugmentConfig { bend_std: bend, swirl_std_rad, .. } = *config;
        if (bend == 0.0 && swirl_std_rad == 0.0) || cloud.is_empty() {
            return None;
        }
        let points = || cloud.points.iter().map(|point| Vector3::from(point.map(f64::from)));
        let centroid_m = points().sum::<Vector3<f64>>() / cloud.len() as f64;
        let world_from_plane = SE3::new(action.rotation, centroid_m);
        let plane_from_world = world_from_plane.inverse();
        let radius_m = points().map(|point| plane_from_world.act(&point).xy().norm()).fold(0.0, f64::max);
        let mut normal = || -> f64 { if bend > 0.0 { StandardNormal.sample(rng) } else { 0.0 } };
        let stretch = (bend * normal()).clamp(-0.3, 0.3);
        let [quadratic, cubic] = [2.0 * REFERENCE_M, 3.0 * REFERENCE_M * REFERENCE_M]
            .map(|size| [bend * normal() / size, bend * normal() / size]);
        let size = |value: Complex| value[0].hypot(value[1]);
        let worst = 2.0 * size(quadratic) * radius_m + 3.0 * size(cubic) * radius_m * radius_m;
        let shrink = if worst > LARGEST { LARGEST / worst } else { 1.0 };
        let [quadratic, cubic] = [quadratic, cubic].map(|value| value.map(|part| part * shrink));
        let mut drawn = Self { world_from_plane, stretch, quadratic, cubic, swirls: [Swirl::NONE; SWIRLS] };
        let bent = |point| {
            let inside = plane_from_world.act(&point);
            drawn.conformal([inside.x, inside.y]).0
        };
        let places_m: Vec<Complex> = points().map(bent).collect();
        if swirl_std_rad > 0.0 {
            drawn.swirls = std::array::from_fn(|_| Swirl::draw(&places_m, swirl_std_rad, rng));
        }
        Some(drawn)
    }

    /// Where a place of the plane goes, and where a direction there goes.
    fn map(&self, place: Complex, direction: Complex) -> (Complex, Complex) {
        let (place, factor) = self.conformal(place);
        let start = (place, times(factor, direction));
        self.swirls.iter().fold(start, |(place, direction), swirl| swirl.map(place, direction))
    }

    /// Where a place goes without the swirls, and by which complex factor its surroundings are turned and stretched.
    fn conformal(&self, z: Complex) -> (Complex, Complex) {
        let (square, linear) = (times(z, z), 1.0 + self.stretch);
        let (a, b) = (times(self.quadratic, square), times(self.cubic, times(square, z)));
        let place = [0, 1].map(|part| linear * z[part] + a[part] + b[part]);
        let (a, b) = (times(self.quadratic, z), times(self.cubic, square));
        (place, [linear + 2.0 * a[0] + 3.0 * b[0], 2.0 * a[1] + 3.0 * b[1]])
    }

    /// The bent scene's points.
    pub(super) fn points(&self, points: &mut [[f32; 3]]) {
        let plane_from_world = self.world_from_plane.inverse();
        for point in points {
            let inside = plane_from_world.act(&Vector3::from(point.map(f64::from)));
            let ([x, y], _) = self.map([inside.x, inside.y], [1.0, 0.0]);
            let moved = self.world_from_plane.act(&Vector3::new(x, y, inside.z));
            *point = moved.map(|value| value as f32).into();
        }
    }

    /// A pose of the bent scene.
    pub(super) fn pose(&self, pose: &SE3) -> SE3 {
        let inside = self.world_from_plane.inverse() * *pose;
        let closing = inside.rotation.act(&Vector3::y());
        let ([x, y], bent) = self.map([inside.translation.x, inside.translation.y], [closing.x, closing.y]);
        // A gripper that closes across the plane is turned by nothing.
        let angle = times(bent, [closing.x, -closing.y]);
        let turn = SO3::exp(&(Vector3::z() * angle[1].atan2(angle[0])));
        let bent = SE3::new(turn * inside.rotation, Vector3::new(x, y, inside.translation.z));
        self.world_from_plane * bent
    }

    /// The bent trajectory; every action keeps the share of the path that lies before it, as the bend stretches some parts of the
    /// path more than others.
    pub(super) fn actions(&self, chunk: &mut ActionChunk) {
        let straight = self.path(&chunk.0, |pose| *pose);
        let bent = self.path(&chunk.0, |pose| self.pose(pose));
        let poses: Vec<SE3> = (0..chunk.0.len())
            .map(|index| {
                let wanted = straight.share[index * SUBDIVISIONS];
                bent.poses[bent.nearest(index * SUBDIVISIONS, wanted)]
            })
            .collect();
        for (action, pose) in chunk.0.iter_mut().zip(poses) {
            action.world_from_gripper = pose;
        }
    }

    /// The trajectory of `actions` with every pose put through `place`.
    fn path(&self, actions: &[Action], place: impl Fn(&SE3) -> SE3) -> Path {
        let mut poses = Vec::with_capacity(actions.len() * SUBDIVISIONS);
        for pair in actions.windows(2) {
            let (from, to) = (pair[0].world_from_gripper, pair[1].world_from_gripper);
            let parts = (0..SUBDIVISIONS).map(|part| part as f64 / SUBDIVISIONS as f64);
            poses.extend(parts.map(|part| place(&from.interpolate_screw(&to, part))));
        }
        poses.extend(actions.last().map(|action| place(&action.world_from_gripper)));
        let plane_from_world = self.world_from_plane.inverse();
        let mut share = vec![0.0];
        for pair in poses.windows(2) {
            let step = plane_from_world.rotation.act(&(pair[1].translation - pair[0].translation));
            share.push(share[share.len() - 1] + step.xy().norm());
        }
        let length = share[share.len() - 1].max(1e-9);
        share.iter_mut().for_each(|share| *share /= length);
        Path { poses, share }
    }
}

/// A trajectory at many places, also between its actions.
struct Path {
    poses: Vec<SE3>,
    /// The share of the whole length within the plane that lies before each place.
    share: Vec<f64>,
}

impl Path {
    /// The place nearest to `index` along the path of those whose share comes closest to `wanted`.
    fn nearest(&self, index: usize, wanted: f64) -> usize {
        let mut place = index;
        let off = |place: usize| (self.share[place] - wanted).abs();
        // Where the path does not advance within the plane, as on the way down to it, rounding alone must not lead on.
        let is_better = |one: usize, other: usize| off(one) + 1e-9 < off(other);
        while place + 1 < self.share.len() && is_better(place + 1, place) {
            place += 1;
        }
        while place > 0 && is_better(place - 1, place) {
            place -= 1;
        }
        place
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    const COUNT: usize = 8;

    /// A plane in no particular place.
    fn world_from_board() -> SE3 {
        SE3::new(SO3::exp(&Vector3::new(0.7, -0.4, 1.1)), Vector3::new(0.3, -0.1, 0.2))
    }

    /// A tool upright on the board that closes along an arc of the radius 0.1 m: two approaches, then evenly along it.
    fn along_an_arc() -> ActionChunk {
        let pose = |index: usize| {
            let (angle, height_m) =
                (0.2 * index.saturating_sub(2) as f64, if index == 0 { 0.06 } else { 0.01 });
            let place = Vector3::new(0.1 * angle.sin(), 0.1 * (1.0 - angle.cos()), height_m);
            // The closing direction is y.
            let turn = angle - std::f64::consts::FRAC_PI_2;
            world_from_board() * SE3::new(SO3::exp(&(Vector3::z() * turn)), place)
        };
        ActionChunk((0..COUNT).map(|i| Action { world_from_gripper: pose(i), opening: 0.0 }).collect())
    }

    fn cloud() -> PointCloud {
        let points: Vec<[f32; 3]> = (0..49)
            .map(|i| Vector3::new(0.04 * f64::from(i % 7 - 3), 0.04 * f64::from(i / 7 - 3), 0.0))
            .map(|place| world_from_board().act(&place).map(|value| value as f32).into())
            .collect();
        PointCloud { colors: vec![[0; 3]; points.len()], points }
    }

    fn bend(bend_std: f64, swirl_std_rad: f64, seed: u64) -> Bend {
        let next = along_an_arc().0[0].world_from_gripper;
        let config = AugmentConfig { bend_std, swirl_std_rad, ..AugmentConfig::NONE };
        Bend::draw(&cloud(), &next, &config, &mut ChaCha8Rng::seed_from_u64(seed)).unwrap()
    }

    /// Bends, swirls, and both.
    fn draws() -> impl Iterator<Item = Bend> {
        [(0.3, 0.0), (0.0, 1.0), (0.3, 1.0)].into_iter().flat_map(|(bend_std, swirl_std_rad)| {
            (0..40).map(move |seed| bend(bend_std, swirl_std_rad, seed))
        })
    }

    #[test]
    fn bent_poses_keep_their_height_stay_upright_and_follow_the_bent_curve() {
        let mut farthest: f64 = 0.0;
        for bend in draws() {
            let actions = along_an_arc();
            for action in actions.iter() {
                let before = action.world_from_gripper;
                let after = bend.pose(&before);
                let [z, up] = [&before, &after].map(|pose| pose.rotation.act(&Vector3::z()));
                assert!((z - up).norm() < 1e-9, "it leans");
                let height = |pose: &SE3| z.dot(&(pose.translation - world_from_board().translation));
                assert!((height(&before) - height(&after)).abs() < 1e-9, "the height changed");
                // Points a little to both sides along the closing direction end up along the bent one.
                let tip = |by: f64| {
                    bend.pose(&SE3::new(before.rotation, before.act(&(Vector3::y() * by)))).translation
                };
                let along = (tip(1e-6) - tip(-1e-6)).normalize();
                assert!((along - after.rotation.act(&Vector3::y())).norm() < 1e-6, "it is off the curve");
                farthest = farthest.max((after.translation - before.translation).norm());
            }
        }
        assert!(farthest > 0.02, "nothing was bent: {farthest}");
    }

    #[test]
    fn points_and_poses_are_bent_alike() {
        for bend in draws() {
            let pose = along_an_arc().0[4].world_from_gripper;
            let mut points = [pose.translation.map(|value| value as f32).into()];
            bend.points(&mut points);
            let apart = Vector3::from(points[0].map(f64::from)) - bend.pose(&pose).translation;
            assert!(apart.norm() < 1e-6, "{apart}");
        }
    }

    #[test]
    fn actions_keep_their_shares_of_the_path() {
        let lengths = |chunk: &ActionChunk| -> Vec<f64> {
            let steps = chunk.0.windows(2);
            steps
                .map(|pair| {
                    (pair[1].world_from_gripper.translation - pair[0].world_from_gripper.translation).norm()
                })
                .collect()
        };
        let mut uneven: f64 = 0.0;
        for bend in draws() {
            let mut bent = along_an_arc();
            bend.actions(&mut bent);
            let steps = lengths(&bent);
            assert!((steps[0] - 0.05).abs() < 1e-6 && steps[1] < 1e-6, "the approach changed: {steps:?}");
            let mean = steps[2..].iter().sum::<f64>() / (steps.len() - 2) as f64;
            // One place of 24 between two actions is 4 % of a step, at either end.
            assert!(steps[2..].iter().all(|step| (step / mean - 1.0).abs() < 0.12), "{steps:?}");
            let plain: Vec<_> =
                along_an_arc().0.iter().map(|action| bend.pose(&action.world_from_gripper)).collect();
            let plain: Vec<f64> = plain
                .windows(2)
                .skip(2)
                .map(|pair| (pair[1].translation - pair[0].translation).norm())
                .collect();
            uneven = plain.iter().fold(uneven, |most, step| most.max((step / mean - 1.0).abs()));
        }
        assert!(uneven > 0.1, "the bends stretch everything alike: {uneven}");
    }

    #[test]
    fn bends_never_fold_the_plane() {
        for seed in 0..200 {
            let bend = bend(0.5, 1.5, seed);
            for i in 0..=40 {
                let angle = f64::from(i) * 0.157;
                let place = [0.17 * angle.cos(), 0.17 * angle.sin()];
                let (_, factor) = bend.conformal(place);
                assert!(factor[0] > 0.05, "{factor:?}");
                // Swirls keep areas.
                for swirl in &bend.swirls {
                    let [(_, one), (_, other)] = [[1.0, 0.0], [0.0, 1.0]].map(|axis| swirl.map(place, axis));
                    assert!((one[0] * other[1] - one[1] * other[0] - 1.0).abs() < 1e-9);
                }
            }
        }
    }
}
