//! LU factors of a matrix whose rows and columns are first brought to one size.
//!
//! Partial pivoting compares the entries of a column, and so depends on the units of the rows: a border of size one beside
//! equations of size 1e-18 is always the pivot, and leaves no digits of them. With `S = R A C`, R and C powers of two that give
//! every column and then every row a largest entry of about one (van der Sluis 1969, doi:10.1007/BF02165096), nothing depends
//! on units, and scaling itself makes no error.

use super::{Lu, Singular};
use faer::{Mat, MatRef};

/// `A = R^-1 S C^-1` with S factored.
pub struct Equilibrated {
    lu: Lu<f64>,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl Equilibrated {
    pub fn new(a: MatRef<'_, f64>) -> Result<Self, Singular> {
        let n = a.nrows();
        let columns: Vec<f64> = (0..n).map(|j| scale((0..n).map(|i| a[(i, j)]))).collect();
        let rows: Vec<f64> = (0..n).map(|i| scale((0..n).map(|j| a[(i, j)] * columns[j]))).collect();
        let scaled = Mat::from_fn(n, n, |i, j| rows[i] * (a[(i, j)] * columns[j]));
        Ok(Self { lu: Lu::new(scaled.as_ref())?, rows, columns })
    }

    /// `A^-1 b` in place.
    pub fn solve(&self, b: &mut [f64]) {
        times(b, &self.rows);
        self.lu.solve(b);
        times(b, &self.columns);
    }

    /// `A^-T b` in place.
    pub fn solve_transposed(&self, b: &mut [f64]) {
        times(b, &self.columns);
        self.lu.solve_adjoint(b);
        times(b, &self.rows);
    }

    /// Sign of the determinant.
    pub fn sign(&self) -> f64 {
        self.lu.sign()
    }
}

fn times(b: &mut [f64], scales: &[f64]) {
    b.iter_mut().zip(scales).for_each(|(b, s)| *b *= s);
}

/// The power of two that brings the largest of some numbers to about one; one where all are zero.
fn scale(numbers: impl Iterator<Item = f64>) -> f64 {
    let largest = numbers.fold(0.0_f64, |most, x| most.max(x.abs()));
    let power = (-largest.log2()).round().exp2();
    if largest > 0.0 && power.is_finite() && power > 0.0 { power } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bordered system in units that differ by 1e18 between its parts is solved to rounding in each unknown.
    #[test]
    fn units_do_not_matter() {
        let a = faer::mat![[2.0, -1.0, 0.5], [1.0, 3.0, -1.0], [0.25, 1.0, 0.5]];
        let (rows, columns) = ([1e-18, 1e-9, 1e9], [1e9, 1e-9, 1.0]);
        let scaled = Mat::from_fn(3, 3, |i, j| rows[i] * a[(i, j)] * columns[j]);
        let lu = Equilibrated::new(scaled.as_ref()).unwrap();
        assert_eq!(lu.sign(), a.determinant().signum());
        let x = [1.0, -2.0, 3.0];
        let mut b: Vec<f64> = (0..3).map(|i| rows[i] * (0..3).map(|j| a[(i, j)] * x[j]).sum::<f64>()).collect();
        let mut bt: Vec<f64> = (0..3).map(|j| columns[j] * (0..3).map(|i| a[(i, j)] * x[i]).sum::<f64>()).collect();
        lu.solve(&mut b);
        lu.solve_transposed(&mut bt);
        for i in 0..3 {
            assert!((b[i] * columns[i] - x[i]).abs() < 1e-13 && (bt[i] * rows[i] - x[i]).abs() < 1e-13);
        }
        assert!(Equilibrated::new(Mat::<f64>::zeros(2, 2).as_ref()).is_err());
    }
}
