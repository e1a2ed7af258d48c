//! Curves of critical cycles as tasks: exact and published ones, with their errors; folds told from pitchforks.

mod common;

use common::{close, near};
use hopfline::branch::{BranchKind, read_branch};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::path::Path;

/// The summary, and of each row of the task "curve" the columns by name.
fn study(text: &str, kind: BranchKind, columns: &[&str]) -> (Summary, Vec<Vec<Option<f64>>>) {
    let scene = Scene::parse(text, Path::new("study.toml"), &[]).unwrap();
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&scene, &options).unwrap();
    let branch = read_branch(&out.path().join("study/branches/curve.csv"), "curve", kind, &[]).unwrap();
    let at: Vec<usize> = columns
        .iter()
        .map(|name| branch.columns.iter().position(|column| column.name == *name).unwrap_or_else(|| panic!("{name}")))
        .collect();
    let rows = branch.rows.iter().map(|row| at.iter().map(|&i| row.values[i]).collect()).collect();
    (summary, rows)
}

/// A circle of radius sqrt(mu + 2) and a third variable that leaves zero at mu = 1/bend:
/// q' = mu (1 - bend mu) q - cubic q³ - q⁵, symmetric up to half a period.
const BREAKING: &str = r#"
[model]
equations = """
x' = (mu + 2)*x - y*(1 + q^2) - x*(x^2 + y^2)
y' = x*(1 + q^2) + (mu + 2)*y - y*(x^2 + y^2)
q' = mu*(1 - bend*mu)*q - cubic*q^3 - q^5
"""
symmetry = "x -> -x, y -> -y, q -> -q"
[model.parameters]
mu = -3
bend = 2
cubic = 1
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-3, -1]
detect = ["HB"]
[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [-3, 1]
points = "gauss"
intervals = 8
detect = ["BPC"]
"#;

#[test]
fn a_symmetry_breaks_along_an_exact_hyperbola() {
    let text = format!(
        "{BREAKING}\n[[task]]\nname = \"curve\"\nkind = \"bpc-curve\"\nfrom = \"cycles/BPC2\"\nfree = [\"mu\", \"bend\"]\n\
         range = {{ mu = [0.1, 2], bend = [0.6, 4] }}\nvalues = {{ bend = [1] }}"
    );
    let (summary, rows) =
        study(&text, BranchKind::BpcCurve, &["mu", "bend", "bpc_c", "error mu", "error bend", "period"]);
    assert!(rows.len() > 15, "{}", summary.tasks[2].reason);
    for row in &rows {
        let [mu, bend, c, period] = [0, 1, 2, 5].map(|i| row[i].unwrap());
        near("mu bend", mu * bend, 1.0, 1e-9);
        close("c", c, -1.0, 1e-7);
        close("period", period, std::f64::consts::TAU, 1e-7);
        // One of the two is held.
        assert_eq!(row[3].iter().chain(row[4].iter()).count(), 1);
        let (error, truth) = row[3].map_or((row[4], bend - 1.0 / mu), |_| (row[3], mu - 1.0 / bend));
        assert!(error.unwrap() < 1e-9 && truth.abs() < 10.0 * error.unwrap() + 1e-10, "{error:?} {truth:e}");
    }
    let wanted = summary.points.iter().find(|point| point.label == "curve/UZ1").unwrap();
    close("mu", wanted.parameters["mu"], 1.0, 1e-10);
    assert!(wanted.errors.contains_key("mu") && !wanted.errors.contains_key("bend"), "{:?}", wanted.errors);
}

#[test]
fn breaking_turns_subcritical_where_its_cubic_coefficient_vanishes() {
    let text = format!(
        "{BREAKING}\n[[task]]\nname = \"curve\"\nkind = \"bpc-curve\"\nfrom = \"cycles/BPC1\"\nfree = [\"mu\", \"cubic\"]\n\
         range = {{ mu = [-1, 1], cubic = [-0.7, 1.2] }}"
    );
    let (summary, rows) = study(&text, BranchKind::BpcCurve, &["mu", "cubic", "bpc_c"]);
    for row in &rows {
        near("mu", row[0].unwrap(), 0.0, 1e-10);
        near("c", row[2].unwrap(), -row[1].unwrap(), 1e-8);
    }
    let found: Vec<_> = summary.points.iter().filter(|point| point.label.starts_with("curve/GBPC")).collect();
    assert_eq!(found.len(), 1);
    near("cubic", found[0].parameters["cubic"], 0.0, 1e-8);
    assert!(found[0].errors["cubic"] < 1e-6, "{:?}", found[0].errors);
}

/// Lorenz' cycle at large rho loses its symmetry at rho = 312.973532984 for sigma = 10 by the multiplier over half the period; at
/// another sigma the curve must agree with a branch there, which a second task follows over the whole period.
const LORENZ: &str = r#"
[model]
equations = """
x' = sigma*(y - x)
y' = x*(rho - z) - y
z' = x*y - beta*z
"""
symmetry = "x -> -x, y -> -y"
[model.parameters]
sigma = 10
rho = 350
beta = "8/3"
[[task]]
name = "motion"
kind = "simulate"
start = [1, 1, 350]
time = [0, 40]
tolerance = 1e-8
[[task]]
name = "symmetric"
kind = "cycles"
from = "motion/LC1"
free = "rho"
range = [300, 350]
points = "gauss"
intervals = 60
detect = ["BPC"]
[[task]]
name = "curve"
kind = "bpc-curve"
from = "symmetric/BPC1"
free = ["rho", "sigma"]
range = { rho = [250, 400], sigma = [9.5, 10.5] }
values = { sigma = [9.75] }
[[task]]
name = "other"
kind = "cycles"
from = "symmetric/EP2"
free = "sigma"
range = [9.75, 10]
points = "gauss"
intervals = 40
[[task]]
name = "across"
kind = "cycles"
from = "other/EP1"
free = "rho"
range = [280, 350]
points = "gauss"
intervals = 80
symmetry = "none"
detect = ["BPC"]
"#;

#[test]
fn the_curve_of_broken_symmetry_of_lorenz_agrees_with_branches_across_it() {
    let (summary, rows) = study(LORENZ, BranchKind::BpcCurve, &["rho", "sigma"]);
    assert!(rows.len() > 10, "{}", summary.tasks[2].reason);
    let point = |label: &str| summary.points.iter().find(|point| point.label == label).expect(label);
    let breaking = point("symmetric/BPC1");
    close("rho", breaking.parameters["rho"], 312.973532984, 1e-11);
    let (curve, across) = (point("curve/UZ1"), point("across/BPC1"));
    close("rho", curve.parameters["rho"], across.parameters["rho"], 1e-9);
    let error = curve.errors["rho"];
    assert!(error < 1e-6 && (curve.parameters["rho"] - across.parameters["rho"]).abs() < 10.0 * error, "{error:e}");
}

#[test]
fn where_no_symmetry_breaks_there_is_no_curve() {
    let text = LORENZ.replace("intervals = 60\ndetect", "intervals = 60\nsymmetry = \"none\"\ndetect");
    let scene = Scene::parse(&text, Path::new("study.toml"), &[]).unwrap();
    let out = tempfile::tempdir().unwrap();
    let only = vec!["curve".to_owned()];
    let options = RunOptions { out: out.path().to_owned(), only, resume: false, quiet: true };
    let summary = run(&scene, &options).unwrap();
    assert!(summary.tasks[2].reason.contains("breaks no symmetry over half a period"), "{}", summary.tasks[2].reason);
    let text = LORENZ.replace("from = \"symmetric/BPC1\"", "from = \"symmetric/EP1\"");
    let scene = Scene::parse(&text, Path::new("study.toml"), &[]).unwrap();
    let refused = run(&scene, &options).map(drop).unwrap_err().to_string();
    assert!(refused.contains("TASK/BPC1") && refused.contains("lose a symmetry"), "{refused}");
}

/// q' = q (mu + 2 q² - q⁴): off the plane q = 0 cycles lie on mu = q⁴ - 2 q², with folds at q = ±1 and a pitchfork at
/// mu = 0, where mu has a largest value, too.
const FORK: &str = r#"
[model]
equations = """
x' = (a + 0.2*q^2)*x - y*(1 + 0.3*q^2) - x*(x^2 + y^2)
y' = x*(1 + 0.3*q^2) + (a + 0.2*q^2)*y - y*(x^2 + y^2)
q' = q*(mu + 2*q^2 - q^4)
"""
[model.parameters]
a = -1
mu = 0.5625
[[task]]
name = "rest"
kind = "equilibria"
free = "a"
range = [-1, 0.5]
state = { q = 1.5 }
detect = ["HB"]
[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "a"
range = [-1, 1]
points = "gauss"
intervals = 10
[[task]]
name = "curve"
kind = "cycles"
from = "cycles/EP1"
free = "mu"
range = [-2, 0.6]
points = "gauss"
detect = ["LPC"]
"#;

#[test]
fn a_pitchfork_is_no_fold() {
    let folds = ["curve/LPC1", "curve/LPC2"];
    for (detect, wanted) in [("\"LPC\"", &folds[..]), ("\"LPC\", \"BPC\"", &["curve/LPC1", "curve/BPC1", "curve/LPC2"])]
    {
        let (summary, _) = study(&FORK.replace("\"LPC\"", detect), BranchKind::Cycles, &[]);
        let found: Vec<_> = summary.points.iter().filter(|point| point.label.starts_with("curve/")).collect();
        let found: Vec<_> = found.into_iter().filter(|point| !point.label.contains("EP")).collect();
        assert_eq!(found.iter().map(|point| point.label.as_str()).collect::<Vec<_>>(), wanted);
        for point in found {
            let fold = point.label.contains("LPC");
            near("mu", point.parameters["mu"], if fold { -1.0 } else { 0.0 }, 1e-9);
            close("T", point.values["period"], std::f64::consts::TAU / if fold { 1.3 } else { 1.0 }, 1e-8);
        }
    }
}
