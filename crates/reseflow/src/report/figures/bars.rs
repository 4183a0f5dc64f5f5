//! Policies side by side on a logarithmic axis, task by task (the paper's bar chart).

use super::look;
use crate::evaluation::StepRow;
use crate::learners::Learner;
use crate::plot::{
    Axis, Frame, GREY, INK, LEGEND_SIZE, Lettering, Picture, Scale, Stroke, TICK_SIZE, TITLE_SIZE,
};
use crate::report::document::Block;
use crate::report::paper::of_task;
use crate::report::study::{Group, Study, fewest, learner_title, most, task_title};

const BAR: f64 = 68.0;
const GAP: f64 = 40.0;
const LEFT: f64 = 80.0;
const TOP: f64 = 72.0;
const HEIGHT: f64 = 300.0;

struct Bar<'a> {
    learner: Learner,
    row: &'a StepRow,
    paper: Option<f64>,
}

/// Bars with error bars; the paper's Table I as strokes across them.
pub(super) fn chart(study: &Study, group: Group) -> Block {
    let mut tasks: Vec<(String, Vec<Bar<'_>>)> = Vec::new();
    for run in study.unimodal(group) {
        let mut bars: Vec<Bar<'_>> = Vec::new();
        for learner in [Learner::Baseline, Learner::Flow(1), Learner::Flow(2)] {
            let Some(report) = study.scores(group, &run.task, learner) else { continue };
            let paper = of_task(&run.task).and_then(|task| task.in_table(learner));
            let least = fewest(report).map_or(0, |row| row.steps);
            let most = most(report).filter(|row| learner == Learner::Baseline && row.steps > least);
            bars.extend(fewest(report).into_iter().chain(most).map(|row| Bar { learner, row, paper }));
        }
        bars.retain(|bar| bar.row.scores.d_geo_mean > 0.0);
        if !bars.is_empty() {
            tasks.push((task_title(&run.task), bars));
        }
    }
    if tasks.is_empty() {
        return Block::absent(format!(
            "the bar chart with {}: no task with a single expert was scored on the test split.",
            group.title()
        ));
    }
    Block::figure(
        format!("bars-{}", group.slug()),
        "D̄_geo on held-out episodes, logarithmic axis; error bars: ± 1 standard deviation over noise seeds. The figure under each bar is \
         its number of steps. Grey strokes: the paper's Table I, which does not say its steps.",
        draw(&format!("D_geo of each policy, {}", group.title()), &tasks),
    )
}

fn draw(title: &str, tasks: &[(String, Vec<Bar<'_>>)]) -> Picture {
    let bars = || tasks.iter().flat_map(|(_, bars)| bars);
    let ends = |bar: &Bar<'_>| {
        let (mean, std) = (bar.row.scores.d_geo_mean, bar.row.scores.d_geo_std.unwrap_or(0.0));
        ((mean - std).max(0.5 * mean), mean + std)
    };
    let low = bars().map(|bar| ends(bar).0).fold(f64::INFINITY, f64::min) / 2.0;
    let high = bars().map(|bar| ends(bar).1.max(bar.paper.unwrap_or(0.0))).fold(0.0, f64::max) * 1.6;
    let width: f64 = tasks.iter().map(|(_, bars)| bars.len() as f64 * BAR + GAP).sum();
    let mut picture = Picture::new(title, (LEFT + width + 20.0).max(560.0), TOP + HEIGHT + 78.0);
    picture.text((14.0, 22.0), title, Lettering::sized(TITLE_SIZE).from_left());
    if bars().any(|bar| bar.paper.is_some()) {
        picture.line([(16.0, 46.0), (46.0, 46.0)], Stroke::solid(GREY, 2.5));
        let key = Lettering::sized(LEGEND_SIZE).from_left();
        picture.text((54.0, 46.0), "the paper's Table I", key);
    }
    let x = Axis::new("", Scale::Linear, 0.0, width).with_ticks(Vec::new());
    let y = Axis::new("mean D_geo (rad, m)", Scale::Log, low, high);
    let frame = Frame { corner: (LEFT, TOP), size: (width, HEIGHT), x, y };
    frame.draw(&mut picture);
    let mut left = 0.5 * GAP;
    for (task, bars) in tasks {
        for (index, bar) in bars.iter().enumerate() {
            one_bar(&mut picture, &frame, left + index as f64 * BAR, bar);
        }
        let middle = LEFT + left + 0.5 * bars.len() as f64 * BAR;
        picture.text((middle, TOP + HEIGHT + 62.0), task, Lettering::sized(LEGEND_SIZE));
        left += bars.len() as f64 * BAR + GAP;
    }
    picture
}

fn one_bar(picture: &mut Picture, frame: &Frame, left: f64, bar: &Bar<'_>) {
    let scores = &bar.row.scores;
    let (from, to, middle) = (left + 7.0, left + BAR - 7.0, left + 0.5 * BAR);
    let at = |x: f64, value: f64| frame.place((x, value));
    let foot = frame.y.low();
    let corners = [at(from, foot), at(from, scores.d_geo_mean), at(to, scores.d_geo_mean), at(to, foot)];
    // The bar with fewer steps is the lighter one of two.
    let opacity = if bar.learner == Learner::Baseline && bar.row.steps > 1 { 0.5 } else { 0.9 };
    picture.area(corners, look(bar.learner).ink, opacity);
    let mut top = scores.d_geo_mean;
    if let Some(std) = scores.d_geo_std.filter(|std| *std > 0.0) {
        let (low, high) = ((scores.d_geo_mean - std).max(foot), scores.d_geo_mean + std);
        let stroke = Stroke::solid(INK, 1.25);
        picture.line([at(middle, low), at(middle, high)], stroke);
        for end in [low, high] {
            picture.line([at(middle - 6.0, end), at(middle + 6.0, end)], stroke);
        }
        top = high;
    }
    let (x, mut y) = at(middle, top);
    // The paper's stroke does not cross the number.
    if let Some(stroke) = bar.paper.map(|paper| at(middle, paper).1)
        && (y - 22.0..y + 2.0).contains(&stroke)
    {
        y = stroke;
    }
    picture.text((x, y - 10.0), format!("{:.3}", scores.d_geo_mean), Lettering::sized(TICK_SIZE));
    if let Some(paper) = bar.paper {
        picture.line([at(left + 3.0, paper), at(left + BAR - 3.0, paper)], Stroke::solid(GREY, 2.5));
    }
    let bottom = frame.corner.1 + frame.size.1;
    picture.text((x, bottom + 14.0), learner_title(bar.learner), Lettering::sized(TICK_SIZE));
    picture.text((x, bottom + 30.0), format!("{}", bar.row.steps), Lettering::sized(TICK_SIZE).ink(GREY));
}
