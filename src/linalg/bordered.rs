//! Bordered systems with matrices of any structure:
//!
//! ```text
//! [ A    B ] [x]   [f]
//! [ C^H  D ] [y] = [g]        A n by n, B and C n by m, D m by m.
//! ```
//!
//! Dense ones are factored as a whole; banded and sparse ones by block elimination, with a step of iterative refinement
//! that makes up for a singular A.

use super::elimination::Elimination;
use super::factors::{Base, Factors, PencilFactors};
use super::{Bordered, Equilibrated, Matrix, Singular, c64, dot};
use faer::Mat;

/// A factored real bordered matrix; it may be regular where A itself is singular.
pub struct BorderedMatrix {
    form: Form,
}

enum Form {
    Whole(Equilibrated),
    Blocks(Box<Blocks>),
}

struct Blocks {
    a: Matrix,
    factors: Factors,
    borders: Elimination<f64>,
    b: Vec<Vec<f64>>,
    c: Vec<Vec<f64>>,
    d: Vec<Vec<f64>>,
}

impl BorderedMatrix {
    /// `b` and `c` are the columns of B and C, `d` the rows of D.
    pub fn new(a: &Matrix, b: &[&[f64]], c: &[&[f64]], d: &[&[f64]]) -> Result<Self, Singular> {
        let Matrix::Dense(a) = a else {
            return Blocks::new(a, b, c, d).map(|x| Self { form: Form::Blocks(Box::new(x)) });
        };
        let n = a.nrows();
        let full = Mat::from_fn(n + b.len(), n + c.len(), |i, j| match (i < n, j < n) {
            (true, true) => a[(i, j)],
            (true, false) => b[j - n][i],
            (false, true) => c[i - n][j],
            (false, false) => d[i - n][j - n],
        });
        Ok(Self { form: Form::Whole(Equilibrated::new(full)?) })
    }

    /// `[f; g]` in, `[x; y]` out.
    pub fn solve(&self, fg: &mut [f64]) {
        match &self.form {
            Form::Whole(lu) => lu.solve(fg),
            Form::Blocks(blocks) => blocks.solve(fg, false),
        }
    }

    /// The same with the transpose.
    pub fn solve_transposed(&self, fg: &mut [f64]) {
        match &self.form {
            Form::Whole(lu) => lu.solve_transposed(fg),
            Form::Blocks(blocks) => blocks.solve(fg, true),
        }
    }

    /// Sign of the determinant, if it is known.
    pub fn sign(&self) -> Option<f64> {
        match &self.form {
            Form::Whole(lu) => Some(lu.sign()),
            Form::Blocks(blocks) => {
                let sign = blocks.factors.sign()?;
                Some(blocks.borders.deltas().fold(sign, |sign, delta| sign * delta.signum()))
            }
        }
    }
}

/// A matrix that is singular to the last bit is moved by this part of its size: refinement makes up for it.
const MOVED: f64 = 1e-13;

impl Blocks {
    fn new(a: &Matrix, b: &[&[f64]], c: &[&[f64]], d: &[&[f64]]) -> Result<Self, Singular> {
        let make = |matrix: &Matrix| {
            let factors = Factors::new(matrix)?;
            let borders = Elimination::new(&factors, b, c, d)?;
            Ok((factors, borders))
        };
        let made = make(a).or_else(|Singular| {
            let mut moved = a.clone();
            moved.add_to_diagonal(MOVED * a.norm_max());
            make(&moved)
        });
        let (factors, borders) = made?;
        let own = |list: &[&[f64]]| list.iter().map(|x| x.to_vec()).collect();
        Ok(Self { a: a.clone(), factors, borders, b: own(b), c: own(c), d: own(d) })
    }

    fn solve(&self, fg: &mut [f64], transposed: bool) {
        let base: &dyn Base<f64> = &self.factors;
        let apply = |x: &mut [f64]| {
            if transposed { self.borders.solve_adjoint(base, x) } else { self.borders.solve(base, x) }
        };
        let mut x = fg.to_vec();
        apply(&mut x);
        let mut left = self.residual(fg, &x, transposed);
        apply(&mut left);
        fg.iter_mut().zip(x.iter().zip(&left)).for_each(|(out, (x, d))| *out = x + d);
    }

    /// `fg - M x`, or with the transpose.
    fn residual(&self, fg: &[f64], x: &[f64], transposed: bool) -> Vec<f64> {
        let n = self.a.n();
        let (columns, rows) = if transposed { (&self.c, &self.b) } else { (&self.b, &self.c) };
        let mut image = vec![0.0; n];
        if transposed {
            self.a.times_transposed(&x[..n], &mut image)
        } else {
            self.a.times(&x[..n], &mut image)
        }
        let mut out = fg.to_vec();
        for i in 0..n {
            out[i] -= image[i] + columns.iter().zip(&x[n..]).map(|(column, y)| column[i] * y).sum::<f64>();
        }
        for k in 0..rows.len() {
            let corner = |j: usize| if transposed { self.d[j][k] } else { self.d[k][j] };
            out[n + k] -= dot(&rows[k], &x[..n]) + (0..rows.len()).map(|j| corner(j) * x[n + j]).sum::<f64>();
        }
        out
    }
}

