//! Eigenvalue branches in any parameter, plain and logarithmic: exceptional points of systems with known ones, and the
//! flagellum's Hopf points in its length and stiffness.

mod common;

use common::{Flagellum, close, near, parameter};
use hopfline::bifurcation::{Coordinate, Equilibria, Mark, Sample, Spectra};
use hopfline::continuation::{Counts, Point};
use hopfline::models::{Law, Load};
use hopfline::problem::{Automatic, Formula, Parameter, Scalar};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::sync::Arc;

/// Damped oscillator x'' + 2 c x' + x = 0 beside a slow decay: its eigenvalues meet at c = 1, at -1.
struct Oscillator([Parameter; 1]);

impl Formula for Oscillator {
    fn dim(&self) -> usize {
        3
    }

    fn parameters(&self) -> &[Parameter] {
        &self.0
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        g[0] = v[0] - u[1];
        g[1] = v[1] + p[0] * u[1] * 2.0 + u[0];
        g[2] = v[2] + u[2] * 0.25;
    }
}

/// Two overdamped links each, under a circulatory load: u' = [[-1, p], [-p, -3]] u has eigenvalues
/// -2 ± sqrt(1 - p²), u' = [[-5, 2 p], [-2 p, -6]] u has -5.5 ± sqrt(1/4 - 4 p²); a rotation by 0.7 mixes the two.
struct Links([Parameter; 1]);

impl Formula for Links {
    fn dim(&self) -> usize {
        4
    }

    fn parameters(&self) -> &[Parameter] {
        &self.0
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (sine, cosine) = 0.7_f64.sin_cos();
        let turn = |x: S, y: S, sign: f64| [x * cosine - y * (sign * sine), x * (sign * sine) + y * cosine];
        let ([a, c], [b, d]) = (turn(u[0], u[2], 1.0), turn(u[1], u[3], 1.0));
        let (first, second) = (b * p[0] - a, -(a * p[0]) - b * 3.0);
        let (third, fourth) = (d * p[0] * 2.0 - c * 5.0, -(c * p[0] * 2.0) - d * 6.0);
        let ([w, y], [x, z]) = (turn(first, third, -1.0), turn(second, fourth, -1.0));
        for (g, (v, f)) in g.iter_mut().zip(v.iter().zip([w, x, y, z])) {
            *g = *v - f;
        }
    }
}

/// Parameter values and means of the exceptional points of a linear system between two values of its parameter.
fn exceptional<F: Formula + 'static>(formula: F, (low, high): (f64, f64), logarithmic: bool) -> Vec<(f64, f64)> {
    let dim = formula.dim();
    let mut coordinate = Coordinate { index: 0, logarithmic, width: 1.0 };
    let (from, to) = (coordinate.of(low), coordinate.of(high));
    coordinate.width = to - from;
    let system = Equilibria {
        problem: Arc::new(Automatic(formula)),
        p: vec![0.0],
        coordinate,
        scale_state: 1.0,
        all_eigenvalues: None,
    };
    let point = |k: usize| Point {
        x: vec![0.0; dim],
        lambda: from + (to - from) * k as f64 / 20.0,
        tangent: vec![0.0; dim],
        tangent_lambda: to - from,
    };
    let mut samples: Vec<Sample> = (0..=20).map(|k| Sample::new(point(k), None)).collect();
    let mut counts = Counts::default();
    let tool = Spectra::new(&system, dim, &|| false, &mut samples, &mut counts).unwrap();
    tool.follow(&mut samples, &mut counts).unwrap();
    let marked = samples.iter().filter_map(|sample| match sample.mark {
        Some(Mark::Exceptional(mean)) => Some((coordinate.value(sample.point.lambda), mean.re)),
        _ => None,
    });
    marked.collect()
}

#[test]
fn an_oscillator_is_critically_damped_at_one() {
    for logarithmic in [false, true] {
        let found = exceptional(Oscillator([parameter("c", 0.5)]), (0.23, 3.1), logarithmic);
        assert_eq!(found.len(), 1, "{found:?}");
        near("c", found[0].0, 1.0, 1e-9);
        near("mean", found[0].1, -1.0, 1e-7);
    }
}

