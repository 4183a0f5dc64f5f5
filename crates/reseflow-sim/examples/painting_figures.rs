//! Measures what the painting task promises: success of expert, replay and standing still, force, depth, visibility.
//!
//! `cargo run -p reseflow-sim --example painting_figures -- [EPISODES]`
#![allow(clippy::print_stdout, reason = "an example that reports to the terminal")]

use std::error::Error;
use std::time::Instant;

use rayon::prelude::*;
use reseflow_data::{
    Action, Episode, EpisodeKey, EpisodeObserver, ObservationHistory, Outcome, Policy, RolloutConfig, Scene,
    Split, Task, Tick, rollout,
};
use reseflow_lie::{SE3, geodesic_distance};
use reseflow_sim::{GenerateRequest, PaintingSetup, PaintingTask, Scripted, Still, generate, is_salient};

/// Depths and brush forces of every tick.
#[derive(Default)]
struct Touches {
    depths_m: Vec<f64>,
    forces_n: Vec<f64>,
}

impl EpisodeObserver for Touches {
    fn on_tick(&mut self, tick: &Tick, _scene: &mut dyn Scene) {
        for contact in &tick.contacts {
            self.depths_m.push(contact.depth_m);
            if contact.body_a == "board" && contact.body_b == "gripper_brush" {
                self.forces_n.push(contact.force_n);
            }
        }
    }
}

fn run(
    task: &PaintingTask,
    key: &EpisodeKey,
    policy: Option<Box<dyn Policy>>,
) -> Result<(Outcome, Touches), String> {
    let spec = task.spec();
    let mut scene = task.reset(key).map_err(|fault| fault.to_string())?;
    let mut policy = policy.unwrap_or_else(|| scene.expert());
    let config = RolloutConfig {
        observation_horizon: 1,
        n_action_steps: spec.action_steps,
        disturb_before: None,
        policy_seed: 0,
    };
    let mut touches = Touches::default();
    let record = rollout(scene.as_mut(), &spec, policy.as_mut(), &config, &mut touches)
        .map_err(|fault| fault.to_string())?;
    Ok((record.outcome, touches))
}

fn key(split: Split, seed: u64, index: u64) -> EpisodeKey {
    EpisodeKey { task: "painting".to_owned(), split, seed, index, attempt: 0 }
}

fn percentile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(((values.len() as f64 - 1.0) * share).round() as usize).copied().unwrap_or(0.0)
}

fn expert_success(task: &PaintingTask, split: Split, episodes: u64) -> Result<(), Box<dyn Error>> {
    let started = Instant::now();
    let results: Vec<(Outcome, Touches)> = (0..episodes)
        .into_par_iter()
        .map(|i| run(task, &key(split, 1, i), None))
        .collect::<Result<_, _>>()?;
    let solved = results.iter().filter(|(outcome, _)| outcome.success).count();
    let mut covered: Vec<f64> = results.iter().map(|(outcome, _)| outcome.measure).collect();
    let mut depths: Vec<f64> = results.iter().flat_map(|(_, t)| t.depths_m.iter().copied()).collect();
    let mut forces: Vec<f64> = results.iter().flat_map(|(_, t)| t.forces_n.iter().copied()).collect();
    println!(
        "expert on {split}, {} substeps: {solved}/{episodes}; covered least {:.3} median {:.3}; brush force p5 {:.2} \
         median {:.2} p95 {:.2} N; depth p99 {:.3} max {:.3} mm; {:.1} s",
        task.physics.substeps,
        percentile(&mut covered, 0.0),
        percentile(&mut covered, 0.5),
        percentile(&mut forces, 0.05),
        percentile(&mut forces, 0.5),
        percentile(&mut forces, 0.95),
        1e3 * percentile(&mut depths, 0.99),
        1e3 * percentile(&mut depths, 1.0),
        started.elapsed().as_secs_f64()
    );
    for (index, (outcome, _)) in results.iter().enumerate().filter(|(_, (o, _))| !o.success).take(5) {
        let name = PaintingSetup::draw(&key(split, 1, index as u64))?.stroke.name().to_owned();
        println!("  failed {index}, {name}: {outcome:?}");
    }
    Ok(())
}

/// The D̄_geo of predicting the mean of the commands relative to the gripper's start, with its largest step.
fn mean_trajectory_error(episodes: &[Episode]) -> Result<f64, Box<dyn Error>> {
    let steps = episodes[0].actions.len();
    let mut sum = 0.0;
    for step in 0..steps {
        let relative: Vec<SE3> = episodes
            .iter()
            .map(|e| e.observations[0].world_from_gripper.inverse() * e.actions[step].world_from_gripper)
            .collect();
        let mean = SE3::frechet_mean(&relative, &vec![1.0; relative.len()])?;
        sum += relative.iter().map(|pose| geodesic_distance(&mean, pose).d_geo()).sum::<f64>()
            / relative.len() as f64;
    }
    Ok(sum / steps as f64)
}

