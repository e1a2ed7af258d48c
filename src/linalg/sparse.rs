//! Sparse matrices of a fixed pattern, and their LU factors by faer, whose symbolic part is made once for a pattern.

use super::Singular;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::solvers::SolveCore;
use faer::perm::PermRef;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::lu::simplicial::{
    SimplicialLu, factorize_simplicial_numeric_lu, factorize_simplicial_numeric_lu_scratch,
};
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use faer::traits::ComplexField;
use faer::{Conj, MatMut};
use std::sync::{Arc, OnceLock};

/// Which entries of a square matrix may differ from zero, column by column; the diagonal always may.
pub struct Pattern {
    symbolic: SymbolicSparseColMat<usize>,
    /// Columns in groups that share no row: their derivatives can be computed together.
    groups: OnceLock<Vec<Vec<usize>>>,
    lu: OnceLock<Option<SymbolicLu<usize>>>,
}

impl std::fmt::Debug for Pattern {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Pattern({} of {} rows)", self.entries(), self.n())
    }
}

impl PartialEq for Pattern {
    fn eq(&self, other: &Self) -> bool {
        self.symbolic.col_ptr() == other.symbolic.col_ptr() && self.symbolic.row_idx() == other.symbolic.row_idx()
    }
}

impl Eq for Pattern {}

impl Pattern {
    /// From pairs (row, column) in any order, repeated or not; those outside n by n are left out.
    pub fn new(n: usize, entries: impl IntoIterator<Item = (usize, usize)>) -> Self {
        let mut columns: Vec<Vec<usize>> = (0..n).map(|j| vec![j]).collect();
        for (i, j) in entries.into_iter().filter(|(i, j)| *i < n && *j < n) {
            columns[j].push(i);
        }
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
            rows.extend_from_slice(column);
            starts.push(rows.len());
        }
        let symbolic = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        Self { symbolic, groups: OnceLock::new(), lu: OnceLock::new() }
    }

    pub fn n(&self) -> usize {
        self.symbolic.ncols()
    }

    pub fn entries(&self) -> usize {
        self.symbolic.row_idx().len()
    }

    /// Where the entries of column j are, and their rows.
    pub fn column(&self, j: usize) -> (std::ops::Range<usize>, &[usize]) {
        let range = self.symbolic.col_ptr()[j]..self.symbolic.col_ptr()[j + 1];
        (range.clone(), &self.symbolic.row_idx()[range])
    }

    /// Groups of columns without a row in common (Curtis, Powell and Reid 1974, doi:10.1093/imamat/13.1.117), greedily.
    pub fn groups(&self) -> &[Vec<usize>] {
        self.groups.get_or_init(|| {
            let n = self.n();
            let mut by_row: Vec<Vec<usize>> = vec![Vec::new(); n];
            (0..n).for_each(|j| self.column(j).1.iter().for_each(|&i| by_row[i].push(j)));
            let (mut colour, mut groups) = (vec![usize::MAX; n], Vec::<Vec<usize>>::new());
            // The last column for which a colour was met as a neighbour's.
            let mut met: Vec<usize> = Vec::new();
            for j in 0..n {
                for other in self.column(j).1.iter().flat_map(|&i| &by_row[i]) {
                    if colour[*other] != usize::MAX {
                        met[colour[*other]] = j + 1;
                    }
                }
                let free = met.iter().position(|&last| last != j + 1).unwrap_or(met.len());
                if free == met.len() {
                    met.push(0);
                    groups.push(Vec::new());
                }
                colour[j] = free;
                groups[free].push(j);
            }
            groups
        })
    }

    fn symbolic_lu(&self) -> Result<SymbolicLu<usize>, Singular> {
        let lu = self.lu.get_or_init(|| SymbolicLu::try_new(self.symbolic.as_ref()).ok());
        lu.clone().ok_or(Singular)
    }

    pub fn symbolic(&self) -> SymbolicSparseColMatRef<'_, usize> {
        self.symbolic.as_ref()
    }
}

/// A sparse matrix: a value for each entry of its pattern, column by column.
#[derive(Clone, Debug)]
pub struct Sparse {
    pub pattern: Arc<Pattern>,
    pub values: Vec<f64>,
}

