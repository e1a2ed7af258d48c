//! Least squares in a box: a trust region with steps after Levenberg and Marquardt, as a solver of argmin, which has none.
//!
//! Each step minimises `|r + J s|` over `|s| <= radius` (More 1978, doi:10.1007/BFb0067700), by the singular values of J:
//! `s(lambda) = -V diag(s_i / (s_i² + lambda)) U^T r`. Unknowns on a face of the box that would leave it are held; others
//! are stopped there. Close to the solution, where a sum of squares cannot tell points apart any more, Gauss-Newton steps
//! go on while they shrink, so that the solution is found to rounding.

use super::{Calibration, HopfError, Lost, Place};
use argmin::core::{
    Error, Executor, IterState, Jacobian, KV, Operator, Problem, Solver, State, TerminationReason, TerminationStatus,
};
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;
use thiserror::Error as ThisError;

/// Where a fit ended.
#[derive(Clone, Debug)]
pub struct Fit {
    pub place: Place,
    /// Whether it ended at a minimum, and not where the Hopf point could not be followed further.
    pub minimal: bool,
    /// Points of the box at which the solver asked for the Hopf point.
    pub evaluations: usize,
}

#[derive(Debug, ThisError)]
pub enum FitError {
    #[error("the fit did not converge in {0} steps")]
    Slow(u64),
    #[error("interrupted")]
    Interrupted,
    #[error("{0}")]
    Failed(String),
}

const FIRST_RADIUS: f64 = 0.25;
/// Steps in parts of the box: below this, nothing moves any more;
const LEAST: f64 = 1e-14;
/// below this, steps count as converging while each is less than half of the last.
const POLISH: f64 = 1e-6;
/// A step must bring this part of the decrease that the linear model promises.
const ENOUGH: f64 = 1e-4;
const MOST_STEPS: u64 = 80;

impl Calibration {
    /// The local minimum of the sum of squares that is reached from a place of the box; `stop` ends the search.
    pub fn fit(&self, start: &Place, stop: &(dyn Fn() -> bool + Sync)) -> Result<Fit, FitError> {
        let follower = Follower { calibration: self, known: RefCell::new(vec![start.clone()]), stop };
        let solver = TrustBox { radius: FIRST_RADIUS, last: f64::INFINITY, blocked: false, done: false };
        let result = Executor::new(follower, solver)
            .configure(|state| state.param(start.x.clone()).max_iters(MOST_STEPS))
            .timer(false)
            .run()
            .map_err(|error| if stop() { FitError::Interrupted } else { FitError::Failed(error.to_string()) })?;
        if result.state.get_iter() >= MOST_STEPS {
            return Err(FitError::Slow(MOST_STEPS));
        }
        let minimal = !result.solver.blocked;
        let (x, follower) = (result.state.param, result.problem.problem);
        let place = x.zip(follower).and_then(|(x, follower)| {
            let known = follower.known.into_inner();
            let evaluations = known.len();
            Some(Fit { place: known.into_iter().find(|place| place.x == x)?, minimal, evaluations })
        });
        place.ok_or_else(|| FitError::Failed("the solver lost its point".to_owned()))
    }
}

/// Answers the solver from the nearest of all places that are known.
struct Follower<'a> {
    calibration: &'a Calibration,
    known: RefCell<Vec<Place>>,
    stop: &'a (dyn Fn() -> bool + Sync),
}

#[derive(Debug, ThisError)]
enum Unanswered {
    #[error(transparent)]
    Lost(#[from] Lost),
    #[error(transparent)]
    Hopf(#[from] HopfError),
    #[error("interrupted")]
    Interrupted,
}

impl Follower<'_> {
    fn place(&self, x: &[f64]) -> Result<Place, Unanswered> {
        if (self.stop)() {
            return Err(Unanswered::Interrupted);
        }
        let distance = |place: &Place| place.x.iter().zip(x).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        let nearest = self.known.borrow().iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).cloned();
        let Some(nearest) = nearest else { return Err(Unanswered::Interrupted) };
        if nearest.x == x {
            return Ok(nearest);
        }
        let place = self.calibration.reach(&nearest, x)?;
        self.known.borrow_mut().push(place.clone());
        Ok(place)
    }
}

impl Operator for Follower<'_> {
    type Param = Vec<f64>;
    type Output = DVector<f64>;

    fn apply(&self, x: &Vec<f64>) -> Result<DVector<f64>, Error> {
        let place = self.place(x)?;
        Ok(self.calibration.residuals(&place.hopf).map_err(Unanswered::from)?)
    }
}

