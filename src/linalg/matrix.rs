//! A square matrix in the form that its problem's structure allows.

use super::{Banded, Pattern, Sparse, c64, dot};
use faer::Mat;
use std::sync::Arc;

/// What is known of a Jacobian's pattern.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub enum Structure {
    #[default]
    Dense,
    /// Entry (i, j) is zero unless `i - lower <= j <= i + upper`.
    Banded {
        lower: usize,
        upper: usize,
    },
    Sparse(Arc<Pattern>),
}

/// A square matrix of that structure.
#[derive(Clone, Debug)]
pub enum Matrix {
    Dense(Mat<f64>),
    Banded(Banded),
    Sparse(Sparse),
}

impl Matrix {
    pub fn zeros(structure: Structure, n: usize) -> Self {
        match structure {
            Structure::Dense => Matrix::Dense(Mat::zeros(n, n)),
            Structure::Banded { lower, upper } => Matrix::Banded(Banded::zeros(n, lower, upper)),
            Structure::Sparse(pattern) => Matrix::Sparse(Sparse::zeros(pattern)),
        }
    }

    pub fn n(&self) -> usize {
        match self {
            Matrix::Dense(a) => a.nrows(),
            Matrix::Banded(a) => a.n(),
            Matrix::Sparse(a) => a.pattern.n(),
        }
    }

    /// All entries.
    pub fn into_dense(self) -> Mat<f64> {
        match self {
            Matrix::Dense(a) => a,
            Matrix::Banded(a) => Mat::from_fn(a.n(), a.n(), |i, j| a.get(i, j)),
            Matrix::Sparse(_) => {
                let mut dense = Mat::zeros(self.n(), self.n());
                self.entries().into_iter().for_each(|(i, j, x)| dense[(i, j)] = x);
                dense
            }
        }
    }

    /// Row, column and value of each entry of the structure.
    pub fn entries(&self) -> Vec<(usize, usize, f64)> {
        match self {
            Matrix::Dense(a) => (0..a.ncols()).flat_map(|j| (0..a.nrows()).map(move |i| (i, j, a[(i, j)]))).collect(),
            Matrix::Banded(a) => {
                (0..a.n()).flat_map(|i| a.columns(i).zip(a.row(i)).map(move |(j, &x)| (i, j, x))).collect()
            }
            Matrix::Sparse(a) => (0..self.n())
                .flat_map(|j| {
                    let (range, rows) = a.pattern.column(j);
                    rows.iter().zip(&a.values[range]).map(move |(&i, &x)| (i, j, x))
                })
                .collect(),
        }
    }

    /// The largest entry's size.
    pub fn norm_max(&self) -> f64 {
        let largest = |values: &mut dyn Iterator<Item = &f64>| values.fold(0.0_f64, |most, x| most.max(x.abs()));
        match self {
            Matrix::Dense(a) => a.norm_max(),
            Matrix::Banded(a) => largest(&mut (0..a.n()).flat_map(|i| a.row(i))),
            Matrix::Sparse(a) => largest(&mut a.values.iter()),
        }
    }

    /// `A + s I`.
    pub fn add_to_diagonal(&mut self, s: f64) {
        for i in 0..self.n() {
            match self {
                Matrix::Dense(a) => a[(i, i)] += s,
                Matrix::Banded(a) => {
                    let first = a.columns(i).start;
                    a.row_mut(i)[i - first] += s;
                }
                Matrix::Sparse(a) => {
                    let (range, rows) = a.pattern.column(i);
                    if let Ok(k) = rows.binary_search(&i) {
                        a.values[range.start + k] += s;
                    }
                }
            }
        }
    }

