//! An interval whose Jacobians are banded: all its nodes but the first from a band system.
//!
//! ```text
//! K (x_1, ..., x_m) + A x_a + E z = r,      x_b = x_m,
//! ```
//!
//! with unknowns and equations ordered by component first and by node or collocation point second, so that K has
//! about m times the band of G_u. What is left for the ends is `[K^-1 A]_b x_a + x_b + [K^-1 E]_b z = [K^-1 r]_b`.

use super::rows::{Reach, Rows};
use crate::linalg::{Banded, BandedLu, LANES, Singular};
use faer::Mat;

/// The interval's equations, factored.
pub struct Band {
    k: BandedLu,
    /// A: for each collocation point its n rows.
    first: Vec<Banded>,
    /// E, in the order of equations, as many entries a row as z has.
    scalars: Vec<f64>,
    count: usize,
    /// `[C E]` of the remaining rows, D being -1: with this sign a joint of two intervals need not move rows.
    remaining: Mat<f64>,
    /// For each border, its entries on x_1 ... x_{m-1} times K^-1.
    borders: Vec<Vec<f64>>,
    n: usize,
    m: usize,
}

impl Band {
    /// `blocks[i]` are G_u and G_v at collocation point i, `value` and `slope` as in `Scheme` (slopes per time), and
    /// `scalars[i]` the columns of z there, n rows.
    pub fn new(
        blocks: &[(Banded, Banded)],
        (value, slope): (&[Vec<f64>], &[Vec<f64>]),
        scalars: &[Vec<f64>],
    ) -> Result<Self, Singular> {
        let m = blocks.len();
        let (n, lower, upper) = (blocks[0].0.n(), blocks[0].0.lower(), blocks[0].0.upper());
        let mut k = Banded::zeros(m * n, m * lower + m - 1, m * upper + m - 1);
        let mut first = vec![Banded::zeros(n, lower, upper); m];
        for (i, (gu, gv)) in blocks.iter().enumerate() {
            for row in 0..n {
                let columns = gu.columns(row);
                let start = k.columns(row * m + i).start;
                let target = k.row_mut(row * m + i);
                for (column, (gu, gv)) in columns.zip(gu.row(row).iter().zip(gv.row(row))) {
                    for l in 1..=m {
                        target[column * m + l - 1 - start] = value[i][l] * gu + slope[i][l] * gv;
                    }
                }
                let entries = gu.row(row).iter().zip(gv.row(row));
                for (target, (gu, gv)) in first[i].row_mut(row).iter_mut().zip(entries) {
                    *target = value[i][0] * gu + slope[i][0] * gv;
                }
            }
        }
        let k = BandedLu::new(&k)?;
        let count = scalars.first().map_or(0, |rows| rows.len() / n);
        let mut ordered = vec![0.0; count * m * n];
        for (at, target) in ordered.chunks_mut(count).enumerate() {
            target.copy_from_slice(&scalars[at % m][count * (at / m)..][..count]);
        }
        // In strips of columns, which stay in the cache while they are solved for.
        let mut remaining = Mat::zeros(n, n + count);
        let mut strip = vec![[0.0; LANES]; m * n];
        for start in (0..n + count).step_by(LANES) {
            let end = (start + LANES).min(n + count);
            strip.fill([0.0; LANES]);
            for (at, target) in strip.iter_mut().enumerate() {
                let (row, first) = (at / m, &first[at % m]);
                let columns = first.columns(row);
                for column in columns.start.max(start)..columns.end.min(end) {
                    target[column - start] = first.row(row)[column - columns.start];
                }
                for column in start.max(n)..end {
                    target[column - start] = ordered[count * at + column - n];
                }
            }
            k.solve_strip(&mut strip);
            for (row, solved) in strip[m - 1..].iter().step_by(m).enumerate() {
                (start..end).for_each(|column| remaining[(row, column)] = -solved[column - start]);
            }
        }
        Ok(Self { k, first, scalars: ordered, count, remaining, borders: Vec::new(), n, m })
    }

    pub fn inside(&self) -> usize {
        (self.m - 1) * self.n
    }

    pub fn remaining(&self) -> Rows<'_> {
        let (c, e) = self.remaining.as_ref().split_at_col(self.n);
        Rows { c, d: None, e }
    }

    /// From the order of points and components to that of components and points.
    fn ordered(&self, r: &[f64]) -> Vec<f64> {
        let (n, m) = (self.n, self.m);
        (0..m * n).map(|at| r.get(at % m * n + at / m).copied().unwrap_or(0.0)).collect()
    }

    /// `row` covers x_1 ... x_{m-1}.
    pub fn add_border(&mut self, row: &[f64]) -> Reach {
        let (n, m) = (self.n, self.m);
        let mut w = self.ordered(row);
        self.k.solve_transposed(&mut w);
        let mut reach = Reach { a: vec![0.0; n], b: vec![0.0; n], z: vec![0.0; self.count] };
        for (at, w) in w.iter().enumerate() {
            let (row, i) = (at / m, at % m);
            let columns = self.first[i].columns(row);
            reach.a[columns].iter_mut().zip(self.first[i].row(row)).for_each(|(a, x)| *a -= w * x);
            reach.z.iter_mut().zip(&self.scalars[self.count * at..]).for_each(|(z, e)| *z -= w * e);
        }
        self.borders.push(w);
        reach
    }

    /// `K^-1 r`, and minus its part at x_b.
    pub fn forward(&self, r: &[f64], border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        let mut solved = self.ordered(r);
        for (border, w) in border.iter_mut().zip(&self.borders) {
            *border -= crate::linalg::dot(w, &solved);
        }
        self.k.solve(&mut solved);
        let bottom = solved.iter().skip(self.m - 1).step_by(self.m).map(|x| -x).collect();
        (solved, bottom)
    }

    /// x_1 ... x_{m-1} from `K^-1 r`, x_a and z.
    pub fn back(&self, solved: &[f64], a: &[f64], z: &[f64]) -> Vec<f64> {
        let (n, m) = (self.n, self.m);
        let mut change: Vec<f64> = (0..m * n)
            .map(|at| {
                let (row, i) = (at / m, at % m);
                let scalars: f64 = self.scalars[self.count * at..].iter().zip(z).map(|(e, z)| e * z).sum();
                crate::linalg::dot(self.first[i].row(row), &a[self.first[i].columns(row)]) + scalars
            })
            .collect();
        self.k.solve(&mut change);
        (0..(m - 1) * n).map(|at| at % n * m + at / n).map(|at| solved[at] - change[at]).collect()
    }
}
