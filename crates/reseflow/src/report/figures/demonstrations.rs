//! Data efficiency: D̄_geo in one step against the number of demonstrations, a panel a flow, a line a task.

use super::panels::plot;
use crate::learners::Learner;
use crate::plot::{Dash, LinePlot, Look, Marker, PALETTE, Panels, Scale, Series};
use crate::report::document::Block;
use crate::report::gather::Run;
use crate::report::study::{Study, fewest, learner_title, task_title};

/// The figure, where a task was learned from at least two numbers of demonstrations.
pub(super) fn chart(study: &Study) -> anyhow::Result<Block> {
    let panels = panels(&study.by_demonstrations());
    if !panels.iter().flat_map(|panel| &panel.series).any(|line| line.points.len() > 1) {
        return Ok(Block::absent(
            "the figure of data efficiency: no task was learned from two numbers of demonstrations.",
        ));
    }
    let columns = panels.len();
    let panel_size = if columns == 1 { (640.0, 380.0) } else { (460.0, 350.0) };
    let title = "D_geo in one step against the number of demonstrations".to_owned();
    let panels = Panels { title, columns, panel_size, shared_y: true, panels };
    Ok(Block::figure(
        "demonstrations",
        "D̄_geo on held-out episodes in one step (the fewest that were scored) against the number of demonstrations that the main method \
         learned from, both axes logarithmic; bands: 95 % bootstrap intervals over episodes. Every point is a training of its own.",
        panels.picture()?,
    ))
}

/// One panel a flow that was scored.
fn panels(runs: &[&Run]) -> Vec<LinePlot> {
    let mut tasks: Vec<&str> = Vec::new();
    for run in runs {
        if !tasks.contains(&run.task.as_str()) {
            tasks.push(&run.task);
        }
    }
    let panel = |flow: Learner| {
        let lines = tasks.iter().enumerate().map(|(index, task)| {
            line(task_title(task), look(index), runs.iter().filter(|run| run.task == *task), flow)
        });
        let lines = lines.filter(|line| !line.points.is_empty()).collect();
        LinePlot {
            x_ticks: None,
            series: lines,
            ..plot(learner_title(flow), "demonstrations", Scale::Log, Vec::new())
        }
    };
    let panels = [1, 2].map(|flow| panel(Learner::Flow(flow))).into_iter();
    panels.filter(|panel| !panel.series.is_empty()).collect()
}

fn line<'a>(label: String, look: Look, runs: impl Iterator<Item = &'a &'a Run>, flow: Learner) -> Series {
    let scored = runs.filter_map(|run| {
        let scores = &fewest(run.on_test(flow)?)?.scores;
        let mean = scores.d_geo_mean;
        let band = (scores.d_geo_low.unwrap_or(mean), scores.d_geo_high.unwrap_or(mean));
        (mean > 0.0).then_some(((run.demonstrations? as f64, mean), band))
    });
    let (points, band) = scored.unzip();
    Series { label, points, band: Some(band), names: None, look }
}

/// What a task looks like: other colours than the policies of other figures have.
fn look(index: usize) -> Look {
    const LOOKS: [(usize, Dash, Marker); 3] = [
        (3, Dash::Solid, Marker::Diamond),
        (4, Dash::Dashed, Marker::Square),
        (5, Dash::Dotted, Marker::Triangle),
    ];
    let (ink, dash, marker) = LOOKS[index % LOOKS.len()];
    Look { ink: PALETTE[ink], dash, marker: Some(marker) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::{run, scored};

    const FLOW: Learner = Learner::Flow(1);

    #[test]
    fn each_task_is_a_line_through_its_numbers_of_demonstrations() {
        let door = |name, count, seed, error: f64| {
            scored(run(name, "door", count, seed), FLOW, &[(1, &[error, 3.0 * error]), (10, &[9.0])])
        };
        let twist = Run { variant: Some("twist".to_owned()), ..door("d-200-twist", 200, 1, 7.0) };
        let both = scored(door("d-200", 200, 1, 0.125), Learner::Flow(2), &[(1, &[0.15])]);
        let runs = vec![
            twist,
            door("d-200-seed2", 200, 2, 8.0),
            both,
            door("d-10", 10, 1, 0.25),
            scored(run("t", "triangle", 500, 1), FLOW, &[(1, &[0.3, 0.3])]),
        ];
        let study = Study::new(runs);
        let panels = panels(&study.by_demonstrations());
        let titles: Vec<&str> = panels.iter().map(|panel| panel.title.as_str()).collect();
        assert_eq!(titles, ["Flow 1", "Flow 2"]);
        let lines: Vec<(&str, &[(f64, f64)])> =
            panels[0].series.iter().map(|line| (line.label.as_str(), line.points.as_slice())).collect();
        let expected: [(&str, &[(f64, f64)]); 2] =
            [("Door opening", &[(10.0, 0.5), (200.0, 0.25)]), ("Rotating triangle", &[(500.0, 0.3)])];
        assert_eq!(lines, expected);
        let band = panels[0].series[0].band.as_ref().unwrap();
        assert_eq!(band[0], (0.25, 0.75), "of two episodes, resampled, some draws hold one of them twice");
        assert_eq!(panels[1].series[0].points, [(200.0, 0.15)]);
        assert!(matches!(chart(&study).unwrap(), Block::Figure(_)));
    }

    #[test]
    fn one_number_of_demonstrations_is_no_curve() {
        let alone = scored(run("d", "door", 10, 1), FLOW, &[(1, &[0.1])]);
        assert!(matches!(chart(&Study::new(vec![alone])).unwrap(), Block::Absent(_)));
    }
}
