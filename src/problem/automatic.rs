//! From one generic formula to a [`Problem`]: derivatives by (hyper-)dual numbers, exact to rounding.

use super::{At, Direction, Observable, Parameter, Problem, Refinement, Reflection, Rotation};
use crate::linalg::{Matrix, Structure};
use num_dual::{Dual2_64, Dual3, Dual64, DualNum, HyperDual64, HyperHyperDual64};

/// A real number, or one that carries derivatives.
pub trait Scalar: DualNum<Primitive = f64> + Copy + Send + Sync {
    /// Zero, with no derivative in it: a term with this coefficient may be left out.
    fn vanishes(&self) -> bool {
        Self::NDERIV == 0 && self.re() == 0.0
    }
}
impl<S: DualNum<Primitive = f64> + Copy + Send + Sync> Scalar for S {}

/// What a model's author writes.
pub trait Formula: Send + Sync {
    fn dim(&self) -> usize;

    fn parameters(&self) -> &[Parameter];

    /// `g = M(u, p) v - F(u, p)`.
    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]);

    /// The pattern that `G_u` and `G_v` share.
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// `G_u` and `G_v` in matrices of that structure; by default with dual numbers, columns without a row in common
    /// together (Curtis, Powell and Reid 1974, doi:10.1093/imamat/13.1.117). A model may know better.
    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        let n = self.dim();
        let (mut u, mut v) = (lift(at.u), lift(at.v));
        let p = lift(at.p);
        let mut g = vec![Dual64::from_re(0.0); n];
        let groups: Vec<Vec<usize>> = match self.structure() {
            Structure::Dense => (0..n).map(|j| vec![j]).collect(),
            Structure::Banded { lower, upper } => {
                let stride = (lower + upper + 1).min(n);
                (0..stride).map(|first| (first..n).step_by(stride).collect()).collect()
            }
            Structure::Sparse(pattern) => pattern.groups().to_vec(),
        };
        let seed = |x: &mut [Dual64], group: &[usize], eps: f64| group.iter().for_each(|&j| x[j].eps = eps);
        for group in &groups {
            seed(&mut u, group, 1.0);
            self.residual(&u, &v, &p, &mut g);
            seed(&mut u, group, 0.0);
            store(gu, group, &g);
            seed(&mut v, group, 1.0);
            self.residual(&u, &v, &p, &mut g);
            seed(&mut v, group, 0.0);
            store(gv, group, &g);
        }
    }

    fn unknowns(&self) -> Vec<String> {
        Vec::new()
    }

    fn start(&self, _p: &[f64]) -> Vec<f64> {
        vec![0.0; self.dim()]
    }

    fn time_unit(&self) -> &'static str {
        ""
    }

    fn observables(&self) -> &[Observable] {
        &[]
    }

    fn observe(&self, _i: usize, _at: At) -> f64 {
        f64::NAN
    }

    fn reflection(&self) -> Option<Reflection> {
        None
    }

    /// Continuous symmetries; with the structure of G_u as it is without drift.
    fn rotations(&self) -> &[Rotation] {
        &[]
    }

    fn picture_unit(&self) -> &'static str {
        ""
    }

    fn picture(&self, _u: &[f64], _p: &[f64]) -> Option<Vec<[f64; 2]>> {
        None
    }

    fn refined(&self) -> Option<Refinement> {
        None
    }
}

/// Derivatives with respect to a group of columns that have no row in common.
fn store(matrix: &mut Matrix, group: &[usize], g: &[Dual64]) {
    for &j in group {
        match matrix {
            Matrix::Dense(a) => a.col_as_slice_mut(j).iter_mut().zip(g).for_each(|(a, g)| *a = g.eps),
            Matrix::Banded(a) => {
                for i in a.rows(j) {
                    let first = a.columns(i).start;
                    a.row_mut(i)[j - first] = g[i].eps;
                }
            }
            Matrix::Sparse(a) => {
                let (range, rows) = a.pattern.column(j);
                a.values[range].iter_mut().zip(rows).for_each(|(value, &i)| *value = g[i].eps);
            }
        }
    }
}

fn lift(x: &[f64]) -> Vec<Dual64> {
    x.iter().map(|&x| Dual64::from_re(x)).collect()
}

/// Entry `i` of a direction's part; an empty part is zero.
fn entry(part: &[f64], i: usize) -> f64 {
    part.get(i).copied().unwrap_or(0.0)
}

/// A [`Formula`] as a [`Problem`].
pub struct Automatic<F>(pub F);

