//! Bifurcations of relative periodic orbits: exact folds and tori, and a period doubling against that of the same orbit in
//! coordinates without the phase.

mod common;

use common::{close, near};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::f64::consts::TAU;
use std::path::Path;

fn summary(text: &str) -> Result<Summary, String> {
    let scene = Scene::parse(text, Path::new("scene.toml"), &[]).map_err(|error| error.to_string())?;
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    run(&scene, &options).map_err(|error| error.to_string())
}

/// A = a + i b rotates with |A|² = mu. Where mu - 1 + 0.8 s - 0.4 s² = 0, (x, y) is a circle of radius sqrt(s), which
/// modulates the phase of A; the branch turns at s = 1, mu = 0.6. (e, f) begins to oscillate on it at mu = 0.8.
const MODULATED: &str = r#"
[model]
equations = """
a' = mu*a - b*(1.5 + 0.3*x + 0.2*x^2) - (a^2 + b^2)*a
b' = mu*b + a*(1.5 + 0.3*x + 0.2*x^2) - (a^2 + b^2)*b
x' = (a^2 + b^2 - 1 + 0.8*(x^2 + y^2) - 0.4*(x^2 + y^2)^2)*x - 1.3*y
y' = (a^2 + b^2 - 1 + 0.8*(x^2 + y^2) - 0.4*(x^2 + y^2)^2)*y + 1.3*x
e' = (mu - 0.8 - e^2 - f^2)*e - 0.4*f
f' = (mu - 0.8 - e^2 - f^2)*f + 0.4*e
"""
rotations = ["a -> -b, b -> a"]
[model.parameters]
mu = -0.1
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [-0.5, 0.5]
detect = ["HB"]
[[task]]
name = "wave"
kind = "cycles"
from = "rest/HB1"
free = "mu"
range = [-0.5, 1.2]
intervals = 12
points = "gauss"
detect = ["NS"]
[[task]]
name = "modulated"
kind = "cycles"
relative = true
from = "wave/NS2"
free = "mu"
range = [0.5, 1.4]
intervals = 12
points = "gauss"
detect = ["LPC", "PD", "NS"]
"#;

/// Labels of a task's points but its ends, and where they are in the summary.
fn found<'a>(summary: &'a Summary, task: &str) -> Vec<(&'a str, usize)> {
    let points = summary.points.iter().enumerate();
    let own = points.filter_map(|(i, point)| Some((point.label.strip_prefix(task)?.strip_prefix('/')?, i)));
    own.filter(|(label, _)| !label.starts_with("EP")).collect()
}

#[test]
fn folds_and_tori_of_modulated_waves_are_where_they_are_exactly() {
    let summary = summary(MODULATED).unwrap();
    let found = found(&summary, "modulated");
    let labels: Vec<&str> = found.iter().map(|(label, _)| *label).collect();
    assert_eq!(labels, ["NS1", "LPC1", "NS2"], "{}", summary.tasks[2].reason);
    let theta = (0.4 * TAU / 1.3_f64).rem_euclid(TAU);
    let theta = theta.min(TAU - theta);
    for (label, i) in found {
        let point = &summary.points[i];
        let mu = point.parameters["mu"];
        near("mu", mu, if label == "LPC1" { 0.6 } else { 0.8 }, 1e-7);
        close("T", point.values["period"], TAU / 1.3, 1e-7);
        if label.starts_with("NS") {
            close("theta", point.values["theta"], theta, 1e-6);
            let error = point.errors["mu"];
            assert!(error < 1e-6 && (mu - 0.8).abs() < 10.0 * error + 1e-9, "{mu} ± {error:e}");
        }
        // x² has the mean s/2.
        let s = if label == "LPC1" { 1.0 } else { 1.0 + if label == "NS1" { -1.0 } else { 1.0 } * 0.5_f64.sqrt() };
        let drift = point.values["drift_1"] - (1.5 + 0.1 * s);
        near("drift", (drift / 1.3).rem_euclid(1.0).min(1.0 - (drift / 1.3).rem_euclid(1.0)), 0.0, 1e-6);
    }
}

/// Rössler's oscillator, and an amplitude A whose phase it moves.
const DRIVING: &str = r#"
[model]
equations = """
x' = -y - z
y' = x + a*y
z' = 0.2 + z*(x - 4)
p' = grow*p - q*(2 + 0.1*x) - (p^2 + q^2)*p
q' = grow*q + p*(2 + 0.1*x) - (p^2 + q^2)*q
"""
rotations = ["p -> -q, q -> p"]
[model.parameters]
a = 0.001
grow = -0.5
[model.start]
x = "(4 - sqrt(16 - 0.8*a))/2"
y = "-(4 - sqrt(16 - 0.8*a))/(2*a)"
z = "(4 - sqrt(16 - 0.8*a))/(2*a)"
[[task]]
name = "rest"
kind = "equilibria"
free = "grow"
range = [-0.5, 0.5]
detect = ["HB"]
[[task]]
name = "growing"
kind = "cycles"
from = "rest/HB1"
free = "grow"
range = [-0.5, 0.5]
intervals = 12
points = "gauss"
[[task]]
name = "wave"
kind = "cycles"
from = "growing/EP1"
free = "a"
range = [0.001, 0.02]
intervals = 12
points = "gauss"
detect = ["NS"]
[[task]]
name = "modulated"
kind = "cycles"
relative = true
from = "wave/NS1"
free = "a"
range = [0.001, 0.2]
intervals = 40
points = "gauss"
detect = ["PD"]
errors = false
"#;

const ALONE: &str = r#"
[model]
equations = """
x' = -y - z
y' = x + a*y
z' = 0.2 + z*(x - 4)
"""
[model.parameters]
a = 0.001
[model.start]
x = "(4 - sqrt(16 - 0.8*a))/2"
y = "-(4 - sqrt(16 - 0.8*a))/(2*a)"
z = "(4 - sqrt(16 - 0.8*a))/(2*a)"
[[task]]
name = "rest"
kind = "equilibria"
free = "a"
range = [0.001, 0.2]
detect = ["HB"]
[[task]]
name = "one"
kind = "cycles"
from = "rest/HB1"
free = "a"
range = [0.001, 0.2]
intervals = 40
points = "gauss"
detect = ["PD"]
errors = false
"#;

#[test]
fn a_relative_orbit_doubles_its_period_where_the_orbit_without_the_phase_does() {
    let (driving, alone) = (summary(DRIVING).unwrap(), summary(ALONE).unwrap());
    let (relative, plain) = (found(&driving, "modulated"), found(&alone, "one"));
    assert_eq!(
        (relative.len(), plain.len()),
        (1, 1),
        "{:?}",
        driving.tasks.iter().map(|t| &t.reason).collect::<Vec<_>>()
    );
    assert_eq!(relative[0].0, "PD1");
    let (relative, plain) = (&driving.points[relative[0].1], &alone.points[plain[0].1]);
    close("a", relative.parameters["a"], plain.parameters["a"], 1e-6);
    close("T", relative.values["period"], plain.values["period"], 1e-6);
}

#[test]
fn branch_points_of_relative_orbits_are_refused() {
    let refused = summary(&MODULATED.replace("\"PD\", ", "\"BPC\", ")).unwrap_err();
    assert!(refused.contains("only LPC, PD and NS"), "{refused}");
}
