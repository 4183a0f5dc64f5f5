//! Runs side by side: each in a process of its own, its output in a file of its own.

use std::collections::{BTreeMap, VecDeque};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use crate::process::{self, complain, say};

/// Runs side by side where nobody says how many.
const MOST: usize = 8;

/// How often the last line of every run is shown.
const LOOK_EVERY: Duration = Duration::from_secs(60);

/// One thing to run.
pub(crate) struct Job {
    /// Its name.
    pub(crate) name: String,
    /// The program and its arguments.
    pub(crate) command: std::process::Command,
    /// Where its output goes.
    pub(crate) log: PathBuf,
}

/// Runs the jobs of `what` in order, `width` of them at a time, and returns the names of those that failed.
///
/// A job whose output cannot be kept has failed like one that ran; the others go on.
///
/// # Errors
/// A folder for the output that cannot be made.
pub(crate) fn run(what: &str, jobs: Vec<Job>, width: usize) -> Result<Vec<String>> {
    for folder in jobs.iter().filter_map(|job| job.log.parent()) {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let (started, count) = (Instant::now(), jobs.len());
    let mut waiting: VecDeque<Job> = jobs.into();
    let mut running: BTreeMap<String, (PathBuf, Instant)> = BTreeMap::new();
    let mut failed = Vec::new();
    let (sender, finished) = mpsc::channel::<(String, Result<()>)>();
    let mut done = 0;
    while done < count {
        while running.len() < width.max(1) {
            let Some(Job { name, mut command, log }) = waiting.pop_front() else { break };
            let place = count - waiting.len();
            say(&format!("{what} {place}/{count}: {name} begins; what it says is in {}", log.display()));
            if let Err(fault) = keep_output(&mut command, &log) {
                complain(&format!("{name}: {fault:#}"));
                failed.push(name);
                done += 1;
                continue;
            }
            running.insert(name.clone(), (log, Instant::now()));
            let sender = sender.clone();
            thread::spawn(move || {
                let result = process::run_aside(&name, &mut command);
                // Nobody listens any more where the caller has given up.
                let _ = sender.send((name, result));
            });
        }
        if running.is_empty() {
            continue;
        }
        match finished.recv_timeout(LOOK_EVERY) {
            Ok((name, result)) => {
                done += 1;
                let begun = running.remove(&name).map_or(started, |(_, begun)| begun);
                let how = if result.is_ok() { "done" } else { "failed" };
                let (took, total) = (clock(begun.elapsed()), clock(started.elapsed()));
                say(&format!(
                    "{what}: {name} {how} in {took}, {total} since the build, {} to go",
                    count - done
                ));
                if let Err(fault) = result {
                    complain(&format!("{fault:#}"));
                    failed.push(name);
                }
            }
            Err(RecvTimeoutError::Timeout) => {
                for (name, (log, _)) in &running {
                    say(&format!("  {name}: {}", last_line(log)));
                }
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    Ok(failed)
}

/// Sends what `command` says to the end of the file `log`.
fn keep_output(command: &mut std::process::Command, log: &Path) -> Result<()> {
    let output =
        File::options().create(true).append(true).open(log).with_context(|| log.display().to_string())?;
    command.stdout(output.try_clone()?).stderr(output);
    Ok(())
}

/// As many as there are processor cores, up to eight.
pub(crate) fn default_width() -> usize {
    thread::available_parallelism().map_or(1, usize::from).min(MOST)
}

/// A span of time as people read it.
pub(crate) fn clock(time: Duration) -> String {
    let secs = time.as_secs();
    format!("{} h {:02} min {:02} s", secs / 3600, secs / 60 % 60, secs % 60)
}

/// The last line of a file, as far as it can be read.
fn last_line(path: &Path) -> String {
    let text = fs::read(path).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or_default().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_written_in_hours_minutes_and_seconds() {
        assert_eq!(clock(Duration::from_secs(3723)), "1 h 02 min 03 s");
    }

    fn job(folder: &Path, name: &str, script: &str) -> Job {
        let mut command = std::process::Command::new("sh");
        command.args(["-c", script]);
        Job { name: name.to_owned(), command, log: folder.join(format!("logs/{name}.log")) }
    }

    #[test]
    fn every_job_runs_keeps_its_output_and_failures_are_named() {
        let folder = std::env::temp_dir().join(format!("reseflow-jobs-{}", std::process::id()));
        let jobs = vec![
            job(&folder, "a", "echo one; echo two >&2"),
            job(&folder, "b", "echo three; exit 4"),
            job(&folder, "c", "echo five"),
        ];
        let failed = run("test", jobs, 2).unwrap();
        let said = |name: &str| fs::read_to_string(folder.join(format!("logs/{name}.log"))).unwrap();
        assert_eq!(failed, ["b"]);
        assert_eq!((said("a").as_str(), said("b").as_str()), ("one\ntwo\n", "three\n"));
        assert_eq!(last_line(&folder.join("logs/c.log")), "five");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_job_whose_output_cannot_be_kept_stops_no_other() {
        let folder = std::env::temp_dir().join(format!("reseflow-logs-{}", std::process::id()));
        fs::create_dir_all(folder.join("logs/b.log")).unwrap();
        let jobs = ["a", "b", "c", "d"].map(|name| job(&folder, name, "echo said"));
        fs::create_dir_all(folder.join("logs/d.log")).unwrap();
        assert_eq!(run("test", jobs.into(), 1).unwrap(), ["b", "d"]);
        let said = |name: &str| fs::read_to_string(folder.join(format!("logs/{name}.log"))).unwrap();
        assert_eq!(["a", "c"].map(said), ["said\n"; 2]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn as_many_run_side_by_side_as_asked_for_and_no_more() {
        let folder = std::env::temp_dir().join(format!("reseflow-width-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let place = folder.display();
        // Two at a time would find each other's folder.
        let alone = format!("mkdir {place}/busy && sleep 0.1 && rmdir {place}/busy");
        // One at a time would wait in vain.
        let meet = |own: &str, other: &str| {
            format!(
                "touch {place}/{own}; for i in $(seq 400); do test -e {place}/{other} && exit 0; sleep 0.05; done; exit 1"
            )
        };
        let turns = ["1", "2", "3"].map(|name| job(&folder, name, &alone));
        assert_eq!(run("test", turns.into(), 1).unwrap(), Vec::<String>::new());
        let pair = vec![job(&folder, "x", &meet("x", "y")), job(&folder, "y", &meet("y", "x"))];
        assert_eq!(run("test", pair, 2).unwrap(), Vec::<String>::new());
        fs::remove_dir_all(folder).unwrap();
    }
}
