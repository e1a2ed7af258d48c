//! An interval of a problem with algebraic unknowns: these are eliminated at each collocation point, before its nodes are.
//!
//! Where the mass has no entries in the columns of some unknowns y, and x are the others, the linearised equations at point i are
//!
//! ```text
//! G_x x(c_i) + M_x x'(c_i) + G_y y(c_i) + E_i z = r_i.
//! ```
//!
//! `K_i = [M_x G_y]` is regular (the index is one, as for simulations), and K_i^-1 times that is, with `K_i^-1 G_x = [J_i; L_i]`
//! and `K_i^-1 E_i = [E_i^x; E_i^y]`, an interval in x alone and a formula for y:
//!
//! ```text
//! x'(c_i) + J_i x(c_i) + E_i^x z = r_i^x,      y(c_i) = r_i^y - L_i x(c_i) - E_i^y z.
//! ```
//!
//! So the structure of G is made use of once for each point, and dense algebra has the size of x. The last point must be the
//! interval's end (Radau), where `y_b = y(c_m)` then: y_a matters for y inside alone. In between, the nodes' values are, with
//! W the inverse of the points' values of Lagrange polynomials 1 ... m,
//!
//! ```text
//! y_l = sum_i W_li (y(c_i) - L_0(c_i) y_a).
//! ```

use super::elimination::Elimination;
use super::rows::{Reach, Rows};
use crate::linalg::{Factors, Lu, Matrix, Singular, dot};
use faer::Mat;

/// One collocation point.
struct Point {
    factors: Factors,
    /// `[L_i, E_i^y]`.
    images: Mat<f64>,
}

/// The interval's equations, factored.
pub struct Algebraic {
    /// Places of x and y among the unknowns.
    moving: Vec<usize>,
    still: Vec<usize>,
    points: Vec<Point>,
    inner: Elimination,
    /// D of the inner interval's `C x_a + D x_b + E z`.
    end: Lu<f64>,
    /// `[C E]` of the remaining rows, D being -1.
    remaining: Mat<f64>,
    /// Values of Lagrange polynomials 0 ... m at the points, and W.
    value: Vec<Vec<f64>>,
    inverse: Mat<f64>,
    /// For each border and point, its entries on y(c_i).
    borders: Vec<Vec<Vec<f64>>>,
    count: usize,
}

impl Algebraic {
    /// Places of x and y, where this way is open: there are algebraic unknowns, and the last point is the interval's end.
    pub fn split(blocks: &[(Matrix, Matrix)], value: &[Vec<f64>]) -> Option<(Vec<usize>, Vec<usize>)> {
        let last = value.last()?;
        let ends = last.iter().rev().skip(1).all(|&x| x == 0.0) && last.last() == Some(&1.0);
        if !ends {
            return None;
        }
        let n = blocks.first()?.0.n();
        let mut moves = vec![false; n];
        for (_, gv) in blocks {
            gv.entries().into_iter().filter(|(.., x)| *x != 0.0).for_each(|(_, j, _)| moves[j] = true);
        }
        let (moving, still): (Vec<usize>, Vec<usize>) = (0..n).partition(|&j| moves[j]);
        (!still.is_empty()).then_some((moving, still))
    }

