//! Straightness before and after reflow: one line a run, from Flow 1 to the last flow.

use super::look;
use crate::learners::Learner;
use crate::plot::{
    Axis, Frame, GREY, INK, LEGEND_SIZE, Legend, Lettering, Picture, Scale, Stroke, TITLE_SIZE,
};
use crate::report::document::Block;
use crate::report::study::{Study, learner_title};

const LINE: f64 = 34.0;
const WIDTH: f64 = 820.0;

/// Markers on a logarithmic axis, joined for each run.
pub(super) fn chart(study: &Study) -> Block {
    let mut lines = Vec::new();
    for run in &study.runs {
        let flows = (1..=9).map(Learner::Flow);
        let known: Vec<(Learner, f64)> = flows
            .filter_map(|flow| Some((flow, run.on_test(flow)?.straightness?.relative)))
            .filter(|(_, relative)| *relative > 0.0)
            .collect();
        if !known.is_empty() {
            lines.push((run.name.clone(), known));
        }
    }
    let values = || lines.iter().flat_map(|(_, known)| known.iter().map(|(_, relative)| *relative));
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    if lines.is_empty() {
        return Block::absent("straightness before and after reflow: it was measured for no flow.");
    }
    let title = "Straightness of the flows (relative; further left is straighter)";
    let mut flows: Vec<Learner> = Vec::new();
    for (flow, _) in lines.iter().flat_map(|(_, known)| known) {
        if !flows.contains(flow) {
            flows.push(*flow);
        }
    }
    let legend = Legend::of(flows.iter().map(|flow| (learner_title(*flow), look(*flow))), WIDTH);
    let top = 44.0 + legend.height();
    let height = top + LINE * lines.len() as f64 + 60.0;
    let mut picture = Picture::new(title, WIDTH, height);
    picture.text((14.0, 22.0), title, Lettering::sized(TITLE_SIZE).from_left());
    legend.draw(&mut picture, 38.0);
    let x = Axis::new(
        "mean squared distance of drift and displacement, of the displacement's",
        Scale::Log,
        low / 1.6,
        high * 1.6,
    );
    let y = Axis::new("", Scale::Linear, 0.0, lines.len() as f64).with_ticks(Vec::new());
    let frame = Frame { corner: (230.0, top), size: (WIDTH - 260.0, LINE * lines.len() as f64), x, y };
    frame.draw(&mut picture);
    for (index, (name, known)) in lines.iter().enumerate() {
        let level = (lines.len() - index) as f64 - 0.5;
        let at = |relative: f64| frame.place((relative, level));
        let label = Lettering::sized(LEGEND_SIZE).ink(INK).up_to();
        picture.text((220.0, at(low).1), name, label);
        picture.line(known.iter().map(|(_, relative)| at(*relative)), Stroke::solid(GREY, 1.5));
        for (flow, relative) in known {
            let look = look(*flow);
            if let Some(marker) = look.marker {
                picture.marker(at(*relative), marker, look.ink, 6.5);
            }
        }
    }
    Block::figure(
        "straightness",
        "How far the drift along each flow is from the straight displacement, squared and as a share of the displacement squared: where \
         reflow works, Flow 2 lies far to the left of Flow 1.",
        picture,
    )
}
