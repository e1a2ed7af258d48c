//! Relative periodic orbits: an exact one, and one of coupled oscillators against the same orbit in coordinates in which
//! the symmetry is divided out, by ordinary collocation.

mod common;

use common::{close, near, parameter};
use hopfline::branch::{Branch, BranchKind, read_branch};
use hopfline::continuation::{
    Border, Corrected, Counts, Factored, Failure, Point, StepControl, Stop, System, Walk, correct,
};
use hopfline::linalg::Structure;
use hopfline::orbit::{Collocation, Frame, Orbit, Points, Scheme};
use hopfline::problem::{At, Automatic, Formula, Observable, Parameter, Problem, Reflection, Rotation, Scalar};
use hopfline::run::{RunOptions, run};
use hopfline::scene::Scene;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The cycle `(x, y) = (cos w t, sin w t)` drives complex amplitudes A_1, ..., A_K whose phases are free:
///
/// ```text
/// x' = x (1 - x² - y²) - w' y,      y' = y (1 - x² - y²) + w' x,      w' = W + 0.3 sum_k (|A_k|² - s²),
/// A_k' = A_k (s'/s + G (s² - |A_k|²) + i (Omega k + B x + D |A_k|²)),       s = 1 + E x.
/// ```
///
/// On the orbit |A_k| = s: the drift is the mean of `Omega k + B x + D s²`, that is `Omega k + D (1 + E²/2)`, and the
/// multipliers are `exp(-2 T)` and `exp(-2 G (1 + E²/2) T)`. The equations are multiplied by a matrix that depends on u.
struct Driven {
    amplitudes: usize,
    parameters: Vec<Parameter>,
    rotations: Vec<Rotation>,
    observables: Vec<Observable>,
}

const W: f64 = 1.3;
const E: f64 = 0.4;
const G: f64 = 0.15;
const B: f64 = 0.7;
const D: f64 = 0.25;
const MEAN_SQUARE: f64 = 1.0 + 0.5 * E * E;

impl Driven {
    fn problem(amplitudes: usize) -> Arc<dyn Problem> {
        let rotations = (0..amplitudes).map(|k| Rotation { planes: vec![(2 + 2 * k, 3 + 2 * k, 1.0)] }).collect();
        let observables = vec![Observable { name: "momentum", unit: "", meaning: "" }];
        Arc::new(Automatic(Self { amplitudes, parameters: vec![parameter("Omega", 0.5)], rotations, observables }))
    }
}

impl Formula for Driven {
    fn dim(&self) -> usize {
        2 + 2 * self.amplitudes
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (x, y) = (u[0], u[1]);
        let s = x * E + 1.0;
        let square = |k: usize| u[2 + 2 * k] * u[2 + 2 * k] + u[3 + 2 * k] * u[3 + 2 * k];
        let detuning = (0..self.amplitudes).fold(S::from(0.0), |sum, k| sum + square(k) - s * s);
        let (growth, w) = (-(x * x + y * y) + 1.0, detuning * 0.3 + W);
        let (fx, fy) = (x * growth - w * y, y * growth + w * x);
        let (first, second) = (v[0] - fx, v[1] - fy);
        g[0] = first * (square(0) + 2.0) + second * 0.3;
        g[1] = second - first * x * 0.2;
        for k in 0..self.amplitudes {
            let (a, b) = (u[2 + 2 * k], u[3 + 2 * k]);
            let rate = fx * E / s + (s * s - square(k)) * G;
            let speed = p[0] * (k as f64 + 1.0) + x * B + square(k) * D;
            let mass = x * x + 1.0;
            g[2 + 2 * k] = mass * (v[2 + 2 * k] - rate * a + speed * b);
            g[3 + 2 * k] = mass * (v[3 + 2 * k] - rate * b - speed * a);
        }
    }

    fn rotations(&self) -> &[Rotation] {
        &self.rotations
    }

    fn observables(&self) -> &[Observable] {
        &self.observables
    }

    /// `|A_1|² theta_1'`, in the frame at rest.
    fn observe(&self, _i: usize, at: At) -> f64 {
        at.u[2] * at.v[3] - at.u[3] * at.v[2]
    }
}

