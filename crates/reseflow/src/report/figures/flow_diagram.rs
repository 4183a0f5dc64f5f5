//! Where Flow 1 and Flow 2 carry the same noise in one scene, in one step and in many (after the paper's second figure).

use reseflow_data::{ActionChunk, Dataset, ObservationHistory};
use reseflow_lie::Vector3;
use reseflow_train::DeviceKind;

use super::super::gather::Run;
use crate::learners::Learner;
use crate::learning::load_flow;
use crate::output::Terminal;
use crate::plot::{
    Axis, Frame, GREY, INK, LEGEND_SIZE, Lettering, Marker, PALETTE, Picture, Scale, Stroke, TITLE_SIZE,
};
use crate::report::document::Block;
use crate::report::study::{learner_title, task_title};
use crate::rollouts::FIRST_SEED;

/// Noises drawn.
const NOISES: usize = 40;
/// What counts as many steps.
const MANY: usize = 100;
const PANEL: (f64, f64) = (345.0, 290.0);
const TOP: f64 = 112.0;

/// The same noises carried in one step and in many.
struct Carried {
    flow: Learner,
    /// Where one step leads, a trajectory for each noise.
    once: Vec<ActionChunk>,
    /// The ways of many steps, from the noise on.
    ways: Vec<Vec<ActionChunk>>,
}

/// One panel a flow: noise, where many steps lead, and where one step leads instead.
pub(super) fn diagram(run: &Run, terminal: &Terminal) -> anyhow::Result<Block> {
    let absent = |reason: &str| Ok(Block::absent(format!("the flow diagram of {}: {reason}.", run.name)));
    let Some(path) = run.find("data/test.npz") else { return absent("its folder holds no test episodes") };
    let dataset = Dataset::read(path)?;
    let Some(episode) = dataset.episodes.first() else {
        return absent("its test split holds no episode");
    };
    let seeds: Vec<u64> = (FIRST_SEED..).take(NOISES).collect();
    let mut flows = Vec::new();
    for flow in (1..=9).map(Learner::Flow) {
        let Some(folder) = run.checkpoint(flow) else { continue };
        let policy = load_flow(&folder, DeviceKind::Cpu)?;
        if policy.model().regression {
            continue;
        }
        terminal.note(format!("{}: drawing {}", run.name, learner_title(flow)));
        let history = ObservationHistory::at_step(&episode.observations, 0, policy.observation_horizon());
        let ways = policy.trace(&history, &seeds, MANY)?;
        let once = policy.trace(&history, &seeds, 1)?;
        let once = once.into_iter().filter_map(|mut way| way.pop()).collect();
        flows.push(Carried { flow, once, ways });
    }
    if flows.is_empty() {
        return absent("there is no checkpoint of a flow");
    }
    let title = format!("{}: the flows in one test scene ({})", task_title(&run.task), run.name);
    Ok(Block::figure(
        format!("flow-diagram-{}", run.name),
        format!(
            "The gripper's pose at the last action, seen from above; strokes show the direction in which the fingers close. {NOISES} \
             noises (grey), the ways on which {MANY} steps of Euler carry them, and their ends (discs). Crosses: where a single step leads \
             instead, joined to their disc. In a straight flow every cross has the place and the direction of its disc."
        ),
        draw(&title, &flows),
    ))
}

