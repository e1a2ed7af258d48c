//! Diagrams that are explored by themselves: switching, disconnected branches by deflation and given states, cycles.

use hopfline::branch::{BranchKind, read_arrays, read_branch};
use hopfline::run::{RunOptions, Summary, plan, redraw, run};
use hopfline::scene::Scene;
use std::path::Path;

fn scene(text: &str, folder: &Path) -> Result<Scene, String> {
    let path = folder.join("study.toml");
    std::fs::write(&path, text).unwrap();
    Scene::load(&path, &[]).map_err(|error| error.to_string())
}

fn study_in(text: &str, folder: &Path, resume: bool) -> Result<Summary, String> {
    let options = RunOptions { out: folder.to_owned(), only: Vec::new(), resume, quiet: true };
    run(&scene(text, folder)?, &options).map_err(|error| error.to_string())
}

fn study(text: &str) -> Result<Summary, String> {
    study_in(text, tempfile::tempdir().unwrap().path(), false)
}

/// x = 0, and a circle about x = 3: `x ((x - 3)² + p² - 1) = 0`.
const CIRCLE: &str = r#"
[model]
equations = "x' = -x*((x - 3)^2 + p^2 - 1)"
[model.parameters]
p = 0
[[task]]
name = "all"
kind = "diagram"
free = "p"
range = [-2, 2]
"#;

fn values(summary: &Summary, kind: &str, name: &str) -> Vec<f64> {
    let points = summary.points.iter().filter(|p| p.label.contains(&format!("/{kind}")));
    points.map(|p| p.parameters.get(name).or(p.values.get(name)).copied().unwrap_or(f64::NAN)).collect()
}

#[test]
fn deflation_and_states_find_an_isola() {
    assert_eq!(study(CIRCLE).unwrap().tasks.len(), 1);
    for more in [
        "deflate = [0.25]",
        "states = [{ x = 3.8, p = 0.25 }]",
        "states = [{ x = 3.9 }, { x = 3.8, p = 0.25 }]\ndeflate = [0.25]",
    ] {
        let summary = study(&format!("{CIRCLE}{more}")).unwrap();
        let names: Vec<&str> = summary.tasks.iter().map(|task| task.name.as_str()).collect();
        assert_eq!(names, ["all-1", "all-2"], "{more}");
        assert!(summary.tasks[1].reason.ends_with("closed on itself"), "{}", summary.tasks[1].reason);
        let mut folds = values(&summary, "LP", "p");
        folds.sort_by(f64::total_cmp);
        assert_eq!(folds.len(), 2);
        assert!((folds[0] + 1.0).abs() < 1e-12 && (folds[1] - 1.0).abs() < 1e-12, "{folds:?}");
        // (x - 3)² = 1 - 1/16 on both sides, and zero.
        for x in values(&summary, "UZ", "x") {
            assert!(x.abs() < 1e-12 || ((x - 3.0).powi(2) - 0.9375).abs() < 1e-12, "{x}");
        }
    }
}

/// Two coupled pitchforks: x and y bifurcate on their own, and together once more.
const COUPLED: &str = r#"
[model]
equations = """
x' = (p - 1)*x - x^3 - 2*x*y^2
y' = (p - 2)*y - y^3 - 2*y*x^2
"""
symmetry = "x -> -x"
[model.parameters]
p = 0
[[task]]
name = "all"
kind = "diagram"
free = "p"
range = [0, 6]
observables = ["x", "y"]
"#;

