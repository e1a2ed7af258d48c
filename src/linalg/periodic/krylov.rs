//! The leading eigenvalues alone, by the periodic Krylov-Schur method (Kressner 2006,
//! doi:10.1007/s00211-006-0682-1).
//!
//! Orthonormal bases V_j at every section, each grown by one vector as the start is carried once round:
//!
//! ```text
//! A_j V_j = V_{j+1} T_j,   T_j upper triangular for j < N - 1,
//! A_{N-1} V_{N-1} = V_0 H + v b^T,   v the next vector of section 0.
//! ```
//!
//! The periodic Schur form of (T_0 .. T_{N-2}, H), large eigenvalues first, shows what has converged, `|b_i|` being the
//! change of the last factor that would make the leading columns exact; its leading columns are what a restart keeps.
//! When all that is wanted has converged, a vector from elsewhere is carried round as well: what one start cannot see
//! (several eigenvectors of one eigenvalue) shows then.

use super::dense::{Dense, axpy};
use super::ritz::Ritz;
use super::{Eigenvalue, PeriodicError, Product, all, subspace};
use crate::linalg::dot;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// Up to this dimension all eigenvalues cost no more than a few.
const SMALL: usize = 40;
/// Rounds that a vector from elsewhere gets.
const ROUNDS: usize = 3;
const RESTARTS: usize = 60;
/// What orthogonalisation leaves of a vector that depends on the basis, in parts of its length.
pub(super) const DEPENDENT: f64 = 10.0 * f64::EPSILON;

/// The k eigenvalues of largest modulus, largest first, and one more where the k-th belongs to a pair. Where a few
/// would cost as much as all, or do not converge, all are computed.
pub fn leading(product: &dyn Product, k: usize) -> Result<Vec<Eigenvalue>, PeriodicError> {
    let most = 2 * k + 8;
    let few = k > 0 && product.dim() > SMALL && 3 * most < product.dim();
    let mut found = None;
    if few {
        found = carried(product, k, most);
        if found.is_none() {
            found = Krylov::new(product, k, most).run()?.map(|ritz| ritz.values);
        }
    }
    let mut values = match found {
        Some(values) => values,
        None => all(product)?,
    };
    let cut = k > 0 && values.get(k - 1).is_some_and(|value| value.direction.im > 0.0);
    values.truncate(k + usize::from(cut));
    Ok(values)
}

/// Where the product has been multiplied out, its own leading subspace is nearly that of the factors.
fn carried(product: &dyn Product, k: usize, most: usize) -> Option<Vec<Eigenvalue>> {
    let formed = vec![product.formed()?];
    let mut krylov = Krylov::new(&formed, k, most);
    let ritz = krylov.run().ok()??;
    krylov.restart(&ritz, ritz.needed);
    subspace::carried(product, krylov.v.swap_remove(0).truncated(product.dim(), ritz.needed), k)
}

struct Krylov<'a> {
    product: &'a dyn Product,
    n: usize,
    /// Index of the last factor.
    last: usize,
    wanted: usize,
    /// Most columns of a basis.
    most: usize,
    /// Columns in use; section 0 has one more.
    size: usize,
    v: Vec<Dense>,
    /// Projected factors, the last with a row more.
    t: Vec<Dense>,
    random: u64,
}

impl<'a> Krylov<'a> {
    fn new(product: &'a dyn Product, wanted: usize, most: usize) -> Self {
        let (n, count) = (product.dim(), product.factors());
        let v = vec![Dense::zeros(n, most + 1); count];
        let t = vec![Dense::zeros(most + 1, most); count];
        let mut krylov = Self { product, n, last: count - 1, wanted, most, size: 0, v, t, random: 1 };
        krylov.invent(0, 0);
        krylov
    }

    /// None where too many restarts would be needed.
    fn run(&mut self) -> Result<Option<Ritz>, PeriodicError> {
        let stride = (self.wanted / 2).max(4);
        let mut goal = self.wanted + 4;
        let mut confirmed = false;
        for _ in 0..RESTARTS {
            while self.size < goal {
                self.grow()?;
            }
            let Some(ritz) = self.ritz() else { return Ok(None) };
            if ritz.converged && confirmed {
                return Ok(Some(ritz));
            }
            confirmed = ritz.converged;
            if ritz.converged {
                let keep = ritz.needed;
                self.restart(&ritz, keep);
                self.t[self.last].a[keep..].iter_mut().step_by(self.most + 1).take(keep).for_each(|b| *b = 0.0);
                self.invent(0, keep);
                goal = (keep + ROUNDS).min(self.most);
            } else if self.size < self.most {
                goal = (self.size + stride).min(self.most);
            } else {
                let enough = self.wanted + (self.most - self.wanted) / 2;
                let ends = ritz.blocks.iter().map(|(i, size)| i + size);
                let keep = ends.take_while(|&end| end <= self.most - 2).find(|&end| end >= enough).unwrap_or(enough);
                self.restart(&ritz, keep);
                goal = self.most;
            }
        }
        Ok(None)
    }

