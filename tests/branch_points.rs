//! Branch points and folds of classic problems: found, located, classified, switched at.

mod common;

use common::{close, near, parameter};
use hopfline::bifurcation::{BranchPoint, Coordinate, Equilibria, Mark, Sample, branch_points, folds, leaving};
use hopfline::continuation::{Border, Counts, Point, StepControl, Walk, correct};
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Scalar};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::sync::Arc;

/// `M u' = f(u, p)` with a mass that mixes and depends on the state.
trait Field: Send + Sync {
    const DIM: usize;
    fn at<S: Scalar>(&self, u: &[S], p: S) -> Vec<S>;
}

struct Model<F> {
    parameters: [Parameter; 1],
    field: F,
    /// How much the mass differs from the identity.
    mixed: f64,
}

impl<F: Field> Formula for Model<F> {
    fn dim(&self) -> usize {
        F::DIM
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let f = self.field.at(u, p[0]);
        for i in 0..F::DIM {
            let next = v[(i + 1) % F::DIM] * self.mixed * (u[i] + 1.0);
            g[i] = v[i] * (1.0 + self.mixed) + next - f[i];
        }
    }
}

fn problem<F: Field + 'static>(field: F, mixed: f64) -> Arc<dyn Problem> {
    Arc::new(Automatic(Model { parameters: [parameter("p", 0.0)], field, mixed }))
}

fn system(problem: Arc<dyn Problem>, (low, high): (f64, f64)) -> Equilibria {
    let coordinate = Coordinate { index: 0, logarithmic: false, width: high - low };
    Equilibria { problem, p: vec![0.0], coordinate, scale_state: 1.0, all_eigenvalues: None }
}

/// The branch from a point, its special points put in.
fn follow(system: &Equilibria, (start, sign): (Point, Option<f64>), range: (f64, f64)) -> Vec<Sample> {
    let mut moving = system.clone();
    let (mut samples, mut signs) = (vec![Sample::new(start.clone(), None)], vec![sign]);
    let mut walk = Walk::new(&mut moving, start, StepControl { step: 5e-3, least: 1e-10, most: 0.02 }, range);
    while samples.len() < 500 {
        let step = walk.step().unwrap();
        signs.push(step.factors.sign());
        samples.push(Sample::new(step.to, None));
        if step.stop.is_some() {
            break;
        }
    }
    let mut counts = Counts::default();
    assert_eq!(branch_points(system, &mut samples, &signs, &mut counts), Vec::<String>::new());
    folds(system, &mut samples, &mut counts).unwrap();
    samples
}

fn from_state(system: &Equilibria, u: &[f64], p: f64) -> (Point, Option<f64>) {
    let border = Border { row: vec![0.0; u.len()], lambda: 1.0 };
    let found = correct(system, (u.to_vec(), p), &border, &mut Counts::default()).unwrap();
    (found.point, found.factors.sign())
}

fn branch_point_of(samples: &[Sample]) -> Vec<BranchPoint> {
    let point =
        |sample: &Sample| if let Some(Mark::Branch(point)) = &sample.mark { Some((**point).clone()) } else { None };
    samples.iter().filter_map(point).collect()
}

/// Both arms of the other branch.
fn switched(system: &Equilibria, point: &BranchPoint, range: (f64, f64)) -> [Vec<Sample>; 2] {
    [1.0, -1.0].map(|side| {
        let mut tangent = point.across.clone();
        tangent.u.iter_mut().for_each(|t| *t *= side);
        tangent.p *= side;
        follow(system, (leaving(system, &point.u, point.p[0], &tangent), None), range)
    })
}

struct Lorenz;
impl Field for Lorenz {
    const DIM: usize = 3;
    fn at<S: Scalar>(&self, u: &[S], rho: S) -> Vec<S> {
        let [x, y, z] = [u[0], u[1], u[2]];
        vec![(y - x) * 10.0, x * (rho - z) - y, x * y - z * (8.0 / 3.0)]
    }
}

