//! The array `disturbed`: for each episode two steps, both 0 where nothing happened.

use crate::npz::Array;
use crate::{Disturbance, Episode};

/// Lays the episodes' disturbances out; `None` where there are none.
pub(super) fn array(episodes: &[Episode]) -> Option<Array<i32>> {
    episodes.iter().any(|episode| episode.disturbance.is_some()).then(|| Array {
        shape: vec![episodes.len(), 2],
        data: episodes.iter().flat_map(|episode| steps(episode.disturbance)).collect(),
    })
}

fn steps(disturbance: Option<Disturbance>) -> [i32; 2] {
    disturbance.map_or([0; 2], |Disturbance { before, answered_from }| {
        [before, answered_from].map(|step| i32::try_from(step).unwrap_or(i32::MAX))
    })
}

/// Whether all steps are of episodes with `steps` steps, and none is answered before it happens.
pub(super) fn check(array: &[i32], steps: usize) -> Result<(), String> {
    let (rows, _) = array.as_chunks::<2>();
    let is_sound = |&[before, answered]: &[i32; 2]| {
        0 <= before && before <= answered && usize::try_from(answered).is_ok_and(|step| step < steps)
    };
    match rows.iter().position(|row| !is_sound(row)) {
        None => Ok(()),
        Some(episode) => Err(format!(
            "`disturbed`[{episode}] is {:?}, expected two steps from 0 to {}, the second not before the first",
            rows[episode],
            steps - 1
        )),
    }
}

/// The disturbance of an episode in a checked array.
pub(super) fn of_episode(array: &[i32], episode: usize) -> Option<Disturbance> {
    let (rows, _) = array.as_chunks::<2>();
    let [before, answered_from] = rows.get(episode)?.map(|step| usize::try_from(step).unwrap_or(0));
    (answered_from > 0).then_some(Disturbance { before, answered_from })
}
