//! A problem in which some parameters are functions of others: `tau_c = c_N L^4 / EI / 200`.
//!
//! The wrapped problem takes the same parameter vector, but entries that are tied are computed, and derivatives follow
//! by the chain rule: with `P(p)` the resolved vector and `d` a direction, `P'd`, `P''[d, e]` enter the derivatives of G.

use super::{At, Direction, Observable, Parameter, Problem, Refinement, Reflection, Rotation};
use crate::linalg::{Matrix, Structure};
use num_dual::{Dual64, HyperDual64};
use std::sync::Arc;

/// How parameter `target` follows from the others, exactly to second order.
pub trait Tie: Send + Sync {
    fn target(&self) -> usize;
    fn value(&self, p: &[f64]) -> f64;
    fn first(&self, p: &[Dual64]) -> Dual64;
    fn second(&self, p: &[HyperDual64]) -> HyperDual64;
}

/// A problem with ties, in an order in which each uses only what is known before it.
#[derive(Clone)]
pub struct Tied {
    pub inner: Arc<dyn Problem>,
    pub ties: Arc<Vec<Box<dyn Tie>>>,
}

impl Tied {
    /// All parameters, tied ones computed.
    pub fn resolve(&self, p: &[f64]) -> Vec<f64> {
        let mut p = p.to_vec();
        for tie in self.ties.iter() {
            p[tie.target()] = tie.value(&p);
        }
        p
    }

    /// `P'(p) d`.
    fn push(&self, p: &[f64], d: &[f64]) -> Vec<f64> {
        if d.is_empty() {
            return Vec::new();
        }
        let mut x: Vec<Dual64> = p.iter().zip(d).map(|(&p, &d)| Dual64::new(p, d)).collect();
        for tie in self.ties.iter() {
            x[tie.target()] = tie.first(&x);
        }
        x.iter().map(|x| x.eps).collect()
    }

    /// `P''(p)[d, e]`, if it is not zero.
    fn bend(&self, p: &[f64], d: &[f64], e: &[f64]) -> Option<Vec<f64>> {
        if d.is_empty() || e.is_empty() {
            return None;
        }
        let mut x: Vec<HyperDual64> = (0..p.len()).map(|i| HyperDual64::new(p[i], d[i], e[i], 0.0)).collect();
        for tie in self.ties.iter() {
            x[tie.target()] = tie.second(&x);
        }
        x.iter().any(|x| x.eps1eps2 != 0.0).then(|| x.iter().map(|x| x.eps1eps2).collect())
    }
}

impl Problem for Tied {
    fn dim(&self) -> usize {
        self.inner.dim()
    }

    fn parameters(&self) -> &[Parameter] {
        self.inner.parameters()
    }

    fn unknowns(&self) -> Vec<String> {
        self.inner.unknowns()
    }

    fn start(&self, p: &[f64]) -> Vec<f64> {
        self.inner.start(&self.resolve(p))
    }

    fn residual(&self, at: At, g: &mut [f64]) {
        self.inner.residual(At { p: &self.resolve(at.p), ..at }, g);
    }

    fn structure(&self) -> Structure {
        self.inner.structure()
    }

    fn linearise(&self, at: At, gu: &mut Matrix, gv: &mut Matrix) {
        self.inner.linearise(At { p: &self.resolve(at.p), ..at }, gu, gv);
    }

    /// Chain rule to second order in p. Third-order derivatives are only ever wanted in (u, v).
    fn derivative(&self, at: At, directions: &[Direction], out: &mut [f64]) {
        let p = self.resolve(at.p);
        let pushed: Vec<Vec<f64>> = directions.iter().map(|d| self.push(at.p, d.p)).collect();
        let moved: Vec<Direction> = directions.iter().zip(&pushed).map(|(d, p)| Direction { p, ..*d }).collect();
        let at_resolved = At { p: &p, ..at };
        self.inner.derivative(at_resolved, &moved, out);
        if let [a, b] = directions
            && let Some(bend) = self.bend(at.p, a.p, b.p)
        {
            let mut extra = vec![0.0; out.len()];
            self.inner.derivative(at_resolved, &[Direction { u: &[], v: &[], p: &bend }], &mut extra);
            out.iter_mut().zip(extra).for_each(|(o, e)| *o += e);
        }
    }

    fn coefficient(&self, at: At, terms: &[Direction], out: &mut [f64]) {
        self.inner.coefficient(At { p: &self.resolve(at.p), ..at }, terms, out);
    }

    fn time_unit(&self) -> &'static str {
        self.inner.time_unit()
    }

    fn observables(&self) -> &[Observable] {
        self.inner.observables()
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        self.inner.observe(i, At { p: &self.resolve(at.p), ..at })
    }

    fn reflection(&self) -> Option<Reflection> {
        self.inner.reflection()
    }

    fn rotations(&self) -> &[Rotation] {
        self.inner.rotations()
    }

    fn picture_unit(&self) -> &'static str {
        self.inner.picture_unit()
    }

    fn picture(&self, u: &[f64], p: &[f64]) -> Option<Vec<[f64; 2]>> {
        self.inner.picture(u, &self.resolve(p))
    }

    fn refined(&self) -> Option<Refinement> {
        let inner = self.inner.refined()?;
        let problem = Arc::new(Tied { inner: inner.problem, ties: self.ties.clone() });
        Some(Refinement { problem, prolong: inner.prolong })
    }
}
