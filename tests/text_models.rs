//! Models as text: the same numbers as models in Rust, errors at their place in the scene, files of other programs.

mod common;

use common::brusselator::Brusselator;
use common::lorenz::Lorenz;
use common::{close, text};
use hopfline::linalg::Structure;
use hopfline::models::{self, Options};
use hopfline::problem::{At, Direction, Problem, check_derivatives};
use hopfline::run;
use hopfline::scene::{Scene, SceneError};
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};

fn numbers(seed: f64, n: usize) -> Vec<f64> {
    (0..n).map(|i| (seed + 1.7 * i as f64).sin()).collect()
}

/// Residual, first, second and third derivatives and Taylor coefficients agree to rounding.
#[track_caller]
fn assert_same(native: &dyn Problem, text: &dyn Problem, p: &[f64]) {
    let n = native.dim();
    assert_eq!(text.dim(), n);
    let (u, v, a, b) = (numbers(0.3, n), numbers(1.1, n), numbers(2.3, n), numbers(3.9, n));
    let (q, at) = (numbers(5.0, p.len()), At { u: &u, v: &v, p });
    let directions =
        [Direction { u: &a, v: &b, p: &q }, Direction { u: &b, v: &a, p: &[] }, Direction { u: &v, v: &u, p: &[] }];
    type Evaluate<'a> = Box<dyn Fn(&dyn Problem, &mut [f64]) + 'a>;
    let mut all: Vec<(String, Evaluate)> =
        vec![("residual".into(), Box::new(|problem, out| problem.residual(at, out)))];
    for k in 1..=3 {
        let d = &directions[..k];
        all.push((format!("derivative {k}"), Box::new(move |problem, out| problem.derivative(at, d, out))));
    }
    let terms = [directions[1], directions[2], directions[1], directions[2], directions[1]];
    for k in 1..=5 {
        all.push((format!("coefficient {k}"), Box::new(move |problem, out| problem.coefficient(at, &terms[..k], out))));
    }
    for (what, evaluate) in all {
        let (mut x, mut y) = (vec![0.0; n], vec![0.0; n]);
        evaluate(native, &mut x);
        evaluate(text, &mut y);
        let scale = x.iter().fold(1.0_f64, |scale, x| scale.max(x.abs()));
        for i in 0..n {
            assert!((x[i] - y[i]).abs() <= 1e-13 * scale, "{what}, {i}: {} and {}", x[i], y[i]);
        }
    }
    assert!(check_derivatives(text, at) < 1e-13);
}

#[test]
fn text_and_rust_are_the_same_model() {
    assert_same(&*Lorenz::problem(), &*text::lorenz(), &[28.0, 10.0, 8.0 / 3.0]);
    assert_same(&*Brusselator::chain(20, true), &*text::brusselator(20), &[0.52]);
    assert_eq!(text::brusselator(20).structure(), Structure::Banded { lower: 2, upper: 2 });
    let built_in = (models::find("lorenz-84").unwrap().build)(&Options::default()).unwrap();
    let equations = "\
        X' = -Y^2 - Z^2 - alpha*X + alpha*F - gamma*U^2
        Y' = X*Y - beta*X*Z - Y + G
        Z' = beta*X*Y + X*Z - Z
        U' = -delta*U + gamma*U*X + T";
    let parameters = ["alpha", "beta", "gamma", "delta", "G", "F", "T"].map(|name| (name, 0.0));
    let written = text::problem(&text::written(equations, &parameters, &[])).unwrap();
    assert_same(&*built_in, &*written, &[0.25, 1.0, 0.987, 1.04, 0.25, 3.0, 0.04]);
}

/// Long chains are read, and differentiated by bands, in a moment.
#[test]
fn chains_may_be_long() {
    let long = text::brusselator(50_000);
    assert_eq!((long.dim(), long.structure()), (100_000, Structure::Banded { lower: 2, upper: 2 }));
    let u = long.start(&[0.5]);
    let (rest, mut g) = (vec![0.0; u.len()], vec![1.0; u.len()]);
    long.residual(At { u: &u, v: &rest, p: &[0.5] }, &mut g);
    // Uniform: 2 and 2.725 are the state at the ends.
    assert!(g.iter().all(|g| g.abs() < 1e-12));
}