fn frame(problem: &Arc<dyn Problem>, p: Vec<f64>) -> Frame {
    let symmetry = Reflection::identity(problem.dim());
    let problem = problem.clone();
    Frame { problem, p, free: 0, symmetry, parts: 1, scale_state: 1.0, scale_part: 1.0, scale_lambda: 1.0 }
}

/// A function of tau on a uniform mesh of a closed orbit.
fn sampled(
    state: impl Fn(f64) -> Vec<f64>,
    (part, drift): (f64, Vec<f64>),
    (intervals, degree, points): (usize, usize, Points),
) -> Orbit {
    let scheme = Scheme::new(points, degree);
    let tau = |i: usize| ((i / degree) as f64 + scheme.nodes[i % degree]) / intervals as f64;
    let mut nodes: Vec<f64> = (0..intervals * degree).flat_map(|i| state(tau(i))).collect();
    nodes.extend(state(0.0));
    let mesh = (0..=intervals).map(|j| j as f64 / intervals as f64).collect();
    Orbit { mesh, points, degree, nodes, dim: state(0.0).len(), part, parts: 1, drift }
}

type Solved = (Collocation, Corrected<<Collocation as System>::Factors>);

/// Newton's method at fixed parameters.
fn solved(frame: Frame, orbit: &Orbit) -> Result<Solved, Failure> {
    let lambda = frame.p[0];
    let system = Collocation::new(frame, orbit);
    let x = Collocation::unknowns(orbit);
    let border = Border { row: vec![0.0; x.len()], lambda: 1.0 };
    let corrected = correct(&system, (x, lambda), &border, &mut Counts::default())?;
    Ok((system, corrected))
}

/// The exact orbit's neighbour: amplitudes without their modulation, and velocities a little off.
fn driven(amplitudes: usize, mesh: (usize, usize, Points)) -> Solved {
    let problem = Driven::problem(amplitudes);
    let state = |tau: f64| {
        let (sin, cos) = (TAU * tau).sin_cos();
        let phase = B / W * sin;
        let mut u = vec![cos, sin];
        (0..amplitudes).for_each(|_| u.extend([(1.0 + E * cos) * phase.cos(), 1.02 * (1.0 + E * cos) * phase.sin()]));
        u
    };
    let drift = (0..amplitudes).map(|k| exact_drift(0.5, k) + 0.02).collect();
    solved(frame(&problem, vec![0.5]), &sampled(state, (1.01 * TAU / W, drift), mesh)).expect("an orbit")
}

fn exact_drift(omega: f64, k: usize) -> f64 {
    omega * (k + 1) as f64 + D * MEAN_SQUARE
}

#[test]
fn period_drift_and_multipliers_are_the_exact_ones() {
    for amplitudes in [1, 2] {
        // Rates on the orbit are of order m alone.
        let (system, corrected) = driven(amplitudes, (40, 6, Points::Gauss));
        let orbit = system.orbit(&corrected.point.x);
        close("period", orbit.period(), TAU / W, 1e-11);
        for (k, c) in orbit.drift.iter().enumerate() {
            close("drift", *c, exact_drift(0.5, k), 1e-11);
        }
        let found = corrected.factors.multipliers(None).expect("multipliers");
        assert_eq!(found.values.len(), 1 + amplitudes);
        assert!(found.trivial_error < 1e-9, "{:e}", found.trivial_error);
        for (i, mu) in found.values.iter().enumerate() {
            let rate = if i < amplitudes { 2.0 * G * MEAN_SQUARE } else { 2.0 };
            near("multiplier", mu.re, (-rate * TAU / W).exp(), 1e-9);
            near("imaginary part", mu.im, 0.0, 1e-9);
        }
        // The momentum needs the rate in the frame at rest; it is largest at x = 1.
        let problem = &*system.frame.problem;
        let momentum = orbit.extremes(problem, 0, &[0.5], &system.frame.symmetry);
        let exact = |x: f64| (1.0 + E * x).powi(2) * (0.5 + B * x + D * (1.0 + E * x).powi(2));
        close("momentum", momentum.max, exact(1.0), 1e-7);
        let least = (0..=4000).map(|i| exact(-1.0 + f64::from(i) / 2000.0)).fold(f64::INFINITY, f64::min);
        near("least momentum", momentum.min, least, 1e-6);
    }
}

