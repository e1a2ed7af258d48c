//! Elimination of what lies inside: LU with partial pivoting of a tall block.
//!
//! ```text
//! [ inside | x_a  x_b  z ] = r,      rows = inside + n,
//! ```
//!
//! leaves n rows `C x_a + D x_b + E z = r'`, and if asked to, `-D^-1` times these. Border rows (phase, arclength) are carried
//! along. Eliminations run side by side, each on one thread.

use super::rows::{GROWTH, Reach, Rows, subtract_product};
use crate::linalg::{Lu, Singular, dot, eliminate, permute};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, MatRef, Par};

/// A tall block `[inside | right]` after elimination of its inside columns.
pub struct Elimination {
    /// L below the diagonal, U on and above it.
    factors: Mat<f64>,
    order: Vec<usize>,
    /// Rows of the right part: on top what gives the inside, below the n remaining rows `[C D E]`.
    right: Mat<f64>,
    /// D, where the remaining rows are solved for x_b.
    end: Option<Lu<f64>>,
    /// For each border, its entries on the inside times U^-1.
    borders: Mat<f64>,
    n: usize,
}

impl Elimination {
    /// Eliminates the columns of `inside`; `right` has columns `[x_a (n), x_b (n), z]`.
    pub fn new(mut inside: Mat<f64>, mut right: Mat<f64>, n: usize) -> Result<Self, Singular> {
        let columns = inside.ncols();
        let order = eliminate(&mut inside)?;
        permute(right.as_mut(), &order);
        let (mut top, bottom) = right.as_mut().split_at_row_mut(columns);
        solve_unit_lower_triangular_in_place(inside.as_ref().subrows(0, columns), top.as_mut(), Par::Seq);
        matmul(bottom, Accum::Add, inside.as_ref().subrows(columns, n), top.as_ref(), -1.0, Par::Seq);
        Ok(Self { factors: inside, order, right, end: None, borders: Mat::new(), n })
    }

    /// Solves the remaining rows for x_b: D = -1 then, which makes joints cheap. Where an entry of C grew beyond `GROWTH` by
    /// that, they are left as pivoting made them.
    pub fn solve_for_end(&mut self) {
        let Rows { c, d: Some(d), e } = self.remaining() else { return };
        let Ok(end) = Lu::new(d.to_owned()) else { return };
        let n = self.n;
        let mut solved = Mat::from_fn(n, n + e.ncols(), |i, j| if j < n { -c[(i, j)] } else { -e[(i, j - n)] });
        end.solve_many(solved.as_mut());
        // Not a number is not below.
        if !(solved.as_ref().subcols(0, n).norm_max() <= GROWTH && solved.is_all_finite()) {
            return;
        }
        let columns = self.inside();
        for (j, solved) in solved.col_iter().enumerate() {
            let target = if j < n { j } else { n + j };
            self.right.as_mut().col_mut(target).subrows_mut(columns, n).copy_from(solved);
        }
        self.end = Some(end);
    }

    pub fn inside(&self) -> usize {
        self.factors.ncols()
    }

    pub fn remaining(&self) -> Rows<'_> {
        let (n, rows) = (self.n, self.right.as_ref().subrows(self.inside(), self.n));
        let d = self.end.is_none().then(|| rows.subcols(n, n));
        Rows { c: rows.subcols(0, n), d, e: rows.subcols(2 * n, rows.ncols() - 2 * n) }
    }

    /// Forgets the remaining rows, which another elimination has taken over.
    pub fn shrink(&mut self) {
        self.right = self.right.as_ref().subrows(0, self.inside()).to_owned();
    }

    fn upper(&self) -> MatRef<'_, f64> {
        self.factors.as_ref().subrows(0, self.inside())
    }

    /// Eliminates the border rows' entries on the inside, a column for each row; the change of their entries elsewhere.
    pub fn add_borders(&mut self, mut rows: Mat<f64>) -> Vec<Reach> {
        let n = self.n;
        solve_lower_triangular_in_place(self.upper().transpose(), rows.as_mut(), Par::Seq);
        let top = self.right.as_ref().subrows(0, self.inside());
        let mut change = Mat::zeros(top.ncols(), rows.ncols());
        matmul(change.as_mut(), Accum::Replace, top.transpose(), rows.as_ref(), -1.0, Par::Seq);
        self.borders = rows;
        let parts = |change: &[f64]| [&change[..n], &change[n..2 * n], &change[2 * n..]].map(<[f64]>::to_vec);
        (0..change.ncols()).map(|j| parts(change.col_as_slice(j))).map(|[a, b, z]| Reach { a, b, z }).collect()
    }

    /// Applies the elimination to a right-hand side: the upper part, and the n remaining entries; `border` collects
    /// what the borders' right-hand sides lose.
    pub fn forward(&self, r: &[f64], border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        let columns = self.inside();
        let mut top: Vec<f64> = self.order[..columns].iter().map(|&i| r[i]).collect();
        let mut bottom: Vec<f64> = self.order[columns..].iter().map(|&i| r[i]).collect();
        let view = faer::MatMut::from_column_major_slice_mut(&mut top, columns, 1);
        solve_unit_lower_triangular_in_place(self.upper(), view, Par::Seq);
        subtract_product(self.factors.as_ref().subrows(columns, self.n), &top, &mut bottom);
        for (j, border) in border.iter_mut().enumerate().take(self.borders.ncols()) {
            *border -= dot(self.borders.col_as_slice(j), &top);
        }
        if let Some(end) = &self.end {
            end.solve(&mut bottom);
            bottom.iter_mut().for_each(|x| *x = -*x);
        }
        (top, bottom)
    }

    /// The inside from the ends and z.
    pub fn back(&self, mut top: Vec<f64>, a: &[f64], b: &[f64], z: &[f64]) -> Vec<f64> {
        let columns = self.inside();
        let outer: Vec<f64> = a.iter().chain(b).chain(z).copied().collect();
        subtract_product(self.right.as_ref().subrows(0, columns), &outer, &mut top);
        let view = faer::MatMut::from_column_major_slice_mut(&mut top, columns, 1);
        solve_upper_triangular_in_place(self.upper(), view, Par::Seq);
        top
    }
}
