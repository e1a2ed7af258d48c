//! Band matrices, and their LU factors with partial pivoting for many right-hand sides at once.
//!
//! ```text
//! P A = L U,    L with `lower` entries below the diagonal, U with `lower + upper` above it
//! ```
//!
//! (Golub and Van Loan 2013, Matrix Computations, section 4.3). Rows are stored one after the other, so that the inner
//! loops of elimination and of solves with many right-hand sides run along memory.

use super::Singular;

/// A square band matrix: row i holds columns `i - lower ..= i + upper`.
#[derive(Clone, Debug)]
pub struct Banded {
    n: usize,
    lower: usize,
    upper: usize,
    /// Row by row, `lower + 1 + upper` entries each; those outside the matrix are zero.
    entries: Vec<f64>,
}

impl Banded {
    /// The band is cut to what fits into the matrix.
    pub fn zeros(n: usize, lower: usize, upper: usize) -> Self {
        let (lower, upper) = (lower.min(n.saturating_sub(1)), upper.min(n.saturating_sub(1)));
        Self { n, lower, upper, entries: vec![0.0; n * (lower + 1 + upper)] }
    }

    pub fn n(&self) -> usize {
        self.n
    }

    pub fn lower(&self) -> usize {
        self.lower
    }

    pub fn upper(&self) -> usize {
        self.upper
    }

    fn width(&self) -> usize {
        self.lower + 1 + self.upper
    }

    /// The columns of row i that lie in band and matrix.
    pub fn columns(&self, i: usize) -> std::ops::Range<usize> {
        i.saturating_sub(self.lower)..(i + self.upper + 1).min(self.n)
    }

    /// The rows of column j that lie in band and matrix.
    pub fn rows(&self, j: usize) -> std::ops::Range<usize> {
        j.saturating_sub(self.upper)..(j + self.lower + 1).min(self.n)
    }

    /// Zero outside the band.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        if self.columns(i).contains(&j) { self.entries[i * self.width() + j + self.lower - i] } else { 0.0 }
    }

    /// The entries of row i in [`Self::columns`].
    pub fn row(&self, i: usize) -> &[f64] {
        let (columns, start) = (self.columns(i), i * self.width() + self.lower);
        &self.entries[start + columns.start - i..start + columns.end - i]
    }

    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        let (columns, start) = (self.columns(i), i * self.width() + self.lower);
        &mut self.entries[start + columns.start - i..start + columns.end - i]
    }

    pub fn fill(&mut self, value: f64) {
        let n = self.n;
        (0..n).for_each(|i| self.row_mut(i).fill(value));
    }

    /// `y = A x`.
    pub fn times(&self, x: &[f64], y: &mut [f64]) {
        for (i, y) in y.iter_mut().enumerate() {
            *y = super::dot(self.row(i), &x[self.columns(i)]);
        }
    }
}

/// Columns of right-hand sides that are solved for together.
pub const LANES: usize = 32;

/// `P A = L U` of a band matrix.
#[derive(Clone, Debug)]
pub struct BandedLu {
    n: usize,
    lower: usize,
    /// Entries of U right of the diagonal.
    above: usize,
    /// Row i of U from the diagonal on, `above + 1` entries each.
    upper: Vec<f64>,
    /// The multipliers of step k, `lower` each.
    multipliers: Vec<f64>,
    /// The row that was swapped with row k in step k.
    swaps: Vec<usize>,
}

