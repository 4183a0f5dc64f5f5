//! The same seed gives the same bytes: twice, for any thread count, in another process, however often one looks.

use std::process::Command;

use reseflow_data::{EpisodeObserver, Scene, Split, Tick};
use reseflow_sim::{GenerateRequest, Generated, generate, task, tasks};

use crate::support::{digest, key, run, run_observed};

fn made(name: &str, threads: usize, episodes: usize) -> Generated {
    let request =
        GenerateRequest { threads: Some(threads), ..GenerateRequest::new(Split::Train, 21, episodes) };
    generate(task(name).unwrap().as_ref(), &request, &|| ()).unwrap()
}

/// A digest of episodes of every task.
fn digest_of_all(threads: usize) -> u64 {
    digest(&tasks().iter().map(|name| made(name, threads, 1)).collect::<Vec<_>>())
}

#[test]
fn thread_counts_change_nothing() {
    for name in tasks() {
        // As many threads as episodes, and more.
        let alone = made(name, 1, 2);
        for threads in [2, 5] {
            assert_eq!(alone, made(name, threads, 2), "{name} with {threads} threads");
        }
    }
}

/// A test of its own, and what `another_process_makes_the_same_bytes` reads from a second process.
#[test]
fn the_digest_is_repeatable() {
    let first = digest_of_all(2);
    assert_eq!(first, digest_of_all(2));
    println!("digest={first}");
}

#[test]
fn another_process_makes_the_same_bytes() {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "determinism::the_digest_is_repeatable", "--nocapture"])
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let there = text.split("digest=").nth(1).and_then(|rest| rest.split_whitespace().next()).unwrap();
    assert_eq!(there, digest_of_all(2).to_string());
}

/// Looks at the scene after every fifth tick, as a log does.
#[derive(Default)]
struct Watcher(usize);

impl EpisodeObserver for Watcher {
    fn on_tick(&mut self, _tick: &Tick, scene: &mut dyn Scene) {
        self.0 += 1;
        if self.0.is_multiple_of(5) {
            assert_eq!(scene.observe(), scene.observe());
        }
    }
}

#[test]
fn looking_changes_nothing() {
    for name in tasks() {
        let task = task(name).unwrap();
        let key = key(name, Split::Train, 21, 3);
        let mut watcher = Watcher::default();
        let watched = run_observed(task.as_ref(), &key, None, None, &mut watcher);
        assert_eq!(watcher.0, 100);
        assert_eq!(watched.episode, run(task.as_ref(), &key, None).episode);
    }
}
