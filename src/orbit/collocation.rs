//! The collocation equations as a curve: unknowns are the nodes' values, the computed part P of the period,
//! drift velocities c_k, and lambda.
//!
//! ```text
//! G(u(c), u'(c)/P, p) = 0         at every collocation point c of every interval,
//! u(1) = S u(0),                  S the identity, or the reflection of a half-period orbit,
//! int <u - u_ref, u_ref'> dtau = 0,      u_ref the last orbit: the integral phase condition,
//! border . (u, P, lambda) = 0     (continuation's own row).
//! ```
//!
//! A relative periodic orbit closes up to continuous symmetries `exp(s Gamma_k)`, k = 1 ... K, of the problem. In the frame
//! that turns with it, `u_lab(t) = exp(t sum_k c_k Gamma_k) u(t)`, it is an orbit of
//!
//! ```text
//! G(u, u'/P + sum_k c_k Gamma_k u, p) = 0,      int <u, Gamma_k u_ref> dtau = 0,
//! ```
//!
//! one unknown velocity and one phase condition for each symmetry (Wulff and Schebesch 2006,
//! SIAM J. Appl. Dyn. Syst. 5, 435). Gamma_k is skew, so that the reference itself fulfils them. c_k is defined up to
//! multiples of 2 pi / P, turns of the frame that the orbit does not see. K is the number of velocities that the orbit
//! comes with: none, or one for each of the problem's rotations.

use super::condensation::{Condensed, Interval};
use super::factors::OrbitFactors;
use super::shape::add_drift;
use super::turning::turned;
use super::{Orbit, Points, Scheme, adapted};
use crate::continuation::{Border, Point, System, inner};
use crate::linalg::{Lu, Matrix, Singular, dot};
use crate::problem::{At, Direction, Problem, Reflection, Rotation};
use faer::Mat;
use rayon::prelude::*;
use std::sync::Arc;

/// What stays the same along a branch of orbits.
#[derive(Clone)]
pub struct Frame {
    pub problem: Arc<dyn Problem>,
    /// All parameters; entry `free` is replaced by lambda.
    pub p: Vec<f64>,
    pub free: usize,
    /// u(t + P) = S u(t).
    pub symmetry: Reflection,
    /// The period over P: 1 or 2.
    pub parts: usize,
    /// Sizes of a state, a period (at first) and a parameter that count as one in arclength.
    pub scale_state: f64,
    pub scale_part: f64,
    pub scale_lambda: f64,
}

impl Frame {
    /// The same for another discretisation of the problem; None if that lacks the symmetry.
    pub fn of(&self, problem: &Arc<dyn Problem>) -> Option<Self> {
        let symmetry = if self.parts == 2 { problem.reflection()? } else { Reflection::identity(problem.dim()) };
        Some(Self { problem: problem.clone(), symmetry, ..self.clone() })
    }
}

/// The system on one mesh.
#[derive(Clone)]
pub struct Collocation {
    pub frame: Frame,
    pub scheme: Scheme,
    /// The error that the mesh is to have, relative to the orbit's size; None: the number of intervals is kept.
    pub tolerance: Option<f64>,
    points: Points,
    pub mesh: Vec<f64>,
    /// The orbit that the phase condition refers to.
    reference: Orbit,
    /// `int <., u_ref'> dtau` as a row over all nodes but the last,
    pub(super) phase: Vec<f64>,
    /// and its value at u_ref, which is not quite zero on a mesh.
    phase_there: f64,
    /// `int <., Gamma_k u_ref> dtau` likewise.
    turns: Vec<Vec<f64>>,
    /// Weight of each node in the metric, the last node's carried by the first.
    weights: Vec<f64>,
}

impl Collocation {
    /// On the orbit's mesh, with the orbit as phase reference.
    pub fn new(frame: Frame, orbit: &Orbit) -> Self {
        let mut system = Self {
            frame,
            scheme: orbit.scheme(),
            tolerance: None,
            points: orbit.points,
            mesh: Vec::new(),
            reference: orbit.clone(),
            phase: Vec::new(),
            phase_there: 0.0,
            turns: Vec::new(),
            weights: Vec::new(),
        };
        system.refer_to(orbit);
        system
    }

    /// The orbit that the phase condition refers to: a system made from it is this one.
    pub fn reference(&self) -> &Orbit {
        &self.reference
    }

    fn n(&self) -> usize {
        self.frame.symmetry.sign.len()
    }

