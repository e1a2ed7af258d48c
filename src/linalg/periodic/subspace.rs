//! A subspace carried round as a block:
//!
//! ```text
//! A_j V_j = V_{j+1} T_j,   T_j upper triangular for j < N - 1,      A_{N-1} V_{N-1} = V_0 H + R.
//! ```
//!
//! A start that is nearly invariant is so to rounding after a round or two (Stewart 1976, doi:10.1007/BF01432880), and a
//! round reads every factor once.

use super::dense::{Dense, axpy};
use super::krylov::DEPENDENT;
use super::ritz::Ritz;
use super::{Eigenvalue, Product};
use crate::linalg::dot;
use faer::Accum::{Add, Replace};
use faer::Par;
use faer::linalg::matmul::matmul;

const ROUNDS: usize = 3;

/// The eigenvalues that belong to the subspace that an orthonormal basis spans, if the k largest converge.
pub(super) fn carried(product: &dyn Product, basis: Dense, k: usize) -> Option<Vec<Eigenvalue>> {
    let (last, size) = (product.factors() - 1, basis.cols);
    let mut first = basis;
    for _ in 0..ROUNDS {
        let mut t = Vec::with_capacity(last + 1);
        let mut v = first.clone();
        for j in 0..last {
            let (next, triangle) = orthonormal(applied(product, j, &v))?;
            t.push(triangle);
            v = next;
        }
        let image = applied(product, last, &v);
        let (mut h, mut left) = (Dense::zeros(size, size), image.clone());
        matmul(h.view_mut(), Replace, first.view().transpose(), image.view(), 1.0, Par::Seq);
        matmul(left.view_mut(), Add, first.view(), h.view(), -1.0, Par::Seq);
        t.push(h);
        let residuals = |basis: &Dense| {
            let turned = left.view() * basis.view();
            turned.col_iter().map(|column| column.norm_l2()).collect()
        };
        let ritz = Ritz::new(t, k, &residuals)?;
        if ritz.converged {
            return Some(ritz.values);
        }
        first = orthonormal(image)?.0;
    }
    None
}

fn applied(product: &dyn Product, j: usize, v: &Dense) -> Dense {
    let mut image = Dense::zeros(v.rows, v.cols);
    product.apply(j, v.view(), image.view_mut());
    image
}

/// `W = Q R` by Gram and Schmidt, twice; None where columns depend on each other or are not finite.
fn orthonormal(mut w: Dense) -> Option<(Dense, Dense)> {
    let (n, size) = (w.rows, w.cols);
    let mut triangle = Dense::zeros(size, size);
    for k in 0..size {
        let (known, rest) = w.a.split_at_mut(k * n);
        let column = &mut rest[..n];
        let before = dot(column, column).sqrt();
        for _ in 0..2 {
            let parts: Vec<f64> = known.chunks(n).map(|v| dot(v, column)).collect();
            for (i, (v, part)) in known.chunks(n).zip(&parts).enumerate() {
                axpy(-part, v, column);
                triangle.set(i, k, triangle.at(i, k) + part);
            }
        }
        let after = dot(column, column).sqrt();
        if after.is_nan() || after <= DEPENDENT * before {
            return None;
        }
        column.iter_mut().for_each(|x| *x /= after);
        triangle.set(k, k, after);
    }
    Some((w, triangle))
}
