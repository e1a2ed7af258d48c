//! A computed cycle against plain time integration: other equations of motion (`u' = M^-1 F`), another method (BDF with
//! error control, of diffsol), no periodicity assumed.
//!
//! From a state a few percent off the cycle the motion settles on it; its period and amplitude are then read off the
//! tip. The slowest multiplier sets how many periods that takes.

mod common;

use common::{Cycle, Flagellum, close, matrices};
use diffsol::{NalgebraLU, NalgebraMat, OdeBuilder, OdeSolverMethod, VectorCommon};
use hopfline::linalg::Lu;
use hopfline::models::{Law, Load};
use hopfline::problem::{At, Direction};
use std::cell::RefCell;

const FUNCTIONS: usize = 12;
/// 12 functions put the onset at 340.8, so this load is as far above it as 360 is above the exact onset.
const LOAD: f64 = 362.0;
const RELATIVE: f64 = 1e-8;
const ABSOLUTE: f64 = 1e-11;

/// `u' = M(u)^-1 F(u)` and its Jacobian times vectors, factors and derivatives kept for the last u.
struct Motion<'a> {
    model: &'a Flagellum,
    kept: RefCell<Option<Kept>>,
}

struct Kept {
    u: Vec<f64>,
    mass: Lu<f64>,
    rate: Vec<f64>,
}

impl Motion<'_> {
    fn with<T>(&self, u: &[f64], f: impl FnOnce(&Kept) -> T) -> T {
        let mut kept = self.kept.borrow_mut();
        if kept.as_ref().is_none_or(|kept| kept.u != u) {
            let rest = vec![0.0; u.len()];
            let at = At { u, v: &rest, p: &self.model.p };
            let (_, mass) = matrices(&*self.model.problem, at);
            let mass = Lu::new(mass).expect("an invertible mass");
            let mut rate = vec![0.0; u.len()];
            self.model.problem.residual(at, &mut rate);
            mass.solve(&mut rate);
            rate.iter_mut().for_each(|r| *r = -*r);
            *kept = Some(Kept { u: u.to_vec(), mass, rate });
        }
        f(kept.as_ref().expect("just made"))
    }

    fn rate(&self, u: &[f64], out: &mut [f64]) {
        self.with(u, |kept| out.copy_from_slice(&kept.rate));
    }

    /// `-M^-1 (G_u d)` at `v = M^-1 F`.
    fn jacobian_times(&self, u: &[f64], d: &[f64], out: &mut [f64]) {
        self.with(u, |kept| {
            let at = At { u, v: &kept.rate, p: &self.model.p };
            let mut product = vec![0.0; u.len()];
            self.model.problem.derivative(at, &[Direction { u: d, v: &[], p: &[] }], &mut product);
            kept.mass.solve(&mut product);
            out.iter_mut().zip(product).for_each(|(o, p)| *o = -p);
        });
    }
}

/// What a motion shows in its last period: the period, and the largest tip deflection.
struct Seen {
    period: f64,
    largest: f64,
}

/// Integrates over a number of periods, and looks at the last.
fn integrate(model: &Flagellum, start: &[f64], duration: f64, periods: f64) -> Seen {
    let motion = Motion { model, kept: RefCell::new(None) };
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(RELATIVE)
        .atol([ABSOLUTE])
        .h0(duration * 1e-6)
        .rhs_implicit(|u, _p, _t, out| motion.rate(u, out), |u, _p, _t, d, out| motion.jacobian_times(u, d, out))
        .init(|_p, _t, u| u.copy_from_slice(start), start.len())
        .build()
        .expect("a problem");
    let mut solver = problem.bdf::<NalgebraLU<f64>>().expect("a solver");
    let rest = vec![0.0; start.len()];
    let index = model.observable("tip_deflection");
    let tip = |u: &[f64]| model.problem.observe(index, At { u, v: &rest, p: &model.p });
    let mut upward: Vec<f64> = Vec::new();
    let mut largest: Vec<f64> = Vec::new();
    let (mut last_t, mut last) = (0.0, tip(start));
    while last_t < periods * duration {
        solver.step().expect("a step");
        let (from, to) = (last_t, solver.state().t);
        let at = |t: f64| tip(solver.interpolate(t).expect("inside the last step").inner().as_slice());
        // A part of a step has one zero or one hump at most, found by bisection and golden section.
        const PARTS: usize = 4;
        for part in 0..PARTS {
            let (a, b) = (
                from + (to - from) * part as f64 / PARTS as f64,
                from + (to - from) * (part + 1) as f64 / PARTS as f64,
            );
            let (at_a, at_b) = (if part == 0 { last } else { at(a) }, at(b));
            if at_a < 0.0 && at_b >= 0.0 {
                let (mut a, mut b) = (a, b);
                for _ in 0..60 {
                    let middle = 0.5 * (a + b);
                    if at(middle) < 0.0 { a = middle } else { b = middle }
                }
                upward.push(0.5 * (a + b));
                largest.push(0.0);
            }
            if let Some(largest) = largest.last_mut() {
                *largest = largest.max(at_a).max(at_b).max(peak(&at, a, b));
            }
        }
        (last_t, last) = (to, at(to));
    }
    let n = upward.len();
    Seen { period: upward[n - 1] - upward[n - 2], largest: largest[n - 2] }
}

/// The largest value of a function of one hump by golden section.
fn peak(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..20 {
        let (c, d) = (b - ratio * (b - a), a + ratio * (b - a));
        if f(c) > f(d) { b = d } else { a = c }
    }
    f(0.5 * (a + b))
}

#[test]
fn time_integration_settles_on_the_collocated_cycle() {
    let model = Flagellum::new(FUNCTIONS, Load::Uniform, Law::Printed).with("p", LOAD);
    let cycles = model.cycles(345.0, &[LOAD], (24, 5));
    let Cycle { orbit, multipliers, deflection } = &cycles[0];
    let slowest = multipliers.values[0].norm();
    assert!(multipliers.unstable() == 0 && slowest < 0.5, "{slowest}");

    // Five percent off the cycle; what is left of that at the end must be below the integrator's error.
    let start: Vec<f64> =
        orbit.node(0).iter().enumerate().map(|(i, u)| u * if i % 2 == 0 { 1.05 } else { 0.96 }).collect();
    let periods = (1e-9_f64.ln() / slowest.ln()).ceil() + 2.0;
    let seen = integrate(&model, &start, orbit.period(), periods);
    // Local errors of 1e-8 of the state, of either sign, over some hundred steps per period.
    close("period", seen.period, orbit.period(), 1e-7);
    close("largest tip deflection", seen.largest, *deflection, 1e-7);
}
