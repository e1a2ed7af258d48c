//! Returns to a section: where a motion crosses a plane through one of its states, at right angles to its rate there.

use super::form::norm;
use super::integrate::{Motion, Step};
use crate::linalg::dot;
use crate::problem::{At, Problem};

/// Largest and smallest value of an observable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub max: f64,
    pub min: f64,
}

/// A crossing of the section, and the lap that it ends.
#[derive(Clone, Debug)]
pub struct Return {
    pub t: f64,
    pub u: Vec<f64>,
    /// Largest distance of the lap's states from its end.
    pub extent: f64,
    /// Of the observables over the lap.
    pub ranges: Vec<Range>,
}

/// A motion's returns so far.
pub struct Returns<'a> {
    problem: &'a dyn Problem,
    parameters: &'a dyn Fn(f64) -> Vec<f64>,
    observables: &'a [usize],
    /// A state and the unit vector along its rate.
    section: Option<(Motion, Vec<f64>)>,
    /// For how long a return is waited for before the section is moved.
    patience: f64,
    since: f64,
    ranges: Vec<Range>,
    extent: f64,
    /// The longest time between two returns.
    longest: f64,
    pub list: Vec<Return>,
}

/// A step is looked at in so many parts, each with at most one extremum, and one crossing on either side of it.
const PARTS: usize = 3;
/// First patience in parts of the time given.
const PATIENCE: f64 = 0.02;
/// Patience in laps.
const LAPS: f64 = 4.0;

impl<'a> Returns<'a> {
    pub fn new(
        problem: &'a dyn Problem,
        parameters: &'a dyn Fn(f64) -> Vec<f64>,
        observables: &'a [usize],
        duration: f64,
    ) -> Self {
        Self {
            problem,
            parameters,
            observables,
            section: None,
            patience: PATIENCE * duration,
            since: f64::NEG_INFINITY,
            ranges: Vec::new(),
            extent: 0.0,
            longest: 0.0,
            list: Vec::new(),
        }
    }

    fn place(&mut self, motion: &Motion) {
        let length = norm(&motion.v);
        self.list.clear();
        self.longest = 0.0;
        self.since = motion.t;
        self.begin(motion);
        self.section = (length > 0.0).then(|| (motion.clone(), motion.v.iter().map(|v| v / length).collect()));
    }

    /// A new lap.
    fn begin(&mut self, motion: &Motion) {
        self.extent = 0.0;
        self.ranges.clear();
        for &i in self.observables {
            let value = observe(self.problem, self.parameters, i, motion);
            self.ranges.push(Range { max: value, min: value });
        }
    }

    /// Takes in a step; says whether there was a return in it.
    pub fn step(&mut self, step: &Step) -> bool {
        if self.section.is_none() {
            self.place(step.from);
        }
        let mut returned = false;
        let (a, b) = (step.from.t, step.to.t);
        let mut from = step.from.clone();
        for part in 1..=PARTS {
            let to = if part == PARTS { step.to.clone() } else { step.at(a + (b - a) * part as f64 / PARTS as f64) };
            if let Some(t) = self.excursion(step, &from, &to) {
                let split = step.at(t);
                returned |= self.part(step, &from, &split);
                from = split;
            }
            returned |= self.part(step, &from, &to);
            from = to;
        }
        let waited = step.to.t - self.list.last().map_or(self.since, |last| last.t);
        if waited > self.patience.max(LAPS * self.longest) {
            self.patience *= 2.0;
            self.place(step.to);
        }
        returned
    }

    /// How far a motion is above the section.
    fn height(&self, motion: &Motion) -> f64 {
        self.section.as_ref().map_or(0.0, |(base, normal)| {
            let above: Vec<f64> = motion.u.iter().zip(&base.u).map(|(u, c)| u - c).collect();
            dot(&above, normal)
        })
    }

    /// When the motion is farthest on the other side of the section than at both ends of a stretch, if it is.
    fn excursion(&self, step: &Step, from: &Motion, to: &Motion) -> Option<f64> {
        let ends = ((from.t, self.height(from)), (to.t, self.height(to)));
        excursion(&|t| self.height(&step.at(t)), ends).map(|found| found.0)
    }

