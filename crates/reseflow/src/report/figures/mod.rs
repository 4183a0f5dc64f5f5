//! The report's figures: what the paper shows, for these runs.

mod bars;
mod calibration;
mod clouds;
mod curves;
mod demonstrations;
mod flow_diagram;
mod frontier;
mod heat_map;
pub(super) mod overview;
mod panels;
mod radar;
mod straight;

use super::document::Block;
use super::study::Study;
use crate::learners::Learner;
use crate::output::Terminal;
use crate::plot::{Dash, Look, Marker, PALETTE};

/// The radar chart and the bar chart of each number of demonstrations.
pub(super) fn over_tasks(study: &Study) -> anyhow::Result<Vec<Block>> {
    let mut blocks = Vec::new();
    for group in study.groups() {
        blocks.push(radar::chart(study, group));
        blocks.push(bars::chart(study, group));
    }
    Ok(blocks)
}

/// D̄_geo over integration steps.
pub(super) fn over_steps(study: &Study) -> anyhow::Result<Vec<Block>> {
    study.groups().into_iter().map(|group| curves::over_steps(study, group)).collect()
}

/// D̄_geo over the number of demonstrations.
pub(super) fn over_demonstrations(study: &Study) -> anyhow::Result<Block> {
    demonstrations::chart(study)
}

/// D_geo of each action: curves for each task, and the heat map over all.
pub(super) fn along_the_trajectory(study: &Study) -> anyhow::Result<Vec<Block>> {
    let mut blocks = Vec::new();
    for group in study.groups() {
        blocks.extend(curves::along_the_trajectory(study, group)?);
        blocks.push(heat_map::chart(study, group));
    }
    Ok(blocks)
}

/// The flow diagram, and straightness before and after reflow.
pub(super) fn flows(study: &Study, terminal: &Terminal) -> anyhow::Result<Vec<Block>> {
    let mut blocks = Vec::new();
    for run in &study.runs {
        blocks.push(flow_diagram::diagram(run, terminal)?);
    }
    blocks.push(straight::chart(study));
    Ok(blocks)
}

/// Nodes beside the consensus, and whether their spread tells the error.
pub(super) fn nodes(study: &Study) -> anyhow::Result<Vec<Block>> {
    let mut blocks = Vec::new();
    for group in study.groups() {
        blocks.push(curves::over_nodes(study, group)?);
        blocks.push(calibration::chart(study, group)?);
    }
    Ok(blocks)
}

/// Error against the time of a call.
pub(super) fn over_time(study: &Study) -> anyhow::Result<Vec<Block>> {
    study.groups().into_iter().map(|group| frontier::chart(study, group)).collect()
}

/// Training and test episodes, and how training went.
pub(super) fn data(study: &Study) -> anyhow::Result<Vec<Block>> {
    let mut blocks = Vec::new();
    for run in &study.runs {
        blocks.push(clouds::views(run)?);
    }
    blocks.push(curves::training(study)?);
    Ok(blocks)
}

/// What a policy looks like in every figure.
fn look(learner: Learner) -> Look {
    match learner {
        Learner::Flow(flow @ 1..=2) => Look::policy(flow - 1),
        Learner::Flow(flow) => Look::policy(flow),
        Learner::Baseline => Look::policy(2),
        Learner::Regressor => Look { ink: PALETTE[4], dash: Dash::Dotted, marker: Some(Marker::Diamond) },
    }
}
