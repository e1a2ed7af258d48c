//! Large eigenvalues first in a periodic Schur form: neighbouring blocks change places.
//!
//! The invariant subspace of the lower of two blocks is `(X_j; I)` at section j, with
//! `X_{j+1} T22_j = T11_j X_j + T12_j` (Granat, Kågström and Kressner 2007, doi:10.1007/s10543-007-0143-y). As the
//! larger eigenvalues go up, the recursion contracts and is solved forwards. Its basis at section 0, carried through
//! the factors by QR, gives the triangular factors of the new form; a change that would leave more than rounding errors
//! below them is not made.

use super::cyclic::Cyclic;
use super::dense::{Dense, Small};
use super::iteration::Blocks;
use super::scaled::eigenvalues;

/// A block of up to four rows and columns, `w[row][column]`.
type Window = [[f64; 4]; 4];

const IDENTITY: Window = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
/// What may be left below the blocks, in parts of the largest entry.
const LEFT: f64 = 50.0 * f64::EPSILON;
/// Moduli that differ by less, in their logarithm, stay in place.
const TIE: f64 = 1e-12;

impl Cyclic {
    /// Sorts the blocks, largest first as far as they can be exchanged, those of two real eigenvalues taken apart.
    pub fn sort(&mut self, blocks: Blocks) -> Blocks {
        let mut sorted: Vec<((usize, usize), f64)> = Vec::new();
        let blocks: Blocks = blocks.into_iter().flat_map(|block| self.apart(block)).collect();
        for block in blocks {
            let ln = self.values(block)[0].ln;
            sorted.push((block, ln));
            for at in (1..sorted.len()).rev() {
                let ((i, p), above) = sorted[at - 1];
                let ((_, q), below) = sorted[at];
                if below <= above + TIE || !self.swap(i, p, q) {
                    break;
                }
                (sorted[at - 1], sorted[at]) = (((i, q), below), ((i + q, p), above));
            }
        }
        sorted.into_iter().map(|(block, _)| block).collect()
    }

    /// A block of two real eigenvalues as two blocks, the larger first.
    fn apart(&mut self, block: (usize, usize)) -> Vec<(usize, usize)> {
        let (i, 2) = block else { return vec![block] };
        let corner = self.trailing(i, i + 1).m;
        let [large, small] = eigenvalues(&corner);
        if large.im != 0.0 {
            return vec![block];
        }
        // Columns of P - small are multiples of the eigenvector of the other.
        let columns = [[corner[0][0] - small.re, corner[1][0]], [corner[0][1], corner[1][1] - small.re]];
        let [first, second] = columns.map(|[x, y]| x.hypot(y));
        let [x, y] = columns[usize::from(second > first)];
        let mut basis = [[0.0; 4]; 4];
        (basis[0][0], basis[1][0]) = (x, y);
        if self.turn_to(i, (2, 1), basis) { vec![(i, 1), (i + 1, 1)] } else { vec![block] }
    }

    /// Exchanges the block of size p at i with the one of size q that follows; whether that was possible.
    fn swap(&mut self, i: usize, p: usize, q: usize) -> bool {
        let unknowns = p * q;
        let Some(constant) = self.recursion(i, p, q, None) else { return false };
        // (1 - L) x = c.
        let mut system = [[0.0; 5]; 4];
        for l in 0..unknowns {
            let Some(image) = self.recursion(i, p, q, Some(l)) else { return false };
            for (k, row) in system.iter_mut().enumerate().take(unknowns) {
                row[l] = f64::from(u8::from(k == l)) - image[k / q][k % q];
            }
        }
        for (k, row) in system.iter_mut().enumerate().take(unknowns) {
            row[4] = constant[k / q][k % q];
        }
        let Some(x) = solved(system, unknowns) else { return false };
        let mut basis = [[0.0; 4]; 4];
        for (k, x) in x.iter().enumerate().take(unknowns) {
            basis[k / q][k % q] = *x;
        }
        (0..q).for_each(|c| basis[p + c][c] = 1.0);
        self.turn_to(i, (p + q, q), basis)
    }

    /// `X_0 -> X_N`: from zero, or without T12 from the unit matrix number `unit`.
    fn recursion(&self, i: usize, p: usize, q: usize, unit: Option<usize>) -> Option<[[f64; 2]; 2]> {
        let mut x = [[0.0; 2]; 2];
        if let Some(unit) = unit {
            x[unit / q][unit % q] = 1.0;
        }
        for t in &self.t {
            let at = |r: usize, c: usize| t.at(i + r, i + c);
            let mut y = [[0.0; 2]; 2];
            for (r, row) in y.iter_mut().enumerate().take(p) {
                for (c, y) in row.iter_mut().enumerate().take(q) {
                    let product: f64 = (0..p).map(|l| at(r, l) * x[l][c]).sum();
                    *y = product + if unit.is_none() { at(r, p + c) } else { 0.0 };
                }
            }
            if q == 1 {
                x = y.map(|[y, _]| [y / at(p, p), 0.0]);
            } else {
                let [[a, b], [c, d]] = [[at(p, p), at(p, p + 1)], [at(p + 1, p), at(p + 1, p + 1)]];
                let determinant = a * d - b * c;
                x = y.map(|[u, v]| [(u * d - v * c) / determinant, (v * a - u * b) / determinant]);
            }
        }
        x.iter().flatten().all(|x| x.is_finite()).then_some(x)
    }