impl<F: Formula> Automatic<F> {
    /// Evaluates the formula over numbers made from (value, index) by `seed`, one for each part of the joint space.
    fn evaluate<S: Scalar>(&self, at: At, seed: impl Fn(f64, fn(&Direction<'_>, usize) -> f64, usize) -> S) -> Vec<S> {
        let make = |values: &[f64], part: fn(&Direction<'_>, usize) -> f64| -> Vec<S> {
            values.iter().enumerate().map(|(i, &x)| seed(x, part, i)).collect()
        };
        let u = make(at.u, |d, i| entry(d.u, i));
        let v = make(at.v, |d, i| entry(d.v, i));
        let p = make(at.p, |d, i| entry(d.p, i));
        let mut g = vec![S::from(0.0); self.0.dim()];
        self.0.residual(&u, &v, &p, &mut g);
        g
    }
}

impl<F: Formula> Problem for Automatic<F> {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn parameters(&self) -> &[Parameter] {
        self.0.parameters()
    }

    fn unknowns(&self) -> Vec<String> {
        self.0.unknowns()
    }

    fn start(&self, p: &[f64]) -> Vec<f64> {
        self.0.start(p)
    }

    fn residual(&self, at: At, g: &mut [f64]) {
        self.0.residual(at.u, at.v, at.p, g);
    }

    fn structure(&self) -> Structure {
        self.0.structure()
    }

    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        self.0.linearise(at, gu, gv);
    }

    fn derivative(&self, at: At, directions: &[Direction], out: &mut [f64]) {
        match directions {
            [a] => {
                let g = self.evaluate(at, |x, part, i| Dual64::new(x, part(a, i)));
                out.iter_mut().zip(g).for_each(|(o, g)| *o = g.eps);
            }
            [a, b] => {
                let g = self.evaluate(at, |x, part, i| HyperDual64::new(x, part(a, i), part(b, i), 0.0));
                out.iter_mut().zip(g).for_each(|(o, g)| *o = g.eps1eps2);
            }
            [a, b, c] => {
                let g = self.evaluate(at, |x, part, i| {
                    HyperHyperDual64::new(x, part(a, i), part(b, i), part(c, i), 0.0, 0.0, 0.0, 0.0)
                });
                out.iter_mut().zip(g).for_each(|(o, g)| *o = g.eps1eps2eps3);
            }
            _ => unreachable!("derivatives are of order one to three"),
        }
    }

    /// With r the sum of two infinitesimals, one carried to third and one to second order, the derivative of order
    /// a in the first and b in the second is that of order a + b in r.
    fn coefficient(&self, at: At, terms: &[Direction], out: &mut [f64]) {
        let order = terms.len();
        debug_assert!((1..=5).contains(&order), "coefficients are of order one to five");
        let (a, b) = (order.min(3), order.saturating_sub(3));
        let one = Dual2_64::from_re(1.0);
        let r = Dual3::new(Dual2_64::new(0.0, 1.0, 0.0), one, one * 0.0, one * 0.0);
        let mut powers = vec![r];
        for _ in 1..order {
            powers.push(powers[powers.len() - 1] * r);
        }
        let value = |x: f64, part: &dyn Fn(&Direction<'_>) -> f64| {
            let start = Dual3::from_re(Dual2_64::from_re(x));
            terms.iter().zip(&powers).fold(start, |sum, (term, &power)| sum + power * part(term))
        };
        let make = |values: &[f64], part: fn(&Direction<'_>, usize) -> f64| -> Vec<Dual3<Dual2_64>> {
            values.iter().enumerate().map(|(i, &x)| value(x, &|term| part(term, i))).collect()
        };
        let (u, v) = (make(at.u, |d, i| entry(d.u, i)), make(at.v, |d, i| entry(d.v, i)));
        let p = make(at.p, |_, _| 0.0);
        let mut g = vec![Dual3::from_re(Dual2_64::from_re(0.0)); self.0.dim()];
        self.0.residual(&u, &v, &p, &mut g);
        let factorial = [1.0, 1.0, 2.0, 6.0, 24.0, 120.0][order];
        for (out, g) in out.iter_mut().zip(&g) {
            let outer = [g.re, g.v1, g.v2, g.v3][a];
            *out = [outer.re, outer.v1, outer.v2][b] / factorial;
        }
    }

    fn time_unit(&self) -> &'static str {
        self.0.time_unit()
    }

    fn observables(&self) -> &[Observable] {
        self.0.observables()
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        self.0.observe(i, at)
    }

    fn reflection(&self) -> Option<Reflection> {
        self.0.reflection()
    }

    fn rotations(&self) -> &[Rotation] {
        self.0.rotations()
    }

    fn picture_unit(&self) -> &'static str {
        self.0.picture_unit()
    }

    fn picture(&self, u: &[f64], p: &[f64]) -> Option<Vec<[f64; 2]>> {
        self.0.picture(u, p)
    }

    fn refined(&self) -> Option<Refinement> {
        self.0.refined()
    }
}

/// Largest relative difference between `linearise` and first directional derivatives of the residual: a check for
/// models that write their own `linearise`.
pub fn check_derivatives(problem: &dyn Problem, at: At) -> f64 {
    let n = problem.dim();
    let (gu, gv) = problem.linearised(at);
    let mut worst = 0.0_f64;
    let mut column = vec![0.0; n];
    let mut unit = vec![0.0; n];
    for (matrix, in_u) in [(gu, true), (gv, false)] {
        let scale = matrix.norm_max().max(f64::MIN_POSITIVE);
        for j in 0..n {
            unit[j] = 1.0;
            let (u, v): (&[f64], &[f64]) = if in_u { (&unit, &[]) } else { (&[], &unit) };
            problem.derivative(at, &[Direction { u, v, p: &[] }], &mut column);
            unit[j] = 0.0;
            for i in 0..n {
                worst = worst.max((column[i] - matrix[(i, j)]).abs() / scale);
            }
        }
    }
    worst
}
