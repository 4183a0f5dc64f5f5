//! Scenes whose drawn line runs otherwise.

use std::f64::consts::PI;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use reseflow_lie::{SE3, SO3, Vector3};

use super::chance;

/// Places between two actions at which the recorded path is known.
const SUBDIVISIONS: usize = 24;
/// Places nearer to each other than this are one, metres.
const SAME_M: f64 = 1e-5;
/// Shorter paths are not redrawn, metres.
const SHORTEST_M: f64 = 0.05;
/// Standard deviations, radian, of the new line's curvature over its length: of the mean, which is the whole turn, and of the amplitudes
/// of cosines with half a period, one, and one and a half.
const CURVATURE_STD_RAD: [f64; 4] = [5.0, 3.5, 2.5, 1.5];
/// How many of the new lines are straight.
const STRAIGHT_SHARE: f64 = 0.15;
/// The new line is nowhere bent more than a circle of this radius, metres.
const LEAST_RADIUS_M: f64 = 0.025;
/// Places further apart along the new line than the first keep the second as their distance, metres.
const CLEARANCE_M: [f64; 2] = [0.07, 0.035];
/// What is further from the recorded path, metres, does not belong to it; the disc that marks a line's beginning reaches as far as 11 mm.
const SURROUNDINGS_M: f64 = 0.015;
/// Draws after which a line is not redrawn.
const MAX_DRAWS: usize = 32;

type Place = [f64; 2];

/// A map of the plane across an action's approach axis that takes the path of an episode's actions to another curve of the same length.
///
/// What lies beside the path goes with the nearest place of it, by a rigid motion, so that widths, heights and lengths stay what they
/// are; points further away are shifted as a whole, as the line's middle is, and may be turned about it, so that nothing but the line
/// itself says which way it runs. The new curve is smooth, keeps clear of itself, and goes
/// through the old one's place next to the anchor in the same direction. An expert that follows a drawn line would follow the new one
/// by the new actions.
#[derive(Debug, Clone)]
pub(super) struct Redraw {
    /// The plane's origin and axes, z along the approach axis.
    world_from_plane: SE3,
    old: Vec<Place>,
    new: Vec<Place>,
    /// By how much the surroundings of each place are turned.
    turn_rad: Vec<f64>,
    /// Where everything else goes, in the plane's axes.
    rest: SE3,
}

impl Redraw {
    /// Another line for the path through `route`, in a plane whose origin is the anchor and whose z is the approach axis; `None` where
    /// there is no path to speak of, or no line was found. `turns_rest`: whether what is far from the line is turned, by any angle.
    pub(super) fn draw(
        route: &[SE3],
        world_from_plane: &SE3,
        turns_rest: bool,
        rng: &mut ChaCha8Rng,
    ) -> Option<Self> {
        let old = path(route, &world_from_plane.inverse());
        let lengths: Vec<f64> = old.windows(2).map(|pair| distance(pair[0], pair[1])).collect();
        let length = lengths.iter().sum::<f64>();
        if length < SHORTEST_M {
            return None;
        }
        let headings = headings(&old);
        let fixed = nearest(&old, [0.0; 2]);
        let mut share = vec![0.0];
        lengths.iter().for_each(|step| share.push(share[share.len() - 1] + step / length));
        // Decided before any is refused, as a straight one never is.
        let is_straight = chance(STRAIGHT_SHARE, rng);
        let (new, new_headings) = (0..MAX_DRAWS).find_map(|_| {
            let amplitudes = if is_straight { [0.0; 4] } else { draw_amplitudes(rng) };
            let is_smooth = share.iter().all(|share| bend(&amplitudes, *share) * LEAST_RADIUS_M <= length);
            let start = headings[fixed] - turn(&amplitudes, share[fixed]);
            let new_headings: Vec<f64> =
                share.iter().map(|share| start + turn(&amplitudes, *share)).collect();
            let new = integrated(&new_headings, &lengths, fixed, old[fixed]);
            (is_smooth && keeps_clear(&new, &share, length)).then_some((new, new_headings))
        })?;
        let turn_rad = new_headings.iter().zip(&headings).map(|(new, old)| new - old).collect();
        let rest_turn_rad = if turns_rest { rng.random_range(-PI..PI) } else { 0.0 };
        let rest = in_plane(middle(&new), rest_turn_rad) * in_plane(middle(&old), 0.0).inverse();
        Some(Self { world_from_plane: *world_from_plane, old, new, turn_rad, rest })
    }

    /// Where everything goes that is far from the line, in the world.
    pub(super) fn rest(&self) -> SE3 {
        self.world_from_plane * self.rest * self.world_from_plane.inverse()
    }