fn draw(title: &str, flows: &[Carried]) -> Picture {
    let mut picture = Picture::new(title, 28.0 + 2.0 * flows.len() as f64 * PANEL.0, TOP + PANEL.1 + 62.0);
    picture.text((14.0, 22.0), title, Lettering::sized(TITLE_SIZE).from_left());
    let key = Lettering::sized(LEGEND_SIZE).from_left();
    picture.disc((22.0, 52.0), 3.0, GREY, 0.8);
    picture.text((32.0, 52.0), "noise", key);
    picture.marker((102.0, 52.0), Marker::Disc, PALETTE[1], 4.5);
    picture.text((112.0, 52.0), format!("{MANY} steps"), key);
    picture.marker((212.0, 52.0), Marker::Cross, PALETTE[2], 4.5);
    picture.text((222.0, 52.0), "1 step", key);
    let places = |chunks: &mut dyn Iterator<Item = &ActionChunk>| -> Vec<Vector3<f64>> {
        chunks.map(|chunk| last(chunk).0).collect()
    };
    let ends = |carried: &Carried| {
        let often = carried.ways.iter().filter_map(|way| way.last());
        places(&mut carried.once.iter().chain(often))
    };
    let ends: Vec<Vector3<f64>> = flows.iter().flat_map(ends).collect();
    let on_the_way = places(&mut flows.iter().flat_map(|carried| carried.ways.iter().flatten()));
    let whole: Vec<Vector3<f64>> = on_the_way.into_iter().chain(ends.iter().copied()).collect();
    for (index, carried) in flows.iter().enumerate() {
        let left = 14.0 + index as f64 * 2.0 * PANEL.0;
        for (place, (points, title)) in
            [(&whole, "from noise to the end"), (&ends, "the ends, enlarged")].into_iter().enumerate()
        {
            let frame = frame(left + place as f64 * PANEL.0, points);
            frame.draw(&mut picture);
            let middle = (frame.corner.0 + 0.5 * frame.size.0, TOP - 18.0);
            let title = format!("{}, {title}", learner_title(carried.flow));
            picture.text(middle, title, Lettering::sized(LEGEND_SIZE).ink(INK));
            if place == 0 {
                ways(&mut picture, &frame, carried);
            }
            arrivals(&mut picture, &frame, carried, if place == 0 { 5.0 } else { 22.0 });
        }
    }
    picture
}

/// Axes in metres about the points, as long to the right as upwards.
fn frame(left: f64, points: &[Vector3<f64>]) -> Frame {
    let size = (PANEL.0 - 86.0, PANEL.1);
    let extent = |axis: usize| {
        let values = || points.iter().map(|point| point[axis]);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let (across, up) = (extent(0), extent(1));
    // Ends that all fall together are still shown a few millimetres apart.
    let metres_a_unit = (1.3 * (across.1 - across.0) / size.0).max(1.3 * (up.1 - up.0) / size.1).max(4e-5);
    let axis = |name: &str, (low, high): (f64, f64), length: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * metres_a_unit * length);
        Axis::new(name, Scale::Linear, middle - half, middle + half)
    };
    let (x, y) = (axis("x (m)", across, size.0), axis("y (m)", up, size.1));
    Frame { corner: (left + 66.0, TOP), size, x, y }
}

/// A stroke along the direction in which the fingers close, as far as it lies in the plane, with the marker's place in its middle.
fn stroke(frame: &Frame, (place, closing): &(Vector3<f64>, Vector3<f64>), length: f64) -> [(f64, f64); 2] {
    let (x, y) = frame.place((place.x, place.y));
    [-1.0, 1.0].map(|side| (x + side * length * closing.x, y - side * length * closing.y))
}

/// Noise, and the ways of many steps from there.
fn ways(picture: &mut Picture, frame: &Frame, carried: &Carried) {
    let at = |place: &Vector3<f64>| frame.place((place.x, place.y));
    for way in &carried.ways {
        picture.line(way.iter().map(|chunk| at(&last(chunk).0)), Stroke::solid(PALETTE[1], 0.8));
        let Some(noise) = way.first().map(last) else { continue };
        picture.line(stroke(frame, &noise, 9.0), Stroke::solid(GREY, 1.2));
        picture.disc(at(&noise.0), 2.2, GREY, 0.8);
    }
}

/// Where many steps and where one step lead.
fn arrivals(picture: &mut Picture, frame: &Frame, carried: &Carried, length: f64) {
    let at = |place: &Vector3<f64>| frame.place((place.x, place.y));
    for (once, way) in carried.once.iter().zip(&carried.ways) {
        let (cross, Some(disc)) = (last(once), way.last().map(last)) else { continue };
        picture.line([at(&cross.0), at(&disc.0)], Stroke::solid(GREY, 0.8));
        picture.line(stroke(frame, &disc, length), Stroke::solid(PALETTE[1], 1.2));
        picture.marker(at(&disc.0), Marker::Disc, PALETTE[1], 3.5);
    }
    for cross in carried.once.iter().map(last) {
        picture.line(stroke(frame, &cross, length), Stroke::solid(PALETTE[2], 1.2));
        picture.marker(at(&cross.0), Marker::Cross, PALETTE[2], 3.5);
    }
}

/// Place and closing direction of the last action.
fn last(chunk: &ActionChunk) -> (Vector3<f64>, Vector3<f64>) {
    let pose = chunk.0.last().map(|action| action.world_from_gripper);
    pose.map_or_else(Default::default, |pose| (pose.translation, pose.rotation.act(&Vector3::y())))
}
