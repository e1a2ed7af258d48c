//! A collocation point's equations, solved for half of what they are about.
//!
//! ```text
//! G_u u + G_v u' + E z = r,      w = (u, u'/s),      B w_p + N w_f + E z = r,
//! w_p = B^-1 r - K (w_f, z),     K = B^-1 [N E].
//! ```
//!
//! Partial pivoting among the 2 n columns of `[G_u, s G_v]` decides which n entries of w make up w_p: neither G_u nor G_v
//! need be regular, and stiff parts are expressed by their rates, others by their values. Both columns of an unknown are first
//! divided by their size, so that units do not matter.

use crate::linalg::{Singular, eliminate};
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_unit_upper_triangular_in_place};
use faer::{Mat, MatMut, Par};

/// The equations, factored.
pub struct Pair {
    /// `B D = U^T L^T`, L and U in one.
    factors: Mat<f64>,
    /// Places in w of w_p, then of w_f.
    order: Vec<usize>,
    /// D: the sizes of w_p.
    sizes: Vec<f64>,
    /// K.
    pub kept: Mat<f64>,
}

impl Pair {
    /// From the point's Jacobians, s, and the columns of z, n rows.
    pub fn new((gu, gv): &(Mat<f64>, Mat<f64>), s: f64, scalars: &[f64]) -> Result<Self, Singular> {
        let n = gu.nrows();
        let width = scalars.len() / n;
        let sizes = sizes(gu, gv, s);
        let mut tall = Mat::zeros(2 * n, n);
        for (j, d) in sizes.iter().enumerate() {
            for (i, (x, y)) in gu.col_as_slice(j).iter().zip(gv.col_as_slice(j)).enumerate() {
                tall[(j, i)] = d * x;
                tall[(n + j, i)] = d * s * y;
            }
        }
        let order = eliminate(&mut tall)?;
        let (factors, below) = tall.as_ref().split_at_row(n);
        let mut kept = Mat::zeros(n, n + width);
        kept.as_mut().subcols_mut(0, n).copy_from(below.transpose());
        for (k, &entry) in scalars.iter().enumerate() {
            kept[(k / width, n + k % width)] = entry;
        }
        solve_lower_triangular_in_place(factors.transpose(), kept.as_mut().subcols_mut(n, width), Par::Seq);
        solve_unit_upper_triangular_in_place(factors.transpose(), kept.as_mut(), Par::Seq);
        let of = |place: &usize| sizes[place % n];
        let (solved, free): (Vec<f64>, Vec<f64>) =
            (order[..n].iter().map(of).collect(), order[n..].iter().map(of).collect());
        for j in 0..n + width {
            let unit = free.get(j).copied().unwrap_or(1.0);
            kept.col_as_slice_mut(j).iter_mut().zip(&solved).for_each(|(x, size)| *x *= size / unit);
        }
        Ok(Self { factors: factors.to_owned(), order, sizes: solved, kept })
    }

    /// Places in w of w_p and of w_f.
    pub fn places(&self) -> (&[usize], &[usize]) {
        self.order.split_at(self.sizes.len())
    }

    /// `B^-1 r`.
    pub fn solve(&self, r: &[f64]) -> Vec<f64> {
        let mut x = r.to_vec();
        let view = MatMut::from_column_major_slice_mut(&mut x, r.len(), 1);
        solve_lower_triangular_in_place(self.factors.transpose(), view, Par::Seq);
        let view = MatMut::from_column_major_slice_mut(&mut x, r.len(), 1);
        solve_unit_upper_triangular_in_place(self.factors.transpose(), view, Par::Seq);
        x.iter_mut().zip(&self.sizes).for_each(|(x, size)| *x *= size);
        x
    }
}

/// For each unknown the power of two next to one over the largest of its entries, each relative to the largest of its row.
fn sizes(gu: &Mat<f64>, gv: &Mat<f64>, s: f64) -> Vec<f64> {
    let n = gu.nrows();
    let entries =
        |j: usize| gu.col_as_slice(j).iter().zip(gv.col_as_slice(j)).map(move |(x, y)| x.abs().max(s * y.abs()));
    let mut rows = vec![0.0_f64; n];
    (0..n).for_each(|j| rows.iter_mut().zip(entries(j)).for_each(|(row, x)| *row = row.max(x)));
    let largest = |j: usize| entries(j).zip(&rows).map(|(x, row)| x / row).fold(0.0, f64::max);
    let size = |x: f64| if x > 0.0 && x.is_finite() { (-x.log2()).round().exp2() } else { 1.0 };
    (0..n).map(|j| size(largest(j))).collect()
}
