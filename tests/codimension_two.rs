//! Normal forms of codimension two against systems built from them, hidden behind a change of coordinates; fold curves
//! with known equations.

mod common;

use common::{close, near, parameter};
use hopfline::bifurcation::{
    Bautin, BogdanovTakens, Coordinate, DoubleHopf, FoldCurve, Hopf, HopfNormalForm, ZeroHopf, reverse,
};
use hopfline::continuation::{Counts, Point, StepControl, Walk, crossing};
use hopfline::linalg::c64;
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Scalar};
use std::sync::Arc;

/// y' = f(y), with two parameters.
trait Field: Send + Sync {
    fn at<S: Scalar>(&self, y: &[S], p: &[S]) -> Vec<S>;
}

/// The field in bent coordinates u: `y = S(u)`, `S' u' = f(S(u))`: a mass that depends on the solution.
/// `S_i = u_i + bend (0.4 u_j² - 0.3 u_j u_k + 0.2 u_j³ + 0.1 u_i u_k²)` with j, k the next two of n.
struct Hidden<F> {
    dim: usize,
    bend: f64,
    parameters: [Parameter; 2],
    field: F,
}

impl<F: Field> Formula for Hidden<F> {
    fn dim(&self) -> usize {
        self.dim
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let n = self.dim;
        let c = |x: f64| S::from(x * self.bend);
        let (mut y, mut rate) = (Vec::new(), Vec::new());
        for i in 0..n {
            let (j, k) = ((i + 1) % n, (i + 2) % n);
            let (a, b, d) = (u[i], u[j], u[k]);
            let (av, bv, dv) = (v[i], v[j], v[k]);
            y.push(a + c(0.4) * b * b - c(0.3) * b * d + c(0.2) * b * b * b + c(0.1) * a * d * d);
            let bent = c(0.8) * b * bv - c(0.3) * (b * dv + bv * d) + c(0.6) * b * b * bv;
            rate.push(av + bent + c(0.1) * (av * d * d + a * d * dv * 2.0));
        }
        for (g, (rate, f)) in g.iter_mut().zip(rate.into_iter().zip(self.field.at(&y, p))) {
            *g = rate - f;
        }
    }
}

fn hidden<F: Field + 'static>(dim: usize, bend: f64, field: F) -> Arc<dyn Problem> {
    Arc::new(Automatic(Hidden { dim, bend, parameters: [parameter("a", 0.0), parameter("b", 0.0)], field }))
}

/// `z' = z (growth + i turn)`.
fn rotor<S: Scalar>(x: S, y: S, growth: S, turn: S) -> [S; 2] {
    [growth * x - turn * y, turn * x + growth * y]
}

const OMEGA: f64 = 1.7;

/// `z' = z (a + i omega + (b + 0.3 i)|z|² + (-0.7 + 0.2 i)|z|⁴)` and a slave.
struct Generalised;
impl Field for Generalised {
    fn at<S: Scalar>(&self, y: &[S], p: &[S]) -> Vec<S> {
        let r = y[0] * y[0] + y[1] * y[1];
        let [x, z] = rotor(y[0], y[1], p[0] + p[1] * r - r * r * 0.7, r * 0.3 + r * r * 0.2 + OMEGA);
        vec![x, z, y[0] * y[1] - y[2] * 2.0 + y[0] * y[0] * y[1]]
    }
}

fn located(problem: &Arc<dyn Problem>, p: [f64; 2]) -> Hopf {
    let q = [c64::new(1.0, 0.0), c64::new(0.1, -0.8), c64::new(0.1, 0.2)];
    Hopf::locate(&**problem, (&vec![0.0; problem.dim()], &p), 0, 1.5, &q[..problem.dim()]).unwrap()
}

#[test]
fn the_second_lyapunov_coefficient_survives_a_change_of_coordinates() {
    for bend in [0.0, 1.0] {
        let problem = hidden(3, bend, Generalised);
        let bautin = Bautin::new(&*problem, &located(&problem, [0.0, 0.0])).unwrap();
        // |z|² is twice |amplitude|² for eigenvectors of length one.
        near("Re c1", bautin.c1.re, 0.0, 1e-13);
        close("Im c1", bautin.c1.im, 2.0 * 0.3, 1e-12);
        close("l2", bautin.l2, -4.0 * 0.7 / OMEGA, 1e-11);
    }
}

