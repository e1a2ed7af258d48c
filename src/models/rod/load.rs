//! How a distributed load varies along a rod.

use crate::problem::Scalar;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// D = 1.
    Uniform,
    /// D = 1 - exp(-s/s0).
    Distal,
}

impl Load {
    /// D at the points x = s/L; `rate` is L/s0 where there is an s0.
    pub fn profile<S: Scalar>(self, x: &[f64], rate: Option<S>) -> Vec<S> {
        let one = S::from(1.0);
        match rate.filter(|_| self == Load::Distal) {
            Some(rate) => x.iter().map(|&x| one - (-rate * x).exp()).collect(),
            None => vec![one; x.len()],
        }
    }

    /// int_x^1 D at the points x = s/L.
    pub fn beyond<S: Scalar>(self, x: &[f64], rate: Option<S>) -> Vec<S> {
        match rate.filter(|_| self == Load::Distal) {
            Some(rate) => {
                let (end, decay) = ((-rate).exp(), rate.recip());
                x.iter().map(|&x| -((-rate * x).exp() - end) * decay + (1.0 - x)).collect()
            }
            None => x.iter().map(|&x| S::from(1.0 - x)).collect(),
        }
    }
}
