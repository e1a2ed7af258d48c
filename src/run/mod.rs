//! From a scene to files: the only place that knows all the others.

mod bench;
mod branch_curve;
mod calibration;
mod cycle_curve;
mod cycles;
mod describe;
mod diagram;
mod equilibria;
mod figures;
mod files;
mod fold_curve;
mod gallery;
mod hopf_curve;
mod hopf_surface;
mod import;
mod locus;
mod map;
mod outcome;
mod plan;
mod recorded;
mod resume;
mod simulate;
mod start;
mod stored_cycle;
mod study;
mod suite;
mod summary;
mod template;
mod watch;
mod wave;
mod written;

pub use bench::{Report, bench, check_study, studies};
pub use describe::{models, one_model};
pub use figures::redraw;
pub use gallery::{gallery, section};
pub use import::import;
pub use plan::plan;
pub use suite::{Case, folder as results_folder, store as store_cases, table as case_table};
pub use summary::{Expected, Summary};
pub use template::template;
pub use watch::INTERRUPTED;

use crate::branch::{Branch, StoreError};
use crate::plot::PlotError;
use crate::scene::{Fault, Place, Scene, SceneError, Task, TaskKind, is_file, owner};
use equilibria::Origin;
use files::Folder;
use outcome::{Outcome, Status};
use resume::Keeper;
use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::Instant;
use study::{Prepared, Study};
use thiserror::Error;
use watch::Watch;

/// What the command line adds to a scene.
#[derive(Clone, Debug)]
pub struct RunOptions {
    pub out: PathBuf,
    /// Tasks to run, with those that they start from; empty: all.
    pub only: Vec<String>,
    pub resume: bool,
    pub quiet: bool,
}

/// Why a run could not be done at all. That a task failed is part of the summary instead.
#[derive(Debug, Error)]
pub enum RunError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Plot(#[from] PlotError),
    #[error("{0}")]
    Input(String),
}

/// A scene that was checked against its model, ready to run.
struct Ready<'a> {
    scene: &'a Scene,
    study: Study,
    /// Tasks to run, in order.
    tasks: Vec<(&'a Task, Prepared)>,
}

fn ready<'a>(scene: &'a Scene, only: &[String]) -> Result<Ready<'a>, RunError> {
    let study = Study::new(scene)?;
    let names: Vec<&str> = scene.tasks.iter().map(|task| task.name.as_str()).collect();
    for name in only {
        if !names.contains(&name.as_str()) {
            let fault = Fault::unknown("task", name, names.iter().copied());
            return Err(RunError::Input(format!("{}: --only: {fault}", scene.path.display())));
        }
    }
    // A task brings along those that it starts from; they come before it.
    let mut wanted: BTreeSet<&str> = if only.is_empty() { names.iter().copied().collect() } else { BTreeSet::new() };
    wanted.extend(only.iter().map(String::as_str));
    for task in scene.tasks.iter().rev() {
        if let (Some((from, _)), true) = (task.kind.from(), wanted.contains(task.name.as_str())) {
            wanted.extend(owner(&scene.tasks, from).map(|task| task.name.as_str()));
        }
    }
    let mut tasks = Vec::new();
    for task in &scene.tasks {
        let prepared = study.prepare(scene, task)?;
        if let Some((from, at)) = task.kind.from() {
            match task.kind {
                // Any state will do.
                TaskKind::Simulate(_) => {}
                TaskKind::FoldCurve(_) => start::check_point(scene, (from, at), ("LP", "a fold"), "equilibria")?,
                TaskKind::BranchPointCurve(_) => {
                    start::check_point(scene, (from, at), ("BP", "a branch point"), "equilibria")?;
                }
                TaskKind::Equilibria(_) => start::check_equilibrium(scene, from, at)?,
                TaskKind::CycleCurve(kind, _) => start::check_point(scene, (from, at), kind.point(), "cycles")?,
                TaskKind::Cycles(ref cycles) if cycles.relative => start::check_relative(scene, &prepared, from, at)?,
                TaskKind::Cycles(_) if start::is_cycle(scene, from) => {}
                _ => start::check(scene, from, at)?,
            }
        }
        if let TaskKind::Calibration(fit) = &task.kind {
            calibration::check(scene, &study, fit)?;
        }
        if wanted.contains(task.name.as_str()) {
            tasks.push((task, prepared));
        }
    }
    figures::check(scene)?;
    Ok(Ready { scene, study, tasks })
}