    /// As [`super::Interval::new`], with places from [`Self::split`]; singular, too, where the index is not one.
    pub fn new(
        blocks: &[(Matrix, Matrix)],
        (moving, still): (Vec<usize>, Vec<usize>),
        (value, slope): (&[Vec<f64>], &[Vec<f64>]),
        scalars: &[Vec<f64>],
    ) -> Result<Self, Singular> {
        let (m, n, nx) = (blocks.len(), moving.len() + still.len(), moving.len());
        let count = scalars.first().map_or(0, |rows| rows.len() / n);
        let (mut inside, mut right) = (Mat::zeros(m * nx, (m - 1) * nx), Mat::zeros(m * nx, 2 * nx + count));
        let mut points = Vec::with_capacity(m);
        for (i, (gu, gv)) in blocks.iter().enumerate() {
            let factors = Factors::new(&gv.with_columns(gu, &still))?;
            let mut images = Mat::zeros(n, nx + count);
            gu.copy_columns(&moving, &mut images);
            for (k, &entry) in scalars[i].iter().enumerate() {
                images[(k / count, nx + k % count)] = entry;
            }
            factors.solve_many(&mut images);
            if !images.is_all_finite() {
                return Err(Singular);
            }
            for l in 0..=m {
                let (a, d) = (value[i][l], slope[i][l]);
                let mut block = match l {
                    0 => right.as_mut().submatrix_mut(i * nx, 0, nx, nx),
                    l if l == m => right.as_mut().submatrix_mut(i * nx, nx, nx, nx),
                    _ => inside.as_mut().submatrix_mut(i * nx, (l - 1) * nx, nx, nx),
                };
                for j in 0..nx {
                    (0..nx).for_each(|k| block[(k, j)] = a * images[(moving[k], j)]);
                    block[(j, j)] += d;
                }
            }
            for j in 0..count {
                (0..nx).for_each(|k| right[(i * nx + k, 2 * nx + j)] = images[(moving[k], nx + j)]);
            }
            let images = Mat::from_fn(still.len(), nx + count, |k, j| images[(still[k], j)]);
            points.push(Point { factors, images });
        }
        let inner = Elimination::new(inside, right, nx)?;
        let rows = inner.remaining();
        let end = Lu::new(rows.d.ok_or(Singular)?.to_owned())?;
        // x_b = rho - [C E] (x_a, z), and y_b from it.
        let mut reach = Mat::from_fn(nx, nx + count, |i, j| if j < nx { rows.c[(i, j)] } else { rows.e[(i, j - nx)] });
        end.solve_many(reach.as_mut());
        let images = &points[m - 1].images;
        let mut reach_still = images.as_ref().subcols(0, nx) * &reach;
        (0..count).for_each(|s| (0..still.len()).for_each(|k| reach_still[(k, nx + s)] -= images[(k, nx + s)]));
        let mut remaining = Mat::zeros(n, n + count);
        for (places, rows, sign) in [(&moving, &reach, -1.0), (&still, &reach_still, 1.0)] {
            for (k, &row) in places.iter().enumerate() {
                (0..nx).for_each(|j| remaining[(row, moving[j])] = sign * rows[(k, j)]);
                (0..count).for_each(|s| remaining[(row, n + s)] = sign * rows[(k, nx + s)]);
            }
        }
        let mut inverse = Mat::identity(m, m);
        Lu::new(Mat::from_fn(m, m, |i, l| value[i][l + 1]))?.solve_many(inverse.as_mut());
        let value = value.to_vec();
        Ok(Self { moving, still, points, inner, end, remaining, value, inverse, borders: Vec::new(), count })
    }

    fn n(&self) -> usize {
        self.moving.len() + self.still.len()
    }

    pub fn inside(&self) -> usize {
        (self.points.len() - 1) * self.n()
    }

