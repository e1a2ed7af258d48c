//! Elimination of everything but the orbit's first point, the period, drift velocities and lambda.
//!
//! Each interval's equations, and each pair of neighbouring spans, have the same form: rows that couple what lies
//! inside to the two ends and to the scalars z = (P, c_1, ..., c_K, lambda), K = 0 without drift,
//!
//! ```text
//! [ inside | x_a  x_b  z ] = r,      rows = inside + n.
//! ```
//!
//! LU with partial pivoting of the tall block of inside columns leaves n rows `C x_a + D x_b + E z = r'`, solved for x_b where
//! that is stable. Intervals are eliminated side by side, then spans are joined pairwise up a binary tree (Ascher, Mattheij and Russell 1995,
//! doi:10.1137/1.9781611971231, section 7.4); transition matrices are never multiplied. Border rows (phase, arclength) are carried along.
//! The work does not depend on the number of threads.

use super::algebraic::Algebraic;
use super::band::Band;
use super::dense::Dense;
use super::joint::Joint;
use super::rows::{Reach, Rows};
use crate::linalg::{Matrix, Singular};
use faer::Mat;

/// Joints of fewer unknowns are made on one thread.
const WORTH_SHARING: usize = 16;
/// Solves with fewer entries of a span's nodes times n, too: below some ten microseconds there is nothing to gain.
const WORTH_SOLVING: usize = 100_000;

/// Both, side by side if their work is worth it.
fn both<A: Send, B: Send>(work: usize, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    if work < WORTH_SOLVING { (a(), b()) } else { rayon::join(a, b) }
}

/// One interval's equations, factored.
pub enum Interval {
    Dense(Dense),
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
        Ok(Interval::Dense(Dense::new(&dense, (value, slope), scalars)?))
    }

    fn inside(&self) -> usize {
        match self {
            Interval::Dense(dense) => dense.inside(),
            Interval::Banded(band) => band.inside(),
            Interval::Algebraic(made) => made.inside(),
        }
    }

    fn remaining(&self) -> Rows<'_> {
        match self {
            Interval::Dense(dense) => dense.remaining(),
            Interval::Banded(band) => band.remaining(),
            Interval::Algebraic(made) => made.remaining(),
        }
    }

    fn add_borders(&mut self, rows: &[&[f64]]) -> Vec<Reach> {
        match self {
            Interval::Dense(dense) => dense.add_borders(rows),
            Interval::Banded(band) => rows.iter().map(|row| band.add_border(row)).collect(),
            Interval::Algebraic(made) => made.add_borders(rows),
        }
    }

    fn forward(&self, r: &[f64], border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        match self {
            Interval::Dense(dense) => dense.forward(r, border),
            Interval::Banded(band) => band.forward(r, border),
            Interval::Algebraic(made) => made.forward(r, border),
        }
    }

    fn back(&self, top: Vec<f64>, a: &[f64], b: &[f64], z: &[f64]) -> Vec<f64> {
        match self {
            Interval::Dense(dense) => dense.back(top, a, b, z),
            Interval::Banded(band) => band.back(&top, a, z),
            Interval::Algebraic(made) => made.back(top, a, b, z),
        }
    }
}

