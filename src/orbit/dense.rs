//! An interval whose Jacobians are dense, in terms of what its equations ask for.
//!
//! The equations at a collocation point are about `u(c_i)` and `u'(c_i)` alone. So for as many points as there is room for
//! beside the ends, both are coordinates of the polynomials (Hermite interpolation), together with the first nodes inside where
//! coordinates are left over. The equations of such a point are then solved by themselves ([`Pair`]), and what is left is an
//! interval with n equations and n unknowns fewer for each: at degree 4, 57 n³ operations become 34 n³, at degree 5, 107 n³
//! become 43 n³. At the ends nothing changes.

use super::elimination::Elimination;
use super::pair::Pair;
use super::rows::{Reach, Rows, subtract_product};
use crate::linalg::{Lu, Singular, dot};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, Par};

/// Systems of fewer unknowns are eliminated as they are, and their ends not solved for: calls would take longer than what they
/// save.
const WORTH_PAIRING: usize = 16;

/// A point whose equations are solved by themselves.
struct Inner {
    point: usize,
    pair: Pair,
    /// What the other points' equations multiply w_p by.
    taken: Mat<f64>,
    /// For each border, its entries on w_p.
    borders: Mat<f64>,
}

/// The interval's equations, factored.
pub struct Dense {
    pairs: Vec<Inner>,
    /// The other points' equations in terms of every w_f and the nodes that are coordinates.
    elimination: Elimination,
    /// Node by coordinate: the coordinates are x_a, x_b, `u(c_i)` and `u'(c_i) / s` of each pair, nodes.
    nodes: Mat<f64>,
    n: usize,
}

impl Dense {
    /// As [`super::Interval::new`].
    pub fn new(
        blocks: &[(Mat<f64>, Mat<f64>)],
        (value, slope): (&[Vec<f64>], &[Vec<f64>]),
        scalars: &[Vec<f64>],
    ) -> Result<Self, Singular> {
        let (m, n) = (blocks.len(), blocks[0].0.nrows());
        let width = scalars[0].len() / n;
        // Every second point, the last one not: so the coordinates are as good as the nodes' values.
        let paired = |i: &usize| n >= WORTH_PAIRING && i % 2 == m % 2 && i + 2 <= m && *i > 0;
        let (places, others): (Vec<usize>, Vec<usize>) = (0..m).partition(paired);
        let scales: Vec<f64> = places.iter().map(|&i| slope[i].iter().fold(0.0, |most, d| d.abs().max(most))).collect();
        let nodes = nodes(&places, &scales, (value, slope))?;
        let parts: Vec<[Vec<f64>; 2]> =
            others.iter().map(|&i| [&value[i], &slope[i]].map(|row| through(row, &nodes))).collect();
        // A coordinate's entries in the other points' equations.
        let fill = |out: &mut [f64], coordinate: usize, column: usize| {
            for ((out, &i), [values, slopes]) in out.chunks_mut(n).zip(&others).zip(&parts) {
                let (a, d) = (values[coordinate], slopes[coordinate]);
                let entries = blocks[i].0.col_as_slice(column).iter().zip(blocks[i].1.col_as_slice(column));
                out.iter_mut().zip(entries).for_each(|(out, (x, y))| *out = a * x + d * y);
            }
        };
        let left = others.len() * n;
        let (mut inside, mut right) = (Mat::zeros(left, left - n), Mat::zeros(left, 2 * n + width));
        (0..2 * n).for_each(|j| fill(right.col_as_slice_mut(j), j / n, j % n));
        for (k, &i) in others.iter().enumerate() {
            for (j, &entry) in scalars[i].iter().enumerate() {
                right[(k * n + j / width, 2 * n + j % width)] = entry;
            }
        }
        let mut pairs = Vec::with_capacity(places.len());
        for (k, (&point, &scale)) in places.iter().zip(&scales).enumerate() {
            let pair = Pair::new(&blocks[point], scale, &scalars[point])?;
            let (solved, free) = pair.places();
            let mut taken = Mat::zeros(left, n);
            for (j, (&p, &f)) in solved.iter().zip(free).enumerate() {
                fill(taken.col_as_slice_mut(j), 2 + 2 * k + p / n, p % n);
                fill(inside.col_as_slice_mut(k * n + j), 2 + 2 * k + f / n, f % n);
            }
            let (by_free, by_scalars) = pair.kept.as_ref().split_at_col(n);
            let subtract = |out: MatMut<'_, f64>, kept| matmul(out, Accum::Add, taken.as_ref(), kept, -1.0, Par::Seq);
            subtract(inside.as_mut().subcols_mut(k * n, n), by_free);
            subtract(right.as_mut().subcols_mut(2 * n, width), by_scalars);
            pairs.push(Inner { point, pair, taken, borders: Mat::new() });
        }
        for j in places.len() * n..left - n {
            fill(inside.col_as_slice_mut(j), 2 + places.len() + j / n, j % n);
        }
        let mut elimination = Elimination::new(inside, right, n)?;
        if n >= WORTH_PAIRING {
            elimination.solve_for_end();
        }
        Ok(Self { pairs, elimination, nodes, n })
    }

