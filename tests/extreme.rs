//! The suite of extreme scenes: all can be run, the quick ones are; budgets; the table of a folder.
//! `hopfline run problems/extreme` runs the whole suite.

use hopfline::run::{self, Case, RunOptions, Summary, case_table};
use hopfline::scene::Scene;
use std::path::{Path, PathBuf};

fn suite() -> Vec<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/extreme");
    Scene::load_all(&folder, &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn run(scene: &Scene) -> Summary {
    let folder = tempfile::tempdir().unwrap();
    let options = RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    run::run(scene, &options).unwrap_or_else(|e| panic!("{}: {e}", scene.name))
}

/// Each has a title, a budget, what limits it, and a number or an end that it promises.
#[test]
fn every_scene_of_the_suite_can_be_run() {
    let scenes = suite();
    assert!(scenes.len() > 20, "{}", scenes.len());
    for scene in scenes {
        run::check(&scene, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert!(scene.budget.is_some() && !scene.limit.is_empty(), "{}", scene.name);
        assert!(!scene.expect.is_empty() || !scene.ends.is_empty(), "{} promises nothing", scene.name);
    }
}

/// No number off by more than its printed error, but for a twentieth of them.
#[test]
fn the_quick_ones_are_right_to_their_printed_errors() {
    let quick = [
        "bratu-fold",
        "dae",
        "exceptional",
        "impasse",
        "k_N-0",
        "no-damping",
        "non-normal",
        "oscillator-large",
        "oscillator-small",
        "too-coarse",
    ];
    let scenes = suite();
    let cases: Vec<Case> = quick
        .iter()
        .map(|name| {
            let scene = scenes.iter().find(|scene| scene.name == *name).unwrap_or_else(|| panic!("no scene {name}"));
            let summary = run(scene);
            assert!(summary.success(), "{}", summary.table(""));
            Case::new(scene, &summary)
        })
        .collect();
    let (right, all) = cases.iter().fold((0, 0), |(right, all), case| (right + case.right, all + case.expected));
    assert!(20 * right >= 19 * all, "{right} of {all}\n{}", case_table(&cases));
    assert!(case_table(&cases).contains(&format!("{right} of {all} numbers lie within their printed errors")));
}

/// Spent at once, a budget leaves the first points, says so, and begins no further task.
#[test]
fn a_spent_budget_stops_cleanly() {
    let text = r#"
budget = 1e-9
[model]
name = "two-doublet"
functions = 12
[[task]]
name = "first"
kind = "equilibria"
free = "p"
range = [0, 500]
detect = ["HB"]
[[task]]
name = "second"
kind = "cycles"
from = "first/HB1"
free = "p"
range = [0, 500]
"#;
    let scene = Scene::parse(text, &PathBuf::from("spent.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let summary = run(&scene);
    assert!(!summary.success() && summary.tasks.len() == 1);
    assert_eq!(summary.tasks[0].reason, "the budget of 0.000000001 s is spent");
    assert!(summary.tasks[0].points >= 1 && summary.points.iter().any(|point| point.label == "first/EP1"));
    let case = Case::new(&scene, &summary);
    assert_eq!(
        (case.verdict.as_str(), case.reason.as_str()),
        ("STOPPED", "first: the budget of 0.000000001 s is spent")
    );
    let longer = Scene::parse(text, &PathBuf::from("spent.toml"), &["budget=600".to_owned()]).unwrap();
    assert_eq!(longer.budget, Some(600.0));
}

/// An end that a scene expects is no failure, another one is.
#[test]
fn ends_are_expected_by_their_reason() {
    let text = |reason: &str| {
        format!(
            "[model]\nequations = \"\"\"\nx' = 1\n0 = x - z + z^3/3\n\"\"\"\n[model.start]\nx = 0\nz = 0\n[[task]]\nname = \
             \"motion\"\nkind = \"simulate\"\ntime = [0, 1]\n[expect]\nmotion.ends = \"{reason}\"\n"
        )
    };
    for (reason, success) in [("t = 0.66", true), ("interrupted", false)] {
        let scene = Scene::parse(&text(reason), &PathBuf::from("ends.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
        let summary = run(&scene);
        assert_eq!(summary.success(), success, "{}", summary.table(""));
        assert_eq!(Case::new(&scene, &summary).verdict, if success { "stops as expected" } else { "STOPPED" });
    }
}
