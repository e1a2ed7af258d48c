//! Calibration: systems with known inverses, closed-form least squares, round trips, and the distal load's decay length.

mod common;

use common::{Flagellum, close, near, parameter};
use hopfline::bifurcation::{Calibration, Coordinate, Fit, Hopf, Place, Quantity, Target, Unknown};
use hopfline::branch::{BranchKind, read_branch};
use hopfline::linalg::c64;
use hopfline::models::{Law, Load};
use hopfline::problem::{Automatic, Formula, Parameter, Scalar};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::path::Path;
use std::sync::Arc;

/// r' = (growth + cubic r²) r, phi' = omega, with parameters (p, a, b).
struct Rotor<F> {
    parameters: [Parameter; 3],
    law: F,
}

/// Growth, angular velocity and cubic coefficient as functions of (p, a, b), over any scalar.
trait Coefficients: Send + Sync {
    fn at<S: Scalar>(&self, p: S, a: S, b: S) -> [S; 3];
}

impl<F: Coefficients> Formula for Rotor<F> {
    fn dim(&self) -> usize {
        2
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let [growth, omega, cubic] = self.law.at(p[0], p[1], p[2]);
        let rate = growth + cubic * (u[0] * u[0] + u[1] * u[1]);
        g[0] = v[0] - (rate * u[0] - omega * u[1]);
        g[1] = v[1] - (omega * u[0] + rate * u[1]);
    }
}

const P: usize = 0;
const A: usize = 1;
const B: usize = 2;

fn unknown(index: usize, low: f64, high: f64) -> Unknown {
    Unknown { coordinate: Coordinate { index, logarithmic: false, width: 1.0 }, low, high }
}

fn target(quantity: Quantity, value: f64, scale: f64) -> Target {
    Target { quantity, value, scale }
}

fn calibration<F: Coefficients + 'static>(law: F, unknowns: Vec<Unknown>, targets: Vec<Target>) -> Calibration {
    let problem = Automatic(Rotor { parameters: ["p", "a", "b"].map(|name| parameter(name, 0.0)), law });
    Calibration { problem: Arc::new(problem), free: P, unknowns, targets }
}

/// The place with parameters (a, b), from a guess of p and omega.
fn place(calibration: &Calibration, (p, omega): (f64, f64), (a, b): (f64, f64)) -> Place {
    let q = [c64::new(1.0, 0.0), c64::new(0.1, -0.9)];
    let hopf = Hopf::locate(&*calibration.problem, (&[0.0, 0.0], &[p, a, b]), P, omega, &q).unwrap();
    calibration.place(hopf).unwrap()
}

fn fit(calibration: &Calibration, start: &Place) -> Fit {
    let fit = calibration.fit(start, &|| false).unwrap();
    assert!(fit.minimal);
    fit
}

/// p_H = a², omega = 2 - a, l1 = 2 (a - 1/2).
struct Parabola;
impl Coefficients for Parabola {
    fn at<S: Scalar>(&self, p: S, a: S, _: S) -> [S; 3] {
        [p - a * a, S::from(2.0) - a, (a - 0.5) * (S::from(2.0) - a)]
    }
}

#[test]
fn each_of_two_solutions_is_found_from_its_side() {
    let problem = calibration(Parabola, vec![unknown(A, -1.0, 1.5)], vec![target(Quantity::Parameter, 0.3, 1.0)]);
    let origin = place(&problem, (0.6, 1.3), (0.8, 0.0));
    close("dp/da", origin.rates[0].0 / 2.5, 1.6, 1e-13);
    close("domega/da", origin.rates[0].1 / 2.5, -1.0, 1e-13);
    for (x, sign) in [(0.95, 1.0), (0.5, 1.0), (0.3, -1.0), (0.0, -1.0)] {
        let start = problem.reach(&origin, &[x]).unwrap();
        let a = -1.0 + 2.5 * x;
        near("p on the way", start.hopf.p[P], a * a, 1e-14);
        let found = fit(&problem, &start).place;
        near("a", found.hopf.p[A], sign * 0.3_f64.sqrt(), 1e-14);
        let analysis = problem.analysis(&found).unwrap();
        let sensitivity = analysis.sensitivity.unwrap()[(0, 0)];
        close("da/dp", sensitivity, sign * 0.5 / 0.3_f64.sqrt(), 1e-12);
        assert!(analysis.chi2 < 1e-28 && analysis.held.is_empty());
    }
}

