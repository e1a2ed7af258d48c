//! Hopf points and first Lyapunov coefficients against closed forms.
//!
//! Here c1 is the coefficient in `z' = i omega z + c1 z |z|²` for `u = u_0 + z q + zbar qbar + ...` with `q^H q = 1`, and
//! `l1 = Re c1 / omega` (Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, section 5.4). A change of coordinates only
//! changes the length of q: with `q -> Q q`, `c1 -> c1 / |Q q|²`.
//!
//! Derivatives are exact and Newton's method goes on to rounding, so tolerances are 1e-11 and below: some hundred
//! roundings of 2e-16, magnified by the condition of systems with entries of different sizes.

mod common;

use common::{close, close_complex, hopf_of_pair, near, parameter};
use hopfline::bifurcation::{Hopf, HopfNormalForm};
use hopfline::linalg::c64;
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Scalar};
use proptest::prelude::*;
use std::sync::Arc;

const EXACT: f64 = 1e-11;

/// A right-hand side `w' = f(w, p)`.
trait Field: Send + Sync + Clone + 'static {
    const DIM: usize;
    fn field<S: Scalar>(&self, w: &[S], p: &[S]) -> Vec<S>;
}

/// How a field is written as `G(u, u', p) = 0`.
#[derive(Clone, Copy, Debug)]
enum Dress {
    /// `u' = f(u)`.
    Plain,
    /// `K(u) u' = K(u) f(u)` with an invertible matrix K(u), neither symmetric nor constant.
    Multiplied,
    /// `Psi'(u) u' = f(Psi(u))`: the field in coordinates u with `w = Psi(u)`.
    Changed,
    /// `w' = f(w) + chi - w_0 w_1, 0 = chi - w_0 w_1`: an algebraic unknown, a singular mass.
    Algebraic,
    /// `w'/s = f(w)`: another unit of time.
    Faster(f64),
}

struct Dressed<F> {
    field: F,
    dress: Dress,
    parameters: Vec<Parameter>,
    start: Vec<f64>,
}

/// `Psi(u)`: `w_i = u_i + 0.4 sin u_j`, j the next index.
fn psi<S: Scalar>(u: &[S]) -> Vec<S> {
    (0..u.len()).map(|i| u[i] + u[(i + 1) % u.len()].sin() * 0.4).collect()
}

/// `Psi'(u) v`.
fn psi_slope<S: Scalar>(u: &[S], v: &[S]) -> Vec<S> {
    let next = |i: usize| (i + 1) % u.len();
    (0..u.len()).map(|i| v[i] + u[next(i)].cos() * v[next(i)] * 0.4).collect()
}

/// `K(u) x`: `2 x_i + sin(u_i) x_j / 2 + (u_0 u_1) x_k / 10`, j the next index and k the one before.
fn multiply<S: Scalar>(u: &[S], x: &[S]) -> Vec<S> {
    let n = u.len();
    (0..n).map(|i| x[i] * 2.0 + u[i].sin() * x[(i + 1) % n] * 0.5 + u[0] * u[1] * x[(i + n - 1) % n] * 0.1).collect()
}

