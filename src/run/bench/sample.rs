//! One setting of a study: what it gives, and how long that takes.

use super::super::outcome::{Outcome, Status};
use super::super::ready;
use super::super::resume::Keeper;
use super::super::watch::{Watch, interrupted};
use crate::branch::{BranchKind, SpecialPoint};
use crate::continuation::Counts;
use crate::scene::{Variant, owner};
use cpu_time::ProcessTime;
use std::collections::BTreeMap;
use std::time::Instant;

/// Most runs of a setting that are timed,
const RUNS: usize = 5;
/// all together no longer than this many seconds, but for the last.
const LIMIT: f64 = 3.0;
/// A first run that takes so many seconds needs no other to warm up for, and counts.
const WARM: f64 = 0.5;

/// The numbers of a point.
#[derive(Clone)]
pub struct Numbers {
    /// With their printed errors.
    pub values: BTreeMap<String, (f64, Option<f64>)>,
    /// Of the system that the point solves; a motion has none that are solved for together.
    pub unknowns: Option<usize>,
    /// Work of all tasks.
    pub counts: Counts,
}

pub struct Sample {
    /// Or why there are none.
    pub numbers: Result<Numbers, String>,
    /// Of each timed run, from the scene to the numbers: building the model is part of it, files are not.
    pub taken: Vec<Taken>,
}

/// Seconds of one run.
#[derive(Clone, Copy)]
pub struct Taken {
    pub wall: f64,
    /// Of the processor, on all threads, where the system tells.
    pub processor: Option<f64>,
}

impl Sample {
    /// Runs the setting several times, the first time to warm up.
    pub fn timed(variant: &Variant) -> Self {
        let (numbers, first) = once(variant);
        let mut taken = Vec::new();
        if first.wall >= WARM || numbers.is_err() {
            taken.push(first);
        }
        let spent = |taken: &[Taken]| taken.iter().map(|run| run.wall).sum::<f64>();
        while numbers.is_ok() && taken.len() < RUNS && spent(&taken) < LIMIT && !interrupted() {
            taken.push(once(variant).1);
        }
        // Interrupted at once.
        if taken.is_empty() {
            taken.push(first);
        }
        Self { numbers, taken }
    }
}

/// The task that has the point.
pub fn task(variant: &Variant) -> String {
    let branch = variant.point.rsplit_once('/').map_or("", |(branch, _)| branch);
    owner(&variant.scene.tasks, branch).map_or(branch, |task| &task.name).to_owned()
}

/// One run, and its seconds.
pub fn once(variant: &Variant) -> (Result<Numbers, String>, Taken) {
    let (start, busy) = (Instant::now(), ProcessTime::try_now().ok());
    let computed = ready(&variant.scene, &[task(variant)])
        .and_then(|ready| Ok(ready.compute(&Keeper::idle(), &Watch::new(true, None), &|_| Ok(()))?));
    let wall = start.elapsed().as_secs_f64();
    let processor = busy.and_then(|busy| busy.try_elapsed().ok()).map(|busy| busy.as_secs_f64());
    let numbers = computed.map_err(|error| error.to_string()).and_then(|outcomes| numbers(&variant.point, &outcomes));
    (numbers, Taken { wall, processor })
}

fn numbers(label: &str, outcomes: &[Outcome]) -> Result<Numbers, String> {
    let branches = outcomes.iter().map(|outcome| &outcome.branch);
    let found = branches.flat_map(|branch| branch.points.iter().map(move |point| (branch.kind, point)));
    let Some((kind, point)) = found.clone().find(|(_, point)| point.label == label) else {
        let ends: Vec<String> = outcomes
            .iter()
            .map(|outcome| {
                let failed = if outcome.status == Status::Failed { "failed: " } else { "" };
                format!("{} {failed}{}", outcome.branch.name, outcome.reason)
            })
            .collect();
        return Err(format!("no {label} ({})", ends.join("; ")));
    };
    let mut counts = Counts::default();
    outcomes.iter().for_each(|outcome| counts += outcome.counts);
    let numbers = point.parameters.iter().chain(&point.values).filter(|(_, value)| value.is_finite());
    let printed = |name: &str| point.errors.get(name).copied().filter(|error| error.is_finite());
    let values = numbers.map(|(name, value)| (name.clone(), (*value, printed(name)))).collect();
    Ok(Numbers { values, unknowns: unknowns(kind, point), counts })
}

fn unknowns(kind: BranchKind, point: &SpecialPoint) -> Option<usize> {
    let solved = kind != BranchKind::Simulation;
    point.arrays.get("state").filter(|_| solved).map(|state| state.data.len())
}
