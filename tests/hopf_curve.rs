//! Hopf curves: systems with known curves and points of codimension two, and the two-doublet flagellum's numbers.

mod common;

use hopfline::bifurcation::{Coordinate, Hopf, HopfCurve, HopfNormalForm, HopfSegment, Test, reverse};
use hopfline::continuation::{Counts, StepControl, Walk};
use hopfline::linalg::c64;
use hopfline::problem::{Automatic, Bounds, Default, Formula, Parameter, Problem, Scalar};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::path::Path;
use std::sync::Arc;

/// u' = f(u, (a, b)) with two parameters.
struct Small<F> {
    dim: usize,
    parameters: [Parameter; 2],
    field: F,
}

/// A vector field over any scalar.
trait Field: Send + Sync {
    fn at<S: Scalar>(&self, u: &[S], a: S, b: S) -> Vec<S>;
}

fn small<F: Field + 'static>(dim: usize, field: F) -> Arc<dyn Problem> {
    let make = |name| Parameter { name, default: Default::Value(0.0), unit: "", meaning: "", bounds: Bounds::Any };
    Arc::new(Automatic(Small { dim, parameters: [make("a"), make("b")], field }))
}

impl<F: Field> Formula for Small<F> {
    fn dim(&self) -> usize {
        self.dim
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        for (g, (&v, f)) in g.iter_mut().zip(v.iter().zip(self.field.at(u, p[0], p[1]))) {
            *g = v - f;
        }
    }
}

const A: usize = 0;
const B: usize = 1;

fn plain(index: usize) -> Coordinate {
    Coordinate { index, logarithmic: false, width: 1.0 }
}

/// The Hopf point near (u, p) with `free` solved for, from a rough eigenvector.
fn hopf(problem: &Arc<dyn Problem>, u: &[f64], p: [f64; 2], free: usize, omega: f64) -> Hopf {
    let mut q = vec![c64::new(0.1, 0.05); u.len()];
    (q[0], q[1]) = (c64::new(1.0, 0.0), c64::new(0.1, -0.8));
    Hopf::locate(&**problem, (u, &p), free, omega, &q).unwrap()
}

/// Both ways from a Hopf point, second coordinate increasing; at most `most` steps each way.
fn follow(
    problem: &Arc<dyn Problem>,
    hopf: &Hopf,
    coordinates: (Coordinate, Coordinate),
    range: (f64, f64),
    most: usize,
) -> Vec<HopfSegment> {
    let mut counts = Counts::default();
    let (curve, point) = HopfCurve::start(problem.clone(), hopf, coordinates, &mut counts).unwrap();
    let mut back = point.clone();
    reverse(&mut back);
    let one_way = |start| {
        let mut system = curve.clone();
        let control = StepControl { step: 0.01, least: 1e-7, most: 0.05 };
        let mut walk = Walk::new(&mut system, start, control, range);
        let mut segments = Vec::new();
        while segments.len() < most {
            let step = walk.step().unwrap();
            let stop = step.stop.is_some();
            segments.push(HopfSegment { curve: walk.system.clone(), from: step.from, to: step.to });
            if stop {
                break;
            }
        }
        segments
    };
    let mut segments: Vec<HopfSegment> = one_way(back);
    segments.reverse();
    segments.extend(one_way(point));
    segments
}

/// Both parameters where a test vanishes, for each segment in which it does.
fn located(segments: &[HopfSegment], test: Test) -> Vec<[f64; 2]> {
    let found = segments.iter().filter_map(|s| Some((s, s.locate(test, &mut Counts::default()).unwrap()?)));
    found
        .map(|(s, point)| {
            let p = s.curve.parameters(&point);
            [p[A], p[B]]
        })
        .collect()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} to {tolerance:e}");
}

/// The rotation of frequency omega with growth rate and cubic coefficient.
fn rotor<S: Scalar>(x: S, y: S, growth: S, omega: f64, cubic: S) -> [S; 2] {
    let r2 = x * x + y * y;
    let rate = growth + cubic * r2;
    [rate * x - y * omega, rate * y + x * omega]
}

/// Hopf points at b = a², l1 = 2 (a - 1/2): a Bautin point at (1/2, 1/4), a fold of the curve in b at 0.
struct Bautin;
impl Field for Bautin {
    fn at<S: Scalar>(&self, u: &[S], a: S, b: S) -> Vec<S> {
        rotor(u[0], u[1], b - a * a, 1.0, a - 0.5).to_vec()
    }
}