    /// Intervals that one thread takes at least: less work than some ten microseconds is not worth sharing.
    fn grain(&self) -> usize {
        (200_000 / (self.n() * self.scheme.degree).pow(3)).max(1)
    }

    /// The period that counts as one in arclength: the frame's, doubled until the reference's is less than twice that, so
    /// that a period which grows by orders of magnitude does not slow the walk down.
    fn scale_part(&self) -> f64 {
        let ratio = self.reference.part / self.frame.scale_part;
        self.frame.scale_part * ratio.max(1.0).log2().floor().exp2()
    }

    fn intervals(&self) -> usize {
        self.mesh.len() - 1
    }

    /// All parameters at lambda.
    pub fn parameters(&self, lambda: f64) -> Vec<f64> {
        let mut p = self.frame.p.clone();
        p[self.frame.free] = lambda;
        p
    }

    /// Unknowns of an orbit on this mesh.
    pub fn unknowns(orbit: &Orbit) -> Vec<f64> {
        let mut x = orbit.nodes[..orbit.nodes.len() - orbit.dim].to_vec();
        x.push(orbit.part);
        x.extend_from_slice(&orbit.drift);
        x
    }

    /// Drift velocities among the unknowns.
    fn drifts(&self) -> usize {
        self.reference.drift.len()
    }

    fn rotations(&self) -> &[Rotation] {
        if self.drifts() == 0 { &[] } else { self.frame.problem.rotations() }
    }

    /// P among the unknowns.
    pub fn part(&self, x: &[f64]) -> f64 {
        x[x.len() - 1 - self.drifts()]
    }

    /// The orbit that unknowns stand for.
    pub fn orbit(&self, x: &[f64]) -> Orbit {
        let n = self.n();
        let (nodes, rest) = x.split_at(x.len() - 1 - self.drifts());
        let mut nodes = nodes.to_vec();
        let mut last = vec![0.0; n];
        self.frame.symmetry.apply(&nodes[..n], &mut last);
        nodes.extend(last);
        Orbit {
            mesh: self.mesh.clone(),
            points: self.points,
            degree: self.scheme.degree,
            nodes,
            dim: n,
            part: rest[0],
            parts: self.frame.parts,
            drift: rest[1..].to_vec(),
        }
    }

    /// Takes over an orbit's mesh, and the orbit as phase reference.
    fn refer_to(&mut self, orbit: &Orbit) {
        let (n, m) = (orbit.dim, self.scheme.degree);
        self.mesh = orbit.mesh.clone();
        self.reference = orbit.clone();
        let nodes = self.intervals() * m;
        let mut phase = vec![0.0; (nodes + 1) * n];
        let mut turns = vec![vec![0.0; (nodes + 1) * n]; self.drifts()];
        self.weights = vec![0.0; nodes];
        for j in 0..self.intervals() {
            let width = self.mesh[j + 1] - self.mesh[j];
            for (i, weight) in self.scheme.weights.iter().enumerate() {
                let (mut slope, mut state) = (vec![0.0; n], vec![0.0; n]);
                for l in 0..=m {
                    let (a, d) = (self.scheme.value[i][l], self.scheme.slope[i][l]);
                    state.iter_mut().zip(orbit.node(j * m + l)).for_each(|(s, x)| *s += a * x);
                    slope.iter_mut().zip(orbit.node(j * m + l)).for_each(|(s, x)| *s += d * x);
                    self.weights[(j * m + l) % nodes] += width * weight * self.scheme.value[i][l];
                }
                for l in 0..=m {
                    // width cancels: int <u, u_ref'> over the interval, u_ref' = slope / width.
                    let factor = weight * self.scheme.value[i][l];
                    let row = &mut phase[(j * m + l) * n..][..n];
                    row.iter_mut().zip(&slope).for_each(|(r, s)| *r += factor * s);
                    for (rotation, turn) in self.frame.problem.rotations().iter().zip(&mut turns) {
                        rotation.add(factor * width, &state, &mut turn[(j * m + l) * n..][..n]);
                    }
                }
            }
        }
        for row in std::iter::once(&mut phase).chain(&mut turns) {
            let last = row.split_off(nodes * n);
            self.frame.symmetry.add_transposed(&last, &mut row[..n]);
            // A row of unit length, so that the phase equation has the size of the others.
            let norm = dot(row, row).sqrt();
            if norm > 0.0 {
                row.iter_mut().for_each(|r| *r /= norm);
            }
        }
        self.phase_there = dot(&phase, &orbit.nodes[..phase.len()]);
        (self.phase, self.turns) = (phase, turns);
    }

