//! Elimination of everything but the orbit's first point, the period, drift velocities and lambda.
//!
//! Each interval's equations, and each pair of neighbouring spans, have the same form: rows that couple what lies
//! inside to the two ends and to the scalars z = (P, c_1, ..., c_K, lambda), K = 0 without drift,
//!
//! ```text
//! [ inside | x_a  x_b  z ] = r,      rows = inside + n.
//! ```
//!
//! LU with partial pivoting of the tall block of inside columns leaves n rows `C x_a + D x_b + E z = r'`. Intervals
//! are eliminated side by side, then spans are joined pairwise up a binary tree (Ascher, Mattheij and Russell 1995,
//! doi:10.1137/1.9781611971231, section 7.4); transition matrices are never multiplied. Border rows (phase, arclength) are carried along.
//! The work does not depend on the number of threads.

use super::algebraic::Algebraic;
use super::band::Band;
use crate::linalg::{Matrix, Singular};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{lu_in_place, lu_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

/// What a border row multiplies after elimination: `x_a`, `x_b` and `z`.
#[derive(Clone, Debug)]
pub struct Reach {
    pub a: Vec<f64>,
    pub b: Vec<f64>,
    pub z: Vec<f64>,
}

/// Entries up to this size are taken as multipliers without exchanging rows: each joint then magnifies rounding errors
/// by no more than that, and there are log2(intervals) of them above each other.
const GROWTH: f64 = 8.0;

/// Joints of fewer unknowns are made on one thread.
const WORTH_SHARING: usize = 16;

/// A tall block `[inside | right]` after elimination of its inside columns.
pub struct Elimination {
    /// L below the diagonal, U on and above it.
    factors: Mat<f64>,
    order: Vec<usize>,
    /// Rows of the right part: on top what gives the inside, below the n remaining rows `[C D E]`.
    right: Mat<f64>,
    /// For each border, its entries on the inside times U^-1.
    borders: Vec<Vec<f64>>,
    n: usize,
}

impl Elimination {
    /// Eliminates the columns of `inside`; `right` has columns `[x_a (n), x_b (n), z]`.
    pub fn new(mut inside: Mat<f64>, right: Mat<f64>, n: usize) -> Result<Self, Singular> {
        let (rows, columns) = (inside.nrows(), inside.ncols());
        let (mut order, mut inverse) = (vec![0_usize; rows], vec![0_usize; rows]);
        let mut memory = MemBuffer::new(lu_in_place_scratch::<usize, f64>(rows, columns, Par::Seq, Default::default()));
        lu_in_place(
            inside.as_mut(),
            &mut order,
            &mut inverse,
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        if (0..columns).any(|i| !inside[(i, i)].is_finite() || inside[(i, i)] == 0.0) {
            return Err(Singular);
        }
        let mut right = Mat::from_fn(rows, right.ncols(), |i, j| right[(order[i], j)]);
        let (mut top, bottom) = right.as_mut().split_at_row_mut(columns);
        inside.as_ref().subrows(0, columns).solve_unit_lower_triangular_in_place(top.as_mut());
        matmul(bottom, Accum::Add, inside.as_ref().subrows(columns, n), top.as_ref(), -1.0, Par::Seq);
        Ok(Self { factors: inside, order, right, borders: Vec::new(), n })
    }

    /// Eliminates the point between two spans:
    ///
    /// ```text
    /// C_l x_a + D_l x_m + E_l z = r_l,      C_r x_m + D_r x_b + E_r z = r_r.
    /// ```
    ///
    /// Where D_l = -1 and no entry of C_r is large, partial pivoting would (nearly) keep the rows as they are: then
    /// factors are known, and only the product C_r C_l is left to do.
    fn joint(l: MatRef<'_, f64>, r: MatRef<'_, f64>, n: usize) -> Result<Self, Singular> {
        let inside = Mat::from_fn(2 * n, n, |i, j| if i < n { l[(i, n + j)] } else { r[(i - n, j)] });
        let mut right = Mat::from_fn(2 * n, l.ncols(), |i, j| match (i < n, j < n, j < 2 * n) {
            (true, true, _) => l[(i, j)],
            (true, false, true) | (false, true, _) => 0.0,
            (true, false, false) => l[(i, j)],
            (false, _, _) => r[(i - n, j)],
        });
        let negated = (0..n).all(|j| (0..n).all(|i| inside[(i, j)] == if i == j { -1.0 } else { 0.0 }));
        if !negated || r.subcols(0, n).norm_max() > GROWTH {
            return Self::new(inside, right, n);
        }
        let mut factors = inside;
        factors.as_mut().subrows_mut(n, n).copy_from(faer::Scale(-1.0) * r.subcols(0, n));
        let (top, mut bottom) = right.as_mut().split_at_row_mut(n);
        let multipliers = factors.as_ref().subrows(n, n);
        for (start, count) in [(0, n), (2 * n, l.ncols() - 2 * n)] {
            let part = top.as_ref().subcols(start, count);
            matmul(bottom.as_mut().subcols_mut(start, count), Accum::Add, multipliers, part, -1.0, Par::Seq);
        }
        Ok(Self { factors, order: (0..2 * n).collect(), right, borders: Vec::new(), n })
    }

    fn inside(&self) -> usize {
        self.factors.ncols()
    }

    /// The remaining rows `[C D E]`.
    pub fn remaining(&self) -> MatRef<'_, f64> {
        self.right.as_ref().subrows(self.inside(), self.n)
    }

    fn upper(&self) -> MatRef<'_, f64> {
        self.factors.as_ref().subrows(0, self.inside())
    }

    /// Eliminates a border row's entries on the inside; the change of its entries elsewhere.
    pub(super) fn add_border(&mut self, mut row: Vec<f64>) -> Reach {
        let n = self.n;
        let columns = self.inside();
        let view = faer::MatMut::from_column_major_slice_mut(&mut row, columns, 1);
        self.upper().transpose().solve_lower_triangular_in_place(view);
        let top = self.right.as_ref().subrows(0, columns);
        let change: Vec<f64> =
            (0..top.ncols()).map(|j| -(0..columns).map(|i| row[i] * top[(i, j)]).sum::<f64>()).collect();
        self.borders.push(row);
        Reach { a: change[..n].to_vec(), b: change[n..2 * n].to_vec(), z: change[2 * n..].to_vec() }
    }

    /// Applies the elimination to a right-hand side: the upper part, and the n remaining entries; `border` collects
    /// what the borders' right-hand sides lose.
    pub(super) fn forward(&self, r: &[f64], border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        let columns = self.inside();
        let mut top: Vec<f64> = self.order[..columns].iter().map(|&i| r[i]).collect();
        let mut bottom: Vec<f64> = self.order[columns..].iter().map(|&i| r[i]).collect();
        let view = faer::MatMut::from_column_major_slice_mut(&mut top, columns, 1);
        self.factors.as_ref().subrows(0, columns).solve_unit_lower_triangular_in_place(view);
        subtract_product(self.factors.as_ref().subrows(columns, self.n), &top, &mut bottom);
        for (border, row) in border.iter_mut().zip(&self.borders) {
            *border -= crate::linalg::dot(row, &top);
        }
        (top, bottom)
    }

    /// The inside from the ends and z.
    pub(super) fn back(&self, mut top: Vec<f64>, a: &[f64], b: &[f64], z: &[f64]) -> Vec<f64> {
        let columns = self.inside();
        let outer: Vec<f64> = a.iter().chain(b).chain(z).copied().collect();
        subtract_product(self.right.as_ref().subrows(0, columns), &outer, &mut top);
        let view = faer::MatMut::from_column_major_slice_mut(&mut top, columns, 1);
        self.upper().solve_upper_triangular_in_place(view);
        top
    }
}