impl BandedLu {
    /// Factors A; a zero or non-finite pivot is an error.
    pub fn new(a: &Banded) -> Result<Self, Singular> {
        let (n, lower) = (a.n, a.lower);
        let above = (a.lower + a.upper).min(n.saturating_sub(1));
        let width = above + 1;
        // A window of rows k ..= k + lower, each stored from column k on.
        let mut upper = vec![0.0; n * width];
        let mut window = vec![0.0; (lower + 1) * width];
        let mut slot: Vec<usize> = (0..=lower).collect();
        let load = |window: &mut [f64], slot: usize, i: usize, first: usize| {
            let target = &mut window[slot * width..(slot + 1) * width];
            target.fill(0.0);
            let columns = a.columns(i);
            target[columns.start - first..columns.end - first].copy_from_slice(a.row(i));
        };
        for (r, &slot) in slot.iter().enumerate().take(n.min(lower + 1)) {
            load(&mut window, slot, r, 0);
        }
        let (mut multipliers, mut swaps) = (vec![0.0; n * lower], vec![0; n]);
        for k in 0..n {
            let active = (lower + 1).min(n - k);
            let size = |r: usize| window[slot[r] * width].abs();
            let pivot = (1..active).fold(0, |best, r| if size(r) > size(best) { r } else { best });
            swaps[k] = k + pivot;
            slot.swap(0, pivot);
            let top = slot[0] * width;
            let divisor = window[top];
            if divisor == 0.0 || !divisor.is_finite() {
                return Err(Singular);
            }
            let row = &mut upper[k * width..(k + 1) * width];
            row.copy_from_slice(&window[top..top + width]);
            for r in 1..active {
                let target = &mut window[slot[r] * width..(slot[r] + 1) * width];
                let factor = target[0] / divisor;
                multipliers[k * lower + r - 1] = factor;
                // One column further: every row moves left by one.
                if factor == 0.0 {
                    target.copy_within(1.., 0);
                } else {
                    for c in 1..width {
                        target[c - 1] = target[c] - factor * row[c];
                    }
                }
                target[width - 1] = 0.0;
            }
            slot.rotate_left(1);
            let next = k + lower + 1;
            if next < n {
                load(&mut window, slot[lower], next, k + 1);
            }
        }
        Ok(Self { n, lower, above, upper, multipliers, swaps })
    }

    /// `A^-1 b` in place.
    pub fn solve(&self, b: &mut [f64]) {
        for k in 0..self.n {
            b.swap(k, self.swaps[k]);
            let value = b[k];
            let multipliers = &self.multipliers[k * self.lower..(k + 1) * self.lower];
            b[k + 1..].iter_mut().zip(multipliers).for_each(|(b, l)| *b -= l * value);
        }
        let width = self.above + 1;
        for k in (0..self.n).rev() {
            let u = &self.upper[k * width..(k + 1) * width];
            let known = &b[k + 1..(k + width).min(self.n)];
            b[k] = (b[k] - super::dot(&u[1..known.len() + 1], known)) / u[0];
        }
    }

    /// `A^-1 B` in place; B has n rows.
    pub fn solve_strip(&self, b: &mut [[f64; LANES]]) {
        pulp::Arch::new().dispatch(Substitution { lu: self, b });
    }

    #[inline(always)]
    fn substitute(&self, b: &mut [[f64; LANES]]) {
        // Rows before the first that is not zero stay so, but for exchanges with later ones.
        let zeros = b.iter().take_while(|row| row.iter().all(|&x| x == 0.0)).count();
        for k in zeros.saturating_sub(self.lower)..self.n {
            b.swap(k, self.swaps[k]);
            let (head, tail) = b.split_at_mut(k + 1);
            let row = head[k];
            let multipliers = &self.multipliers[k * self.lower..(k + 1) * self.lower];
            for (factor, target) in multipliers.iter().zip(tail) {
                target.iter_mut().zip(&row).for_each(|(t, r)| *t = (-factor).mul_add(*r, *t));
            }
        }
        let width = self.above + 1;
        for k in (0..self.n).rev() {
            let (head, tail) = b.split_at_mut(k + 1);
            let u = &self.upper[k * width..(k + 1) * width];
            let inverse = 1.0 / u[0];
            // The row stays in registers while those below pass by.
            let mut sum = head[k];
            for (u, row) in u[1..].iter().zip(&*tail) {
                sum.iter_mut().zip(row).for_each(|(s, r)| *s = (-u).mul_add(*r, *s));
            }
            head[k] = sum.map(|s| s * inverse);
        }
    }

    /// Sign of the determinant.
    pub fn sign(&self) -> f64 {
        let swapped = |k: usize| if self.swaps[k] == k { 1.0 } else { -1.0 };
        (0..self.n).map(|k| swapped(k) * self.upper[k * (self.above + 1)].signum()).product()
    }

