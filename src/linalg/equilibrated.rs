//! LU factors of a matrix whose rows and columns are first brought to one size.
//!
//! Partial pivoting compares the entries of a column, and so depends on the units of the rows: a border of size one beside
//! equations of size 1e-18 is always the pivot, and leaves no digits of them. With `S = R A C`, R and C diagonal, that give every
//! row and every column a largest entry of about one (Ruiz 2001, RAL-TR-2001-034: all are divided by the root of it, some
//! times), nothing depends on units; they are powers of two, so that scaling makes no error.

use super::{Lu, Singular};
use faer::Mat;

/// `A = R^-1 S C^-1` with S factored.
pub struct Equilibrated {
    lu: Lu<f64>,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl Equilibrated {
    pub fn new(mut a: Mat<f64>) -> Result<Self, Singular> {
        let n = a.nrows();
        let (mut rows, mut columns) = (vec![1.0; n], vec![1.0; n]);
        for _ in 0..SWEEPS {
            let (mut by_row, mut by_column) = (vec![0.0_f64; n], vec![0.0_f64; n]);
            for (j, down) in by_column.iter_mut().enumerate() {
                let column = a.col_as_slice(j);
                by_row.iter_mut().zip(column).for_each(|(across, x)| *across = across.max(x.abs()));
                *down = largest(column);
            }
            by_row.iter_mut().chain(&mut by_column).for_each(|x| *x = inverse_root(*x));
            if by_row.iter().chain(&by_column).all(|&x| x == 1.0) {
                break;
            }
            for (j, scale) in by_column.iter().enumerate() {
                a.col_as_slice_mut(j).iter_mut().zip(&by_row).for_each(|(x, row)| *x = row * (*x * scale));
            }
            times(&mut rows, &by_row);
            times(&mut columns, &by_column);
        }
        Ok(Self { lu: Lu::new(a)?, rows, columns })
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

/// The largest size, of eight side by side.
fn largest(column: &[f64]) -> f64 {
    let mut most = [0.0_f64; 8];
    let chunks = column.chunks_exact(most.len());
    let rest = chunks.remainder().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    chunks.for_each(|chunk| most.iter_mut().zip(chunk).for_each(|(most, x)| *most = most.max(x.abs())));
    most.into_iter().fold(rest, f64::max)
}

/// Each brings sizes half way to one, in decades: 1e32 to 10.
const SWEEPS: usize = 5;

/// The power of two next to `1/sqrt(x)`; one where x is zero.
fn inverse_root(x: f64) -> f64 {
    let power = (-0.5 * x.log2()).round().exp2();
    if x > 0.0 && power.is_finite() && power > 0.0 { power } else { 1.0 }
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
        let lu = Equilibrated::new(scaled).unwrap();
        assert_eq!(lu.sign(), a.determinant().signum());
        let x = [1.0, -2.0, 3.0];
        let mut b: Vec<f64> = (0..3).map(|i| rows[i] * (0..3).map(|j| a[(i, j)] * x[j]).sum::<f64>()).collect();
        let mut bt: Vec<f64> = (0..3).map(|j| columns[j] * (0..3).map(|i| a[(i, j)] * x[i]).sum::<f64>()).collect();
        lu.solve(&mut b);
        lu.solve_transposed(&mut bt);
        for i in 0..3 {
            assert!((b[i] * columns[i] - x[i]).abs() < 1e-13 && (bt[i] * rows[i] - x[i]).abs() < 1e-13);
        }
        assert!(Equilibrated::new(Mat::zeros(2, 2)).is_err());
    }
}
