//! The Brusselator on a line, by second-order differences at `points` interior points:
//!
//! ```text
//! u' = Dx u_xx / L² + u² v - (B + 1) u + A,    v' = Dy v_xx / L² - u² v + B u,    u = A, v = B/A at the ends,
//! ```
//!
//! unknowns u_1, v_1, u_2, v_2, ...; A = 2, B = 5.45, Dx = 0.008, Dy = 0.004, free parameter L.

use super::{hopf_of_pair, parameter};
use hopfline::bifurcation::Hopf;
use hopfline::linalg::Structure;
use hopfline::problem::{At, Automatic, Formula, Observable, Parameter, Problem, Scalar};
use std::f64::consts::PI;
use std::sync::Arc;

const A: f64 = 2.0;
const B: f64 = 5.45;
const DX: f64 = 0.008;
const DY: f64 = 0.004;

pub struct Brusselator {
    points: usize,
    structure: Structure,
    parameters: Vec<Parameter>,
}

impl Brusselator {
    pub fn chain(points: usize, banded: bool) -> Arc<dyn Problem> {
        let structure = if banded { Structure::Banded { lower: 2, upper: 2 } } else { Structure::Dense };
        Arc::new(Automatic(Self { points, structure, parameters: vec![parameter("L", 0.4)] }))
    }

    /// L at the first Hopf point: exact.
    pub fn onset(points: usize) -> f64 {
        let n = (points + 1) as f64;
        let m = 4.0 * n * n * (PI / (2.0 * n)).sin().powi(2);
        ((DX + DY) * m / (B - 1.0 - A * A)).sqrt()
    }

    /// The first Hopf point, solved for from its exact place.
    pub fn hopf(problem: &Arc<dyn Problem>) -> Hopf {
        let n = problem.dim();
        hopf_of_pair(problem, (&problem.start(&[0.0]), &[Self::onset(n / 2)]), 0, 20.0, 0)
    }
}

impl Formula for Brusselator {
    fn dim(&self) -> usize {
        2 * self.points
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn structure(&self) -> Structure {
        self.structure.clone()
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let n = self.points;
        let scale = p[0].powi(-2) * ((n + 1) * (n + 1)) as f64;
        for i in 0..n {
            let (x, y) = (u[2 * i], u[2 * i + 1]);
            let side = |k: usize, end: f64| {
                let left = if i == 0 { S::from(end) } else { u[2 * i - 2 + k] };
                let right = if i + 1 == n { S::from(end) } else { u[2 * i + 2 + k] };
                (left + right - u[2 * i + k] * 2.0) * scale
            };
            let reaction = x * x * y;
            g[2 * i] = v[2 * i] - (side(0, A) * DX + reaction - x * (B + 1.0) + A);
            g[2 * i + 1] = v[2 * i + 1] - (side(1, B / A) * DY - reaction + x * B);
        }
    }

    fn start(&self, _: &[f64]) -> Vec<f64> {
        [A, B / A].repeat(self.points)
    }

    fn observables(&self) -> &[Observable] {
        const LIST: &[Observable] = &[Observable { name: "middle", unit: "", meaning: "u in the middle" }];
        LIST
    }

    fn observe(&self, _: usize, at: At) -> f64 {
        at.u[2 * (self.points / 2)]
    }
}