impl Sparse {
    pub fn zeros(pattern: Arc<Pattern>) -> Self {
        let values = vec![0.0; pattern.entries()];
        Self { pattern, values }
    }

    /// `out += A x`, x real or complex.
    pub fn add_times<T: Copy + std::ops::Mul<f64, Output = T> + std::ops::AddAssign>(&self, x: &[T], out: &mut [T]) {
        for (j, &x) in x.iter().enumerate() {
            let (range, rows) = self.pattern.column(j);
            rows.iter().zip(&self.values[range]).for_each(|(&i, &a)| out[i] += x * a);
        }
    }

    /// `out += A^T x`.
    pub fn add_transposed_times(&self, x: &[f64], out: &mut [f64]) {
        for (j, out) in out.iter_mut().enumerate() {
            let (range, rows) = self.pattern.column(j);
            *out += rows.iter().zip(&self.values[range]).map(|(&i, &a)| x[i] * a).sum::<f64>();
        }
    }
}

/// `P A Q = L U` of a sparse matrix.
pub struct SparseLu<T> {
    factors: Lu<usize, T>,
    n: usize,
}

impl<T: ComplexField> SparseLu<T> {
    /// Factors a matrix with these values.
    pub fn new(pattern: &Pattern, values: &[T]) -> Result<Self, Singular> {
        let a = SparseColMatRef::new(pattern.symbolic(), values);
        let factors = Lu::try_new_with_symbolic(pattern.symbolic_lu()?, a).map_err(|_| Singular)?;
        Ok(Self { factors, n: pattern.n() })
    }

    /// `A^-1 b` in place.
    pub fn solve(&self, b: &mut [T]) {
        let right = MatMut::from_column_major_slice_mut(b, self.n, 1);
        self.factors.solve_in_place_with_conj(Conj::No, right);
    }

    /// `A^-H b` in place.
    pub fn solve_adjoint(&self, b: &mut [T]) {
        let right = MatMut::from_column_major_slice_mut(b, self.n, 1);
        self.factors.solve_transpose_in_place_with_conj(Conj::Yes, right);
    }
}

/// The sign of the determinant, which faer's fast factors do not give away: by factors of their own, entry by entry.
pub fn sign(a: &Sparse) -> Result<f64, Singular> {
    let (n, symbolic) = (a.pattern.n(), a.pattern.symbolic());
    let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, a.pattern.entries()));
    amd::order(&mut forward, &mut inverse, symbolic, Default::default(), MemStack::new(&mut memory))
        .map_err(|_| Singular)?;
    let columns = PermRef::new_checked(&forward, &inverse, n);
    let (mut rows, mut rows_inverse) = (vec![0; n], vec![0; n]);
    let mut lu = SimplicialLu::new();
    let mut memory = MemBuffer::new(factorize_simplicial_numeric_lu_scratch::<usize, f64>(n, n));
    let matrix = SparseColMatRef::new(symbolic, &a.values[..]);
    factorize_simplicial_numeric_lu(&mut rows, &mut rows_inverse, &mut lu, matrix, columns, MemStack::new(&mut memory))
        .map_err(|_| Singular)?;
    let upper = lu.u_factor_unsorted();
    let diagonal = (0..n).map(|j| {
        let entries = upper.row_idx_of_col_raw(j).iter().zip(upper.val_of_col(j));
        entries.filter(|(i, _)| **i == j).map(|(_, value)| value.signum()).next().unwrap_or(0.0)
    });
    let product: f64 = diagonal.product();
    if product.abs() == 1.0 { Ok(product * parity(&rows) * parity(&forward)) } else { Err(Singular) }
}

/// 1 for an even permutation, -1 for an odd one.
pub fn parity(permutation: &[usize]) -> f64 {
    let mut seen = vec![false; permutation.len()];
    let mut sign = 1.0;
    for start in 0..permutation.len() {
        let (mut i, mut length) = (start, 0);
        while !seen[i] {
            seen[i] = true;
            i = permutation[i];
            length += 1;
        }
        if length > 0 && length % 2 == 0 {
            sign = -sign;
        }
    }
    sign
}