/// Stationary Lorenz: a pitchfork at rho = 1, arms `x² = (8/3)(rho - 1)`. On the centre manifold x = y,
/// z = 3 x²/8: x' (1 + 1/10) = x (rho - 1) - 3 x³/8, x measured along (1, 1, 0)/sqrt 2.
#[test]
fn the_pitchfork_of_lorenz_is_found_and_both_arms_followed() {
    let range = (0.0, 3.0);
    for mixed in [0.0, 0.3] {
        let system = system(problem(Lorenz, mixed), range);
        let trivial = follow(&system, from_state(&system, &[0.0; 3], 0.0), range);
        let found = branch_point_of(&trivial);
        assert_eq!(found.len(), 1);
        near("rho", found[0].p[0], 1.0, 1e-14);
        let form = &found[0].form;
        assert!(form.pitchfork() && form.d < 0.0);
        if mixed == 0.0 {
            close("b", form.b, 10.0 / 11.0, 1e-13);
            close("d", form.d, -0.5 * 0.375 * 10.0 / 11.0, 1e-13);
        }
        // Where b m + d x² = 0 the curve bends, whatever the mass: x² = 2 (8/3) m along the unit vector.
        close("-b/d", -form.b / form.d, 16.0 / 3.0, 1e-12);
        for arm in switched(&system, &found[0], range) {
            let end = &arm[arm.len() - 1].point;
            close("rho", end.lambda, 3.0, 1e-15);
            close("x", end.x[0].abs(), (16.0_f64 / 3.0).sqrt(), 1e-11);
            assert!(arm.iter().all(|sample| sample.mark.is_none()));
        }
    }
}

/// The pitchfork seen from the bent branch: still a branch point, and no fold.
#[test]
fn a_pitchfork_is_no_fold_of_its_arms() {
    let range = (0.0, 3.0);
    let system = system(problem(Lorenz, 0.0), range);
    let x = (16.0_f64 / 3.0).sqrt();
    let (mut start, sign) = from_state(&system, &[x, x, 2.0], 2.999);
    start.tangent.iter_mut().for_each(|t| *t = -*t);
    start.tangent_lambda = -start.tangent_lambda;
    let arms = follow(&system, (start, sign.map(|sign| -sign)), range);
    let found = branch_point_of(&arms);
    assert_eq!(found.len(), 1);
    assert!(arms.iter().all(|sample| !matches!(sample.mark, Some(Mark::Fold(_)))));
    assert!(arms[arms.len() - 1].point.x[0] < 0.0, "the other arm is reached");
    let [up, down] = switched(&system, &found[0], range);
    assert!(up.iter().chain(&down).all(|sample| sample.point.x.iter().all(|x| x.abs() < 1e-12)), "the trivial branch");
}

struct Prey;
impl Field for Prey {
    const DIM: usize = 2;
    fn at<S: Scalar>(&self, u: &[S], p: S) -> Vec<S> {
        let harvest = p * (S::from(1.0) - (u[0] * -5.0).exp());
        vec![u[0] * (S::from(1.0) - u[0]) * 3.0 - u[0] * u[1] - harvest, u[1] * (u[0] * 3.0 - 1.0)]
    }
}

/// Predator-prey: u = v = 0 loses its stability to (u, 0) at p = 3/5, the fold of which is at 0.832929322234157, after
/// (1/3, v) has branched off; Doedel's values in 40 digits.
#[test]
fn transcritical_points_and_the_fold_of_predator_and_prey() {
    let range = (0.05, 1.2);
    let system = system(problem(Prey, 0.0), range);
    let alone = follow(&system, from_state(&system, &[1.0, 0.0], 0.05), range);
    let mut lambdas: Vec<(&str, f64)> = Vec::new();
    for sample in &alone {
        match &sample.mark {
            Some(Mark::Branch(point)) => lambdas.push(("BP", point.p[0])),
            Some(Mark::Fold(Some(fold))) => {
                assert!(fold.rounding < 1e-13);
                lambdas.push(("LP", fold.p[0]));
            }
            _ => {}
        }
    }
    // Where v = 0 and u = 1/3: 3 u (1 - u) = p (1 - exp(-5 u)).
    let third = (2.0 / 3.0) / (1.0 - (-5.0_f64 / 3.0).exp());
    let expected = [("LP", 0.832929322234157), ("BP", third), ("BP", 0.6)];
    assert_eq!(lambdas.len(), 3, "{lambdas:?}");
    for ((kind, value), (wanted, number)) in lambdas.iter().zip(expected) {
        assert_eq!(*kind, wanted);
        close(kind, *value, number, 1e-13);
    }
    for point in branch_point_of(&alone) {
        assert!(!point.form.pitchfork());
    }
    // u' = (3 - 5 p) u + (12.5 p - 3) u²; the eigenvalue along the branch that is followed has the other sign.
    let at_zero = &branch_point_of(&alone)[1].form;
    close("b", at_zero.b, 5.0, 1e-12);
    close("c", at_zero.c, 12.5 * 0.6 - 3.0, 1e-12);
}