/// `y -= A x`.
fn subtract_product(a: MatRef<'_, f64>, x: &[f64], y: &mut [f64]) {
    let rows = y.len();
    let x = MatRef::from_column_major_slice(x, x.len(), 1);
    let y = faer::MatMut::from_column_major_slice_mut(y, rows, 1);
    matmul(y, Accum::Add, a, x, -1.0, Par::Seq);
}

/// One interval's equations, factored.
pub enum Interval {
    Dense(Elimination),
    Banded(Band),
    /// Of a problem with structure and algebraic unknowns.
    Algebraic(Box<Algebraic>),
}

impl Interval {
    /// From the matrices G_u and G_v at the collocation points, which are of one structure, the values and slopes (per
    /// time) of Lagrange polynomials there, and the columns of z, n rows at each point.
    pub fn new(
        blocks: Vec<(Matrix, Matrix)>,
        (value, slope): (&[Vec<f64>], &[Vec<f64>]),
        scalars: &[Vec<f64>],
    ) -> Result<Self, Singular> {
        let m = blocks.len();
        let structured = !blocks.iter().any(|(gu, _)| matches!(gu, Matrix::Dense(_)));
        if structured
            && let Some(split) = Algebraic::split(&blocks, value)
            && let Ok(made) = Algebraic::new(&blocks, split, (value, slope), scalars)
        {
            return Ok(Interval::Algebraic(Box::new(made)));
        }
        let (mut dense, mut banded) = (Vec::new(), Vec::new());
        for pair in blocks {
            match pair {
                (Matrix::Banded(gu), Matrix::Banded(gv)) => banded.push((gu, gv)),
                (gu, gv) => dense.push((gu.into_dense(), gv.into_dense())),
            }
        }
        if banded.len() == m {
            return Ok(Interval::Banded(Band::new(&banded, (value, slope), scalars)?));
        }
        let n = dense.first().map_or(0, |(gu, _)| gu.nrows());
        let width = scalars.first().map_or(0, |rows| rows.len() / n);
        let (mut inside, mut right) = (Mat::zeros(m * n, (m - 1) * n), Mat::zeros(m * n, 2 * n + width));
        for (i, (gu, gv)) in dense.iter().enumerate() {
            for l in 0..=m {
                let (a, d) = (value[i][l], slope[i][l]);
                let block = match l {
                    0 => right.as_mut().submatrix_mut(i * n, 0, n, n),
                    l if l == m => right.as_mut().submatrix_mut(i * n, n, n, n),
                    _ => inside.as_mut().submatrix_mut(i * n, (l - 1) * n, n, n),
                };
                faer::zip!(block, gu, gv).for_each(|faer::unzip!(b, x, y)| *b = a * *x + d * *y);
            }
            for (k, &entry) in scalars[i].iter().enumerate() {
                right[(i * n + k / width, 2 * n + k % width)] = entry;
            }
        }
        Ok(Interval::Dense(Elimination::new(inside, right, n)?))
    }

