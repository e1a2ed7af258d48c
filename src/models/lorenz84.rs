//! The extended Lorenz-84 model of atmospheric circulation: four equations whose equilibria have every bifurcation of
//! codimension two.
//!
//! ```text
//! X' = -Y² - Z² - alpha X + alpha F - gamma U²,     Y' = X Y - beta X Z - Y + G,
//! Z' = beta X Y + X Z - Z,                          U' = -delta U + gamma U X + T.
//! ```
//!
//! (Shilnikov, Nicolis and Nicolis 1995, doi:10.1142/S0218127495001253, for U = 0; Kuznetsov, Meijer, Govaerts and
//! Sautois 2008, doi:10.1016/j.physd.2008.06.006, for the extension.)

use super::{ModelError, Options};
use crate::problem::{At, Automatic, Bounds, Formula, Observable, Parameter, Problem, Scalar};
use std::sync::Arc;

/// The model; all numbers are pure.
pub struct Lorenz84 {
    parameters: Vec<Parameter>,
}

const OBSERVABLES: &[Observable] = &[
    Observable { name: "X", unit: "", meaning: "westerly current" },
    Observable { name: "Y", unit: "", meaning: "cosine phase of eddies" },
    Observable { name: "Z", unit: "", meaning: "sine phase of eddies" },
    Observable { name: "U", unit: "", meaning: "second current" },
];

impl Lorenz84 {
    pub fn build(_: &Options) -> Result<Arc<dyn Problem>, ModelError> {
        let make = |name, value, meaning| Parameter::new(name, value, "", Bounds::Any, meaning);
        let parameters = vec![
            make("alpha", 0.25, "damping of the current"),
            make("beta", 1.0, "displacement of eddies"),
            make("gamma", 0.987, "coupling of the second current"),
            make("delta", 1.04, "damping of the second current"),
            make("G", 0.25, "asymmetric forcing"),
            make("F", 3.0, "symmetric forcing"),
            make("T", 0.04, "forcing of the second current"),
        ];
        Ok(Arc::new(Automatic(Self { parameters })))
    }
}

impl Formula for Lorenz84 {
    fn dim(&self) -> usize {
        4
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let [x, y, z, w] = [u[0], u[1], u[2], u[3]];
        let [alpha, beta, gamma, delta, forcing_g, forcing_f, forcing_t] = [p[0], p[1], p[2], p[3], p[4], p[5], p[6]];
        g[0] = v[0] + y * y + z * z + alpha * x - alpha * forcing_f + gamma * w * w;
        g[1] = v[1] - x * y + beta * x * z + y - forcing_g;
        g[2] = v[2] - beta * x * y - x * z + z;
        g[3] = v[3] + delta * w - gamma * w * x - forcing_t;
    }

    fn unknowns(&self) -> Vec<String> {
        ["X", "Y", "Z", "U"].map(str::to_owned).to_vec()
    }

    /// The state of strong westerly current: exact for G = T = 0.
    fn start(&self, p: &[f64]) -> Vec<f64> {
        vec![p[5], 0.0, 0.0, 0.0]
    }

    fn observables(&self) -> &[Observable] {
        OBSERVABLES
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        at.u[i]
    }
}
