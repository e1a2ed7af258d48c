//! What a motion settles on: a steady state, a cycle, a closed curve of returns, or nothing that can be named.

use super::drift::Drift;
use super::form::norm;
use super::integrate::{Control, Course, Motion, Step, integrate};
use super::returns::{Range, Return, Returns, observe};
use super::{Ring, SimulateError};
use crate::continuation::Counts;
use crate::problem::Problem;
use std::ops::ControlFlow;

/// What is looked for, and how long.
#[derive(Clone, Debug)]
pub struct Search<'a> {
    pub observables: &'a [usize],
    /// Whether anything is looked for.
    pub recognise: bool,
    /// Whether the motion ends where a cycle is recognised.
    pub stop: bool,
    /// Whether errors are estimated by another run, with ten times the tolerance.
    pub errors: bool,
}

/// A cycle that a motion has settled on.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    pub period: f64,
    /// Largest and smallest value of each observable.
    pub ranges: Vec<Range>,
    /// Of the period, then of each observable's largest and smallest value: what successive returns, and a run with
    /// ten times the tolerance if one was wanted, differ by.
    pub errors: Vec<f64>,
    /// A state on it, and when the motion was there.
    pub at: Vec<f64>,
    pub time: f64,
    /// Crossings of the section in one period.
    pub crossings: usize,
}

/// What was recognised.
#[derive(Clone, Debug, PartialEq)]
pub enum Attractor {
    /// At the last rate it would take more than ten of such motions to move by the error allowed.
    Steady,
    Cycle(Box<Cycle>),
    /// The returns fill a closed curve: the motion looks quasi-periodic. That it is not periodic with a long period, no
    /// finite time can show.
    Torus(Ring),
    /// Returns neither repeat nor fill a curve, within the time given.
    Open {
        returns: usize,
    },
    /// Nothing was looked for.
    Unknown,
}

/// A motion's end, and what it settled on.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    pub last: Motion,
    pub attractor: Attractor,
    /// Largest and smallest values of the observables: over the cycle, or over the later half of the returns.
    pub ranges: Vec<Range>,
}

/// What is left to a cycle, in parts of its size and of the tolerance.
const SETTLED: f64 = 10.0;
/// Returns that no longer approach each other differ by the integrator's errors: this much of its tolerance.
const NOISE: f64 = 1000.0;
/// The most crossings of the section in one period.
const CROSSINGS: usize = 8;
/// Returns that must agree without approaching each other.
const AGREEING: usize = 8;
/// Speed times the whole time that counts as rest, in parts of the tolerance and the motion's size.
const RESTING: f64 = 100.0;

/// Integrates and says what the motion settled on; `see` sees every step.
pub fn settle(
    problem: &dyn Problem,
    start: &[f64],
    (course, control): (&Course, &Control),
    search: &Search,
    counts: &mut Counts,
    see: &mut dyn FnMut(&Step) -> ControlFlow<()>,
) -> Result<Settled, SimulateError> {
    let parameters = |t: f64| course.parameters(t);
    let mut returns = Returns::new(problem, &parameters, search.observables, course.to - course.from);
    let mut size = norm(start);
    let mut found: Option<Cycle> = None;
    let last = integrate(problem, start, course, control, counts, &mut |step| {
        size = size.max(norm(&step.to.u));
        let flow = see(step);
        if search.recognise && returns.step(step) {
            let kept = found.take().filter(|cycle| repeats(&returns.list, cycle.crossings, control));
            found = recognise(&returns.list, control, size).or(kept);
        }
        if found.is_some() && search.stop { ControlFlow::Break(()) } else { flow }
    })?;
    if !search.recognise {
        return Ok(Settled { last, attractor: Attractor::Unknown, ranges: Vec::new() });
    }
    if let Some(mut cycle) = found {
        if search.errors {
            compare(problem, (course, control), search, &mut cycle, counts);
        }
        let ranges = cycle.ranges.clone();
        return Ok(Settled { last, attractor: Attractor::Cycle(Box::new(cycle)), ranges });
    }
    // The later half: what is left of the way there is shorter.
    let late = &returns.list[returns.list.len() / 2..];
    let here = |&i: &usize| {
        let value = observe(problem, &parameters, i, &last);
        Range { max: value, min: value }
    };
    let mut ranges: Vec<Range> = search.observables.iter().map(here).collect();
    if norm(&last.v) * (course.to - course.from) <= RESTING * control.tolerance * size {
        return Ok(Settled { last, attractor: Attractor::Steady, ranges });
    }
    for lap in late {
        ranges.iter_mut().zip(&lap.ranges).for_each(|(range, lap)| {
            *range = Range { max: range.max.max(lap.max), min: range.min.min(lap.min) };
        });
    }
    let points: Vec<&[f64]> = late.iter().map(|at| at.u.as_slice()).collect();
    let ring = Ring::of(&points, NOISE * (control.tolerance + control.absolute) * size);
    let attractor = ring.map_or(Attractor::Open { returns: returns.list.len() }, Attractor::Torus);
    Ok(Settled { last, attractor, ranges })
}

/// Whether the last return is as close to the one `q` before it as errors of the integrator let it be.
fn repeats(list: &[Return], q: usize, control: &Control) -> bool {
    let Some(k) = list.len().checked_sub(1).filter(|k| *k >= q) else { return false };
    let extent = list[k + 1 - q..].iter().map(|lap| lap.extent).fold(0.0, f64::max);
    gap(list, k, q) <= 0.1 * NOISE * control.tolerance.max(control.absolute) * extent
}