/// The fold of Bratu's problem, by n points: the error goes as h².
#[test]
fn bratus_fold_converges_as_a_square() {
    let exact = 3.513830719125162;
    let errors = [49, 99, 199].map(|n: usize| {
        let folder = tempfile::tempdir().unwrap();
        let scene = Scene::load(&problems().join("bratu.toml"), &[format!("model.n={n}")]).unwrap();
        let options = run::RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
        let summary = run::run(&scene, &options).unwrap();
        let fold = summary.points.iter().find(|point| point.label == "states/LP1").unwrap();
        fold.parameters["lambda"] - exact
    });
    close("order 2", errors[0] / errors[1], 4.0, 2e-3);
    close("order 2", errors[1] / errors[2], 4.0, 1e-3);
}

fn problems() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("problems")
}

const SCENE: &str = r#"title = "Chain"
[model]
equations = """
u[i]' = D*(u[i-1] - 2*u[i] + u[i+1]) + R - x  for i = 1..N   # diffusion
x' = sum(u[i], i = 1..N)/N - x

R = a/(1 + x)
u[0] = 0
u[N+1] = 1
"""
N = 20
[model.parameters]
D = { value = 2, unit = "m^2/s", min = 0, meaning = "diffusion" }
a = 1
[model.start]
u = "a/2"
[model.observables]
mean = "sum(u[i], i = 1..N)/N"
[[task]]
name = "steady"
kind = "equilibria"
free = "a"
range = [0, 2]
observables = ["mean", "x"]
"#;

fn load(text: &str, sets: &[&str]) -> Result<(), String> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let scene = Scene::parse(text, Path::new("chain.toml"), &sets).map_err(|error: SceneError| error.to_string())?;
    run::check(&scene, &[]).map_err(|error| error.to_string())
}

#[test]
fn errors_point_at_line_and_column() {
    assert_eq!(load(SCENE, &[]), Ok(()));
    for (from, to, expected) in [
        ("R = a/(1 + x)", "R = a/(1 + xx)", "chain.toml:7:12: model.equations: unknown name \"xx\""),
        ("- 2*u[i]", "- 2 u[i]", "chain.toml:4:23: model.equations: expected an operator"),
        ("u[N+1] = 1", "", "chain.toml:4:30: model.equations: u[21] is not defined, only u[0] to u[20]"),
        (
            "x' = sum",
            "x' = summ",
            "chain.toml:5:19: model.equations: expected an operator or \")\", since only sum(BODY, i = FROM..TO) takes an index",
        ),
        (
            "1 + x)",
            "x)",
            "chain.toml:7:6: model.equations: the equation of u[1] is not finite at the start: 0 is divided by zero",
        ),
        ("u = \"a/2\"", "u = \"a/c\"", "chain.toml:16:8: model.start.u: unknown name \"c\""),
        (
            "\"sum(u[i], i = 1..N)/N\"",
            "\"sum(u[i], i = 1..M)/N\"",
            "chain.toml:18:26: model.observables.mean: \"M\" is not a whole number",
        ),
        ("D = { value = 2,", "D = { value = -2,", "chain.toml:13: model.parameters.D: -2: must be >= 0"),
        ("N = 20", "N = 20.5", "chain.toml:11: model.N: must be a whole number"),
        (
            "N = 20",
            "startt = \"x\"",
            "chain.toml:11: model.startt: unknown key of a model as text \"startt\" (did you mean \"start\"?)",
        ),
        ("N = 20", "N = 20\nname = \"chain\"", "chain.toml:12: model.name: a model is either"),
        ("N = 20", "N = 20\nsymmetry = \"x -> -x\"", "model.symmetry: the symmetry does not hold"),
        ("a = 1\n", "a = 1\nomega = 1\n", "chain.toml:15: model.parameters.omega: \"omega\" is the name of a column"),
        ("a = 1\n", "a = \"D*b\"\n", "chain.toml:14:8: model.parameters.a: \"b\" is not a parameter"),
        (
            "observables = [\"mean\"",
            "observables = [\"man\"",
            "unknown observable or column \"man\" (did you mean \"mean\"?)",
        ),
        ("[model.start]", "[parameters]\nb = 2\n[model.start]", "parameters.b: unknown parameter \"b\""),
    ] {
        let error = load(&SCENE.replacen(from, to, 1), &[]).expect_err(from);
        assert!(error.contains(expected), "{to}: {error}");
    }
}

