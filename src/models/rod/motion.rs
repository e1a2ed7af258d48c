//! Directions and velocities of a rod of unit length.

use super::basis::{Basis, times, times_both};
use crate::problem::Scalar;

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
        let turning = |n: &[S]| psi_t.iter().zip(n).map(|(&a, &n)| a * n).collect::<Vec<S>>();
        let [mut v_x, v_y] = times_both(&basis.integral, [&turning(&sine), &turning(&cosine)]);
        v_x.iter_mut().for_each(|v| *v = -*v);
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