/// x² = p - 1; y² = p - 2; and both where `p - 1 = x² + 2 y²`, `p - 2 = y² + 2 x²`: y² = p/3, x² = p/3 - 1, from p = 3,
/// which is on the branch x = 0.
#[test]
fn every_pitchfork_is_met_once() {
    let summary = study(COUPLED).unwrap();
    let mut points: Vec<(f64, String)> = Vec::new();
    for point in summary.points.iter().filter(|p| p.label.contains("/BP")) {
        points.push((point.parameters["p"], point.label.clone()));
    }
    // 1 and 2 on the trivial branch; 3 on the arms of y, of which both are followed in one task.
    let mut places: Vec<f64> = points.iter().map(|(p, _)| *p).collect();
    places.sort_by(f64::total_cmp);
    for place in &places {
        assert!([1.0, 2.0, 3.0].iter().any(|exact| (place - exact).abs() < 1e-12), "{points:?}");
    }
    let names: Vec<&str> = summary.tasks.iter().map(|task| task.name.as_str()).collect();
    // Trivial, x, y, and both from either arm of y.
    assert_eq!(names.len(), 5, "{names:?} {points:?}");
    for branch in &summary.branches {
        assert_eq!(branch.kind, BranchKind::Equilibria);
    }
    for (x, y) in values(&summary, "EP", "x").into_iter().zip(values(&summary, "EP", "y")) {
        let (x, y) = (x * x, y * y);
        let known = [(0.0, 0.0), (5.0, 0.0), (0.0, 4.0), (1.0, 2.0)];
        assert!(known.iter().any(|(a, b)| (x - a).abs() + (y - b).abs() < 1e-9), "{x} {y}");
    }
    assert_eq!(summary.figures.len(), 1, "drawn by itself");
    assert_eq!(study(&format!("{COUPLED}depth = 1")).unwrap().tasks.len(), 3);
    assert_eq!(study(&format!("{COUPLED}max_branches = 2")).unwrap().tasks.len(), 2);
}

/// Whatever a diagram did not find was expected in vain; states on known branches are no new starts, wherever the first began.
#[test]
fn branches_that_are_not_found_are_missed() {
    let more =
        "start = 0.5\nstates = [{ x = 0.01 }, { x = 3.9 }]\n[expect]\n\"all-9/BP1\".p = { value = 1, tolerance = 1 }";
    let summary = study(&format!("{CIRCLE}{more}")).unwrap();
    let names: Vec<&str> = summary.tasks.iter().map(|task| task.name.as_str()).collect();
    assert_eq!(names, ["all-1", "all-2"]);
    assert!(summary.expect.len() == 1 && !summary.success(), "{:?}", summary.expect);
}

/// Cycles are drawn over the same logarithm as the equilibria that they come from.
#[test]
fn logarithmic_diagrams_show_their_cycles() {
    let text = r#"
[model]
equations = """
x' = (mu - 1)*x - y - x*(x^2 + y^2)
y' = x + (mu - 1)*y - y*(x^2 + y^2)
"""
[model.parameters]
mu = 0.1
[[task]]
name = "all"
kind = "diagram"
free = "mu"
range = [0.1, 10]
log = true
intervals = 4
observables = ["x"]
"#;
    let folder = tempfile::tempdir().unwrap();
    let summary = study_in(text, folder.path(), false).unwrap();
    let cycles = summary.branches.iter().find(|branch| branch.kind == BranchKind::Cycles).unwrap();
    assert!(cycles.columns.contains(&"log10 mu".to_owned()), "{:?}", cycles.columns);
    let out = folder.path().join("study");
    let table = read_branch(&out.join(&cycles.file), &cycles.name, cycles.kind, &cycles.free).unwrap();
    let (mu, log) = (table.column("mu").unwrap(), table.column("log10 mu").unwrap());
    for row in &table.rows {
        assert_eq!(row.values[log], row.values[mu].map(f64::log10));
    }
    let svg = std::fs::read(out.join("figures/all.svg")).unwrap();
    assert_eq!(redraw(&out).unwrap(), ["all"]);
    assert!(svg == std::fs::read(out.join("figures/all.svg")).unwrap());
}

#[test]
fn boxes_end_branches() {
    let summary = study(&format!("{COUPLED}box = {{ x = [-1, 1] }}")).unwrap();
    let arm = summary.tasks.iter().find(|task| task.reason.contains("all-1/BP1")).unwrap();
    assert!(arm.reason.ends_with("end of the box"), "{}", arm.reason);
}