impl<F: Field> Formula for Dressed<F> {
    fn dim(&self) -> usize {
        F::DIM + usize::from(matches!(self.dress, Dress::Algebraic))
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn start(&self, _p: &[f64]) -> Vec<f64> {
        self.start.clone()
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let n = F::DIM;
        match self.dress {
            Dress::Plain | Dress::Faster(_) => {
                let unit = if let Dress::Faster(s) = self.dress { 1.0 / s } else { 1.0 };
                let f = self.field.field(u, p);
                (0..n).for_each(|i| g[i] = v[i] * unit - f[i]);
            }
            Dress::Multiplied => {
                let (a, b) = (multiply(u, v), multiply(u, &self.field.field(u, p)));
                (0..n).for_each(|i| g[i] = a[i] - b[i]);
            }
            Dress::Changed => {
                let (a, b) = (psi_slope(u, v), self.field.field(&psi(u), p));
                (0..n).for_each(|i| g[i] = a[i] - b[i]);
            }
            Dress::Algebraic => {
                let constraint = u[n] - u[0] * u[1];
                let f = self.field.field(&u[..n], p);
                (0..n).for_each(|i| g[i] = v[i] - f[i] - constraint);
                g[n] = constraint;
            }
        }
    }
}

/// The Hopf point and its normal form, from an equilibrium at p near it.
fn solve<F: Field>(field: &F, dress: Dress, (w, p): (&[f64], &[f64])) -> (Hopf, HopfNormalForm) {
    let start = match dress {
        Dress::Algebraic => [w, &[w[0] * w[1]]].concat(),
        Dress::Changed => inverse_psi(w),
        _ => w.to_vec(),
    };
    let names = ["p0", "p1", "p2"];
    let parameters = p.iter().zip(names).map(|(&p, name)| parameter(name, p)).collect();
    let problem: Arc<dyn Problem> =
        Arc::new(Automatic(Dressed { field: field.clone(), dress, parameters, start: start.clone() }));
    let hopf = hopf_of_pair(&problem, (&start, p), 0, 100.0, 0);
    let form = HopfNormalForm::new(&*problem, &hopf).expect("a normal form");
    (hopf, form)
}

/// `Psi(u) = w` by fixed-point iteration, near enough for a start.
fn inverse_psi(w: &[f64]) -> Vec<f64> {
    let mut u = w.to_vec();
    for _ in 0..200 {
        let image = psi(&u);
        (0..u.len()).for_each(|i| u[i] -= 0.3 * (image[i] - w[i]));
    }
    u
}

/// `z' = (mu + i omega) z + (alpha + i beta) z |z|²` with z = x + i y.
#[derive(Clone)]
struct NormalForm {
    alpha: f64,
    beta: f64,
    omega: f64,
}

impl Field for NormalForm {
    const DIM: usize = 2;
    fn field<S: Scalar>(&self, w: &[S], p: &[S]) -> Vec<S> {
        let (x, y) = (w[0], w[1]);
        let r2 = x * x + y * y;
        vec![
            p[0] * x - y * self.omega + (x * self.alpha - y * self.beta) * r2,
            x * self.omega + p[0] * y + (y * self.alpha + x * self.beta) * r2,
        ]
    }
}

#[test]
fn the_normal_form_gives_back_its_own_coefficients() {
    // q = (1, -i)/sqrt 2, so z = sqrt 2 times the amplitude along q: c1 = 2 (alpha + i beta); the circle of radius
    // sqrt(-mu/alpha) turns at omega + beta r².
    for (alpha, beta, omega) in [(-1.0, 0.5, 1.0), (0.3, -2.0, 7.0), (-20.0, 0.0, 0.1)] {
        let (hopf, form) = solve(&NormalForm { alpha, beta, omega }, Dress::Plain, (&[0.0, 0.0], &[0.05]));
        near("p", hopf.p[0], 0.0, EXACT);
        close("omega", hopf.omega, omega, EXACT);
        close_complex("slope", hopf.slope, c64::new(1.0, 0.0), EXACT);
        close_complex("c1", form.c1, c64::new(2.0 * alpha, 2.0 * beta), EXACT);
        close("l1", form.l1, 2.0 * alpha / omega, EXACT);
        close("p2", form.p2, -2.0 * alpha, EXACT);
        near("omega2", form.omega2, 2.0 * beta, EXACT);
    }
}

#[test]
fn newton_may_start_where_the_parameter_is_zero() {
    // mu = e^p - 20: the Hopf point is at p = ln 20, three steps of order one away.
    #[derive(Clone)]
    struct Shifted;
    impl Field for Shifted {
        const DIM: usize = 2;
        fn field<S: Scalar>(&self, w: &[S], p: &[S]) -> Vec<S> {
            NormalForm { alpha: -1.0, beta: 0.0, omega: 3.0 }.field(w, &[p[0].exp() - 20.0])
        }
    }
    let (hopf, _) = solve(&Shifted, Dress::Plain, (&[0.0, 0.0], &[0.0]));
    close("p", hopf.p[0], 20.0_f64.ln(), EXACT);
}

/// `x' = mu x - omega y + f, y' = omega x + mu y + g` with all quadratic and cubic terms.
#[derive(Clone, Debug)]
struct Planar {
    omega: f64,
    /// Coefficients of x², xy, y², x³, x²y, xy², y³ in f and g.
    f: [f64; 7],
    g: [f64; 7],
}

impl Planar {
    /// Guckenheimer and Holmes (1983, doi:10.1007/978-1-4612-1140-2, 3.4.11): r' = a r³ in the radius of (x, y).
    fn a(&self) -> f64 {
        let ([fxx, fxy, fyy], [gxx, gxy, gyy]) =
            ([2.0 * self.f[0], self.f[1], 2.0 * self.f[2]], [2.0 * self.g[0], self.g[1], 2.0 * self.g[2]]);
        let cubic = 6.0 * self.f[3] + 2.0 * self.f[5] + 2.0 * self.g[4] + 6.0 * self.g[6];
        let quadratic = fxy * (fxx + fyy) - gxy * (gxx + gyy) - fxx * gxx + fyy * gyy;
        (cubic + quadratic / self.omega) / 16.0
    }
}

impl Field for Planar {
    const DIM: usize = 2;
    fn field<S: Scalar>(&self, w: &[S], p: &[S]) -> Vec<S> {
        let (x, y) = (w[0], w[1]);
        let terms = [x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
        let sum = |c: &[f64; 7]| terms.iter().zip(c).fold(S::from(0.0), |sum, (&t, &c)| sum + t * c);
        vec![p[0] * x - y * self.omega + sum(&self.f), x * self.omega + p[0] * y + sum(&self.g)]
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn planar_systems_obey_the_formula_of_guckenheimer_and_holmes(
        omega in 0.5..5.0,
        f in proptest::array::uniform7(-2.0..2.0),
        g in proptest::array::uniform7(-2.0..2.0),
    ) {
        let planar = Planar { omega, f, g };
        let (_, form) = solve(&planar, Dress::Plain, (&[0.0, 0.0], &[0.01]));
        // Coefficients of size ten may cancel in a: an absolute tolerance.
        near("Re c1", form.c1.re, 2.0 * planar.a(), 1e-10);
    }
}

#[derive(Clone)]
struct Lorenz;

const SIGMA: f64 = 10.0;
const BETA: f64 = 8.0 / 3.0;
const RHO_H: f64 = 470.0 / 19.0;
/// Evaluated apart from this code by the projection formula in numpy (eigenvectors of A and A^T, explicit B(a, b)).
const LORENZ_C1: c64 = c64::new(0.002555495334118459, -0.02765775716948505);

impl Field for Lorenz {
    const DIM: usize = 3;
    fn field<S: Scalar>(&self, w: &[S], p: &[S]) -> Vec<S> {
        let (x, y, z) = (w[0], w[1], w[2]);
        vec![(y - x) * SIGMA, x * (p[0] - z) - y, x * y - z * BETA]
    }
}

fn lorenz_start() -> [f64; 3] {
    let rho: f64 = 24.0;
    let x = (BETA * (rho - 1.0)).sqrt();
    [x, x, rho - 1.0]
}

#[test]
fn lorenz_loses_stability_subcritically_at_470_over_19() {
    let (hopf, form) = solve(&Lorenz, Dress::Plain, (&lorenz_start(), &[24.0]));
    close("rho", hopf.p[0], RHO_H, EXACT);
    close("omega", hopf.omega, (BETA * (RHO_H + SIGMA)).sqrt(), EXACT);
    // The period is known to 14 digits.
    close("T0", std::f64::consts::TAU / hopf.omega, 0.65283034762051, 2e-14);
    // Derivative of the root of s³ + (sigma + b + 1) s² + b (rho + sigma) s + 2 sigma b (rho - 1).
    let s = c64::new(0.0, hopf.omega);
    let slope =
        -(s * BETA + 2.0 * SIGMA * BETA) / (s * s * 3.0 + s * (2.0 * (SIGMA + BETA + 1.0)) + BETA * (RHO_H + SIGMA));
    close_complex("d sigma / d rho", hopf.slope, slope, EXACT);
    // The reference in double precision has some 12 digits.
    close_complex("c1", form.c1, LORENZ_C1, 1e-10);
    assert!(form.l1 > 0.0);
}

/// `X' = A - (B + 1) X + X² Y, Y' = B X - X² Y` with (B, A) the parameters.
#[derive(Clone)]
struct Brusselator;

impl Field for Brusselator {
    const DIM: usize = 2;
    fn field<S: Scalar>(&self, w: &[S], p: &[S]) -> Vec<S> {
        let (x, y) = (w[0], w[1]);
        vec![p[1] - (p[0] + 1.0) * x + x * x * y, p[0] * x - x * x * y]
    }
}

#[test]
fn the_brusselator_oscillates_beyond_one_plus_a_squared() {
    for a in [0.5_f64, 1.0, 2.0] {
        let b = 1.05 * (1.0 + a * a);
        let (hopf, form) = solve(&Brusselator, Dress::Plain, (&[a, b / a], &[b, a]));
        close("B", hopf.p[0], 1.0 + a * a, EXACT);
        close("omega", hopf.omega, a, EXACT);
        // s² - (B - 1 - A²) s + A² = 0: ds/dB = 1/2 at s = i A.
        close_complex("d sigma / dB", hopf.slope, c64::new(0.5, 0.0), EXACT);
        // The eigenvector is (1, (i - A)/A) up to its length, of squared length 2 + 1/A²; for it Re c1 = -(1/2 + 1/A²).
        let x2 = 1.0 / (2.0 + 1.0 / (a * a));
        close("|X|²", hopf.q[0].norm_sqr(), x2, EXACT);
        close("Re c1", form.c1.re, -(0.5 + 1.0 / (a * a)) * x2, EXACT);
        assert!(form.l1 < 0.0);
    }
}

/// What must come out the same in every dress: the point, the slope, and c1 after the change of q's length.
fn invariant<F: Field>(field: &F, at: (&[f64], &[f64])) {
    let (plain, form) = solve(field, Dress::Plain, at);
    let n = F::DIM;
    for dress in [Dress::Multiplied, Dress::Changed, Dress::Algebraic, Dress::Faster(1e3)] {
        let name = format!("{dress:?}");
        let (hopf, dressed) = solve(field, dress, at);
        let speed = if let Dress::Faster(s) = dress { s } else { 1.0 };
        // The length of q in the coordinates of the plain field.
        let q: Vec<c64> = match dress {
            Dress::Changed => {
                let part = |f: fn(&c64) -> f64| psi_slope(&hopf.u, &hopf.q.iter().map(f).collect::<Vec<_>>());
                part(|z| z.re).into_iter().zip(part(|z| z.im)).map(|(re, im)| c64::new(re, im)).collect()
            }
            _ => hopf.q[..n].to_vec(),
        };
        let length2: f64 = q.iter().map(|z| z.norm_sqr()).sum();
        near(&name, hopf.p[0], plain.p[0], EXACT * plain.p[0].abs().max(1.0));
        close(&name, hopf.omega, speed * plain.omega, EXACT);
        close_complex(&name, hopf.slope, plain.slope * speed, EXACT);
        // The double-precision cancellation among the three parts of c1 costs one more digit.
        close_complex(&name, dressed.c1, form.c1 * (speed * length2), 1e-10);
        close(&name, dressed.l1, form.l1 * length2, 1e-10);
        close(&name, dressed.p2, form.p2 * length2, 1e-10);
        if matches!(dress, Dress::Multiplied | Dress::Faster(_)) {
            near(&name, length2, 1.0, EXACT);
        }
    }
}

#[test]
fn the_lyapunov_coefficient_does_not_depend_on_how_the_field_is_written() {
    invariant(&Lorenz, (&lorenz_start(), &[24.0]));
    invariant(&Brusselator, (&[1.0, 2.1], &[2.1, 1.0]));
    let planar =
        Planar { omega: 2.0, f: [0.3, -1.0, 0.7, 0.1, 0.2, -0.3, 0.4], g: [-0.6, 0.5, 1.1, -0.2, 0.3, 0.5, -0.7] };
    invariant(&planar, (&[0.0, 0.0], &[0.01]));
}