    /// Carries the newest vector round once.
    fn grow(&mut self) -> Result<(), PeriodicError> {
        let k = self.size;
        let mut w = vec![0.0; self.n];
        for j in 0..=self.last {
            self.product.apply(
                j,
                MatRef::from_column_major_slice(self.v[j].col(k), self.n, 1),
                MatMut::from_column_major_slice_mut(&mut w, self.n, 1),
            );
            let before = dot(&w, &w).sqrt();
            if !before.is_finite() {
                return Err(PeriodicError::NotFinite { factor: j });
            }
            let (section, known) = if j == self.last { (0, k + 1) } else { (j + 1, k) };
            self.orthogonalise(section, known, &mut w, j);
            let after = dot(&w, &w).sqrt();
            if after <= DEPENDENT * before {
                self.t[j].set(known, k, 0.0);
                self.invent(section, known);
            } else {
                self.t[j].set(known, k, after);
                let column = self.v[section].col_mut(known);
                column.iter_mut().zip(&w).for_each(|(v, w)| *v = w / after);
            }
        }
        self.size += 1;
        Ok(())
    }

    /// Takes from w what lies in the first columns of a section, twice; what is taken goes to column `size` of T_j.
    fn orthogonalise(&mut self, section: usize, known: usize, w: &mut [f64], j: usize) {
        let k = self.size;
        self.t[j].col_mut(k).fill(0.0);
        for _ in 0..2 {
            let parts: Vec<f64> = (0..known).map(|i| dot(self.v[section].col(i), w)).collect();
            for (i, part) in parts.iter().enumerate() {
                axpy(-part, self.v[section].col(i), w);
                self.t[j].a[k * (self.most + 1) + i] += part;
            }
        }
    }

    /// Column `known` of a section: a direction from nowhere, the same in every run, orthogonal to those before.
    fn invent(&mut self, section: usize, known: usize) {
        let random = &mut self.random;
        // Steele, Lea and Flood 2014, doi:10.1145/2660193.2660195.
        let mut w: Vec<f64> = (0..self.n)
            .map(|_| {
                *random = random.wrapping_add(0x9E37_79B9_7F4A_7C15);
                let mut z = *random;
                z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
                z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
                (z ^ (z >> 31)) as f64 / 2.0_f64.powi(63) - 1.0
            })
            .collect();
        for _ in 0..2 {
            for i in 0..known {
                let part = dot(self.v[section].col(i), &w);
                axpy(-part, self.v[section].col(i), &mut w);
            }
            let norm = dot(&w, &w).sqrt();
            w.iter_mut().for_each(|w| *w /= norm);
        }
        self.v[section].col_mut(known).copy_from_slice(&w);
    }

    /// None if the small problem does not converge.
    fn ritz(&self) -> Option<Ritz> {
        let s = self.size;
        let beta = self.t[self.last].at(s, s - 1);
        let residuals = |basis: &Dense| (0..s).map(|i| beta * basis.at(s - 1, i)).collect();
        Ritz::new(self.t.iter().map(|t| t.truncated(s, s)).collect(), self.wanted, &residuals)
    }

    /// Keeps the leading columns of the Schur form.
    fn restart(&mut self, ritz: &Ritz, keep: usize) {
        let (n, s) = (self.n, self.size);
        let Some(bases) = &ritz.cyclic.q else { return };
        let next = self.v[0].col(s).to_vec();
        for (j, turn) in bases.iter().enumerate() {
            let mut turned = Dense::zeros(n, self.most + 1);
            let (old, turn) = (self.v[j].view().subcols(0, s), turn.view().subcols(0, keep));
            matmul(turned.view_mut().subcols_mut(0, keep), Accum::Replace, old, turn, 1.0, Par::Seq);
            self.v[j] = turned;
            let scale = f64::from(ritz.cyclic.exponents[j]).exp2();
            self.t[j].a.fill(0.0);
            for c in 0..keep {
                for r in 0..keep {
                    self.t[j].set(r, c, scale * ritz.cyclic.t[j].at(r, c));
                }
            }
        }
        self.v[0].col_mut(keep).copy_from_slice(&next);
        (0..keep).for_each(|c| self.t[self.last].set(keep, c, ritz.residuals[c]));
        self.size = keep;
    }
}