#[test]
fn period_and_drift_converge_at_twice_the_degree() {
    let errors = |intervals: usize, points: Points| {
        let (system, corrected) = driven(1, (intervals, 3, points));
        let orbit = system.orbit(&corrected.point.x);
        [orbit.period() - TAU / W, orbit.drift[0] - exact_drift(0.5, 0)].map(f64::abs)
    };
    for (points, order) in [(Points::Gauss, 6.0), (Points::Radau, 5.0)] {
        let (coarse, fine) = (errors(10, points), errors(20, points));
        for (coarse, fine) in coarse.iter().zip(fine) {
            let seen = (coarse / fine).log2();
            assert!(fine > 1e-13 && (seen - order).abs() < 0.7, "{points:?}: {coarse:e} {fine:e}: order {seen}");
        }
    }
}

#[test]
fn a_branch_carries_its_drift_over_moving_meshes() {
    let (mut system, first) = driven(1, (20, 4, Points::Gauss));
    system.tolerance = Some(1e-7);
    let control = StepControl { step: 0.1, least: 1e-6, most: 0.3 };
    let mut walk = Walk::new(&mut system, first.point, control, (0.0, 2.0));
    let mut last: Option<Point> = None;
    let mut meshes = 0;
    for _ in 0..100 {
        let before = walk.system.mesh.clone();
        let step = walk.step().unwrap_or_else(|stop| panic!("{stop}"));
        meshes += usize::from(before != walk.system.mesh);
        let orbit = walk.system.orbit(&step.to.x);
        close("period", orbit.period(), TAU / W, 1e-7);
        close("drift", orbit.drift[0], exact_drift(step.to.lambda, 0), 1e-7);
        if step.stop == Some(Stop::RangeEnd) {
            last = Some(step.to);
            break;
        }
    }
    assert!(last.is_some() && meshes > 0);
}

/// `A' = (1 + i W_A) A - (1 + i ALPHA) |A|² A + (K + 0.2 i) (B - A)` and the same for B with W_B: the common phase is free.
/// Far apart, the frequencies do not lock, and B turns once around A in each period.
struct Pair {
    /// A is real, its phase is divided out: unknowns (A, B e^{-i theta}).
    reduced: bool,
    parameters: Vec<Parameter>,
    rotations: Vec<Rotation>,
}

const W_A: f64 = 1.7;
const W_B: f64 = 3.9;
const ALPHA: f64 = 0.6;
const COUPLING: f64 = 0.35;

/// A' or B', given the other.
fn rate<S: Scalar>(w: f64, [a, b]: [S; 2], [c, d]: [S; 2]) -> [S; 2] {
    let square = a * a + b * b;
    let (growth, speed) = (-square + 1.0, -square * ALPHA + w);
    let (x, y) = (c - a, d - b);
    [growth * a - speed * b + x * COUPLING - y * 0.2, growth * b + speed * a + y * COUPLING + x * 0.2]
}

impl Formula for Pair {
    fn dim(&self) -> usize {
        if self.reduced { 3 } else { 4 }
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], _p: &[S], g: &mut [S]) {
        if self.reduced {
            let (a, c) = ([u[0], S::from(0.0)], [u[1], u[2]]);
            let (fa, fc) = (rate(W_A, a, c), rate(W_B, c, a));
            let turn = fa[1] / u[0];
            (g[0], g[1], g[2]) = (v[0] - fa[0], v[1] - fc[0] - turn * c[1], v[2] - fc[1] + turn * c[0]);
        } else {
            let (a, b) = ([u[0], u[1]], [u[2], u[3]]);
            let (fa, fb) = (rate(W_A, a, b), rate(W_B, b, a));
            (g[0], g[1], g[2], g[3]) = (v[0] - fa[0], v[1] - fa[1], v[2] - fb[0], v[3] - fb[1]);
        }
    }

    fn rotations(&self) -> &[Rotation] {
        &self.rotations
    }
}

fn pair(reduced: bool) -> Arc<dyn Problem> {
    let rotations = if reduced { Vec::new() } else { vec![Rotation { planes: vec![(0, 1, 1.0), (2, 3, 1.0)] }] };
    Arc::new(Automatic(Pair { reduced, parameters: vec![parameter("none", 0.0)], rotations }))
}