#[test]
fn the_lyapunov_coefficient_can_be_a_target() {
    let problem = calibration(Parabola, vec![unknown(A, -1.0, 1.5)], vec![target(Quantity::Lyapunov, 0.0, 1.0)]);
    let origin = place(&problem, (0.1, 2.2), (-0.2, 0.0));
    near("a", fit(&problem, &origin).place.hopf.p[A], 0.5, 1e-13);
}

/// p_H = a + 2 b, omega = 2 - a + b.
struct Linear;
impl Coefficients for Linear {
    fn at<S: Scalar>(&self, p: S, a: S, b: S) -> [S; 3] {
        [p - a - b * 2.0, S::from(2.0) - a + b, S::from(-1.0)]
    }
}

#[test]
fn two_unknowns_are_the_solution_of_two_equations() {
    let targets = vec![target(Quantity::Parameter, 1.1, 0.1), target(Quantity::Omega, 1.9, 0.3)];
    let problem = calibration(Linear, vec![unknown(A, -2.0, 2.0), unknown(B, -1.0, 1.0)], targets);
    let found = fit(&problem, &place(&problem, (0.0, 2.0), (0.0, 0.0))).place;
    // a + 2 b = 1.1, b - a = -0.1.
    near("a", found.hopf.p[A], 1.3 / 3.0, 1e-14);
    near("b", found.hopf.p[B], 1.0 / 3.0, 1e-14);
    let analysis = problem.analysis(&found).unwrap();
    let expected = [[1.0 / 3.0, -2.0 / 3.0], [1.0 / 3.0, 1.0 / 3.0]];
    let (sensitivity, covariance) = (analysis.sensitivity.unwrap(), analysis.covariance.unwrap());
    for (i, row) in expected.iter().enumerate() {
        for (k, &entry) in row.iter().enumerate() {
            close("sensitivity", sensitivity[(i, k)], entry, 1e-12);
        }
        close("variance", covariance[(i, i)], (row[0] * 0.1).powi(2) + (row[1] * 0.3).powi(2), 1e-12);
    }
    close("covariance", covariance[(0, 1)], (0.01 - 2.0 * 0.09) / 9.0, 1e-12);
}

#[test]
fn more_targets_than_unknowns_are_weighted_least_squares() {
    // min ((a - 0.5)/0.1)² + ((2 - a - 1.2)/0.2)²: a = (50 + 20)/(100 + 25).
    let targets = vec![target(Quantity::Parameter, 0.5, 0.1), target(Quantity::Omega, 1.2, 0.2)];
    let problem = calibration(Linear, vec![unknown(A, -2.0, 2.0)], targets);
    let found = fit(&problem, &place(&problem, (0.0, 2.0), (0.0, 0.0))).place;
    near("a", found.hopf.p[A], 0.56, 1e-13);
    let analysis = problem.analysis(&found).unwrap();
    close("chi2", analysis.chi2, 0.36 + 1.44, 1e-12);
    close("variance", analysis.covariance.unwrap()[(0, 0)], 1.0 / 125.0, 1e-12);
}

#[test]
fn a_nonlinear_fit_with_residuals_is_stationary_to_rounding() {
    // min (a² - 1)² + (2 - a - 1.4)²: 4 a (a² - 1) - 2 (0.6 - a) = 0, that is 2 a³ - a - 0.6 = 0.
    let targets = vec![target(Quantity::Parameter, 1.0, 1.0), target(Quantity::Omega, 1.4, 1.0)];
    let problem = calibration(Parabola, vec![unknown(A, -1.0, 1.5)], targets);
    let a = fit(&problem, &place(&problem, (0.2, 1.5), (0.5, 0.0))).place.hopf.p[A];
    near("gradient", 2.0 * a * a * a - a - 0.6, 0.0, 1e-12);
}

#[test]
fn what_cannot_be_met_ends_at_the_nearest_point_of_the_box() {
    let unknowns = || vec![unknown(A, 0.2, 0.9)];
    let above = calibration(Parabola, unknowns(), vec![target(Quantity::Parameter, 4.0, 1.0)]);
    let found = fit(&above, &place(&above, (0.25, 1.5), (0.5, 0.0))).place;
    assert_eq!(found.hopf.p[A], 0.9);
    let analysis = above.analysis(&found).unwrap();
    assert_eq!(analysis.held, [0]);
    near("residual", analysis.residuals[0], 0.81 - 4.0, 1e-13);
    assert!(analysis.covariance.is_none());
    // p_H = a² has its least value inside.
    let below = calibration(Parabola, vec![unknown(A, -1.0, 1.5)], vec![target(Quantity::Parameter, -0.5, 1.0)]);
    let found = fit(&below, &place(&below, (0.25, 1.5), (0.5, 0.0))).place;
    near("a", found.hopf.p[A], 0.0, 1e-6);
    assert!(below.analysis(&found).unwrap().held.is_empty());
}

