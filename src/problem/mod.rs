//! What is followed: `M(u, p) u' = F(u, p)`, written as one implicit residual
//!
//! ```text
//! G(u, v, p) = M(u, p) v - F(u, p) = 0,      v = u'.
//! ```
//!
//! Equilibria solve `G(u, 0, p) = 0`; the linearisation of a motion is `G_v w' + G_u w = 0`, so that at an equilibrium
//! `G_v = M` and `G_u = -J`, and eigenvalues solve `(G_u + sigma G_v) q = 0`. Orbits solve `G(u, u', p) = 0`. One
//! function and its exact derivatives in the joint space (u, v, p) serve everything; a solution-dependent mass
//! needs no special case.

mod automatic;
mod rotation;
mod tied;

pub use automatic::{Automatic, Formula, Scalar, check_derivatives};
pub use rotation::Rotation;
pub use tied::{Tie, Tied};

use crate::linalg::{Matrix, Structure};
use faer::Mat;
use std::sync::Arc;

/// A parameter of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    pub name: &'static str,
    pub default: Default,
    /// "" for a pure number.
    pub unit: &'static str,
    pub meaning: &'static str,
    pub bounds: Bounds,
}

impl Parameter {
    /// With a number as default.
    pub const fn new(
        name: &'static str,
        value: f64,
        unit: &'static str,
        bounds: Bounds,
        meaning: &'static str,
    ) -> Self {
        Self { name, default: Default::Value(value), unit, meaning, bounds }
    }
}

/// A parameter's value when a scene says nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    Value(f64),
    /// An expression in other parameters that a scene may replace.
    Tie(&'static str),
    /// An expression in other parameters that no scene may replace: a name for use in other expressions.
    Derived(&'static str),
}

/// Values for which the model makes sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bounds {
    Any,
    Positive,
    NonNegative,
    /// Both ends included; they may be infinite.
    Within(f64, f64),
}

impl Bounds {
    pub fn contain(self, x: f64) -> bool {
        match self {
            Bounds::Any => x.is_finite(),
            Bounds::Positive => x.is_finite() && x > 0.0,
            Bounds::NonNegative => x.is_finite() && x >= 0.0,
            Bounds::Within(least, most) => x.is_finite() && (least..=most).contains(&x),
        }
    }
}

impl std::fmt::Display for Bounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Bounds::Any => f.write_str("any number"),
            Bounds::Positive => f.write_str("> 0"),
            Bounds::NonNegative => f.write_str(">= 0"),
            Bounds::Within(least, f64::INFINITY) => write!(f, ">= {least}"),
            Bounds::Within(f64::NEG_INFINITY, most) => write!(f, "<= {most}"),
            Bounds::Within(least, most) => write!(f, "from {least} to {most}"),
        }
    }
}

/// A named functional of the motion with its unit: a tip deflection, an energy.
#[derive(Clone, Debug, PartialEq)]
pub struct Observable {
    pub name: &'static str,
    pub unit: &'static str,
    pub meaning: &'static str,
}

/// A linear map `(S u)_i = sign_i u_{source_i}` that takes solutions to solutions.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflection {
    pub source: Vec<usize>,
    pub sign: Vec<f64>,
}

impl Reflection {
    pub fn identity(n: usize) -> Self {
        Self { source: (0..n).collect(), sign: vec![1.0; n] }
    }

    /// `S = -1`.
    pub fn negation(n: usize) -> Self {
        Self { source: (0..n).collect(), sign: vec![-1.0; n] }
    }

    pub fn apply(&self, u: &[f64], out: &mut [f64]) {
        for (i, o) in out.iter_mut().enumerate() {
            *o = self.sign[i] * u[self.source[i]];
        }
    }

    /// `out += S^T row`, for a row vector that acts on `S u`.
    pub fn add_transposed(&self, row: &[f64], out: &mut [f64]) {
        for (i, r) in row.iter().enumerate() {
            out[self.source[i]] += self.sign[i] * r;
        }
    }
}

/// A point of the joint space (u, v, p).
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub p: &'a [f64],
}

/// A direction of the joint space; an empty slice stands for zero.
#[derive(Clone, Copy, Debug)]
pub struct Direction<'a> {
    pub u: &'a [f64],
    pub v: &'a [f64],
    pub p: &'a [f64],
}

/// A map of states into a finer space.
pub type Prolongation = Box<dyn Fn(&[f64]) -> Vec<f64> + Send + Sync>;

/// A finer discretisation of the same model and the map of states into it.
pub struct Refinement {
    pub problem: Arc<dyn Problem>,
    pub prolong: Prolongation,
}

/// `G(u, v, p) = M(u, p) v - F(u, p)` and its exact derivatives. Object safe: the call costs nothing next to the work.
pub trait Problem: Send + Sync {
    /// Number of unknowns and of equations.
    fn dim(&self) -> usize;

    fn parameters(&self) -> &[Parameter];

    /// The names of the unknowns in their order; empty where they have none.
    fn unknowns(&self) -> Vec<String> {
        Vec::new()
    }

    /// A start for equilibria.
    fn start(&self, _p: &[f64]) -> Vec<f64> {
        vec![0.0; self.dim()]
    }

    /// `g = G(u, v, p)`; lengths `dim`.
    fn residual(&self, at: At, g: &mut [f64]);

    /// The pattern of `G_u` and `G_v`.
    fn structure(&self) -> Structure {
        Structure::Dense
    }

    /// `gu = G_u`, `gv = G_v = M`; both `dim` by `dim` and of the problem's structure, overwritten.
    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix);

    /// Both, in matrices of their own.
    fn matrices(&self, at: At) -> (Matrix, Matrix) {
        let zeros = || Matrix::zeros(self.structure(), self.dim());
        let (mut gu, mut gv) = (zeros(), zeros());
        self.linearise(at, &mut gu, &mut gv);
        (gu, gv)
    }

    /// Both as dense matrices, for what is done once at a point.
    fn linearised(&self, at: At) -> (Mat<f64>, Mat<f64>) {
        let (gu, gv) = self.matrices(at);
        (gu.into_dense(), gv.into_dense())
    }

    /// The derivative of G along one, two or three directions: `D^k G [d_1, ..., d_k]`, exact.
    fn derivative(&self, at: At, directions: &[Direction], out: &mut [f64]);

    /// The coefficient of `r^k`, `k = terms.len()` from 1 to 5, in `G(u + sum_j r^j u_j, v + sum_j r^j v_j, p)` with
    /// `(u_j, v_j)` the j-th term; exact. The terms' parts in p are not looked at.
    fn coefficient(&self, at: At, terms: &[Direction], out: &mut [f64]);

    /// The unit of time, "" if it has none.
    fn time_unit(&self) -> &'static str {
        ""
    }

    fn observables(&self) -> &[Observable] {
        &[]
    }

    /// Value of observable `i`.
    fn observe(&self, _i: usize, _at: At) -> f64 {
        f64::NAN
    }

    /// A reflection under which orbits may be invariant up to half a period.
    fn reflection(&self) -> Option<Reflection> {
        None
    }

    /// Continuous symmetries, along which relative periodic orbits may drift.
    fn rotations(&self) -> &[Rotation] {
        &[]
    }

    /// The unit of pictures' coordinates.
    fn picture_unit(&self) -> &'static str {
        ""
    }

    /// The planar curve that a state looks like, as points (x, y).
    fn picture(&self, _u: &[f64], _p: &[f64]) -> Option<Vec<[f64; 2]>> {
        None
    }

    /// A finer discretisation; `None` for a model without one.
    fn refined(&self) -> Option<Refinement> {
        None
    }
}
