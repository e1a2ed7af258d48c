//! A task of kind `calibration`: parameters in a box for which a Hopf point meets targets, looked for from several
//! starts, each solution with its sensitivity and errors.

mod report;

use super::equilibria::error;
use super::outcome::{Outcome, Status, labels};
use super::start::Stored;
use super::study::{Prepared, Study};
use super::watch::Watch;
use crate::bifurcation::{
    Analysis, Calibration, Coordinate, Fit, FitError, Hopf, HopfError, Lost, Place, Quantity, Target, Unknown,
};
use crate::branch::{Branch, Kind, SpecialPoint};
use crate::linalg::c64;
use crate::problem::{Problem, Refinement};
use crate::scene::{self, Scene, SceneError};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::Instant;
use thiserror::Error;

pub use report::empty;

#[derive(Debug, Error)]
enum CalibrationError {
    #[error("the start is not a Hopf point any more: {0}")]
    Start(#[from] HopfError),
    #[error("{0} is not stored with its eigenvector")]
    Incomplete(String),
    #[error("{0} at the start: nothing can be solved for a target that it does not have there")]
    NotFinite(String),
}

/// Solutions closer than this, in parts of the box, are one.
const SAME: f64 = 1e-5;
/// A target is met to this part of its size.
const MET: f64 = 1e-8;
/// Starts that are followed before progress is shown and an interruption is heeded.
const BATCH: usize = 8;

/// Refuses unknowns whose value in the scene, where the search begins, lies outside of their range.
pub fn check(scene: &Scene, study: &Study, task: &scene::Calibration) -> Result<(), SceneError> {
    let parameters = study.parameters();
    for (name, range) in task.unknowns() {
        let Some((_, value, ..)) = parameters.iter().find(|(known, ..)| known == name) else { continue };
        let slack = 1e-12 * (range.to - range.from);
        if *value < range.from - slack || *value > range.to + slack {
            let message = format!(
                "the start has {name} = {value}, which does not lie inside the range {} to {}; widen the range, or \
                 change {name} in [parameters]",
                range.from, range.to
            );
            return Err(scene.refuse(&range.at, message));
        }
    }
    Ok(())
}

pub fn run(prepared: &Prepared, name: &str, task: &scene::Calibration, from: &SpecialPoint, watch: &Watch) -> Outcome {
    let start = Instant::now();
    let branch = empty(prepared, name, task);
    let tool = Tool { prepared, task, watch };
    let mut outcome = match tool.solve(branch.clone(), from) {
        Ok(outcome) => outcome,
        Err(failure) => Outcome::failed(branch, failure.to_string()),
    };
    outcome.seconds = start.elapsed().as_secs_f64();
    outcome
}

/// A minimum of the sum of squares.
struct Solution {
    place: Place,
    analysis: Analysis,
    /// Whether every target is met.
    met: bool,
    /// From how many starts it was reached.
    starts: usize,
}

/// How a search from one start ended.
enum Search {
    Ended(Box<Fit>),
    Failed,
    Interrupted,
}

/// What all searches found.
#[derive(Default)]
struct Found {
    solutions: Vec<Solution>,
    searches: usize,
    /// Searches that ended where the Hopf point cannot be followed, or did not converge.
    failed: usize,
    /// Points of the box at which the Hopf point was asked for.
    evaluations: usize,
    interrupted: bool,
}

struct Tool<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Calibration,
    watch: &'a Watch,
}