/// The rates along the flagellum's stiffness and time constant against differences of Hopf points.
#[test]
fn rates_are_derivatives() {
    let model = Flagellum::new(24, Load::Uniform, Law::Printed);
    let unknowns = ["k_N", "k_T", "L"].map(|name| {
        let value = model.get(name);
        unknown(model.index(name), 0.5 * value, 1.5 * value)
    });
    let (problem, free) = (model.problem.clone(), model.index("p"));
    let calibration = Calibration { problem, free, unknowns: unknowns.to_vec(), targets: Vec::new() };
    let origin = calibration.place(model.hopf(338.0, 0)).unwrap();
    for (i, rate) in origin.rates.iter().enumerate() {
        let h = 1e-4;
        let [after, before] = [h, -h].map(|h| {
            let mut x = origin.x.clone();
            x[i] += h;
            calibration.reach(&origin, &x).unwrap().hopf
        });
        close("dp/dx", rate.0, (after.p[free] - before.p[free]) / (2.0 * h), 1e-6);
        close("domega/dx", rate.1, (after.omega - before.omega) / (2.0 * h), 1e-6);
    }
}

fn study(text: &str, sets: &[&str]) -> Summary {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).unwrap();
    run_scene(&path, sets, folder.path()).unwrap()
}

fn run_scene(path: &Path, sets: &[&str], out: &Path) -> Result<Summary, String> {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    let options = RunOptions { out: out.to_owned(), only: Vec::new(), resume: false, quiet: true };
    let scene = Scene::load(path, &sets).map_err(|error| error.to_string())?;
    run(&scene, &options).map_err(|error| error.to_string())
}

const STRAIGHT: &str = "
    [model]
    name = \"two-doublet\"
    functions = 24
    [[task]]
    name = \"straight\"
    kind = \"equilibria\"
    free = \"p\"
    range = [0, 500]
    detect = [\"HB\"]
    errors = false
    [[task]]
    name = \"fit\"
    kind = \"calibration\"
    from = \"straight/HB1\"
    ";

fn number(summary: &Summary, label: &str, name: &str) -> f64 {
    let point = summary.points.iter().find(|point| point.label == label);
    let point = point.unwrap_or_else(|| panic!("no {label} in:\n{}", summary.table("")));
    *point.parameters.get(name).or(point.values.get(name)).unwrap_or_else(|| panic!("{label} has no {name}"))
}

fn reason<'a>(summary: &'a Summary, task: &str) -> &'a str {
    &summary.tasks.iter().find(|line| line.name == task).unwrap().reason
}