    /// `A + s M`, both of one structure.
    pub fn plus(&self, s: f64, m: &Matrix) -> Matrix {
        let mut sum = self.clone();
        match (&mut sum, m) {
            (Matrix::Banded(a), Matrix::Banded(m)) => (0..a.n()).for_each(|i| {
                a.row_mut(i).iter_mut().zip(m.row(i)).for_each(|(a, m)| *a += s * m);
            }),
            (Matrix::Sparse(a), Matrix::Sparse(m)) => {
                a.values.iter_mut().zip(&m.values).for_each(|(a, m)| *a += s * m);
            }
            (Matrix::Dense(a), _) => m.entries().into_iter().for_each(|(i, j, x)| a[(i, j)] += s * x),
            (_, m) => return Matrix::Dense(sum.into_dense()).plus(s, m),
        }
        sum
    }

    /// This matrix with the columns of another one of the same structure at some places.
    pub fn with_columns(&self, other: &Matrix, columns: &[usize]) -> Matrix {
        let mut mixed = self.clone();
        match (&mut mixed, other) {
            (Matrix::Dense(a), Matrix::Dense(b)) => columns.iter().for_each(|&j| a.col_mut(j).copy_from(b.col(j))),
            (Matrix::Banded(a), Matrix::Banded(b)) => {
                for &j in columns {
                    for i in b.rows(j) {
                        let first = a.columns(i).start;
                        a.row_mut(i)[j - first] = b.get(i, j);
                    }
                }
            }
            (Matrix::Sparse(a), Matrix::Sparse(b)) => {
                for &j in columns {
                    let range = b.pattern.column(j).0;
                    a.values[range.clone()].copy_from_slice(&b.values[range]);
                }
            }
            (_, other) => {
                let dense = |a: &Matrix| Matrix::Dense(a.clone().into_dense());
                return dense(self).with_columns(&dense(other), columns);
            }
        }
        mixed
    }

    /// Some columns, into the first ones of a dense matrix of zeros.
    pub fn copy_columns(&self, columns: &[usize], out: &mut Mat<f64>) {
        for (k, &j) in columns.iter().enumerate() {
            let out = out.col_as_slice_mut(k);
            match self {
                Matrix::Dense(a) => out.copy_from_slice(a.col_as_slice(j)),
                Matrix::Banded(a) => a.rows(j).for_each(|i| out[i] = a.get(i, j)),
                Matrix::Sparse(a) => {
                    let (range, rows) = a.pattern.column(j);
                    rows.iter().zip(&a.values[range]).for_each(|(&i, &x)| out[i] = x);
                }
            }
        }
    }

    /// `y = A x`.
    pub fn times(&self, x: &[f64], y: &mut [f64]) {
        match self {
            Matrix::Dense(a) => {
                y.fill(0.0);
                for (j, &x) in x.iter().enumerate() {
                    y.iter_mut().zip(a.col_as_slice(j)).for_each(|(y, a)| *y += a * x);
                }
            }
            Matrix::Banded(a) => a.times(x, y),
            Matrix::Sparse(a) => {
                y.fill(0.0);
                a.add_times(x, y);
            }
        }
    }

    /// `y = A^T x`.
    pub fn times_transposed(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        match self {
            Matrix::Dense(a) => y.iter_mut().enumerate().for_each(|(j, y)| *y = dot(a.col_as_slice(j), x)),
            Matrix::Banded(a) => {
                for (i, &x) in x.iter().enumerate() {
                    y[a.columns(i)].iter_mut().zip(a.row(i)).for_each(|(y, a)| *y += a * x);
                }
            }
            Matrix::Sparse(a) => a.add_transposed_times(x, y),
        }
    }

    /// `A x` for complex x.
    pub fn times_complex(&self, x: &[c64]) -> Vec<c64> {
        let part = |f: fn(&c64) -> f64| {
            let (part, mut image): (Vec<f64>, _) = (x.iter().map(f).collect(), vec![0.0; x.len()]);
            self.times(&part, &mut image);
            image
        };
        part(|z| z.re).into_iter().zip(part(|z| z.im)).map(|(re, im)| c64::new(re, im)).collect()
    }
}
