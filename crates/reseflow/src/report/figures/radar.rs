//! One axis a task, further out is worse (the paper's radar chart).

use std::f64::consts::TAU;

use super::look;
use crate::learners::Learner;
use crate::plot::{
    Axis, Dash, GREY, GRID, LEGEND_SIZE, Legend, Lettering, Look, Picture, Scale, Stroke, TICK_SIZE,
    TITLE_SIZE,
};
use crate::report::document::Block;
use crate::report::paper::of_task;
use crate::report::study::{Group, Study, fewest, learner_title, steps_title, task_title};

const WIDTH: f64 = 720.0;
const CENTRE: (f64, f64) = (360.0, 330.0);
const RADIUS: f64 = 200.0;

/// Closed lines over at least three tasks, on a logarithmic axis.
pub(super) fn chart(study: &Study, group: Group) -> Block {
    let tasks: Vec<&str> = study.unimodal(group).iter().map(|run| run.task.as_str()).collect();
    let mut lines: Vec<(String, Look, Vec<f64>)> = Vec::new();
    for learner in [Learner::Baseline, Learner::Flow(1), Learner::Flow(2)] {
        let rows = tasks.iter().map(|task| fewest(study.scores(group, task, learner)?));
        let Some(rows) = rows.collect::<Option<Vec<_>>>() else { continue };
        let steps = rows.iter().map(|row| row.steps).max().unwrap_or(1);
        let name = format!("{}, {}", learner_title(learner), steps_title(steps));
        lines.push((name, look(learner), rows.iter().map(|row| row.scores.d_geo_mean).collect()));
    }
    if tasks.len() < 3 || lines.is_empty() {
        let title = group.title();
        return Block::absent(format!(
            "the radar chart with {title}: it needs three tasks with the same policies."
        ));
    }
    let paper = tasks.iter().map(|task| of_task(task)?.in_table(Learner::Flow(2)));
    if let Some(values) = paper.collect::<Option<Vec<f64>>>() {
        let look = Look { ink: GREY, dash: Dash::Dotted, marker: None };
        lines.push(("Flow 2, the paper's Table I".to_owned(), look, values));
    }
    let title = format!("D_geo over tasks, {}", group.title());
    Block::figure(
        format!("radar-{}", group.slug()),
        "D̄_geo with the fewest steps, one axis a task, logarithmic: further out is worse.",
        draw(&title, &tasks, &lines),
    )
}

fn draw(title: &str, tasks: &[&str], lines: &[(String, Look, Vec<f64>)]) -> Picture {
    let legend = Legend::of(lines.iter().map(|(name, look, _)| (name.clone(), *look)), WIDTH);
    let down = legend.height();
    let centre = (CENTRE.0, CENTRE.1 + down - 24.0);
    let angle = |index: usize| TAU * index as f64 / tasks.len() as f64 - 0.25 * TAU;
    let lowest = (0..tasks.len()).map(|index| angle(index).sin()).fold(0.0, f64::max);
    let mut picture = Picture::new(title, WIDTH, centre.1 + RADIUS * lowest + 50.0);
    picture.text((14.0, 22.0), title, Lettering::sized(TITLE_SIZE).from_left());
    legend.draw(&mut picture, 38.0);
    let values = || lines.iter().flat_map(|(.., values)| values.iter().copied()).filter(|value| *value > 0.0);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let axis = Axis::new("", Scale::Log, low / 1.8, high * 1.1);
    let at = |index: usize, share: f64| {
        let (sin, cos) = angle(index).sin_cos();
        (centre.0 + RADIUS * share * cos, centre.1 + RADIUS * share * sin)
    };
    let around = |share: &dyn Fn(usize) -> f64| {
        (0..=tasks.len()).map(|i| at(i % tasks.len(), share(i % tasks.len()))).collect::<Vec<_>>()
    };
    picture.line(around(&|_| 1.0), Stroke::solid(GREY, 1.0));
    for (value, _) in axis.ticks() {
        let share = axis.share(*value);
        picture.line(around(&|_| share), Stroke::solid(GRID, 1.0));
    }
    for (index, task) in tasks.iter().enumerate() {
        picture.line([centre, at(index, 1.0)], Stroke::solid(GREY, 1.0));
        let (x, y) = at(index, 1.09);
        let lettering = Lettering::sized(LEGEND_SIZE);
        match angle(index).cos() {
            ..-0.2 => picture.text((x + 10.0, y + 8.0), task_title(task), lettering.up_to()),
            0.2.. => picture.text((x - 10.0, y + 8.0), task_title(task), lettering.from_left()),
            _ => picture.text((x, y), task_title(task), lettering),
        }
    }
    for (_, look, values) in lines {
        let places = around(&|index| axis.share(values[index]).clamp(0.0, 1.0));
        picture.line(places.iter().copied(), look.stroke(2.25));
        if let Some(marker) = look.marker {
            places.iter().skip(1).for_each(|&place| picture.marker(place, marker, look.ink, 5.0));
        }
    }
    for (value, text) in axis.ticks() {
        let (x, y) = at(0, axis.share(*value));
        picture.text((x - 5.0, y), text, Lettering::sized(TICK_SIZE).ink(GREY).up_to());
    }
    picture
}