/// Whether a scene can be run: its model, and all that its tasks and figures name.
pub fn check(scene: &Scene, only: &[String]) -> Result<(), RunError> {
    ready(scene, only).map(drop)
}

/// Runs a scene and writes everything; the summary says whether all went well.
pub fn run(scene: &Scene, options: &RunOptions) -> Result<Summary, RunError> {
    let start = Instant::now();
    let ready = ready(scene, &options.only)?;
    let folder = Folder::open(&options.out, &scene.name)?;
    let watch = Watch::new(options.quiet, scene.budget);
    let keeper = Keeper::new(folder.path("resume"), identity(scene), options.resume);
    if !options.resume {
        folder.clear(ready.tasks.iter().map(|(task, _)| task.name.as_str()));
        let diagrams = ready.tasks.iter().filter(|(task, _)| matches!(task.kind, TaskKind::Diagram(_)));
        diagrams.for_each(|(task, _)| folder.clear_parts(&task.name));
    }
    let outcomes = ready.compute(&keeper, &watch, &|branch| folder.write_branch(branch))?;
    let branches: Vec<Branch> = outcomes.iter().map(|outcome| outcome.branch.clone()).collect();
    let mut figures = Vec::new();
    for spec in figures::specs(scene, &branches, ready.study.picture_unit()) {
        match crate::plot::draw(&spec, &branches) {
            Ok(svg) => {
                folder.write_figure(&spec.name, &svg)?;
                figures.push(spec);
            }
            Err(error) => watch.warn(format!("not drawn: {error}")),
        }
    }
    let summary = Summary::new(scene, &outcomes, figures, start.elapsed().as_secs_f64());
    folder.write_json("summary.json", &summary)?;
    folder.write_log(&watch.finish())?;
    Ok(summary)
}

/// What results depend on: the program, the scene, wherever its file lies and however long it may take, and the files that
/// it starts from.
fn identity(scene: &Scene) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let written = Scene { path: PathBuf::new(), budget: None, ..scene.clone() };
    let mut hasher = DefaultHasher::new();
    for (from, _) in scene.tasks.iter().filter_map(|task| task.kind.from()).filter(|(from, _)| is_file(from)) {
        std::fs::read(scene.home().join(from)).ok().hash(&mut hasher);
    }
    format!("{version} {written:?} {:x}", hasher.finish())
}

impl Ready<'_> {
    /// Performs the tasks one after another; what each leaves is handed to `store` at once.
    fn compute(
        &self,
        keeper: &Keeper,
        watch: &Watch,
        store: &dyn Fn(&Branch) -> Result<(), StoreError>,
    ) -> Result<Vec<Outcome>, StoreError> {
        let home = self.scene.home();
        let mut outcomes: Vec<Outcome> = Vec::new();
        for (task, prepared) in &self.tasks {
            watch.task(&task.name);
            let mut found = match keeper.finished(&task.name) {
                Some(found) => found,
                None => perform((task, home), prepared, &outcomes, keeper, watch),
            };
            if found.iter().all(|outcome| outcome.status == Status::Done) {
                keeper.finish(&task.name, &found);
            }
            for outcome in &mut found {
                if let (Status::Interrupted, Some(spent)) = (outcome.status, watch.spent()) {
                    outcome.reason = spent;
                }
                watch.say(format!("{}: {:?}, {}", outcome.branch.name, outcome.status, outcome.reason));
                store(&outcome.branch)?;
            }
            let interrupted = found.iter().any(|outcome| outcome.status == Status::Interrupted);
            outcomes.extend(found);
            if interrupted {
                break;
            }
        }
        Ok(outcomes)
    }
}