#[test]
fn values_are_laid_over_text_models() {
    for sets in [["model.N=40", "parameters.D=3"], ["model.parameters.a=2", "parameters.D=a/4 + 1"]] {
        assert_eq!(load(SCENE, &sets), Ok(()), "{sets:?}");
    }
    let error = load(SCENE, &["model.N=0"]).expect_err("an empty range");
    assert!(error.contains("the range i = 1..N is empty: it runs from 1 to 0"), "{error}");
    let error = load(SCENE, &["model.N=1000000"]).expect_err("too long");
    assert!(error.contains("too long; at most 400000 elements"), "{error}");
    let error = load(SCENE, &["model.equations=x' = y"]).expect_err("no y");
    assert!(error.starts_with("chain.toml: --set model.equations=x' = y: model.equations"), "{error}");
    let error = load(SCENE, &["parameters.D={ value = 1, unit = \"s\" }"]).expect_err("no fit");
    assert!(error.contains("do not fit"), "{error}");
}

/// The scene in the README is complete; its equilibria have trace zero at v² = 1 - eps b.
#[test]
fn the_readme_example_runs() {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let section = readme.split("## Write a model as text").nth(1).unwrap();
    let example = section.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::parse(example, Path::new("neuron.toml"), &[]).unwrap();
    let options = run::RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run::run(&scene, &options).unwrap();
    let hopf = summary.points.iter().find(|point| point.label == "rest/HB1").unwrap();
    let v = -(1.0_f64 - 0.08 * 0.8).sqrt();
    close("I", hopf.parameters["I"], (v + 0.7) / 0.8 - v + v.powi(3) / 3.0, 1e-12);
}

fn ode(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ode").join(name)
}

#[test]
fn files_of_xppaut_become_scenes() {
    for (name, unknowns, parameters) in [("lorenz.ode", 3, 3), ("morris-lecar.ode", 2, 13), ("algebraic.ode", 2, 2)] {
        let (scene, notes) = run::import(&ode(name)).unwrap_or_else(|error| panic!("{error}"));
        let scene = Scene::parse(&scene, Path::new("imported.toml"), &[]).unwrap();
        let plan = run::plan(&scene).unwrap();
        assert!(plan.contains(&format!("with {unknowns} unknowns")), "{plan}");
        assert_eq!(scene.model.text.unwrap().parameters.len(), parameters, "{name}");
        assert!(!notes.is_empty(), "{name} has options that are left out");
    }
}

/// The imported Lorenz system has its Hopf point where theory has it; range and start are those of the file.
#[test]
fn an_imported_scene_runs() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, _) = run::import(&ode("lorenz.ode")).unwrap();
    let scene = Scene::parse(&scene, Path::new("lorenz.toml"), &[]).unwrap();
    let options = run::RunOptions { out: folder.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let summary = run::run(&scene, &options).unwrap();
    let hopf = summary.points.iter().find(|point| point.label == "steady/HB1").unwrap();
    close("rho", hopf.parameters["r"], 470.0 / 19.0, 1e-12);
}