/// The distance of a return from the one `q` before it.
fn gap(list: &[Return], k: usize, q: usize) -> f64 {
    let apart: Vec<f64> = list[k].u.iter().zip(&list[k - q].u).map(|(a, b)| a - b).collect();
    norm(&apart)
}

/// A cycle, if the last returns repeat.
fn recognise(list: &[Return], control: &Control, size: f64) -> Option<Cycle> {
    let allowed = control.tolerance.max(control.absolute);
    for q in 1..=CROSSINGS {
        let k = list.len().checked_sub(1).filter(|k| *k >= 3 * q)?;
        let extent = list[k + 1 - q..].iter().map(|lap| lap.extent).fold(0.0, f64::max);
        if extent <= NOISE * control.absolute * size {
            continue;
        }
        // What repeats after fewer crossings already, but for the integrator's errors, goes round several times in q.
        let noise = NOISE * allowed * extent;
        if (1..q).any(|fewer| q % fewer == 0 && gap(list, k, fewer) <= noise) {
            continue;
        }
        let gap = |k: usize| gap(list, k, q);
        let (now, before) = (gap(k), gap(k - q));
        let ratio = if before > 0.0 { now / before } else { 0.0 };
        let left = if ratio < 1.0 { now * ratio / (1.0 - ratio) } else { f64::INFINITY };
        let settled = ratio < 0.9 && left <= SETTLED * allowed * extent && now <= NOISE * allowed * extent;
        let enough = k >= 2 * q + AGREEING;
        let agree = || {
            let gaps: Vec<f64> = (k - AGREEING..=k).map(gap).collect();
            let (first, second) = gaps.split_at(gaps.len() / 2);
            let most = |gaps: &[f64]| gaps.iter().copied().fold(0.0, f64::max);
            most(&gaps) <= 0.1 * NOISE * allowed * extent && most(second) <= 3.0 * most(first)
        };
        if settled || enough && agree() {
            let drift = Drift::of(list, q);
            // Several laps together would repeat no better: the motion is still on its way.
            let arrived = drift.is_none_or(|drift| drift.distance() <= SETTLED * allowed * extent);
            // Returns that converge differ by what is left; those that only agree, by errors of the integrator.
            let laps = if settled { 1 } else { AGREEING.min(k / q - 1) };
            return arrived.then(|| measured(list, (q, laps), drift));
        }
    }
    None
}

/// The last lap of `q` returns as a cycle; its errors are what the `laps` before differ by from it, or what is left of a
/// drift.
fn measured(list: &[Return], (q, laps): (usize, usize), drift: Option<Drift>) -> Cycle {
    let k = list.len() - 1;
    let last = &list[k];
    let lap = |k: usize| list[k].t - list[k - q].t;
    let range = |k: usize, o: usize| {
        let laps = list[k + 1 - q..=k].iter().map(|lap| lap.ranges[o]);
        let nothing = Range { max: f64::NEG_INFINITY, min: f64::INFINITY };
        laps.fold(nothing, |a, b| Range { max: a.max.max(b.max), min: a.min.min(b.min) })
    };
    let error = |value: &dyn Fn(usize) -> f64| {
        let apart = |laps: usize| (value(k) - value(k - laps * q)).abs();
        match drift {
            Some(drift) => apart(1).max(apart(drift.laps) * drift.left()),
            None => (1..=laps).map(apart).fold(0.0, f64::max),
        }
    };
    let mut errors = vec![error(&lap)];
    for o in 0..last.ranges.len() {
        errors.extend([error(&|k| range(k, o).max), error(&|k| range(k, o).min)]);
    }
    let ranges = (0..last.ranges.len()).map(|o| range(k, o)).collect();
    Cycle { period: lap(k), ranges, errors, at: last.u.clone(), time: last.t, crossings: q }
}

/// Adds to the errors what a run with ten times the tolerance differs by.
fn compare(
    problem: &dyn Problem,
    (course, control): (&Course, &Control),
    search: &Search,
    cycle: &mut Cycle,
    counts: &mut Counts,
) {
    const COARSER: f64 = 10.0;
    let coarse = Control { tolerance: COARSER * control.tolerance, absolute: COARSER * control.absolute, ..*control };
    let p = course.parameters(cycle.time);
    let again = Course::steady(0.0, course.to - course.from, &p);
    let search = Search { stop: true, errors: false, ..search.clone() };
    let nothing = &mut |_: &Step| ControlFlow::Continue(());
    let other = settle(problem, &cycle.at, (&again, &coarse), &search, counts, nothing);
    if let Ok(Settled { attractor: Attractor::Cycle(other), .. }) = other {
        let values = |cycle: &Cycle| {
            std::iter::once(cycle.period).chain(cycle.ranges.iter().flat_map(|range| [range.max, range.min])).collect()
        };
        let (fine, mut coarse): (Vec<f64>, Vec<f64>) = (values(cycle), values(&other));
        // It may have taken several rounds for one.
        coarse[0] /= (coarse[0] / fine[0]).round().max(1.0);
        for (error, (a, b)) in cycle.errors.iter_mut().zip(fine.iter().zip(&coarse)) {
            *error += (a - b).abs();
        }
    } else {
        // Without a second run no error is known.
        cycle.errors.iter_mut().for_each(|error| *error = f64::NAN);
    }
}
