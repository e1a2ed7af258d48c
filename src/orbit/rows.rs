//! The rows that couple the ends of an interval, or of a span of several, once its inside is eliminated.

use crate::problem::Reflection;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// Entries up to this size are taken as multipliers without exchanging rows: each elimination then magnifies rounding errors
/// by no more than that, and there are log2(intervals) of them above each other.
pub const GROWTH: f64 = 8.0;

/// `C x_a + D x_b + E z = r`, n rows.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    pub c: MatRef<'a, f64>,
    /// None stands for -1.
    pub d: Option<MatRef<'a, f64>>,
    pub e: MatRef<'a, f64>,
}

impl Rows<'_> {
    /// n.
    pub fn n(&self) -> usize {
        self.c.ncols()
    }

    /// `out += factor D S`.
    pub fn add_end(&self, symmetry: &Reflection, factor: f64, mut out: MatMut<'_, f64>) {
        for (j, (&source, &sign)) in symmetry.source.iter().zip(&symmetry.sign).enumerate() {
            match self.d {
                Some(d) => faer::zip!(out.as_mut().col_mut(source), d.col(j))
                    .for_each(|faer::unzip!(out, d)| *out += factor * sign * *d),
                None => out[(j, source)] -= factor * sign,
            }
        }
    }

    /// An entry of `[C D E]`.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        let n = self.n();
        match (j / n, self.d) {
            (0, _) => self.c[(i, j)],
            (1, Some(d)) => d[(i, j - n)],
            (1, None) => -f64::from(u8::from(i == j - n)),
            _ => self.e[(i, j - 2 * n)],
        }
    }
}

/// What a border row multiplies after elimination: `x_a`, `x_b` and `z`.
#[derive(Clone, Debug)]
pub struct Reach {
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    pub z: Vec<f64>,
}

/// `y -= A x`.
pub fn subtract_product(a: MatRef<'_, f64>, x: &[f64], y: &mut [f64]) {
    add_product(-1.0, a, x, y);
}

/// `y += factor A x`.
pub fn add_product(factor: f64, a: MatRef<'_, f64>, x: &[f64], y: &mut [f64]) {
    let rows = y.len();
    let x = MatRef::from_column_major_slice(x, x.len(), 1);
    let y = MatMut::from_column_major_slice_mut(y, rows, 1);
    matmul(y, Accum::Add, a, x, factor, Par::Seq);
}
