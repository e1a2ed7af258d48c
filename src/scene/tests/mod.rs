//! Tests of whole scenes: a good one, and what is said about spoiled copies of it.

mod bench;
mod names;
mod overrides;
mod values;
mod words;

use std::path::Path;

use super::*;

const GOOD: &str = r#"title = "Two doublets"
[model]
name = "two-doublet"
load = "uniform"
functions = 28
gain = 1.5
exact = true

[parameters]
k_N = 1e4
L = { value = 12000, unit = "nm" }
tau_c = "c_N * L^4 / EI / 200"
n = 3

[[task]]
name = "straight"
kind = "equilibria"
free = "p"
range = [0, 500]
spectrum = 8
detect = ["HB"]

[[task]]
name = "beat"
kind = "cycles"
from = "straight/HB1"
free = "p"
range = { p = [0, 420] }
values = { p = [340, 360.5], max_tip = [1] }
max_step = 5
max_points = 200
observables = ["energy"]
errors = false
intervals = 30
degree = 5
multipliers = true
symmetry = "none"

[[figure]]
name = "diagram"
x = "p"
y = "max tip_deflection"
tasks = ["straight", "beat"]

[[figure]]
name = "spectrum"
kind = "eigenvalues"
tasks = ["straight"]

[[figure]]
name = "beat"
kind = "waveform"
point = "beat/UZ2"
title = "One period"

[expect]
"straight/HB1".p = { value = 338.889485397848, tolerance = 1e-9, source = "two codes" }
"beat/UZ1"."max tip_deflection" = { value = 0, tolerance = 1 }
"#;

fn parse(text: &str, sets: &[&str]) -> Result<Scene, SceneError> {
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    Scene::parse(text, Path::new("problems/good.toml"), &sets)
}