    /// The phase condition of nodes, the last one left out or not.
    pub(super) fn phase_of(&self, nodes: &[f64]) -> f64 {
        dot(&self.phase, &nodes[..self.phase.len()]) - self.phase_there
    }

    /// What the rows of the phase conditions, of time and of rotations, give for nodes or a direction.
    fn phases(&self, nodes: &[f64]) -> Vec<f64> {
        let rows = std::iter::once(&self.phase).chain(&self.turns);
        rows.map(|row| dot(row, &nodes[..row.len()])).collect()
    }

    /// Directions at the nodes, the last one left out, in which an orbit moves along itself and turns.
    fn motions(&self, orbit: &Orbit) -> Vec<Vec<f64>> {
        let rates = orbit.rates(&self.scheme);
        let turned = |rotation: &Rotation| {
            let mut turned = vec![0.0; rates.len()];
            let states = orbit.nodes.chunks(orbit.dim);
            turned.chunks_mut(orbit.dim).zip(states).for_each(|(out, u)| rotation.add(1.0, u, out));
            turned
        };
        let turns = self.rotations().iter().map(turned).collect::<Vec<_>>();
        std::iter::once(rates).chain(turns).collect()
    }

    /// Moves nodes, or a direction, along an orbit's `motions` until they miss the phase conditions by nothing instead of
    /// `misses`.
    fn keep_phase(&self, motions: &[Vec<f64>], nodes: &mut [f64], mut misses: Vec<f64>) {
        let moved: Vec<Vec<f64>> = motions.iter().map(|motion| self.phases(motion)).collect();
        let Ok(lu) = Lu::new(Mat::from_fn(moved.len(), moved.len(), |i, j| moved[j][i])) else { return };
        lu.solve(&mut misses);
        for (motion, share) in motions.iter().zip(misses) {
            nodes.iter_mut().zip(motion).for_each(|(x, m)| *x -= share * m);
        }
    }

    /// u and `u' + sum_k c_k Gamma_k u` (per P) at collocation point i of interval j.
    pub(super) fn state(&self, orbit: &Orbit, j: usize, i: usize) -> (Vec<f64>, Vec<f64>) {
        let (n, m) = (orbit.dim, self.scheme.degree);
        let rate = 1.0 / ((self.mesh[j + 1] - self.mesh[j]) * orbit.part);
        let (mut u, mut v) = (vec![0.0; n], vec![0.0; n]);
        for l in 0..=m {
            let (a, d) = (self.scheme.value[i][l], self.scheme.slope[i][l] * rate);
            for (k, &x) in orbit.node(j * m + l).iter().enumerate() {
                u[k] += a * x;
                v[k] += d * x;
            }
        }
        add_drift(self.rotations(), &orbit.drift, &u, &mut v);
        (u, v)
    }

    /// `G(u, u', p)` at all collocation points of an orbit, which need not close.
    pub(super) fn equations(&self, orbit: &Orbit, p: &[f64], r: &mut [f64]) {
        let n = self.n();
        let rows = r.par_chunks_mut(self.scheme.degree * n).with_min_len(16 * self.grain());
        rows.enumerate().for_each(|(j, rows)| {
            for (i, row) in rows.chunks_mut(n).enumerate() {
                let (u, v) = self.state(orbit, j, i);
                self.frame.problem.residual(At { u: &u, v: &v, p }, row);
            }
        });
    }

