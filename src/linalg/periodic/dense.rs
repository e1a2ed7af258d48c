//! A column-major matrix of plain numbers, and the reflectors that act on a few of its rows or columns.

use crate::linalg::dot;
use faer::{MatMut, MatRef};

/// Rows by columns, column after column without gaps.
#[derive(Clone, Debug)]
pub(super) struct Dense {
    pub rows: usize,
    pub cols: usize,
    pub a: Vec<f64>,
}

impl Dense {
    pub fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, a: vec![0.0; rows * cols] }
    }

    pub fn identity(n: usize) -> Self {
        let mut one = Self::zeros(n, n);
        (0..n).for_each(|i| one.a[i * n + i] = 1.0);
        one
    }

    /// Rows `rows` and columns `cols` of a matrix.
    pub fn part(of: MatRef<'_, f64>, rows: &[usize], cols: &[usize]) -> Self {
        let a = cols.iter().flat_map(|&j| rows.iter().map(move |&i| of[(i, j)])).collect();
        Self { rows: rows.len(), cols: cols.len(), a }
    }

    #[inline]
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.a[j * self.rows + i]
    }

    #[inline]
    pub fn set(&mut self, i: usize, j: usize, value: f64) {
        self.a[j * self.rows + i] = value;
    }

    #[inline]
    pub fn col(&self, j: usize) -> &[f64] {
        &self.a[j * self.rows..][..self.rows]
    }

    #[inline]
    pub fn col_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.a[j * self.rows..][..self.rows]
    }

    pub fn view(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.a, self.rows, self.cols)
    }

    pub fn view_mut(&mut self) -> MatMut<'_, f64> {
        MatMut::from_column_major_slice_mut(&mut self.a, self.rows, self.cols)
    }

    pub fn largest(&self) -> f64 {
        self.a.iter().fold(0.0, |most, x| most.max(x.abs()))
    }

    /// The first rows and columns only.
    pub fn truncated(&self, rows: usize, cols: usize) -> Self {
        let a = (0..cols).flat_map(|j| self.col(j)[..rows].iter().copied()).collect();
        Self { rows, cols, a }
    }
}

impl From<MatRef<'_, f64>> for Dense {
    fn from(a: MatRef<'_, f64>) -> Self {
        let mut out = Self::zeros(a.nrows(), a.ncols());
        out.view_mut().copy_from(a);
        out
    }
}

/// `y += a x`.
pub(super) fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}

/// `I - tau v v^T` with `v = (1, tail)`, which turns a given vector into `(beta, 0, ..)`.
#[derive(Clone, Debug)]
pub(super) struct Reflector {
    pub tau: f64,
    /// The whole of v, its leading 1 included.
    pub v: Vec<f64>,
}

impl Reflector {
    /// For a vector, and its beta. What is tiny beside the first entry stays in the tail, however tiny.
    pub fn new(x: &[f64]) -> (Self, f64) {
        let mut v = x.to_vec();
        let (tau, beta) = householder(&mut v);
        (Self { tau, v }, beta)
    }

    /// From the left on rows `k ..` of the columns `from .. to`.
    pub fn left(&self, a: &mut Dense, k: usize, from: usize, to: usize) {
        if self.tau == 0.0 {
            return;
        }
        for j in from..to {
            let x = &mut a.col_mut(j)[k..k + self.v.len()];
            let s = self.tau * dot(&self.v, x);
            axpy(-s, &self.v, x);
        }
    }

    /// From the right on columns `k ..` of the first `to` rows; `work` is overwritten.
    pub fn right(&self, a: &mut Dense, k: usize, to: usize, work: &mut Vec<f64>) {
        if self.tau == 0.0 {
            return;
        }
        work.clear();
        work.resize(to, 0.0);
        for (l, &v) in self.v.iter().enumerate() {
            axpy(self.tau * v, &a.col(k + l)[..to], work);
        }
        for (l, &v) in self.v.iter().enumerate() {
            axpy(-v, work, &mut a.col_mut(k + l)[..to]);
        }
    }
}

/// v on the place of x, its first entry 1; tau and beta.
fn householder(x: &mut [f64]) -> (f64, f64) {
    let first = x[0];
    let size = x[1..].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    x[0] = 1.0;
    if size == 0.0 {
        return (0.0, first);
    }
    let size = size.max(first.abs());
    let squares = x[1..].iter().map(|x| (x / size) * (x / size)).sum::<f64>() + (first / size) * (first / size);
    let beta = -first.signum() * size * squares.sqrt();
    x[1..].iter_mut().for_each(|x| *x /= first - beta);
    ((beta - first) / beta, beta)
}

/// A reflector of two or three entries: the working tool of the iteration. The third is zero where there are two.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Small {
    tau: f64,
    v: [f64; 2],
}

impl Small {
    pub fn new(x: [f64; 3]) -> (Self, f64) {
        let mut v = x;
        let (tau, beta) = householder(&mut v);
        (Self { tau, v: [v[1], v[2]] }, beta)
    }

    /// tau and the second entry of v.
    pub fn pair(&self) -> (f64, f64) {
        (self.tau, self.v[0])
    }

    /// From the left on `size` rows from k, of the columns `from .. to`.
    pub fn left(&self, a: &mut Dense, (k, size): (usize, usize), from: usize, to: usize) {
        if self.tau == 0.0 || from >= to {
            return;
        }
        let (tau, [v, w], rows) = (self.tau, self.v, a.rows);
        let columns = a.a[from * rows..to * rows].chunks_exact_mut(rows);
        if size == 3 {
            for column in columns {
                let [x, y, z] = &mut column[k..k + 3] else { return };
                let s = tau * (*x + v * *y + w * *z);
                *x -= s;
                *y -= s * v;
                *z -= s * w;
            }
        } else {
            for column in columns {
                let [x, y] = &mut column[k..k + 2] else { return };
                let s = tau * (*x + v * *y);
                *x -= s;
                *y -= s * v;
            }
        }
    }

    /// From the right on `size` columns from k, of the rows `from .. to`.
    pub fn right(&self, a: &mut Dense, (k, size): (usize, usize), from: usize, to: usize) {
        if self.tau == 0.0 {
            return;
        }
        let (tau, [v, w], rows) = (self.tau, self.v, a.rows);
        let (x, rest) = a.a[k * rows..(k + size) * rows].split_at_mut(rows);
        let (y, z) = rest.split_at_mut(rows);
        let (x, y) = (&mut x[from..to], &mut y[from..to]);
        if size == 3 {
            for ((x, y), z) in x.iter_mut().zip(y).zip(&mut z[from..to]) {
                let s = tau * (*x + v * *y + w * *z);
                *x -= s;
                *y -= s * v;
                *z -= s * w;
            }
        } else {
            for (x, y) in x.iter_mut().zip(y) {
                let s = tau * (*x + v * *y);
                *x -= s;
                *y -= s * v;
            }
        }
    }
}