    fn inside(&self) -> usize {
        match self {
            Interval::Dense(elimination) => elimination.inside(),
            Interval::Banded(band) => band.inside(),
            Interval::Algebraic(made) => made.inside(),
        }
    }

    /// `[C D E]`.
    fn remaining(&self) -> MatRef<'_, f64> {
        match self {
            Interval::Dense(elimination) => elimination.remaining(),
            Interval::Banded(band) => band.remaining(),
            Interval::Algebraic(made) => made.remaining(),
        }
    }

    fn add_border(&mut self, row: &[f64]) -> Reach {
        match self {
            Interval::Dense(elimination) => elimination.add_border(row.to_vec()),
            Interval::Banded(band) => band.add_border(row),
            Interval::Algebraic(made) => made.add_border(row),
        }
    }

    fn forward(&self, r: &[f64], border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        match self {
            Interval::Dense(elimination) => elimination.forward(r, border),
            Interval::Banded(band) => band.forward(r, border),
            Interval::Algebraic(made) => made.forward(r, border),
        }
    }

    fn back(&self, top: Vec<f64>, a: &[f64], b: &[f64], z: &[f64]) -> Vec<f64> {
        match self {
            Interval::Dense(elimination) => elimination.back(top, a, b, z),
            Interval::Banded(band) => band.back(&top, a, z),
            Interval::Algebraic(made) => made.back(top, a, b, z),
        }
    }
}

/// Neighbouring intervals as one span.
enum Span {
    Interval(Interval),
    Joined { left: Box<Span>, right: Box<Span>, joint: Elimination },
}

/// A right-hand side on its way through the tree.
enum Carried {
    Interval(Vec<f64>),
    Joined(Box<Carried>, Box<Carried>, Vec<f64>),
}

impl Span {
    fn join(mut intervals: Vec<Interval>, n: usize) -> Result<Self, Singular> {
        if intervals.len() == 1 {
            return intervals.pop().map(Span::Interval).ok_or(Singular);
        }
        let tail = intervals.split_off(intervals.len() / 2);
        let (left, right) = if n < WORTH_SHARING {
            (Self::join(intervals, n), Self::join(tail, n))
        } else {
            rayon::join(|| Self::join(intervals, n), || Self::join(tail, n))
        };
        let (left, right) = (left?, right?);
        let joint = Elimination::joint(left.remaining(), right.remaining(), n)?;
        let (mut left, mut right) = (left, right);
        left.shrink();
        right.shrink();
        Ok(Span::Joined { left: Box::new(left), right: Box::new(right), joint })
    }

    /// Forgets the rows that couple the ends of a span of several intervals, which its joint with another has taken over.
    fn shrink(&mut self) {
        if let Span::Joined { joint, .. } = self {
            joint.right = joint.right.as_ref().subrows(0, joint.inside()).to_owned();
        }
    }