impl Tool<'_> {
    fn solve(&self, mut branch: Branch, from: &SpecialPoint) -> Result<Outcome, CalibrationError> {
        let Stored { u, p, omega, q } =
            Stored::read(self.prepared, from).ok_or_else(|| CalibrationError::Incomplete(from.label.clone()))?;
        let first = self.prepared.first();
        let hopf = Hopf::locate(&*self.prepared.problem, (&u, &p), first, omega, &q)?;
        let calibration = self.calibration(&hopf)?;
        let origin = calibration.place(hopf)?;
        let mut found = self.search(&calibration, &origin);
        let (status, reason) = self.judge(&mut found, &origin);
        let refined = if self.task.along.errors { self.prepared.problem.refined() } else { None };
        let points: Vec<Result<SpecialPoint, HopfError>> = found
            .solutions
            .par_iter()
            .map(|solution| {
                let fine = refined.as_ref().and_then(|refined| self.refit(&calibration, &solution.place, refined));
                self.special(&calibration, (&solution.place, &solution.analysis), fine.as_ref())
            })
            .collect();
        for (row, point) in points.into_iter().enumerate() {
            let mut point = SpecialPoint { row, ..point? };
            let (short, label) = labels(&branch, Kind::UZ);
            point.label = label;
            if self.prepared.waves.contains(&point.label) {
                super::wave::of_mode(self.prepared, &mut point);
            }
            branch.rows.push(report::row(&branch, &point, short));
            branch.points.push(point);
        }
        let outcome = Outcome { branch, status, reason, seconds: 0.0, counts: Default::default() };
        Ok(outcome)
    }

    /// The scene's words as a problem; `hopf` gives a target of zero its scale.
    fn calibration(&self, hopf: &Hopf) -> Result<Calibration, CalibrationError> {
        let list = self.prepared.problem.parameters();
        let unknown = |(name, range): (&str, &scene::Range)| {
            let index = list.iter().position(|q| q.name == name)?;
            let logarithmic = self.task.along.logarithmic.iter().any(|known| known == name);
            let coordinate = Coordinate { index, logarithmic, width: 1.0 };
            Some(Unknown { coordinate, low: range.from, high: range.to })
        };
        let mut calibration = Calibration {
            problem: self.prepared.problem.clone(),
            free: self.prepared.first(),
            unknowns: self.task.unknowns().into_iter().filter_map(unknown).collect(),
            targets: Vec::new(),
        };
        for wanted in &self.task.targets {
            let quantity = quantity(&wanted.quantity);
            let here = calibration.quantity(hopf, quantity)?;
            if !here.is_finite() {
                return Err(CalibrationError::NotFinite(wanted.quantity.clone()));
            }
            let sizes = [wanted.value.abs(), here.abs(), 1.0];
            let size = sizes.into_iter().find(|size| *size > 0.0).unwrap_or(1.0);
            let scale = wanted.sigma.unwrap_or(size);
            calibration.targets.push(Target { quantity, value: wanted.value, scale });
        }
        Ok(calibration)
    }

    /// Local fits from the scene's own values and from points spread evenly over the box.
    fn search(&self, calibration: &Calibration, origin: &Place) -> Found {
        let mut found = Found::default();
        let m = origin.x.len();
        let starts: Vec<Vec<f64>> =
            std::iter::once(origin.x.clone()).chain((1..self.task.starts).map(|k| halton(k, m))).collect();
        for batch in starts.chunks(BATCH) {
            if self.watch.stopped() {
                found.interrupted = true;
                break;
            }
            let searches: Vec<Search> =
                batch.par_iter().map(|start| from_start(calibration, origin, start, self.watch)).collect();
            for search in searches {
                found.searches += 1;
                match search {
                    Search::Ended(fit) => {
                        found.evaluations += fit.evaluations;
                        self.add(&mut found, calibration, *fit);
                    }
                    Search::Failed => found.failed += 1,
                    Search::Interrupted => found.interrupted = true,
                }
            }
            let message = format!("{} starts, {} solutions", found.searches, found.solutions.len());
            self.watch.at(found.searches as f64 / starts.len() as f64, message);
        }
        found
    }

    fn add(&self, found: &mut Found, calibration: &Calibration, fit: Fit) {
        let same = |a: &Place| a.x.iter().zip(&fit.place.x).all(|(a, b)| (a - b).abs() <= SAME);
        if let Some(known) = found.solutions.iter_mut().find(|known| same(&known.place)) {
            known.starts += 1;
            return;
        }
        let Ok(analysis) = calibration.analysis(&fit.place) else {
            found.failed += 1;
            return;
        };
        let met =
            analysis.residuals.iter().zip(&self.task.targets).zip(&calibration.targets).all(|((r, wanted), t)| {
                let size = if wanted.value != 0.0 { wanted.value.abs() } else { t.scale };
                r.abs() <= MET * size
            });
        // Where the Hopf point cannot be followed further there may be something better beyond.
        if !fit.minimal && !met {
            found.failed += 1;
            return;
        }
        found.solutions.push(Solution { place: fit.place, analysis, met, starts: 1 });
    }

    /// Sorts and selects the solutions, and says what they are.
    fn judge(&self, found: &mut Found, origin: &Place) -> (Status, String) {
        let distance = |s: &Solution| -> f64 { s.place.x.iter().zip(&origin.x).map(|(a, b)| (a - b).powi(2)).sum() };
        let misfit = |s: &Solution| if s.met { 0.0 } else { rounded(s.analysis.chi2) };
        found.solutions.sort_by(|a, b| {
            misfit(a)
                .total_cmp(&misfit(b))
                .then(distance(a).total_cmp(&distance(b)))
                .then(a.place.x[0].total_cmp(&b.place.x[0]))
        });
        let solved_exactly = self.task.targets.len() == self.task.unknowns().len();
        let all = found.solutions.len();
        let any_met = found.solutions.first().is_some_and(|best| best.met);
        let mut worse = 0;
        if any_met {
            worse = found.solutions.iter().filter(|s| !s.met).map(|s| s.starts).sum();
            found.solutions.retain(|s| s.met);
        } else if solved_exactly {
            found.solutions.truncate(1);
        }
        let mut notes = vec![format!("{} starts, {} evaluations", found.searches, found.evaluations)];
        if worse > 0 {
            notes.push(format!("from {worse} the targets are not met"));
        }
        if found.failed > 0 {
            notes.push(format!("from {} the Hopf point could not be followed to a minimum", found.failed));
        }
        let notes = notes.join("; ");
        let Some(best) = found.solutions.first() else {
            let status = if found.interrupted { Status::Interrupted } else { Status::Failed };
            return (status, format!("no minimum was found ({notes})"));
        };
        let names = self.task.unknowns();
        let name = |i: &usize| names[*i].0;
        let (status, said) = if let Some(idle) = best.analysis.idle.first() {
            (Status::Failed, format!("{} changes none of the targets", name(idle)))
        } else if best.met && best.analysis.condition.is_none() && all > 1 {
            let which = names.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
            (Status::Failed, format!("the targets do not determine {which}: solutions are not isolated"))
        } else if solved_exactly && !best.met {
            (Status::Failed, format!("no point of the box meets the targets; closest is {}", self.closest(best)))
        } else {
            let count = found.solutions.len();
            let what = match (any_met, count) {
                (true, 1) => "1 solution".to_owned(),
                (true, _) => format!("{count} solutions"),
                (false, 1) => "1 minimum".to_owned(),
                (false, _) => format!("{count} minima"),
            };
            let held: Vec<String> = best.analysis.held.iter().map(|i| self.at_end(best, *i)).collect();
            let held = if held.is_empty() { String::new() } else { format!(" with {}", held.join(", ")) };
            (Status::Done, format!("{what} in the box{held}"))
        };
        if status == Status::Failed {
            found.solutions.truncate(1);
        }
        let status = if found.interrupted { Status::Interrupted } else { status };
        (status, format!("{said} ({notes})"))
    }

    /// "p = 380 (wanted 450), with s0 = 20, the end of its range".
    fn closest(&self, best: &Solution) -> String {
        let missed = self.task.targets.iter().zip(&best.analysis.residuals);
        let missed: Vec<String> =
            missed.map(|(t, r)| format!("{} = {:.6} (wanted {})", t.quantity, t.value + r, t.value)).collect();
        let held: Vec<String> = best.analysis.held.iter().map(|i| self.at_end(best, *i)).collect();
        let held = if held.is_empty() { String::new() } else { format!(", with {}", held.join(", ")) };
        format!("{}{held}", missed.join(", "))
    }

    fn at_end(&self, solution: &Solution, i: usize) -> String {
        let (name, range) = self.task.unknowns()[i];
        let end = if solution.place.x[i] > 0.5 { range.to } else { range.from };
        format!("{name} at the end of its range, {end}")
    }

    /// The numbers of the same solution on the refined discretisation.
    fn refit(&self, calibration: &Calibration, place: &Place, refined: &Refinement) -> Option<BTreeMap<String, f64>> {
        let fine = Calibration { problem: refined.problem.clone(), ..calibration.clone() };
        let hopf = &place.hopf;
        let part = |f: fn(&c64) -> f64| (refined.prolong)(&hopf.q.iter().map(f).collect::<Vec<_>>());
        let q: Vec<c64> = part(|z| z.re).iter().zip(part(|z| z.im)).map(|(&re, im)| c64::new(re, im)).collect();
        let u = (refined.prolong)(&hopf.u);
        let hopf = Hopf::locate(&*refined.problem, (&u, &hopf.p), fine.free, hopf.omega, &q).ok()?;
        let fit = fine.fit(&fine.place(hopf).ok()?, &|| self.watch.stopped()).ok()?;
        self.numbers(&fine, &fit.place, &fine.analysis(&fit.place).ok()?).ok()
    }
}

