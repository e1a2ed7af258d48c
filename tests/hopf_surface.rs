//! Hopf surfaces: systems with known surfaces, and the two-doublet flagellum's numbers.

mod common;

use hopfline::bifurcation::{Coordinate, Hopf, HopfNormalForm, HopfSurface};
use hopfline::branch::{Branch, BranchKind, read_branch, read_triangles};
use hopfline::continuation::{Bound, Cover, CoverControl};
use hopfline::linalg::c64;
use hopfline::problem::{Automatic, Bounds, Default, Formula, Parameter, Problem, Scalar};
use hopfline::run::{RunOptions, Summary, redraw, run};
use hopfline::scene::Scene;
use std::path::Path;
use std::sync::Arc;

/// u' = f(u, (a, b, c)).
struct Small<F> {
    dim: usize,
    parameters: [Parameter; 3],
    field: F,
}

trait Field: Send + Sync {
    fn at<S: Scalar>(&self, u: &[S], p: &[S]) -> Vec<S>;
}

fn small<F: Field + 'static>(dim: usize, field: F) -> Arc<dyn Problem> {
    let make = |name| Parameter { name, default: Default::Value(0.0), unit: "", meaning: "", bounds: Bounds::Any };
    Arc::new(Automatic(Small { dim, parameters: [make("a"), make("b"), make("c")], field }))
}

impl<F: Field> Formula for Small<F> {
    fn dim(&self) -> usize {
        self.dim
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        for (g, (&v, f)) in g.iter_mut().zip(v.iter().zip(self.field.at(u, p))) {
            *g = v - f;
        }
    }
}

/// The surface from the Hopf point near (u, p), with the first parameter solved for there, in a box.
fn covered(
    problem: &Arc<dyn Problem>,
    (u, p, omega): (&[f64], [f64; 3], f64),
    ranges: [(f64, f64); 3],
) -> Cover<HopfSurface> {
    let q = [c64::new(1.0, 0.0), c64::new(0.1, -0.8)];
    let hopf = Hopf::locate(&**problem, (u, &p), 0, omega, &q).unwrap();
    let coordinate = |index: usize| Coordinate { index, logarithmic: false, width: ranges[index].1 - ranges[index].0 };
    let (surface, x) = HopfSurface::start(problem.clone(), &hopf, [0, 1, 2].map(coordinate));
    let mut bounds = Vec::new();
    for (place, (low, high)) in surface.places().into_iter().zip(ranges) {
        bounds.push(Bound { coordinate: place, upper: false, value: low });
        bounds.push(Bound { coordinate: place, upper: true, value: high });
    }
    bounds.push(surface.end());
    let control = CoverControl { tolerance: 5e-3, largest: 0.1 };
    let mut cover = Cover::start(&surface, &x, &surface.places(), bounds, control).unwrap();
    while cover.step() {}
    assert!(cover.failures.is_empty(), "{:?}", cover.failures);
    cover
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} to {tolerance:e}");
}

/// Hopf points at a = b² - c² with omega = 1 + 0.3 b and l1 = 2 (c - 0.2) / omega.
struct Saddle;
impl Field for Saddle {
    fn at<S: Scalar>(&self, u: &[S], p: &[S]) -> Vec<S> {
        let (x, y) = (u[0], u[1]);
        let rate = p[0] - p[1] * p[1] + p[2] * p[2] + (p[2] - 0.2) * (x * x + y * y);
        let omega = p[1] * 0.3 + 1.0;
        vec![rate * x - omega * y, rate * y + omega * x]
    }
}

