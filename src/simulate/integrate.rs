//! Steps through time by backward differentiation or a diagonally implicit Runge-Kutta method.

use super::SimulateError;
use super::equations::{Equations, Trouble};
use super::form::Form;
use crate::continuation::Counts;
use crate::linalg::finite;
use crate::problem::Problem;
use diffsol::{BdfState, FaerSparseLU, OdeBuilder, OdeSolverMethod, OdeSolverState as _, OdeSolverStopReason};
use diffsol::{FaerSparseMat, FaerVec, Tableau, VectorCommon as _};
use std::ops::ControlFlow;

/// Methods of integration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Backward differentiation of variable order, 1 to 5 (Shampine and Reichelt 1997, doi:10.1137/S1064827594276424).
    Bdf,
    /// ESDIRK3(4), L-stable and of order 4 (Jørgensen, Kristensen and Thomsen 2018, arXiv:1803.01613).
    Sdirk,
}

/// How accurately: local errors of each unknown stay below `tolerance |u_i| + absolute U`, U the largest unknown so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Control {
    pub method: Method,
    pub tolerance: f64,
    pub absolute: f64,
}

/// For how long, and with which parameters: `p(t)` goes in a straight line from the first to the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    pub from: f64,
    pub to: f64,
    pub first: Vec<f64>,
    pub last: Vec<f64>,
}

impl Course {
    /// With constant parameters.
    pub fn steady(from: f64, to: f64, p: &[f64]) -> Self {
        Self { from, to, first: p.to_vec(), last: p.to_vec() }
    }

    /// The parameters at a time.
    pub fn parameters(&self, t: f64) -> Vec<f64> {
        let part = (t - self.from) / (self.to - self.from);
        self.first.iter().zip(&self.last).map(|(a, b)| if a == b { *a } else { a + part * (b - a) }).collect()
    }
}

/// A state with its rates.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    pub t: f64,
    pub u: Vec<f64>,
    pub v: Vec<f64>,
}

/// An accepted step: the motion at its ends, and between them by the method's own interpolation.
pub struct Step<'s> {
    pub from: &'s Motion,
    pub to: &'s Motion,
    pub(super) between: &'s dyn Fn(f64) -> Option<Motion>,
}

impl Step<'_> {
    /// The motion at a time inside the step.
    pub fn at(&self, t: f64) -> Motion {
        let end = || if t - self.from.t < self.to.t - t { self.from.clone() } else { self.to.clone() };
        if t == self.from.t || t == self.to.t { end() } else { (self.between)(t).unwrap_or_else(end) }
    }
}

/// The least step in parts of the whole time.
const LEAST_STEP: f64 = 1e-18;
/// When the solution has outgrown the size that absolute errors refer to by this factor, they are adapted.
const GROWTH: f64 = 4.0;

/// Integrates from a start, made consistent first, until the end or until `see` breaks; returns the last motion.
pub fn integrate(
    problem: &dyn Problem,
    start: &[f64],
    course: &Course,
    control: &Control,
    counts: &mut Counts,
    see: &mut dyn FnMut(&Step) -> ControlFlow<()>,
) -> Result<Motion, SimulateError> {
    let p = course.parameters(course.from);
    let form = Form::new(problem, start, &p);
    let (u, v) = form.consistent(start, &p, course.from)?;
    let mut now = Motion { t: course.from, u, v };
    // A motion that starts at zero has a size only after its first step.
    let mut size = largest(&now.u);
    if size == 0.0 {
        size = largest(&now.v) * (course.to - course.from);
    }
    loop {
        let leg = Leg { form: &form, course, control, size };
        match leg.run(now, counts, see)? {
            End::Outgrown(motion) => {
                size = largest(&motion.u);
                now = motion;
            }
            End::Over(motion) => return Ok(motion),
        }
    }
}

fn largest(u: &[f64]) -> f64 {
    u.iter().fold(0.0_f64, |most, x| most.max(x.abs()))
}

/// A stretch of the motion with fixed absolute errors.
struct Leg<'a> {
    form: &'a Form<'a>,
    course: &'a Course,
    control: &'a Control,
    size: f64,
}

enum End {
    Outgrown(Motion),
    Over(Motion),
}