    fn part(&mut self, step: &Step, from: &Motion, to: &Motion) -> bool {
        let height = |motion: &Motion| self.height(motion);
        let crosses = height(from) < 0.0 && height(to) >= 0.0;
        let crossing = crosses.then(|| {
            let (mut a, mut b) = (from.t, to.t);
            let mut at = to.clone();
            // Bisection, to the last bit of the time.
            loop {
                let middle = 0.5 * (a + b);
                if middle <= a || middle >= b {
                    break at;
                }
                let there = step.at(middle);
                if height(&there) < 0.0 {
                    a = middle;
                } else {
                    b = middle;
                    at = there;
                }
            }
        });
        match crossing {
            None => {
                self.extend(step, from, to);
                false
            }
            Some(at) => {
                self.extend(step, from, &at);
                let ranges = std::mem::take(&mut self.ranges);
                self.longest = self.list.last().map_or(0.0, |last| at.t - last.t).max(self.longest);
                self.list.push(Return { t: at.t, u: at.u.clone(), extent: self.extent, ranges });
                self.begin(&at);
                self.extend(step, &at, to);
                true
            }
        }
    }

    /// Takes a stretch into the lap's extent and ranges.
    fn extend(&mut self, step: &Step, from: &Motion, to: &Motion) {
        let base = self.list.last().map(|last| &last.u).or(self.section.as_ref().map(|(base, _)| &base.u));
        if let Some(base) = base {
            let away: Vec<f64> = to.u.iter().zip(base).map(|(u, c)| u - c).collect();
            self.extent = self.extent.max(norm(&away));
        }
        if self.observables.is_empty() || to.t <= from.t {
            return;
        }
        let middle = step.at(0.5 * (from.t + to.t));
        for (k, &i) in self.observables.iter().enumerate() {
            let value = |motion: &Motion| observe(self.problem, self.parameters, i, motion);
            let (a, m, b) = (value(from), value(&middle), value(to));
            let range = &mut self.ranges[k];
            for sign in [1.0, -1.0] {
                // The parabola's vertex, in [-1, 1] inside the stretch.
                let bend = sign * (a - 2.0 * m + b);
                let vertex = -0.5 * sign * (b - a) / bend;
                let ends = (sign * a).max(sign * m).max(sign * b);
                let top = if bend < 0.0 && vertex.abs() <= 1.0 {
                    let f = |t: f64| sign * value(&step.at(t));
                    ends.max(peak(&f, from.t, to.t).1)
                } else {
                    ends
                };
                if sign > 0.0 {
                    range.max = range.max.max(top);
                } else {
                    range.min = range.min.min(-top);
                }
            }
        }
    }
}

pub fn observe(problem: &dyn Problem, parameters: &dyn Fn(f64) -> Vec<f64>, i: usize, motion: &Motion) -> f64 {
    problem.observe(i, At { u: &motion.u, v: &motion.v, p: &parameters(motion.t) })
}

/// Where a function of one extremum is on the other side of zero than at both ends of a stretch, farthest from zero, and its
/// value there.
pub(super) fn excursion(f: &dyn Fn(f64) -> f64, (from, to): ((f64, f64), (f64, f64))) -> Option<(f64, f64)> {
    let side = from.1.signum();
    if from.1 == 0.0 || to.1 * side <= 0.0 || to.0 <= from.0 {
        return None;
    }
    let beyond = |t: f64| -side * f(t);
    let (a, m, b) = (-side * from.1, beyond(0.5 * (from.0 + to.0)), -side * to.1);
    // The parabola's vertex, in [-1, 1] inside the stretch; its height is right to a small part of its bend.
    let bend = a - 2.0 * m + b;
    let vertex = -0.5 * (b - a) / bend;
    if bend >= 0.0 || vertex.abs() > 1.0 || m - 0.5 * bend * vertex * vertex < 0.5 * bend {
        return None;
    }
    let (t, top) = peak(&beyond, from.0, to.0);
    (top > 0.0).then_some((t, -side * top))
}

/// Where a function of one hump is largest, and its value there, by golden section.
fn peak(f: &dyn Fn(f64) -> f64, mut a: f64, mut b: f64) -> (f64, f64) {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut at_c, mut at_d) = (f(c), f(d));
    // A value's error goes as the square of the place's.
    for _ in 0..36 {
        if at_c > at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - ratio * (b - a);
            at_c = f(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + ratio * (b - a);
            at_d = f(d);
        }
    }
    if at_c > at_d { (c, at_c) } else { (d, at_d) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excursions_are_found_where_they_reach_the_other_side() {
        let found = |depth: f64| {
            let f = |t: f64| 4.0 * (t - 0.4).powi(2) - depth;
            excursion(&f, ((0.0, f(0.0)), (1.0, f(1.0))))
        };
        let (t, value) = found(1e-3).unwrap();
        assert!((t - 0.4).abs() < 1e-6 && (value + 1e-3).abs() < 1e-12, "{t} {value}");
        assert_eq!(found(-1e-3), None);
        assert_eq!(excursion(&|t: f64| t, ((0.0, 0.0), (1.0, 1.0))), None);
    }
}
