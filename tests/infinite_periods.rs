//! Branches that end at orbits of infinite period, by what they pass: a saddle-node whose place is exact.

mod common;

use common::close;
use hopfline::run::{RunOptions, run};
use hopfline::scene::Scene;
use std::path::Path;

/// On the unit circle theta' = (p - sin theta) (1 + k cos theta), with two equilibria for p < 1 and none beyond; for k = 0 the
/// period is 2 pi/sqrt(p² - 1).
fn circle(k: f64) -> String {
    format!(
        r#"
[model]
equations = """
x' = (1 - x^2 - y^2)*x - y*w
y' = (1 - x^2 - y^2)*y + x*w
w = (p - y)*(1 + {k}*x)
"""
[model.parameters]
p = 2
[[task]]
name = "motion"
kind = "simulate"
start = [1, 0]
time = [0, 60]
tolerance = 1e-8
[[task]]
name = "cycles"
kind = "cycles"
from = "motion/LC1"
free = "p"
range = [0.5, 2]
tolerance = 1e-7
"#
    )
}

#[test]
fn a_branch_ends_at_a_saddle_node_on_the_circle() {
    for k in [0.0, 0.6] {
        let scene = Scene::parse(&circle(k), Path::new("scene.toml"), &[]).unwrap();
        let out = tempfile::tempdir().unwrap();
        let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
        let summary = run(&scene, &options).unwrap();
        let reason = &summary.tasks[1].reason;
        assert!(reason.contains("SNIC") && reason.contains("^(-1/2)"), "{reason}");
        let end = summary.points.iter().find(|point| point.label == "cycles/EP1").unwrap();
        close("p", end.values["snic"], 1.0, 1e-12);
        assert!(end.errors["snic"] < 1e-12, "{:?}", end.errors);
        if k == 0.0 {
            let p = end.parameters["p"];
            close("T", end.values["period"], std::f64::consts::TAU / (p * p - 1.0).sqrt(), 1e-6);
        }
    }
}

/// A swing with friction that changes its sign: the cycle ends at the saddle's connection. On meshes of the default tolerance
/// lambda is known to no more than that.
#[test]
fn a_connection_is_recognised_on_meshes_of_the_default_tolerance() {
    let scene = r#"
[model]
symmetry = "x -> -x, y -> -y"
equations = """
x' = y
y' = -sin(x) + (mu + 0.1*x^2)*y
"""
[model.parameters]
mu = 0.1
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-0.3, 0.3]
detect = ["HB"]
[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [-0.3, 0.3]
errors = false
TOLERANCE
"#;
    let ends = ["", "tolerance = 1e-9"].map(|tolerance| {
        let text = scene.replace("TOLERANCE", tolerance);
        let scene = Scene::parse(&text, Path::new("scene.toml"), &[]).unwrap();
        let out = tempfile::tempdir().unwrap();
        let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
        let summary = run(&scene, &options).unwrap();
        let reason = &summary.tasks[1].reason;
        assert!(reason.contains("the period grows without bound"), "{reason}");
        let end = summary.points.iter().find(|point| point.label == "cycles/EP1").unwrap();
        end.values["homoclinic"]
    });
    close("mu", ends[0], ends[1], 1e-5);
}

/// The cycles of the predator-prey model end at a cycle of two connections between saddles without predators. The rate is
/// 1/(1/mu_1 + (nu_1/mu_1)/mu_2) with the saddles' eigenvalues where the connection is, in 30 digits.
#[test]
fn a_cycle_of_connections_is_recognised_by_all_its_saddles() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/predator-prey-diagram.toml");
    let scene = Scene::load(&path, &[]).unwrap();
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&scene, &options).unwrap();
    let reason = &summary.tasks.iter().find(|task| task.name == "all-4").unwrap().reason;
    assert!(reason.contains("that of the 2 saddles is 0.2211"), "{reason}");
    let end = summary.points.iter().find(|point| point.label == "all-4/EP1").unwrap();
    close("rate", end.values["rate"], 0.221116516739872, 2e-3);
    // Errors are estimates; here it is that of the mesh.
    let (off, error) = ((end.values["homoclinic"] - 0.7080728074984).abs(), end.errors["homoclinic"]);
    assert!(off < 2.0 * error && error < 1e-8, "{off} {error}");
}
