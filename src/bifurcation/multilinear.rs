//! Second and third derivatives of `G(u, v, p)` along complex directions of (u, v).

use crate::linalg::{c64, dot};
use crate::problem::{At, Direction, Problem};

/// A complex direction (q, sigma q) of (u, v).
pub(super) struct Complex {
    pub u: Vec<c64>,
    pub v: Vec<c64>,
}

/// Its real or imaginary part.
pub(super) struct Part {
    u: Vec<f64>,
    v: Vec<f64>,
}

impl Complex {
    /// (q, i omega q).
    pub fn new(q: &[c64], omega: f64) -> Self {
        Self { u: q.to_vec(), v: q.iter().map(|z| z * c64::new(0.0, omega)).collect() }
    }

    pub fn conjugate(&self) -> Self {
        let conj = |z: &[c64]| z.iter().map(|z| z.conj()).collect();
        Self { u: conj(&self.u), v: conj(&self.v) }
    }

    pub fn split(&self) -> [Part; 2] {
        let take = |f: fn(&c64) -> f64| Part { u: self.u.iter().map(f).collect(), v: self.v.iter().map(f).collect() };
        [take(|z| z.re), take(|z| z.im)]
    }
}

impl Part {
    pub fn direction(&self) -> Direction<'_> {
        Direction { u: &self.u, v: &self.v, p: &[] }
    }

    /// Whether the direction is zero, so that derivatives along it need not be computed.
    pub fn vanishes(&self) -> bool {
        dot(&self.u, &self.u) + dot(&self.v, &self.v) == 0.0
    }
}

/// `D²G[a, b]` for complex directions.
pub(super) fn second(problem: &dyn Problem, at: At, a: &Complex, b: &Complex) -> Vec<c64> {
    let mut sum = vec![c64::new(0.0, 0.0); problem.dim()];
    let mut out = vec![0.0; problem.dim()];
    for (i, x) in a.split().iter().enumerate() {
        for (j, y) in b.split().iter().enumerate() {
            if x.vanishes() || y.vanishes() {
                continue;
            }
            problem.derivative(at, &[x.direction(), y.direction()], &mut out);
            let unit = c64::new(0.0, 1.0).powu((i + j) as u32);
            sum.iter_mut().zip(&out).for_each(|(s, &o)| *s += unit * o);
        }
    }
    sum
}

/// `D³G[a, b, c]`.
pub(super) fn third(problem: &dyn Problem, at: At, [a, b, c]: [&Complex; 3]) -> Vec<c64> {
    let mut sum = vec![c64::new(0.0, 0.0); problem.dim()];
    let mut out = vec![0.0; problem.dim()];
    let [a, b, c] = [a, b, c].map(Complex::split);
    for code in 0..8_usize {
        let parts = [&a[code & 1], &b[code >> 1 & 1], &c[code >> 2]];
        if parts.iter().any(|part| part.vanishes()) {
            continue;
        }
        problem.derivative(at, &parts.map(Part::direction), &mut out);
        let unit = c64::new(0.0, 1.0).powu(code.count_ones());
        sum.iter_mut().zip(&out).for_each(|(s, &o)| *s += unit * o);
    }
    sum
}