/// Follows the Hopf point to a start and fits from there, or from as far as it came.
fn from_start(calibration: &Calibration, origin: &Place, start: &[f64], watch: &Watch) -> Search {
    let place = match calibration.reach(origin, start) {
        Ok(place) => place,
        Err(Lost { last, .. }) => *last,
    };
    match calibration.fit(&place, &|| watch.stopped()) {
        Ok(fit) => Search::Ended(Box::new(fit)),
        Err(FitError::Interrupted) => Search::Interrupted,
        Err(FitError::Slow(_) | FitError::Failed(_)) => Search::Failed,
    }
}

/// Point k of the sequence of Halton (1960, doi:10.1007/BF01386213): evenly spread in the unit box, however many there are.
fn halton(k: usize, dimension: usize) -> Vec<f64> {
    const PRIMES: [usize; 8] = [2, 3, 5, 7, 11, 13, 17, 19];
    let inverse = |base: usize| {
        let (mut k, mut x, mut unit) = (k, 0.0, 1.0);
        while k > 0 {
            unit /= base as f64;
            x += unit * (k % base) as f64;
            k /= base;
        }
        x
    };
    PRIMES.iter().take(dimension).map(|&base| inverse(base)).collect()
}

/// To seven digits, so that equal minima compare as equal.
fn rounded(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let unit = 10.0_f64.powf(x.log10().floor() - 6.0);
    (x / unit).round() * unit
}

fn quantity(name: &str) -> Quantity {
    match name {
        "omega" => Quantity::Omega,
        "frequency" => Quantity::Frequency,
        "lyapunov" => Quantity::Lyapunov,
        "dsigma_re" => Quantity::SlopeRe,
        "dsigma_im" => Quantity::SlopeIm,
        _ => Quantity::Parameter,
    }
}
