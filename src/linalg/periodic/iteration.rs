//! The implicit periodic QR algorithm on a product in Hessenberg-triangular form.
//!
//! Double shifts are chased through all factors by reflectors of three entries (Bojanczyk, Golub and Van Dooren 1992,
//! doi:10.1117/12.130915; Hench and Laub 1994, doi:10.1109/9.293179; Kressner 2001 and 2006). Steps without a shift
//! come first and wherever shifts are of no use: they bring large eigenvalues to the top, on which most of a
//! stiff product falls apart at once, and a zero on the diagonal of a triangular factor to the bottom, where it splits
//! off as an exact zero.

use super::Unconverged;
use super::cyclic::Cyclic;
use super::dense::Small;
use super::scaled::{eigenvalues, scaled};
use faer::c64;

/// Steps without a shift at the start.
const UNSHIFTED: usize = 2;
/// Steps for each eigenvalue that are taken before giving up, and between steps with shifts made up.
const STEPS: usize = 30;
const EXCEPTIONAL: usize = 10;
/// A shift polynomial whose first column is this close to the first axis moves nothing.
const IDLE: f64 = 1e-200;

/// Blocks of the periodic Schur form: first row, and size 1 or 2.
pub(super) type Blocks = Vec<(usize, usize)>;

impl Cyclic {
    /// Iterates until the Hessenberg factor is quasi-triangular; its blocks from the top.
    pub fn iterate(&mut self) -> Result<Blocks, Unconverged> {
        let mut blocks = Vec::new();
        let norm = self.h().a.iter().map(|x| x * x).sum::<f64>().sqrt();
        if self.n > 2 {
            (0..UNSHIFTED).for_each(|_| self.unshifted(0, self.n - 1));
        }
        let (mut end, mut steps, mut left) = (self.n, 0, STEPS * self.n.max(10));
        while end > 0 {
            let hi = end - 1;
            let lo = self.split(hi, norm);
            if lo == hi {
                blocks.push((lo, 1));
                (end, steps) = (lo, 0);
                continue;
            }
            if left == 0 {
                return Err(Unconverged { left: end, n: self.n });
            }
            left -= 1;
            if self.singular(lo, hi) {
                self.unshifted(lo, hi);
            } else if hi == lo + 1 {
                blocks.push((lo, 2));
                (end, steps) = (lo, 0);
            } else {
                steps += 1;
                match self.start(lo, hi, steps % EXCEPTIONAL == 0) {
                    Some(start) => self.chase(lo, hi, start),
                    None => self.unshifted(lo, hi),
                }
            }
        }
        blocks.reverse();
        Ok(blocks)
    }

    /// Sets what is negligible below the diagonal to zero; the first row of the block that ends at hi.
    fn split(&mut self, hi: usize, norm: f64) -> usize {
        for k in (1..=hi).rev() {
            let h = self.h_mut();
            let beside = h.at(k - 1, k - 1).abs() + h.at(k, k).abs();
            let size = if beside == 0.0 { norm } else { beside };
            if h.at(k, k - 1).abs() <= f64::EPSILON * size {
                h.set(k, k - 1, 0.0);
                return k;
            }
        }
        0
    }

    /// First column of `(P - s_1)(P - s_2)` up to a factor, the shifts from the product's last corner; none where
    /// it does not stand out from the first axis or cannot be formed.
    fn start(&self, lo: usize, hi: usize, exceptional: bool) -> Option<[f64; 3]> {
        let (p, last) = (self.leading(lo, hi), self.trailing(lo, hi));
        let corner = last.m[1][1];
        let [mut s, mut t] = eigenvalues(&last.m);
        if exceptional {
            // As in LAPACK's dlahqr.
            let size = last.m[..2].iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
            s = c64::new(corner + 0.75 * size, (0.4375_f64).sqrt() * size);
            t = s.conj();
        } else if s.im == 0.0 {
            // Twice the one that is nearer to the corner.
            let nearer = if (s.re - corner).abs() < (t.re - corner).abs() { s } else { t };
            (s, t) = (nearer, nearer);
        }
        let common = p.exponent.max(last.exponent);
        let (down, by) = (p.exponent - common, last.exponent - common);
        let [[p11, p12], [p21, p22], [_, p32]] = p.m.map(|row| row.map(|x| scaled(x, down)));
        let (re, im, other) = (scaled(s.re, by), scaled(s.im, by), scaled(t.re, by));
        let first = ((p11 - re) * (p11 - other) + im * im) / p21 + p12;
        let rest = [p11 + p22 - re - other, p32];
        let moves = rest[0].abs().max(rest[1].abs()) > IDLE * first.abs();
        (first.is_finite() && moves).then_some([first, rest[0], rest[1]])
    }

    /// One sweep that starts with a given first column.
    fn chase(&mut self, lo: usize, hi: usize, start: [f64; 3]) {
        let (last, end) = (self.last(), self.end(hi));
        for k in lo..hi {
            let size = (hi - k + 1).min(3);
            for j in 0..self.t.len() {
                // The reflector of section j, from column k of the factor before; at section 0 column k - 1.
                let factor = if j == 0 { last } else { j - 1 };
                let column = if j == 0 { k.wrapping_sub(1) } else { k };
                let reflector = if j == 0 && k == lo {
                    Small::new(start).0
                } else {
                    let entries = &mut self.t[factor].col_mut(column)[k..k + size];
                    let mut x = [0.0; 3];
                    x[..size].copy_from_slice(entries);
                    let (reflector, beta) = Small::new(x);
                    entries.fill(0.0);
                    entries[0] = beta;
                    reflector
                };
                let from = if j == 0 { k } else { k + 1 };
                reflector.left(&mut self.t[factor], (k, size), from, end);
                let bottom = if j == last { k + 3 } else { k + 2 };
                self.turn(j, reflector, (k, size), (lo, bottom.min(hi)));
            }
        }
    }

    /// One step without a shift: the Hessenberg factor is made triangular, and what that takes goes round once.
    pub fn unshifted(&mut self, lo: usize, hi: usize) {
        let (last, end) = (self.last(), self.end(hi));
        let mut reflectors: Vec<Small> = Vec::with_capacity(hi - lo);
        for k in lo..hi {
            let h = self.h_mut();
            let (reflector, beta) = Small::new([h.at(k, k), h.at(k + 1, k), 0.0]);
            h.set(k, k, beta);
            h.set(k + 1, k, 0.0);
            reflector.left(h, (k, 2), k + 1, end);
            reflectors.push(reflector);
        }
        for j in 0..last {
            for k in lo..hi {
                let singular = self.t[j].at(k, k) == 0.0;
                self.turn(j, reflectors[k - lo], (k, 2), (lo, k + 1));
                let t = &mut self.t[j];
                // A zero on the diagonal goes one down, exactly: both columns are multiples of one.
                let column = if singular { k + 1 } else { k };
                let (reflector, beta) = Small::new([t.at(k, column), t.at(k + 1, column), 0.0]);
                reflector.left(t, (k, 2), k, end);
                t.set(k, column, beta);
                t.set(k + 1, k, 0.0);
                if singular {
                    t.set(k + 1, k + 1, 0.0);
                }
                reflectors[k - lo] = reflector;
            }
        }
        for k in lo..hi {
            self.turn(last, reflectors[k - lo], (k, 2), (lo, k + 1));
        }
    }
}
