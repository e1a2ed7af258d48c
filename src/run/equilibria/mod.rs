//! A task of kind `equilibria`: the branch, user values, folds, eigenvalue branches, Hopf points, their errors.

mod begin;
mod describe;
mod values;
mod walk;

use super::outcome::{Outcome, Status, joined, labels};
use super::study::Prepared;
use super::watch::Watch;
use super::wave;
use crate::bifurcation::{Equilibria, Mark, Reach, Sample, Spectra, branch_points, folds, leading};
use crate::branch::{Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Failure, Point, Stop};
use crate::linalg::{c64, growth};
use crate::problem::Problem;
use crate::scene;
use begin::{BeginError, begin};
pub use begin::{Origin, given, guessed};
use describe::{describe, estimate, observe};
use rayon::prelude::*;
use std::time::Instant;
use values::user_values;
use walk::{Walked, Wanted, walk};

pub use describe::{SCATTER, error};

/// Numbers of special points that are neither observables nor eigenvalues.
pub const VALUES: [&str; 12] = [
    "omega",
    "frequency",
    "lyapunov",
    "dsigma_re",
    "dsigma_im",
    "growth",
    "condition",
    "lp_a",
    "lp_b",
    "bp_b",
    "bp_c",
    "bp_d",
];

/// Runs the task; numerical trouble ends up in the outcome's status and reason.
pub fn run(prepared: &Prepared, name: &str, task: &scene::Equilibria, origin: Origin, watch: &Watch) -> Outcome {
    let start = Instant::now();
    let branch = empty(name, task);
    let mut counts = Counts::default();
    let mut outcome = match follow(prepared, branch.clone(), task, origin, watch, &mut counts) {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::failed(branch, failure.to_string()),
    };
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome.counts = counts;
    outcome
}

/// A branch without rows.
pub fn empty(name: &str, task: &scene::Equilibria) -> Branch {
    Branch::new(name, BranchKind::Equilibria, vec![task.along.free.clone()], Vec::new())
}

