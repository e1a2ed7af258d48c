//! LU factors of a matrix whose rows and columns are first brought to one size.
//!
//! Partial pivoting compares the entries of a column, and so depends on the units of the rows: a border of size one beside
//! equations of size 1e-18 is always the pivot, and leaves no digits of them. With `S = R A C`, R and C diagonal, that give every
//! row and every column a largest entry of about one (Ruiz 2001, RAL-TR-2001-034: all are divided by the root of it, some
//! times), nothing depends on units; they are powers of two, so that scaling makes no error.

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
        let (mut rows, mut columns) = (vec![1.0; n], vec![1.0; n]);
        for _ in 0..SWEEPS {
            let (mut across, mut down) = (vec![0.0_f64; n], vec![0.0_f64; n]);
            for j in 0..n {
                for i in 0..n {
                    let size = (rows[i] * (a[(i, j)] * columns[j])).abs();
                    across[i] = across[i].max(size);
                    down[j] = down[j].max(size);
                }
            }
            rows.iter_mut().zip(across).for_each(|(scale, largest)| *scale *= inverse_root(largest));
            columns.iter_mut().zip(down).for_each(|(scale, largest)| *scale *= inverse_root(largest));
        }
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