fn good() -> Scene {
    parse(GOOD, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The complaint about the good scene with one piece replaced.
fn spoiled(piece: &str, replacement: &str) -> String {
    assert_eq!(GOOD.matches(piece).count(), 1, "{piece:?} must stand once");
    match parse(&GOOD.replace(piece, replacement), &[]) {
        Ok(_) => panic!("{replacement:?} must be refused"),
        Err(error) => error.to_string(),
    }
}

fn check(cases: &[(&str, &str, &str)]) {
    for (piece, replacement, expected) in cases {
        same(&spoiled(piece, replacement), &format!("problems/good.toml:{expected}"));
    }
}

/// An expected text may end in "..." where a list grows with the program.
fn same(found: &str, expected: &str) {
    match expected.strip_suffix("...") {
        Some(start) => assert!(found.starts_with(start), "{found:?} does not start with {start:?}"),
        None => assert_eq!(found, expected),
    }
}

#[test]
fn a_scene_is_read_in_full() {
    let scene = good();
    assert_eq!((scene.name.as_str(), scene.title.as_str()), ("good", "Two doublets"));
    assert!(!scene.overridden);
    let options: Vec<_> = scene.model.options.iter().map(|o| (o.name.as_str(), o.value.clone())).collect();
    assert_eq!(scene.model.name, "two-doublet");
    assert_eq!(
        options,
        [
            ("load", OptionValue::Text("uniform".to_owned())),
            ("functions", OptionValue::Integer(28)),
            ("gain", OptionValue::Number(1.5)),
            ("exact", OptionValue::Flag(true)),
        ]
    );
    let [k, l, tau, n] = scene.parameters.as_slice() else { panic!("four parameters") };
    assert!(matches!(k.value, Value::Number(1e4)) && matches!(n.value, Value::Number(3.0)));
    assert!(matches!(&l.value, Value::Quantity { value: 12000.0, unit } if unit == "nm"));
    assert!(matches!(&tau.value, Value::Tie(tie) if tie.to_string() == "c_N * L^4 / EI / 200"));
    assert_eq!(tau.at, Place { key: "parameters.tau_c".to_owned(), line: Some(12) });

    let [straight, beat] = scene.tasks.as_slice() else { panic!("two tasks") };
    assert_eq!(straight.at, Place { key: "task.straight".to_owned(), line: Some(15) });
    let TaskKind::Equilibria(straight) = &straight.kind else { panic!("equilibria") };
    assert_eq!((straight.spectrum, straight.detect.as_slice()), (8, &["HB".to_owned()][..]));
    assert_eq!((straight.along.max_step, straight.along.max_points, straight.along.errors), (None, 1000, true));
    let TaskKind::Cycles(beat) = &beat.kind else { panic!("cycles") };
    assert_eq!((beat.from.as_str(), beat.from_at.line), ("straight/HB1", Some(26)));
    assert_eq!((beat.intervals, beat.degree, beat.multipliers, beat.symmetry), (Some(30), 5, 6, false));
    let along = &beat.along;
    assert_eq!((along.range.from, along.range.to), (0.0, 420.0));
    assert_eq!(along.values["p"], [340.0, 360.5]);
    assert_eq!((along.max_step, along.max_points, along.errors), (Some(5.0), 200, false));
    assert_eq!(along.places["values"].line, Some(29));

    let [diagram, spectrum, waveform] = scene.figures.as_slice() else { panic!("three figures") };
    assert_eq!((diagram.kind.as_str(), diagram.y.as_slice()), ("diagram", &["max tip_deflection".to_owned()][..]));
    assert_eq!((spectrum.kind.as_str(), spectrum.x.as_deref()), ("eigenvalues", Some("p")));
    assert_eq!((waveform.point.as_deref(), waveform.title.as_deref()), (Some("beat/UZ2"), Some("One period")));
    let [hopf, rest] = scene.expect.as_slice() else { panic!("two expectations") };
    assert_eq!((hopf.label.as_str(), hopf.quantity.as_str(), hopf.tolerance), ("straight/HB1", "p", 1e-9));
    assert_eq!((hopf.source.as_str(), rest.source.as_str(), rest.at.line), ("two codes", "", Some(58)));
}

#[test]
fn what_is_left_out_has_defaults() {
    let scene = parse("[model]\nname = \"m\"\n", &[]).expect("a model is enough");
    assert_eq!(scene.title, "good");
    assert!(scene.parameters.is_empty() && scene.tasks.is_empty() && scene.expect.is_empty());
    let text =
        GOOD.replace("intervals = 30\ndegree = 5\nmultipliers = true\nsymmetry = \"none\"\n", "multipliers = 3\n");
    let scene = parse(&text, &[]).expect("valid");
    let Some(TaskKind::Cycles(beat)) = scene.tasks.get(1).map(|task| &task.kind) else { panic!("cycles") };
    assert_eq!((beat.intervals, beat.degree, beat.multipliers, beat.symmetry), (None, 4, 3, true));
}

#[test]
fn callers_complain_in_the_same_words() {
    let scene = parse(GOOD, &["parameters.L=14"]).expect("valid");
    let complaint = |setting: &Setting| scene.refuse(&setting.at, "must be positive").to_string();
    assert_eq!(complaint(&scene.parameters[0]), "problems/good.toml:10: parameters.k_N: must be positive");
    assert_eq!(
        complaint(&scene.parameters[1]),
        "problems/good.toml: --set parameters.L=14: parameters.L: must be positive"
    );
    let fault = Fault::unknown("parameter", "k_n", ["k_N", "k_T"]);
    assert_eq!(
        scene.fault(&scene.parameters[0].at, fault).to_string(),
        "problems/good.toml:10: parameters.k_N: unknown parameter \"k_n\" (did you mean \"k_N\"?); allowed: k_N, k_T"
    );
}

#[test]
fn unreadable_files_are_named() {
    let error = Scene::load(Path::new("no/such/scene.toml"), &[]).expect_err("no such file");
    assert!(error.to_string().starts_with("cannot read the scene no/such/scene.toml: "), "{error}");
}

proptest::proptest! {
    /// Whatever stands in a value's place, the answer is a scene or an error.
    #[test]
    fn any_value_is_answered(line in 0..60usize, value in "\\PC{0,20}") {
        let text: Vec<String> = GOOD
            .lines()
            .enumerate()
            .map(|(i, old)| match old.split_once(" = ") {
                Some((key, _)) if i == line => format!("{key} = {value}"),
                _ => old.to_owned(),
            })
            .collect();
        let _ = parse(&text.join("\n"), &[]);
    }

    #[test]
    fn any_override_is_answered(key in "(parameters|model|task|figure|title)(\\.(beat|L|range|straight|p)){0,3}", value in "\\PC{0,12}") {
        let _ = parse(GOOD, &[&format!("{key}={value}")]);
    }
}