#[test]
fn a_round_trip_recovers_the_parameters() {
    let known = Flagellum::new(24, Load::Uniform, Law::Printed).with("k_N", 2500.0).with("tau_c", 2e-4);
    let hopf = known.hopf(210.0, 0);
    let (p, omega) = (hopf.p[known.index("p")], hopf.omega);
    let text = format!(
        "{STRAIGHT}free = [\"k_N\", \"tau_c\"]
        log = [\"k_N\", \"tau_c\"]
        range = {{ k_N = [1e3, 1e5], tau_c = [1e-5, 1e-2] }}
        targets = {{ p = {p}, omega = {omega} }}"
    );
    let summary = study(&text, &[]);
    assert!(summary.success(), "{}", summary.table(""));
    assert!(reason(&summary, "fit").starts_with("1 solution in the box (16 starts"), "{}", reason(&summary, "fit"));
    close("k_N", number(&summary, "fit/UZ1", "k_N"), 2500.0, 1e-9);
    close("tau_c", number(&summary, "fit/UZ1", "tau_c"), 2e-4, 1e-9);
    close("b_N, tied", number(&summary, "fit/UZ1", "b_N"), 0.5, 1e-9);
}

/// The decay length of the load for a threshold of 450: a bracketed root of Hopf points found afresh from spectra.
#[test]
fn the_decay_length_agrees_with_a_search_by_fresh_runs() {
    let model = Flagellum::new(32, Load::Distal, Law::Printed);
    let threshold = |s0: f64| {
        let at = model.clone().with("s0", s0);
        at.hopf(430.0, 0).p[at.index("p")]
    };
    let (mut low, mut high) = (4.0, 4.7);
    close("threshold at s0 = 4", threshold(low), 425.711221652, 1e-10);
    let (mut below, mut above) = (threshold(low), threshold(high));
    assert!(below < 450.0 && above > 450.0);
    // Regula falsi from below: the threshold bends upward, so that the lower end moves.
    let mut secant = low;
    for _ in 0..12 {
        secant = low + (450.0 - below) * (high - low) / (above - below);
        let here = threshold(secant);
        if here < 450.0 {
            (low, below) = (secant, here)
        } else {
            (high, above) = (secant, here)
        }
        if (here - 450.0).abs() < 1e-9 {
            break;
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/calibrate-s0.toml");
    let out = tempfile::tempdir().unwrap();
    let summary = run_scene(&path, &[], out.path()).unwrap();
    assert!(summary.success(), "{}", summary.table(""));
    let found = number(&summary, "decay/UZ1", "s0");
    near("s0", found, secant, 1e-10);
    // A standard deviation of 10 of the threshold: 10 ds0/dp, to first order.
    let slope = 0.02 / (threshold(found + 0.01) - threshold(found - 0.01));
    close("sigma s0", number(&summary, "decay/UZ1", "sigma s0"), 10.0 * slope, 1e-5);
    // Errors against a finer discretisation.
    let fine = run_scene(
        &path,
        &["model.functions=44", "task.decay.starts=1", "task.coupling.starts=1", "task.onset.max_points=3"],
        out.path(),
    )
    .unwrap();
    for (label, name) in [("decay/UZ1", "s0"), ("decay/UZ1", "omega"), ("coupling/UZ1", "k_N")] {
        let (coarse, fine) = (number(&summary, label, name), number(&fine, label, name));
        let point = summary.points.iter().find(|point| point.label == label).unwrap();
        assert!((coarse - fine).abs() <= 10.0 * point.errors[name], "{label} {name}: {coarse}, {fine}");
        assert!(point.errors[name] < 1e-10 * fine);
    }
    let names = ["s0".to_owned(), "p".to_owned()];
    let table =
        read_branch(&out.path().join("calibrate-s0/branches/decay.csv"), "decay", BranchKind::Calibration, &names);
    let table = table.unwrap();
    assert_eq!(table.rows.len(), 1);
    assert_eq!(table.columns[0].unit, "µm");
}

const CRITICALITY: &str = "free = [\"L\"]
    range = { L = [4, 30] }
    errors = false
    targets = { lyapunov = VALUE }";

#[test]
fn all_solutions_in_the_box_are_reported() {
    // l1 falls from L = 4 on and rises again toward L = 30.
    let summary = study(&(STRAIGHT.to_owned() + &CRITICALITY.replace("VALUE", "-0.19")), &[]);
    assert!(summary.success(), "{}", summary.table(""));
    assert!(reason(&summary, "fit").starts_with("2 solutions in the box"), "{}", reason(&summary, "fit"));
    let lengths = ["fit/UZ1", "fit/UZ2"].map(|label| number(&summary, label, "L"));
    let model = Flagellum::new(24, Load::Uniform, Law::Printed);
    for length in lengths {
        // With a time constant of its own nothing but L changes.
        let at = model.clone().with("L", length);
        let near_onset = if length < 12.0 { 900.0 } else { 150.0 };
        let l1 = hopfline::bifurcation::HopfNormalForm::new(&*at.problem, &at.hopf(near_onset, 0)).unwrap().l1;
        close("l1 afresh", l1, -0.19, 1e-8);
    }
    assert!(lengths[0] != lengths[1]);
}

#[test]
fn unreachable_targets_are_said_to_be_so() {
    let summary = study(&(STRAIGHT.to_owned() + &CRITICALITY.replace("VALUE", "-0.9")), &[]);
    assert!(!summary.success());
    let inside = reason(&summary, "fit");
    assert!(inside.starts_with("no point of the box meets the targets; closest is lyapunov = -0."), "{inside}");
    assert!(number(&summary, "fit/UZ1", "residual lyapunov") > 0.5);
    let far = "free = [\"L\"]\nrange = { L = [10, 14] }\ntargets = { p = 600 }";
    let summary = study(&(STRAIGHT.to_owned() + far), &[]);
    let end = reason(&summary, "fit");
    assert!(end.contains("closest is p = 426.0909") && end.contains("L at the end of its range, 10"), "{end}");
    assert_eq!(number(&summary, "fit/UZ1", "L"), 10.0);
}

#[test]
fn results_do_not_depend_on_threads() {
    let results = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let text =
            STRAIGHT.to_owned() + "free = [\"k_N\"]\nrange = { k_N = [1e3, 1e5] }\ntargets = { p = 300 }\nstarts = 5";
        pool.install(|| study(&text, &[])).points
    };
    assert_eq!(results(1), results(3));
}

#[test]
fn bad_input_is_named() {
    let refused = |keys: &str, wanted: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("study.toml");
        std::fs::write(&path, STRAIGHT.to_owned() + keys).unwrap();
        let message = match run_scene(&path, &[], folder.path()) {
            Err(message) => message,
            Ok(summary) => reason(&summary, "fit").to_owned(),
        };
        assert!(message.contains(wanted), "{message:?} lacks {wanted:?}");
    };
    let range = "free = [\"L\"]\nrange = { L = [4, 30] }\n";
    refused(&format!("{range}targets = {{ q = 3 }}"), "unknown target \"q\"; allowed: p, omega, frequency, lyapunov");
    refused(range, "the key \"targets\" is missing");
    refused(&format!("{range}targets = {{}}"), "is empty; give { p = 450 }");
    refused(&format!("{range}targets = {{ p = {{ value = 3, sigma = 0 }} }}"), "greater than 0");
    refused(&format!("{range}targets = {{ p = {{ value = 3, sigma = 1 }}, omega = 3 }}"), "omega has none");
    refused("free = [\"L\"]\nrange = { L = [13, 30] }\ntargets = { p = 300 }", "the start has L = 12");
    refused("free = [\"L\"]\ntargets = { p = 300 }", "range");
    refused("free = [\"L\"]\nrange = { k_N = [1, 2] }\ntargets = { p = 300 }", "unknown free parameter \"k_N\"");
    let two = "free = [\"L\", \"k_N\"]\nrange = { L = [4, 30], k_N = [1, 1e5] }\n";
    refused(&format!("{two}targets = {{ p = 300 }}"), "2 unknowns (L, k_N) need at least as many targets; there are 1");
    refused("free = [\"p\"]\nrange = { p = [4, 30] }\ntargets = { omega = 300 }", "p is solved for at straight/HB1");
    refused("free = [\"x\"]\nrange = { x = [4, 30] }\ntargets = { omega = 300 }", "unknown parameter \"x\"");
    refused(&format!("{range}log = [\"p\"]\ntargets = {{ p = 300 }}"), "unknown free parameter \"p\"");
    refused(&format!("{range}targets = {{ p = 300 }}\nstarts = 0"), "whole number");
    refused(
        "free = [\"k_3N\"]\nrange = { k_3N = [0, 2e5] }\ntargets = { p = 300 }",
        "k_3N changes none of the targets",
    );
    let both = "free = [\"c_N\", \"EI\"]\nrange = { c_N = [0.001, 0.01], EI = [100, 1000] }\n";
    refused(&format!("{both}targets = {{ omega = 150, frequency = 25 }}"), "no point of the box meets the targets");
}

/// The Lyapunov coefficient does not exist at any point of the box: the fit says so, and ends.
#[test]
fn a_quantity_that_is_not_finite_ends_the_fit() {
    let text = "
        [model]
        equations = \"\"\"
        x' = mu*x - om*y - x*sqrt(x^2 + 1e-300) - k*x*y^2
        y' = om*x + mu*y - k*y^3
        \"\"\"
        [model.parameters]
        mu = -0.5
        om = 1.1
        k = 1
        [[task]]
        name = \"rest\"
        kind = \"equilibria\"
        free = \"mu\"
        range = [-1, 1]
        detect = [\"HB\"]
        [[task]]
        name = \"fit\"
        kind = \"calibration\"
        from = \"rest/HB1\"
        free = [\"k\"]
        range = { k = [0.5, 20] }
        targets = { lyapunov = -0.5 }
        ";
    let summary = study(text, &[]);
    assert!(!summary.success());
}
