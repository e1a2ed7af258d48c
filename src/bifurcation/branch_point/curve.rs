//! Curves of branch points in two parameters.
//!
//! In general a branch point needs two parameters and persists only where a symmetry, an invariant subspace, or a known
//! solution sees to it. What may be followed in (X, q, beta), X the state with the parameter of the branches and q the
//! other parameter, is
//!
//! ```text
//! H(X, q) + beta b = 0,        g(X, q) = 0,
//! ```
//!
//! g being the two scalars of the [module](super) and b a constant vector, that of the kernel of `H_X^T` at the start
//! (Govaerts 2000, doi:10.1137/1.9780898719543, chapter 8; MatCont's branch point curves). Branches cross where beta = 0; elsewhere
//! they would if the problem were changed by beta b. The solution of the linear system is by block elimination.

use super::{Frame, Place, Scales};
use crate::bifurcation::{Coordinate, Locus, Segment};
use crate::continuation::{Border, Counts, Factored, Failure, Point, System, correct, normalise};
use crate::linalg::{Lu, Singular, dot, unit};
use crate::problem::{At, Direction, Problem};
use faer::Mat;
use std::sync::Arc;

/// The system of a curve of branch points: x = (u, z1, beta), lambda = z2.
#[derive(Clone)]
pub struct BranchCurve {
    pub problem: Arc<dyn Problem>,
    /// All parameters; those of `first` and `second` are overwritten.
    p: Vec<f64>,
    pub first: Coordinate,
    pub second: Coordinate,
    /// Which of the two is that of the branches.
    own: usize,
    scales: Scales,
    scale_state: f64,
    /// What beta counts in.
    pub size: f64,
    /// The constant vector b.
    pub unfolding: Vec<f64>,
    c: [Vec<f64>; 2],
    b: Vec<f64>,
}

impl BranchCurve {
    /// The system near a branch point (u, p) of branches in the parameter with index `free`, one of the two, and the point
    /// of the curve there, with a tangent along which z2 does not fall.
    pub fn start(
        problem: Arc<dyn Problem>,
        (u, p): (&[f64], &[f64]),
        (first, second): (Coordinate, Coordinate),
        free: usize,
        counts: &mut Counts,
    ) -> Result<(Self, Point), Failure> {
        let n = problem.dim();
        let rms = (dot(u, u) / n as f64).sqrt();
        // A branch point at zero is stored up to rounding.
        let scale_state = if rms > f64::EPSILON { rms } else { 1.0 };
        let own = usize::from(free != first.index);
        let axis = [first, second][own];
        let parameter = axis.width.abs() * axis.rate(axis.of(p[axis.index])).abs();
        let any = |k: usize| unit(&(0..=n).map(|i| 1.0 + ((7 - 4 * k) * i + k) as f64 % 5.0).collect::<Vec<_>>());
        let mut curve = Self {
            problem,
            p: p.to_vec(),
            first,
            second,
            own,
            scales: Scales { state: scale_state * (n as f64).sqrt(), parameter },
            scale_state,
            size: 1.0,
            unfolding: Vec::new(),
            c: [any(0), any(1)],
            b: unit(&any(0)[..n]),
        };
        let mut x = u.to_vec();
        x.extend([first.of(p[first.index]), 0.0]);
        let lambda = second.of(p[second.index]);
        let mut point = Point { tangent: vec![0.0; n + 2], x, lambda, tangent_lambda: 0.0 };
        // No vectors are known to be near the kernels; a few inverse iterations from any make some.
        for _ in 0..3 {
            curve.prepare(&mut point);
        }
        curve.size = curve.frame(&point.x, lambda)?.size * scale_state;
        curve.unfolding = curve.b.clone();
        // A border across the curve is not known: the unknown that may be held is the one along which the curve runs.
        let along = |k: usize| {
            let mut border = Border { row: vec![0.0; n + 2], lambda: 0.0 };
            match k {
                0 => border.lambda = 1.0 / second.width,
                1 => border.row[n] = 1.0 / first.width,
                2 => border.row[..n].copy_from_slice(&curve.c[0][..n]),
                _ => border.row[n + 1] = 1.0 / curve.size,
            }
            border
        };
        let found = (0..4).find_map(|k| correct(&curve, (point.x.clone(), lambda), &along(k), counts).ok());
        let mut point = found.ok_or(Failure::Singular(Singular))?.point;
        if point.tangent_lambda < 0.0 || point.tangent_lambda == 0.0 && point.tangent[n] < 0.0 {
            crate::bifurcation::reverse(&mut point);
        }
        Ok((curve, point))
    }