struct Imperfect(f64);
impl Field for Imperfect {
    const DIM: usize = 2;
    fn at<S: Scalar>(&self, u: &[S], p: S) -> Vec<S> {
        vec![p * u[0] - u[0] * u[0] * u[0] + self.0, u[0] - u[1]]
    }
}

#[test]
fn an_imperfect_pitchfork_is_refused() {
    for (imperfection, there) in [(0.0, true), (1e-4, false)] {
        let problem = problem(Imperfect(imperfection), 0.0);
        let scales = hopfline::bifurcation::Scales { state: 1.4, parameter: 2.0 };
        let tangent = hopfline::bifurcation::Tangent { u: vec![0.1, 0.0], p: 1.0 };
        let found = BranchPoint::locate(&*problem, (&[0.02, 0.01], &[0.03]), (0, scales), &tangent);
        assert_eq!(found.is_ok(), there, "{found:?}");
    }
}

/// x' = m + l x - x³ at l = 0.7: folds at x = ± sqrt(l/3), m = ∓ 2 x l/3, with the normal form x' = m - 3 x_0 x².
struct Cubic;
impl Field for Cubic {
    const DIM: usize = 2;
    fn at<S: Scalar>(&self, u: &[S], p: S) -> Vec<S> {
        vec![p + u[0] * 0.7 - u[0] * u[0] * u[0], u[0] * u[0] - u[1]]
    }
}

#[test]
fn folds_have_their_normal_form() {
    let range = (-1.0, 1.0);
    let system = system(problem(Cubic, 0.0), range);
    let samples = follow(&system, from_state(&system, &[-1.2, 1.4], -1.0), range);
    let found: Vec<_> = samples
        .iter()
        .filter_map(|s| if let Some(Mark::Fold(Some(fold))) = &s.mark { Some(fold) } else { None })
        .collect();
    assert_eq!(found.len(), 2);
    for (fold, side) in found.iter().zip([-1.0, 1.0]) {
        let x = side * (0.7_f64 / 3.0).sqrt();
        close("m", fold.p[0], -2.0 / 3.0 * 0.7 * x, 1e-14);
        // q = (1, 2 x)/|.|, w = (|.|, 0), w^T q = 1.
        let length = (1.0 + 4.0 * x * x).sqrt() * fold.q[0].signum();
        close("b", fold.b, length, 1e-13);
        close("a", fold.a, -3.0 * x / length, 1e-13);
    }
}

/// Lorenz-84 with G = T = 0: X = F up to F = delta/gamma, where U branches off; HB at F = 1.
const SWITCHING: &str = r#"
[model]
name = "lorenz-84"
[parameters]
G = 0
T = 0
[[task]]
name = "zero"
kind = "equilibria"
free = "F"
range = [0, 3]
detect = ["BP", "LP", "HB"]
values = { F = [2] }
[[task]]
name = "current"
kind = "equilibria"
from = "zero/BP1"
free = "F"
range = [0, 3]
detect = ["BP", "LP"]
values = { F = [2] }
observables = ["U", "X"]
[[task]]
name = "weaker"
kind = "equilibria"
from = "current/UZ1"
free = "delta"
range = [0.5, 1.5]
values = { delta = [0.7] }
observables = ["U"]
[[task]]
name = "through"
kind = "equilibria"
from = "zero/HB1"
free = "G"
range = [-0.5, 0.5]
observables = ["Y"]
[[task]]
name = "broken"
kind = "equilibria"
from = "zero/BP1"
free = "T"
range = [-0.1, 0.1]
detect = ["BP"]
observables = ["U"]
"#;

fn study(text: &str) -> Result<Summary, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).unwrap();
    let options = RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let scene = Scene::load(&path, &[]).map_err(|error| error.to_string())?;
    run(&scene, &options).map_err(|error| error.to_string())
}

