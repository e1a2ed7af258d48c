//! Linear equations along an orbit with a closing condition of choice, bordered.
//!
//! ```text
//! L w_i + E z = r_i,     w_i(P) = sum_j kappa_ij S w_j(0) - b g_i + rho_i,     rows . (w_i, z) = gamma_i,
//! ```
//!
//! for d functions w_1, ..., w_d that the matrix kappa couples at the ends only, z being P and lambda as far as they
//! are unknown. kappa = 1 are variations of the orbit itself, kappa = -1 those of period doubling; a complex kappa is a
//! real 2 by 2 matrix. The elimination of all interior nodes does not depend on kappa, so that all such problems
//! share it; what is left is one small system. The border column b sits in the closing conditions: smooth,
//! whatever pivots the elimination takes.

use super::linear::Linear;
use crate::linalg::{Lu, Singular, dot};
use faer::Mat;

/// What closes the equations.
pub struct Closing {
    /// d by d.
    pub kappa: Mat<f64>,
    /// How many of (P, lambda) are unknown; only with d = 1.
    pub scalars: usize,
    pub column: Option<Vec<f64>>,
    /// Border rows, by their index in [`Linear`], and their entries for (P, lambda).
    pub rows: Vec<(usize, [f64; 2])>,
}

impl Closing {
    /// kappa as a number c + i s: d = 2 with real and imaginary part as components.
    pub fn rotation(c: f64, s: f64) -> Mat<f64> {
        faer::mat![[c, -s], [s, c]]
    }

    /// kappa as a root of `kappa² = 2 c kappa - 1`: components belong to 1 and kappa.
    pub fn companion(c: f64) -> Mat<f64> {
        faer::mat![[0.0, -1.0], [1.0, 2.0 * c]]
    }
}

/// Right-hand sides of one component; empty slices stand for zero.
#[derive(Clone, Copy, Default)]
pub struct Right<'a> {
    pub equations: &'a [f64],
    pub end: &'a [f64],
    pub rows: &'a [f64],
}

/// All nodes of each component, z, and each component's g.
#[derive(Clone, Debug)]
pub struct Solution {
    pub nodes: Vec<Vec<f64>>,
    pub z: [f64; 2],
    pub g: Vec<f64>,
}

/// The factored small system: unknown `(w_1(0), ..., w_d(0), g_1, ..., g_d, z)`.
pub struct Closed {
    closing: Closing,
    lu: Lu<f64>,
}

impl Closed {
    pub fn new(linear: &Linear, closing: Closing) -> Result<Self, Singular> {
        let (n, d) = (linear.n(), closing.kappa.nrows());
        let rows = linear.condensed.transition();
        let symmetry = linear.symmetry();
        let turned = |row: &dyn Fn(usize) -> f64| {
            let mut out = vec![0.0; n];
            symmetry.add_transposed(&(0..n).map(row).collect::<Vec<_>>(), &mut out);
            out
        };
        let columns = usize::from(closing.column.is_some());
        let size = d * (n + columns) + closing.scalars;
        let mut a = Mat::zeros(size, size);
        let z = d * (n + columns);
        let mut fill = |row: usize, component: usize, first: &dyn Fn(usize) -> f64, last: &dyn Fn(usize) -> f64| {
            let back = turned(last);
            for k in 0..n {
                a[(row, component * n + k)] += first(k);
                for j in 0..d {
                    a[(row, j * n + k)] += closing.kappa[(component, j)] * back[k];
                }
            }
            if let Some(b) = &closing.column {
                a[(row, d * n + component)] = -(0..n).map(|k| last(k) * b[k]).sum::<f64>();
            }
        };
        for component in 0..d {
            for i in 0..n {
                fill(component * n + i, component, &|k| rows.at(i, k), &|k| rows.at(i, n + k));
            }
            for (i, &(border, _)) in closing.rows.iter().enumerate() {
                let reach = &linear.reaches[border];
                fill(d * n + component * closing.rows.len() + i, component, &|k| reach.a[k], &|k| reach.b[k]);
            }
        }
        for s in 0..closing.scalars {
            (0..n).for_each(|i| a[(i, z + s)] = rows.at(i, 2 * n + s));
            for (i, &(border, direct)) in closing.rows.iter().enumerate() {
                a[(n + i, z + s)] = linear.reaches[border].z[s] + direct[s];
            }
        }
        Ok(Self { lu: Lu::new(a)?, closing })
    }