/// Lorenz: the trivial state, both rolls, and the unstable cycles of both.
#[test]
fn lorenz_has_its_rolls_and_their_cycles() {
    let text = r#"
[model]
equations = """
x' = 10*(y - x)
y' = x*(rho - z) - y
z' = x*y - 8/3*z
"""
[model.parameters]
rho = 0
[[task]]
name = "all"
kind = "diagram"
free = "rho"
range = [0, 30]
box = { x = [-20, 20] }
errors = false
observables = ["x"]
"#;
    let folder = tempfile::tempdir().unwrap();
    let summary = study_in(text, folder.path(), false).unwrap();
    let kinds: Vec<BranchKind> = summary.tasks.iter().map(|task| task.kind).collect();
    use BranchKind::{Cycles, Equilibria};
    assert_eq!(kinds, [Equilibria, Equilibria, Cycles, Cycles]);
    assert!((values(&summary, "BP", "rho")[0] - 1.0).abs() < 1e-13);
    for rho in values(&summary, "HB", "rho") {
        assert!((rho / (470.0 / 19.0) - 1.0).abs() < 1e-12, "{rho}");
    }
    let out = folder.path().join("study");
    let arrays = read_arrays(&out.join("points/all-1/BP1.npz")).unwrap();
    assert_eq!(arrays["other_tangent"].data.len(), 4);
    // A finished diagram is taken as it is.
    let again = study_in(text, folder.path(), true).unwrap();
    assert_eq!(again.points, summary.points);
    // Another run leaves no branches of this one behind.
    study_in(&text.replace("range = [0, 30]", "range = [0, 0.5]"), folder.path(), false).unwrap();
    assert!(out.join("branches/all-1.csv").exists() && !out.join("branches/all-2.csv").exists());
}

#[test]
fn a_branch_may_start_near_a_given_state() {
    let text =
        CIRCLE.replace("kind = \"diagram\"", "kind = \"equilibria\"\nstate = { x = 3.9, p = 0.5 }\ndetect = [\"LP\"]");
    let summary = study(&text).unwrap();
    assert_eq!(values(&summary, "LP", "p").len(), 2);
    assert!(summary.tasks[0].reason.ends_with("closed on itself"));
}

#[test]
fn wrong_diagrams_are_refused() {
    let cases = [
        ("states = [{ y = 1 }]", "unknown unknown of the model \"y\"; allowed: x, p"),
        ("states = [{ x = 1, p = 5 }]", "5 lies outside the range -2 to 2"),
        ("states = [{}]", "is empty"),
        ("states = { x = 1 }", "a list of states"),
        ("deflate = [3]", "3 lies outside the range"),
        ("box = { y = [0, 1] }", "unknown observable \"y\""),
        ("box = { x = [1, 0] }", "runs from 1 to 0"),
        ("depth = -1", "whole numbers from 0"),
        ("cycles = 3", "true or false"),
        ("from = \"all-1/BP1\"", "unknown key of a diagram task"),
        ("[expect]\n\"all-2/GH1\".p = { value = 1, tolerance = 1 }", "it finds HB, LP, BP, KC, XP, UZ and EP"),
        ("[expect]\nall.ends = \"closed\"", "is a diagram: each of its branches ends in its own way"),
        ("[expect]\n\"all/BP1\".p = { value = 1, tolerance = 1 }", "is a diagram of several branches"),
        (
            "[[task]]\nname = \"all-2\"\nkind = \"equilibria\"\nfree = \"p\"\nrange = [0, 1]",
            "is the name of a branch of the diagram \"all\"",
        ),
    ];
    for (keys, wanted) in cases {
        let message = study(&format!("{CIRCLE}{keys}")).unwrap_err();
        assert!(message.contains(wanted), "{message:?} lacks {wanted:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let text = plan(&scene(&format!("{CIRCLE}deflate = [0]\ncycles = false"), folder.path()).unwrap()).unwrap();
    assert!(text.contains("and those that deflation finds") && text.contains("left out: cycles from every Hopf point"));
}