    /// Inner nodes.
    fn inner(&self) -> usize {
        self.nodes.nrows() - 2
    }

    pub fn inside(&self) -> usize {
        self.inner() * self.n
    }

    pub fn remaining(&self) -> Rows<'_> {
        self.elimination.remaining()
    }

    /// The rows cover the inner nodes.
    pub fn add_borders(&mut self, rows: &[&[f64]]) -> Vec<Reach> {
        let (n, count, inner) = (self.n, rows.len(), self.inner());
        // Their entries on a coordinate.
        let on = |coordinate: usize| {
            let mut on = Mat::zeros(n, count);
            for (k, row) in rows.iter().enumerate() {
                for (l, row) in row.chunks(n).enumerate() {
                    let part = self.nodes[(l + 1, coordinate)];
                    on.col_as_slice_mut(k).iter_mut().zip(row).for_each(|(on, x)| *on += part * x);
                }
            }
            on
        };
        let (a, b) = (on(0), on(1));
        let mut inside = Mat::zeros(self.elimination.inside(), count);
        let mut changes = Vec::with_capacity(self.pairs.len());
        for k in 0..self.pairs.len() {
            let w = [on(2 + 2 * k), on(3 + 2 * k)];
            let (solved, free) = self.pairs[k].pair.places();
            let at = |places: &[usize]| Mat::from_fn(n, count, |i, j| w[places[i] / n][(places[i] % n, j)]);
            let (on_solved, on_free) = (at(solved), at(free));
            let change = self.pairs[k].pair.kept.transpose() * &on_solved;
            inside.as_mut().subrows_mut(k * n, n).copy_from(on_free - change.as_ref().subrows(0, n));
            changes.push((on_solved, change));
        }
        for k in self.pairs.len()..inner - self.pairs.len() {
            inside.as_mut().subrows_mut(k * n, n).copy_from(on(2 + self.pairs.len() + k));
        }
        let mut reaches = self.elimination.add_borders(inside);
        for (j, reach) in reaches.iter_mut().enumerate() {
            reach.a.iter_mut().zip(a.col_as_slice(j)).for_each(|(x, a)| *x += a);
            reach.b.iter_mut().zip(b.col_as_slice(j)).for_each(|(x, b)| *x += b);
            for (_, change) in &changes {
                reach.z.iter_mut().zip(&change.col_as_slice(j)[n..]).for_each(|(z, change)| *z -= change);
            }
        }
        self.pairs.iter_mut().zip(changes).for_each(|(pair, (on_solved, _))| pair.borders = on_solved);
        reaches
    }

    /// What `back` needs, and the n remaining entries; `border` collects what the borders' right-hand sides lose.
    pub fn forward(&self, r: &[f64], border: &mut [f64]) -> (Vec<f64>, Vec<f64>) {
        let n = self.n;
        let mut left = Vec::with_capacity(r.len());
        let of_pair = |i: usize| self.pairs.iter().any(|pair| pair.point == i);
        r.chunks(n).enumerate().filter(|(i, _)| !of_pair(*i)).for_each(|(_, r)| left.extend_from_slice(r));
        let mut solved = Vec::with_capacity(self.pairs.len() * n);
        for Inner { point, pair, taken, borders } in &self.pairs {
            let w = pair.solve(&r[point * n..][..n]);
            subtract_product(taken.as_ref(), &w, &mut left);
            for (j, border) in border.iter_mut().enumerate().take(borders.ncols()) {
                *border -= dot(borders.col_as_slice(j), &w);
            }
            solved.extend(w);
        }
        let (mut top, bottom) = self.elimination.forward(&left, border);
        top.extend(solved);
        (top, bottom)
    }

    /// The inner nodes from the ends and z.
    pub fn back(&self, mut top: Vec<f64>, a: &[f64], b: &[f64], z: &[f64]) -> Vec<f64> {
        let n = self.n;
        let mut solved = top.split_off(self.elimination.inside());
        let inside = self.elimination.back(top, a, b, z);
        let mut out = vec![0.0; self.inside()];
        let mut add = |coordinate: usize, x: &[f64]| {
            for (l, out) in out.chunks_mut(n).enumerate() {
                let part = self.nodes[(l + 1, coordinate)];
                if part != 0.0 {
                    out.iter_mut().zip(x).for_each(|(out, x)| *out += part * x);
                }
            }
        };
        add(0, a);
        add(1, b);
        let (of_pairs, nodes) = inside.split_at(self.pairs.len() * n);
        for (k, (Inner { pair, .. }, w)) in self.pairs.iter().zip(solved.chunks_mut(n)).enumerate() {
            let kept = [&of_pairs[k * n..][..n], z].concat();
            subtract_product(pair.kept.as_ref(), &kept, w);
            let (solved, free) = pair.places();
            let mut whole = vec![0.0; 2 * n];
            solved.iter().zip(&*w).chain(free.iter().zip(&kept)).for_each(|(&place, x)| whole[place] = *x);
            add(2 + 2 * k, &whole[..n]);
            add(3 + 2 * k, &whole[n..]);
        }
        nodes.chunks(n).enumerate().for_each(|(l, x)| add(2 + 2 * self.pairs.len() + l, x));
        out
    }
}