#[test]
fn a_curve_turns_in_its_second_parameter_and_shows_its_bautin_point() {
    let problem = small(2, Bautin);
    let start = hopf(&problem, &[0.0, 0.0], [-0.8, 0.6], B, 1.1);
    let segments = follow(&problem, &start, (plain(A), plain(B)), (-1.0, 1.0), 200);
    for segment in &segments {
        let p = segment.curve.parameters(&segment.to);
        close(p[B], p[A] * p[A], 1e-10);
        let hopf = segment.curve.hopf(&segment.to, B).unwrap();
        close(hopf.omega, 1.0, 1e-13);
        close(HopfNormalForm::new(&*problem, &hopf).unwrap().l1, 2.0 * (p[A] - 0.5), 1e-9);
    }
    let ends = [&segments[0], &segments[segments.len() - 1]].map(|s| s.curve.parameters(&s.to)[A]);
    close(ends[0].abs(), 1.0, 1e-9);
    close(ends[0] + ends[1], 0.0, 1e-9);
    let found = located(&segments, Test::Criticality);
    assert_eq!(found.len(), 1);
    close(found[0][A], 0.5, 1e-9);
    close(found[0][B], 0.25, 1e-9);
}

/// x' = y, y' = a + b y + x² + x y (Guckenheimer and Holmes 1983, section 7.3): Hopf points at a = -b², b > 0, with
/// omega² = 2 b; the Bogdanov-Takens point is the origin.
struct Takens;
impl Field for Takens {
    fn at<S: Scalar>(&self, u: &[S], a: S, b: S) -> Vec<S> {
        vec![u[1], a + b * u[1] + u[0] * u[0] + u[0] * u[1]]
    }
}

#[test]
fn the_system_is_regular_through_a_bogdanov_takens_point() {
    let problem = small(2, Takens);
    let start = hopf(&problem, &[-0.7, 0.0], [-0.5, 0.7], A, 1.2);
    let segments = follow(&problem, &start, (plain(A), plain(B)), (-0.5, 1.0), 200);
    for segment in &segments {
        let p = segment.curve.parameters(&segment.to);
        // Beyond the point the curve goes on as one of neutral saddles.
        close(p[A], -p[B] * p[B], 1e-10);
        close(segment.curve.kappa(&segment.to), 2.0 * p[B], 1e-9);
    }
    close(segments[0].to.lambda, -0.5, 1e-12);
    let found = located(&segments, Test::Frequency);
    assert_eq!(found.len(), 1);
    close(found[0][A], 0.0, 1e-12);
    close(found[0][B], 0.0, 1e-12);
}

/// z' = a - z², an oscillator with growth b + z: Hopf points at z = -b, a = b²; zero-Hopf at the origin.
struct ZeroHopf;
impl Field for ZeroHopf {
    fn at<S: Scalar>(&self, u: &[S], a: S, b: S) -> Vec<S> {
        let [x, y] = rotor(u[0], u[1], b + u[2], 1.3, S::from(-1.0));
        vec![x, y, a - u[2] * u[2] + u[0] * u[0] * 0.3]
    }
}

#[test]
fn a_curve_passes_a_zero_hopf_point() {
    let problem = small(3, ZeroHopf);
    let start = hopf(&problem, &[0.0, 0.0, 0.4], [0.2, -0.4], A, 1.2);
    let segments = follow(&problem, &start, (plain(A), plain(B)), (-1.0, 1.0), 200);
    for segment in &segments {
        let p = segment.curve.parameters(&segment.to);
        close(p[A], p[B] * p[B], 1e-10);
    }
    let found = located(&segments, Test::Steady);
    assert_eq!(found.len(), 1);
    close(found[0][A], 0.0, 1e-12);
    close(found[0][B], 0.0, 1e-12);
    // l1 has a pole there, which is no Bautin point; its one zero is elsewhere.
    let bautin = located(&segments, Test::Criticality);
    assert!(bautin.len() == 1 && bautin[0][B].abs() > 0.01, "{bautin:?}");
}

/// Two oscillators: Hopf points of the first at a = b², of the second at b = 0.3.
struct Double;
impl Field for Double {
    fn at<S: Scalar>(&self, u: &[S], a: S, b: S) -> Vec<S> {
        let minus = S::from(-1.0);
        let [x, y] = rotor(u[0], u[1], a - b * b, 1.0, minus);
        let [z, w] = rotor(u[2], u[3], b - 0.3, 1.7, minus);
        vec![x + u[2] * u[2], y, z + u[0] * u[1] * 0.5, w]
    }
}

