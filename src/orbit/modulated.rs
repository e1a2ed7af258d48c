//! Where a rotating wave becomes modulated: the start of a branch of relative periodic orbits.
//!
//! A rotating wave `exp(t sum_k c_k Gamma_k) u_0` rests in the frame that turns with it. What becomes of a perturbation
//! there has constant coefficients, `(G_u + sum_k c_k G_v Gamma_k + sigma G_v) q = 0`; where a pair sigma = ± i Omega
//! crosses the axis - as a cycle the wave then has multipliers `exp(±i Omega T)`, a torus bifurcation - modulated waves
//! branch off (Rand 1982, Arch. Rational Mech. Anal. 79:1),
//!
//! ```text
//! u(tau) = u_0 + 2 r Re(q exp(2 pi i tau)) + O(r²),      P = 2 pi / Omega.
//! ```

use super::turning::turned;
use super::{Orbit, Points, Scheme};
use crate::linalg::{Lu, c64, dot, pencil};
use crate::problem::{At, Problem};
use faer::Mat;
use std::f64::consts::PI;

/// The rotations balance all forces but this part of them, or it is no such wave.
const WAVE: f64 = 1e-4;

/// A rotating wave with the mode that grows on it.
pub struct Modulation {
    u: Vec<f64>,
    drift: Vec<f64>,
    omega: f64,
    q: Vec<c64>,
}

impl Modulation {
    /// From the wave as a cycle; None if it is no rotating wave, or no pair of its eigenvalues is complex.
    pub fn new(problem: &dyn Problem, cycle: &Orbit, p: &[f64]) -> Option<Self> {
        let rotations = problem.rotations();
        let u = cycle.node(0).to_vec();
        // The velocities with which u, at rest, solves the equations best; these are linear in the rate.
        let still = vec![0.0; u.len()];
        let (_, mass) = problem.matrices(At { u: &u, v: &still, p });
        let mut rest = still.clone();
        problem.residual(At { u: &u, v: &still, p }, &mut rest);
        let columns: Vec<Vec<f64>> = rotations
            .iter()
            .map(|rotation| {
                let (mut turned, mut column) = (still.clone(), still.clone());
                rotation.add(1.0, &u, &mut turned);
                mass.times(&turned, &mut column);
                column
            })
            .collect();
        let count = columns.len();
        let gram = Mat::from_fn(count, count, |i, j| dot(&columns[i], &columns[j]));
        let mut drift: Vec<f64> = columns.iter().map(|column| -dot(column, &rest)).collect();
        Lu::new(gram).ok()?.solve(&mut drift);
        let force = dot(&rest, &rest);
        for (column, c) in columns.iter().zip(&drift) {
            rest.iter_mut().zip(column).for_each(|(r, x)| *r += c * x);
        }
        // Written so that a number that is none fails.
        if !(force > 0.0 && dot(&rest, &rest) < WAVE * WAVE * force) {
            return None;
        }
        let mut v = still;
        super::shape::add_drift(rotations, &drift, &u, &mut v);
        let (gu, gv) = turned(problem.matrices(At { u: &u, v: &v, p }), rotations, &drift);
        let (gu, gv) = (gu.into_dense(), gv.into_dense());
        // Not an eigenvalue itself, as zero is.
        let shift = 0.1 * std::f64::consts::E / cycle.period();
        let pairs = pencil(gu.as_ref(), gv.as_ref(), shift, u.len()).ok()?;
        let above = pairs.into_iter().filter(|pair| pair.value.im * cycle.period() > WAVE);
        let pair = above.min_by(|a, b| a.value.re.abs().total_cmp(&b.value.re.abs()))?;
        let size = pair.vector.iter().map(|q| q.norm_sqr()).sum::<f64>().sqrt();
        let q = pair.vector.iter().map(|q| q / size).collect();
        Some(Self { u, drift, omega: pair.value.im, q })
    }

    /// The orbit at r: at zero the wave itself, at rest.
    pub fn orbit(&self, r: f64, mesh: (usize, usize, Points)) -> Orbit {
        self.sampled(1.0, r, mesh)
    }

    /// Its derivative with respect to r.
    pub fn mode(&self, mesh: (usize, usize, Points)) -> Orbit {
        let drift = vec![0.0; self.drift.len()];
        Orbit { part: 0.0, drift, ..self.sampled(0.0, 1.0, mesh) }
    }

    fn sampled(&self, wave: f64, r: f64, (intervals, degree, points): (usize, usize, Points)) -> Orbit {
        let scheme = Scheme::new(points, degree);
        let count = intervals * degree;
        let state = |i: usize| {
            let tau = ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
            let turn = c64::from_polar(1.0, 2.0 * PI * tau);
            let turn = if i == count { c64::new(1.0, 0.0) } else { turn };
            self.u.iter().zip(&self.q).map(move |(u, q)| wave * u + 2.0 * r * (q * turn).re).collect::<Vec<f64>>()
        };
        Orbit {
            mesh: (0..=intervals).map(|j| j as f64 / intervals as f64).collect(),
            points,
            degree,
            nodes: (0..=count).flat_map(state).collect(),
            dim: self.u.len(),
            part: 2.0 * PI / self.omega,
            parts: 1,
            drift: self.drift.clone(),
        }
    }
}