#[test]
fn both_ways_to_the_first_lyapunov_coefficient_agree() {
    let problem = hidden(3, 0.8, Generalised);
    let hopf = located(&problem, [0.0, -0.4]);
    let (bautin, form) = (Bautin::new(&*problem, &hopf).unwrap(), HopfNormalForm::new(&*problem, &hopf).unwrap());
    close("Re c1", bautin.c1.re, form.c1.re, 1e-12);
    close("Im c1", bautin.c1.im, form.c1.im, 1e-12);
    close("l1", form.l1, -0.8 / OMEGA, 1e-12);
}

/// `x' = y, y' = 0.6 x² - 1.3 x y`.
struct Takens;
impl Field for Takens {
    fn at<S: Scalar>(&self, y: &[S], _: &[S]) -> Vec<S> {
        vec![y[1], y[0] * y[0] * 0.6 - y[0] * y[1] * 1.3, y[0] * y[1] - y[2]]
    }
}

#[test]
fn bogdanov_takens_coefficients_survive_a_change_of_coordinates() {
    for bend in [0.0, 1.0] {
        let form = BogdanovTakens::new(&*hidden(3, bend, Takens), &[0.0; 3], &[0.0; 2]).unwrap();
        // The kernel's sign is free.
        close("a", form.a.abs(), 0.6, 1e-12);
        close("b", form.b.abs(), 1.3, 1e-12);
        assert!(form.a * form.b < 0.0);
    }
}

/// Coefficients of x², |z|², x z, x³, x |z|², x² z, z |z|² (those of z with their imaginary parts), the kernel first.
struct FoldHopf;
impl Field for FoldHopf {
    fn at<S: Scalar>(&self, y: &[S], _: &[S]) -> Vec<S> {
        let (x, r) = (y[0], y[1] * y[1] + y[2] * y[2]);
        let [a, b] = rotor(y[1], y[2], x * -0.9 + x * x * 0.35 + r * 0.15, x * 0.4 + x * x * 0.1 - r * 0.2 + OMEGA);
        vec![x * x * 0.8 - r * 0.5 + x * x * x * 0.25 + x * r * 0.45, a, b, x * y[1] - y[3] * 3.0]
    }
}

#[test]
fn zero_hopf_coefficients_survive_a_change_of_coordinates() {
    for bend in [0.0, 1.0] {
        let form = ZeroHopf::new(&*hidden(4, bend, FoldHopf), &[0.0; 4], &[0.0; 2], OMEGA).unwrap();
        let (g200, g011, d) = (1.6, -0.5 * 2.0, -0.9);
        let (g300, g111, g210, g021) = (1.5, 0.45 * 2.0, 0.7, 0.15 * 4.0);
        let e = 0.5 * (g210 + d * (g021 / g011 - g300 / g200 + g111 / g011) - g021 * g200 / (2.0 * g011));
        assert_eq!(form.s, -1.0);
        close("theta", form.theta, d / g200, 1e-12);
        close("g200", form.g200, g200, 1e-12);
        close("g011", form.g011, g011, 1e-12);
        close("E", form.e, e, 1e-10);
    }
}

struct Twice;
impl Field for Twice {
    fn at<S: Scalar>(&self, y: &[S], _: &[S]) -> Vec<S> {
        let (r, s) = (y[0] * y[0] + y[1] * y[1], y[2] * y[2] + y[3] * y[3]);
        let [a, b] = rotor(y[0], y[1], r * -0.4 + s * 0.3, r * 0.1 + OMEGA);
        let [c, d] = rotor(y[2], y[3], r * -0.8 + s * 0.5, s * 0.2 + OMEGA * 0.618);
        vec![a, b, c, d, y[0] * y[2] - y[4]]
    }
}

#[test]
fn double_hopf_coefficients_survive_a_change_of_coordinates() {
    for bend in [0.0, 1.0] {
        let form = DoubleHopf::new(&*hidden(5, bend, Twice), &[0.0; 5], &[0.0; 2], [OMEGA, OMEGA * 0.618]).unwrap();
        for (found, expected) in form.p.iter().zip([-0.8, 0.6, -1.6, 1.0]) {
            close("p", *found, expected, 1e-11);
        }
        close("theta", form.theta, 0.6, 1e-11);
        close("delta", form.delta, 2.0, 1e-11);
    }
}