    /// The equations of interval j, linearised, with its inner nodes eliminated.
    fn eliminate(&self, orbit: &Orbit, p: &[f64], j: usize) -> Result<Interval, Singular> {
        let (n, m) = (orbit.dim, self.scheme.degree);
        let rate = 1.0 / ((self.mesh[j + 1] - self.mesh[j]) * orbit.part);
        let structure = self.frame.problem.structure();
        let mut unit = vec![0.0; p.len()];
        unit[self.frame.free] = 1.0;
        let (mut blocks, mut scalars) = (Vec::with_capacity(m), Vec::with_capacity(m));
        let (mut moved, mut by_lambda) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..m {
            let (u, v) = self.state(orbit, j, i);
            let at = At { u: &u, v: &v, p };
            let (mut gu, mut gv) = (Matrix::zeros(structure.clone(), n), Matrix::zeros(structure.clone(), n));
            self.frame.problem.linearise(at, &mut gu, &mut gv);
            self.frame.problem.derivative(at, &[Direction { u: &[], v: &[], p: &unit }], &mut by_lambda);
            // dG/dP = -G_v u' / P, without the drift.
            let mut slope = v.clone();
            for (rotation, c) in self.rotations().iter().zip(&orbit.drift) {
                rotation.add(-c, &u, &mut slope);
            }
            gv.times(&slope, &mut moved);
            let mut columns = vec![moved.iter().map(|m| -m / orbit.part).collect::<Vec<f64>>()];
            for rotation in self.rotations() {
                let (mut turned, mut by_drift) = (vec![0.0; n], vec![0.0; n]);
                rotation.add(1.0, &u, &mut turned);
                gv.times(&turned, &mut by_drift);
                columns.push(by_drift);
            }
            columns.push(by_lambda.clone());
            scalars.push((0..n).flat_map(|row| columns.iter().map(move |column| column[row])).collect());
            blocks.push(turned((gu, gv), self.rotations(), &orbit.drift));
        }
        let slope: Vec<Vec<f64>> = self.scheme.slope.iter().map(|row| row.iter().map(|d| d * rate).collect()).collect();
        Interval::new(blocks, (&self.scheme.value, &slope), &scalars)
    }

    /// All intervals at an orbit, which need not close, linearised and condensed.
    pub(super) fn condensed(&self, orbit: &Orbit, p: &[f64]) -> Result<Condensed, Singular> {
        let all = (0..self.intervals()).into_par_iter().with_min_len(self.grain());
        let intervals: Result<Vec<_>, _> = all.map(|j| self.eliminate(orbit, p, j)).collect();
        Condensed::new(intervals?, self.n())
    }
}

impl System for Collocation {
    type Factors = OrbitFactors;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        let (n, m) = (self.n(), self.scheme.degree);
        let (equations, phase) = r.split_at_mut(self.intervals() * m * n);
        self.equations(&self.orbit(x), &self.parameters(lambda), equations);
        let nodes = &x[..equations.len()];
        phase[0] = self.phase_of(nodes);
        for (r, turn) in phase[1..].iter_mut().zip(&self.turns) {
            *r = dot(turn, nodes);
        }
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<OrbitFactors, Singular> {
        let orbit = self.orbit(x);
        let p = self.parameters(lambda);
        let condensed = self.condensed(&orbit, &p)?;
        OrbitFactors::new(condensed, (&self.phase, &self.turns), border, &self.frame)
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        let (n, scale) = (self.n(), self.frame.scale_state.powi(-2));
        let (nodes, rest) = t.split_at(t.len() - 1 - self.drifts());
        let mut row: Vec<f64> = nodes.iter().enumerate().map(|(i, t)| scale * self.weights[i / n] * t).collect();
        let period = self.scale_part().powi(2);
        row.push(rest[0] / period);
        // A velocity counts as one that turns by one in P.
        row.extend(rest[1..].iter().map(|c| c * period));
        row
    }

    fn dual_lambda(&self) -> f64 {
        self.frame.scale_lambda.powi(-2)
    }

    /// Moves the mesh where the error is spread too unevenly, and takes the point as phase reference.
    fn prepare(&mut self, point: &mut Point) -> bool {
        let orbit = self.orbit(&point.x);
        let scale = self.scale_part();
        if let Some(mesh) = adapted(&orbit, &self.scheme, &self.frame.symmetry, self.tolerance) {
            let moved = orbit.interpolated(&mesh, self.scheme.degree);
            let tangent = self.orbit(&point.tangent).interpolated(&mesh, self.scheme.degree);
            self.refer_to(&moved);
            point.x = Self::unknowns(&moved);
            point.tangent = Self::unknowns(&tangent);
            true
        } else {
            self.refer_to(&orbit);
            let misses = self.phases(&point.tangent);
            self.keep_phase(&self.motions(&self.reference), &mut point.tangent, misses);
            // The metric has changed, too: the tangent's length is one again.
            let along = (&point.tangent[..], point.tangent_lambda);
            let length = inner(self, along, along).sqrt();
            point.tangent.iter_mut().for_each(|t| *t /= length);
            point.tangent_lambda /= length;
            self.scale_part() != scale
        }
    }

    fn align(&self, past: &mut Point) {
        let motions = self.motions(&self.orbit(&past.x));
        let (mut of_nodes, of_tangent) = (self.phases(&past.x), self.phases(&past.tangent));
        of_nodes[0] -= self.phase_there;
        self.keep_phase(&motions, &mut past.x, of_nodes);
        self.keep_phase(&motions, &mut past.tangent, of_tangent);
    }
}