fn follow(
    prepared: &Prepared,
    mut branch: Branch,
    task: &scene::Equilibria,
    origin: Origin,
    watch: &Watch,
    counts: &mut Counts,
) -> Result<Outcome, BeginError> {
    let along = &task.along;
    let detects = |kind: &str| task.detect.iter().any(|known| known == kind);
    let (mut system, first) = begin(prepared, task, origin, counts)?;
    let bounds = bounds(prepared, task);
    let still = system.clone();
    let inside = |point: &Point| bounds.iter().all(|&(i, low, high)| (low..=high).contains(&observe(&still, point, i)));
    let wanted = Wanted { along, signed: detects("BP"), inside: &inside };
    let Walked { points, signs, back, stop } = walk(&mut system, first, wanted, watch, counts);
    let mut samples: Vec<Sample> = points.into_iter().map(|point| Sample::new(point, None)).collect();
    let mark = |stop: &Stop| Some(if matches!(stop, Stop::Stagnation { .. }) { Mark::Stuck } else { Mark::End });
    if let Some(last) = samples.last_mut() {
        last.mark = mark(&stop);
    }
    if let Some(first) = samples.first_mut() {
        first.mark = back.as_ref().map_or(Some(Mark::End), mark);
    }
    if detects("BP") {
        branch_points(&system, &mut samples, &signs, counts).into_iter().for_each(|doubt| watch.say(doubt));
    }
    // A search that fails leaves a gap in what was found, not in the branch.
    let mut failures: Vec<Failure> = Vec::new();
    if detects("LP") {
        failures.extend(folds(&system, &mut samples, counts).err());
    }
    // After the folds: next to one the parameter takes a value twice within a step.
    failures.extend(user_values(&system, &along.values, &mut samples, counts).err());
    let hopf = detects("HB");
    // Detection alone needs the eigenvalues that may cross, not columns for them.
    let wanted = if hopf { task.spectrum.max(4) } else { task.spectrum };
    let stopped = || watch.stopped();
    let tool = (wanted > 0).then(|| Spectra::new(&system, wanted, &stopped, &mut samples, counts));
    let spectra = tool.and_then(|tool| tool.map_err(|failure| failures.push(failure)).ok());
    if let Some(tool) = &spectra {
        let mut search = || {
            tool.follow(&mut samples, counts)?;
            if hopf {
                tool.hopf_points(&mut samples, counts).into_iter().for_each(|doubt| watch.say(doubt));
            }
            if task.spectrum > 0 { tool.smooth(&mut samples, counts) } else { Ok(()) }
        };
        failures.extend(search().err());
    }
    // What there was no time for is left out at the end.
    let stop = if watch.stopped() { Stop::Interrupted } else { stop };
    if let Some(last) = samples.last_mut() {
        last.mark.get_or_insert(Mark::End);
    }
    let reach = spectra.as_ref().and_then(|tool| tool.reach);
    if let Some(reach) = reach.filter(|reach| reach.complete) {
        watch.say(format!("{}: {}", branch.name, checked(reach)));
    }
    rows(prepared, &system, task, &samples, &mut branch);
    let marked: Vec<(usize, &Sample, Kind)> = (samples.iter().enumerate())
        .filter_map(|(row, sample)| Some((row, sample, kind(sample.mark.as_ref()?))))
        .collect();
    for &(row, _, kind) in &marked {
        let (short, label) = labels(&branch, kind);
        branch.rows[row].label = Some(short);
        branch.points.push(SpecialPoint::new(label, kind, row));
    }
    let confirmed = branch.points.par_iter_mut().zip(&marked).map(|(point, &(row, sample, _))| {
        let drawn = prepared.waves.contains(&point.label);
        describe(prepared, &system, sample, spectra.as_ref().filter(|_| drawn), point);
        let mut found = true;
        if along.errors && !watch.stopped() {
            let neighbours = (samples.get(row.wrapping_sub(1)), samples.get(row + 1));
            found = estimate(prepared, &system, sample, neighbours, spectra.as_ref(), point);
        }
        if drawn {
            wave::of_mode(prepared, point);
        }
        found
    });
    let confirmed: Vec<bool> = confirmed.collect();
    let up = stop.to_string();
    let (mut status, mut reason) = match &back {
        Some(back) => joined([(status(back), &back.to_string()), (status(&stop), &up)]),
        None => (status(&stop), up),
    };
    for failure in failures {
        if status == Status::Done {
            status = Status::Failed;
        }
        reason += &format!("; what was looked for is not complete: {failure}");
    }
    if let Some(reach) = reach.filter(|reach| !reach.complete) {
        reason += &format!("; {}", checked(reach));
    }
    let lost: Vec<&str> = branch
        .points
        .iter()
        .zip(confirmed)
        .filter(|(_, found)| !found)
        .map(|(point, _)| point.label.as_str())
        .collect();
    if !lost.is_empty() {
        reason += &format!("; not found on a finer discretisation, so not to be trusted: {}", lost.join(", "));
    }
    Ok(Outcome { branch, status, reason, seconds: 0.0, counts: *counts })
}

/// How a way that ended so went.
fn status(stop: &Stop) -> Status {
    match stop {
        Stop::Interrupted => Status::Interrupted,
        Stop::Stagnation { .. } => Status::Failed,
        Stop::RangeEnd | Stop::BoxEnd | Stop::Closed | Stop::MaxPoints => Status::Done,
    }
}