#[test]
fn links_under_circulatory_load_have_two_exceptional_points() {
    for logarithmic in [false, true] {
        let found = exceptional(Links([parameter("p", 0.5)]), (0.013, 2.07), logarithmic);
        assert_eq!(found.len(), 2, "{found:?}");
        for ((p, mean), expected) in found.into_iter().zip([(0.25, -5.5), (1.0, -2.0)]) {
            near("p", p, expected.0, 1e-8);
            near("mean", mean, expected.1, 1e-6);
        }
    }
}

fn study(keys: &str) -> Result<Summary, String> {
    let text = format!(
        "[model]
        name = \"two-doublet\"
        functions = 24
        [parameters]
        p = 400
        [[task]]
        name = \"modes\"
        kind = \"equilibria\"
        detect = [\"HB\"]
        errors = false
        {keys}"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).unwrap();
    let options = RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let scene = Scene::load(&path, &[]).map_err(|error| error.to_string())?;
    run(&scene, &options).map_err(|error| error.to_string())
}

fn values(summary: &Summary, kind: &str, name: &str) -> Vec<f64> {
    let points = summary.points.iter().filter(|point| point.label.starts_with(&format!("modes/{kind}")));
    points.map(|point| point.parameters[name]).collect()
}

/// Hopf points in k_N at p = 400 are those in p at that k_N; the logarithm changes steps, not solutions.
#[test]
fn hopf_points_in_the_stiffness_are_those_in_the_load() {
    let model = Flagellum::new(24, Load::Uniform, Law::Printed);
    let plain = study("free = \"k_N\"\nrange = [5e3, 3e4]").unwrap();
    let logarithmic = study("free = \"k_N\"\nrange = [5e3, 3e4]\nlog = true\nvalues = { k_N = [1e4] }").unwrap();
    let found = values(&logarithmic, "HB", "k_N");
    assert!(!found.is_empty());
    assert_eq!(found.len(), values(&plain, "HB", "k_N").len());
    for (a, b) in found.iter().zip(values(&plain, "HB", "k_N")) {
        close("k_N", *a, b, 1e-11);
    }
    let stiffness = found[found.len() - 1];
    let at = model.with("k_N", stiffness);
    close("p", at.hopf(400.0, 0).p[at.index("p")], 400.0, 1e-10);
    close("k_N", values(&logarithmic, "UZ", "k_N")[0], 1e4, 1e-14);
}

#[test]
fn a_logarithm_needs_positive_ends() {
    let refused = |keys: &str, wanted: &str| {
        let message = study(keys).unwrap_err();
        assert!(message.contains(wanted), "{message:?} lacks {wanted:?}");
    };
    refused("free = \"k_N\"\nrange = [0, 1e4]\nlog = true", "ends greater than 0");
    refused("free = \"k_N\"\nrange = [1, 1e4]\nlog = [\"k_T\"]", "unknown free parameter \"k_T\"");
    refused("free = \"k_N\"\nrange = [1, 1e4]\nlog = 3", "list of free parameters");
}

/// It jumps over the axis: the log says that no Hopf point explains the change.
#[test]
fn a_pair_that_crosses_without_a_hopf_point_is_said_to() {
    let text = r#"
[model]
equations = """
x' = jump*x - y
y' = x + jump*y
jump = mu/abs(mu)
"""
[model.parameters]
mu = -0.5
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-1, 1.1]
detect = ["HB"]
"#;
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let scene = Scene::parse(text, std::path::Path::new("crossing.toml"), &[]).unwrap();
    let summary = run(&scene, &options).unwrap();
    assert!(summary.points.iter().all(|point| !point.label.contains("/HB")));
    let log = std::fs::read_to_string(out.path().join("crossing/run.log")).unwrap();
    assert!(log.contains("the number of growing eigenvalues goes from 0 to 2"), "{log}");
}
