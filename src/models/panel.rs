//! A flat panel in supersonic flow, simply supported, in cylindrical bending with stretching, by quasi-steady piston
//! theory (Dowell 1966, doi:10.2514/3.3658). With W = w/h, x in chords, time in sqrt(rho h a^4/D):
//!
//! ```text
//! W_xxxx - (R + k_3 int_0^1 W_x^2 dx) W_xx + lambda W_x + g W_t + W_tt = 0,   W = W_xx = 0 at x = 0, 1.
//! ```
//!
//! W = sum c_k f_k with f_k'' = sqrt(2k + 1) P_k(2x - 1) and f_k(0) = f_k(1) = 0: bending is the identity, and the
//! conditions W_xx = 0 are natural, so that convergence is exponential (sines do not converge so: W_xxxx != 0 at the ends).

use super::rod::{Basis, finer, times};
use super::{ModelError, Options};
use crate::problem::{At, Automatic, Bounds, Formula, Observable, Parameter, Problem, Refinement, Reflection, Scalar};
use faer::Mat;
use std::sync::Arc;

pub struct Panel {
    basis: Basis,
    /// `int f_j f_k`, `int f_j' f_k'`, `int f_j f_k'`.
    mass: Mat<f64>,
    stretch: Mat<f64>,
    flow: Mat<f64>,
    parameters: Vec<Parameter>,
}

const OBSERVABLES: &[Observable] = &[
    Observable { name: "deflection_75", unit: "", meaning: "w/h at three quarters of the chord" },
    Observable { name: "deflection_50", unit: "", meaning: "w/h at half the chord" },
    Observable { name: "tension", unit: "", meaning: "in-plane tension by stretching, k_3 int W_x^2" },
];

/// Positions in the parameter vector.
mod index {
    pub const LAMBDA: usize = 0;
    pub const G: usize = 1;
    pub const R: usize = 2;
    pub const K_3: usize = 3;
}

impl Panel {
    /// From the scene's option `functions`.
    pub fn build(options: &Options) -> Result<Arc<dyn Problem>, ModelError> {
        Ok(Arc::new(Automatic(Self::new(options.integer("functions", 12, 2, 400)?))))
    }

    pub fn new(functions: usize) -> Self {
        use Bounds::{Any, NonNegative};
        let make = |name, value, bounds, meaning| Parameter::new(name, value, "", bounds, meaning);
        let parameters = vec![
            make("lambda", 0.0, NonNegative, "dynamic pressure rho_inf U^2 a^3 / (M D)"),
            make("g", 0.0, NonNegative, "aerodynamic damping; sqrt(lambda mu/M) by piston theory"),
            make("R", 0.0, Any, "in-plane tension N a^2/D; negative in compression"),
            make("k_3", 5.46, NonNegative, "stretching, 6 (1 - nu^2)"),
        ];
        let basis = Basis::new(functions);
        let mean: Vec<f64> = (0..functions).map(|k| mean(&basis, k)).collect();
        let slope = Mat::from_fn(basis.points, functions, |i, k| basis.value[(i, k)] - mean[k]);
        let shape = Mat::from_fn(basis.points, functions, |i, k| basis.integrated_value[(i, k)] - mean[k] * basis.x[i]);
        let product = |a: &Mat<f64>, b: &Mat<f64>| {
            a.transpose() * Mat::from_fn(basis.points, functions, |i, k| basis.w[i] * b[(i, k)])
        };
        let (mass, stretch, flow) = (product(&shape, &shape), product(&slope, &slope), product(&shape, &slope));
        Self { basis, mass, stretch, flow, parameters }
    }

    /// W(x): the slope's integral, the Gauss points squeezed into [0, x].
    fn deflection(&self, c: &[f64], x: f64) -> f64 {
        let basis = &self.basis;
        let inner = basis.total(basis.x.iter().map(|y| basis.psi(c, x * y)));
        let mean: f64 = c.iter().enumerate().map(|(k, c)| c * mean(basis, k)).sum();
        x * (inner - mean)
    }
}

/// `int_0^1 q_k dx`: what the slope q_k must lose for the panel to end where it began.
fn mean(basis: &Basis, k: usize) -> f64 {
    basis.total(basis.value.col_as_slice(k).iter().copied())
}

impl Formula for Panel {
    fn dim(&self) -> usize {
        2 * self.basis.functions
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        use index::{G, K_3, LAMBDA, R};
        let k = self.basis.functions;
        let ((c, rate), (c_t, acceleration)) = (u.split_at(k), v.split_at(k));
        let stretched = times(&self.stretch, c);
        let square = c.iter().zip(&stretched).fold(S::from(0.0), |sum, (&c, &s)| sum + c * s);
        let tension = p[R] + p[K_3] * square;
        let blown = times(&self.flow, c);
        let moved: Vec<S> = acceleration.iter().zip(rate).map(|(&a, &r)| a + p[G] * r).collect();
        let moved = times(&self.mass, &moved);
        for i in 0..k {
            g[i] = c_t[i] - rate[i];
            g[k + i] = c[i] + tension * stretched[i] + p[LAMBDA] * blown[i] + moved[i];
        }
    }

    fn observables(&self) -> &[Observable] {
        OBSERVABLES
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        let c = &at.u[..self.basis.functions];
        match i {
            0 => self.deflection(c, 0.75),
            1 => self.deflection(c, 0.5),
            2 => at.p[index::K_3] * times(&self.stretch, c).iter().zip(c).map(|(s, c)| s * c).sum::<f64>(),
            _ => f64::NAN,
        }
    }

    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection::negation(self.dim()))
    }

    fn picture(&self, u: &[f64], _p: &[f64]) -> Option<Vec<[f64; 2]>> {
        const CELLS: usize = 100;
        let c = &u[..self.basis.functions];
        Some((0..=CELLS).map(|i| i as f64 / CELLS as f64).map(|x| [x, self.deflection(c, x)]).collect())
    }

    fn refined(&self) -> Option<Refinement> {
        Some(finer(self.basis.functions, 2, |more| Arc::new(Automatic(Self::new(more)))))
    }
}