#[test]
fn a_saddle_is_covered_exactly_with_its_criticality() {
    let problem = small(2, Saddle);
    let cover = covered(&problem, (&[0.0, 0.0], [0.05, 0.2, 0.1], 1.05), [(-2.0, 2.0), (-1.0, 1.0), (-1.0, 1.0)]);
    let mut corners = 0;
    for chart in &cover.charts {
        let p = chart.surface.parameters(&chart.x);
        close(p[0], p[1] * p[1] - p[2] * p[2], 1e-9);
        let hopf = chart.surface.hopf(&chart.x, &p, chart.surface.solvable(chart, &[])).unwrap();
        close(hopf.p[0], hopf.p[1] * hopf.p[1] - hopf.p[2] * hopf.p[2], 1e-14);
        close(hopf.omega, 1.0 + 0.3 * p[1], 1e-13);
        let l1 = HopfNormalForm::new(&*problem, &hopf).unwrap().l1;
        close(l1, 2.0 * (p[2] - 0.2) / hopf.omega, 1e-12);
        corners += usize::from(chart.on.len() == 2);
    }
    assert_eq!(corners, 4);
    let area: f64 = cover
        .triangles()
        .iter()
        .map(|t| {
            let [p, q, r] = t.map(|i| cover.charts[i].surface.parameters(&cover.charts[i].x));
            0.5 * ((q[1] - p[1]) * (r[2] - p[2]) - (q[2] - p[2]) * (r[1] - p[1]))
        })
        .sum();
    // Seen along a, the surface is the whole square, whichever way it is turned.
    close(area.abs(), 4.0, 1e-12);
}

/// x' = y, y' = a + c + b y + x² + x y: Hopf points at a + c = -b², b > 0, with omega² = 2 b.
struct Takens;
impl Field for Takens {
    fn at<S: Scalar>(&self, u: &[S], p: &[S]) -> Vec<S> {
        vec![u[1], p[0] + p[2] + p[1] * u[1] + u[0] * u[0] + u[0] * u[1]]
    }
}

#[test]
fn a_surface_ends_at_bogdanov_takens_points() {
    let problem = small(2, Takens);
    let cover = covered(&problem, (&[-0.7, 0.0], [-0.5, 0.7, 0.0], 1.2), [(-3.0, 3.0), (-1.0, 1.0), (-1.0, 1.0)]);
    let mut last = Vec::new();
    for chart in &cover.charts {
        let p = chart.surface.parameters(&chart.x);
        close(p[0] + p[2], -p[1] * p[1], 1e-9);
        close(chart.surface.kappa(&chart.x), 2.0 * p[1], 1e-6);
        assert!(p[1] > -1e-9);
        if chart.on.contains(&6) {
            close(p[1], 0.0, 1e-9);
            last.push(p[2]);
        }
    }
    let ends = last.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| (low.min(*c), high.max(*c)));
    assert!(last.len() > 5);
    close(ends.0, -1.0, 1e-12);
    close(ends.1, 1.0, 1e-12);
}

fn scene(sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    Scene::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/onset-surface.toml"), &sets).unwrap()
}

fn study(sets: &[&str], out: &Path) -> Summary {
    let options = RunOptions { out: out.to_owned(), only: Vec::new(), resume: false, quiet: true };
    run(&scene(sets), &options).unwrap()
}

fn stored(out: &Path, summary: &Summary) -> Branch {
    let line = summary.branches.iter().find(|line| line.kind == BranchKind::HopfSurface).unwrap();
    let folder = out.join("onset-surface");
    let mut branch = read_branch(&folder.join(&line.file), &line.name, line.kind, &line.free).unwrap();
    branch.triangles = read_triangles(&folder.join("meshes/surface.ply"), branch.rows.len()).unwrap();
    branch
}

fn number(branch: &Branch, row: usize, name: &str) -> f64 {
    branch.rows[row].values[branch.column(name).unwrap()].unwrap()
}

const RANGE: &str = "task.surface.range={ p = [0, 1000], L = [10, 12], k_N = [1e3, 1e4] }";