    /// `A^-T b` in place.
    pub fn solve_transposed(&self, b: &mut [f64]) {
        let width = self.above + 1;
        for k in 0..self.n {
            let u = &self.upper[k * width..(k + 1) * width];
            let (head, tail) = b.split_at_mut(k + 1);
            head[k] /= u[0];
            let value = head[k];
            tail.iter_mut().zip(&u[1..]).for_each(|(b, u)| *b -= u * value);
        }
        for k in (0..self.n).rev() {
            let multipliers = &self.multipliers[k * self.lower..(k + 1) * self.lower];
            let below = &b[k + 1..(k + 1 + self.lower).min(self.n)];
            b[k] -= super::dot(&multipliers[..below.len()], below);
            b.swap(k, self.swaps[k]);
        }
    }
}

/// A call of [`BandedLu::substitute`], compiled for each kind of vector unit and chosen when the program runs.
struct Substitution<'a> {
    lu: &'a BandedLu,
    b: &'a mut [[f64; LANES]],
}

impl pulp::NullaryFnOnce for Substitution<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.lu.substitute(self.b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Lu;
    use faer::Mat;
    use proptest::prelude::*;

    fn example(n: usize, lower: usize, upper: usize, seed: u64) -> Banded {
        let mut a = Banded::zeros(n, lower, upper);
        let mut state = seed.wrapping_mul(2).wrapping_add(1);
        for i in 0..n {
            for x in a.row_mut(i) {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                *x = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            }
        }
        a
    }

    proptest! {
        #[test]
        fn solves_as_dense_factors_do(n in 1..24_usize, lower in 0..6_usize, upper in 0..6_usize, seed: u64) {
            let a = example(n, lower, upper, seed);
            let dense = Mat::from_fn(n, n, |i, j| a.get(i, j));
            let (Ok(banded), Ok(lu)) = (BandedLu::new(&a), Lu::new(dense)) else { return Ok(()) };
            // Backward error of the solution, for random matrices may be close to singular.
            let b: Vec<f64> = (0..2 * n).map(|i| (i as f64).sin()).collect();
            let mut strip: Vec<[f64; LANES]> = b.chunks(2).map(|row| std::array::from_fn(|c| row[c % 2])).collect();
            banded.solve_strip(&mut strip);
            let x: Vec<f64> = strip.iter().flat_map(|row| [row[LANES - 2], row[LANES - 1]]).collect();
            // A right-hand side that begins with zeros.
            let mut late = vec![[0.0; LANES]; n];
            late[n - 1][0] = 1.0;
            banded.solve_strip(&mut late);
            let (mut unit, column): (Vec<f64>, Vec<f64>) = (vec![0.0; n], late.iter().map(|row| row[0]).collect());
            a.times(&column, &mut unit);
            let size = column.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for (i, x) in unit.iter().enumerate() {
                prop_assert!((x - f64::from(u8::from(i + 1 == n))).abs() < 1e-12 * size);
            }
            let mut single: Vec<f64> = b.iter().step_by(2).copied().collect();
            banded.solve(&mut single);
            let size = x.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
            for (i, y) in single.iter().enumerate() {
                prop_assert!((x[2 * i] - y).abs() < 1e-12 * size * size);
            }
            for c in 0..2 {
                let (column, mut image): (Vec<f64>, _) = ((0..n).map(|i| x[2 * i + c]).collect(), vec![0.0; n]);
                a.times(&column, &mut image);
                for i in 0..n {
                    prop_assert!((image[i] - b[2 * i + c]).abs() < 1e-12 * size);
                }
            }
            let (mut y, mut z) = (b[..n].to_vec(), b[..n].to_vec());
            banded.solve_transposed(&mut y);
            lu.solve_adjoint(&mut z);
            let size = z.iter().fold(1.0_f64, |m, z| m.max(z.abs()));
            for (i, b) in b[..n].iter().enumerate() {
                let image: f64 = (0..n).map(|k| a.get(k, i) * y[k]).sum();
                prop_assert!((image - b).abs() < 1e-12 * size.max(y.iter().fold(1.0, |m: f64, y| m.max(y.abs()))));
            }
        }
    }

    #[test]
    fn a_singular_band_is_an_error() {
        assert!(BandedLu::new(&Banded::zeros(4, 1, 1)).is_err());
    }
}