#[test]
fn modulated_waves_are_those_of_the_reduced_equations() {
    let mesh = (30, 5, Points::Gauss);
    let part = TAU / (W_B - W_A);
    let other = |tau: f64| [(TAU * tau).cos(), (TAU * tau).sin()];
    let whole = sampled(|tau| [[1.0, 0.0], other(tau)].concat(), (part, vec![W_A - ALPHA]), mesh);
    let slice = sampled(|tau| [&[1.0][..], &other(tau)].concat(), (part, Vec::new()), mesh);
    let (system, corrected) = solved(frame(&pair(false), vec![0.0]), &whole).expect("a relative orbit");
    let (reduced, expected) = solved(frame(&pair(true), vec![0.0]), &slice).expect("an orbit");
    let (orbit, slice) = (system.orbit(&corrected.point.x), reduced.orbit(&expected.point.x));
    close("period", orbit.period(), slice.period(), 1e-11);
    // The phase of A moves at Im(A'/A).
    let scheme = slice.scheme();
    let mut mean = 0.0;
    for w in slice.mesh.windows(2) {
        for (c, weight) in scheme.points.iter().zip(&scheme.weights) {
            let (u, _) = slice.at(w[0] + c * (w[1] - w[0]), &scheme);
            mean += (w[1] - w[0]) * weight * rate(W_A, [u[0], 0.0], [u[1], u[2]])[1] / u[0];
        }
    }
    close("drift", orbit.drift[0], mean, 1e-10);
    let (found, wanted) = (corrected.factors.multipliers(None), expected.factors.multipliers(None));
    let (found, wanted) = (found.expect("multipliers"), wanted.expect("multipliers"));
    assert_eq!((found.values.len(), wanted.values.len()), (2, 2));
    for (mu, nu) in found.values.iter().zip(&wanted.values) {
        near("multiplier", (mu - nu).norm(), 0.0, 1e-9);
    }
    assert!(found.trivial_error < 1e-9);
    // At rest the frame sees a motion on a torus, which does not close.
    let at_rest = Orbit { drift: Vec::new(), ..whole };
    assert!(solved(frame(&pair(false), vec![0.0]), &at_rest).is_err());
}

/// A chain of complex oscillators `A_j' = (1 + i p - (1 + 0.5 i) |A_j|²) A_j + (0.3 + 0.1 i) (A_{j-1} - 2 A_j + A_{j+1})`.
struct Chain {
    structure: Structure,
    parameters: Vec<Parameter>,
    rotations: Vec<Rotation>,
}

const LENGTH: usize = 6;