    pub fn column(&self) -> Option<Vec<f64>> {
        self.closing.column.clone()
    }

    /// For right-hand sides of all components.
    pub fn solve(&self, linear: &Linear, right: &[Right]) -> Solution {
        let (n, d) = (linear.n(), right.len());
        let transition = linear.condensed.transition();
        let (zero, borders) = (vec![0.0; linear.count()], self.closing.rows.len());
        let mut ends = vec![0.0; d * (n + borders)];
        let mut carried = Vec::with_capacity(d);
        for (i, right) in right.iter().enumerate() {
            let mut border = vec![0.0; linear.reaches.len()];
            for (&(row, _), gamma) in self.closing.rows.iter().zip(right.rows) {
                border[row] = *gamma;
            }
            let equations = if right.equations.is_empty() { &zero } else { right.equations };
            let (forwarded, rows) = linear.condensed.forward(equations, &mut border);
            carried.push(forwarded);
            ends[i * n..(i + 1) * n].copy_from_slice(&rows);
            let below = &mut ends[d * n + i * borders..];
            for (below, &(row, _)) in below.iter_mut().zip(&self.closing.rows) {
                *below = border[row];
            }
            if !right.end.is_empty() {
                for k in 0..n {
                    ends[i * n + k] -= (0..n).map(|l| transition.at(k, n + l) * right.end[l]).sum::<f64>();
                }
                for (k, &(row, _)) in self.closing.rows.iter().enumerate() {
                    ends[d * n + i * borders + k] -= dot(&linear.reaches[row].b, right.end);
                }
            }
        }
        self.lu.solve(&mut ends);
        let columns = usize::from(self.closing.column.is_some());
        let g = ends[d * n..d * (n + columns)].to_vec();
        let mut z = [0.0; 2];
        z[..self.closing.scalars].copy_from_slice(&ends[d * (n + columns)..]);
        let turned: Vec<Vec<f64>> = (0..d)
            .map(|j| {
                let mut out = vec![0.0; n];
                linear.symmetry().apply(&ends[j * n..(j + 1) * n], &mut out);
                out
            })
            .collect();
        let nodes = carried.into_iter().enumerate().map(|(i, forwarded)| {
            let mut last: Vec<f64> = right[i].end.to_vec();
            last.resize(n, 0.0);
            for k in 0..n {
                last[k] += (0..d).map(|j| self.closing.kappa[(i, j)] * turned[j][k]).sum::<f64>();
                if let Some(b) = &self.closing.column {
                    last[k] -= b[k] * g[i];
                }
            }
            let mut nodes = vec![0.0; linear.count()];
            linear.condensed.back(forwarded, (&ends[i * n..(i + 1) * n], &last), &z, &mut nodes);
            nodes.extend(last);
            nodes
        });
        Solution { nodes: nodes.collect(), z, g }
    }

    /// How g of component i answers to the closings' right-hand sides of all components: the left null vectors' parts
    /// at the end, which are the best border column where the unbordered system is singular.
    pub fn left(&self, linear: &Linear, i: usize) -> Vec<Vec<f64>> {
        let (n, d) = (linear.n(), self.closing.kappa.nrows());
        let borders = self.closing.rows.len();
        let mut y = vec![0.0; d * (n + borders)];
        y[d * n + i] = 1.0;
        self.lu.solve_adjoint(&mut y);
        let transition = linear.condensed.transition();
        let part = |j: usize| {
            let mut eta = vec![0.0; n];
            for (l, eta) in eta.iter_mut().enumerate() {
                *eta = -(0..n).map(|k| transition.at(k, n + l) * y[j * n + k]).sum::<f64>();
                for (k, &(row, _)) in self.closing.rows.iter().enumerate() {
                    *eta -= linear.reaches[row].b[l] * y[d * n + j * borders + k];
                }
            }
            eta
        };
        (0..d).map(part).collect()
    }
}
