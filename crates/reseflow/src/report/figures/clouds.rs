//! Training and test episodes as the camera saw them, from above and from the side, with the demonstrated paths.

use reseflow_data::{Dataset, Episode};
use reseflow_lie::Vector3;

use super::super::gather::Run;
use crate::plot::{
    Axis, Frame, GREY, INK, Ink, LEGEND_SIZE, Lettering, Marker, PALETTE, Picture, Scale, Stroke, TITLE_SIZE,
};
use crate::report::document::Block;
use crate::report::study::task_title;

/// Episodes whose clouds are drawn.
const CLOUDS: usize = 3;
/// Episodes whose paths are drawn.
const PATHS: usize = 20;
const PANEL: (f64, f64) = (290.0, 270.0);
const TOP: f64 = 84.0;
/// How long the stroke is that shows where the gripper points, metres.
const APPROACH_M: f64 = 0.02;

/// What a view shows to the right and upwards.
#[derive(Clone, Copy)]
struct View {
    title: &'static str,
    axes: [usize; 2],
}

const VIEWS: [View; 2] =
    [View { title: "from above", axes: [0, 1] }, View { title: "from the side", axes: [0, 2] }];

/// Four panels: both splits in both views, all to one scale.
pub(super) fn views(run: &Run) -> anyhow::Result<Block> {
    let mut splits = Vec::new();
    for (title, file) in [("training", "data/train.npz"), ("test", "data/test.npz")] {
        if let Some(path) = run.find(file) {
            splits.push((title, Dataset::read(path)?));
        }
    }
    splits.retain(|(_, dataset)| !dataset.is_empty());
    if splits.is_empty() {
        return Ok(Block::absent(format!("the data of {}: its folder holds no data set.", run.name)));
    }
    let title = format!("{}: training and test data ({})", task_title(&run.task), run.name);
    let columns = splits.len() * VIEWS.len();
    let mut picture = Picture::new(&title, 28.0 + columns as f64 * PANEL.0, TOP + PANEL.1 + 62.0);
    picture.text((14.0, 22.0), &title, Lettering::sized(TITLE_SIZE).from_left());
    for (index, (split, dataset)) in splits.iter().enumerate() {
        for (place, view) in VIEWS.iter().enumerate() {
            let left = 14.0 + (index * VIEWS.len() + place) as f64 * PANEL.0;
            panel(&mut picture, left, split, *view, dataset);
        }
    }
    Ok(Block::figure(
        format!("data-{}", run.name),
        format!(
            "The first frames of up to {CLOUDS} episodes, in the camera's colours (the first one full, the others pale), and the commanded \
             paths of the gripper in up to {PATHS} (the first one bold, short strokes where the gripper points). The data sets hold {}.",
            splits
                .iter()
                .map(|(split, dataset)| format!("{} {split} episodes", dataset.len()))
                .collect::<Vec<_>>()
                .join(" and ")
        ),
        picture,
    ))
}

fn panel(picture: &mut Picture, left: f64, split: &str, view: View, dataset: &Dataset) {
    let shown = &dataset.episodes[..dataset.len().min(PATHS)];
    let [across, up] = view.axes;
    let seen = |point: &Vector3<f64>| (point[across], point[up]);
    let frame = frame(left, view, shown, &seen);
    frame.draw(picture);
    let middle = (frame.corner.0 + 0.5 * frame.size.0, TOP - 22.0);
    picture.text(middle, format!("{split}, {}", view.title), Lettering::sized(LEGEND_SIZE).ink(INK));
    for (index, episode) in shown.iter().enumerate().take(CLOUDS).rev() {
        let Some(first) = episode.observations.first() else { continue };
        let opacity = if index == 0 { 1.0 } else { 0.3 };
        for (point, [red, green, blue]) in first.cloud.points.iter().zip(&first.cloud.colors) {
            let point = Vector3::from(point.map(f64::from));
            picture.disc(frame.place(seen(&point)), 1.8, Ink(*red, *green, *blue), opacity);
        }
    }
    for episode in shown.iter().skip(1) {
        picture.line(path(episode).iter().map(|point| frame.place(seen(point))), Stroke::solid(GREY, 0.6));
    }
    let Some(episode) = shown.first() else { return };
    let places: Vec<_> = path(episode).iter().map(|point| frame.place(seen(point))).collect();
    for action in &episode.actions {
        let pose = &action.world_from_gripper;
        let ends =
            [Vector3::zeros(), Vector3::z() * APPROACH_M].map(|point| frame.place(seen(&pose.act(&point))));
        picture.line(ends, Stroke::solid(PALETTE[0], 1.2));
    }
    picture.line(places.iter().copied(), Stroke::solid(PALETTE[2], 2.0));
    places.iter().take(1).for_each(|&place| picture.marker(place, Marker::Diamond, INK, 4.0));
    places.iter().skip(1).for_each(|&place| picture.marker(place, Marker::Disc, PALETTE[2], 2.5));
}

/// The gripper's start and its commanded places.
fn path(episode: &Episode) -> Vec<Vector3<f64>> {
    let start = episode.observations.first().map(|first| first.world_from_gripper.translation);
    start
        .into_iter()
        .chain(episode.actions.iter().map(|action| action.world_from_gripper.translation))
        .collect()
}

/// Axes in metres, as long to the right as upwards, about everything that is shown.
fn frame(left: f64, view: View, shown: &[Episode], seen: &dyn Fn(&Vector3<f64>) -> (f64, f64)) -> Frame {
    let clouds = shown.iter().take(CLOUDS).filter_map(|episode| episode.observations.first());
    let points =
        clouds.flat_map(|first| first.cloud.points.iter().map(|point| Vector3::from(point.map(f64::from))));
    let (mut low, mut high) = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));
    for (x, y) in points.chain(shown.iter().flat_map(path)).map(|point| seen(&point)) {
        low = (low.0.min(x), low.1.min(y));
        high = (high.0.max(x), high.1.max(y));
    }
    let size = (PANEL.0 - 86.0, PANEL.1 - 10.0);
    let metres_a_unit = (1.06 * (high.0 - low.0) / size.0).max(1.06 * (high.1 - low.1) / size.1).max(1e-6);
    let axis = |name: &str, low: f64, high: f64, length: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * metres_a_unit * length);
        Axis::new(&format!("{name} (m)"), Scale::Linear, middle - half, middle + half)
    };
    let name = |axis: usize| ["x", "y", "z"][axis];
    let [across, up] = view.axes;
    Frame {
        corner: (left + 66.0, TOP),
        size,
        x: axis(name(across), low.0, high.0, size.0),
        y: axis(name(up), low.1, high.1, size.1),
    }
}
