//! Bordered systems by mixed block elimination: solves with A and its adjoint alone, and yet stable where A is singular.
//!
//! One border after the other is added, M_0 = A, and with `M_k = [M, b; c^H, d]`, M short for M_(k-1),
//!
//! ```text
//! M v = b,   M^H w = c,   delta = d - c^H v,   delta* = d - w^H b          (once)
//! y1 = (g - w^H f) / delta*,   M x = f - b y1,   y2 = (g - d y1 - c^H x) / delta,   x - v y2,   y1 + y2.
//! ```
//!
//! (Govaerts and Pryce 1993, doi:10.1093/imanum/13.2.161, algorithm BEMW.) det M_k = delta det M.

use super::factors::Base;
use super::{Singular, c64};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Real or complex numbers.
pub(super) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + std::iter::Sum
{
    fn conjugate(self) -> Self;
    fn size(self) -> f64;
    fn real(x: f64) -> Self;
}

impl Number for f64 {
    fn conjugate(self) -> Self {
        self
    }

    fn size(self) -> f64 {
        self.abs()
    }

    fn real(x: f64) -> Self {
        x
    }
}

impl Number for c64 {
    fn conjugate(self) -> Self {
        self.conj()
    }

    fn size(self) -> f64 {
        self.norm()
    }

    fn real(x: f64) -> Self {
        c64::new(x, 0.0)
    }
}

/// One border with what belongs to it.
struct Level<T> {
    b: Vec<T>,
    c: Vec<T>,
    d: T,
    v: Vec<T>,
    w: Vec<T>,
    delta: T,
    delta_adjoint: T,
}

/// The borders around one matrix.
pub(super) struct Elimination<T> {
    levels: Vec<Level<T>>,
}

impl<T: Number> Elimination<T> {
    /// `b` and `c` are the columns of B and C, `d` the rows of D.
    pub fn new(base: &dyn Base<T>, b: &[&[T]], c: &[&[T]], d: &[&[T]]) -> Result<Self, Singular> {
        let mut made = Self { levels: Vec::new() };
        for k in 0..b.len() {
            let column: Vec<T> = b[k].iter().copied().chain((0..k).map(|i| d[i][k])).collect();
            let row: Vec<T> = c[k].iter().copied().chain((0..k).map(|j| d[k][j].conjugate())).collect();
            let (mut v, mut w) = (column.clone(), row.clone());
            made.solve(base, &mut v);
            made.solve_adjoint(base, &mut w);
            if !v.iter().chain(&w).all(|x| x.size().is_finite()) {
                return Err(Singular);
            }
            let corner = d[k][k];
            // An exact zero only says that this border alone does not suffice: the next one decides.
            let scale = row.iter().zip(&v).map(|(c, v)| c.size() * v.size()).fold(corner.size(), f64::max);
            let sound = |x: T| if x.size() == 0.0 { T::real(f64::EPSILON * scale.max(f64::MIN_POSITIVE)) } else { x };
            let delta = sound(corner - product(&row, &v));
            let delta_adjoint = sound(corner - product(&w, &column));
            made.levels.push(Level { b: column, c: row, d: corner, v, w, delta, delta_adjoint });
        }
        Ok(made)
    }

    /// `[f; g]` in, `[x; y]` out; with fewer borders where there are fewer entries in g.
    pub fn solve(&self, base: &dyn Base<T>, fg: &mut [T]) {
        let levels: Vec<_> =
            self.levels.iter().map(|l| (&l.b, &l.c, l.d, &l.v, &l.w, l.delta, l.delta_adjoint)).collect();
        eliminate(&levels, &|x| base.solve(x), fg);
    }

    /// The same with the adjoint.
    pub fn solve_adjoint(&self, base: &dyn Base<T>, fg: &mut [T]) {
        let turned = |l: &Level<T>| (l.delta_adjoint.conjugate(), l.delta.conjugate());
        let levels: Vec<_> =
            (self.levels.iter()).map(|l| (&l.c, &l.b, l.d.conjugate(), &l.w, &l.v, turned(l).0, turned(l).1)).collect();
        eliminate(&levels, &|x| base.solve_adjoint(x), fg);
    }

    /// `det M / det A` in sign: the product of the deltas.
    pub fn deltas(&self) -> impl Iterator<Item = T> + '_ {
        self.levels.iter().map(|level| level.delta)
    }
}

/// b, c, d, v, w, delta and delta* of a level.
type Border<'a, T> = (&'a Vec<T>, &'a Vec<T>, T, &'a Vec<T>, &'a Vec<T>, T, T);

fn eliminate<T: Number>(levels: &[Border<T>], base: &dyn Fn(&mut [T]), fg: &mut [T]) {
    let Some(((b, c, d, v, w, delta, delta_adjoint), inner)) = levels.split_last() else { return base(fg) };
    let Some((last, f)) = fg.split_last_mut() else { return };
    let first = (*last - product(w, f)) / *delta_adjoint;
    f.iter_mut().zip(*b).for_each(|(f, &b)| *f = *f - b * first);
    eliminate(inner, base, f);
    let second = (*last - *d * first - product(c, f)) / *delta;
    f.iter_mut().zip(*v).for_each(|(x, &v)| *x = *x - v * second);
    *last = first + second;
}

/// `a^H b`.
pub(super) fn product<T: Number>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).map(|(&a, &b)| a.conjugate() * b).sum()
}