    /// All parameters at a point.
    pub fn parameters(&self, point: &Point) -> Vec<f64> {
        self.values(self.coordinates(point))
    }

    /// By how much of b the problem must be changed for the branches to cross here.
    pub fn imperfection(&self, point: &Point) -> f64 {
        point.x[self.problem.dim() + 1]
    }

    fn values(&self, z: [f64; 2]) -> Vec<f64> {
        let mut p = self.p.clone();
        for (coordinate, z) in [self.first, self.second].into_iter().zip(z) {
            p[coordinate.index] = coordinate.value(z);
        }
        p
    }

    fn place(&self) -> Place<'_> {
        let free = [self.first, self.second][self.own].index;
        Place { problem: &*self.problem, free, scales: self.scales }
    }

    fn frame(&self, x: &[f64], lambda: f64) -> Result<Frame, Singular> {
        let n = self.problem.dim();
        let (rest, p) = (vec![0.0; n], self.values([x[n], lambda]));
        Frame::new(&self.place(), At { u: &x[..n], v: &rest, p: &p }, &self.c, &self.b)
    }
}

impl Locus for BranchCurve {
    /// Which coordinate takes which value.
    type Test = (usize, f64);
    const SMALL: f64 = 1e-5;

    fn axes(&self) -> [Coordinate; 2] {
        [self.first, self.second]
    }

    fn coordinates(&self, point: &Point) -> [f64; 2] {
        [point.x[self.problem.dim()], point.lambda]
    }

    fn taking(k: usize, goal: f64) -> (usize, f64) {
        (k, goal)
    }

    fn goal((k, goal): (usize, f64)) -> Option<f64> {
        (k == 1).then_some(goal)
    }

    fn value(step: &Segment<Self>, (k, goal): (usize, f64), point: &Point) -> f64 {
        step.curve.coordinates(point)[k] - goal
    }
}

impl System for BranchCurve {
    type Factors = BranchFactors;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        let n = self.problem.dim();
        let (rest, p) = (vec![0.0; n], self.values([x[n], lambda]));
        self.problem.residual(At { u: &x[..n], v: &rest, p: &p }, &mut r[..n]);
        r[..n].iter_mut().zip(&self.unfolding).for_each(|(r, b)| *r += x[n + 1] * b);
        // A singular bordered matrix has no scalars: the residual then is not a number, and the step fails.
        let g = self.frame(x, lambda).map_or([f64::NAN; 2], |frame| frame.g);
        r[n..].copy_from_slice(&g);
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<BranchFactors, Singular> {
        BranchFactors::new(self, x, lambda, border)
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        let n = self.problem.dim();
        let state = 1.0 / (n as f64 * self.scale_state.powi(2));
        let mut out: Vec<f64> = t[..n].iter().map(|t| state * t).collect();
        out.extend([t[n] / self.first.width.powi(2), t[n + 1] / self.size.powi(2)]);
        out
    }

    fn dual_lambda(&self) -> f64 {
        self.second.width.powi(-2)
    }

    /// Takes the kernels' vectors at the point as borders; the tangent is normalised anew.
    fn prepare(&mut self, point: &mut Point) -> bool {
        if let Ok(frame) = self.frame(&point.x, point.lambda) {
            (self.c, self.b) = frame.borders();
        }
        normalise(self, point);
        false
    }
}

/// The factored Jacobian: four equations for the parts of dX along Q, the other coordinate's change and dbeta are left.
pub struct BranchFactors {
    curve: BranchCurve,
    u: Vec<f64>,
    p: Vec<f64>,
    frame: Frame,
    /// Solutions for G_q, q the other coordinate, and for b.
    columns: [Vec<f64>; 2],
    /// dX to (du, dz): the change of the own coordinate for a unit of the scaled parameter.
    rate: f64,
    row: Vec<f64>,
    small: Lu<f64>,
    sizes: [f64; 4],
}