/// The factored matrix `[A + s M, b; c^H, 0]`, s complex.
pub struct BorderedPencil {
    form: PencilForm,
}

enum PencilForm {
    Whole(Bordered<c64>),
    Blocks(Box<(PencilFactors, Elimination<c64>)>),
}

impl BorderedPencil {
    pub fn new((a, m): (&Matrix, &Matrix), s: c64, b: &[c64], c: &[c64]) -> Result<Self, Singular> {
        let zero = c64::new(0.0, 0.0);
        if let (Matrix::Dense(a), Matrix::Dense(m)) = (a, m) {
            let shifted = Mat::from_fn(a.nrows(), a.ncols(), |i, j| s * m[(i, j)] + a[(i, j)]);
            return Ok(Self { form: PencilForm::Whole(Bordered::new(shifted.as_ref(), b, c, zero)?) });
        }
        let make = |s: c64| {
            let factors = PencilFactors::new(a, m, s)?;
            let borders = Elimination::new(&factors, &[b], &[c], &[&[zero]])?;
            Ok(Self { form: PencilForm::Blocks(Box::new((factors, borders))) })
        };
        // At an eigenvalue to the last bit a pivot may vanish: half a digit beside it none does.
        make(s).or_else(|Singular| make(s + 10.0 * f64::EPSILON * s.norm()))
    }

    /// `[f; g]` in, `[x; y]` out.
    pub fn solve(&self, fg: &mut [c64]) {
        match &self.form {
            PencilForm::Whole(bordered) => bordered.solve(fg),
            PencilForm::Blocks(made) => made.1.solve(&made.0, fg),
        }
    }

    /// The same with the adjoint.
    pub fn solve_adjoint(&self, fg: &mut [c64]) {
        match &self.form {
            PencilForm::Whole(bordered) => bordered.solve_adjoint(fg),
            PencilForm::Blocks(made) => made.1.solve_adjoint(&made.0, fg),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{Banded, Pattern, Sparse};
    use proptest::prelude::*;
    use std::sync::Arc;

    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(2).wrapping_add(1);
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    /// A band matrix as such, as a sparse and as a dense one; with a row that is zero up to `defect`.
    fn forms(n: usize, seed: u64, defect: Option<f64>) -> [Matrix; 3] {
        let mut next = numbers(seed);
        let mut banded = Banded::zeros(n, 2, 1);
        for i in 0..n {
            banded.row_mut(i).iter_mut().for_each(|x| *x = next());
        }
        if let Some(defect) = defect {
            banded.row_mut(n / 2).iter_mut().for_each(|x| *x *= defect);
        }
        let banded = Matrix::Banded(banded);
        let entries = banded.entries();
        let mut sparse = Sparse::zeros(Arc::new(Pattern::new(n, entries.iter().map(|(i, j, _)| (*i, *j)))));
        for (i, j, x) in entries {
            let (range, rows) = sparse.pattern.column(j);
            sparse.values[range.start + rows.binary_search(&i).unwrap()] = x;
        }
        let dense = Matrix::Dense(banded.clone().into_dense());
        [banded, Matrix::Sparse(sparse), dense]
    }

    proptest! {
        /// Block elimination solves as the whole matrix does, be A regular, singular or nearly so.
        #[test]
        fn all_structures_agree(n in 3..30_usize, width in 1..4_usize, seed: u64, singular in 0..4_usize) {
            let defect = [None, Some(0.0), Some(1e-16), Some(1e-9)][singular];
            let [banded, sparse, dense] = forms(n, seed, defect);
            let mut next = numbers(seed ^ 77);
            let mut columns = |rows: usize| -> Vec<Vec<f64>> { (0..width).map(|_| (0..rows).map(|_| next()).collect()).collect() };
            let (b, c, d) = (columns(n), columns(n), columns(width));
            fn refs(x: &[Vec<f64>]) -> Vec<&[f64]> { x.iter().map(|x| &x[..]).collect() }
            let make = |a: &Matrix| BorderedMatrix::new(a, &refs(&b), &refs(&c), &refs(&d));
            let right: Vec<f64> = (0..n + width).map(|i| (i as f64).sin()).collect();
            let Ok(whole) = make(&dense) else { return Ok(()) };
            let (mut x, mut y) = (right.clone(), right.clone());
            whole.solve(&mut x);
            whole.solve_transposed(&mut y);
            let size = |x: &[f64]| x.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            // Only well-conditioned systems have solutions that can be compared.
            prop_assume!(size(&x) < 1e4 && size(&y) < 1e4);
            for a in [&banded, &sparse] {
                let parts = make(a).unwrap();
                let (mut p, mut q) = (right.clone(), right.clone());
                parts.solve(&mut p);
                parts.solve_transposed(&mut q);
                for i in 0..n + width {
                    prop_assert!((p[i] - x[i]).abs() <= 1e-8 * size(&x), "{p:?} {x:?}");
                    prop_assert!((q[i] - y[i]).abs() <= 1e-8 * size(&y), "{q:?} {y:?}");
                }
                if defect != Some(0.0) {
                    prop_assert_eq!(parts.sign(), whole.sign());
                }
            }
        }
    }
}