#[test]
fn the_surface_meets_the_table_and_fresh_runs() {
    let out = tempfile::tempdir().unwrap();
    let summary = study(&[RANGE, "task.surface.tolerance=2e-2"], out.path());
    assert!(summary.success(), "{}", summary.table(""));
    let branch = stored(out.path(), &summary);
    // The corners of the box, of which two are in the table.
    for (length, stiffness, p, omega) in
        [(12.0, 1e3, 136.356825057, 351.258231833), (10.0, 1e4, 426.090903937, 257.436661609)]
    {
        let at = |row: &usize| number(&branch, *row, "L") == length && number(&branch, *row, "k_N") == stiffness;
        let corner = (0..branch.rows.len()).find(at).expect("a point at the corner of the box");
        close(number(&branch, corner, "p") / p, 1.0, 1e-9);
        close(number(&branch, corner, "omega") / omega, 1.0, 1e-9);
        assert!(number(&branch, corner, "error p") < 1e-6);
    }
    for row in [branch.rows.len() / 3, branch.rows.len() - 2] {
        let at = |name: &str| format!("parameters.{name}={:?}", number(&branch, row, name));
        let fresh = tempfile::tempdir().unwrap();
        let options =
            RunOptions { out: fresh.path().to_owned(), only: vec!["straight".into()], resume: false, quiet: true };
        let fresh = run(&scene(&[&at("L"), &at("k_N"), "task.straight.range=[0, 600]"]), &options).unwrap();
        let point = fresh.points.iter().find(|point| point.label == "straight/HB1").unwrap();
        close(number(&branch, row, "p") / point.parameters["p"], 1.0, 1e-9);
        close(number(&branch, row, "omega") / point.values["omega"], 1.0, 1e-9);
        close(number(&branch, row, "lyapunov") / point.values["lyapunov"], 1.0, 1e-6);
    }
    // What is stored is enough to draw the same figure.
    let figure = out.path().join("onset-surface/figures/surface.svg");
    let before = std::fs::read_to_string(&figure).unwrap();
    assert!(before.len() < 1_000_000 && before.matches("<polygon").count() > branch.triangles.len());
    std::fs::remove_file(&figure).unwrap();
    redraw(&out.path().join("onset-surface")).unwrap();
    assert_eq!(std::fs::read_to_string(&figure).unwrap(), before);
}

#[test]
fn threads_change_nothing() {
    let texts = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let out = tempfile::tempdir().unwrap();
        let summary = pool.install(|| study(&["task.surface.max_points=60"], out.path()));
        let reason = &summary.tasks.iter().find(|task| task.name == "surface").unwrap().reason;
        assert!(reason.starts_with("max_points reached"), "{reason}");
        ["branches/surface.csv", "meshes/surface.ply"]
            .map(|name| std::fs::read_to_string(out.path().join("onset-surface").join(name)).unwrap())
    });
    assert_eq!(texts[0], texts[1]);
    assert!(texts[0][0].lines().count() == 61 && texts[0][1].contains("\n3 0 "));
}

#[test]
fn bad_input_is_named() {
    let refused = |sets: &[&str], wanted: &str| common::refused("onset-surface", sets, wanted);
    refused(&["task.surface.from=\"straight/EP1\""], "the start must be a Hopf point");
    refused(&["task.surface.free=[\"p\", \"L\"]"], "three names");
    refused(&["task.surface.free=[\"p\", \"L\", \"tau\"]"], "unknown free parameter \"k_N\"");
    refused(&["task.surface.range={ p = [0, 1000], L = [6, 20] }"], "the range of \"k_N\" is missing");
    refused(&["task.surface.range={ p = [0, 1000], L = [6, 20], k_N = [0, 1e5] }"], "logarithmic");
    refused(
        &["task.surface.range={ p = [0, 1000], L = [13, 20], k_N = [1e2, 1e5] }"],
        "start has L = 12, which does not lie inside the range 13 to 20",
    );
    refused(&["task.surface.tolerance=1"], "up to 0.1");
    refused(&["task.surface.values={ L = [10] }"], "unknown key of a hopf-surface task \"values\"");
    refused(
        &[
            "task.surface.free=[\"k_3T\", \"k_3N\", \"c_T\"]",
            "task.surface.log=[\"k_3T\"]",
            "task.surface.range={ k_3T = [1, 1e4], k_3N = [0, 2e5], c_T = [1e-3, 2e-3] }",
        ],
        "there is no surface in these parameters",
    );
    refused(&["figure.surface.view=[30, 100]"], "elevations from 0 to 90");
    refused(&["figure.surface.view=[30]"], "[azimuth, elevation]");
}