impl BranchFactors {
    fn new(curve: &BranchCurve, x: &[f64], lambda: f64, border: &Border) -> Result<Self, Singular> {
        let n = curve.problem.dim();
        let z = [x[n], lambda];
        let (own, other) = (curve.own, 1 - curve.own);
        let axes = [curve.first, curve.second];
        let (frame, p) = (curve.frame(x, lambda)?, curve.values(z));
        let mut e = vec![0.0; p.len()];
        e[axes[other].index] = axes[other].rate(z[other]);
        let (mut by_other, rest) = (vec![0.0; n], vec![0.0; n]);
        let at = At { u: &x[..n], v: &rest, p: &p };
        curve.problem.derivative(at, &[Direction { u: &[], v: &[], p: &e }], &mut by_other);
        let parts = [border.row[n], border.lambda];
        // (u, own, other, beta)
        let row = [&border.row[..n], &[parts[own], parts[other], border.row[n + 1]]].concat();
        let mut factors = Self {
            rate: curve.scales.parameter / curve.scales.state / axes[own].rate(z[own]),
            u: x[..n].to_vec(),
            columns: [solve(&frame, &by_other), solve(&frame, &curve.unfolding)],
            row,
            small: Lu::new(Mat::<f64>::identity(4, 4))?,
            sizes: [1.0; 4],
            curve: curve.clone(),
            frame,
            p,
        };
        let zero = vec![0.0; n + 1];
        let mut small = Mat::zeros(4, 4);
        for k in 0..2 {
            let q = &factors.frame.q[k];
            small[(0, k)] = factors.frame.g[k];
            small[(3, k)] = factors.held(q);
            let column = &factors.columns[k];
            small[(0, 2 + k)] = -column[n + 1];
            small[(3, 2 + k)] = factors.row[n + 1 + k] - factors.held(column);
            for j in 0..2 {
                small[(1 + j, k)] = factors.bend(j, q, &[]);
                small[(1 + j, 2 + k)] = -factors.bend(j, column, &[]);
            }
        }
        for j in 0..2 {
            small[(1 + j, 2)] += factors.bend(j, &zero, &e);
        }
        // Rows of one size: the pivots of so small a system would otherwise depend on units.
        factors.sizes = [0, 1, 2, 3].map(|i| (0..4).map(|j| small[(i, j)].abs()).fold(f64::MIN_POSITIVE, f64::max));
        let small = Mat::from_fn(4, 4, |i, j| small[(i, j)] / factors.sizes[i]);
        factors.small = Lu::new(small)?;
        Ok(factors)
    }

    /// The border's product with a direction dX.
    fn held(&self, x: &[f64]) -> f64 {
        let n = self.u.len();
        dot(&self.row[..n], &x[..n]) + self.row[n] * self.rate * x[n]
    }

    /// dg_j along dX and a direction of the parameters.
    fn bend(&self, j: usize, x: &[f64], dp: &[f64]) -> f64 {
        let n = self.u.len();
        let place = self.curve.place();
        let (q, d) = (place.unscaled(&self.frame.q[j]), place.unscaled(&x[..=n]));
        let (mut of_q, mut of_d) = (vec![0.0; self.p.len()], vec![0.0; self.p.len()]);
        (of_q[place.free], of_d[place.free]) = (q.p, d.p);
        of_d.iter_mut().zip(dp).for_each(|(p, dp)| *p += dp);
        let (rest, mut out) = (vec![0.0; n], vec![0.0; n]);
        let at = At { u: &self.u, v: &rest, p: &self.p };
        let directions = [Direction { u: &q.u, v: &[], p: &of_q }, Direction { u: &d.u, v: &[], p: &of_d }];
        self.curve.problem.derivative(at, &directions, &mut out);
        -dot(&self.frame.w, &out)
    }
}

/// (dX, mu) for a right-hand side.
fn solve(frame: &Frame, right: &[f64]) -> Vec<f64> {
    let mut x = right.to_vec();
    x.extend([0.0, 0.0]);
    frame.matrix.solve(&mut x);
    x
}

impl Factored for BranchFactors {
    fn solve(&self, right: &mut [f64]) {
        let n = self.u.len();
        let known = solve(&self.frame, &right[..n]);
        let bent = [0, 1].map(|j| self.bend(j, &known, &[]));
        let mut y = [-known[n + 1], right[n] - bent[0], right[n + 1] - bent[1], right[n + 2] - self.held(&known)];
        y.iter_mut().zip(&self.sizes).for_each(|(y, size)| *y /= size);
        self.small.solve(&mut y);
        let [t0, t1, other, beta] = y;
        let [by_other, by_beta] = &self.columns;
        let q = &self.frame.q;
        let x = |i: usize| known[i] + t0 * q[0][i] + t1 * q[1][i] - other * by_other[i] - beta * by_beta[i];
        (0..n).for_each(|i| right[i] = x(i));
        let own = self.rate * x(n);
        let z = if self.curve.own == 0 { [own, other] } else { [other, own] };
        (right[n], right[n + 1], right[n + 2]) = (z[0], beta, z[1]);
    }
}
