//! What stands between a running task and the person who waits: progress, interruption, the log.

use indicatif::{ProgressBar, ProgressStyle};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Set by Ctrl-C; tasks stop after the current point.
pub static INTERRUPTED: AtomicBool = AtomicBool::new(false);

pub fn interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Progress and log of a run, and when it has to stop.
pub struct Watch {
    bar: ProgressBar,
    log: Mutex<Vec<String>>,
    start: Instant,
    /// Seconds that the run may take.
    budget: Option<f64>,
}

impl Watch {
    /// A bar on a terminal (indicatif hides it in a pipe), nothing if `quiet`.
    pub fn new(quiet: bool, budget: Option<f64>) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(1000) };
        if let Ok(style) = ProgressStyle::with_template("{prefix:>14} [{bar:30}] {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self { bar, log: Mutex::new(Vec::new()), start: Instant::now(), budget }
    }

    /// Whether tasks are to stop after the current point.
    pub fn stopped(&self) -> bool {
        interrupted() || self.spent().is_some()
    }

    /// That the budget is spent, in a sentence.
    pub fn spent(&self) -> Option<String> {
        let budget = self.budget.filter(|budget| self.start.elapsed().as_secs_f64() > *budget)?;
        Some(format!("the budget of {budget} s is spent"))
    }

    pub fn task(&self, name: &str) {
        self.bar.set_prefix(name.to_owned());
        self.bar.set_position(0);
        self.say(format!("task {name}"));
    }

    /// How much of the task is done, and where it is.
    pub fn at(&self, fraction: f64, message: String) {
        self.bar.set_position((1000.0 * fraction.clamp(0.0, 1.0)) as u64);
        self.say(message.clone());
        self.bar.set_message(message);
    }

    pub fn say(&self, line: String) {
        if let Ok(mut log) = self.log.lock() {
            log.push(format!("{:9.3} s  {line}", self.start.elapsed().as_secs_f64()));
        }
    }

    /// What whoever waits is to see at once.
    pub fn warn(&self, line: String) {
        self.bar.suspend(|| eprintln!("{line}"));
        self.say(line);
    }

    pub fn finish(&self) -> String {
        self.bar.finish_and_clear();
        self.log.lock().map(|log| log.join("\n") + "\n").unwrap_or_default()
    }
}