    /// Makes the first q columns of the basis those of section 0 in the window of size s at i, which they leave
    /// invariant.
    fn turn_to(&mut self, i: usize, (s, q): (usize, usize), basis: Window) -> bool {
        let last = self.last();
        let window = |t: &Dense| -> Window {
            let mut w = [[0.0; 4]; 4];
            (0..s).for_each(|r| (0..s).for_each(|c| w[r][c] = t.at(i + r, i + c)));
            w
        };
        let mut turns = vec![factored(basis, s, q).0];
        let mut blocks = Vec::with_capacity(self.t.len());
        for t in &self.t[..last] {
            let (turn, triangular) = factored(times(&window(t), &turns[turns.len() - 1]), s, s - 1);
            turns.push(turn);
            blocks.push(triangular);
        }
        let h = window(self.h());
        let mut h_turned = times(&transposed(&turns[0]), &times(&h, &turns[last]));
        let largest = h.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        for row in &mut h_turned[q..s] {
            for x in &mut row[..q] {
                if x.is_nan() || x.abs() > LEFT * largest {
                    return false;
                }
                *x = 0.0;
            }
        }
        blocks.push(h_turned);
        for (j, block) in blocks.iter().enumerate() {
            let n = self.n;
            turn_columns(&mut self.t[j], i, i, s, &turns[j]);
            let after = &turns[(j + 1) % turns.len()];
            for c in i + s..n {
                let entries = &mut self.t[j].col_mut(c)[i..i + s];
                let mut x = [0.0; 4];
                x[..s].copy_from_slice(entries);
                for (r, entry) in entries.iter_mut().enumerate() {
                    *entry = (0..s).map(|l| after[l][r] * x[l]).sum();
                }
            }
            for (r, row) in block.iter().enumerate().take(s) {
                row[..s].iter().enumerate().for_each(|(c, x)| self.t[j].set(i + r, i + c, *x));
            }
            if let Some(bases) = &mut self.q {
                turn_columns(&mut bases[j], i, n, s, &turns[j]);
            }
        }
        true
    }
}

/// Columns `i .. i + s` of the first rows times a turn.
fn turn_columns(a: &mut Dense, i: usize, rows: usize, s: usize, turn: &Window) {
    for r in 0..rows {
        let mut x = [0.0; 4];
        (0..s).for_each(|l| x[l] = a.at(r, i + l));
        (0..s).for_each(|c| a.set(r, i + c, (0..s).map(|l| x[l] * turn[l][c]).sum()));
    }
}

/// `W = Q R`: Q and R, from reflectors of the first columns.
fn factored(w: Window, s: usize, columns: usize) -> (Window, Window) {
    let (mut q, mut r) = (IDENTITY, w);
    for k in 0..columns.min(s - 1) {
        // Rotations of neighbouring rows, from below: reflectors of two entries.
        for l in (k + 1..s).rev() {
            let (reflector, beta) = Small::new([r[l - 1][k], r[l][k], 0.0]);
            let (upper, lower) = reflector.pair();
            let turned = |x: f64, y: f64| (x - upper * (x + lower * y), y - upper * lower * (x + lower * y));
            let [above, below] = [r[l - 1], r[l]];
            (k..s).for_each(|c| (r[l - 1][c], r[l][c]) = turned(above[c], below[c]));
            (r[l - 1][k], r[l][k]) = (beta, 0.0);
            for row in &mut q {
                (row[l - 1], row[l]) = turned(row[l - 1], row[l]);
            }
        }
    }
    (q, r)
}

fn times(a: &Window, b: &Window) -> Window {
    let mut out = [[0.0; 4]; 4];
    for (out, a) in out.iter_mut().zip(a) {
        for (c, out) in out.iter_mut().enumerate() {
            *out = (0..4).map(|l| a[l] * b[l][c]).sum();
        }
    }
    out
}

fn transposed(a: &Window) -> Window {
    let mut out = [[0.0; 4]; 4];
    (0..4).for_each(|r| (0..4).for_each(|c| out[r][c] = a[c][r]));
    out
}

/// Gauss's method with row exchanges for up to four unknowns; the right-hand side in the last column.
fn solved(mut system: [[f64; 5]; 4], size: usize) -> Option<[f64; 4]> {
    for k in 0..size {
        let pivot = (k..size).max_by(|&i, &j| system[i][k].abs().total_cmp(&system[j][k].abs()))?;
        system.swap(k, pivot);
        for i in k + 1..size {
            let factor = system[i][k] / system[k][k];
            (k..5).for_each(|c| system[i][c] -= factor * system[k][c]);
        }
    }
    let mut x = [0.0; 4];
    for k in (0..size).rev() {
        let known: f64 = (k + 1..size).map(|c| system[k][c] * x[c]).sum();
        x[k] = (system[k][4] - known) / system[k][k];
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}