/// `home` is the scene's folder, in which it may name files.
fn perform(
    (task, home): (&Task, &Path),
    prepared: &Prepared,
    before: &[Outcome],
    keeper: &Keeper,
    watch: &Watch,
) -> Vec<Outcome> {
    let points = || before.iter().flat_map(|outcome| &outcome.branch.points);
    let source = |label: &str| {
        points().find(|point| point.label == label).ok_or_else(|| {
            let found: Vec<&str> = points().map(|point| point.label.as_str()).collect();
            format!("there is no {label}; found were: {}", found.join(", "))
        })
    };
    let outcome = match &task.kind {
        TaskKind::Equilibria(equilibria) => match equilibria.from.as_ref().map(|(from, _)| source(from)).transpose() {
            Ok(from) => {
                let origin = from.map_or(Origin::Model, Origin::Point);
                equilibria::run(prepared, &task.name, equilibria, origin, watch)
            }
            Err(reason) => Outcome::failed(equilibria::empty(&task.name, equilibria), reason),
        },
        TaskKind::Cycles(cycles) if is_file(&cycles.from) => {
            let mesh = (cycles.intervals.unwrap_or(cycles::INTERVALS), cycles.degree);
            match recorded::cycle(&home.join(&cycles.from), &cycles.from, prepared, mesh) {
                Ok(from) => cycles::run(prepared, &task.name, cycles, &from, keeper, watch),
                Err(error) => Outcome::failed(cycles::empty(prepared, &task.name, cycles), error.to_string()),
            }
        }
        TaskKind::Diagram(wanted) => return diagram::run(prepared, &task.name, wanted, keeper, watch),
        TaskKind::Cycles(cycles) => match source(&cycles.from) {
            Ok(from) => cycles::run(prepared, &task.name, cycles, from, keeper, watch),
            Err(reason) => Outcome::failed(cycles::empty(prepared, &task.name, cycles), reason),
        },
        TaskKind::FoldCurve(curve) => match source(&curve.from) {
            Ok(from) => fold_curve::run(prepared, &task.name, curve, from, watch),
            Err(reason) => Outcome::failed(fold_curve::empty(prepared, &task.name, curve), reason),
        },
        TaskKind::BranchPointCurve(curve) => match source(&curve.from) {
            Ok(from) => branch_curve::run(prepared, &task.name, curve, from, watch),
            Err(reason) => Outcome::failed(branch_curve::empty(prepared, &task.name, curve), reason),
        },
        TaskKind::CycleCurve(kind, curve) => match source(&curve.from) {
            Ok(from) => cycle_curve::run(prepared, &task.name, (curve, *kind), from, watch),
            Err(reason) => Outcome::failed(cycle_curve::empty(prepared, &task.name, (curve, *kind)), reason),
        },
        TaskKind::Simulate(motion) => match motion.from.as_ref().map(|(from, _)| source(from)).transpose() {
            Ok(from) => simulate::run(prepared, &task.name, motion, from, watch),
            Err(reason) => Outcome::failed(simulate::empty(prepared, &task.name, motion), reason),
        },
        TaskKind::Map(map) => map::run(prepared, &task.name, map, watch),
        TaskKind::HopfCurve(curve) => match source(&curve.from) {
            Ok(from) => hopf_curve::run(prepared, &task.name, curve, from, watch),
            Err(reason) => Outcome::failed(hopf_curve::empty(prepared, &task.name, curve), reason),
        },
        TaskKind::Calibration(fit) => match source(&fit.from) {
            Ok(from) => calibration::run(prepared, &task.name, fit, from, watch),
            Err(reason) => Outcome::failed(calibration::empty(prepared, &task.name, fit), reason),
        },
        TaskKind::HopfSurface(surface) => match source(&surface.from) {
            Ok(from) => hopf_surface::run(prepared, &task.name, surface, from, watch),
            Err(reason) => Outcome::failed(hopf_surface::empty(prepared, &task.name, surface), reason),
        },
    };
    vec![outcome]
}

/// The place of a key of a task, for messages.
fn place(task: &Task, key: &str) -> Place {
    task.kind.along().places.get(key).cloned().unwrap_or_else(|| task.at.clone())
}
