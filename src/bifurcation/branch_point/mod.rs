//! Simple branch points of equilibria on their defining system: two curves of solutions cross.
//!
//! With X = (u, m), m the parameter in parts of a width, and `H(X) = G(u, 0, p)`, the n by n + 1 matrix H_X loses its rank. Then
//! g, the two scalars of
//!
//! ```text
//! [ H_X  b ] [ Q ]   [ 0 ]        [ H_X^T  C ] [w]   [0]
//! [ C^T  0 ] [g^T] = [ I ],       [ b^T    0 ] [g] = [1],        Q n + 1 by 2,
//! ```
//!
//! vanish, and `dg_j = -w^T D²H[Q_j, d]`. Newton's method on `H + beta b = 0, g = 0` in (X, beta) converges
//! quadratically, and by block elimination needs solves with this one matrix (Govaerts 2000,
//! doi:10.1137/1.9780898719543, chapter 8). beta = 0 says that the curves do cross: at an imperfect bifurcation they
//! only come close. Tangents T = Q t of the two curves solve the algebraic branching equation `w^T D²H[T, T] = 0`
//! (Keller 1977, Applications of Bifurcation Theory, 359-384).

mod curve;
mod form;

pub use curve::BranchCurve;
pub use form::BranchForm;

use super::steady::size;
use crate::continuation::Failure;
use crate::linalg::{BorderedMatrix, Lu, Matrix, Singular, any, dot, finite, unit};
use crate::problem::{At, Direction, Problem};
use faer::Mat;
use thiserror::Error;

/// A direction of (u, p), p being the free parameter.
#[derive(Clone, Debug)]
pub struct Tangent {
    pub u: Vec<f64>,
    pub p: f64,
}

/// What counts as much: a change of the state by `state` (in the Euclidean norm) and of the parameter by `parameter`.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    pub state: f64,
    pub parameter: f64,
}

/// A branch point.
#[derive(Clone, Debug)]
pub struct BranchPoint {
    pub u: Vec<f64>,
    pub p: Vec<f64>,
    /// Tangents of the curve that was followed and of the other one, of unit length in these scales.
    pub along: Tangent,
    pub across: Tangent,
    pub form: BranchForm,
    /// The last Newton step in the parameter: what rounding leaves open.
    pub rounding: f64,
}

#[derive(Debug, Error, PartialEq)]
pub enum BranchError {
    #[error(transparent)]
    Newton(#[from] Failure),
    #[error("the curves only come close (a residual of {0:.1e} is left)")]
    Imperfect(f64),
    #[error("the point is degenerate: no two curves with different tangents cross there")]
    Degenerate,
}

impl From<Singular> for BranchError {
    fn from(failure: Singular) -> Self {
        Self::Newton(failure.into())
    }
}

const MOST_STEPS: usize = 25;
/// Of two entries as large as this in parts of each other, the first counts.
const NEARLY: f64 = 0.9;
/// beta b in parts of G_u and the state's scale: less is rounding.
const IMPERFECT: f64 = 1e-8;

/// The problem near a branch point.
pub(super) struct Place<'a> {
    pub problem: &'a dyn Problem,
    pub free: usize,
    pub scales: Scales,
}

impl Place<'_> {
    /// A vector of the scaled space as a direction of (u, p).
    fn unscaled(&self, x: &[f64]) -> Tangent {
        let n = x.len() - 1;
        Tangent { u: x[..n].to_vec(), p: x[n] * self.scales.parameter / self.scales.state }
    }

    /// `-w^T D²G[a, b]`.
    pub fn second(&self, at: At, w: &[f64], a: &Tangent, b: &Tangent) -> f64 {
        let unit = |p: f64| {
            let mut e = vec![0.0; at.p.len()];
            e[self.free] = p;
            e
        };
        let (p, q) = (unit(a.p), unit(b.p));
        let mut out = vec![0.0; w.len()];
        let directions = [Direction { u: &a.u, v: &[], p: &p }, Direction { u: &b.u, v: &[], p: &q }];
        self.problem.derivative(at, &directions, &mut out);
        -dot(w, &out)
    }
}

/// The bordered matrix at a trial point.
struct Frame {
    matrix: BorderedMatrix,
    q: [Vec<f64>; 2],
    g: [f64; 2],
    w: Vec<f64>,
    mass: Matrix,
    size: f64,
}

