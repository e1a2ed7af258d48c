//! Corrections with factors that are already there, from the last point of the curve.
//!
//! Anderson's method, which is GMRES as far as H is linear: with `f(x) = -B^-1 H(x)`, B the old matrix, the next iterate is
//! what f leads to from that point among the affine combinations of all iterates so far where f is smallest,
//!
//! ```text
//! x_{k+1} = x_k + f_k - sum_j c_j (dx_j + df_j),      |f_k - sum_j c_j df_j| -> min in the metric,
//! ```
//!
//! dx_j and df_j the changes from one iterate to the next (Walker and Ni 2011, doi:10.1137/10078356X; with Broyden's
//! method, which keeps one secant a step, curves turn out to need two to four steps more). It converges superlinearly for the
//! price of a residual and a solution a step; a factorisation costs as much as dozens of those in large systems.

use super::{Border, Counts, Factored, Failure, Point, System, inner};
use crate::linalg::{dot, finite};

/// Where what is left shrinks less than this in three steps, the factors are of no use here;
const SLOWEST: f64 = 0.5;
/// but it never grows more than this.
const WORST: f64 = 5.0;
/// No step is relied on to leave less than this of |f|, nor less than the last one left, for f is not quite linear: where
/// few directions matter, the least is zero after as many steps.
const FASTEST: f64 = 0.1;
const MOST_STEPS: usize = 12;

/// A solution on a hyperplane through the start.
pub struct Settled {
    pub x: Vec<f64>,
    pub lambda: f64,
    pub steps: usize,
    /// Distance between start and solution.
    pub distance: f64,
}

/// An iterate, and what the steps to it have taught.
pub struct Chord<'a, S: System> {
    system: &'a S,
    factors: &'a S::Factors,
    plane: Option<Plane<'a>>,
    pub x: Vec<f64>,
    pub lambda: f64,
    /// The last step with the f before it,
    last: Option<(Vec<f64>, Vec<f64>)>,
    /// and the length of that f.
    size: f64,
    /// Changes of f, made orthonormal, each with the same combination of the changes of the iterate.
    pairs: Vec<(Vec<f64>, Vec<f64>)>,
}

/// Another hyperplane than that of the factors' own border: steps move onto it along the tangent where the factors are from.
#[derive(Clone, Copy)]
pub struct Plane<'a> {
    pub border: &'a Border,
    pub along: &'a Point,
}

impl Plane<'_> {
    /// `f - t (border . f) / (border . t)`: both fulfil all equations but the border's.
    fn project(&self, f: &mut [f64]) {
        let Self { border, along } = self;
        let n = f.len() - 1;
        let slope = dot(&border.row, &along.tangent) + border.lambda * along.tangent_lambda;
        let share = (dot(&border.row, &f[..n]) + border.lambda * f[n]) / slope;
        add(-share, &along.tangent, &mut f[..n]);
        f[n] -= share * along.tangent_lambda;
    }
}

impl<'a, S: System> Chord<'a, S> {
    /// On the hyperplane of the factors' own border where no other is given.
    pub fn new(system: &'a S, (x, lambda): (Vec<f64>, f64), factors: &'a S::Factors, plane: Option<Plane<'a>>) -> Self {
        Self { system, factors, plane, x, lambda, last: None, size: f64::INFINITY, pairs: Vec::new() }
    }

    /// One step; the distance that is left to the solution: as much of the step's length as of f where f is linear, or as
    /// the last step left.
    pub fn advance(&mut self, counts: &mut Counts) -> Result<f64, Failure> {
        let n = self.x.len();
        let product = |a: &[f64], b: &[f64]| inner(self.system, (&a[..n], a[n]), (&b[..n], b[n]));
        let mut f = vec![0.0; n + 1];
        self.system.residual(&self.x, self.lambda, &mut f[..n]);
        counts.residuals += 1;
        if !finite(&f) {
            return Err(Failure::NotFinite);
        }
        self.factors.solve(&mut f);
        counts.newton += 1;
        if let Some(plane) = &self.plane {
            plane.project(&mut f);
        }
        f.iter_mut().for_each(|f| *f = -*f);
        if let Some((mut p, before)) = self.last.take() {
            let mut q: Vec<f64> = f.iter().zip(&before).map(|(f, before)| f - before).collect();
            for (p_j, q_j) in &self.pairs {
                let share = product(q_j, &q);
                add(-share, q_j, &mut q);
                add(-share, p_j, &mut p);
            }
            let length = product(&q, &q).sqrt();
            if length > 0.0 {
                p.iter_mut().chain(&mut q).for_each(|entry| *entry /= length);
                self.pairs.push((p, q));
            }
        }
        let (mut step, mut left) = (f.clone(), f.clone());
        for (p, q) in &self.pairs {
            let share = product(q, &left);
            add(-share, q, &mut left);
            add(-share, q, &mut step);
            add(-share, p, &mut step);
        }
        if !finite(&step) {
            return Err(Failure::NotFinite);
        }
        add(1.0, &step[..n], &mut self.x);
        self.lambda += step[n];
        let [left, size, length] = [&left, &f, &step].map(|x| product(x, x).sqrt());
        let rate = (size / self.size).clamp(FASTEST, 1.0);
        (self.last, self.size) = (Some((step, f)), size);
        // f is the distance as the old matrix sees it, the step as it has become.
        Ok(if size > 0.0 { rate.max(left / size) * size.max(length) } else { 0.0 })
    }
}

/// `y += factor x`.
fn add(factor: f64, x: &[f64], y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += factor * x);
}

/// Solves `H = 0` from a start to a tolerance; an error where the factors are too far from those of the solution.
pub fn settle<S: System>(
    system: &S,
    start: (Vec<f64>, f64),
    (factors, plane): (&S::Factors, Option<Plane>),
    tolerance: f64,
    counts: &mut Counts,
) -> Result<Settled, Failure> {
    let mut chord = Chord::new(system, start.clone(), factors, plane);
    let mut last = [f64::INFINITY; 3];
    for count in 1..=MOST_STEPS {
        let left = chord.advance(counts)?;
        if left < tolerance {
            let Chord { x, lambda, .. } = chord;
            let difference: Vec<f64> = x.iter().zip(&start.0).map(|(a, b)| a - b).collect();
            let moved = (&difference[..], lambda - start.1);
            let distance = inner(system, moved, moved).sqrt();
            return Ok(Settled { x, lambda, steps: count, distance });
        }
        if left > SLOWEST * last[2] || left > WORST * last[0] {
            return Err(Failure::Diverged(left));
        }
        last = [left, last[0], last[1]];
    }
    Err(Failure::Diverged(last[0]))
}
