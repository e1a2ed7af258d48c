//! The scalars that vanish where a cycle is critical, at one orbit, with their derivatives.
//!
//! With base borders (b, c) the variations of the orbit are regular,
//!
//! ```text
//! L w + E_P P' = 0,   w(P) = S w(0) - b g,   phase . w = 0,   c . (w, P') = 1,
//! ```
//!
//! and g = 0 where the cycle has a fold. With another pair of borders and kappa = -1, or kappa² = 2 cos(theta) kappa - 1
//! (numbers w_r + kappa w_s: two components), the scalars vanish at a period doubling, or at a torus bifurcation;
//! `dg` along a direction d of (nodes, P, p) is the scalar of the same system with right-hand side `-D²G[w, d]`
//! (Govaerts 2000, doi:10.1137/1.9780898719543; Kuznetsov, Govaerts, Doedel and Dhooge 2005, doi:10.1137/040611306).

use super::closing::{Closed, Closing, Right, Solution};
use super::linear::{Field, Linear};
use super::signs::pivots;
use super::{Borders, Critical};
use crate::linalg::{Lu, Singular, c64};
use crate::orbit::{Collocation, Orbit};
use faer::Mat;

/// Border rows in [`Linear`].
const PHASE: usize = 0;
const BASE: usize = 1;
const CRITICAL: usize = 2;

/// Everything at one orbit.
pub struct Place {
    pub linear: Linear,
    /// cos(theta) where that is an unknown.
    cosine: Option<f64>,
    base: Closed,
    kernel: Solution,
    closed: Option<(Closed, Solution)>,
    /// The functions that derivatives of the scalars act on.
    null: Vec<Field>,
}

impl Place {
    pub fn new(
        system: &Collocation,
        (orbit, p): (Orbit, Vec<f64>),
        (kind, cosine): (Critical, f64),
        borders: &Borders,
    ) -> Result<Self, Singular> {
        let inner = |row: &'_ Vec<f64>| row[..row.len() - orbit.dim].to_vec();
        let mut rows = vec![inner(&borders.row)];
        rows.extend(borders.critical.iter().map(|(_, row)| inner(row)));
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let linear = Linear::new(system, orbit.clone(), p, &rows)?;
        let base = Closed::new(
            &linear,
            Closing {
                kappa: Mat::identity(1, 1),
                scalars: 1,
                column: Some(borders.column.clone()),
                rows: vec![(PHASE, [0.0; 2]), (BASE, [borders.row_part, 0.0])],
            },
        )?;
        let kernel = base.solve(&linear, &[Right { rows: &[0.0, 1.0], ..Right::default() }]);
        let kappa = match kind {
            Critical::Fold => None,
            Critical::Flip => Some(faer::mat![[-1.0]]),
            Critical::Torus => Some(Closing::companion(cosine)),
        };
        let closed = match (kappa, &borders.critical) {
            (Some(kappa), Some((column, _))) => {
                let d = kappa.nrows();
                let rows = vec![(CRITICAL, [0.0; 2])];
                let closed = Closed::new(&linear, Closing { kappa, scalars: 0, column: Some(column.clone()), rows })?;
                let mut right = vec![Right::default(); d];
                right[0].rows = &[1.0];
                let solution = closed.solve(&linear, &right);
                Some((closed, solution))
            }
            _ => None,
        };
        let null = match &closed {
            Some((_, solution)) => solution.nodes.iter().map(|w| linear.field(w, 0.0, Vec::new())).collect(),
            None => vec![linear.field(&kernel.nodes[0], kernel.z[0], Vec::new())],
        };
        let cosine = (kind == Critical::Torus).then_some(cosine);
        Ok(Self { linear, cosine, base, kernel, closed, null })
    }

    /// The scalars: one, or two where cos(theta) is an unknown.
    pub fn scalars(&self) -> &[f64] {
        self.closed.as_ref().map_or(&self.kernel.g, |(_, solution)| &solution.g)
    }

    /// A function that changes sign where variations of the orbit are singular, at folds and branch points: the sign of
    /// their determinant times the distance of the multiplier nearest to 1 from it; nu are those but the trivial one.
    pub fn fold(&self, nu: &[c64]) -> Result<f64, Singular> {
        let (n, rows) = (self.linear.n(), self.linear.condensed.transition());
        let (symmetry, phase) = (self.linear.symmetry(), &self.linear.reaches[PHASE]);
        let mut whole = Mat::zeros(n + 1, n + 1);
        for i in 0..=n {
            let entry = |k: usize| {
                if i < n {
                    rows.at(i, k)
                } else if k < n {
                    phase.a[k]
                } else {
                    phase.b[k - n]
                }
            };
            for k in 0..n {
                whole[(i, k)] += entry(k);
                whole[(i, symmetry.source[k])] += entry(n + k) * symmetry.sign[k];
            }
            whole[(i, n)] = if i < n { rows.at(i, 2 * n) } else { phase.z[0] };
        }
        let nearest = nu.iter().map(|nu| (nu - 1.0).norm()).fold(f64::INFINITY, f64::min);
        Ok(Lu::new(whole)?.sign() * pivots(rows, symmetry, nu)? * nearest)
    }