impl Leg<'_> {
    fn run(
        &self,
        start: Motion,
        counts: &mut Counts,
        see: &mut dyn FnMut(&Step) -> ControlFlow<()>,
    ) -> Result<End, SimulateError> {
        let duration = self.course.to - self.course.from;
        let time = |s: f64| self.course.from + s * duration;
        let parameters = |s: f64| self.course.parameters(time(s));
        let refused = |t: f64, reason: String| SimulateError::Integrator { time: t, reason };
        let y = self.form.join(&start.u, &start.v);
        let n = start.u.len();
        let equations = Equations::new(self.form, &parameters, duration, y)
            .ok_or_else(|| refused(start.t, "the matrix's pattern is too large".to_owned()))?;
        // Rates are not judged; their zeros must not dilute the mean.
        let part = (n as f64 / self.form.dim() as f64).sqrt();
        let size = if self.size > 0.0 { self.size } else { 1.0 };
        let absolute = |i: usize| if i < n { part * self.control.absolute * size } else { f64::INFINITY };
        let absolute: Vec<f64> = (0..self.form.dim()).map(absolute).collect();
        let problem = OdeBuilder::<FaerSparseMat<f64>>::new()
            .t0((start.t - self.course.from) / duration)
            .h0(1e-6)
            .rtol(part * self.control.tolerance)
            .atol(absolute)
            .build_from_eqn(equations);
        let mut problem = problem.map_err(|error| refused(start.t, error.to_string()))?;
        problem.ode_options.min_timestep = LEAST_STEP;
        // The library counts these over the whole motion; the least step bounds those that follow each other.
        problem.ode_options.max_nonlinear_solver_failures = usize::MAX;
        // The start is consistent; the library's search for one asks for more digits of the rates than there are.
        let outcome = match self.control.method {
            Method::Bdf => {
                let solver =
                    BdfState::new(&problem, 1).and_then(|state| problem.bdf_solver::<FaerSparseLU<f64>>(state));
                solver
                    .map_err(|error| refused(start.t, error.to_string()))
                    .and_then(|solver| self.steps(solver, start, see))
            }
            Method::Sdirk => {
                let state = problem.rk_state(&Tableau::esdirk34());
                let solver = state.and_then(|state| problem.esdirk34_solver::<FaerSparseLU<f64>>(state));
                solver
                    .map_err(|error| refused(start.t, error.to_string()))
                    .and_then(|solver| self.steps(solver, start, see))
            }
        };
        counts.residuals += problem.eqn.evaluations.get();
        counts.factorisations += problem.eqn.jacobians.get();
        outcome
    }

    fn steps<'e, 'f: 'e>(
        &self,
        mut solver: impl OdeSolverMethod<'e, Equations<'f>>,
        start: Motion,
        see: &mut dyn FnMut(&Step) -> ControlFlow<()>,
    ) -> Result<End, SimulateError> {
        let duration = self.course.to - self.course.from;
        let time = |s: f64| self.course.from + s * duration;
        solver
            .set_stop_time(1.0)
            .map_err(|error| SimulateError::Integrator { time: start.t, reason: error.to_string() })?;
        let mut last = start;
        loop {
            let taken = solver.step();
            let trouble = solver.problem().eqn.trouble.get();
            if let Some(Trouble::Rate(unknown)) = trouble {
                return Err(SimulateError::Rate { unknown, time: time(solver.state().t) });
            }
            let reason = taken.map_err(|error| self.failure(&error, time(solver.state().t), trouble))?;
            let motion = |y: &FaerVec<f64>, dy: &FaerVec<f64>, t: f64| {
                let (u, mut v) = self.form.split(y.inner().col_as_slice(0));
                for (i, _) in self.form.algebraic.iter().enumerate().filter(|(_, algebraic)| **algebraic) {
                    v[i] = dy.inner().col_as_slice(0)[i] / duration;
                }
                Motion { t, u: u.to_vec(), v }
            };
            let state = solver.state();
            let over = matches!(reason, OdeSolverStopReason::TstopReached);
            let t = if over { self.course.to } else { time(state.t) };
            let now = motion(state.y, state.dy, t);
            if !finite(&now.u) || !finite(&now.v) {
                return Err(SimulateError::NotFinite { time: last.t });
            }
            let (from, to) = (last.t, now.t);
            let end = solver.state().t;
            let between = |t: f64| {
                let s = ((t - self.course.from) / duration).min(end);
                (from..=to).contains(&t).then_some(())?;
                let (y, dy) = (solver.interpolate(s).ok()?, solver.interpolate_dy(s).ok()?);
                Some(motion(&y, &dy, t)).filter(|motion| finite(&motion.u) && finite(&motion.v))
            };
            let flow = see(&Step { from: &last, to: &now, between: &between });
            // A step that was accepted after all makes up for what was tried on the way.
            solver.problem().eqn.trouble.set(None);
            last = now;
            if over || flow.is_break() {
                return Ok(End::Over(last));
            }
            if largest(&last.u) > GROWTH * self.size {
                return Ok(End::Outgrown(last));
            }
        }
    }

    fn failure(&self, error: &diffsol::DiffsolError, time: f64, trouble: Option<Trouble>) -> SimulateError {
        use diffsol::error::OdeSolverError::{
            StepSizeTooSmall, TooManyErrorTestFailures, TooManyNonlinearSolverFailures,
        };
        if trouble == Some(Trouble::NotFinite) {
            return SimulateError::NotFinite { time };
        }
        match error {
            diffsol::DiffsolError::OdeSolverError(
                StepSizeTooSmall { .. } | TooManyErrorTestFailures { .. } | TooManyNonlinearSolverFailures { .. },
            ) => SimulateError::Step { time, step: LEAST_STEP * (self.course.to - self.course.from) },
            other => SimulateError::Integrator { time, reason: other.to_string() },
        }
    }
}