impl Jacobian for Follower<'_> {
    type Param = Vec<f64>;
    type Jacobian = DMatrix<f64>;

    fn jacobian(&self, x: &Vec<f64>) -> Result<DMatrix<f64>, Error> {
        let place = self.place(x)?;
        Ok(self.calibration.jacobian(&place).map_err(Unanswered::from)?)
    }
}

type Iterate = IterState<Vec<f64>, (), (), (), DVector<f64>, f64>;

/// The solver.
struct TrustBox {
    radius: f64,
    /// Length of the last polishing step.
    last: f64,
    /// Whether the last step was refused because the Hopf point could not be followed to its end.
    blocked: bool,
    done: bool,
}

impl<O> Solver<O, Iterate> for TrustBox
where
    O: Operator<Param = Vec<f64>, Output = DVector<f64>> + Jacobian<Param = Vec<f64>, Jacobian = DMatrix<f64>>,
{
    fn name(&self) -> &str {
        "trust region in a box"
    }

    fn next_iter(&mut self, problem: &mut Problem<O>, mut state: Iterate) -> Result<(Iterate, Option<KV>), Error> {
        let x = state.take_param().unwrap_or_default();
        let r = match state.take_residuals() {
            Some(r) => r,
            None => problem.apply(&x)?,
        };
        let j = problem.jacobian(&x)?;
        let (mut to, mut there) = (x.clone(), r.clone());
        let open = open(&x, &j, &r);
        loop {
            let (trial, full) = self.trial(&x, &j, &r, &open);
            let step = DVector::from_iterator(x.len(), trial.iter().zip(&x).map(|(a, b)| a - b));
            let length = step.norm();
            if length <= LEAST {
                self.done = true;
                break;
            }
            if full && length <= POLISH {
                self.done = length > 0.5 * self.last;
                self.last = length;
                if !self.done {
                    there = problem.apply(&trial)?;
                    to = trial;
                }
                break;
            }
            let found = problem.apply(&trial);
            self.blocked = found.is_err();
            let promised = r.norm_squared() - (&r + &j * &step).norm_squared();
            let Some(found) = found.ok().filter(|_| promised > 0.0) else {
                self.radius = 0.25 * length;
                continue;
            };
            let ratio = (r.norm_squared() - found.norm_squared()) / promised;
            if ratio < 0.25 {
                self.radius = 0.25 * length;
            } else if ratio > 0.75 {
                self.radius = self.radius.max(2.0 * length);
            }
            if ratio > ENOUGH {
                (to, there) = (trial, found);
                break;
            }
        }
        let cost = there.norm_squared();
        Ok((state.param(to).residuals(there).cost(cost), None))
    }

    fn terminate(&mut self, _: &Iterate) -> TerminationStatus {
        if self.done {
            TerminationStatus::Terminated(TerminationReason::SolverConverged)
        } else {
            TerminationStatus::NotTerminated
        }
    }
}

impl TrustBox {
    /// The end of the best step in reach, inside the box, and whether it is the whole Gauss-Newton step.
    fn trial(&self, x: &[f64], j: &DMatrix<f64>, r: &DVector<f64>, open: &[usize]) -> (Vec<f64>, bool) {
        let mut trial = x.to_vec();
        if open.is_empty() {
            return (trial, true);
        }
        let svd = j.select_columns(open).svd(true, true);
        let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return (trial, true) };
        let s = &svd.singular_values;
        let load = u.tr_mul(r);
        let floor = f64::EPSILON * 10.0 * s.max();
        let step = |lambda: f64| {
            let part = |i: usize| if s[i] > floor { -load[i] * s[i] / (s[i] * s[i] + lambda) } else { 0.0 };
            v.tr_mul(&DVector::from_iterator(s.len(), (0..s.len()).map(part)))
        };
        let mut best = step(0.0);
        let full = best.norm() <= self.radius;
        if !full {
            // |s(lambda)| falls from above the radius to below it: |s| <= |J^T r| / lambda.
            let gradient = load.component_mul(s).norm();
            let (mut low, mut high) = (0.0, gradient / self.radius);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if step(middle).norm() > self.radius { low = middle } else { high = middle }
            }
            best = step(high);
        }
        for (&i, s) in open.iter().zip(best.iter()) {
            trial[i] = (x[i] + s).clamp(0.0, 1.0);
        }
        (trial, full)
    }
}

/// Unknowns that may move: not those on a face of the box that the gradient would take outside.
pub(super) fn open(x: &[f64], j: &DMatrix<f64>, r: &DVector<f64>) -> Vec<usize> {
    let gradient = j.tr_mul(r);
    (0..x.len()).filter(|&i| !(x[i] <= 0.0 && gradient[i] > 0.0 || x[i] >= 1.0 && gradient[i] < 0.0)).collect()
}