#[test]
fn another_pair_on_the_axis_makes_a_double_hopf_point() {
    let problem = small(4, Double);
    let start = hopf(&problem, &[0.0; 4], [0.2, -0.5], A, 1.02);
    let segments = follow(&problem, &start, (plain(A), plain(B)), (-1.0, 1.0), 200);
    let mut found = Vec::new();
    for segment in &segments {
        let others = [&segment.from, &segment.to].map(|point| segment.curve.others(point).unwrap());
        for test in HopfSegment::crossing_pairs(&others[0], &others[1]) {
            let Test::Pair(from, to) = test else { panic!("a pair") };
            let point = segment.locate(test, &mut Counts::default()).unwrap().unwrap();
            close(segment.pair(from, to, &point).unwrap().im, 1.7, 1e-12);
            found.push(segment.curve.parameters(&point));
        }
    }
    assert_eq!(found.len(), 1);
    close(found[0][A], 0.09, 1e-11);
    close(found[0][B], 0.3, 1e-11);
}

/// Hopf points at log10 a = b: straight in the logarithm over ten decades.
struct Decades;
impl Field for Decades {
    fn at<S: Scalar>(&self, u: &[S], a: S, b: S) -> Vec<S> {
        rotor(u[0], u[1], a.ln() * (1.0 / std::f64::consts::LN_10) - b, 1.0, S::from(-1.0)).to_vec()
    }
}

#[test]
fn a_logarithmic_parameter_covers_decades() {
    let problem = small(2, Decades);
    let start = hopf(&problem, &[0.0, 0.0], [12.0, 1.0], A, 1.0);
    let logarithmic = Coordinate { index: A, logarithmic: true, width: 10.0 };
    let wide = Coordinate { index: B, logarithmic: false, width: 10.0 };
    let segments = follow(&problem, &start, (wide, logarithmic), (-5.0, 5.0), 200);
    for segment in &segments {
        let p = segment.curve.parameters(&segment.to);
        close(p[A].log10(), p[B], 1e-10);
    }
    assert!(segments.len() < 100);
    let ends = [&segments[0], &segments[segments.len() - 1]].map(|s| s.to.lambda);
    assert_eq!(ends, [-5.0, 5.0]);
}

/// Runs a scene of `problems` or of text, with nothing printed.
fn study(name: &str, text: Option<&str>, sets: &[&str]) -> Summary {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems").join(format!("{name}.toml"));
    let scene = match text {
        Some(text) => Scene::parse(text, &path, &sets),
        None => Scene::load(&path, &sets),
    };
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    run(&scene.unwrap(), &options).unwrap()
}

fn number(summary: &Summary, label: &str, name: &str) -> f64 {
    let reasons: Vec<&str> = summary.tasks.iter().map(|task| task.reason.as_str()).collect();
    let point = summary.points.iter().find(|p| p.label == label).unwrap_or_else(|| panic!("no {label}: {reasons:?}"));
    *point.parameters.get(name).or(point.values.get(name)).unwrap()
}

fn matches(summary: &Summary, label: &str, p: f64, omega: f64) {
    close(number(summary, label, "p") / p, 1.0, 1e-9);
    close(number(summary, label, "omega") / omega, 1.0, 1e-9);
}

/// The panel flutters without tension at lambda = 343: where the tension passes zero, its relative error says nothing.
#[test]
fn a_parameter_may_pass_zero() {
    let text = r#"
[model]
name = "panel"
functions = 8
[parameters]
R = 0.02
g = 1
[[task]]
name = "flat"
kind = "equilibria"
free = "lambda"
range = [340, 350]
detect = ["HB"]
[[task]]
name = "onset"
kind = "hopf-curve"
from = "flat/HB1"
free = ["R", "lambda"]
range = { R = [-1, 1], lambda = [330, 360] }
"#;
    let summary = study("panel", Some(text), &[]);
    assert_eq!(summary.tasks[1].reason, "end of the range");
    let ends = ["onset/EP1", "onset/EP2"].map(|label| number(&summary, label, "R"));
    assert!(ends[0] * ends[1] < 0.0, "{ends:?}");
}