impl Formula for Chain {
    fn dim(&self) -> usize {
        2 * LENGTH
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn structure(&self) -> Structure {
        self.structure.clone()
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        for j in 0..LENGTH {
            let (a, b) = (u[2 * j], u[2 * j + 1]);
            let square = a * a + b * b;
            let (growth, speed) = (-square + 1.0, p[0] - square * 0.5);
            let (mut x, mut y) = (S::from(0.0), S::from(0.0));
            for other in [j.saturating_sub(1), (j + 1).min(LENGTH - 1)] {
                (x, y) = (x + u[2 * other] - a, y + u[2 * other + 1] - b);
            }
            g[2 * j] = v[2 * j] - growth * a + speed * b - x * 0.3 + y * 0.1;
            g[2 * j + 1] = v[2 * j + 1] - growth * b - speed * a - y * 0.3 - x * 0.1;
        }
    }

    fn rotations(&self) -> &[Rotation] {
        &self.rotations
    }
}

/// Turning all phases keeps the equations; in the turned frame the band grows by one.
#[test]
fn banded_and_dense_factors_agree_in_a_frame_that_turns() {
    let chain = |structure: Structure| -> Arc<dyn Problem> {
        let rotations = vec![Rotation { planes: (0..LENGTH).map(|j| (2 * j, 2 * j + 1, 1.0)).collect() }];
        Arc::new(Automatic(Chain { structure, parameters: vec![parameter("p", 0.4)], rotations }))
    };
    let state = |tau: f64| -> Vec<f64> {
        (0..2 * LENGTH).map(|i| 0.8 + 0.3 * (TAU * tau + 0.9 * i as f64).sin() - 0.1 * i as f64).collect()
    };
    let orbit = sampled(state, (4.0, vec![0.7]), (6, 3, Points::Radau));
    let x = Collocation::unknowns(&orbit);
    let wave = |seed: f64, count: usize| -> Vec<f64> { (0..count).map(|i| (seed + 1.7 * i as f64).sin()).collect() };
    let border = Border { row: wave(0.4, x.len()), lambda: 0.6 };
    let solutions = [Structure::Dense, Structure::Banded { lower: 3, upper: 3 }].map(|structure| {
        let system = Collocation::new(frame(&chain(structure), vec![0.4]), &orbit);
        let mut right = wave(0.1, x.len() + 1);
        system.factor(&x, 0.4, &border).expect("factors").solve(&mut right);
        right
    });
    let size = solutions[0].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (dense, banded) in solutions[0].iter().zip(&solutions[1]) {
        near("entry", *banded, *dense, 1e-10 * size);
    }
    // The equations turn with the state.
    let problem = chain(Structure::Dense);
    let (mut u, mut v) = (wave(0.3, 2 * LENGTH), wave(0.8, 2 * LENGTH));
    let (mut before, mut after) = (vec![0.0; 2 * LENGTH], vec![0.0; 2 * LENGTH]);
    problem.residual(At { u: &u, v: &v, p: &[0.4] }, &mut before);
    [&mut u, &mut v, &mut before].into_iter().for_each(|x| problem.rotations()[0].turn(0.7, x));
    problem.residual(At { u: &u, v: &v, p: &[0.4] }, &mut after);
    before.iter().zip(&after).for_each(|(a, b)| near("turned", *b, *a, 1e-14));
}

/// With a velocity for a rotation that leaves the orbit where it is, the phase condition is empty.
#[test]
fn an_orbit_that_a_rotation_does_not_move_has_no_drift() {
    let state = |tau: f64| [(TAU * tau).cos(), (TAU * tau).sin(), 0.0, 0.0].to_vec();
    let orbit = sampled(state, (TAU / W, vec![0.1]), (10, 4, Points::Gauss));
    assert!(solved(frame(&Driven::problem(1), vec![0.5]), &orbit).is_err());
}

/// A = a + i b rotates with |A|² = mu for mu > 0. Where |A|² > 1, (x, y) oscillates and modulates it.
const WAVE: &str = r#"
title = "Modulated wave"

[model]
equations = """
a' = mu*a - 1.5*b - (a^2 + b^2)*(a - 0.5*b) + 0.3*x*a
b' = mu*b + 1.5*a - (a^2 + b^2)*(b + 0.5*a) + 0.3*x*b
x' = (a^2 + b^2 - 1)*x - 1.3*y - x*(x^2 + y^2)
y' = (a^2 + b^2 - 1)*y + 1.3*x - y*(x^2 + y^2)
"""
rotations = ["a -> -b, b -> a"]

[model.parameters]
mu = -0.1

[model.observables]
size = "sqrt(a^2 + b^2)"

[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-0.5, 0.5]
detect = ["HB"]

[[task]]
name = "wave"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [-0.5, 1.4]
points = "gauss"
detect = ["NS"]

[[task]]
name = "modulated"
kind = "cycles"
relative = true
from = "wave/NS1"
free = "mu"
range = [0.5, 1.4]
intervals = 30
degree = 5
points = "gauss"
values = { mu = [1.2] }
multipliers = 2
observables = ["size"]

[[task]]
name = "again"
kind = "cycles"
relative = true
from = "modulated/UZ1"
free = "mu"
range = [1.1, 1.25]
points = "gauss"
degree = 5
"#;

/// The same without the phase.
const REDUCED: &str = r#"
title = "Amplitudes of a modulated wave"

[model]
equations = """
r' = mu*r - r^3 + 0.3*x*r
x' = (r^2 - 1)*x - 1.3*y - x*(x^2 + y^2)
y' = (r^2 - 1)*y + 1.3*x - y*(x^2 + y^2)
"""

[model.parameters]
mu = 0.8

[model.start]
r = "sqrt(mu)"

[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [0.5, 1.4]
detect = ["HB"]

[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [0.5, 1.4]
intervals = 30
degree = 5
points = "gauss"
values = { mu = [1.2] }
multipliers = 2
observables = ["r"]
"#;

struct Results {
    folder: tempfile::TempDir,
    /// Refusal, or how the tasks ended.
    message: String,
}

fn results(text: &str) -> Results {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, text).unwrap();
    let options = RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let message = match Scene::load(&path, &[]).map_err(|e| e.to_string()) {
        Err(message) => message,
        Ok(scene) => match run(&scene, &options) {
            Err(error) => error.to_string(),
            Ok(summary) => summary.tasks.iter().map(|task| task.reason.clone() + "; ").collect(),
        },
    };
    Results { folder, message }
}

impl Results {
    #[track_caller]
    fn branch(&self, scene: &str, name: &str) -> Branch {
        let path = self.folder.path().join(scene).join(format!("branches/{name}.csv"));
        let branch = read_branch(&path, name, BranchKind::Cycles, &["mu".to_owned()]);
        branch.unwrap_or_else(|e| panic!("{e}; {}", self.message))
    }
}

#[track_caller]
fn value(branch: &Branch, row: usize, column: &str) -> f64 {
    let k = branch.column(column).unwrap_or_else(|| panic!("{column}"));
    branch.rows[row].values[k].unwrap_or(f64::NAN)
}

fn labelled(branch: &Branch, label: &str) -> usize {
    branch.rows.iter().position(|row| row.label.as_deref() == Some(label)).expect(label)
}

#[test]
fn a_rotating_wave_becomes_modulated() {
    let (whole, reduced) = (results(WAVE), results(REDUCED));
    let (modulated, expected) = (whole.branch("scene", "modulated"), reduced.branch("scene", "cycles"));
    // |A|² = 1 at the onset: the wave turns at 1.5 - 0.5, the mode at 1.3.
    close("onset", value(&modulated, 0, "mu"), 1.0, 1e-8);
    close("drift there", value(&modulated, 0, "drift_1"), 1.0, 1e-6);
    close("period there", value(&modulated, 0, "period"), TAU / 1.3, 1e-6);
    let (here, there) = (labelled(&modulated, "UZ1"), labelled(&expected, "UZ1"));
    for (own, other) in [("period", "period"), ("max size", "max r"), ("min size", "min r"), ("mu_1_re", "mu_1_re")] {
        close(own, value(&modulated, here, own), value(&expected, there, other), 1e-7);
    }
    assert_eq!(modulated.rows[here].stable, Some(true));
    // Started again at the stored point, drift included.
    let again = whole.branch("scene", "again");
    let distance = |row: &usize| (value(&again, *row, "mu") - 1.2).abs();
    let same = (0..again.rows.len()).min_by(|i, j| distance(i).total_cmp(&distance(j))).expect("a row");
    for column in ["mu", "period", "drift_1"] {
        close(column, value(&again, same, column), value(&modulated, here, column), 1e-7);
    }
    near("one end", value(&again, 0, "mu"), 1.1, 1e-9);
    near("the other end", value(&again, again.rows.len() - 1, "mu"), 1.25, 1e-9);
}

#[test]
fn what_has_no_relative_orbits_is_refused() {
    let quarter = "a -> -b, b -> a";
    let start = "from = \"wave/NS1\"";
    for (from, to, wanted) in [
        (start, "from = \"wave/EP1\"", "rotating wave"),
        (start, "from = \"rest/HB1\"", "start at \"TASK/NS1\""),
        ("multipliers = 2\n", "multipliers = 2\ndetect = [\"BPC\"]\n", "not looked for"),
        ("rotations = [\"a -> -b, b -> a\"]\n", "", "needs a model with rotations"),
        (quarter, "a -> -b", "quarter turn"),
        (quarter, "a -> -x, x -> a", "is no symmetry"),
        (quarter, "a -> -q, q -> a", "q is not an unknown"),
        ("[\"a -> -b, b -> a\"]", "[\"a -> -b, b -> a\", \"a -> -b, b -> a\"]", "rotations must commute"),
    ] {
        assert!(WAVE.contains(from), "{from}");
        let found = results(&WAVE.replace(from, to)).message;
        assert!(found.contains(wanted), "{found:?} lacks {wanted:?}");
    }
}