    /// The redrawn scene's points.
    pub(super) fn points(&self, points: &mut [[f32; 3]]) {
        let plane_from_world = self.world_from_plane.inverse();
        let rest = self.rest();
        for point in points {
            let world = Vector3::from(point.map(f64::from));
            let inside = plane_from_world.act(&world);
            let index = nearest(&self.old, [inside.x, inside.y]);
            let moved = if distance(self.old[index], [inside.x, inside.y]) > SURROUNDINGS_M {
                rest.act(&world)
            } else {
                self.world_from_plane.act(&self.motion(index).act(&inside))
            };
            *point = moved.map(|value| value as f32).into();
        }
    }

    /// A pose of the redrawn scene.
    pub(super) fn pose(&self, pose: &SE3) -> SE3 {
        let inside = self.world_from_plane.inverse() * *pose;
        let index = nearest(&self.old, [inside.translation.x, inside.translation.y]);
        self.world_from_plane * self.motion(index) * inside
    }

    /// Where the surroundings of a place of the path go, in the plane's axes.
    fn motion(&self, index: usize) -> SE3 {
        in_plane(self.new[index], self.turn_rad[index]) * in_plane(self.old[index], 0.0).inverse()
    }
}

/// A frame at a place, turned about the plane's normal.
fn in_plane(place: Place, turn_rad: f64) -> SE3 {
    SE3::new(SO3::exp(&(Vector3::z() * turn_rad)), Vector3::new(place[0], place[1], 0.0))
}

fn middle(places: &[Place]) -> Place {
    [0, 1].map(|axis| places.iter().map(|place| place[axis]).sum::<f64>() / places.len() as f64)
}

/// The places along `route` in the plane's axes.
fn path(route: &[SE3], plane_from_world: &SE3) -> Vec<Place> {
    let mut places: Vec<Place> = Vec::with_capacity(route.len() * SUBDIVISIONS);
    let mut add = |pose: &SE3| {
        let at = plane_from_world.act(&pose.translation);
        if places.last().is_none_or(|last| distance(*last, [at.x, at.y]) > SAME_M) {
            places.push([at.x, at.y]);
        }
    };
    for pair in route.windows(2) {
        let shares = (0..SUBDIVISIONS).map(|part| part as f64 / SUBDIVISIONS as f64);
        shares.for_each(|share| add(&pair[0].interpolate_screw(&pair[1], share)));
    }
    route.last().into_iter().for_each(add);
    places
}

/// The direction of travel at each place, radian and continuous: between those of the steps before and after it.
fn headings(places: &[Place]) -> Vec<f64> {
    let mut steps: Vec<f64> = Vec::with_capacity(places.len());
    for pair in places.windows(2) {
        let angle = (pair[1][1] - pair[0][1]).atan2(pair[1][0] - pair[0][0]);
        let last = steps.last().copied().unwrap_or(angle);
        steps.push(last + (angle - last + PI).rem_euclid(2.0 * PI) - PI);
    }
    // Beyond either end it goes on turning as it did.
    let beyond = |end: f64, inner: f64| end + 0.5 * (end - inner);
    (0..places.len())
        .map(|index| match (index.checked_sub(1).and_then(|before| steps.get(before)), steps.get(index)) {
            (Some(before), Some(after)) => 0.5 * (before + after),
            (Some(end), None) => beyond(*end, steps[steps.len().saturating_sub(2)]),
            (None, Some(end)) => beyond(*end, steps[1.min(steps.len() - 1)]),
            (None, None) => 0.0,
        })
        .collect()
}

fn draw_amplitudes(rng: &mut ChaCha8Rng) -> [f64; 4] {
    CURVATURE_STD_RAD.map(|std| {
        let normal: f64 = StandardNormal.sample(rng);
        std * normal
    })
}

/// The size of the curvature, in radian over the whole length, after this share of it.
fn bend(amplitudes: &[f64; 4], share: f64) -> f64 {
    let cosines = amplitudes.iter().enumerate().map(|(k, size)| size * (PI * k as f64 * share).cos());
    cosines.sum::<f64>().abs()
}

/// The turn after this share of the length, radian: the curvature's integral.
fn turn(amplitudes: &[f64; 4], share: f64) -> f64 {
    let [mean, ..] = amplitudes;
    let waves = amplitudes.iter().enumerate().skip(1).map(|(k, size)| {
        let frequency = PI * k as f64;
        size * (frequency * share).sin() / frequency
    });
    mean * share + waves.sum::<f64>()
}