#[test]
fn scenes_switch_branches_and_parameters() {
    let summary = study(SWITCHING).unwrap();
    let point = |label: &str| summary.points.iter().find(|p| p.label == label).unwrap_or_else(|| panic!("{label}"));
    for task in &summary.tasks {
        assert_eq!(task.reason, "end of the range", "{}", task.name);
    }
    let (delta, gamma, alpha) = (1.04, 0.987, 0.25);
    close("BP", point("zero/BP1").parameters["F"], delta / gamma, 1e-14);
    assert!(point("zero/BP1").values["bp_d"] < 0.0);
    // X = delta/gamma, gamma U² = alpha (F - X), on both arms.
    let expected = |f: f64, delta: f64| (alpha / gamma * (f - delta / gamma)).sqrt();
    for label in ["current/UZ1", "current/UZ2"] {
        close(label, point(label).values["U"].abs(), expected(2.0, delta), 1e-12);
    }
    assert!(point("current/UZ1").values["U"] * point("current/UZ2").values["U"] < 0.0);
    close("weaker", point("weaker/UZ1").values["U"].abs(), expected(2.0, 0.7), 1e-12);
    close("start", point("weaker/EP2").parameters["delta"], 1.5, 1e-15);
    assert_eq!(point("weaker/EP1").parameters["F"], 2.0);
    // At X = 1 the eddies' equation is Z = Y, Y' = -Z + G: through the Hopf point G alone changes Z.
    assert_eq!(point("through/EP1").parameters["G"], -0.5);
    // Unfolded by T the pitchfork is a cubic: delta U - gamma U X = T.
    let end = point("broken/EP2");
    let (u, f) = (end.values["U"], end.parameters["F"]);
    close("T", delta * u - gamma * u * (f - gamma / alpha * u * u), end.parameters["T"], 1e-11);
}

#[test]
fn wrong_starts_are_refused() {
    for (from, to, wanted) in [
        (
            "from = \"zero/BP1\"\nfree = \"F\"",
            "from = \"zero/BP1\"\nstart = 1\nfree = \"F\"",
            "leave out from or start",
        ),
        ("detect = [\"BP\", \"LP\", \"HB\"]", "detect = [\"LP\", \"HB\"]", "give it detect = [\"LP\", \"HB\", \"BP\"]"),
        ("from = \"current/UZ1\"", "from = \"current/XX1\"", "KIND one of HB, LP, BP"),
        ("from = \"zero/HB1\"", "from = \"through/EP1\"", "comes later"),
    ] {
        assert!(SWITCHING.contains(from));
        let message = study(&SWITCHING.replace(from, to)).unwrap_err();
        assert!(message.contains(wanted), "{message:?} lacks {wanted:?}");
    }
    let failed =
        study(&SWITCHING.replace("free = \"delta\"\nrange = [0.5, 1.5]", "free = \"delta\"\nrange = [0.5, 0.9]"));
    let reason = failed.unwrap().tasks.iter().find(|task| task.name == "weaker").unwrap().reason.clone();
    assert!(reason.contains("does not lie inside the range"), "{reason}");
}

/// One task of equilibria in mu from -1 to 1, with what it is to do besides.
fn equilibria(equations: &str, keys: &str) -> Summary {
    let scene = format!(
        "[model]\nequations = \"\"\"\n{equations}\n\"\"\"\n[model.parameters]\nmu = 0\n[model.start]\nx = 0\n[[task]]\n\
         name = \"rest\"\nkind = \"equilibria\"\nfree = \"mu\"\nrange = [-1, 1]\nerrors = false\n{keys}"
    );
    study(&scene).unwrap()
}

fn labels(summary: &Summary) -> Vec<&str> {
    summary.points.iter().map(|point| point.label.as_str()).collect()
}

#[test]
fn a_wanted_value_does_not_take_the_place_of_a_branch_point() {
    let summary = equilibria("x' = mu*x - x^3", "start = 0.5\ndetect = [\"BP\"]\nvalues = { mu = [0] }");
    let found = labels(&summary);
    assert!(found.contains(&"rest/BP1") && found.contains(&"rest/UZ1") && found.len() == 4, "{found:?}");
}

/// At both ends of the first an eigenvalue is 1, which is the first shift; slopes of a Hopf point can be expected.
#[test]
fn an_eigenvalue_may_be_the_shift() {
    let summary = equilibria("x' = mu*x - x^3\ny' = -y", "spectrum = 2\ndetect = [\"HB\"]");
    assert_eq!(summary.tasks[0].reason, "end of the range");
    let expect = "detect = [\"HB\"]\n[expect]\n\"rest/HB1\".dsigma_re = { value = 1, tolerance = 1e-12 }";
    assert!(equilibria("x' = mu*x - y\ny' = x + mu*y", expect).success());
}

#[test]
fn what_cannot_be_looked_for_costs_no_branch() {
    // No rate of change, no eigenvalues.
    let summary = equilibria(
        "0 = 2*mu + x - x^3/3",
        "state = { x = -2.36 }\ndetect = [\"LP\", \"HB\"]\n[expect]\n\
         rest.ends = \"what was looked for is not complete\"\n\"rest/LP1\".mu = { value = 0.3333333333333333, tolerance = 1e-12 }",
    );
    assert!(summary.tasks[0].points > 10 && summary.success(), "{:?} {:?}", summary.tasks, summary.expect);
    assert_eq!(format!("{:?}", summary.tasks[0].status), "Failed");
}

