//! D_geo of each action in one step, policies and tasks as rows (the paper's per-action heat map).

use crate::learners::Learner;
use crate::plot::{INK, Ink, LEGEND_SIZE, Lettering, Picture, TICK_SIZE, TITLE_SIZE};
use crate::report::document::Block;
use crate::report::study::{Group, Study, fewest, learner_title, most, steps_title, task_title};

const LEFT: f64 = 320.0;
const TOP: f64 = 74.0;
const CELL: (f64, f64) = (62.0, 28.0);
/// Shades from few to many; dark is worse.
const SHADES: [(f64, f64, f64); 4] =
    [(247.0, 251.0, 255.0), (158.0, 202.0, 225.0), (49.0, 130.0, 189.0), (8.0, 48.0, 107.0)];
/// Text on light and on dark cells, the same on every page.
const ON_LIGHT: Ink = Ink(1, 1, 1);
const ON_DARK: Ink = Ink(254, 254, 254);

/// The table of cells, shaded by the logarithm of what they hold.
pub(super) fn chart(study: &Study, group: Group) -> Block {
    let rows = rows(study, group);
    let positive = || rows.iter().flat_map(|(_, values)| values.iter().copied()).filter(|value| *value > 0.0);
    let (low, high) = (positive().fold(f64::INFINITY, f64::min), positive().fold(0.0, f64::max));
    let columns = rows.iter().map(|(_, values)| values.len()).max().unwrap_or(0);
    if columns == 0 || high <= 0.0 {
        return Block::absent(format!(
            "the heat map with {}: no task with a single expert was scored on the test split.",
            group.title()
        ));
    }
    let title = format!("D_geo of each action, {}", group.title());
    let width = LEFT + columns as f64 * CELL.0 + 20.0;
    let mut picture = Picture::new(&title, width, TOP + rows.len() as f64 * CELL.1 + 20.0);
    picture.text((14.0, 22.0), &title, Lettering::sized(TITLE_SIZE).from_left());
    for column in 0..columns {
        let x = LEFT + (column as f64 + 0.5) * CELL.0;
        picture.text((x, TOP - 12.0), format!("{}", column + 1), Lettering::sized(LEGEND_SIZE));
    }
    picture.text((LEFT - 10.0, TOP - 12.0), "action", Lettering::sized(LEGEND_SIZE).up_to());
    for (index, (name, values)) in rows.iter().enumerate() {
        let top = TOP + index as f64 * CELL.1;
        let middle = top + 0.5 * CELL.1;
        picture.text((LEFT - 10.0, middle), name, Lettering::sized(LEGEND_SIZE).ink(INK).up_to());
        for (column, value) in values.iter().enumerate() {
            let left = LEFT + column as f64 * CELL.0;
            let share = if high > low { (value.max(low) / low).ln() / (high / low).ln() } else { 0.5 };
            picture.rectangle((left + 0.75, top + 0.75), (CELL.0 - 1.5, CELL.1 - 1.5), shade(share));
            let ink = if share > 0.5 { ON_DARK } else { ON_LIGHT };
            picture.text((left + 0.5 * CELL.0, middle), number(*value), Lettering::sized(TICK_SIZE).ink(ink));
        }
    }
    Block::figure(
        format!("heat-map-{}", group.slug()),
        "Mean D_geo of each action with the fewest steps, of ET-SEED with its most as well; dark is worse, the shade goes with the \
         logarithm.",
        picture,
    )
}

/// A policy's name and the error of each action: with the fewest steps, and the baseline with its most as well.
fn rows(study: &Study, group: Group) -> Vec<(String, &[f64])> {
    let mut rows: Vec<(String, &[f64])> = Vec::new();
    for run in study.unimodal(group) {
        for learner in study.learners(group, &run.task) {
            let Some(report) = study.scores(group, &run.task, learner) else { continue };
            let few = fewest(report);
            let many = most(report)
                .filter(|many| learner == Learner::Baseline && few.is_some_and(|few| few.steps < many.steps));
            for row in few.into_iter().chain(many) {
                let policy = format!("{}, {}", learner_title(learner), steps_title(row.steps));
                rows.push((format!("{}: {policy}", task_title(&run.task)), &row.scores.per_action_mean));
            }
        }
    }
    rows
}

/// Three digits that count.
fn number(value: f64) -> String {
    if value < 0.1 { format!("{value:.4}") } else { format!("{value:.3}") }
}

fn shade(share: f64) -> Ink {
    let place = share.clamp(0.0, 1.0) * (SHADES.len() - 1) as f64;
    let index = (place.floor() as usize).min(SHADES.len() - 2);
    let (from, to, part) = (SHADES[index], SHADES[index + 1], place - index as f64);
    let mix = |a: f64, b: f64| (a + part * (b - a)).round() as u8;
    Ink(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::{run, scored};

    #[test]
    fn the_baseline_has_a_row_for_its_most_levels() {
        let run = run("d", "door", 200, 1);
        let run = scored(run, Learner::Flow(1), &[(1, &[0.2]), (100, &[0.1])]);
        let run = scored(run, Learner::Baseline, &[(100, &[0.5]), (1, &[0.75]), (10, &[0.7])]);
        let study = Study::new(vec![run]);
        let rows = rows(&study, Group::Count(200));
        let found: Vec<(&str, f64)> = rows.iter().map(|(name, values)| (name.as_str(), values[9])).collect();
        let expected = [
            ("Door opening: Flow 1, 1 step", 0.2),
            ("Door opening: ET-SEED, 1 step", 0.75),
            ("Door opening: ET-SEED, 100 steps", 0.5),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn more_is_darker() {
        let lightness = |share: f64| {
            let ink = shade(share);
            0.2126 * f64::from(ink.0) + 0.7152 * f64::from(ink.1) + 0.0722 * f64::from(ink.2)
        };
        let levels: Vec<f64> = (0..=20).map(|step| lightness(f64::from(step) / 20.0)).collect();
        assert!(levels.windows(2).all(|pair| pair[1] < pair[0]), "{levels:?}");
        assert_eq!([number(0.03456), number(1.2344)], ["0.0346", "1.234"]);
    }
}
