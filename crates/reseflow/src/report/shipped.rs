//! What the policies that ship were trained with, as the card beside them tells.

use std::fs;
use std::path::Path;

use reseflow_train::WEIGHTS;
use serde::Deserialize;

use super::gather::json;
use crate::learning::find_policies;

/// The part of `card.json` that a report shows.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub(super) struct Card {
    /// Demonstrations that the policies learned from.
    pub(super) demonstrations: Option<usize>,
    /// The seed of Flow 1's training.
    pub(super) seed: Option<u64>,
}

/// The card of the policies that the run in `folder` took from `given`; `None` where there is none, or where it lies beside other weights
/// by now.
///
/// # Errors
/// Bad input: the card is broken.
pub(super) fn card(folder: &Path, given: &str) -> anyhow::Result<Option<Card>> {
    let Ok(policies) = find_policies(Path::new(given)) else { return Ok(None) };
    let card = policies.join("card.json");
    let weights = |policy: &Path| fs::read(policy.join(WEIGHTS)).ok();
    let scored = weights(&folder.join("checkpoint"));
    if !card.is_file() || scored.is_none() || scored != weights(&policies.join("flow1")) {
        return Ok(None);
    }
    json(&card).map(Some)
}

#[cfg(test)]
mod tests {
    use super::super::gather::Run;
    use super::super::study::{Group, Study};
    use super::*;

    #[test]
    fn a_run_of_shipped_policies_knows_what_they_learned_from_as_long_as_they_are_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["run/checkpoint", "door/flow1"] {
            fs::create_dir_all(path(name)).unwrap();
            fs::write(path(name).join(WEIGHTS), "weights").unwrap();
        }
        let given = path("door").display().to_string().replace('\\', "/");
        let config = format!(
            "name = \"a\"\ntask = \"door\"\npretrained = \"{given}\"\n[data]\ntrain_episodes = 200\n[train]\nseed = 1\n"
        );
        fs::write(path("run/config.toml"), config).unwrap();
        let read = || Run::read(&path("run"));
        let known = || read().map(|run| (run.demonstrations, run.training_seed)).unwrap();
        assert_eq!(known(), (None, None), "the 200 are for the trivial predictors");
        fs::write(path("door/card.json"), "{\"demonstrations\": 3000, \"seed\": 7, \"policies\": {}}")
            .unwrap();
        assert_eq!(known(), (Some(3000), Some(7)));
        let study = Study::new(vec![read().unwrap()]);
        assert_eq!(study.groups(), [Group::Shipped], "tasks have as many demonstrations as serve them");
        fs::write(path("door/card.json"), "[").unwrap();
        assert!(read().unwrap_err().to_string().contains("card.json"));
        fs::write(path("door/flow1/model.safetensors"), "others").unwrap();
        assert_eq!(known(), (None, None));
    }
}