    pub fn remaining(&self) -> Rows<'_> {
        let (c, e) = self.remaining.as_ref().split_at_col(self.n());
        Rows { c, d: None, e }
    }

    /// The rows cover the nodes 1 ... m-1.
    pub fn add_borders(&mut self, rows: &[&[f64]]) -> Vec<Reach> {
        let (m, nx) = (self.points.len(), self.moving.len());
        let moved: Vec<_> = rows.iter().map(|row| self.on_moving(row)).collect();
        let inside = Mat::from_fn((m - 1) * nx, rows.len(), |i, j| moved[j].1[1 + i / nx][i % nx]);
        let inner = self.inner.add_borders(inside);
        let whole = |((mut reach, own, on_points), inner): ((Reach, Vec<Vec<f64>>, _), Reach)| {
            for (k, &j) in self.moving.iter().enumerate() {
                reach.a[j] = own[0][k] + inner.a[k];
                reach.b[j] = own[m][k] + inner.b[k];
            }
            reach.z.iter_mut().zip(&inner.z).for_each(|(z, inner)| *z += inner);
            (reach, on_points)
        };
        let (reaches, borders) = moved.into_iter().zip(inner).map(whole).unzip();
        self.borders = borders;
        reaches
    }

    /// A border row without y inside: what it reaches, its entries on x at the nodes 0 ... m, and those on y(c_i).
    fn on_moving(&self, row: &[f64]) -> (Reach, Vec<Vec<f64>>, Vec<Vec<f64>>) {
        let (n, m, nx) = (self.n(), self.points.len(), self.moving.len());
        let mut reach = Reach { a: vec![0.0; n], b: vec![0.0; n], z: vec![0.0; self.count] };
        let mut own = vec![vec![0.0; nx]; m + 1];
        for (own, row) in own[1..m].iter_mut().zip(row.chunks(n)) {
            own.iter_mut().zip(&self.moving).for_each(|(own, &j)| *own = row[j]);
        }
        let mut on_points = Vec::with_capacity(m);
        for i in 0..m {
            let mut beta = vec![0.0; self.still.len()];
            for (l, row) in row.chunks(n).enumerate() {
                beta.iter_mut().zip(&self.still).for_each(|(b, &j)| *b += self.inverse[(l, i)] * row[j]);
            }
            let images = &self.points[i].images;
            let taken: Vec<f64> = (0..nx + self.count).map(|j| dot(&beta, images.col_as_slice(j))).collect();
            for (own, a) in own.iter_mut().zip(&self.value[i]) {
                own.iter_mut().zip(&taken).for_each(|(own, taken)| *own -= a * taken);
            }
            reach.z.iter_mut().zip(&taken[nx..]).for_each(|(z, taken)| *z -= taken);
            let first = self.value[i][0];
            self.still.iter().zip(&beta).for_each(|(&j, b)| reach.a[j] -= first * b);
            on_points.push(beta);
        }
        (reach, own, on_points)
    }

    /// What `back` needs, and minus what is known of x_b and y_b.
    pub fn forward(&self, r: &[f64], border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        let n = self.n();
        let (mut moved, mut known) = (Vec::new(), Vec::new());
        for (i, (point, r)) in self.points.iter().zip(r.chunks(n)).enumerate() {
            let mut r = r.to_vec();
            point.factors.solve(&mut r);
            moved.extend(self.moving.iter().map(|&j| r[j]));
            let still: Vec<f64> = self.still.iter().map(|&j| r[j]).collect();
            border.iter_mut().zip(&self.borders).for_each(|(border, rows)| *border -= dot(&rows[i], &still));
            known.extend(still);
        }
        let (mut top, mut end) = self.inner.forward(&moved, border);
        self.end.solve(&mut end);
        let mut bottom = vec![0.0; n];
        self.moving.iter().zip(&end).for_each(|(&j, x)| bottom[j] = -x);
        let mut last = known[known.len() - self.still.len()..].to_vec();
        self.points[self.points.len() - 1].subtract(&end, &mut last);
        self.still.iter().zip(&last).for_each(|(&j, y)| bottom[j] = -y);
        top.extend(known);
        (top, bottom)
    }

    /// The nodes 1 ... m-1 from the ends and z.
    pub fn back(&self, mut top: Vec<f64>, a: &[f64], b: &[f64], z: &[f64]) -> Vec<f64> {
        let (n, m, nx) = (self.n(), self.points.len(), self.moving.len());
        let known = top.split_off((m - 1) * nx);
        let of = |x: &[f64]| -> Vec<f64> { self.moving.iter().map(|&j| x[j]).collect() };
        let (first, last) = (of(a), of(b));
        let inner = self.inner.back(top, &first, &last, z);
        let nodes: Vec<&[f64]> = std::iter::once(&first[..]).chain(inner.chunks(nx)).chain([&last[..]]).collect();
        let mut out = vec![0.0; (m - 1) * n];
        for (l, out) in out.chunks_mut(n).enumerate() {
            self.moving.iter().zip(nodes[l + 1]).for_each(|(&j, x)| out[j] = *x);
        }
        for (i, mut y) in known.chunks(self.still.len()).map(<[f64]>::to_vec).enumerate() {
            let mut state = vec![0.0; nx];
            for (node, value) in nodes.iter().zip(&self.value[i]) {
                state.iter_mut().zip(*node).for_each(|(s, x)| *s += value * x);
            }
            state.extend_from_slice(z);
            self.points[i].subtract(&state, &mut y);
            self.still.iter().zip(&mut y).for_each(|(&j, y)| *y -= self.value[i][0] * a[j]);
            for (l, out) in out.chunks_mut(n).enumerate() {
                self.still.iter().zip(&y).for_each(|(&j, y)| out[j] += self.inverse[(l, i)] * y);
            }
        }
        out
    }
}

