//! Cycles that start from samples in a file: the circle of radius sqrt(mu), exact; and what is wrong with a file.

mod common;

use common::{close, near};
use hopfline::run::{RunOptions, Summary, run};
use hopfline::scene::Scene;
use std::f64::consts::TAU;
use std::fs;

const SCENE: &str = r#"
title = "A circle from samples"

[model]
equations = """
x' = mu*x - 2*y - x*(x^2 + y^2)
y' = 2*x + mu*y - y*(x^2 + y^2)
"""

[model.parameters]
mu = 1

[[task]]
name = "cycles"
kind = "cycles"
from = "samples.csv"
free = "mu"
range = [0.25, 2.25]
multipliers = 1
tolerance = 1e-7
values = { mu = [0.49, 1, 1.69] }
observables = ["mean x", "norm x", "norm"]
"#;

/// Runs the scene beside a file of samples.
fn summary(samples: &str) -> Summary {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("samples.csv"), samples).expect("a file");
    let scene = Scene::parse(SCENE, &folder.path().join("circle.toml"), &[]).expect("a scene");
    let options = RunOptions { out: folder.path().join("out"), only: Vec::new(), resume: false, quiet: true };
    run(&scene, &options).expect("a run")
}

/// A motion that spirals out to the circle, in `count` samples.
fn spiral(count: usize) -> String {
    let row = |k: usize| {
        let t = 12.0 * k as f64 / count as f64;
        let r = 1.0 - 0.5 * (-2.0 * t).exp();
        format!("{t},{},{}\n", r * (2.0 * t).cos(), r * (2.0 * t).sin())
    };
    "t,x,y\n".to_owned() + &(0..count).map(row).collect::<String>()
}

#[test]
fn a_branch_goes_both_ways_from_the_last_turn() {
    let summary = summary(&spiral(900));
    assert!(summary.success(), "{}", summary.table(""));
    let ends: Vec<f64> = summary.points.iter().filter(|p| p.label.contains("EP")).map(|p| p.parameters["mu"]).collect();
    assert_eq!(ends, [0.25, 2.25]);
    assert_eq!(summary.points.len(), 5, "the start is found once");
    for (label, mu) in [("cycles/UZ1", 1.0_f64), ("cycles/UZ2", 0.49), ("cycles/UZ3", 1.69)] {
        let point = summary.points.iter().find(|point| point.label == label).expect("a point");
        close("mu", point.parameters["mu"], mu, 1e-14);
        close("period", point.values["period"], TAU / 2.0, 1e-9);
        near("mean", point.values["mean x"], 0.0, 1e-9);
        close("norm of x", point.values["norm x"], (mu / 2.0).sqrt(), 1e-9);
        close("norm", point.values["norm"], mu.sqrt(), 1e-9);
        // exp(-2 mu T).
        near("multiplier", point.values["mu_1_re"], (-2.0 * mu * TAU / 2.0).exp(), 1e-8);
    }
}

/// What a file held before is no state to go on from.
#[test]
fn other_samples_are_another_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = Scene::parse(SCENE, &folder.path().join("circle.toml"), &[]).expect("a scene");
    let mut options = RunOptions { out: folder.path().join("out"), only: Vec::new(), resume: false, quiet: true };
    let mut start = |samples: &str, resume: bool| {
        fs::write(folder.path().join("samples.csv"), samples).expect("a file");
        options.resume = resume;
        run(&scene, &options).expect("a run").success()
    };
    assert!(start(&spiral(900), false) && start(&spiral(900), true));
    assert!(!start("t,x,y\n0,1,0\n", true));
}

#[test]
fn what_is_wrong_with_samples_is_said() {
    let still: String = (0..40).map(|k| format!("{k},1,1\n")).collect();
    let line: String = (0..40).map(|k| format!("{k},{k},0\n")).collect();
    for (samples, wanted) in [
        ("t,x,y\n0,1,0\n1,0\n".to_owned(), "line 3: 2 numbers; there must be 3: the time and 2 states"),
        ("t,x,y\n0,1,0\n0,1,0\n".to_owned(), "line 3: the time 0 does not come after the one before it"),
        ("t,x,y\n0,one,0\n".to_owned(), "line 2: not a row of numbers"),
        ("t,x,y\n0,inf,0\n".to_owned(), "line 2: a number is not finite"),
        ("t,x,y\n0,1,0\n".to_owned(), "1 samples; at least 8 are needed"),
        (format!("t,x,y\n{still}"), "do not come back"),
        (format!("t,x,y\n{line}"), "do not come back"),
    ] {
        let summary = summary(&samples);
        let reason = &summary.tasks[0].reason;
        assert!(!summary.success() && reason.contains("samples.csv") && reason.contains(wanted), "{wanted}: {reason}");
    }
}
