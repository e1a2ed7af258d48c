//! Scenes with bifurcations of cycles: what is found, what starts there, what is refused.

mod common;

use common::{close, near, refused};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::path::Path;

/// A circle in (x, y) and a third variable that leaves zero at mu = 0, and is back there at mu = 1/bend: with
/// (x, y, q) -> (-x, -y, -q) the cycle with q = 0 is symmetric up to half a period. All is exact.
fn symmetric(symmetry: &str, tasks: &str) -> String {
    format!(
        r#"
title = "A symmetric cycle"

[model]
equations = """
x' = (mu + 2)*x - y - x*(x^2 + y^2)
y' = x + (mu + 2)*y - y*(x^2 + y^2)
q' = mu*(1 - bend*mu)*q - q^3
"""
symmetry = "x -> -x, y -> -y, q -> -q"

[model.parameters]
mu = -3
bend = 0

[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-3, -1]
spectrum = 3
detect = ["HB"]

[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [-3, 1]
symmetry = {symmetry:?}
points = "gauss"
intervals = 12
multipliers = 2
detect = ["LPC", "PD", "NS", "BPC"]
{tasks}"#
    )
}

const BROKEN: &str = r#"
[[task]]
name = "broken"
kind = "cycles"
from = "cycles/BPC1"
free = "mu"
range = [-3, 1]
points = "gauss"
multipliers = 2
values = { mu = [0.64] }
observables = ["q"]
"#;

fn summary(text: &str, sets: &[&str]) -> Result<Summary, String> {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    let scene = Scene::parse(text, Path::new("scene.toml"), &sets).map_err(|e| e.to_string())?;
    let out = tempfile::tempdir().expect("a folder");
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    run(&scene, &options).map_err(|e| e.to_string())
}

#[test]
fn a_symmetry_breaks_and_the_other_branch_is_followed() {
    for symmetry in ["auto", "none"] {
        let summary = summary(&symmetric(symmetry, BROKEN), &[]).expect("a run");
        let reasons: Vec<&str> = summary.tasks.iter().map(|task| task.reason.as_str()).collect();
        assert_eq!(reasons, ["end of the range"; 3], "{symmetry}");
        let labels: Vec<&str> = summary.points.iter().map(|point| point.label.as_str()).collect();
        assert_eq!(labels.iter().filter(|label| label.starts_with("cycles/")).count(), 2, "{labels:?}");
        let point = |label: &str| summary.points.iter().find(|point| point.label == label).expect(label);
        let breaking = point("cycles/BPC1");
        near("mu", breaking.parameters["mu"], 0.0, 1e-10);
        assert!(breaking.errors["mu"] < 1e-9, "{:?}", breaking.errors);
        if symmetry == "auto" {
            // q is the critical function, of mean square 1 as it is.
            close("c", breaking.values["bpc_c"], -1.0, 1e-9);
        }
        // q = sqrt(mu) or its mirror image.
        let broken = point("broken/UZ1");
        close("q", broken.values["max q"].abs(), 0.8, 1e-9);
        close("q", broken.values["min q"].abs(), 0.8, 1e-9);
    }
}

#[test]
fn a_branch_that_comes_back_to_symmetric_cycles_ends_there() {
    for symmetry in ["auto", "none"] {
        let text = symmetric(symmetry, &BROKEN.replace("0.64", "0.25"));
        let summary = summary(&text, &["model.parameters.bend=2"]).expect("a run");
        let found: Vec<f64> = summary
            .points
            .iter()
            .filter(|point| point.label.starts_with("cycles/BPC"))
            .map(|point| point.parameters["mu"])
            .collect();
        assert_eq!(found.len(), 2);
        near("first", found[0], 0.0, 1e-10);
        near("second", found[1], 0.5, 1e-10);
        let point = summary.points.iter().find(|point| point.label == "broken/UZ1").expect("a user value");
        close("q", point.values["max q"].abs(), (0.25_f64 - 2.0 * 0.0625).sqrt(), 1e-9);
        // Over the whole period the other branch is a pitchfork's, too; its own half tells nothing there.
        if symmetry == "auto" {
            let reason = &summary.tasks[2].reason;
            assert!(reason.contains("symmetric cycles near mu = 0.5"), "{reason}");
        }
    }
}

#[test]
fn a_branch_of_cycles_ends_at_the_other_hopf_point() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/enzyme.toml");
    let text = std::fs::read_to_string(path).expect("a scene");
    let summary = summary(&text, &[]).expect("a run");
    let reason = &summary.tasks[1].reason;
    assert!(reason.contains("a Hopf point near rho = 4.650459"), "{reason}");
    // The curve of folds leads from the one to the other, and a branch in one parameter finds the same fold elsewhere.
    let point = |label: &str| summary.points.iter().find(|point| point.label == label).expect(label);
    let other = self::summary(
        &text,
        &["model.parameters.kappa=0.12", "task.cycles.range=[2, 8]", "task.folds.values={ kappa = [0.1] }"],
    )
    .expect("a run");
    for (on_curve, alone) in [("folds/UZ1", "cycles/LPC2"), ("folds/UZ2", "cycles/LPC1")] {
        let there = other.points.iter().find(|point| point.label == alone).expect("a fold");
        close("rho", point(on_curve).parameters["rho"], there.parameters["rho"], 1e-9);
        close("T", point(on_curve).values["period"], there.values["period"], 1e-9);
    }
}

