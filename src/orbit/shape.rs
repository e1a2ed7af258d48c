//! An orbit as data: a piecewise polynomial over one period, or over half of it where symmetry gives the rest.

use super::{Points, Scheme};
use crate::problem::{At, Problem, Reflection, Rotation};
use argmin::core::{CostFunction, Executor};
use argmin::solver::brent::BrentOpt;
use serde::{Deserialize, Serialize};

/// `u(t)` for `t = tau P`, tau in [0, 1]; beyond it `u(t + P) = S u(t)`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Orbit {
    /// Boundaries of the intervals, from 0 to 1.
    pub mesh: Vec<f64>,
    pub points: Points,
    pub degree: usize,
    /// Values at all nodes, `degree` per interval and the last one, each of length `dim`.
    pub nodes: Vec<f64>,
    pub dim: usize,
    /// P: the computed part of the period.
    pub part: f64,
    /// The period over P: 1, or 2 with half-period symmetry.
    pub parts: usize,
    /// Velocities c_k of the problem's rotations, where u is seen from a frame that turns with the orbit:
    /// `u_lab(t) = exp(t sum_k c_k Gamma_k) u(t)`. Empty: the frame is at rest, the orbit itself closes.
    #[serde(default)]
    pub drift: Vec<f64>,
}

/// `v += sum_k c_k Gamma_k u`: from u' in the frame that turns to the rate that the equations see.
pub(super) fn add_drift(rotations: &[Rotation], drift: &[f64], u: &[f64], v: &mut [f64]) {
    for (rotation, &c) in rotations.iter().zip(drift) {
        rotation.add(c, u, v);
    }
}

/// Where an observable is largest and smallest over the period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremes {
    pub max: f64,
    pub min: f64,
}

impl Orbit {
    pub fn scheme(&self) -> Scheme {
        Scheme::new(self.points, self.degree)
    }

    pub fn intervals(&self) -> usize {
        self.mesh.len() - 1
    }

    pub fn period(&self) -> f64 {
        self.part * self.parts as f64
    }

    pub fn node(&self, i: usize) -> &[f64] {
        &self.nodes[i * self.dim..(i + 1) * self.dim]
    }

    /// u and u' at tau in [0, 1].
    pub fn at(&self, tau: f64, scheme: &Scheme) -> (Vec<f64>, Vec<f64>) {
        let j = self.mesh.partition_point(|&b| b <= tau).clamp(1, self.intervals()) - 1;
        let x = (tau - self.mesh[j]) / (self.mesh[j + 1] - self.mesh[j]);
        self.combined(j, &scheme.values_at(x), &scheme.slopes_at(x))
    }