/// Control ticks and clouds per second on one core, over one episode.
fn speed(task: &PaintingTask) -> Result<(), Box<dyn Error>> {
    let key = key(Split::Test, 1, 0);
    let mut scene = task.reset(&key)?;
    let mut command =
        Action { world_from_gripper: PaintingSetup::draw(&key)?.world_from_gripper, opening: 0.0 };
    let history = ObservationHistory::new(scene.observe(), 1);
    let plan = scene.expert().plan(&history)?;
    let started = Instant::now();
    for target in plan.actions.iter() {
        for tick in 1..=10 {
            scene.tick(&command.interpolate(target, f64::from(tick) / 10.0))?;
        }
        command = *target;
    }
    let ticks_per_sec = 100.0 / started.elapsed().as_secs_f64();
    let started = Instant::now();
    for _ in 0..20 {
        scene.observe();
    }
    let clouds_per_sec = 20.0 / started.elapsed().as_secs_f64();
    println!("one core: {ticks_per_sec:.0} control ticks/s, {clouds_per_sec:.0} clouds/s");
    Ok(())
}

/// How many points of the stroke (blue) and of its beginning (green) the first frame holds.
fn first_frames(task: &PaintingTask, split: Split, episodes: u64) -> Result<(), Box<dyn Error>> {
    let count = |index: u64| {
        let cloud = task.reset(&key(split, 1, index)).map_err(|fault| fault.to_string())?.observe().cloud;
        let salient = cloud.colors.iter().filter(|&&color| is_salient(color));
        Ok(salient.fold([0.0, 0.0], |[green, blue], color| {
            if color[1] > color[2] { [green + 1.0, blue] } else { [green, blue + 1.0] }
        }))
    };
    let counts: Vec<[f64; 2]> = (0..episodes).into_par_iter().map(count).collect::<Result<_, String>>()?;
    let [mut beginning, mut stroke] = [0, 1].map(|i| counts.iter().map(|c| c[i]).collect::<Vec<f64>>());
    println!(
        "first frames on {split}: points of the beginning least {} median {}, of the stroke least {} median {}",
        percentile(&mut beginning, 0.0),
        percentile(&mut beginning, 0.5),
        percentile(&mut stroke, 0.0),
        percentile(&mut stroke, 0.5)
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let episodes: u64 = std::env::args().nth(1).map_or(Ok(200), |text| text.parse())?;
    let task = PaintingTask::default();
    speed(&task)?;
    first_frames(&task, Split::Test, episodes)?;
    first_frames(&task, Split::Wide, episodes)?;
    expert_success(&task, Split::Test, episodes)?;
    expert_success(&task, Split::Wide, episodes)?;
    let mut halved = task;
    halved.physics.substeps *= 2;
    expert_success(&halved, Split::Test, episodes)?;

    let started = Instant::now();
    let made = generate(&task, &GenerateRequest::new(Split::Train, 7, episodes as usize), &|| ())?;
    println!(
        "generate: {episodes} episodes in {:.1} s, dropped {}; mean trajectory D_geo {:.3}",
        started.elapsed().as_secs_f64(),
        made.attempts_dropped,
        mean_trajectory_error(&made.episodes)?
    );
    let replayed = |sigma_rad: f64, sigma_m: f64| -> Result<usize, String> {
        let one = |(episode, key): (&Episode, &EpisodeKey)| {
            let mut rng = key.rng("command noise");
            let actions = episode.actions.iter().map(|action| Action {
                world_from_gripper: SE3::sample_gaussian(
                    &action.world_from_gripper,
                    sigma_rad,
                    sigma_m,
                    &mut rng,
                ),
                opening: action.opening,
            });
            run(&task, key, Some(Box::new(Scripted::new("replay", actions.collect()))))
        };
        let results: Vec<_> =
            made.episodes.par_iter().zip(&made.keys).map(one).collect::<Result<_, String>>()?;
        Ok(results.iter().filter(|(outcome, _)| outcome.success).count())
    };
    println!("replay: {}/{episodes}", replayed(0.0, 0.0)?);
    for (sigma_rad, sigma_m) in [(0.01, 0.0005), (0.02, 0.001), (0.03, 0.002), (0.05, 0.003)] {
        println!(
            "commands off by {sigma_rad} rad and {} mm on each axis: {}/{episodes}",
            1e3 * sigma_m,
            replayed(sigma_rad, sigma_m)?
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
    Ok(())
}