#[test]
fn nothing_is_looked_for_that_is_not_asked_for() {
    let text = symmetric("none", "");
    let plain = summary(&text, &["task.cycles.detect=[]", "task.cycles.multipliers=0"]).expect("a run");
    let folds = summary(&text, &["task.cycles.detect=[\"LPC\"]", "task.cycles.multipliers=0"]).expect("a run");
    assert_eq!((plain.tasks[1].counts.spectra, folds.tasks[1].counts.spectra), (0, 0));
    assert_eq!(plain.tasks[1].counts.factorisations + 1, folds.tasks[1].counts.factorisations);
}

#[test]
fn the_doubled_cycle_is_followed_to_where_it_doubles_again() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/roessler.toml");
    let text = std::fs::read_to_string(path).expect("a scene");
    let summary = summary(&text, &[]).expect("a run");
    let point = |label: &str| summary.points.iter().find(|point| point.label == label).expect(label);
    let (one, two) = (point("one/PD1"), point("two/PD1"));
    assert!(one.values["pd_c"] < 0.0 && two.parameters["a"] > one.parameters["a"]);
    // A little further on, the doubled cycle still takes nearly twice as long.
    close("T", two.values["period"], 2.0 * one.values["period"], 0.03);
    // The curve in two parameters and a branch in one find the same point at another c.
    let other = self::summary(&text, &["parameters.c=5.7"]).expect("a run");
    let there = other.points.iter().find(|point| point.label == "one/PD1").expect("a period doubling");
    let on_curve = point("doublings/UZ1");
    near("a", on_curve.parameters["a"], there.parameters["a"], 10.0 * there.errors["a"]);
    close("c", on_curve.values["pd_c"], there.values["pd_c"], 1e-6);
}

#[test]
fn what_cannot_be_is_refused() {
    refused("enzyme", &["task.cycles.detect=[\"HB\"]"], "LPC");
    refused("langford", &["task.cycles.detect=[]"], "give it detect = [\"NS\"]");
    refused("langford", &["task.tori.from=\"rest/HB1\""], "the start must be a torus bifurcation");
    refused("langford", &["task.tori.from=\"rest/NS1\""], "these are points of cycles");
    refused(
        "langford",
        &["task.tori.range={ alpha = [2, 3] }", "task.tori.values={ alpha = [2.5] }"],
        "does not lie inside",
    );
    refused("roessler", &["task.doublings.from=\"one/LPC1\""], "give it detect = [\"PD\", \"LPC\"]");
    refused("roessler", &["task.two.range=[0.2, 0.25]"], "one/PD1 at a = 0.147");
}

