//! Integrals of many functions at once, with half the work of the full matrix.
//!
//! The Gauss points lie symmetrically about the middle. Integration from there makes even functions odd and odd ones
//! even; so with E = g(x) + g(1 - x) and O = g(x) - g(1 - x) at the points of the first half (E = g in the middle),
//!
//! ```text
//! int_0^x g = kappa + K_o O + K_e E,    int_0^(1-x) g = kappa + K_o O - K_e E,    kappa = 1/2 int_0^1 g.
//! ```

use faer::linalg::matmul::matmul;
use faer::reborrow::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// The antiderivative for functions in rows and Gauss points in columns.
pub struct Halves {
    /// K_o, transposed; its rows in the order of the second half's points.
    from_odd: Mat<f64>,
    /// K_e, transposed, its columns in that order; one more makes kappa.
    from_even: Mat<f64>,
}

impl Halves {
    /// From the matrix of the antiderivative and the weights.
    pub(super) fn new(integral: &Mat<f64>, w: &[f64]) -> Self {
        let points = w.len();
        let (half, rest) = (points.div_ceil(2), points / 2);
        let image = |i: usize| points - 1 - i;
        // From the part of one parity at point j to the part of the other at point i.
        let part = |i: usize, j: usize, parity: f64| {
            let at = |i| integral[(i, j)] + parity * integral[(i, image(j))];
            0.25 * (at(i) - parity * at(image(i)))
        };
        let from_odd = Mat::from_fn(rest, half, |j, i| part(i, image(half + j), -1.0));
        let from_even =
            Mat::from_fn(half, rest + 1, |j, i| if i == rest { 0.5 * w[j] } else { part(image(half + i), j, 1.0) });
        Self { from_odd, from_even }
    }

    /// The integrals from 0 to each point, and in one column more kappa. The functions are overwritten.
    #[inline(always)] // for the vector unit that the caller is compiled for
    pub fn integrate(&self, functions: &mut Mat<f64>, integrals: &mut Mat<f64>) {
        let (rest, half) = self.from_odd.shape();
        let (mut even, mut odd) = functions.as_mut().split_at_col_mut(half);
        for i in 0..rest {
            let parts = slice_mut(even.rb_mut(), i).iter_mut().zip(slice_mut(odd.rb_mut(), rest - 1 - i));
            parts.for_each(|(g, image)| (*g, *image) = (*g + *image, *g - *image));
        }
        let (mut values, mut images) = integrals.as_mut().split_at_col_mut(half);
        matmul(values.rb_mut(), Accum::Replace, odd, &self.from_odd, 1.0, Par::Seq);
        matmul(images.rb_mut(), Accum::Replace, even, &self.from_even, 1.0, Par::Seq);
        let (mut images, kappa) = images.split_at_col_mut(rest);
        let kappa = slice(kappa.as_ref(), 0);
        for i in 0..half {
            slice_mut(values.rb_mut(), i).iter_mut().zip(kappa).for_each(|(value, kappa)| *value += kappa);
        }
        for i in 0..rest {
            let parts = slice_mut(values.rb_mut(), i).iter_mut().zip(slice_mut(images.rb_mut(), rest - 1 - i));
            parts.for_each(|(even, odd)| (*even, *odd) = (*even + *odd, *even - *odd));
        }
    }
}

/// Column j of a matrix stored by columns.
#[inline(always)]
pub fn slice(a: MatRef<'_, f64>, j: usize) -> &[f64] {
    a.col(j).try_as_col_major().expect("contiguous columns").as_slice()
}

/// The same, to be written.
#[inline(always)]
pub fn slice_mut(a: MatMut<'_, f64>, j: usize) -> &mut [f64] {
    a.col_mut(j).try_as_col_major_mut().expect("contiguous columns").as_slice_mut()
}

#[cfg(test)]
mod tests {
    use super::super::basis::Basis;
    use faer::Mat;

    #[test]
    fn halves_integrate_as_the_matrix_does() {
        for functions in [7, 8] {
            let basis = Basis::new(functions);
            let mut values = Mat::from_fn(3, basis.points, |k, i| ((k + 1) as f64 * (1.0 + basis.x[i]).powi(3)).sin());
            let expected = &values * basis.integral.transpose();
            let totals: Vec<f64> = (0..3).map(|k| basis.total(values.row(k).iter().copied())).collect();
            let mut integrals = Mat::zeros(3, basis.points + 1);
            basis.halves.integrate(&mut values, &mut integrals);
            for k in 0..3 {
                for i in 0..basis.points {
                    assert!((integrals[(k, i)] - expected[(k, i)]).abs() < 1e-15);
                }
                assert!((2.0 * integrals[(k, basis.points)] - totals[k]).abs() < 1e-15);
            }
        }
    }
}
