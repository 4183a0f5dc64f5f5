//! Measures what the simulator promises: success of expert, replay and standing still, contact depth, step halving.
//!
//! `cargo run -p reseflow-sim --example figures -- [EPISODES]`
#![allow(clippy::print_stdout, reason = "an example that reports to the terminal")]

use std::error::Error;
use std::time::Instant;

use rand::RngExt;
use rayon::prelude::*;
use reseflow_data::{
    Action, Episode, EpisodeKey, EpisodeObserver, Outcome, Policy, RolloutConfig, Scene, Split, Task, Tick,
    rollout,
};
use reseflow_lie::{SE3, SO3, Vector3};
use reseflow_sim::{GenerateRequest, Generated, Scripted, Still, TriangleTask, generate};

/// Collects the depth of every contact, metres.
#[derive(Default)]
struct Depths(Vec<f64>);

impl EpisodeObserver for Depths {
    fn on_tick(&mut self, tick: &Tick, _scene: &mut dyn Scene) {
        self.0.extend(tick.contacts.iter().map(|contact| contact.depth_m));
    }
}

fn run(
    task: &dyn Task,
    key: &EpisodeKey,
    policy: Option<Box<dyn Policy>>,
) -> Result<(Outcome, Vec<f64>), String> {
    let spec = task.spec();
    let mut scene = task.reset(key).map_err(|fault| fault.to_string())?;
    let mut policy = policy.unwrap_or_else(|| scene.expert());
    let config = RolloutConfig {
        observation_horizon: 1,
        n_action_steps: spec.action_steps,
        disturb_before: None,
        policy_seed: 0,
    };
    let mut depths = Depths::default();
    let record = rollout(scene.as_mut(), &spec, policy.as_mut(), &config, &mut depths)
        .map_err(|fault| fault.to_string())?;
    Ok((record.outcome, depths.0))
}

fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(((values.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(0.0)
}

fn expert_success(task: &TriangleTask, split: Split, seed: u64, episodes: u64) -> Result<(), Box<dyn Error>> {
    let started = Instant::now();
    let results: Vec<(Outcome, Vec<f64>)> = (0..episodes)
        .into_par_iter()
        .map(|index| run(task, &EpisodeKey { task: "triangle".into(), split, seed, index, attempt: 0 }, None))
        .collect::<Result<_, _>>()?;
    let solved = results.iter().filter(|(outcome, _)| outcome.success).count();
    let mut errors: Vec<f64> =
        results.iter().map(|(o, _)| (o.measure - std::f64::consts::FRAC_PI_2).abs()).collect();
    let mut depths: Vec<f64> = results.iter().flat_map(|(_, depths)| depths.iter().copied()).collect();
    println!(
        "expert on {split}, {} substeps: {solved}/{episodes}; |angle error| median {:.4} p99 {:.4} rad; \
         depth median {:.3} p99 {:.3} max {:.3} mm; {:.1} s",
        task.physics.substeps,
        percentile(&mut errors, 0.5),
        percentile(&mut errors, 0.99),
        1e3 * percentile(&mut depths, 0.5),
        1e3 * percentile(&mut depths, 0.99),
        1e3 * percentile(&mut depths, 1.0),
        started.elapsed().as_secs_f64()
    );
    for (index, (outcome, _)) in results.iter().enumerate().filter(|(_, (o, _))| !o.success).take(5) {
        println!("  failed {index}: {outcome:?}");
    }
    Ok(())
}

/// Success of the expert's commands with independent errors, as a learned policy makes them.
fn noisy_success(
    task: &TriangleTask,
    made: &Generated,
    sigma_rad: f64,
    sigma_m: f64,
) -> Result<usize, Box<dyn Error>> {
    let noisy = |(episode, key): (&Episode, &EpisodeKey)| {
        let mut rng = key.rng("command noise");
        let disturbed = episode.actions.iter().map(|action| Action {
            world_from_gripper: SE3::sample_gaussian(
                &action.world_from_gripper,
                sigma_rad,
                sigma_m,
                &mut rng,
            ),
            opening: action.opening,
        });
        run(task, key, Some(Box::new(Scripted::new("noisy", disturbed.collect()))))
    };
    let results: Vec<_> = made.episodes.par_iter().zip(&made.keys).map(noisy).collect::<Result<_, _>>()?;
    Ok(results.iter().filter(|(outcome, _)| outcome.success).count())
}

/// Commands scattered about the table, openings beyond their range, now and then a NaN: how such episodes end.
fn wild(task: &TriangleTask, episodes: u64) -> Result<(), Box<dyn Error>> {
    let home =
        SE3::new(SO3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0)), Vector3::new(0.0, 0.0, 0.12));
    let results: Vec<_> = (0..episodes)
        .into_par_iter()
        .map(|index| {
            let key = EpisodeKey { task: "triangle".into(), split: Split::Test, seed: 2, index, attempt: 0 };
            let mut rng = key.rng("wild actions");
            let actions = (0..10).map(|_| {
                let nan = rng.random_range(0..200) == 0;
                Action {
                    world_from_gripper: SE3::sample_gaussian(&home, 0.5, 0.12, &mut rng),
                    opening: if nan { f64::NAN } else { rng.random_range(-0.5..=1.5) },
                }
            });
            run(task, &key, Some(Box::new(Scripted::new("wild", actions.collect()))))
        })
        .collect::<Result<_, _>>()?;
    let mut ends = std::collections::BTreeMap::<String, usize>::new();
    let mut depths: Vec<f64> = results.iter().flat_map(|(_, depths)| depths.iter().copied()).collect();
    for (outcome, _) in &results {
        *ends.entry(outcome.halt.map_or("none".to_owned(), |halt| halt.to_string())).or_default() += 1;
    }
    println!(
        "wild actions, {episodes} episodes: {ends:?}; depth p99 {:.3} mm",
        1e3 * percentile(&mut depths, 0.99)
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let episodes: u64 = std::env::args().nth(1).map_or(Ok(200), |text| text.parse())?;
    let task = TriangleTask::default();
    expert_success(&task, Split::Test, 1, episodes)?;
    expert_success(&task, Split::Wide, 1, episodes)?;
    let mut halved = task;
    halved.physics.substeps *= 2;
    expert_success(&halved, Split::Test, 1, episodes)?;

    let started = Instant::now();
    let made = generate(&task, &GenerateRequest::new(Split::Train, 7, 100), &|| ())?;
    println!(
        "generate: 100 episodes in {:.1} s, dropped {}",
        started.elapsed().as_secs_f64(),
        made.attempts_dropped
    );

    let made = generate(&task, &GenerateRequest::new(Split::Train, 7, episodes as usize), &|| ())?;
    let replay = |(episode, key): (&Episode, &EpisodeKey)| {
        run(&task, key, Some(Box::new(Scripted::new("replay", episode.actions.clone()))))
    };
    let replayed: Vec<_> = made.episodes.par_iter().zip(&made.keys).map(replay).collect::<Result<_, _>>()?;
    println!("replay: {}/{episodes}", replayed.iter().filter(|(outcome, _)| outcome.success).count());

    for (sigma_rad, sigma_m) in [(0.02, 0.001), (0.03, 0.002), (0.05, 0.003), (0.08, 0.005)] {
        let solved = noisy_success(&task, &made, sigma_rad, sigma_m)?;
        println!(
            "commands off by {sigma_rad} rad and {} mm on each axis: {solved}/{episodes}",
            1e3 * sigma_m
        );
    }

    let still: Vec<_> = made
        .keys
        .par_iter()
        .take(100)
        .map(|key| run(&task, key, Some(Box::new(Still))))
        .collect::<Result<_, _>>()?;
    println!(
        "standing still: {}/{}",
        still.iter().filter(|(outcome, _)| outcome.success).count(),
        still.len()
    );
    wild(&task, 1000)?;
    Ok(())
}
