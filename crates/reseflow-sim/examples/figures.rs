//! Measures what the simulator promises: success of expert, replay and standing still, contact depth, step halving.
//!
//! `cargo run -p reseflow-sim --example figures -- [EPISODES] [TASK…]`
#![allow(clippy::print_stdout, reason = "an example that reports to the terminal")]

use std::collections::BTreeMap;
use std::error::Error;
use std::time::Instant;

use rand::RngExt;
use rayon::prelude::*;
use reseflow_data::{
    Action, Episode, EpisodeKey, EpisodeObserver, Outcome, Policy, RolloutConfig, Scene, Split, Task, Tick,
    rollout,
};
use reseflow_lie::{SE3, SO3, Vector3, geodesic_distance};
use reseflow_sim::{
    CameraSettings, GenerateRequest, Generated, PhysicsSettings, Scripted, Still, configured_task, generate,
    task, tasks,
};

/// Episodes in the measurements that need many runs.
const SLOW_EPISODES: usize = 100;
/// Worlds that are alive at once where their memory is measured.
const WORLDS: u64 = 300;

/// Plans again every third action step, undisturbed.
const CLOSED_LOOP: RolloutConfig =
    RolloutConfig { observation_horizon: 1, n_action_steps: 3, disturb_before: None, policy_seed: 0 };

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
    run_as(task, key, policy, &RolloutConfig { n_action_steps: task.spec().action_steps, ..CLOSED_LOOP })
}

fn run_as(
    task: &dyn Task,
    key: &EpisodeKey,
    policy: Option<Box<dyn Policy>>,
    config: &RolloutConfig,
) -> Result<(Outcome, Vec<f64>), String> {
    let spec = task.spec();
    let mut scene = task.reset(key).map_err(|fault| fault.to_string())?;
    let mut policy = policy.unwrap_or_else(|| scene.expert());
    let mut depths = Depths::default();
    let record = rollout(scene.as_mut(), &spec, policy.as_mut(), config, &mut depths)
        .map_err(|fault| fault.to_string())?;
    Ok((record.outcome, depths.0))
}

fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(((values.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(0.0)
}

/// Wilson's 95 % interval of a share.
fn wilson(successes: usize, trials: usize) -> (f64, f64) {
    let (n, z) = (trials as f64, 1.959_963_984_540_054_f64);
    let share = successes as f64 / n;
    let middle = share + z * z / (2.0 * n);
    let half = z * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + z * z / n;
    ((middle - half) / scale, (middle + half) / scale)
}

/// The expert's outcomes; prints how it fared.
fn expert(task: &dyn Task, label: &str, split: Split, episodes: u64) -> Result<Vec<Outcome>, Box<dyn Error>> {
    let started = Instant::now();
    let name = task.spec().name;
    let results: Vec<(Outcome, Vec<f64>)> = (0..episodes)
        .into_par_iter()
        .map(|index| run(task, &EpisodeKey { task: name.clone(), split, seed: 1, index, attempt: 0 }, None))
        .collect::<Result<_, _>>()?;
    let solved = results.iter().filter(|(outcome, _)| outcome.success).count();
    let mut measures: Vec<f64> = results.iter().map(|(outcome, _)| outcome.measure).collect();
    let mut depths: Vec<f64> = results.iter().flat_map(|(_, depths)| depths.iter().copied()).collect();
    let (low, high) = wilson(solved, results.len());
    println!(
        "{name}, expert on {split}{label}: {solved}/{episodes} ({low:.4} to {high:.4}); measure p1 {:.4} median {:.4} p99 \
         {:.4}; depth median {:.3} p99 {:.3} max {:.3} mm; {:.1} s",
        percentile(&mut measures, 0.01),
        percentile(&mut measures, 0.5),
        percentile(&mut measures, 0.99),
        1e3 * percentile(&mut depths, 0.5),
        1e3 * percentile(&mut depths, 0.99),
        1e3 * percentile(&mut depths, 1.0),
        started.elapsed().as_secs_f64()
    );
    for (index, (outcome, _)) in results.iter().enumerate().filter(|(_, (o, _))| !o.success).take(5) {
        println!("  failed {index}: {outcome:?}");
    }
    Ok(results.into_iter().map(|(outcome, _)| outcome).collect())
}

/// What halving the physics step changes in the success measure.
fn halved(name: &str, coarse: &[Outcome]) -> Result<(), Box<dyn Error>> {
    let physics = PhysicsSettings { substeps: 2 * PhysicsSettings::default().substeps, ..Default::default() };
    let task = configured_task(name, physics, CameraSettings::default())?;
    let fine = expert(task.as_ref(), ", step halved", Split::Test, coarse.len() as u64)?;
    let mut changes: Vec<f64> =
        coarse.iter().zip(&fine).map(|(a, b)| (a.measure / b.measure - 1.0).abs()).collect();
    println!(
        "  halving changes the measure by median {:.3} %, max {:.3} %",
        100.0 * percentile(&mut changes, 0.5),
        100.0 * percentile(&mut changes, 1.0)
    );
    Ok(())
}

/// The expert's commands with independent errors, as a learned policy makes them.
fn noisy(task: &dyn Task, made: &Generated, sigma_rad: f64, sigma_m: f64) -> Result<usize, Box<dyn Error>> {
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

/// Disturbed episodes: the commands of the undisturbed ones replayed, and the expert planning again.
fn disturbed(task: &dyn Task, made: &Generated) -> Result<(), Box<dyn Error>> {
    let config = |index: usize, n_action_steps| RolloutConfig {
        n_action_steps,
        disturb_before: Some(task.spec().action_steps),
        policy_seed: index as u64,
        ..CLOSED_LOOP
    };
    let solved = |n_action_steps: usize, replay: bool| -> Result<usize, String> {
        let outcomes: Vec<bool> = (0..made.keys.len())
            .into_par_iter()
            .map(|index| {
                let stored = || Scripted::new("replay", made.episodes[index].actions.clone());
                let policy = replay.then(|| Box::new(stored()) as Box<dyn Policy>);
                let config = config(index, n_action_steps);
                Ok(run_as(task, &made.keys[index], policy, &config)?.0.success)
            })
            .collect::<Result<_, String>>()?;
        Ok(outcomes.into_iter().filter(|&success| success).count())
    };
    println!(
        "  disturbed before step {}: replay {}/{n}, expert planning every step {}/{n}, every third {}/{n}",
        task.spec().disturb_before,
        solved(1, true)?,
        solved(1, false)?,
        solved(3, false)?,
        n = made.keys.len()
    );
    Ok(())
}

/// D̄_geo of the mean trajectory relative to the gripper's first pose.
fn mean_trajectory_error(episodes: &[Episode]) -> Result<f64, Box<dyn Error>> {
    let start = |episode: &Episode| episode.observations[0].world_from_gripper.inverse();
    let steps = episodes.first().map_or(0, |episode| episode.actions.len());
    let mut sum = 0.0;
    for step in 0..steps {
        let relative: Vec<SE3> =
            episodes.iter().map(|e| start(e) * e.actions[step].world_from_gripper).collect();
        let mean = SE3::frechet_mean(&relative, &vec![1.0; relative.len()])?;
        sum += relative.iter().map(|pose| geodesic_distance(&mean, pose).d_geo()).sum::<f64>();
    }
    Ok(sum / (steps * episodes.len()) as f64)
}

/// Commands scattered about the table, openings beyond their range, now and then a NaN: how such episodes end.
fn wild(task: &dyn Task, episodes: u64) -> Result<(), Box<dyn Error>> {
    let home =
        SE3::new(SO3::exp(&Vector3::new(std::f64::consts::PI, 0.0, 0.0)), Vector3::new(0.0, 0.0, 0.12));
    let name = task.spec().name;
    let results: Vec<_> = (0..episodes)
        .into_par_iter()
        .map(|index| {
            let key = EpisodeKey { task: name.clone(), split: Split::Test, seed: 2, index, attempt: 0 };
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
    let mut ends = BTreeMap::<String, usize>::new();
    let mut depths: Vec<f64> = results.iter().flat_map(|(_, depths)| depths.iter().copied()).collect();
    for (outcome, _) in &results {
        *ends.entry(outcome.halt.map_or("none".to_owned(), |halt| halt.to_string())).or_default() += 1;
    }
    println!(
        "  wild actions, {episodes} episodes: {ends:?}; depth p99 {:.3} mm",
        1e3 * percentile(&mut depths, 0.99)
    );
    Ok(())
}

/// A line of what Linux says about this process's memory, kilobytes.
fn memory_kb(field: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(field))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

/// What one more running world takes, as the mean over many that are alive at once; returns them, so that the next task's
/// do not get their memory.
fn memory_of_a_world(name: &str) -> Result<Vec<Box<dyn Scene>>, Box<dyn Error>> {
    let task = task(name).ok_or_else(|| format!("no task `{name}`, expected one of {:?}", tasks()))?;
    let before = memory_kb("VmRSS:");
    let mut scenes = Vec::new();
    for index in 0..WORLDS {
        let mut scene = task.reset(&EpisodeKey {
            task: name.to_owned(),
            split: Split::Train,
            seed: 3,
            index,
            attempt: 0,
        })?;
        let first = scene.observe();
        let command = Action { world_from_gripper: first.world_from_gripper, opening: first.gripper_opening };
        for _ in 0..10 {
            scene.tick(&command).map_err(|halt| halt.to_string())?;
        }
        scenes.push(scene);
    }
    if let (Some(before), Some(after)) = (before, memory_kb("VmRSS:")) {
        println!("{name}: a running world takes {} kB", after.saturating_sub(before) / WORLDS);
    }
    Ok(scenes)
}

fn figures(name: &str, episodes: u64) -> Result<(), Box<dyn Error>> {
    let task = task(name).ok_or_else(|| format!("no task `{name}`, expected one of {:?}", tasks()))?;
    let task = task.as_ref();
    let coarse = expert(task, "", Split::Test, episodes)?;
    expert(task, "", Split::Wide, episodes)?;
    halved(name, &coarse[..coarse.len().min(SLOW_EPISODES)])?;

    let started = Instant::now();
    let made = generate(task, &GenerateRequest::new(Split::Train, 7, episodes as usize), &|| ())?;
    println!(
        "  generate: {episodes} episodes in {:.1} s, {} attempts dropped; mean trajectory off by D_geo {:.3}",
        started.elapsed().as_secs_f64(),
        made.attempts_dropped,
        mean_trajectory_error(&made.episodes)?
    );
    let replay = |(episode, key): (&Episode, &EpisodeKey)| {
        run(task, key, Some(Box::new(Scripted::new("replay", episode.actions.clone()))))
    };
    let replayed: Vec<_> = made.episodes.par_iter().zip(&made.keys).map(replay).collect::<Result<_, _>>()?;
    println!("  replay: {}/{episodes}", replayed.iter().filter(|(outcome, _)| outcome.success).count());
    let few = Generated {
        episodes: made.episodes.iter().take(SLOW_EPISODES).cloned().collect(),
        keys: made.keys.iter().take(SLOW_EPISODES).cloned().collect(),
        ..made
    };
    for (sigma_rad, sigma_m) in [(0.02, 0.001), (0.03, 0.002), (0.05, 0.003), (0.08, 0.005)] {
        let solved = noisy(task, &few, sigma_rad, sigma_m)?;
        println!(
            "  commands off by {sigma_rad} rad and {} mm on each axis: {solved}/{}",
            1e3 * sigma_m,
            few.episodes.len()
        );
    }
    disturbed(task, &few)?;
    let still = |key: &EpisodeKey| run(task, key, Some(Box::new(Still)));
    let still: Vec<_> = few.keys.par_iter().map(still).collect::<Result<_, _>>()?;
    println!(
        "  standing still: {}/{}",
        still.iter().filter(|(outcome, _)| outcome.success).count(),
        still.len()
    );
    wild(task, 1000)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let episodes: u64 = arguments.next().map_or(Ok(200), |text| text.parse())?;
    let mut names: Vec<String> = arguments.collect();
    if names.is_empty() {
        names = tasks().iter().map(|name| (*name).to_owned()).collect();
    }
    let worlds = names.iter().map(|name| memory_of_a_world(name)).collect::<Result<Vec<_>, _>>()?;
    drop(worlds);
    names.iter().try_for_each(|name| figures(name, episodes))?;
    if let Some(peak) = memory_kb("VmHWM:") {
        println!("the most memory that was ever in use: {peak} kB");
    }
    Ok(())
}