/// Morris and Lecar's equations, written out: every idiom of the file has its meaning.
#[test]
fn an_imported_model_is_the_one_in_the_file() {
    let (scene, _) = run::import(&ode("morris-lecar.ode")).unwrap();
    let scene = Scene::parse(&scene, Path::new("ml.toml"), &[]).unwrap();
    let words = scene.model.text.unwrap();
    let parameters: Vec<(&str, f64)> = [
        ("vk", -84.0),
        ("vl", -60.0),
        ("vca", 120.0),
        ("i", 30.0),
        ("gk", 8.0),
        ("gl", 2.0),
        ("c", 20.0),
        ("v1", -1.2),
        ("v2", 18.0),
        ("v3", 2.0),
        ("v4", 30.0),
        ("phi", 0.04),
        ("half", 15.0),
    ]
    .to_vec();
    let names: Vec<&str> = words.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
    assert_eq!(names, parameters.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    let problem = text::problem(&text::written(&words.equations.text, &parameters, &[])).unwrap();
    let (v, w) = (-23.0_f64, 0.3_f64);
    let mut g = [0.0; 2];
    let p: Vec<f64> = parameters.iter().map(|(_, value)| *value).collect();
    problem.residual(At { u: &[v, w], v: &[0.0, 0.0], p: &p }, &mut g);
    let m = 0.5 * (1.0 + ((v + 1.2) / 18.0).tanh());
    let current = 30.0 + 2.0 * (-60.0 - v) + 8.0 * w * (-84.0 - v) - 4.4 * m * (v - 120.0);
    close("v'", -g[0], current / 20.0, 1e-14);
    let rate = 0.04 * (0.5 * (1.0 + ((v - 2.0) / 30.0).tanh()) - w) * ((v - 2.0) / 60.0).cosh();
    close("w'", -g[1], rate, 1e-14);
    let observables: Vec<&str> = words.observables.iter().map(|o| o.expression.text.as_str()).collect();
    assert_eq!(observables, ["ica", "i * v^2 / log(exp(1))"]);
}

#[test]
fn what_cannot_be_imported_is_said_with_its_line() {
    let error = run::import(&ode("unsupported.ode")).map(drop).expect_err("must be refused").to_string();
    for expected in [
        "unsupported.ode:1: the function heav is not supported",
        "unsupported.ode:2: conditions (if, <, >, &, |) are not supported",
        "unsupported.ode:3: a scene has no events that change the state",
        "unsupported.ode:4: a scene has no noise",
        "unsupported.ode:5: arrays of names, x[1..n], are not supported",
        "unsupported.ode:6: expected NAME = NUMBER, found \"a = b\"",
        "unsupported.ode:7: unknown name gamm; did you mean gamma?",
        "unsupported.ode:8: the function delay is not supported",
        "unsupported.ode:10: time t in a right-hand side is not supported",
    ] {
        assert!(error.contains(expected), "{expected}: {error}");
    }
    let error = run::import(&ode("none.ode")).map(drop).expect_err("must be refused").to_string();
    assert!(error.contains("cannot read"), "{error}");
}

/// Shipped scenes with models as text.
fn written_scenes() -> Vec<String> {
    let paths = fs::read_dir(problems()).unwrap().map(|entry| entry.unwrap().path());
    let scenes = paths.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    scenes.map(|path| fs::read_to_string(path).unwrap()).filter(|text| text.contains("equations")).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Bytes of a scene cut out, doubled or replaced: an answer, and never a panic.
    #[test]
    fn mutated_scenes_are_answered(
        which in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(),
        cut in 0..12_usize,
        new in "\\PC{0,4}|[-+*/^()\\[\\]{}'\"=,.a-z0-9\n ]{0,6}",
    ) {
        let scenes = written_scenes();
        let text = which.get(&scenes);
        let places: Vec<usize> = text.char_indices().map(|(at, _)| at).collect();
        let start = at.index(places.len());
        let end = places.get(start + cut).copied().unwrap_or(text.len());
        let _ = load(&format!("{}{new}{}", &text[..places[start]], &text[end..]), &[]);
    }
}

/// Each equation counts by its own size, beside others that are a thousand million times larger.
#[test]
fn a_false_symmetry_is_seen_beside_stiff_equations() {
    let stiff = r#"
[model]
symmetry = "x -> -x, y -> -y"
equations = """
x' = -1e11*x
y' = -y + 0.3*y^2 + mu
"""
[model.parameters]
mu = 0.1
[[task]]
name = "rest"
kind = "equilibria"
free = "mu"
range = [0, 0.3]
"#;
    let error = load(stiff, &[]).unwrap_err();
    assert!(error.contains("the symmetry does not hold: the equation of y changes"), "{error}");
}