/// The curve with these headings at its places, `lengths` apart, with the one at `fixed` in `place`.
fn integrated(headings: &[f64], lengths: &[f64], fixed: usize, place: Place) -> Vec<Place> {
    let mut places = vec![[0.0; 2]];
    for (pair, length) in headings.windows(2).zip(lengths) {
        let (sin, cos) = (0.5 * (pair[0] + pair[1])).sin_cos();
        let [x, y] = places[places.len() - 1];
        places.push([x + length * cos, y + length * sin]);
    }
    let shift = [0, 1].map(|axis| place[axis] - places[fixed][axis]);
    places.iter().map(|place| [place[0] + shift[0], place[1] + shift[1]]).collect()
}

/// Whether parts of the curve that are far apart along it are so in the plane.
fn keeps_clear(places: &[Place], share: &[f64], length: f64) -> bool {
    let [along, apart] = CLEARANCE_M;
    let few: Vec<usize> = (0..places.len()).step_by(4).collect();
    few.iter().all(|&one| {
        let far = few.iter().filter(|&&other| (share[other] - share[one]) * length > along);
        far.into_iter().all(|&other| distance(places[one], places[other]) > apart)
    })
}

/// The index of the place nearest to `place`.
fn nearest(places: &[Place], place: Place) -> usize {
    let squared = |other: &Place| (other[0] - place[0]).powi(2) + (other[1] - place[1]).powi(2);
    let order = |(_, one): &(usize, f64), (_, other): &(usize, f64)| one.total_cmp(other);
    places.iter().map(squared).enumerate().min_by(order).map_or(0, |(index, _)| index)
}

