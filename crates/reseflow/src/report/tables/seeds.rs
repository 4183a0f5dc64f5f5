//! Experiments that were trained with several seeds.

use super::super::document::{Block, Table};
use super::super::pooling::OverSeeds;
use super::super::study::{Study, learner_title};

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
    }
    blocks
}

fn millimetres(over: &OverSeeds) -> String {
    format!("{:.2} ± {:.2}", over.mean, over.std)
}