/// Both ways along a fold curve.
fn folds(problem: &Arc<dyn Problem>, u: &[f64], p: [f64; 2], range: (f64, f64)) -> (FoldCurve, Vec<Point>) {
    let axis = |index| Coordinate { index, logarithmic: false, width: 1.0 };
    let mut counts = Counts::default();
    let (curve, start) = FoldCurve::start(problem.clone(), (u, &p), (axis(0), axis(1)), &mut counts).unwrap();
    let mut back = start.clone();
    reverse(&mut back);
    let way = |start: Point| {
        let mut system = curve.clone();
        let control = StepControl { step: 0.01, least: 1e-9, most: 0.05 };
        let mut walk = Walk::new(&mut system, start, control, range);
        let mut points = Vec::new();
        while points.len() < 200 {
            let step = walk.step().unwrap();
            points.push(step.to);
            if step.stop.is_some() {
                break;
            }
        }
        points
    };
    let points = way(back).into_iter().rev().chain([start.clone()]).chain(way(start)).collect();
    (curve, points)
}

/// x' = a + b x - x³ (a cusp at the origin), and a slave.
struct Cusp;
impl Field for Cusp {
    fn at<S: Scalar>(&self, y: &[S], p: &[S]) -> Vec<S> {
        vec![p[0] + p[1] * y[0] - y[0] * y[0] * y[0], y[0] - y[1]]
    }
}

#[test]
fn a_fold_curve_passes_the_cusp_on_its_invariant() {
    let problem = hidden(2, 0.0, Cusp);
    // The fold at x = 0.5: b = 3 x², a = -2 x³.
    let (curve, points) = folds(&problem, &[0.45, 0.5], [-0.25, 0.7], (-1.0, 1.0));
    assert!(points.len() > 20);
    for point in &points {
        let p = curve.parameters(point);
        // On 27 a² = 4 b³.
        near("a", p[0].abs(), (4.0 / 27.0 * p[1].max(0.0).powi(3)).sqrt(), 1e-11);
    }
    // Both arms are reached: x has either sign.
    let signs = [points[0].x[0], points[points.len() - 1].x[0]];
    assert!(signs[0] * signs[1] < 0.0, "{signs:?}");
    let pair = points.windows(2).find(|w| w[0].x[0] * w[1].x[0] < 0.0).expect("the cusp is passed");
    let value = |point: &Point| curve.quadratic(point).unwrap();
    let cusp = crossing(&curve, (&pair[0], &pair[1]), &value, &mut Counts::default()).unwrap();
    let p = curve.parameters(&cusp);
    near("a", p[0], 0.0, 1e-12);
    near("b", p[1], 0.0, 1e-12);
}

/// x' = y, y' = a + b y + x² + x y: folds at a = 0 for all b, Bogdanov-Takens at b = 0.
struct TakensUnfolded;
impl Field for TakensUnfolded {
    fn at<S: Scalar>(&self, y: &[S], p: &[S]) -> Vec<S> {
        vec![y[1], p[0] + p[1] * y[1] + y[0] * y[0] + y[0] * y[1]]
    }
}

#[test]
fn a_fold_curve_passes_a_bogdanov_takens_point() {
    let problem = hidden(2, 1.0, TakensUnfolded);
    let (curve, points) = folds(&problem, &[0.05, 0.0], [0.01, -0.4], (-1.0, 1.0));
    for point in &points {
        near("a", curve.parameters(point)[0], 0.0, 1e-11);
    }
    assert_eq!([points[0].lambda, points[points.len() - 1].lambda], [-1.0, 1.0]);
    let value = |point: &Point| curve.mass(point).unwrap();
    let pair = points.windows(2).find(|w| value(&w[0]) * value(&w[1]) < 0.0).expect("the point is passed");
    let found = crossing(&curve, (&pair[0], &pair[1]), &value, &mut Counts::default()).unwrap();
    near("b", curve.parameters(&found)[1], 0.0, 1e-11);
    let form = BogdanovTakens::new(&*problem, &found.x[..2], &curve.parameters(&found)).unwrap();
    close("a", form.a.abs(), 1.0, 1e-10);
    close("b", form.b.abs(), 1.0, 1e-10);
}
