//! Errors of a row's quantities: the same quantities on a refined discretisation, in space where the problem has one and
//! in time by a degree more, at the same parameters.
//!
//! The refined orbit is solved for by Broyden's method from the present one, with factors at an anchor: the first of a few
//! rows, which follow each other closely. The phase conditions are those of the anchor, with the present orbit's values.

use super::Cycles;
use super::quantities::measure;
use super::rows::Pending;
use crate::continuation::{Border, Counts, Factored, Progress, System, approach};
use crate::linalg::Singular;
use crate::orbit::{Collocation, Frame, Orbit, OrbitFactors};
use crate::problem::{Problem, Reflection};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Rows that one anchor serves.
const ROWS: usize = 6;
/// A refined orbit is solved for to this part of its distance from the present one, in the metric's norm,
const PART: f64 = 0.01;
/// and its P, which is far more accurate, to this part of its own change.
const PERIOD: f64 = 0.03;

/// or where the steps are as small as this.
const ROUNDING: (f64, f64) = (1e-12, 4.0 * f64::EPSILON);

/// Where an anchor is: its factors follow from that.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Place {
    orbit: Orbit,
    lambda: f64,
    /// Rows that it has served, its own included.
    rows: usize,
}

/// Refined factors at a row.
pub struct Anchor {
    pub place: Place,
    /// None as long as no row has asked.
    fine: Option<Result<Fine, Singular>>,
}

struct Fine {
    system: Collocation,
    factors: OrbitFactors,
}

/// The refined system at a row with an anchor's phase conditions.
struct Beside<'a> {
    system: Collocation,
    anchor: &'a Collocation,
    /// What these make of the present orbit.
    phases: Vec<f64>,
}

impl System for Beside<'_> {
    type Factors = OrbitFactors;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        self.system.residual(x, lambda, r);
        let phases = self.anchor.phases(x);
        let rows = r.len() - phases.len();
        for (r, (now, before)) in r[rows..].iter_mut().zip(phases.iter().zip(&self.phases)) {
            *r = now - before;
        }
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<OrbitFactors, Singular> {
        self.system.factor(x, lambda, border)
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        self.system.dual(t)
    }

    fn dual_lambda(&self) -> f64 {
        self.system.dual_lambda()
    }
}

impl From<Place> for Anchor {
    fn from(place: Place) -> Self {
        Self { place, fine: None }
    }
}

impl Anchor {
    /// Whether one more row may use it.
    fn serves(&self, point: &Pending) -> bool {
        self.place.rows < ROWS && self.place.orbit.mesh == point.orbit.mesh
    }
}

/// The refined system at an orbit, which may be too coarse for it to have one, and the orbit's unknowns in it.
fn finer(problem: &Arc<dyn Problem>, frame: &Frame, orbit: &Orbit) -> Option<(Collocation, Vec<f64>)> {
    let (problem, finer) = match problem.refined() {
        Some(refinement) => (refinement.problem, orbit.mapped(&*refinement.prolong)),
        None => (problem.clone(), orbit.clone()),
    };
    let finer = finer.interpolated(&orbit.mesh, orbit.degree + 1);
    let symmetry = if orbit.parts == 2 { problem.reflection()? } else { Reflection::identity(problem.dim()) };
    let x = Collocation::unknowns(&finer);
    Some((Collocation::new(Frame { problem, symmetry, ..frame.clone() }, &finer), x))
}

/// Factors at constant lambda.
fn factored(system: &Collocation, x: &[f64], lambda: f64) -> Result<OrbitFactors, Singular> {
    system.factor(x, lambda, &Border { row: vec![0.0; x.len()], lambda: 1.0 })
}

/// From an anchor's factors; None where these are of no use.
fn beside(fine: &Fine, system: &Collocation, (x, lambda): (&[f64], f64), counts: &mut Counts) -> Option<Vec<f64>> {
    let part = |x: &[f64]| system.part(x);
    let enough = |progress: &Progress| {
        let distance = |a: (&[f64], f64)| crate::continuation::inner(system, a, a).sqrt();
        let moved: Vec<f64> = progress.at.0.iter().zip(x).map(|(a, b)| a - b).collect();
        let (step, whole) = (distance(progress.step), distance((&moved, 0.0)));
        let (by, so_far) = (part(progress.step.0).abs(), part(&moved).abs());
        (step <= PART * whole || step <= ROUNDING.0) && (by <= PERIOD * so_far || by <= ROUNDING.1 * part(x))
    };
    let beside = Beside { system: system.clone(), anchor: &fine.system, phases: fine.system.phases(x) };
    let settled = approach(&beside, (x.to_vec(), lambda), &fine.factors, &enough, counts).ok()?;
    Some(settled.x)
}

/// By one Newton step, which leaves the error of the error.
fn newton(system: &Collocation, (x, lambda): (&[f64], f64), counts: &mut Counts) -> Option<Vec<f64>> {
    counts.factorisations += 1;
    let factors = factored(system, x, lambda).ok()?;
    let mut right = vec![0.0; x.len() + 1];
    system.residual(x, lambda, &mut right[..x.len()]);
    factors.solve(&mut right);
    counts.residuals += 1;
    counts.newton += 1;
    Some(x.iter().zip(&right).map(|(x, d)| x - d).collect())
}

impl Cycles<'_> {
    /// The anchors of accepted points, and which serves each; the first may be the last one of earlier rows.
    pub fn anchors(&mut self, pending: &[Pending], counts: &mut Counts) -> (Vec<Anchor>, Vec<usize>) {
        let mut anchors: Vec<Anchor> = self.anchor.take().into_iter().collect();
        let mut serving = Vec::with_capacity(pending.len());
        for point in pending {
            match anchors.last_mut().filter(|anchor| anchor.serves(point)) {
                Some(anchor) => anchor.place.rows += 1,
                None => {
                    counts.factorisations += 1;
                    anchors.push(Place { orbit: point.orbit.clone(), lambda: point.lambda, rows: 1 }.into());
                }
            }
            serving.push(anchors.len() - 1);
        }
        let problem: Arc<dyn Problem> = self.prepared.problem.clone();
        anchors.par_iter_mut().enumerate().for_each(|(k, Anchor { place, fine })| {
            let Some(at) = serving.iter().position(|&anchor| anchor == k).filter(|_| fine.is_none()) else { return };
            let made = finer(&problem, &pending[at].frame, &place.orbit).ok_or(Singular).and_then(|(system, x)| {
                let factors = factored(&system, &x, place.lambda)?;
                Ok(Fine { system, factors })
            });
            *fine = Some(made);
        });
        (anchors, serving)
    }

    /// The quantities of a refined orbit.
    pub fn refined(&self, point: &Pending, anchor: &Anchor, counts: &mut Counts) -> Option<Vec<f64>> {
        let Pending { frame, orbit, lambda, .. } = point;
        let problem: Arc<dyn Problem> = self.prepared.problem.clone();
        let (system, x) = finer(&problem, frame, orbit)?;
        let start = (&x[..], *lambda);
        let by_anchor = match &anchor.fine {
            Some(Ok(fine)) => beside(fine, &system, start, counts),
            _ => None,
        };
        let x = by_anchor.or_else(|| newton(&system, start, counts))?;
        let (p, Frame { problem, symmetry, .. }) = (system.parameters(*lambda), &system.frame);
        Some(measure(self.prepared, &**problem, &system.orbit(&x), symmetry, &p))
    }
}
