//! Directions, velocities and displacements of a rod of unit length.

use super::basis::{Basis, times};
use super::linearisation::product;
use crate::problem::Scalar;
use faer::Mat;

/// Directions and velocities at the Gauss points.
pub struct Motion<S> {
    pub sine: Vec<S>,
    pub cosine: Vec<S>,
    /// `int_0^x psi_t n`.
    pub v_x: Vec<S>,
    pub v_y: Vec<S>,
}

impl<S: Scalar> Motion<S> {
    /// From the angles and their rates at the Gauss points.
    pub fn new(basis: &Basis, psi: &[S], psi_t: &[S]) -> Self {
        let (sine, cosine): (Vec<S>, Vec<S>) = psi.iter().map(|a| a.sin_cos()).unzip();
        let v_x = times(&basis.integral, &psi_t.iter().zip(&sine).map(|(&a, &s)| -a * s).collect::<Vec<_>>());
        let v_y = times(&basis.integral, &psi_t.iter().zip(&cosine).map(|(&a, &c)| a * c).collect::<Vec<_>>());
        Self { sine, cosine, v_x, v_y }
    }

    /// The velocity along t and n at Gauss point i.
    pub fn resolved(&self, i: usize) -> [S; 2] {
        let (s, c) = (self.sine[i], self.cosine[i]);
        [self.v_x[i] * c + self.v_y[i] * s, self.v_y[i] * c - self.v_x[i] * s]
    }

    /// `sum_i w_i q_k(x_i) n . F_i` for every function q_k: the virtual work of forces of which `beyond` is F, already
    /// times the weights, less the `moment` per length, not yet so.
    pub fn tested(&self, basis: &Basis, [x, y]: [&[S]; 2], moment: Option<&[S]>) -> Vec<S> {
        let mut tested: Vec<S> = (0..basis.points).map(|i| self.cosine[i] * y[i] - self.sine[i] * x[i]).collect();
        if let Some(moment) = moment {
            tested.iter_mut().zip(moment.iter().zip(&basis.w)).for_each(|(t, (&m, &w))| *t -= m * w);
        }
        times(&basis.value_transposed, &tested)
    }
}

/// Columns for all functions q, rows for Gauss points, along t in the upper half and along n in the lower one.
pub struct Variation {
    /// The displacement `int_0^x q n`; of the velocity, too, where q is a rate.
    pub displacement: Mat<f64>,
    /// The change `-int_0^x psi_t t q` of the velocity at given rates; None at rest.
    pub velocity: Option<Mat<f64>>,
}

impl Variation {
    pub fn new(basis: &Basis, motion: &Motion<f64>, psi_t: &[f64], moving: bool) -> Self {
        let (k, m) = (basis.functions, basis.points);
        let (s, c) = (&motion.sine, &motion.cosine);
        let mut factors: Vec<Vec<f64>> = vec![s.iter().map(|s| -s).collect(), c.clone()];
        if moving {
            factors.push(c.iter().zip(psi_t).map(|(c, v)| -c * v).collect());
            factors.push(s.iter().zip(psi_t).map(|(s, v)| -s * v).collect());
        }
        let mut integrand = Mat::zeros(m, factors.len() * k);
        for (part, factor) in factors.iter().enumerate() {
            for j in 0..k {
                let column = integrand.col_as_slice_mut(part * k + j);
                for ((out, f), b) in column.iter_mut().zip(factor).zip(basis.value.col_as_slice(j)) {
                    *out = f * b;
                }
            }
        }
        let moved = product(basis.integral.as_ref(), integrand.as_ref());
        let turned = |part: usize| {
            let mut out = Mat::zeros(2 * m, k);
            for j in 0..k {
                let (x, y) = (moved.col_as_slice(part * k + j), moved.col_as_slice((part + 1) * k + j));
                let (t, n) = out.col_as_slice_mut(j).split_at_mut(m);
                for (((t, n), (x, y)), (s, c)) in t.iter_mut().zip(n).zip(x.iter().zip(y)).zip(s.iter().zip(c)) {
                    (*t, *n) = (c * x + s * y, c * y - s * x);
                }
            }
            out
        };
        Self { displacement: turned(0), velocity: moving.then(|| turned(2)) }
    }
}