/// The nodes in terms of the coordinates: the inverse of what makes these of those.
fn nodes(places: &[usize], scales: &[f64], (value, slope): (&[Vec<f64>], &[Vec<f64>])) -> Result<Mat<f64>, Singular> {
    let m = value.len();
    let unit = |node: usize| (0..=m).map(|l| f64::from(u8::from(l == node))).collect::<Vec<f64>>();
    let mut rows = vec![unit(0), unit(m)];
    for (&i, scale) in places.iter().zip(scales) {
        rows.extend([value[i].clone(), slope[i].iter().map(|d| d / scale).collect()]);
    }
    rows.extend((1..m - 2 * places.len()).map(unit));
    if places.is_empty() {
        return Ok(Mat::from_fn(m + 1, m + 1, |l, c| rows[c][l]));
    }
    let mut nodes = Mat::identity(m + 1, m + 1);
    Lu::new(Mat::from_fn(m + 1, m + 1, |i, j| rows[i][j]))?.solve_many(nodes.as_mut());
    Ok(nodes)
}

/// A row over nodes as one over coordinates.
fn through(row: &[f64], nodes: &Mat<f64>) -> Vec<f64> {
    (0..nodes.ncols()).map(|c| dot(row, nodes.col_as_slice(c))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Matrix;
    use crate::orbit::{Condensed, Interval, Points, Scheme};

    /// Pseudorandom numbers in (-1/2, 1/2).
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = 2 * seed + 1;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        }
    }

    /// Whatever the units of unknowns and equations, stiff ones and algebraic ones among them, the nodes fulfil the
    /// equations, and a border row gives what it gives of them.
    #[test]
    fn nodes_fulfil_the_equations() {
        let cases = [Points::Radau, Points::Gauss].into_iter().flat_map(|p| (1..=7).map(move |m| (p, m)));
        for ((points, m), decades) in cases.flat_map(|case| [0, 2].map(|decades| (case, decades))) {
            let (n, mut next, scheme) = (WORTH_PAIRING + m, numbers(m as u64), Scheme::new(points, m));
            let unit = |k: usize| 10_f64.powi((k % 3) as i32 * decades - decades);
            let blocks: Vec<(Mat<f64>, Mat<f64>)> = (0..m)
                .map(|_| {
                    let stiff = |i: usize| if i % 5 == 1 { 1e3 } else { 1.0 };
                    let algebraic = |i: usize| if i % 7 == 2 { 0.0 } else { 1.0 };
                    let mut entry = |i: usize, j: usize| unit(i) / unit(j) * (next() + f64::from(u8::from(i == j)));
                    let gu = Mat::from_fn(n, n, |i, j| stiff(i) * entry(i, j));
                    (gu, Mat::from_fn(n, n, |i, j| algebraic(i) * entry(i, j)))
                })
                .collect();
            let mut vector = |len: usize| -> Vec<f64> { (0..len).map(|_| next()).collect() };
            let scalars: Vec<Vec<f64>> =
                (0..m).map(|_| vector(2 * n).iter().enumerate().map(|(k, x)| x * unit(k / 2)).collect()).collect();
            let [r, row] = [vector(m * n), vector(m * n)];
            let (r, row): (Vec<f64>, Vec<f64>) =
                ((0..m * n).map(|k| r[k] * unit(k % n)).collect(), (0..m * n).map(|k| row[k] / unit(k % n)).collect());
            let (a, z): (Vec<f64>, _) = (vector(n).iter().enumerate().map(|(j, x)| x * unit(j)).collect(), vector(2));
            let wrapped = blocks.iter().map(|(u, v)| (Matrix::Dense(u.clone()), Matrix::Dense(v.clone()))).collect();
            let interval = Interval::new(wrapped, (&scheme.value, &scheme.slope), &scalars).expect("an interval");
            let Interval::Dense(dense) = &interval else { panic!("dense") };
            assert_eq!(dense.pairs.len(), (m - 1) / 2);
            let mut condensed = Condensed::new(vec![interval], n).expect("one interval");
            let reach = condensed.add_borders(&[&row]).remove(0);
            let mut border = [0.0];
            let (forwarded, mut b) = condensed.forward(&r, &mut border);
            let rows = condensed.transition();
            subtract_product(rows.c, &a, &mut b);
            subtract_product(rows.e, &z, &mut b);
            match rows.d {
                Some(d) => Lu::new(d.to_owned()).expect("an end").solve(&mut b),
                None => b.iter_mut().for_each(|b| *b = -*b),
            }
            let mut nodes = vec![0.0; m * n];
            condensed.back(forwarded, (&a, &b), &z, &mut nodes);
            nodes.extend(&b);
            let through = dot(&reach.a, &a) + dot(&reach.b, &b) + dot(&reach.z, &z) - border[0];
            let size = (0..m * n).map(|k| (row[k] * nodes[k]).abs()).sum::<f64>();
            assert!((through - dot(&row, &nodes[..m * n])).abs() < 1e-10 * size, "{points:?} {m}: the border");
            for (k, r) in r.iter().enumerate() {
                let (i, row) = (k / n, k % n);
                let (gu, gv) = &blocks[i];
                let z_terms = (0..2).map(|s| scalars[i][row * 2 + s] * z[s]);
                let terms: Vec<f64> = (0..(m + 1) * n)
                    .map(|at| (at / n, at % n))
                    .map(|(l, j)| {
                        (scheme.value[i][l] * gu[(row, j)] + scheme.slope[i][l] * gv[(row, j)]) * nodes[l * n + j]
                    })
                    .chain(z_terms)
                    .collect();
                let size = terms.iter().map(|x| x.abs()).sum::<f64>();
                assert!((terms.iter().sum::<f64>() - r).abs() < 1e-10 * size, "{points:?} {m} {decades}: equation {k}");
            }
        }
    }
}
