//! Cycles with exactly known normal forms.

use super::common::{close, near, parameter};
use super::coordinate;
use hopfline::continuation::Counts;
use hopfline::orbit::bifurcations::{Critical, CriticalCycle, CycleNormalForm};
use hopfline::orbit::{Collocation, Frame, Orbit, Points, Scheme};
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Reflection, Scalar};
use std::f64::consts::TAU;
use std::sync::Arc;

/// How the equations are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    Plain,
    Mass,
    Algebraic,
}

/// A cycle of radius 1 in the plane (x, y) whose normal form is known, with everything around it in the coordinates
/// `r = 1 + rho`, s, w:
///
/// ```text
/// flip    dA/dt = mu A + c A³ + m A w,   dB/dt = -B,   (rho, s) = A e(phi/2) + B e'(phi/2),   w' = feed - w + w² + q A²,
/// torus   Z = rho + i s,   dZ/dt = (mu + i omega) Z + (c + i) Z |Z|² + m Z w,   w' = -decay w + q |Z|²,
/// fold    drho/dt = mu + linear rho + c rho² - cubic rho³,   s' = -s,   w' = -decay w + q rho²,   dphi/dt = 1 - 0.4 rho,
/// ```
///
/// with `dphi/dt = 1 + k (squared amplitude)`. With no feed w = q A² + ... on the centre manifold, so that the cubic coefficients are
/// c + m q. All of it may be multiplied by a matrix that depends on the
/// state, or have r² as an algebraic unknown.
struct Exact {
    kind: Critical,
    form: Form,
    list: Vec<Parameter>,
}

pub const C: f64 = -0.7;
pub const M: f64 = 0.9;
const Q: f64 = 0.6;
const K: f64 = 0.3;
pub const OMEGA: f64 = 0.37;

impl Formula for Exact {
    fn dim(&self) -> usize {
        if self.form == Form::Algebraic { 5 } else { 4 }
    }

    fn parameters(&self) -> &[Parameter] {
        &self.list
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (x, y, s, w) = (u[0], u[1], u[2], u[3]);
        let [mu, q, omega, linear, cubic, feed] = [p[0], p[1], p[2], p[3], p[4], p[5]];
        let distance = x * x + y * y;
        let r = if self.form == Form::Algebraic { u[4] } else { distance }.sqrt();
        let (cosine, sine, rho) = (x / r, y / r, r - 1.0);
        let (turning, rho_rate, s_rate, square);
        match self.kind {
            Critical::Flip => {
                // The part of (rho, s) along e(phi/2).
                let a_rho = (rho * (cosine + 1.0) + s * sine) * 0.5;
                let a_s = (rho * sine + s * (-cosine + 1.0)) * 0.5;
                square = a_rho * a_rho + a_s * a_s;
                turning = square * K + 1.0;
                let growth = mu + square * C + w * M + 1.0;
                // e(phi/2) turns at half the rate.
                rho_rate = a_rho * growth - rho - s * turning * 0.5;
                s_rate = a_s * growth - s + rho * turning * 0.5;
            }
            Critical::Torus => {
                square = rho * rho + s * s;
                turning = square * K + 1.0;
                let growth = mu + square * C + w * M;
                rho_rate = rho * growth - s * (square + omega);
                s_rate = s * growth + rho * (square + omega);
            }
            Critical::Fold => {
                square = rho * rho;
                turning = -rho * 0.4 + 1.0;
                rho_rate = mu + linear * rho + square * C - square * rho * cubic;
                s_rate = -s;
            }
        }
        let rates =
            [rho_rate * cosine - y * turning, rho_rate * sine + x * turning, s_rate, square * q + feed - w + w * w];
        for i in 0..4 {
            g[i] = v[i] - rates[i];
        }
        match self.form {
            Form::Plain => {}
            Form::Mass => {
                let [a, b, c, d] = [g[0], g[1], g[2], g[3]];
                (g[0], g[1]) = (a * (x * x + 2.0) + b * y.sin(), b * (x * 0.3).exp() - d * s);
                (g[2], g[3]) = (c + a * x * 0.5, d + c * y * 0.4);
            }
            Form::Algebraic => g[4] = u[4] - distance,
        }
    }
}

/// The unit circle at mu = `mu`, with the multipliers that its equations have.
pub fn exact(kind: Critical, form: Form, mu: f64) -> (Frame, Orbit) {
    let p = vec![mu, Q, OMEGA, 0.0, 1.0, 0.0];
    let names = ["mu", "q", "omega", "linear", "cubic", "feed"];
    let list = names.iter().zip(&p).map(|(name, &value)| parameter(name, value)).collect();
    let problem: Arc<dyn Problem> = Arc::new(Automatic(Exact { kind, form, list }));
    let dim = problem.dim();
    // An algebraic unknown needs the ends of intervals among the collocation points.
    let points = if form == Form::Algebraic { Points::Radau } else { Points::Gauss };
    let (intervals, degree) = (16, 6);
    let scheme = Scheme::new(points, degree);
    let mut nodes = Vec::new();
    for i in 0..=intervals * degree {
        let phi = TAU * ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
        nodes.extend_from_slice(&[phi.cos(), phi.sin(), 0.0, 0.0, 1.0][..dim]);
    }
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    let orbit = Orbit { mesh, points, degree, nodes, dim, part: TAU, parts: 1, drift: Vec::new() };
    let symmetry = Reflection::identity(dim);
    let (scale_state, scale_part, scale_lambda) = (1.0, TAU, 1.0);
    (Frame { problem, p, free: 0, symmetry, parts: 1, scale_state, scale_part, scale_lambda }, orbit)
}

#[test]
fn normal_forms_are_exact_with_any_mass() {
    // The mean square of the critical function as it stands above: e, (1/2)(e_rho -+ i e_s), e_rho; an algebraic unknown
    // r² adds the square of 2 rho.
    let cubic = C + M * Q;
    for (kind, coefficient, square, more) in
        [(Critical::Flip, cubic, 1.0, 2.0), (Critical::Torus, cubic, 0.5, 1.0), (Critical::Fold, C, 1.0, 4.0)]
    {
        for form in [Form::Plain, Form::Mass, Form::Algebraic] {
            let (frame, orbit) = exact(kind, form, 0.01);
            let system = Collocation::new(frame, &orbit);
            let cosine = (TAU * OMEGA + 0.01).cos();
            let (cycle, x) =
                CriticalCycle::new(&system, (&orbit, &system.frame.p), (kind, cosine), &[coordinate(0, 1.0)])
                    .expect("borders");
            let x = cycle.solve(x, &mut Counts::default()).expect("a critical cycle");
            near("mu", cycle.parameters(&x)[0], 0.0, 1e-10);
            close("T", cycle.orbit(&x).part, TAU, 1e-10);
            if kind == Critical::Torus {
                near("cos(theta)", cycle.cosine(&x).expect("an angle"), (TAU * OMEGA).cos(), 1e-9);
            }
            let found = CycleNormalForm::new(&cycle, &x).expect("a normal form");
            let size: f64 = if form == Form::Algebraic { square + more } else { square };
            // v points to longer periods, and those are at larger rho.
            let expected = if kind == Critical::Fold { coefficient / size.sqrt() } else { coefficient / size };
            close("coefficient", found.coefficient.re, expected, 1e-8);
        }
    }
}