/// Neighbouring intervals as one span.
enum Span {
    Interval(Interval),
    Joined { left: Box<Span>, right: Box<Span>, joint: Joint },
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
        let (mut left, mut right) = (left?, right?);
        let joint = Joint::new(left.remaining(), right.remaining())?;
        if let Joint::Pivoted(_) = joint {
            left.shrink();
            right.shrink();
        }
        Ok(Span::Joined { left: Box::new(left), right: Box::new(right), joint })
    }

    /// Forgets the rows that couple the ends of a span of several intervals.
    fn shrink(&mut self) {
        if let Span::Joined { joint, .. } = self {
            joint.shrink();
        }
    }

    /// The rows that couple the span's ends.
    fn remaining(&self) -> Rows<'_> {
        match self {
            Span::Interval(interval) => interval.remaining(),
            Span::Joined { joint, .. } => joint.remaining(),
        }
    }

    /// Appends the remaining rows of the span's intervals in order.
    fn intervals<'a>(&'a self, out: &mut Vec<Rows<'a>>) {
        match self {
            Span::Interval(elimination) => out.push(elimination.remaining()),
            Span::Joined { left, right, .. } => {
                left.intervals(out);
                right.intervals(out);
            }
        }
    }

    /// The rows cover the span's nodes, its last one excluded.
    fn add_borders(&mut self, rows: &[&[f64]], n: usize) -> Vec<Reach> {
        let count = self.nodes(n);
        match self {
            Span::Interval(interval) => {
                let inner: Vec<&[f64]> = rows.iter().map(|row| &row[n..]).collect();
                let mut reaches = interval.add_borders(&inner);
                for (reach, row) in reaches.iter_mut().zip(rows) {
                    reach.a.iter_mut().zip(*row).for_each(|(a, r)| *a += r);
                }
                reaches
            }
            Span::Joined { left, right, joint } => {
                let at = left.nodes(n) * n;
                let (rows_left, rows_right): (Vec<_>, Vec<_>) = rows.iter().map(|row| row.split_at(at)).unzip();
                let (l, r) =
                    both(count * n * n, || left.add_borders(&rows_left, n), || right.add_borders(&rows_right, n));
                let middle = |(l, r): (&Reach, &Reach)| l.b.iter().zip(&r.a).map(|(x, y)| x + y).collect();
                let middle: Vec<Vec<f64>> = l.iter().zip(&r).map(middle).collect();
                let mut reaches = match joint {
                    Joint::Direct(direct) => direct.add_borders(left.remaining(), middle),
                    Joint::Pivoted(elimination) => {
                        elimination.add_borders(Mat::from_fn(n, rows.len(), |i, j| middle[j][i]))
                    }
                };
                for (reach, (l, r)) in reaches.iter_mut().zip(l.iter().zip(&r)) {
                    reach.a.iter_mut().zip(&l.a).for_each(|(x, y)| *x += y);
                    reach.b.iter_mut().zip(&r.b).for_each(|(x, y)| *x += y);
                    reach.z.iter_mut().zip(l.z.iter().zip(&r.z)).for_each(|(x, (l, r))| *x = *x + l + r);
                }
                reaches
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
                let mut of_right = vec![0.0; border.len()];
                let ((carried_left, above), (carried_right, below)) =
                    both(r.len() * n, || left.forward(r_left, border, n), || right.forward(r_right, &mut of_right, n));
                border.iter_mut().zip(&of_right).for_each(|(border, change)| *border += change);
                let (top, bottom) = match joint {
                    Joint::Direct(direct) => direct.forward(right.remaining(), above, below, border),
                    Joint::Pivoted(elimination) => elimination.forward(&[above, below].concat(), border),
                };
                (Carried::Joined(Box::new(carried_left), Box::new(carried_right), top), bottom)
            }
        }
    }

    /// The span's nodes, from its first on, the last one excluded.
    fn back(&self, carried: Carried, (a, b): (&[f64], &[f64]), z: &[f64], out: &mut [f64]) {
        let n = a.len();
        match (self, carried) {
            (Span::Interval(interval), Carried::Interval(top)) => {
                out[..n].copy_from_slice(a);
                out[n..].copy_from_slice(&interval.back(top, a, b, z));
            }
            (Span::Joined { left, right, joint }, Carried::Joined(carried_left, carried_right, top)) => {
                let middle = match joint {
                    Joint::Direct(direct) => direct.back(left.remaining(), &top, a, z),
                    Joint::Pivoted(elimination) => elimination.back(top, a, b, z),
                };
                let work = out.len() * n;
                let (out_left, out_right) = out.split_at_mut(left.nodes(n) * n);
                both(
                    work,
                    || left.back(*carried_left, (a, &middle), z, out_left),
                    || right.back(*carried_right, (&middle, b), z, out_right),
                );
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

    /// The rows that couple the orbit's ends.
    pub fn transition(&self) -> Rows<'_> {
        self.root.remaining()
    }

    /// Those of each interval in order.
    pub fn intervals(&self) -> Vec<Rows<'_>> {
        let mut out = Vec::new();
        self.root.intervals(&mut out);
        out
    }

    /// Condenses the border rows, over all nodes but the last.
    pub fn add_borders(&mut self, rows: &[&[f64]]) -> Vec<Reach> {
        self.root.add_borders(rows, self.n)
    }

    /// Condenses a right-hand side: what is left for the ends; `border` is changed accordingly.
    pub fn forward(&self, r: &[f64], border: &mut [f64]) -> (Forwarded, Vec<f64>) {
        let (carried, rows) = self.root.forward(r, border, self.n);
        (Forwarded(carried), rows)
    }

    /// All nodes but the last from x_0, x_N and z.
    pub fn back(&self, forwarded: Forwarded, ends: (&[f64], &[f64]), z: &[f64], nodes: &mut [f64]) {
        self.root.back(forwarded.0, ends, z, nodes);
    }
}

/// A right-hand side after forward elimination.
pub struct Forwarded(Carried);
