//! What is kept while a run goes on, so that `--resume` completes it to the same numbers.
//!
//! One file per task in `resume/`: the outcome of a finished task, or the state of the walk after its last point. Each
//! is written whole or not at all, so that a kill at any moment leaves the one before.

use super::cycles::Place;
use super::outcome::{Outcome, Status};
use crate::branch::{Branch, write_atomically};
use crate::continuation::{Counts, WalkState};
use crate::orbit::Orbit;
use crate::orbit::bifurcations::{Passage, Signs};
use serde::{Deserialize, Serialize};
use std::cell::Cell;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A branch of cycles in the middle.
#[derive(Serialize, Deserialize)]
pub struct Checkpoint {
    pub branch: Branch,
    /// The orbit that the system referred its phase to at the last point.
    pub orbit: Orbit,
    pub walk: WalkState,
    /// Where the factors that errors are found with are from.
    pub refined: Option<Place>,
    pub counts: Counts,
    pub seconds: f64,
    /// How the first of two ways ended, if this is the second.
    pub behind: Option<(Status, String)>,
    /// The stretch of the free parameter in which bifurcations could not be looked for.
    pub blind: Option<(f64, f64)>,
    /// Test functions at the last point, and what the last ones say of a homoclinic end.
    pub signs: Option<Signs>,
    pub passages: Vec<Passage>,
}

#[derive(Serialize, Deserialize)]
enum State {
    Midway(Box<Checkpoint>),
    /// One branch, or those of a diagram.
    Finished(Vec<Outcome>),
}

#[derive(Serialize, Deserialize)]
struct Kept {
    /// The program, the resolved scene and the files it names: a state is good only for what it came from.
    scene: String,
    state: State,
}

/// Keeps states no more often than this; a kill loses no more work.
const INTERVAL: Duration = Duration::from_millis(500);

/// Reads and writes the states of one run.
pub struct Keeper {
    /// None: nothing is kept.
    folder: Option<PathBuf>,
    scene: String,
    resuming: bool,
    last: Cell<Instant>,
}

impl Keeper {
    pub fn new(folder: PathBuf, scene: String, resuming: bool) -> Self {
        Self { folder: Some(folder), scene, resuming, last: Cell::new(Instant::now()) }
    }

    /// One that keeps nothing.
    pub fn idle() -> Self {
        Self { folder: None, scene: String::new(), resuming: false, last: Cell::new(Instant::now()) }
    }

    fn path(&self, task: &str) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(format!("{task}.json")))
    }

    fn read(&self, task: &str) -> Option<State> {
        if !self.resuming {
            return None;
        }
        let text = std::fs::read(self.path(task)?).ok()?;
        let kept: Kept = serde_json::from_slice(&text).ok()?;
        (kept.scene == self.scene).then_some(kept.state)
    }

    /// The outcomes of a task that was finished before.
    pub fn finished(&self, task: &str) -> Option<Vec<Outcome>> {
        match self.read(task)? {
            State::Finished(outcomes) => Some(outcomes),
            State::Midway(_) => None,
        }
    }

    /// The state of a task that was left in the middle.
    pub fn load(&self, task: &str) -> Option<Checkpoint> {
        match self.read(task)? {
            State::Midway(checkpoint) => Some(*checkpoint),
            State::Finished(_) => None,
        }
    }

    /// Whether the last state is old enough to be replaced.
    pub fn due(&self) -> bool {
        self.folder.is_some() && self.last.get().elapsed() >= INTERVAL
    }

    /// Keeps the state of a task: its branch must hold all rows up to where the walk is. Failure to write is no reason
    /// to stop: the run itself goes on.
    pub fn keep(&self, checkpoint: Checkpoint) {
        let task = checkpoint.branch.name.clone();
        self.write(&task, State::Midway(Box::new(checkpoint)));
        self.last.set(Instant::now());
    }

    pub fn finish(&self, task: &str, outcomes: &[Outcome]) {
        if self.folder.is_some() {
            self.write(task, State::Finished(outcomes.to_vec()));
        }
    }

    fn write(&self, task: &str, state: State) {
        let Some(path) = self.path(task) else { return };
        let kept = Kept { scene: self.scene.clone(), state };
        let _ = write_atomically(&path, |file| serde_json::to_writer(file, &kept).map_err(std::io::Error::from));
    }
}
