//! Progress: a bar on a terminal, a plain line now and then elsewhere.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Plain lines come at most this often, so that a log stays readable.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// The progress of one piece of work. Shared freely between threads.
pub struct Progress {
    label: String,
    total: u64,
    done: AtomicU64,
    before: u64,
    started: Instant,
    display: Display,
}

enum Display {
    Bar(ProgressBar),
    Plain { last_line: Mutex<Instant> },
}

impl Progress {
    pub(super) fn start(label: &str, total: u64, interactive: bool) -> Self {
        let started = Instant::now();
        let display = if interactive {
            let bar = ProgressBar::new(total).with_prefix(label.to_owned());
            let template = "{prefix:<12} {bar:32} {pos}/{len} {elapsed} (eta {eta}) {msg}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            Display::Bar(bar)
        } else {
            Display::Plain { last_line: Mutex::new(started) }
        };
        Self { label: label.to_owned(), total, done: AtomicU64::new(0), before: 0, started, display }
    }

    /// One more thing is done.
    pub fn advance(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.show(done, "");
    }

    /// `done` things are done; `message` says how it stands.
    pub fn set(&self, done: u64, message: &str) {
        self.done.store(done, Ordering::Relaxed);
        self.show(done, message);
    }

    /// `done` things were done before this work was taken up again; the time left is judged from what comes now.
    pub fn start_at(&mut self, done: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.before = done;
        if let Display::Bar(bar) = &self.display {
            bar.set_position(done);
            bar.reset_eta();
        }
    }

    fn show(&self, done: u64, message: &str) {
        match &self.display {
            Display::Bar(bar) => {
                bar.set_position(done);
                if !message.is_empty() {
                    bar.set_message(message.to_owned());
                }
            }
            Display::Plain { last_line } => {
                let Ok(mut last_line) = last_line.lock() else { return };
                if last_line.elapsed() >= PLAIN_INTERVAL && done < self.total {
                    *last_line = Instant::now();
                    self.plain_line(done, message);
                }
            }
        }
    }

    #[expect(clippy::print_stderr, reason = "this is the output module")]
    fn plain_line(&self, done: u64, message: &str) {
        let secs = self.started.elapsed().as_secs_f64();
        let separator = if message.is_empty() { "" } else { ", " };
        let left = seconds_left(done, self.before, self.total, secs);
        let left = left.map(|left| format!(" (about {left:.0} s left)")).unwrap_or_default();
        eprintln!("{}: {done}/{} after {secs:.1} s{left}{separator}{message}", self.label, self.total);
    }

    /// Ends the display and returns the seconds that the work took.
    pub fn finish(self) -> f64 {
        match &self.display {
            Display::Bar(bar) => bar.finish_and_clear(),
            Display::Plain { .. } => {
                let done = self.done.load(Ordering::Relaxed);
                self.plain_line(done, "done");
            }
        }
        self.started.elapsed().as_secs_f64()
    }
}

/// The seconds that the rest takes at the speed so far; `None` where nothing was done yet, or nothing is left.
fn seconds_left(done: u64, before: u64, total: u64, secs: f64) -> Option<f64> {
    let now = done.saturating_sub(before);
    let left = total.saturating_sub(done);
    (now > 0 && left > 0).then(|| secs * left as f64 / now as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_judged_by_what_was_done_since_the_start() {
        assert_eq!(seconds_left(25, 0, 100, 5.0), Some(15.0));
        assert_eq!(seconds_left(75, 50, 100, 5.0), Some(5.0), "work done before took none of this time");
        assert_eq!(seconds_left(50, 50, 100, 5.0), None);
        assert_eq!(seconds_left(100, 0, 100, 5.0), None);
    }
}
