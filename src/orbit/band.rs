//! An interval whose Jacobians are banded: all its nodes but the first from a band system.
//!
//! ```text
//! K (x_1, ..., x_m) + A x_a + E z = r,      x_b = x_m,
//! ```
//!
//! with unknowns and equations ordered by component first and by node or collocation point second, so that K has
//! about m times the band of G_u. What is left for the ends is `[K^-1 A]_b x_a + x_b + [K^-1 E]_b z = [K^-1 r]_b`.

use super::condensation::Reach;
use crate::linalg::{Banded, BandedLu, Singular};
use faer::{Mat, MatRef};

/// The interval's equations, factored.
pub struct Band {
    k: BandedLu,
    /// A: for each collocation point its n rows.
    first: Vec<Banded>,
    /// E, in the order of equations, as many entries a row as z has.
    scalars: Vec<f64>,
    count: usize,
    /// `[-C  -1  -e]`, n rows: with this sign a joint of two intervals need not move rows.
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
        let width = n + count;
        let mut right = vec![0.0; m * n * width];
        let mut ordered = vec![0.0; count * m * n];
        for row in 0..n {
            for i in 0..m {
                let at = row * m + i;
                let target = &mut right[at * width..(at + 1) * width];
                target[first[i].columns(row)].copy_from_slice(first[i].row(row));
                let here = &scalars[i][count * row..count * (row + 1)];
                target[n..].copy_from_slice(here);
                ordered[count * at..count * (at + 1)].copy_from_slice(here);
            }
        }
        k.solve_many(&mut right, width);
        let mut remaining = Mat::zeros(n, 2 * n + count);
        for row in 0..n {
            let solved = &right[(row * m + m - 1) * width..][..width];
            solved.iter().enumerate().for_each(|(j, x)| remaining[(row, if j < n { j } else { n + j })] = -x);
            remaining[(row, n + row)] = -1.0;
        }
        Ok(Self { k, first, scalars: ordered, count, remaining, borders: Vec::new(), n, m })
    }

    pub fn inside(&self) -> usize {
        (self.m - 1) * self.n
    }

    pub fn remaining(&self) -> MatRef<'_, f64> {
        self.remaining.as_ref()
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