impl Frame {
    /// Borders are `c` and, of length one, `b`.
    fn new(place: &Place, at: At, c: &[Vec<f64>; 2], b: &[f64]) -> Result<Self, Singular> {
        let n = at.u.len();
        let (gu, mass) = place.problem.matrices(at);
        let size = size(&gu);
        let mut e = vec![0.0; at.p.len()];
        e[place.free] = place.scales.parameter / place.scales.state;
        let mut by_parameter = vec![0.0; n];
        place.problem.derivative(at, &[Direction { u: &[], v: &[], p: &e }], &mut by_parameter);
        let scaled = |x: &[f64]| -> Vec<f64> { x.iter().map(|x| size * x).collect() };
        let (b, c) = (scaled(b), [scaled(&c[0]), scaled(&c[1])]);
        let rows: [&[f64]; 2] = [&c[0][..n], &c[1][..n]];
        let corner: [&[f64]; 2] = [&[c[0][n], 0.0], &[c[1][n], 0.0]];
        let matrix = BorderedMatrix::new(&gu, &[&by_parameter, &b], &rows, &corner)?;
        let mut found = Self { matrix, q: [Vec::new(), Vec::new()], g: [0.0; 2], w: Vec::new(), mass, size };
        for j in 0..2 {
            let mut x = vec![0.0; n + 2];
            x[n + j] = size;
            found.matrix.solve(&mut x);
            found.g[j] = x[n + 1];
            x.truncate(n + 1);
            found.q[j] = x;
        }
        let mut w = vec![0.0; n + 2];
        w[n + 1] = 1.0;
        found.matrix.solve_transposed(&mut w);
        w.truncate(n);
        found.w = w;
        if finite(&found.w) && finite(&found.q[0]) && finite(&found.q[1]) { Ok(found) } else { Err(Singular) }
    }

    /// The kernel's vectors as borders: orthonormal, and w of length one.
    fn borders(&self) -> ([Vec<f64>; 2], Vec<f64>) {
        let first = unit(&self.q[0]);
        let along = dot(&first, &self.q[1]);
        let rest: Vec<f64> = self.q[1].iter().zip(&first).map(|(q, f)| q - along * f).collect();
        ([first, unit(&rest)], unit(&self.w))
    }
}

impl BranchPoint {
    /// Solves for a branch point near (u, p) with `p[free]` unknown, `tangent` being that of the curve that is followed.
    pub fn locate(
        problem: &dyn Problem,
        (u, p): (&[f64], &[f64]),
        (free, scales): (usize, Scales),
        tangent: &Tangent,
    ) -> Result<Self, BranchError> {
        let n = u.len();
        let place = Place { problem, free, scales };
        let rest = vec![0.0; n];
        let (mut u, mut p) = (u.to_vec(), p.to_vec());
        let mut chord = tangent.u.clone();
        chord.push(tangent.p * scales.state / scales.parameter);
        let chord = unit(&chord);
        // Of the kernels no more is known than the tangent; a few inverse iterations find them.
        let (mut c, mut b) = ([chord.clone(), unit(&any(n + 1))], unit(&any(n)));
        for _ in 0..3 {
            (c, b) = Frame::new(&place, At { u: &u, v: &rest, p: &p }, &c, &b)?.borders();
        }
        let (mut largest, mut last) = (f64::MIN_POSITIVE, f64::INFINITY);
        for step in 0..MOST_STEPS {
            let at = At { u: &u, v: &rest, p: &p };
            let frame = Frame::new(&place, at, &c, &b)?;
            let mut residual = vec![0.0; n];
            problem.residual(at, &mut residual);
            let mut particular: Vec<f64> = residual.iter().map(|r| -r).collect();
            particular.extend([0.0, 0.0]);
            frame.matrix.solve(&mut particular);
            let beta = particular[n + 1];
            particular.truncate(n + 1);
            let q = [0, 1].map(|j| place.unscaled(&frame.q[j]));
            let moved = place.unscaled(&particular);
            // dX = X0 + Q t with g + dg = 0; dg_j = w^T-product of D²H, `second` having its sign.
            let bend = |x: &Tangent, y: &Tangent| place.second(at, &frame.w, x, y) * frame.size;
            let m = [[bend(&q[0], &q[0]), bend(&q[0], &q[1])], [bend(&q[1], &q[0]), bend(&q[1], &q[1])]];
            let most = m.iter().flatten().fold(f64::MIN_POSITIVE, |most, x| x.abs().max(most));
            let small = Mat::from_fn(2, 2, |i, j| m[i][j] / most);
            let mut t = [0, 1].map(|j| -(frame.g[j] * frame.size + bend(&q[j], &moved)) / most);
            Lu::new(small).map_err(|_| BranchError::Degenerate)?.solve(&mut t);
            let d: Vec<f64> = (0..=n).map(|i| particular[i] + t[0] * frame.q[0][i] + t[1] * frame.q[1][i]).collect();
            let step_of = place.unscaled(&d);
            if !finite(&d) {
                return Err(Failure::NotFinite.into());
            }
            u.iter_mut().zip(&step_of.u).for_each(|(u, d)| *u += d);
            p[free] += step_of.p;
            let left = beta + frame.g[0] * t[0] + frame.g[1] * t[1];
            largest = largest.max(p[free].abs()).max(step_of.p.abs());
            let size = dot(&d, &d).sqrt() / scales.state;
            (c, b) = frame.borders();
            if size < 1e-15 || (size < 1e-8 && step > 1 && size > 0.3 * last) {
                if left.abs() > IMPERFECT * scales.state {
                    return Err(BranchError::Imperfect(left.abs() / scales.state));
                }
                let frame = Frame::new(&place, At { u: &u, v: &rest, p: &p }, &c, &b)?;
                return Self::formed(&place, (u, p), &frame, &chord, step_of.p.abs());
            }
            if size > 1e6 {
                return Err(Failure::Diverged(size).into());
            }
            last = size;
        }
        Err(Failure::Diverged(last).into())
    }

