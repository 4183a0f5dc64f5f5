//! Experiments that were trained with several seeds.

use super::super::document::{Block, Table, percent};
use super::super::pooling::{OverSeeds, Pool, PooledRow};
use super::super::study::{Study, learner_title};
use crate::evaluation::ModeScores;

/// A table for each of them: mean and standard deviation over trainings.
pub(in super::super) fn over_training_seeds(study: &Study) -> Vec<Block> {
    let (pools, faults) = study.pools();
    let mut blocks: Vec<Block> = faults.into_iter().map(Block::absent).collect();
    for pool in pools {
        let mut table = Table::new(
            format!(
                "{} with the training seeds {}: mean ± standard deviation over trainings (each the mean over noise seeds and held-out \
                 episodes, which are the same for all), and D̄_geo of each.",
                pool.name,
                pool.seeds()
            ),
            ["", "split", "steps", "trainings", "D̄_geo", "rad", "mm", "D̄_geo of each"],
        );
        for row in pool.rows() {
            let parts = (
                row.over(|row| row.scores.d_geo_mean),
                row.over(|row| row.scores.rotation_rad),
                row.over(|row| 1e3 * row.scores.translation_m),
            );
            let (Some(d_geo), Some(rad), Some(mm)) = parts else { continue };
            let each: Vec<String> = d_geo.values.iter().map(|value| format!("{value:.4}")).collect();
            table.row([
                learner_title(row.learner),
                row.split.to_owned(),
                row.rows[0].steps.to_string(),
                row.rows.len().to_string(),
                d_geo.text(),
                rad.text(),
                millimetres(&mm),
                each.join(", "),
            ]);
        }
        blocks.push(Block::Part(format!("{} over training seeds", pool.name)));
        blocks
            .push(table.or_absent(&format!("{} over training seeds: no two runs share a score.", pool.name)));
        blocks.extend(modes(&pool));
    }
    blocks
}

/// Where the samples of scenes with two experts lie; `None` where scenes have one.
fn modes(pool: &Pool<'_>) -> Option<Block> {
    let mut table = Table::new(
        format!(
            "Two experts, {} with the training seeds {}: mean ± standard deviation over trainings of the columns of the table of modes.",
            pool.name,
            pool.seeds()
        ),
        [
            "",
            "steps",
            "trainings",
            "share between",
            "share a mode",
            "rarer within a scene",
            "D̄_geo to the nearer",
            "share between of each",
        ],
    );
    for row in pool.rows().iter().filter(|row| row.split == "test") {
        let (Some(between), Some(first), Some(second), Some(rarer), Some(nearer)) = (
            over(row, |modes| modes.share_between),
            over(row, |modes| modes.share_per_mode[0]),
            over(row, |modes| modes.share_per_mode[1]),
            over(row, |modes| modes.rarer_share_within_scene),
            over(row, |modes| modes.d_geo_nearer),
        ) else {
            continue;
        };
        let each: Vec<String> = between.values.iter().map(|share| percent(*share)).collect();
        table.row([
            learner_title(row.learner),
            row.rows[0].steps.to_string(),
            between.values.len().to_string(),
            between.shares(),
            format!("{}; {}", first.shares(), second.shares()),
            rarer.shares(),
            nearer.text(),
            each.join(", "),
        ]);
    }
    (!table.rows.is_empty()).then_some(Block::Table(table))
}

/// A number about modes over the trainings that were scored on two experts.
fn over(row: &PooledRow<'_>, value: impl Fn(&ModeScores) -> f64) -> Option<OverSeeds> {
    OverSeeds::of(row.rows.iter().filter_map(|row| row.modes.as_ref()).map(value).collect())
}

fn millimetres(over: &OverSeeds) -> String {
    format!("{:.2} ± {:.2}", over.mean, over.std)
}

#[cfg(test)]
mod tests {
    use super::super::super::samples::{coin_toss, run, scored};
    use super::*;
    use crate::learners::Learner;

    #[test]
    fn shares_of_two_experts_are_averaged_over_trainings() {
        let study = Study::new(vec![coin_toss("coin", 1, 0.1, 0.5), coin_toss("coin-seed2", 2, 0.3, 0.6)]);
        let blocks = over_training_seeds(&study);
        let tables: Vec<&Table> = blocks
            .iter()
            .filter_map(|block| match block {
                Block::Table(table) => Some(table),
                _ => None,
            })
            .collect();
        assert_eq!(tables.len(), 2, "errors, and modes");
        // Half of 0.2, times the root of two; of 0.1 alike.
        let expected = [
            "Flow 2",
            "1",
            "2",
            "20.0 % ± 14.1 %",
            "55.0 % ± 7.1 %; 45.0 % ± 7.1 %",
            "25.0 % ± 0.0 %",
            "0.0200 ± 0.0000",
            "10.0 %, 30.0 %",
        ];
        assert_eq!(tables[1].rows, [expected.map(str::to_owned)]);
        let single = scored(run("door", "door", 10, 1), Learner::Flow(1), &[(1, &[0.5])]);
        let other = scored(run("door-seed2", "door", 10, 2), Learner::Flow(1), &[(1, &[0.5])]);
        let study = Study::new(vec![single, other]);
        let tables = over_training_seeds(&study);
        assert_eq!(tables.iter().filter(|block| matches!(block, Block::Table(_))).count(), 1, "one expert");
    }
}
