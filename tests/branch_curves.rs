//! Curves of branch points against exact ones: kept by an invariant axis, by a symmetry, and by nothing.

use hopfline::branch::{BranchKind, read_branch};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::path::Path;

/// The corrector ends a step at 1e-11, in parts of the ranges.
const CORRECTED: f64 = 4e-11;

/// The summary, and of each row of the last task the columns by name.
fn study(text: &str, columns: [&str; 3]) -> Result<(Summary, Vec<[f64; 3]>), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, text).unwrap();
    let scene = Scene::load(&path, &[]).map_err(|error| error.to_string())?;
    let options = RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&scene, &options).map_err(|error| error.to_string())?;
    let rows = rows(folder.path(), &summary, columns);
    Ok((summary, rows))
}

fn rows(folder: &Path, summary: &Summary, columns: [&str; 3]) -> Vec<[f64; 3]> {
    let name = &summary.tasks.last().unwrap().name;
    let branch =
        read_branch(&folder.join(format!("study/branches/{name}.csv")), name, BranchKind::BranchPointCurve, &[])
            .unwrap();
    let at = columns.map(|name| branch.columns.iter().position(|column| column.name == name).unwrap());
    branch.rows.iter().map(|row| at.map(|i| row.values[i].unwrap())).collect()
}

/// Rosenzweig and MacArthur: without predators x = K, and y may invade from K/(1 + K) = d on.
const INVASION: &str = r#"
[model]
equations = """
x' = x*(1 - x/K) - x*y/(1 + x)
y' = x*y/(1 + x) - d*y
"""
[model.parameters]
K = 0.2
d = 0.4
[model.start]
x = "K"
[[task]]
name = "alone"
kind = "equilibria"
free = "K"
range = [0.2, 2]
detect = ["BP"]
[[task]]
name = "invasion"
kind = "branch-point-curve"
from = "alone/BP1"
free = ["K", "d"]
range = { K = [0.1, 3], d = [0.1, 0.7] }
values = { d = [0.25], K = [1.5] }
"#;

#[test]
fn a_predator_invades_along_the_exact_line() {
    for order in ["[\"K\", \"d\"]", "[\"d\", \"K\"]"] {
        for logarithmic in ["", "log = [\"K\"]"] {
            let text = INVASION.replace("[\"K\", \"d\"]", order) + logarithmic;
            let (summary, rows) = study(&text, ["K", "d", "imperfection"]).unwrap();
            assert!(rows.len() > 20, "{} rows, {}", rows.len(), summary.tasks[1].reason);
            for [k, d, beta] in &rows {
                assert!((d - k / (1.0 + k)).abs() < CORRECTED * 0.6 && beta.abs() < 1e-13, "{k} {d} {beta}");
            }
            let (least, most) = rows.iter().fold((1.0_f64, 0.0_f64), |(a, b), row| (a.min(row[1]), b.max(row[1])));
            assert!((least - 0.1).abs() < 1e-13 && (most - 0.7).abs() < 1e-13, "{least} {most}");
            let wanted = summary.points.iter().filter(|point| point.label.starts_with("invasion/UZ"));
            let mut found: Vec<f64> = wanted.map(|point| point.parameters["d"]).collect();
            found.sort_by(f64::total_cmp);
            assert!(found.len() == 2 && (found[0] - 0.25).abs() < 1e-12 && (found[1] - 0.6).abs() < 1e-12, "{found:?}");
        }
    }
}

/// x = 0, y = a + a^3/5: x bifurcates at mu = a^2 - y.
const SYMMETRIC: &str = r#"
[model]
equations = """
x' = (mu - a^2)*x - x^3 + x*y
y' = a + a^3/5 - y + x^2/3
"""
[model.parameters]
mu = -2
a = 0.5
[[task]]
name = "even"
kind = "equilibria"
free = "mu"
range = [-2, 2]
detect = ["BP"]
[[task]]
name = "pitchforks"
kind = "branch-point-curve"
from = "even/BP1"
free = ["a", "mu"]
range = { a = [-3, 3], mu = [-4, 4] }
"#;

#[test]
fn a_pitchfork_moves_along_the_exact_curve() {
    let (summary, rows) = study(SYMMETRIC, ["mu", "a", "imperfection"]).unwrap();
    assert!(rows.len() > 20, "{} rows, {}", rows.len(), summary.tasks[1].reason);
    for [mu, a, beta] in &rows {
        assert!((mu - (a * a - a - a.powi(3) / 5.0)).abs() < CORRECTED * 8.0 && beta.abs() < 1e-13, "{mu} {a} {beta}");
    }
    // Past the turns of mu(a) on both sides of the start.
    assert!(rows.iter().any(|row| row[1] < -0.9) && rows.iter().any(|row| row[1] > 1.5));
}

/// With q the branches come apart: `x' = mu x + x^2 + q` is changed by q.
#[test]
fn beta_says_what_is_missing() {
    let text = r#"
[model]
equations = "x' = mu*x + x^2 + q"
[model.parameters]
mu = -1
q = 0
[[task]]
name = "perfect"
kind = "equilibria"
free = "mu"
range = [-1, 1]
detect = ["BP"]
[[task]]
name = "imperfect"
kind = "branch-point-curve"
from = "perfect/BP1"
free = ["q", "mu"]
range = { q = [-1, 1], mu = [-1, 1] }
"#;
    let (_, rows) = study(text, ["mu", "q", "imperfection"]).unwrap();
    assert!(rows.len() > 5);
    for [mu, q, beta] in &rows {
        assert!(mu.abs() < 1e-12 && (beta.abs() - q.abs()).abs() < 1e-12, "{mu} {q} {beta}");
    }
    let ends = |q: f64| rows.iter().any(|row| (row[1] - q).abs() <= f64::EPSILON);
    assert!(ends(-1.0) && ends(1.0));
    let refused = |text: &str, expected: &str| {
        let error = study(text, ["mu", "q", "imperfection"]).map(|_| ()).unwrap_err();
        assert!(error.contains(expected), "{error}");
    };
    refused(&text.replace("perfect/BP1", "perfect/EP1"), "the start must be a branch point");
    refused(&text.replace("detect = [\"BP\"]", ""), "BP");
}

/// Without damping zero is a double eigenvalue: `x'' = p x - 2 x^3`.
#[test]
fn a_double_zero_has_a_normal_form() {
    let text = r#"
[model]
equations = """
x' = 3*y
y' = (p*x - 2*x^3)/3
"""
[model.parameters]
p = -1
[[task]]
name = "straight"
kind = "equilibria"
free = "p"
range = [-1, 1]
detect = ["BP"]
observables = ["x"]
"#;
    let (summary, _) = study(text, ["p", "x", "x"]).unwrap();
    let point = summary.points.iter().find(|point| point.label == "straight/BP1").unwrap();
    let (b, d) = (point.values["bp_b"], point.values["bp_d"]);
    assert!((b - 1.0).abs() < 1e-12 && (d + 2.0).abs() < 1e-12, "{b} {d}");
}
