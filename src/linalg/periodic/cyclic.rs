//! Factors of a product in periodic Hessenberg-triangular or Schur form, with or without the bases that lead there.
//!
//! Section j lies before factor j, section 0 behind the last one as well. An orthogonal matrix at section j acts on
//! factor j from the right and, transposed, on factor j - 1 from the left:
//!
//! ```text
//! T_j = Q_{j+1}^T A_j Q_j,   T_0 .. T_{N-2} upper triangular, T_{N-1} upper Hessenberg.
//! ```

use super::dense::{Dense, Reflector, Small};

/// The factors, each divided by a power of two so that its largest entry lies in [1/2, 1).
#[derive(Clone, Debug)]
pub(super) struct Cyclic {
    pub n: usize,
    pub t: Vec<Dense>,
    /// Exponents of those powers.
    pub exponents: Vec<i32>,
    /// Q_j, where asked for: then the whole of every factor is kept up to date, not only the block in work.
    pub q: Option<Vec<Dense>>,
}

impl Cyclic {
    /// From square factors, brought to Hessenberg-triangular form.
    pub fn new(mut t: Vec<Dense>, bases: bool) -> Self {
        let n = t[0].rows;
        let exponents: Vec<i32> = t.iter().map(|t| exponent(t.largest()).clamp(-1000, 1000)).collect();
        for (t, &e) in t.iter_mut().zip(&exponents) {
            let scale = (-f64::from(e)).exp2();
            t.a.iter_mut().for_each(|x| *x *= scale);
        }
        let q = bases.then(|| vec![Dense::identity(n); t.len()]);
        let mut cyclic = Self { n, t, exponents, q };
        cyclic.reduce();
        cyclic
    }

    /// Index of the Hessenberg factor.
    pub fn last(&self) -> usize {
        self.t.len() - 1
    }

    /// The Hessenberg factor.
    pub fn h(&self) -> &Dense {
        &self.t[self.t.len() - 1]
    }

    pub fn h_mut(&mut self) -> &mut Dense {
        let last = self.last();
        &mut self.t[last]
    }

    /// Column by column, factor by factor (Bojanczyk, Golub and Van Dooren 1992, doi:10.1117/12.130915): `10/3 n³`
    /// operations for each factor.
    fn reduce(&mut self) {
        let (n, last) = (self.n, self.last());
        let mut work = Vec::new();
        for k in 0..n {
            for j in 0..=last {
                let top = if j == last { k + 1 } else { k };
                if top + 1 >= n {
                    continue;
                }
                let (reflector, beta) = Reflector::new(&self.t[j].col(k)[top..]);
                let column = &mut self.t[j].col_mut(k)[top..];
                column.fill(0.0);
                column[0] = beta;
                let section = (j + 1) % self.t.len();
                reflector.left(&mut self.t[j], top, k + 1, n);
                reflector.right(&mut self.t[section], top, n, &mut work);
                if let Some(q) = &mut self.q {
                    reflector.right(&mut q[section], top, n, &mut work);
                }
            }
        }
    }

    /// A reflector at a section, on what follows it and what is known of its basis: columns `k .. k + size` of factor
    /// `section`, down to row `bottom`.
    pub fn turn(&mut self, section: usize, reflector: Small, (k, size): (usize, usize), (lo, bottom): (usize, usize)) {
        let top = if self.q.is_some() { 0 } else { lo };
        reflector.right(&mut self.t[section], (k, size), top, bottom + 1);
        if let Some(q) = &mut self.q {
            reflector.right(&mut q[section], (k, size), 0, self.n);
        }
    }

    /// One past the last column that rows of a block ending at hi are kept up to date in.
    pub fn end(&self, hi: usize) -> usize {
        if self.q.is_some() { self.n } else { hi + 1 }
    }

    /// The factor's first triangular one with a zero on the diagonal between lo and hi.
    pub fn singular(&self, lo: usize, hi: usize) -> bool {
        self.t[..self.last()].iter().any(|t| (lo..=hi).any(|k| t.at(k, k) == 0.0))
    }
}

/// e with `2^(e-1) <= x < 2^e`, 0 for zero.
pub(super) fn exponent(x: f64) -> i32 {
    if x == 0.0 || !x.is_finite() { 0 } else { x.log2().floor() as i32 + 1 }
}