    /// The rows `[C D E]` that couple the span's ends.
    fn remaining(&self) -> MatRef<'_, f64> {
        match self {
            Span::Interval(interval) => interval.remaining(),
            Span::Joined { joint, .. } => joint.remaining(),
        }
    }

    /// Appends the remaining rows of the span's intervals in order.
    fn intervals<'a>(&'a self, out: &mut Vec<MatRef<'a, f64>>) {
        match self {
            Span::Interval(elimination) => out.push(elimination.remaining()),
            Span::Joined { left, right, .. } => {
                left.intervals(out);
                right.intervals(out);
            }
        }
    }

    /// `row` covers the span's nodes, its last one excluded.
    fn add_border(&mut self, row: &[f64], n: usize) -> Reach {
        match self {
            Span::Interval(interval) => {
                let mut reach = interval.add_border(&row[n..]);
                reach.a.iter_mut().zip(row).for_each(|(a, r)| *a += r);
                reach
            }
            Span::Joined { left, right, joint } => {
                let (row_left, row_right) = row.split_at(left.nodes(n) * n);
                let (l, r) = (left.add_border(row_left, n), right.add_border(row_right, n));
                let middle = l.b.iter().zip(&r.a).map(|(x, y)| x + y).collect();
                let mut reach = joint.add_border(middle);
                reach.a.iter_mut().zip(&l.a).for_each(|(x, y)| *x += y);
                reach.b.iter_mut().zip(&r.b).for_each(|(x, y)| *x += y);
                reach.z.iter_mut().zip(l.z.iter().zip(&r.z)).for_each(|(x, (l, r))| *x = *x + l + r);
                reach
            }
        }
    }

    /// Nodes of the span, the last one excluded.
    fn nodes(&self, n: usize) -> usize {
        match self {
            Span::Interval(interval) => interval.inside() / n + 1,
            Span::Joined { left, right, .. } => left.nodes(n) + right.nodes(n),
        }
    }

    /// Equations of the span, which are as many as its nodes' entries.
    fn forward(&self, r: &[f64], border: &mut [f64], n: usize) -> (Carried, Vec<f64>) {
        match self {
            Span::Interval(interval) => {
                let (top, bottom) = interval.forward(r, border);
                (Carried::Interval(top), bottom)
            }
            Span::Joined { left, right, joint } => {
                let (r_left, r_right) = r.split_at(left.nodes(n) * n);
                let (carried_left, mut rows) = left.forward(r_left, border, n);
                let (carried_right, below) = right.forward(r_right, border, n);
                rows.extend(below);
                let (top, bottom) = joint.forward(&rows, border);
                (Carried::Joined(Box::new(carried_left), Box::new(carried_right), top), bottom)
            }
        }
    }

    /// Appends the span's nodes, from its first on, the last one excluded.
    fn back(&self, carried: Carried, a: &[f64], b: &[f64], z: &[f64], out: &mut Vec<f64>) {
        match (self, carried) {
            (Span::Interval(interval), Carried::Interval(top)) => {
                out.extend_from_slice(a);
                out.extend(interval.back(top, a, b, z));
            }
            (Span::Joined { left, right, joint }, Carried::Joined(carried_left, carried_right, top)) => {
                let middle = joint.back(top, a, b, z);
                left.back(*carried_left, a, &middle, z, out);
                right.back(*carried_right, &middle, b, z, out);
            }
            _ => unreachable!("a right-hand side has the shape of its tree"),
        }
    }
}

/// All intervals condensed to `C x_0 + D x_N + E z = r`.
pub struct Condensed {
    root: Span,
    n: usize,
}

impl Condensed {
    /// From the intervals in order.
    pub fn new(intervals: Vec<Interval>, n: usize) -> Result<Self, Singular> {
        Ok(Self { root: Span::join(intervals, n)?, n })
    }

    /// `[C D E]`.
    pub fn transition(&self) -> MatRef<'_, f64> {
        self.root.remaining()
    }

    /// `[C D E]` of each interval in order.
    pub fn intervals(&self) -> Vec<MatRef<'_, f64>> {
        let mut out = Vec::new();
        self.root.intervals(&mut out);
        out
    }

    /// Condenses a border row over all nodes but the last.
    pub fn add_border(&mut self, row: &[f64]) -> Reach {
        self.root.add_border(row, self.n)
    }

    /// Condenses a right-hand side: what is left for the ends; `border` is changed accordingly.
    pub fn forward(&self, r: &[f64], border: &mut [f64]) -> (Forwarded, Vec<f64>) {
        let (carried, rows) = self.root.forward(r, border, self.n);
        (Forwarded(carried), rows)
    }

    /// All nodes but the last from x_0, x_N and z.
    pub fn back(&self, forwarded: Forwarded, first: &[f64], last: &[f64], z: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.root.nodes(self.n) * self.n);
        self.root.back(forwarded.0, first, last, z, &mut out);
        out
    }
}

/// A right-hand side after forward elimination.
pub struct Forwarded(Carried);
