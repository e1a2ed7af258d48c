//! The collocation equations linearised at one orbit, and their second derivatives.
//!
//! A variation of (nodes, P, p) is a [`Field`]: what it does to u, u' and p at every collocation point. With
//! `u' = (1/P) du/dtau`, the second derivative along two of them is
//!
//! ```text
//! D²G[(u_a, v_a, p_a), (u_b, v_b, p_b)] - G_v (v_a P_b + v_b P_a) / P.
//! ```

use super::super::condensation::Condensed;
use super::super::rows::Reach;
use super::super::{Collocation, Orbit};
use crate::linalg::Singular;
use crate::problem::{At, Direction, Problem, Reflection};
use rayon::prelude::*;

/// A variation at all collocation points.
#[derive(Clone, Debug)]
pub struct Field {
    /// Of u and u', n entries a point.
    pub u: Vec<f64>,
    pub v: Vec<f64>,
    /// Of P.
    pub part: f64,
    /// Of the parameters; empty for none.
    pub p: Vec<f64>,
}

/// An orbit with its condensed equations. Border rows 0, 1, ... are carried along: the phase condition first.
pub struct Linear {
    pub system: Collocation,
    pub orbit: Orbit,
    pub p: Vec<f64>,
    pub(super) condensed: Condensed,
    pub(super) reaches: Vec<Reach>,
}

impl Linear {
    /// At an orbit, which need not close, with border rows over all nodes but the last. Relative periodic orbits are
    /// refused: their drift is no unknown here.
    pub fn new(system: &Collocation, orbit: Orbit, p: Vec<f64>, rows: &[&[f64]]) -> Result<Self, Singular> {
        if !orbit.drift.is_empty() {
            return Err(Singular);
        }
        let mut condensed = system.condensed(&orbit, &p)?;
        let reaches = condensed.add_borders(&[&[&system.phase[..]], rows].concat());
        Ok(Self { system: system.clone(), orbit, p, condensed, reaches })
    }

    pub fn n(&self) -> usize {
        self.orbit.dim
    }

    /// Equations of all intervals.
    pub fn count(&self) -> usize {
        self.orbit.nodes.len() - self.orbit.dim
    }

    pub(super) fn symmetry(&self) -> &Reflection {
        &self.system.frame.symmetry
    }

    /// The residual at all collocation points.
    pub fn residual(&self) -> Vec<f64> {
        let mut r = vec![0.0; self.count()];
        self.system.equations(&self.orbit, &self.p, &mut r);
        r
    }

    /// Values and derivatives (per P) at all collocation points of a function given at all nodes.
    pub fn sample(&self, nodes: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let function = Orbit { nodes: nodes.to_vec(), ..self.orbit.clone() };
        let m = self.orbit.degree;
        let points = (0..self.orbit.intervals() * m).map(|k| self.system.state(&function, k / m, k % m));
        let (u, v): (Vec<_>, Vec<_>) = points.unzip();
        (u.concat(), v.concat())
    }

    /// The variation of nodes (the last one included), P and p.
    pub fn field(&self, nodes: &[f64], part: f64, p: Vec<f64>) -> Field {
        let (u, mut v) = self.sample(nodes);
        if part != 0.0 {
            let (_, rate) = self.sample(&self.orbit.nodes);
            v.iter_mut().zip(&rate).for_each(|(v, rate)| *v -= rate * part / self.orbit.part);
        }
        Field { u, v, part, p }
    }

    /// The variation of the parameters alone.
    pub fn parametric(&self, p: Vec<f64>) -> Field {
        let zeros = vec![0.0; self.count()];
        Field { u: zeros.clone(), v: zeros, part: 0.0, p }
    }

    /// A value at every collocation point from the state there.
    pub fn at_points(&self, value: impl Fn(usize, At, &mut [f64]) + Sync) -> Vec<f64> {
        let (n, m) = (self.orbit.dim, self.orbit.degree);
        let mut out = vec![0.0; self.count()];
        out.par_chunks_mut(n).enumerate().for_each(|(k, out)| {
            let (u, v) = self.system.state(&self.orbit, k / m, k % m);
            value(k, At { u: &u, v: &v, p: &self.p }, out);
        });
        out
    }

    fn problem(&self) -> &dyn Problem {
        &*self.system.frame.problem
    }

    /// The first derivative along a variation.
    pub fn first(&self, a: &Field) -> Vec<f64> {
        let n = self.n();
        self.at_points(|k, at, out| {
            let points = k * n..(k + 1) * n;
            let direction = Direction { u: &a.u[points.clone()], v: &a.v[points], p: &a.p };
            self.problem().derivative(at, &[direction], out);
        })
    }

    /// The second derivative along two variations.
    pub fn second(&self, a: &Field, b: &Field) -> Vec<f64> {
        let (n, part) = (self.n(), self.orbit.part);
        self.at_points(|k, at, out| {
            let points = k * n..(k + 1) * n;
            let (va, vb) = (&a.v[points.clone()], &b.v[points.clone()]);
            let a_here = Direction { u: &a.u[points.clone()], v: va, p: &a.p };
            let b_here = Direction { u: &b.u[points], v: vb, p: &b.p };
            self.problem().derivative(at, &[a_here, b_here], out);
            if a.part != 0.0 || b.part != 0.0 {
                let v: Vec<f64> = va.iter().zip(vb).map(|(va, vb)| -(va * b.part + vb * a.part) / part).collect();
                let mut extra = vec![0.0; n];
                self.problem().derivative(at, &[Direction { u: &[], v: &v, p: &[] }], &mut extra);
                out.iter_mut().zip(extra).for_each(|(o, e)| *o += e);
            }
        })
    }

    /// `G_v x` for values x at all collocation points.
    pub fn mass(&self, x: &[f64]) -> Vec<f64> {
        let n = self.n();
        self.at_points(|k, at, out| {
            self.problem().derivative(at, &[Direction { u: &[], v: &x[k * n..(k + 1) * n], p: &[] }], out);
        })
    }
}