    /// The base system's solution (w, P').
    pub fn kernel(&self) -> &Solution {
        &self.kernel
    }

    /// The base system's left vector at the end.
    pub fn kernel_left(&self) -> Vec<f64> {
        self.base.left(&self.linear, 0).swap_remove(0)
    }

    /// Solves the base system: equations, phase, border.
    pub fn base(&self, equations: &[f64], rows: [f64; 2]) -> Solution {
        self.base.solve(&self.linear, &[Right { equations, rows: &rows, end: &[] }])
    }

    /// Solves the critical system (at a fold that is the base system) for equations of each component.
    pub fn singular(&self, equations: &[&[f64]]) -> Solution {
        let right: Vec<Right> = equations.iter().map(|&equations| Right { equations, ..Right::default() }).collect();
        self.closed.as_ref().map_or(&self.base, |(closed, _)| closed).solve(&self.linear, &right)
    }

    /// The critical system at kappa as a complex number: real and imaginary part as components.
    pub fn complex(&self) -> Result<Closed, Singular> {
        let kappa = self.kappa();
        let column = self.closed.as_ref().and_then(|(closed, _)| closed.column());
        let closing = Closing {
            kappa: Closing::rotation(kappa.re, kappa.im),
            scalars: 0,
            column,
            rows: vec![(CRITICAL, [0.0; 2])],
        };
        Closed::new(&self.linear, closing)
    }

    /// The critical functions at all nodes.
    pub fn null_nodes(&self) -> &[Vec<f64>] {
        self.closed.as_ref().map_or(&self.kernel.nodes, |(_, solution)| &solution.nodes)
    }

    /// kappa as a complex number.
    pub fn kappa(&self) -> c64 {
        match self.cosine {
            Some(c) => c64::new(c, (1.0 - c * c).max(0.0).sqrt()),
            None => c64::new(if self.closed.is_some() { -1.0 } else { 1.0 }, 0.0),
        }
    }

    /// The critical function and its left vector as complex vectors; None at folds.
    pub fn critical(&self) -> Option<(Vec<c64>, Vec<c64>)> {
        let (closed, solution) = self.closed.as_ref()?;
        let joined = |parts: &[&Vec<f64>]| -> Vec<c64> {
            let other = |i: usize| parts.get(1).map_or(c64::new(0.0, 0.0), |part| self.kappa() * part[i]);
            (0..parts[0].len()).map(|i| other(i) + parts[0][i]).collect()
        };
        let right = joined(&solution.nodes.iter().collect::<Vec<_>>());
        let left: Vec<Vec<f64>> = (0..solution.g.len()).map(|i| closed.left(&self.linear, i).swap_remove(0)).collect();
        Some((right, joined(&left.iter().collect::<Vec<_>>())))
    }

    /// Derivatives of the scalars along a variation of (nodes, P, p), and of cos(theta).
    pub fn along(&self, direction: Option<&Field>, cosine: f64) -> Vec<f64> {
        let equations: Vec<Vec<f64>> = match direction {
            Some(direction) => self.null.iter().map(|w| negated(self.linear.second(w, direction))).collect(),
            None => vec![Vec::new(); self.null.len()],
        };
        let mut right: Vec<Right> = equations.iter().map(|equations| Right { equations, ..Right::default() }).collect();
        let mut end = vec![0.0; self.linear.n()];
        match &self.closed {
            None => self.base.solve(&self.linear, &right).g,
            Some((closed, solution)) => {
                if self.cosine.is_some() && cosine != 0.0 {
                    // The closing w_s(P) = S (w_r + 2 c w_s)(0) moves by 2 dc S w_s(0).
                    self.linear.symmetry().apply(&solution.nodes[1][..self.linear.n()], &mut end);
                    end.iter_mut().for_each(|x| *x *= 2.0 * cosine);
                    right[1].end = &end;
                }
                closed.solve(&self.linear, &right).g
            }
        }
    }
}

pub fn negated(mut x: Vec<f64>) -> Vec<f64> {
    x.iter_mut().for_each(|x| *x = -*x);
    x
}
