//! Reference vectors of the bordered systems along a branch of critical cycles.

use super::{Critical, Place};
use crate::linalg::{any, dot, real_direction, unit};
use crate::orbit::{Orbit, Scheme};

/// Borders: columns in the closing conditions, rows as functions at all nodes.
#[derive(Clone, Debug)]
pub struct Borders {
    /// Of the variations of the orbit itself (kappa = 1), with an entry for P in the row.
    pub column: Vec<f64>,
    pub row: Vec<f64>,
    pub row_part: f64,
    /// Of the critical functions, where kappa is not 1.
    pub critical: Option<(Vec<f64>, Vec<f64>)>,
}

impl Borders {
    /// Any vectors: a few steps of [`Borders::follow`] make good ones.
    pub fn any(orbit: &Orbit, kind: Critical) -> Self {
        let n = orbit.dim;
        let column = unit(&any(n));
        let count = orbit.nodes.len() / n;
        let size = (count as f64).sqrt();
        let row: Vec<f64> = (0..count).flat_map(|_| column.iter().map(|c| c / size)).collect();
        let critical = (kind != Critical::Fold).then(|| (column.clone(), row.clone()));
        Self { column, row, row_part: 0.0, critical }
    }

    /// Takes the null vectors at a place.
    pub fn follow(&mut self, place: &Place) {
        let kernel = place.kernel();
        let size = (dot(&kernel.nodes[0], &kernel.nodes[0]) + kernel.z[0].powi(2)).sqrt();
        self.row = kernel.nodes[0].iter().map(|w| w / size).collect();
        self.row_part = kernel.z[0] / size;
        self.column = unit(&place.kernel_left());
        if let Some((right, left)) = place.critical() {
            self.critical = Some((real_direction(&left), real_direction(&right)));
        }
    }

    /// Rows on another mesh or degree, by interpolation.
    pub fn interpolated(&self, from: &Orbit, mesh: &[f64], degree: usize) -> Self {
        let ratio = ((from.nodes.len() / from.dim) as f64 / (degree * (mesh.len() - 1) + 1) as f64).sqrt();
        let moved = |row: &[f64]| -> Vec<f64> {
            let function = Orbit { nodes: row.to_vec(), ..from.clone() };
            function.interpolated(mesh, degree).nodes.iter().map(|w| w * ratio).collect()
        };
        let critical = self.critical.as_ref().map(|(column, row)| (column.clone(), moved(row)));
        Self { column: self.column.clone(), row: moved(&self.row), row_part: self.row_part, critical }
    }

    /// The same on a finer discretisation in space.
    pub fn mapped(&self, n: usize, map: &dyn Fn(&[f64]) -> Vec<f64>) -> Self {
        let all = |row: &[f64]| -> Vec<f64> { row.chunks(n).flat_map(map).collect() };
        let critical = self.critical.as_ref().map(|(column, row)| (map(column), all(row)));
        Self { column: map(&self.column), row: all(&self.row), row_part: self.row_part, critical }
    }
}

/// Quadrature weights of all nodes: `int f dtau = sum weight f`.
pub fn weights(orbit: &Orbit, scheme: &Scheme) -> Vec<f64> {
    let m = orbit.degree;
    let mut weights = vec![0.0; orbit.intervals() * m + 1];
    for (j, w) in orbit.mesh.windows(2).enumerate() {
        for (weight, value) in scheme.weights.iter().zip(&scheme.value) {
            for (l, value) in value.iter().enumerate() {
                weights[j * m + l] += (w[1] - w[0]) * weight * value;
            }
        }
    }
    weights
}