    /// Tangents by the algebraic branching equation, and the normal form.
    fn formed(
        place: &Place,
        (u, p): (Vec<f64>, Vec<f64>),
        frame: &Frame,
        chord: &[f64],
        rounding: f64,
    ) -> Result<Self, BranchError> {
        let rest = vec![0.0; u.len()];
        let at = At { u: &u, v: &rest, p: &p };
        let (orthonormal, w) = frame.borders();
        let q = [0, 1].map(|j| place.unscaled(&orthonormal[j]));
        let bend = |i: usize, j: usize| place.second(at, &w, &q[i], &q[j]);
        let (m11, m12, m22) = (bend(0, 0), bend(0, 1), bend(1, 1));
        let discriminant = m12 * m12 - m11 * m22;
        let scale = m12 * m12 + m11.abs().max(m22.abs()).powi(2);
        if discriminant.is_nan() || discriminant <= 1e-10 * scale {
            return Err(BranchError::Degenerate);
        }
        // Both roots without cancellation.
        let s = m12 + discriminant.sqrt().copysign(m12);
        let mut tangents: Vec<Vec<f64>> = [(-s, m11), (m22, -s)]
            .iter()
            .map(|(x, y)| {
                unit(&orthonormal[0].iter().zip(&orthonormal[1]).map(|(a, b)| x * a + y * b).collect::<Vec<_>>())
            })
            .collect();
        tangents.sort_by(|a, b| dot(b, chord).abs().total_cmp(&dot(a, chord).abs()));
        let n = u.len();
        if dot(&tangents[0], chord) < 0.0 {
            tangents[0].iter_mut().for_each(|t| *t = -*t);
        }
        if tangents[1][n] < 0.0 {
            tangents[1].iter_mut().for_each(|t| *t = -*t);
        }
        // The kernel of G_u itself: the combination without a part in the parameter.
        let parts = [orthonormal[0][n], orthonormal[1][n]];
        if parts[0].hypot(parts[1]) < 1e-6 {
            return Err(BranchError::Degenerate);
        }
        let kernel: Vec<f64> = (0..n).map(|i| parts[1] * orthonormal[0][i] - parts[0] * orthonormal[1][i]).collect();
        let form = BranchForm::new(place, at, (&kernel, &w), &tangents, &frame.mass)?;
        if form.pitchfork() {
            // The curve of the new states is vertical; rounding is not to decide to which side it leans, nor on which it is
            // entered: on that of the largest entry.
            let vertical = if tangents[0][n].abs() < tangents[1][n].abs() { 0 } else { 1 };
            tangents[vertical][n] = 0.0;
            let most = tangents[1].iter().fold(0.0_f64, |most, t| most.max(t.abs()));
            if vertical == 1 && tangents[1].iter().find(|t| t.abs() > NEARLY * most).is_some_and(|&t| t < 0.0) {
                tangents[1].iter_mut().for_each(|t| *t = -*t);
            }
        }
        let (along, across) = (place.unscaled(&tangents[0]), place.unscaled(&tangents[1]));
        Ok(Self { along, across, form, rounding, u, p })
    }
}
