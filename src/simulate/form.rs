//! Which unknowns have rates, the pattern of the system for (u, v_d), and a consistent start.

use super::SimulateError;
use crate::linalg::{Factors, finite};
use crate::problem::{At, Problem};

/// The split of the unknowns.
pub struct Form<'a> {
    pub problem: &'a dyn Problem,
    /// Unknowns whose rates the equations hold.
    pub differential: Vec<usize>,
    /// Whether an unknown is none of these.
    pub algebraic: Vec<bool>,
}

/// Newton steps towards a consistent start.
const STEPS: usize = 50;
/// A step is halved so often until the residual falls.
const HALVINGS: usize = 20;

impl<'a> Form<'a> {
    /// Columns of `M(u, p)` that are zero at the start and at states near it are taken for zero everywhere, which
    /// every later evaluation checks.
    pub fn new(problem: &'a dyn Problem, u: &[f64], p: &[f64]) -> Self {
        let n = problem.dim();
        let size = u.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let size = if size > 0.0 { size } else { 1.0 };
        let mut algebraic = vec![true; n];
        // Low-discrepancy multipliers in (-1, 1): a column that vanishes at a state by chance does not at the others.
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let rest = vec![0.0; n];
        for k in 0..3 {
            let near = u.iter().enumerate().map(|(i, x)| x + 1e-3 * size * part(k, i, GOLDEN));
            let near: Vec<f64> = near.collect();
            let (_, mass) = problem.matrices(At { u: &near, v: &rest, p });
            mass.entries().into_iter().filter(|(.., x)| *x != 0.0).for_each(|(_, j, _)| algebraic[j] = false);
        }
        let differential = (0..n).filter(|&i| !algebraic[i]).collect();
        Self { problem, differential, algebraic }
    }

    /// Unknowns of the whole system.
    pub fn dim(&self) -> usize {
        self.algebraic.len() + self.differential.len()
    }

    /// u and v of the whole system's unknowns.
    pub fn split<'y>(&self, y: &'y [f64]) -> (&'y [f64], Vec<f64>) {
        let (u, rates) = y.split_at(self.algebraic.len());
        let mut v = vec![0.0; u.len()];
        self.differential.iter().zip(rates).for_each(|(&i, rate)| v[i] = *rate);
        (u, v)
    }

    /// The whole system's unknowns.
    pub fn join(&self, u: &[f64], v: &[f64]) -> Vec<f64> {
        u.iter().copied().chain(self.differential.iter().map(|&i| v[i])).collect()
    }

    /// Solves `G(u, v, p) = 0` for the rates of the differential unknowns and for the algebraic unknowns by Newton's
    /// method with halved steps; the differential unknowns are kept.
    pub fn consistent(&self, start: &[f64], p: &[f64], time: f64) -> Result<(Vec<f64>, Vec<f64>), SimulateError> {
        let n = start.len();
        if !finite(start) {
            return Err(SimulateError::Start);
        }
        let (mut u, mut v) = (start.to_vec(), vec![0.0; n]);
        let still: Vec<usize> = (0..n).filter(|&i| self.algebraic[i]).collect();
        let mut g = vec![0.0; n];
        self.problem.residual(At { u: &u, v: &v, p }, &mut g);
        if !finite(&g) {
            return Err(SimulateError::NotFinite { time });
        }
        let first = norm(&g);
        for _ in 0..STEPS {
            let (gu, gv) = self.problem.matrices(At { u: &u, v: &v, p });
            let factors = Factors::new(&gv.with_columns(&gu, &still)).map_err(|_| SimulateError::Index { time })?;
            let mut step = g.clone();
            factors.solve(&mut step);
            if !finite(&step) {
                return Err(SimulateError::Index { time });
            }
            let before = norm(&g);
            let mut factor = 1.0;
            let mut moved = false;
            for _ in 0..HALVINGS {
                let (mut u2, mut v2) = (u.clone(), v.clone());
                for i in 0..n {
                    let target = if self.algebraic[i] { &mut u2 } else { &mut v2 };
                    target[i] -= factor * step[i];
                }
                self.problem.residual(At { u: &u2, v: &v2, p }, &mut g);
                if finite(&g) && (norm(&g) < before || before == 0.0) {
                    (u, v, moved) = (u2, v2, true);
                    break;
                }
                factor *= 0.5;
            }
            let size = (0..n).map(|i| if self.algebraic[i] { u[i].abs() } else { v[i].abs() }).fold(0.0, f64::max);
            let length = step.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            // Rounding stops the descent at the solution; elsewhere the step stays long.
            if length <= 1e-13 * size || length == 0.0 || (!moved && length <= 1e-8 * size) {
                return Ok((u, v));
            }
            if !moved {
                break;
            }
        }
        self.problem.residual(At { u: &u, v: &v, p }, &mut g);
        Err(SimulateError::Inconsistent { residual: norm(&g) / first.max(f64::MIN_POSITIVE) })
    }
}

fn part(k: usize, i: usize, golden: f64) -> f64 {
    if k == 0 { 0.0 } else { 2.0 * ((k * 7919 + i + 1) as f64 * golden).fract() - 1.0 }
}

pub(super) fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