impl Point {
    /// `y -= [L_i, E_i^y] x`, x with z or without.
    fn subtract(&self, x: &[f64], y: &mut [f64]) {
        for (j, x) in x.iter().enumerate() {
            y.iter_mut().zip(self.images.col_as_slice(j)).for_each(|(y, image)| *y -= image * x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Banded;
    use crate::orbit::{Interval, Points, Scheme};

    /// Pseudorandom numbers in (-1/2, 1/2).
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = 2 * seed + 1;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    /// Random banded equations of which every third unknown, and the last, has no rate.
    fn blocks(n: usize, m: usize, next: &mut impl FnMut() -> f64) -> Vec<(Matrix, Matrix)> {
        (0..m)
            .map(|_| {
                let (mut gu, mut gv) = (Banded::zeros(n, 2, 2), Banded::zeros(n, 2, 2));
                for i in 0..n {
                    let columns = gu.columns(i);
                    gu.row_mut(i).iter_mut().for_each(|x| *x = next());
                    for (x, j) in gv.row_mut(i).iter_mut().zip(columns) {
                        *x = if j % 3 == 1 || j == n - 1 { 0.0 } else { next() };
                    }
                }
                (Matrix::Banded(gu), Matrix::Banded(gv))
            })
            .collect()
    }

    /// x_b from x_a and z, and the nodes between.
    fn solved(interval: Interval, r: &[f64], row: &[f64], (a, z): (&[f64], &[f64])) -> (Vec<f64>, Vec<f64>, f64) {
        let n = a.len();
        let mut condensed = crate::orbit::Condensed::new(vec![interval], n).expect("one interval");
        let whole: Vec<f64> = vec![0.0; n].into_iter().chain(row.iter().copied()).collect();
        let reach = condensed.add_borders(&[&whole]).remove(0);
        let mut border = [0.0];
        let (forwarded, mut b) = condensed.forward(r, &mut border);
        let rows = condensed.transition();
        for (i, b) in b.iter_mut().enumerate() {
            *b -= (0..n).map(|j| rows.at(i, j) * a[j]).sum::<f64>();
            *b -= z.iter().enumerate().map(|(s, z)| rows.at(i, 2 * n + s) * z).sum::<f64>();
        }
        Lu::new(Mat::from_fn(n, n, |i, j| rows.at(i, n + j))).expect("an end").solve(&mut b);
        let mut nodes = vec![0.0; r.len()];
        condensed.back(forwarded, (a, &b), z, &mut nodes);
        let nodes = nodes.split_off(n);
        let through = dot(&reach.a, a) + dot(&reach.b, &b) + dot(&reach.z, z) - border[0];
        (b, nodes, through)
    }

    #[test]
    fn gives_what_elimination_of_all_nodes_gives() {
        for (seed, n, m) in [(1, 5, 2), (2, 9, 3), (3, 12, 4), (4, 7, 5)] {
            let mut next = numbers(seed);
            let scheme = Scheme::new(Points::Radau, m);
            let blocks = blocks(n, m, &mut next);
            let dense: Vec<_> = blocks
                .iter()
                .map(|(gu, gv)| (Matrix::Dense(gu.clone().into_dense()), Matrix::Dense(gv.clone().into_dense())))
                .collect();
            let mut vector = |len: usize| -> Vec<f64> { (0..len).map(|_| next()).collect() };
            let scalars: Vec<Vec<f64>> = (0..m).map(|_| vector(2 * n)).collect();
            let (r, row, a, z) = (vector(m * n), vector((m - 1) * n), vector(n), vector(2));
            let make = |blocks| Interval::new(blocks, (&scheme.value, &scheme.slope), &scalars).expect("an interval");
            let interval = make(blocks);
            assert!(matches!(interval, Interval::Algebraic(_)));
            let (b, nodes, through) = solved(interval, &r, &row, (&a, &z));
            let (b_dense, nodes_dense, _) = solved(make(dense), &r, &row, (&a, &z));
            let size = b_dense.iter().chain(&nodes_dense).fold(1.0_f64, |most, x| most.max(x.abs()));
            for (x, y) in b.iter().zip(&b_dense).chain(nodes.iter().zip(&nodes_dense)) {
                assert!((x - y).abs() < 1e-9 * size, "seed {seed}: {x} {y}");
            }
            assert!((through - dot(&row, &nodes)).abs() < 1e-9 * size, "seed {seed}: the border");
        }
    }

    #[test]
    fn gauss_points_and_regular_masses_are_left_to_others() {
        let mut next = numbers(7);
        let made = blocks(6, 3, &mut next);
        assert!(Algebraic::split(&made, &Scheme::new(Points::Gauss, 3).value).is_none());
        let regular: Vec<_> = made.iter().map(|(gu, _)| (gu.clone(), gu.clone())).collect();
        assert!(Algebraic::split(&regular, &Scheme::new(Points::Radau, 3).value).is_none());
    }
}