/// Hopf points at a = b², folds at c² = 4 b³/9.
#[test]
fn a_curve_may_start_at_a_wanted_value() {
    let text = r#"
[model]
equations = """
x' = (a - b^2)*x - y - x*(x^2 + y^2)
y' = x + (a - b^2)*y - y*(x^2 + y^2)
z' = c + b*z - z^3/3
"""
[model.parameters]
a = 0
b = 1
c = 5
[model.start]
z = 3
[[task]]
name = "rest"
kind = "equilibria"
free = "a"
range = [0, 2]
detect = ["HB"]
[[task]]
name = "onset"
kind = "hopf-curve"
from = "rest/HB1"
free = ["a", "b"]
range = { b = [0.5, 2] }
values = { b = [0.7, 1, 1.5] }
[[task]]
name = "shifted"
kind = "equilibria"
free = "c"
range = [-5, 5]
start = 5
detect = ["LP"]
[[task]]
name = "folds"
kind = "fold-curve"
from = "shifted/LP1"
free = ["c", "b"]
range = { b = [0.5, 2] }
values = { b = [0.7, 1, 1.5] }
"#;
    let summary = study("wanted", Some(text), &[]);
    for task in ["onset", "folds"] {
        let wanted = ["UZ1", "UZ2", "UZ3"].map(|label| number(&summary, &format!("{task}/{label}"), "b"));
        assert_eq!(wanted, [0.7, 1.0, 1.5], "{task}");
    }
    close(number(&summary, "onset/UZ2", "a"), 1.0, 1e-12);
}

#[test]
fn the_curve_in_the_length_meets_the_table_with_both_conventions() {
    let fixed = study("onset-L", None, &[]);
    assert!(fixed.success(), "{}", fixed.table(""));
    matches(&fixed, "onset/UZ1", 426.090903937, 257.436661609);
    let tied = study("onset-L", None, &["parameters.tau_c=\"tau / 200\""]);
    matches(&tied, "onset/UZ1", 427.829901502, 508.416715403);
    // p_H falls with L.
    for summary in [&fixed, &tied] {
        assert!(number(summary, "onset/EP1", "p") > number(summary, "onset/UZ1", "p"));
        assert!(number(summary, "onset/UZ1", "p") > number(summary, "onset/EP2", "p"));
        assert_eq!([number(summary, "onset/EP1", "L"), number(summary, "onset/EP2", "L")], [4.0, 30.0]);
    }
}

#[test]
fn points_of_the_curve_are_those_of_fresh_runs() {
    let curve = study("onset-L", None, &["task.onset.values={ L = [7, 20] }"]);
    for (label, length) in [("onset/UZ1", 7), ("onset/UZ2", 20)] {
        let sets = [format!("parameters.L={length}"), "task.straight.range=[0, 1000]".to_owned()];
        let fresh = study("onset-L", None, &[&sets[0], &sets[1], "task.onset.max_points=2"]);
        matches(&curve, label, number(&fresh, "straight/HB1", "p"), number(&fresh, "straight/HB1", "omega"));
    }
}

#[test]
fn the_curve_in_the_stiffness_covers_seven_decades() {
    let summary = study("onset-kN", None, &[]);
    assert!(summary.success(), "{}", summary.table(""));
    matches(&summary, "onset/UZ1", 136.356825057, 351.258231833);
    // p_H rises with k_N, the frequency falls.
    let of = |name| ["onset/EP1", "onset/UZ1", "onset/EP2"].map(|label| number(&summary, label, name));
    assert!(of("p").is_sorted() && of("frequency").iter().rev().is_sorted());
}

#[test]
fn the_curve_reaches_a_stiffness_of_zero() {
    let sets = ["task.onset.log=[]", "task.onset.range={ k_N = [0, 2e4] }", "model.functions=28"];
    let summary = study("onset-kN", None, &sets);
    assert_eq!(number(&summary, "onset/EP1", "k_N"), 0.0);
    matches(&summary, "onset/EP1", 21.497443667, 1049.312744222);
}

/// Where the beats' criticality changes along the curve in k_N, with the sign that the outer cycle's stability has.
#[test]
fn a_bautin_point_comes_with_its_second_coefficient() {
    let at = |functions: usize| {
        let summary = study("onset-k3N", None, &[&format!("model.functions={functions}")]);
        let point = summary.points.iter().find(|p| p.label == "onset/GH1").unwrap().clone();
        (point.values["lyapunov_2"], point.errors["lyapunov_2"])
    };
    let ((coarse, estimate), (fine, _)) = (at(28), at(40));
    assert!(fine > 0.0);
    assert!((coarse - fine).abs() <= 3.0 * estimate, "{coarse} ± {estimate}, {fine}");
}