    /// u and u' in interval j, from values and slopes of the Lagrange polynomials.
    fn combined(&self, j: usize, value: &[f64], slope: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mut u, mut v) = (vec![0.0; self.dim], vec![0.0; self.dim]);
        self.add_combination(j, value, 1.0, &mut u);
        self.add_combination(j, slope, 1.0 / self.duration(j), &mut v);
        (u, v)
    }

    /// u' at the nodes, the last one left out.
    pub fn rates(&self, scheme: &Scheme) -> Vec<f64> {
        let slopes: Vec<Vec<f64>> = scheme.nodes[..self.degree].iter().map(|&x| scheme.slopes_at(x)).collect();
        let mut rates = vec![0.0; self.intervals() * self.degree * self.dim];
        for (k, rate) in rates.chunks_mut(self.dim).enumerate() {
            let (j, i) = (k / self.degree, k % self.degree);
            self.add_combination(j, &slopes[i], 1.0 / self.duration(j), rate);
        }
        rates
    }

    /// Of interval j.
    fn duration(&self, j: usize) -> f64 {
        (self.mesh[j + 1] - self.mesh[j]) * self.part
    }

    /// `y += factor sum_l weights_l u_l` over the nodes of interval j.
    fn add_combination(&self, j: usize, weights: &[f64], factor: f64, y: &mut [f64]) {
        for (l, weight) in weights.iter().enumerate() {
            let weight = factor * weight;
            y.iter_mut().zip(self.node(j * self.degree + l)).for_each(|(y, x)| *y += weight * x);
        }
    }

    /// From u' in the frame that turns with the orbit to the rate at rest, seen from that frame.
    pub fn add_drift(&self, problem: &dyn Problem, u: &[f64], v: &mut [f64]) {
        add_drift(problem.rotations(), &self.drift, u, v);
    }

    /// u and u' at any multiple t of P, by symmetry.
    pub fn anywhere(&self, t: f64, scheme: &Scheme, symmetry: &Reflection) -> (Vec<f64>, Vec<f64>) {
        let turns = t.floor();
        reflected(self.at(t - turns, scheme), (turns as i64).rem_euclid(self.parts as i64), symmetry)
    }

    /// The same orbit (or tangent) on another mesh or with another degree, by interpolation.
    pub fn interpolated(&self, mesh: &[f64], degree: usize) -> Self {
        let (from, to) = (self.scheme(), Scheme::new(self.points, degree));
        let mut nodes = Vec::with_capacity(self.dim * (degree * (mesh.len() - 1) + 1));
        for w in mesh.windows(2) {
            for x in &to.nodes[..degree] {
                nodes.extend(self.at(w[0] + x * (w[1] - w[0]), &from).0);
            }
        }
        nodes.extend_from_slice(self.node(self.intervals() * self.degree));
        Self { mesh: mesh.to_vec(), degree, nodes, ..self.clone() }
    }

    /// The same orbit with each state mapped into another space.
    pub fn mapped(&self, map: &dyn Fn(&[f64]) -> Vec<f64>) -> Self {
        let nodes: Vec<f64> = self.nodes.chunks(self.dim).flat_map(map).collect();
        let dim = nodes.len() / (self.nodes.len() / self.dim);
        Self { nodes, dim, ..self.clone() }
    }

    /// The mean of a function of (u, u') over the whole period, by the collocation points' quadrature: as accurate as the
    /// period itself.
    pub fn mean(&self, symmetry: &Reflection, value: &dyn Fn(&[f64], &[f64]) -> f64) -> f64 {
        let scheme = self.scheme();
        let mut sum = 0.0;
        for part in 0..self.parts {
            for w in self.mesh.windows(2) {
                for (c, weight) in scheme.points.iter().zip(&scheme.weights) {
                    let tau = w[0] + c * (w[1] - w[0]);
                    // The last Radau point of a part belongs to it, not to the next.
                    let (u, v) = reflected(self.at(tau, &scheme), part as i64, symmetry);
                    sum += weight * (w[1] - w[0]) * value(&u, &v);
                }
            }
        }
        sum / self.parts as f64
    }

    /// The largest and smallest value of a functional over the whole period: sampled at all nodes, then
    /// refined by Brent's method wherever the samples do not rule out that the extremum is there.
    pub fn extremes(&self, problem: &dyn Problem, observable: usize, p: &[f64], symmetry: &Reflection) -> Extremes {
        let scheme = self.scheme();
        let observe = |(u, mut v): (Vec<f64>, Vec<f64>)| -> f64 {
            self.add_drift(problem, &u, &mut v);
            problem.observe(observable, At { u: &u, v: &v, p })
        };
        let places = &scheme.nodes[..self.degree];
        let weights: Vec<_> = places.iter().map(|&x| (scheme.values_at(x), scheme.slopes_at(x))).collect();
        let (mut times, mut values) = (Vec::new(), Vec::new());
        for part in 0..self.parts {
            for (j, w) in self.mesh.windows(2).enumerate() {
                for (x, (value, slope)) in places.iter().zip(&weights) {
                    times.push(part as f64 + w[0] + x * (w[1] - w[0]));
                    values.push(observe(reflected(self.combined(j, value, slope), part as i64, symmetry)));
                }
            }
        }
        let value = |t: f64| observe(self.anywhere(t, &scheme, symmetry));
        let period = self.parts as f64;
        let min = least(&times, period, &values, &value);
        values.iter_mut().for_each(|y| *y = -*y);
        Extremes { max: -least(&times, period, &values, &|t| -value(t)), min }
    }
}

/// A minimum between samples may be deeper than the parabola through them has it by this part of its depth.
const DEEPER: f64 = 1.0;

/// u and u' after some of the period's parts.
fn reflected((mut u, mut v): (Vec<f64>, Vec<f64>), parts: i64, symmetry: &Reflection) -> (Vec<f64>, Vec<f64>) {
    for _ in 0..parts {
        let (old_u, old_v) = (u.clone(), v.clone());
        symmetry.apply(&old_u, &mut u);
        symmetry.apply(&old_v, &mut v);
    }
    (u, v)
}

/// The least value of a periodic function from samples.
fn least(t: &[f64], period: f64, y: &[f64], f: &dyn Fn(f64) -> f64) -> f64 {
    let n = t.len();
    // Each local minimum with the least value that there may be around it.
    let mut valleys: Vec<(f64, f64, f64)> = (0..n)
        .filter_map(|i| {
            let (before, after) = ((i + n - 1) % n, (i + 1) % n);
            if y[before] < y[i] || y[after] < y[i] {
                return None;
            }
            let from = if i == 0 { t[before] - period } else { t[before] };
            let to = if i + 1 == n { t[after] + period } else { t[after] };
            let (left, right) = ((y[i] - y[before]) / (t[i] - from), (y[after] - y[i]) / (to - t[i]));
            let bend = (right - left) / (to - from);
            let slope = left + bend * (t[i] - from);
            let depth = if bend > 0.0 { slope * slope / (4.0 * bend) } else { 0.0 };
            Some((y[i] - (1.0 + DEEPER) * depth, from, to))
        })
        .collect();
    valleys.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = y.iter().copied().fold(f64::INFINITY, f64::min);
    for (k, &(bound, from, to)) in valleys.iter().enumerate() {
        if k > 0 && bound >= best {
            break;
        }
        best = best.min(refined(f, from, to));
    }
    best
}

/// The least value of a function of one valley.
fn refined(f: &dyn Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    struct Cost<'a>(&'a dyn Fn(f64) -> f64);
    impl CostFunction for Cost<'_> {
        type Param = f64;
        type Output = f64;
        fn cost(&self, t: &f64) -> Result<f64, argmin::core::Error> {
            Ok((self.0)(*t))
        }
    }
    let brent = BrentOpt::new(from, to).set_tolerance(1e-9, 1e-10);
    let found = Executor::new(Cost(f), brent).configure(|state| state.max_iters(60)).run();
    found.map_or(f64::INFINITY, |found| found.state().best_cost)
}