/// What is known of a large problem's eigenvalues on the imaginary axis, of which some are computed only.
fn checked(Reach { covered, bound, complete }: Reach) -> String {
    match bound {
        Some(bound) if complete => {
            format!(
                "no eigenvalue on the imaginary axis was missed: discs cover it up to {bound:.3e}, and none is higher"
            )
        }
        Some(bound) => format!(
            "eigenvalues on the imaginary axis are sure to be found up to {covered:.3e} only, and may lie as high as \
             {bound:.3e}; a larger spectrum covers more"
        ),
        None => format!(
            "eigenvalues on the imaginary axis are sure to be found up to {covered:.3e} only (M is not symmetric and \
             diagonally dominant, so that there is no bound); a larger spectrum covers more"
        ),
    }
}

/// Observables with the bounds in which the branch is followed.
fn bounds(prepared: &Prepared, task: &scene::Equilibria) -> Vec<(usize, f64, f64)> {
    let list = prepared.problem.observables();
    let of = |(name, range): &(String, scene::Range)| {
        list.iter().position(|o| o.name == name).map(|i| (i, range.from, range.to))
    };
    task.bounds.iter().filter_map(of).collect()
}

/// The name under which a mark is stored.
fn kind(mark: &Mark) -> Kind {
    match mark {
        Mark::End => Kind::EP,
        Mark::Stuck => Kind::MX,
        Mark::User => Kind::UZ,
        Mark::Fold(_) => Kind::LP,
        Mark::Branch(_) => Kind::BP,
        Mark::Hopf(_) => Kind::HB,
        Mark::Exceptional(mean) if mean.im > 0.0 && growth(*mean) == 0.0 => Kind::KC,
        Mark::Exceptional(_) => Kind::XP,
    }
}

fn rows(prepared: &Prepared, system: &Equilibria, task: &scene::Equilibria, samples: &[Sample], branch: &mut Branch) {
    let column = |name: &str, unit: &str| Column { name: name.to_owned(), unit: unit.to_owned() };
    let observables = prepared.problem.observables();
    branch.columns.push(column(&prepared.free_name, &prepared.free_unit));
    if system.coordinate.logarithmic {
        branch.columns.push(column(&format!("log10 {}", prepared.free_name), ""));
    }
    for &i in &prepared.observables {
        branch.columns.push(column(observables[i].name, observables[i].unit));
    }
    let followed = task.spectrum > 0 && samples.iter().all(|sample| !sample.followed.is_empty());
    let shown = if followed { leading(samples, task.spectrum) } else { Vec::new() };
    let (rate, turn) = rates(prepared.problem.time_unit());
    for k in 1..=shown.len() {
        branch.columns.push(column(&format!("re_{k}"), &rate));
        branch.columns.push(column(&format!("im_{k}"), &turn));
    }
    for sample in samples {
        let lambda = sample.point.lambda;
        let mut values = vec![Some(system.coordinate.value(lambda))];
        values.extend(system.coordinate.logarithmic.then_some(Some(lambda)));
        values.extend(prepared.observables.iter().map(|&i| Some(observe(system, &sample.point, i))));
        for &k in &shown {
            values.extend([Some(sample.followed[k].re), Some(sample.followed[k].im)]);
        }
        values.iter_mut().for_each(|value| *value = value.filter(|value| value.is_finite()));
        let on_axis = matches!(sample.mark.as_ref().map(kind), Some(Kind::HB | Kind::KC | Kind::BP | Kind::LP));
        // Undamped oscillations do not grow.
        let bounded = |sigma: &c64| growth(*sigma) < 0.0 || growth(*sigma) == 0.0 && sigma.im != 0.0;
        let stable = sample.values.first().filter(|_| !on_axis).map(bounded);
        branch.rows.push(Row { label: None, stable, values });
    }
}

/// The unit of frequencies.
pub fn frequency(time: &str) -> String {
    match time {
        "" => String::new(),
        "s" => "Hz".to_owned(),
        other => format!("1/{other}"),
    }
}

/// Units of growth rates and angular frequencies.
pub fn rates(time: &str) -> (String, String) {
    if time.is_empty() { (String::new(), "rad".to_owned()) } else { (format!("1/{time}"), format!("rad/{time}")) }
}