#[test]
fn the_curve_in_the_time_constant_covers_six_decades() {
    let text = "
        [model]
        name = \"two-doublet\"
        functions = 28
        [[task]]
        name = \"straight\"
        kind = \"equilibria\"
        free = \"p\"
        range = [0, 400]
        detect = [\"HB\"]
        [[task]]
        name = \"onset\"
        kind = \"hopf-curve\"
        from = \"straight/HB1\"
        free = [\"p\", \"tau_c\"]
        log = [\"tau_c\"]
        range = { tau_c = [1e-6, 1] }
        values = { tau_c = [1e-4] }";
    let summary = study("time-constant", Some(text), &[]);
    assert!(summary.success(), "{}", summary.table(""));
    matches(&summary, "onset/UZ1", 342.691293674, 1426.587683351);
    let omega = ["onset/EP1", "onset/EP2"].map(|label| number(&summary, label, "omega"));
    assert!(omega[0] / omega[1] > 1e4, "{omega:?}");
    close(number(&summary, "onset/EP2", "tau_c"), 1.0, 1e-15);
}

#[test]
fn geometry_alone_is_subcritical_with_either_law() {
    for (law, expected) in [("printed", 2.42e4), ("separation", 5.41e4)] {
        let at = |functions: usize| {
            let sets = [format!("model.law=\"{law}\""), format!("model.functions={functions}")];
            number(&study("onset-k3N", None, &[&sets[0], &sets[1]]), "onset/GH1", "k_3N")
        };
        let (coarse, fine) = (at(28), at(36));
        close(coarse / expected, 1.0, 1e-3);
        close(coarse / fine, 1.0, 1e-7);
    }
}

#[test]
fn bad_input_is_named() {
    let refused = |sets: &[&str], wanted: &str| common::refused("onset-L", sets, wanted);
    refused(&["task.onset.from=\"straight/EP1\""], "the start must be a Hopf point");
    refused(&["task.onset.kind=\"fold-curve\""], "the start must be a fold");
    refused(&["task.straight.start=500"], "outside the range 0 to 400");
    refused(&["task.onset.from=\"straight/GH1\""], "points of codimension two are on curves");
    refused(&["task.onset.free=[\"p\", \"p\"]"], "given twice");
    refused(&["task.onset.free=[\"p\"]"], "two names");
    refused(&["task.onset.free=[\"p\", \"tau\"]", "task.onset.range={ tau = [1, 2] }"], "values");
    refused(
        &["task.onset.range={ L = [13, 30] }", "task.onset.values={ L = [20] }"],
        "start has L = 12, which does not lie inside the range 13 to 30",
    );
    refused(&["task.onset.range={ p = [100, 200] }"], "the range of \"L\" is missing");
    refused(&["task.onset.range={ L = [4, 30], p = [0, 100] }"], "start has p = 338.88");
    refused(&["task.onset.log=[\"L\"]", "task.onset.range={ L = [0, 30] }"], "logarithmic");
    refused(&["task.onset.log=[\"k_N\"]"], "unknown free parameter \"k_N\"");
    refused(&["task.onset.values={ L = [40] }"], "outside the range 4 to 30");
    refused(&["task.onset.max_step=1"], "unknown key of a hopf-curve task \"max_step\"");
    let cubic = ["task.onset.values={ k_3N = [5e4] }", "task.onset.range={ k_3N = [0, 2e5] }"];
    refused(&["task.onset.free=[\"k_3T\", \"k_3N\"]", cubic[0], cubic[1]], "moves the Hopf point");
    // Viscosities of their own leave nothing for the time constant to do.
    let idle = [
        "task.onset.free=[\"p\", \"tau_c\"]",
        "task.onset.range={ tau_c = [0, 1] }",
        "task.onset.values={ tau_c = [0.5] }",
    ];
    refused(&["parameters.b_N=7.776", "parameters.b_T=0.7776", idle[0], idle[1], idle[2]], "tau_c changes neither");
}

/// Along mu = 0, where parts of mu mean nothing: the first Lyapunov coefficient vanishes where om = c + 13/150 or so.
#[test]
fn a_bautin_point_is_found_where_the_parameter_is_zero() {
    let text = r#"
[model]
equations = """
x' = mu*x - om*y + (om - 1.5)*x*(x^2 + y^2) + 0.3*z*x
y' = om*x + mu*y + (om - 1.5)*y*(x^2 + y^2) - 0.7*x*y
z' = -z + x*y + 0.1*x
"""
[model.parameters]
mu = -0.5
om = 1.1
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-1, 1]
detect = ["HB"]
[[task]]
name = "curve"
kind = "hopf-curve"
from = "rest/HB1"
free = ["mu", "om"]
range = { om = [0.5, 3] }
"#;
    let summary = study("bautin", Some(text), &[]);
    let point = summary.points.iter().find(|point| point.label == "curve/GH1").unwrap();
    assert!(point.parameters["mu"].abs() < 1e-12 && point.values["lyapunov"].abs() < 1e-9, "{point:?}");
}