/// Circles of radius sqrt(r²) with mu = r⁴ - r²: a fold at mu = -1/4; they do not feel kappa.
const FOLDED: &str = r#"
[model]
equations = """
x' = (mu + x^2 + y^2 - (x^2 + y^2)^2)*x - y
y' = x + (mu + x^2 + y^2 - (x^2 + y^2)^2)*y
"""
[model.parameters]
mu = 0
kappa = 7
[model.observables]
r = "sqrt(x^2 + y^2)"
missing = "sqrt(x^2 + y^2 - 0.5)"
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-1, 1]
detect = ["HB"]
[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [-1, 1]
values = { mu = [-0.24999, 0.5] }
multipliers = 1
intervals = 6
detect = ["LPC"]
observables = ["max r", "mean missing"]
[[task]]
name = "small"
kind = "cycles"
from = "cycles/LPC1"
free = "mu"
range = [-0.3, 0.1]
multipliers = 1
intervals = 6
[[task]]
name = "across"
kind = "cycles"
from = "cycles/UZ1"
free = "kappa"
range = [6, 8]
values = { kappa = [6.5, 7, 7.5] }
intervals = 6
[[task]]
name = "beyond"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [0, 1]
intervals = 6
"#;

#[test]
fn wanted_values_are_found_beside_folds_and_at_the_start() {
    let out = tempfile::tempdir().expect("a folder");
    let scene = Scene::parse(FOLDED, Path::new("scene.toml"), &[]).expect("a scene");
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&scene, &options).expect("a run");
    let point = |label: &str| summary.points.iter().find(|point| point.label == label).expect(label);
    // Both circles at mu, one on each side of the fold.
    let radius = |sign: f64| (0.5 + sign * 0.00001_f64.sqrt()).sqrt();
    for (label, sign) in [("cycles/UZ1", -1.0), ("cycles/UZ2", 1.0)] {
        assert_eq!(point(label).parameters["mu"], -0.24999);
        close(label, point(label).values["max r"], radius(sign), 1e-3);
    }
    assert_eq!(point("cycles/UZ3").parameters["mu"], 0.5);
    assert!(point("cycles/UZ1").row < point("cycles/LPC1").row && point("cycles/LPC1").row < point("cycles/UZ2").row);
    // A number that does not exist is none: the mean of what is not real everywhere.
    assert!(!point("cycles/UZ1").values.contains_key("mean missing"));
    let text = std::fs::read_to_string(out.path().join("scene/branches/cycles.csv")).expect("a table");
    assert!(!text.contains("NaN"), "{text}");
    // A start among cycles is as stable as it is itself, not as the first cycle beside it.
    let small = std::fs::read_to_string(out.path().join("scene/branches/small.csv")).expect("a table");
    let fold = format!(",,{},", point("cycles/LPC1").parameters["mu"]);
    assert!(small.lines().any(|line| line.starts_with(&fold[..14])), "undecided at {fold}: {small}");
    let wanted: Vec<f64> = (1..=3).map(|k| point(&format!("across/UZ{k}")).parameters["kappa"]).collect();
    assert_eq!(wanted, [7.0, 6.5, 7.5]);
    let reason = &summary.tasks.iter().find(|task| task.name == "beyond").expect("a task").reason;
    assert!(reason == "end of the range" || reason.contains("leave the range at once"), "{reason}");
}

/// Two humps of 1 and 1.001, between samples.
#[test]
fn the_larger_of_two_humps_is_the_maximum() {
    let text = r#"
[model]
equations = """
x' = mu*x - y - x*(x^2 + y^2)
y' = x + mu*y - y*(x^2 + y^2)
"""
[model.parameters]
mu = -0.5
[model.observables]
g = "2*x*y + 0.001*(x + y)/sqrt(2)"
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-1, 1.5]
detect = ["HB"]
[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [-1, 1.5]
intervals = 9
errors = false
observables = ["g"]
values = { mu = [1.0] }
"#;
    for intervals in 9..15 {
        let summary = summary(text, &[&format!("task.cycles.intervals={intervals}")]).expect("a run");
        let point = summary.points.iter().find(|point| point.label == "cycles/UZ1").expect("a point");
        near("max g", point.values["max g"], 1.001, 1e-5);
    }
}

/// A state of 1e-10 that is not fixed by the reflection, with cycles of its own size.
#[test]
fn small_states_are_no_symmetric_ones() {
    let text = r#"
[model]
symmetry = "x -> -x, y -> -y"
equations = """
x' = y
y' = x - 1e20*x^3 + (mu - 1e20*x^2)*y
"""
[model.parameters]
mu = 0.5
[model.start]
x = 1e-10
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [0.5, 1.5]
start = 0.5
detect = ["HB"]
[[task]]
name = "cycles"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [0.5, 1.5]
errors = false
values = { mu = [0.9] }
observables = ["x"]
"#;
    let summary = summary(text, &[]).expect("a run");
    let cycle = summary.points.iter().find(|point| point.label == "cycles/UZ1").expect("a cycle");
    // Around x = 1e-10, not around both equilibria.
    assert!(cycle.values["min x"] > 0.0, "{cycle:?}");
}
