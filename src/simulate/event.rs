//! Events: where an observable of a motion takes a value.

use super::integrate::{Motion, Step};
use super::returns::excursion;
use crate::problem::{At, Problem};

/// Which way an observable crosses a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    Up,
    Down,
    Any,
}

/// An observable, by its position in the problem's list, that crosses a value.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    pub observable: usize,
    pub value: f64,
    pub direction: Direction,
}

/// A step is looked at in so many parts, each with at most one extremum, and one crossing on either side of it.
const PARTS: usize = 4;
/// Of regula falsi, each other step by halving: more than it takes to halve a step away.
const MOST_STEPS: usize = 120;

impl Event {
    /// The motion at each crossing within a step, in order, on the method's own interpolation, whose error is the
    /// integrator's: nothing is gained by more accurate times than those at which it changes its sign.
    pub fn within(&self, problem: &dyn Problem, parameters: &dyn Fn(f64) -> Vec<f64>, step: &Step) -> Vec<Motion> {
        let value = |motion: &Motion| {
            let at = At { u: &motion.u, v: &motion.v, p: &parameters(motion.t) };
            problem.observe(self.observable, at) - self.value
        };
        let (from, to) = (step.from.t, step.to.t);
        let place = |k: usize| if k == PARTS { to } else { from + (to - from) * k as f64 / PARTS as f64 };
        let mut found = Vec::new();
        let mut last = (from, value(step.from));
        for k in 1..=PARTS {
            let next = (place(k), value(&step.at(place(k))));
            let between = excursion(&|t| value(&step.at(t)), (last, next));
            for next in between.into_iter().chain([next]) {
                // A value that is met at the end of a part belongs to that part.
                let (up, down) = (last.1 < 0.0 && next.1 >= 0.0, last.1 > 0.0 && next.1 <= 0.0);
                if match self.direction {
                    Direction::Up => up,
                    Direction::Down => down,
                    Direction::Any => up || down,
                } {
                    found.push(step.at(zero(last, next, &|t| value(&step.at(t)))));
                }
                last = next;
            }
        }
        found
    }
}

/// Where a function changes its sign between two times, by regula falsi and halving in turns.
fn zero(mut a: (f64, f64), mut b: (f64, f64), value: &dyn Fn(f64) -> f64) -> f64 {
    for k in 0..MOST_STEPS {
        if b.1 == 0.0 {
            return b.0;
        }
        let middle = 0.5 * (a.0 + b.0);
        let secant = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
        let t = if k % 2 == 0 && secant.is_finite() { secant.clamp(a.0.min(b.0), a.0.max(b.0)) } else { middle };
        if middle == a.0 || middle == b.0 {
            break;
        }
        let here = (t, value(t));
        if (here.1 < 0.0) == (a.1 < 0.0) && here.1 != 0.0 { a = here } else { b = here }
    }
    b.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_sign_is_found_to_rounding() {
        let f = |t: f64| (t - 0.3).powi(3) + 1e-3 * (t - 0.3);
        assert!((zero((0.0, f(0.0)), (1.0, f(1.0)), &f) - 0.3).abs() < 1e-15);
        let jump = |t: f64| if t < 0.7 { -1.0 } else { 2.0 };
        assert!((zero((0.0, -1.0), (1.0, 2.0), &jump) - 0.7).abs() < 1e-15);
    }
}