/// On one side there are more points than are wanted, on the other the field ends.
#[test]
fn how_both_ways_ended_is_said() {
    let keys = "start = 0.4999\nstate = { x = 0.03 }\nmax_points = 100\nmax_step = 0.02";
    let summary = equilibria("x' = x - sqrt(0.5 - mu)", keys);
    let reason = &summary.tasks[0].reason;
    assert!(!summary.success() && reason.contains("one way: max_points reached; the other: no step"), "{reason}");
}

/// Euler's column as the elastica, clamped and free: `theta'' + P sin(theta) = 0, theta(0) = theta'(1) = 0`, in
/// theta = sum u_k sin((k - 1/2) pi s), by Galerkin's method with Gauss points (weights and points of the midpoint rule, which
/// is exact for these waves up to aliasing).
struct Elastica {
    functions: usize,
    parameters: [Parameter; 1],
}

impl Formula for Elastica {
    fn dim(&self) -> usize {
        self.functions
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let n = self.functions;
        let wave = |k: usize| (k as f64 + 0.5) * std::f64::consts::PI;
        for k in 0..n {
            g[k] = v[k] + u[k] * (0.5 * wave(k).powi(2));
        }
        let points = 4 * n;
        for j in 0..points {
            let s = (j as f64 + 0.5) / points as f64;
            let theta = u.iter().enumerate().fold(S::from(0.0), |sum, (k, &u)| sum + u * (wave(k) * s).sin());
            let force = p[0] * theta.sin() / points as f64;
            for (k, g) in g.iter_mut().enumerate() {
                *g -= force * (wave(k) * s).sin();
            }
        }
    }
}

/// The complete elliptic integral of the first kind with modulus k, by the arithmetic-geometric mean.
fn elliptic(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    while f64::abs(a - b) > 1e-15 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::FRAC_PI_2 / a
}

/// Both arms to tip angles beyond 150 degrees: P = K(sin(alpha/2))².
#[test]
fn the_column_follows_the_elastica() {
    let functions = 30;
    let problem: Arc<dyn Problem> = Arc::new(Automatic(Elastica { functions, parameters: [parameter("P", 1.0)] }));
    let range = (1.0, 8.0);
    let system = system(problem, range);
    let straight = follow(&system, from_state(&system, &vec![0.0; functions], 1.0), range);
    let found = branch_point_of(&straight);
    assert_eq!(found.len(), 1);
    close("P", found[0].p[0], std::f64::consts::FRAC_PI_2.powi(2), 1e-13);
    // Supercritical: P = P_1 (1 + alpha²/8 + ...), and x = alpha along the first function.
    assert!(found[0].form.pitchfork() && found[0].form.d < 0.0);
    close("-d/b", -found[0].form.d / found[0].form.b, std::f64::consts::FRAC_PI_2.powi(2) / 8.0, 1e-12);
    let arms = switched(&system, &found[0], range);
    let mut ends = Vec::new();
    for arm in &arms {
        for sample in arm {
            let tip: f64 = sample.point.x.iter().enumerate().map(|(k, u)| if k % 2 == 0 { *u } else { -u }).sum();
            close("P", elliptic((0.5 * tip.abs()).sin()).powi(2), sample.point.lambda, 1e-8);
            ends.push(tip);
        }
    }
    let (least, most) = ends.iter().fold((0.0_f64, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    assert!(least < -2.5 && most > 2.5, "{least} {most}");
}

fn fold_scene(equations: &str, start: f64, from: f64) -> String {
    format!(
        r#"
[model]
equations = """
{equations}
"""
[model.parameters]
mu = -1
[model.start]
x = {start}
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
start = {from}
range = [-1, 1]
detect = ["LP"]
"#
    )
}

/// At mu = 0 and x = 0, where parts of both mean nothing.
#[test]
fn a_fold_at_zero_has_its_normal_form() {
    let summary = study(&fold_scene("x' = mu + exp(x) - 1 - x - 0.3*y\ny' = 0.3*x - y", 1.0, -1.0)).unwrap();
    let fold = summary.points.iter().find(|point| point.label == "rest/LP1").unwrap();
    assert!(fold.values.contains_key("lp_a"), "{fold:?}");
    let summary = study(&fold_scene("x' = mu + exp(x) - 1 - x", 1.0, -0.5)).unwrap();
    let fold = summary.points.iter().find(|point| point.label == "rest/LP1").unwrap();
    assert!(fold.parameters["mu"].abs() < 1e-12, "{fold:?}");
    close("a", fold.values["lp_a"], 0.5, 1e-9);
}