fn distance(one: Place, other: Place) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::SeedableRng;

    /// Poses on the stroke.
    const COUNT: usize = 7;
    const RADIUS_M: f64 = 0.12;
    const STEP_RAD: f64 = 0.3;

    /// A plane in no particular place.
    fn world_from_board() -> SE3 {
        SE3::new(SO3::exp(&Vector3::new(0.7, -0.4, 1.1)), Vector3::new(0.3, -0.1, 0.2))
    }

    /// A tool upright on the board at a height over it, after an angle of an arc, closing along it.
    fn on_the_arc(angle: f64, height_m: f64) -> SE3 {
        let place = Vector3::new(RADIUS_M * angle.sin(), RADIUS_M * (1.0 - angle.cos()), height_m);
        // The closing direction is y.
        let turn = angle - std::f64::consts::FRAC_PI_2;
        world_from_board() * SE3::new(SO3::exp(&(Vector3::z() * turn)), place)
    }

    /// Down to an arc, along it, and up again.
    fn route() -> Vec<SE3> {
        let along = (0..COUNT).map(|index| on_the_arc(STEP_RAD * index as f64, 0.01));
        let up = on_the_arc(STEP_RAD * (COUNT - 1) as f64, 0.06);
        [on_the_arc(0.0, 0.07)].into_iter().chain(along).chain([up]).collect()
    }

    fn draws(anchor: usize) -> impl Iterator<Item = Redraw> {
        let draw = move |seed| {
            let route = route();
            Redraw::draw(&route, &route[anchor], false, &mut ChaCha8Rng::seed_from_u64(seed))
        };
        (0..60).filter_map(draw)
    }

    /// Place and closing direction, on the board.
    fn seen(pose: &SE3) -> (Vector3<f64>, Vector3<f64>) {
        let inside = world_from_board().inverse() * *pose;
        (inside.translation, inside.rotation.act(&Vector3::y()))
    }

    #[test]
    fn new_lines_are_as_long_and_the_tool_closes_along_them_upright_at_its_height() {
        let (mut count, mut farthest, mut straight) = (0, 0.0_f64, 0);
        for redraw in draws(0) {
            count += 1;
            let mut length = 0.0;
            let steps = 200;
            let angle = |index: usize| STEP_RAD * (COUNT - 1) as f64 * index as f64 / steps as f64;
            let poses: Vec<SE3> =
                (0..=steps).map(|index| redraw.pose(&on_the_arc(angle(index), 0.01))).collect();
            for pair in poses.windows(2) {
                let [(from, close), (to, next)] = [&pair[0], &pair[1]].map(seen);
                assert!((to.z - 0.01).abs() < 1e-9 && close.z.abs() < 1e-9, "it leans or left its height");
                length += (to - from).norm();
                let along = (to - from).normalize();
                // Places nearer than 1.5 mm go by the same motion, which the recorded arc is not quite.
                assert!((0.5 * (close + next) - along).norm() < 0.15, "{close} is off {along}");
            }
            let whole = RADIUS_M * STEP_RAD * (COUNT - 1) as f64;
            assert!((length / whole - 1.0).abs() < 0.02, "{length} for {whole}");
            let (first, last) = (seen(&poses[0]), seen(&poses[steps]));
            farthest = farthest.max((last.0 - seen(&on_the_arc(angle(steps), 0.01)).0).norm());
            straight += usize::from(((last.0 - first.0).norm() / length - 1.0).abs() < 1e-3);
        }
        assert!(count > 50 && farthest > 0.1, "{count} lines, by at most {farthest} m elsewhere");
        // Three standard deviations about the share of 60 are 8.
        assert!((1..=17).contains(&straight), "{straight} straight lines");
    }

    #[test]
    fn poses_on_the_path_get_the_new_lines_own_direction() {
        for redraw in draws(3) {
            let ends = [0, redraw.new.len() - 1];
            for (index, pose) in [(ends[0], on_the_arc(0.0, 0.01)), (ends[1], route()[COUNT])] {
                let (place, close) = seen(&redraw.pose(&pose));
                // The new line's neighbours say how it runs at its end: a parabola through three places.
                let to_board = |index: usize| {
                    let [x, y] = redraw.new[index];
                    let world = redraw.world_from_plane.act(&Vector3::new(x, y, 0.0));
                    world_from_board().inverse().act(&world)
                };
                let (one, two) = if index == 0 { (index + 1, index + 2) } else { (index - 1, index - 2) };
                let sign = if index == 0 { 1.0 } else { -1.0 };
                let along = (to_board(one) * 4.0 - to_board(two) - to_board(index) * 3.0) * sign;
                let along = Vector3::new(along.x, along.y, 0.0).normalize();
                assert!((close - along).norm() < 0.01, "{close} at an end that runs {along}");
                assert!((place.xy() - to_board(index).xy()).norm() < 1e-6);
            }
        }
    }

    #[test]
    fn the_anchor_stays_and_points_go_with_the_poses_beside_them() {
        for redraw in draws(3) {
            let anchor = route()[3];
            let apart = (anchor.inverse() * redraw.pose(&anchor)).log();
            assert!(apart.linear.norm() < 1e-4 && apart.angular.norm() < 0.01, "{apart:?}");
            for index in 0..COUNT {
                // Points at the line's edge, and as far as the mark of its beginning reaches, as a tool there has them.
                let tool = on_the_arc(STEP_RAD * index as f64, 0.0);
                for beside in [0.004, -0.012, 0.012] {
                    let edge = tool.act(&(Vector3::x() * beside));
                    let mut points = [edge.map(|value| value as f32).into()];
                    redraw.points(&mut points);
                    let with_tool = redraw.pose(&tool).act(&(Vector3::x() * beside));
                    let apart = (Vector3::from(points[0].map(f64::from)) - with_tool).norm();
                    assert!(apart < 1e-4, "{apart}");
                }
            }
        }
    }

    #[test]
    fn what_is_far_from_the_line_keeps_its_shape_and_goes_with_the_lines_middle() {
        let far: Vec<[f32; 3]> = (0..8_u8)
            .map(|index| on_the_arc(0.8 * f64::from(index), 0.0).act(&(Vector3::x() * 0.02)))
            .map(|point| point.map(|value| value as f32).into())
            .collect();
        for redraw in draws(0) {
            let mut moved = far.clone();
            redraw.points(&mut moved);
            let steps = 200;
            let along =
                |index: usize| on_the_arc(STEP_RAD * (COUNT - 1) as f64 * index as f64 / steps as f64, 0.0);
            let moved_by = |index| redraw.pose(&along(index)).translation - along(index).translation;
            let shift = (0..=steps).map(moved_by).sum::<Vector3<f64>>() / (steps + 1) as f64;
            for (new, old) in moved.iter().zip(&far) {
                let [new, old] = [new, old].map(|point| Vector3::from(point.map(f64::from)));
                // Its places are 1.5 mm apart, and fewer of them are counted here.
                assert!((new - old - shift).norm() < 2e-3, "{old} went to {new}");
            }
        }
    }

    #[test]
    fn a_line_stays_clear_of_itself_and_a_short_path_is_no_line() {
        for redraw in draws(0) {
            let places = &redraw.new;
            for (index, one) in places.iter().enumerate() {
                // 1.5 mm lie between two places; 48 of them are beyond the distance that counts as far.
                for other in places.iter().skip(index + 48) {
                    assert!(distance(*one, *other) > 0.028);
                }
            }
        }
        let still: Vec<SE3> = (0..5).map(|index| on_the_arc(0.0, 0.01 * f64::from(index))).collect();
        assert!(Redraw::draw(&still, &still[0], true, &mut ChaCha8Rng::seed_from_u64(1)).is_none());
    }
}
