//! Lorenz' equations `x' = sigma (y - x), y' = x (rho - z) - y, z' = x y - beta z`; parameters rho, sigma, beta.

use super::{hopf_of_pair, parameter};
use hopfline::bifurcation::Hopf;
use hopfline::problem::{At, Automatic, Formula, Observable, Parameter, Problem, Reflection, Scalar};
use std::sync::Arc;

pub struct Lorenz {
    parameters: Vec<Parameter>,
}

impl Lorenz {
    pub fn problem() -> Arc<dyn Problem> {
        let parameters = vec![parameter("rho", 28.0), parameter("sigma", 10.0), parameter("beta", 8.0 / 3.0)];
        Arc::new(Automatic(Self { parameters }))
    }

    /// The Hopf point at rho = 470/19.
    pub fn hopf(problem: &Arc<dyn Problem>) -> Hopf {
        let (rho, beta) = (470.0 / 19.0, 8.0 / 3.0);
        let x = f64::sqrt(beta * (rho - 1.0));
        hopf_of_pair(problem, (&[x, x, rho - 1.0], &[rho, 10.0, beta]), 0, 30.0, 0)
    }
}

impl Formula for Lorenz {
    fn dim(&self) -> usize {
        3
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (x, y, z) = (u[0], u[1], u[2]);
        g[0] = v[0] - p[1] * (y - x);
        g[1] = v[1] - (x * (p[0] - z) - y);
        g[2] = v[2] - (x * y - p[2] * z);
    }

    fn observables(&self) -> &[Observable] {
        const LIST: &[Observable] = &[Observable { name: "x", unit: "", meaning: "" }];
        LIST
    }

    fn observe(&self, i: usize, at: At) -> f64 {
        at.u[i]
    }

    /// (x, y, z) -> (-x, -y, z).
    fn reflection(&self) -> Option<Reflection> {
        Some(Reflection { source: vec![0, 1, 2], sign: vec![-1.0, -1.0, 1.0] })
    }
}
