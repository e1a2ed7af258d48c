//! Products of corners of the factors, two or three rows wide, with an exponent of their own so that neither a long
//! product overflows nor its small entries vanish before they have to.

use super::cyclic::{Cyclic, exponent};
use super::dense::Dense;
use faer::c64;

/// `2^exponent` times a matrix of up to three rows and two columns, `m[row][column]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub m: [[f64; 2]; 3],
    pub exponent: i64,
}

impl Corner {
    fn normalise(&mut self) {
        let e = exponent(self.m.iter().flatten().fold(0.0, |most, x| most.max(x.abs())));
        self.exponent += i64::from(e);
        for x in self.m.iter_mut().flatten() {
            *x = scaled(*x, -i64::from(e));
        }
    }

    /// T times this, T the upper triangular corner of size s at i.
    fn times(&mut self, t: &Dense, i: usize, s: usize) {
        for c in 0..2 {
            for r in 0..s {
                self.m[r][c] = (r..s).map(|l| t.at(i + r, i + l) * self.m[l][c]).sum();
            }
        }
        self.normalise();
    }
}

/// `x 2^e`, zero or infinite only where that is what it is.
pub(super) fn scaled(x: f64, e: i64) -> f64 {
    let e = e.clamp(-2400, 2400) as i32;
    let half = e / 2;
    x * f64::from(half).exp2() * f64::from(e - half).exp2()
}

impl Cyclic {
    /// Rows lo .. lo + 2 and columns lo, lo + 1 of the product: what its first two columns are in a block.
    pub fn leading(&self, lo: usize, hi: usize) -> Corner {
        let mut p = Corner { m: [[1.0, 0.0], [0.0, 1.0], [0.0; 2]], exponent: 0 };
        for t in &self.t[..self.last()] {
            p.times(t, lo, 2);
        }
        let (h, x) = (self.h(), p.m);
        for (r, row) in p.m.iter_mut().enumerate() {
            for (c, out) in row.iter_mut().enumerate() {
                let below = lo + r > hi;
                *out = if below { 0.0 } else { h.at(lo + r, lo) * x[0][c] + h.at(lo + r, lo + 1) * x[1][c] };
            }
        }
        p.m[2][0] = 0.0;
        p.normalise();
        p
    }

    /// The product's last two rows and columns in the block lo .. hi, in rows 0 and 1 of the result.
    pub fn trailing(&self, lo: usize, hi: usize) -> Corner {
        let size = (hi - lo + 1).min(3);
        let top = hi + 1 - size;
        let mut m = [[0.0; 2]; 3];
        (m[size - 2][0], m[size - 1][1]) = (1.0, 1.0);
        let mut p = Corner { m, exponent: 0 };
        for t in &self.t[..self.last()] {
            p.times(t, top, size);
        }
        let (h, x) = (self.h(), p.m);
        p.m = [[0.0; 2]; 3];
        for (r, row) in p.m.iter_mut().enumerate().take(2) {
            for (c, out) in row.iter_mut().enumerate() {
                *out = (0..size).map(|l| h.at(hi - 1 + r, top + l) * x[l][c]).sum();
            }
        }
        p.normalise();
        p
    }
}

/// Eigenvalues of the upper two rows, without the exponent: complex ones with im > 0 first, of real ones the larger.
pub(super) fn eigenvalues([[a, b], [c, d], _]: &[[f64; 2]; 3]) -> [c64; 2] {
    let (mean, half) = ((a + d) / 2.0, (a - d) / 2.0);
    let square = half * half + b * c;
    if square < 0.0 {
        let im = (-square).sqrt();
        return [c64::new(mean, im), c64::new(mean, -im)];
    }
    let large = mean + square.sqrt().copysign(mean);
    let small = if large == 0.0 { 0.0 } else { (a * d - b * c) / large };
    [c64::new(large, 0.0), c64::new(small, 0.0)]
}
