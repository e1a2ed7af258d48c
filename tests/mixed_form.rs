//! The two-doublet model with its forces kept against the form in angles alone: two discretisations that share no code but
//! the parameters must give the same numbers.

mod common;

use common::{Flagellum, close, near, spectrum};
use hopfline::bifurcation::HopfNormalForm;
use hopfline::continuation::{Border, Counts, correct};
use hopfline::linalg::Matrix;
use hopfline::models::{Law, Load, Mesh, MixedTwoDoublet};
use hopfline::orbit::{Collocation, Frame, Multipliers, Orbit, Points, from_hopf, half_period};
use hopfline::problem::{At, Automatic, check_derivatives};
use hopfline::run::{RunOptions, run};
use hopfline::scene::Scene;
use std::sync::Arc;

fn mixed((elements, degree, grading): (usize, usize, f64), load: Load, law: Law) -> Flagellum {
    let mesh = Mesh { elements, degree, grading };
    Flagellum::of(Arc::new(Automatic(MixedTwoDoublet::new(mesh, load, law))))
}

fn uniform(mesh: (usize, usize, f64)) -> Flagellum {
    mixed(mesh, Load::Uniform, Law::Printed)
}

/// Enough for eleven digits of the onset.
const FINE: (usize, usize, f64) = (8, 8, 1.15);
const ONSET: f64 = 338.889485397848;
const OMEGA: f64 = 202.675023170;

/// Numbers without pattern in (-size, size).
fn waves(n: usize, size: f64, pace: f64) -> Vec<f64> {
    (0..n).map(|i| size * (pace * i as f64 + 0.3).sin()).collect()
}

#[test]
fn derivatives_are_exact_and_the_mass_is_constant() {
    for (load, law) in [(Load::Uniform, Law::Printed), (Load::Distal, Law::Separation)] {
        let model = mixed((3, 3, 1.5), load, law);
        let n = model.problem.dim();
        let (u, v) = (waves(n, 0.3, 1.0), waves(n, 5.0, 1.7));
        let at = At { u: &u, v: &v, p: &model.p };
        assert!(check_derivatives(&*model.problem, at) < 1e-14);
        let (rest, p) = (vec![0.0; n], &model.p);
        let [here, there] = [at, At { u: &rest, v: &rest, p }].map(|at| model.problem.matrices(at).1);
        let scale = here.norm_max();
        assert!(here.plus(-1.0, &there).norm_max() < 1e-14 * scale);
        // Angles move; forces and separations follow.
        let moving = |j: &usize| here.entries().iter().any(|&(_, k, x)| k == *j && x != 0.0);
        assert_eq!((0..n).filter(moving).count(), 2 * 3 * 3);
    }
}

#[test]
fn the_straight_state_rests_at_every_load() {
    for load in [Load::Uniform, Load::Distal] {
        let model = mixed((3, 4, 1.2), load, Law::Printed).with("p", 700.0);
        let mut g = vec![1.0; model.problem.dim()];
        let straight = model.straight();
        model.problem.residual(At { u: &straight, v: &straight, p: &model.p }, &mut g);
        assert!(g.iter().all(|g| *g == 0.0));
    }
}

#[test]
fn both_forms_have_the_same_onset() {
    type Case<'a> = (&'a str, Load, &'a [(&'a str, f64)], f64, f64);
    let cases: [Case; 7] = [
        ("baseline", Load::Uniform, &[], ONSET, OMEGA),
        ("k_T = b_T = 0", Load::Uniform, &[("k_T", 0.0)], 324.648709262, 217.576764018),
        ("L = 10", Load::Uniform, &[("L", 10.0)], 426.090903937, 257.436661609),
        ("k_N = 1000", Load::Uniform, &[("k_N", 1000.0)], 136.356825057, 351.258231833),
        ("k_N = 0", Load::Uniform, &[("k_N", 0.0)], 21.497443667, 1049.312744222),
        ("tau_c = 1e-4", Load::Uniform, &[("tau_c", 1e-4)], 342.691293674, 1426.587683351),
        ("distal", Load::Distal, &[], 425.711221652, 124.123377727),
    ];
    for (case, load, changes, p, omega) in cases {
        let model = mixed(FINE, load, Law::Printed);
        let model = changes.iter().fold(model, |model, &(name, value)| model.with(name, value));
        let hopf = model.hopf(p, 0);
        close(case, hopf.p[model.index("p")], p, 1e-9);
        close(case, hopf.omega, omega, 1e-9);
    }
}

#[test]
fn both_forms_have_the_same_nonlinearity_at_the_onset() {
    // d omega / dp along the cycles, which does not depend on how eigenvectors are scaled, and the sign of l1.
    for (load, p) in [(Load::Uniform, ONSET), (Load::Distal, 425.711221652)] {
        for law in [Law::Printed, Law::Separation] {
            let slope = |model: Flagellum| {
                let hopf = model.hopf(p, 0);
                let form = HopfNormalForm::new(&*model.problem, &hopf).expect("a normal form");
                (form.omega2 / form.p2, form.l1.signum())
            };
            let (found, kind) = slope(mixed((6, 8, 1.2), load, law));
            let (expected, other) = slope(Flagellum::new(44, load, law));
            close("d omega / dp", found, expected, 1e-6);
            assert_eq!(kind, other);
        }
    }
}

#[test]
fn no_mode_is_spurious() {
    let growing = |model: &Flagellum| {
        let values = spectrum(&model.problem, (&model.straight(), &model.p), 1e4, 0);
        let count = values.iter().filter(|(value, _)| value.re > 0.0).count();
        (count, values[0].0)
    };
    for (k_n, tau_c, p) in [
        (1e4, 7.776e-4, 300.0),
        (1e4, 7.776e-4, 600.0),
        (1e4, 0.0, 600.0),
        (1e4, 7.776e-4, 1500.0),
        (1e7, 7.776e-4, 1500.0),
        (1e7, 0.0, 1500.0),
        (1e7, 7.776e-4, 9000.0),
        (1e9, 7.776e-4, 1500.0),
    ] {
        let set = |model: Flagellum| model.with("tau_c", tau_c).with("k_N", k_n).with("p", p);
        let (expected, first) = growing(&set(Flagellum::new(64, Load::Uniform, Law::Printed)));
        // Coarse meshes miss growing modes; none has one too many.
        for mesh in [(1, 2, 1.0), (3, 3, 1.0), (40, 2, 1.0), (8, 4, 1.3), (16, 2, 2.0), (4, 8, 1.5), (1, 8, 1.0)] {
            let (found, _) = growing(&set(uniform(mesh)));
            assert!(found <= expected, "k_N {k_n}, tau_c {tau_c}, p {p}, {mesh:?}: {found} instead of {expected}");
        }
        let (found, leading) = growing(&set(uniform((8, 8, 1.3))));
        assert_eq!(found, expected, "k_N {k_n}, tau_c {tau_c}, p {p}");
        near("leading eigenvalue", leading.re, first.re, 1e-3 * first.norm());
    }
}

#[test]
fn doublets_may_differ() {
    let leading = |mut model: Flagellum| {
        let i = model.index("EI_2");
        model.p[i] = 900.0;
        spectrum(&model.problem, (&model.straight(), &model.p), 1e3, 0)[0].0
    };
    let (mixed, minimal) = (leading(uniform((6, 8, 1.2))), leading(Flagellum::new(36, Load::Uniform, Law::Printed)));
    near("growth", mixed.re, minimal.re, 1e-6 * minimal.norm());
    near("frequency", mixed.im, minimal.im, 1e-6 * minimal.norm());
}

/// `p_H / exact - 1`.
fn error(mesh: (usize, usize, f64)) -> f64 {
    let model = uniform(mesh);
    model.hopf(ONSET, 0).p[model.index("p")] / ONSET - 1.0
}

#[test]
fn the_onset_converges_as_h_to_twice_the_degree_and_exponentially_in_the_degree() {
    for (degree, coarse, fine) in [(2, 16, 32), (3, 12, 24), (4, 10, 20)] {
        let (first, second) = (error((coarse, degree, 1.0)), error((fine, degree, 1.0)));
        let order = (first / second).ln() / (fine as f64 / coarse as f64).ln();
        assert!((order - 2.0 * degree as f64).abs() < 0.9, "degree {degree}: order {order:.2}");
    }
    let errors: Vec<f64> = (4..=8).map(|degree| error((6, degree, 1.2)).abs()).collect();
    assert!(errors.windows(2).all(|pair| pair[1] < 0.2 * pair[0]), "{errors:?}");
}

#[test]
fn one_degree_more_takes_up_most_of_the_error() {
    for mesh in [(4, 4, 1.0), (6, 5, 1.2), (4, 8, 1.0)] {
        let coarse = uniform(mesh);
        let finer = coarse.problem.refined().expect("a refinement");
        let raised = Flagellum { problem: finer.problem.clone(), p: coarse.p.clone() };
        let p = |model: &Flagellum| model.hopf(ONSET, 0).p[model.index("p")];
        let (first, second) = (p(&coarse) - ONSET, p(&raised) - ONSET);
        assert!(second.abs() < 0.5 * first.abs(), "{mesh:?}: {first:.1e}, then {second:.1e}");
        // The same state: what is seen of it, and what the equations that there are already say.
        let (n, pace) = (coarse.problem.dim(), 1.3);
        let (u, v) = (waves(n, 0.2, pace), vec![0.0; n]);
        let (fine, rest) = ((finer.prolong)(&u), vec![0.0; raised.problem.dim()]);
        for (i, o) in coarse.problem.observables().iter().enumerate() {
            let (a, b) = (coarse.problem.observe(i, At { u: &u, v: &v, p: &coarse.p }), {
                raised.problem.observe(i, At { u: &fine, v: &rest, p: &raised.p })
            });
            // The largest value is sought on a finer grid.
            near(o.name, b, a, if o.name.starts_with("largest") { 1e-4 } else { 1e-9 } * (1.0 + a.abs()));
        }
    }
}

const INTERVALS: (usize, usize) = (8, 4);

/// One cycle at a load, by Newton's method from a guess, on half a period.
fn corrected(model: &Flagellum, guess: &Orbit, load: f64) -> (Orbit, Multipliers) {
    let frame = Frame {
        problem: model.problem.clone(),
        p: model.p.clone(),
        free: model.index("p"),
        symmetry: model.problem.reflection().expect("a symmetric model"),
        parts: 2,
        scale_state: 0.1,
        scale_part: guess.part,
        scale_lambda: 100.0,
    };
    let system = Collocation::new(frame, guess);
    let x = Collocation::unknowns(guess);
    let border = Border { row: vec![0.0; x.len()], lambda: 1.0 };
    let found = correct(&system, (x, load), &border, &mut Counts::default()).expect("a cycle");
    let multipliers = found.factors.multipliers(None).expect("multipliers");
    (system.orbit(&found.point.x), multipliers)
}

/// Cycles at loads, the first from the normal form; then `u / r` and the frequency are taken to be linear in r² = p - p_H.
fn beats(model: &Flagellum, loads: &[f64]) -> Vec<(Orbit, Multipliers)> {
    let hopf = model.hopf(ONSET, 0);
    let onset = hopf.p[model.index("p")];
    let form = HopfNormalForm::new(&*model.problem, &hopf).expect("a normal form");
    let symmetry = half_period(&*model.problem, &hopf, 1.0).expect("an odd mode");
    let mut found: Vec<(Orbit, Multipliers)> = Vec::new();
    for (i, &load) in loads.iter().enumerate() {
        let r = |load: f64| (load - onset).sqrt();
        let guess = if let [.., (before, _), (last, _)] = &found[..] {
            let (near, far) = (r(loads[i - 1]), r(loads[i - 2]));
            let beyond = (load - loads[i - 1]) / (loads[i - 1] - loads[i - 2]);
            let along = |near: f64, far: f64| near + beyond * (near - far);
            let mut guess = last.clone();
            for (x, before) in guess.nodes.iter_mut().zip(&before.nodes) {
                *x = r(load) * along(*x / near, before / far);
            }
            guess.part = along(1.0 / last.part, 1.0 / before.part).recip();
            guess
        } else {
            let (r, mesh) = ((load - onset) / form.p2, (INTERVALS.0, INTERVALS.1, Points::Radau));
            from_hopf((&hopf, &form), model.index("p"), r.sqrt(), (&symmetry, 2), mesh).0
        };
        found.push(corrected(model, &guess, load));
    }
    found
}

#[test]
fn both_forms_have_the_same_beats() {
    const LOADS: [f64; 5] = [340.0, 341.0, 344.0, 350.0, 360.0];
    let minimal = Flagellum::new(44, Load::Uniform, Law::Printed);
    let expected = beats(&minimal, &LOADS);
    // On a coarse space first, whose onset must lie below the first load; then with its degree raised.
    let mut model = uniform((7, 5, 1.2));
    let mut found = beats(&model, &LOADS);
    for _ in 5..8 {
        let finer = model.problem.refined().expect("a refinement");
        for (orbit, _) in &mut found {
            orbit.nodes = orbit.nodes.chunks(orbit.dim).flat_map(|u| (finer.prolong)(u)).collect();
            orbit.dim = finer.problem.dim();
        }
        model.problem = finer.problem;
    }
    // 56 functions, 12 intervals of degree 4 (p = 360: and by an independent code).
    let published = [(340.0, 32.71334022, 0.26032963), (360.0, 41.66029446, 0.75740251)];
    for (load, frequency, deflection) in published {
        let i = LOADS.iter().position(|p| *p == load).expect("one of the loads");
        let (orbit, multipliers) = corrected(&model, &found[i].0, load);
        let (other, others) = &expected[i];
        close("period", orbit.period(), other.period(), 1e-6);
        close("frequency", 1.0 / orbit.period(), frequency, 1e-6);
        let extremes = |model: &Flagellum, orbit: &Orbit, i: usize| {
            let model = model.clone().with("p", load);
            let symmetry = model.problem.reflection().expect("a symmetric model");
            orbit.extremes(&*model.problem, i, &model.p, &symmetry)
        };
        let tip = model.observable("tip_deflection");
        close("deflection", extremes(&model, &orbit, tip).max, extremes(&minimal, other, tip).max, 1e-6);
        close("deflection", extremes(&model, &orbit, tip).max, deflection, 1e-6);
        for (i, o) in model.problem.observables().iter().enumerate() {
            let (a, b) = (extremes(&model, &orbit, i), extremes(&minimal, other, i));
            let size = b.max.abs().max(b.min.abs());
            // Values at points converge more slowly than integrals, and the least of largest ones has a kink in time.
            if o.name.starts_with("largest") {
                near(o.name, a.max, b.max, 1e-4 * size);
            } else {
                near(o.name, a.max, b.max, 2e-5 * size);
                near(o.name, a.min, b.min, 2e-5 * size);
            }
        }
        near("multiplier", multipliers.values[0].re, others.values[0].re, 1e-6);
        assert!(multipliers.trivial_error < 1e-6, "{:.1e}", multipliers.trivial_error);
    }
}

const SCENE: &str = r#"
title = "Few elements, their own onset at 347"
[model]
name = "two-doublet"
form = "mixed"
elements = 2
degree = 6
[[task]]
name = "straight"
kind = "equilibria"
free = "p"
range = [340, 360]
detect = ["HB"]
[[task]]
name = "onset"
kind = "hopf-curve"
from = "straight/HB1"
free = ["p", "k_N"]
range = { k_N = [990, 10000] }
errors = false
[[task]]
name = "beat"
kind = "cycles"
from = "straight/HB1"
free = "p"
range = [340, 355]
multipliers = 2
observables = ["base_tension_1"]
[[task]]
name = "motion"
kind = "simulate"
from = "straight/HB1"
amplitude = 0.05
over = { p = [355] }
time = [0, 1]
tolerance = 1e-7
"#;

#[test]
fn scenes_run_in_it_and_simulation_settles_on_the_collocated_cycle() {
    let out = tempfile::tempdir().expect("a folder");
    let path = out.path().join("few.toml");
    std::fs::write(&path, SCENE).expect("a file");
    let scene = Scene::load(&path, &[]).expect("a scene");
    let options = RunOptions { out: out.path().join("output"), only: Vec::new(), resume: false, quiet: true };
    let summary = run(&scene, &options).expect("a run");
    let reasons: Vec<_> = summary.tasks.iter().map(|task| (&task.name, &task.reason)).collect();
    assert!(summary.success(), "{reasons:?}");
    let value = |label: &str, quantity: &str| {
        let point = summary.points.iter().find(|point| point.label == label).expect(label);
        (point.values[quantity], point.errors.get(quantity).copied().unwrap_or(f64::NAN))
    };
    let (collocated, _) = value("beat/EP1", "frequency");
    let (simulated, error) = value("motion/LC1", "frequency");
    close("frequency", simulated, collocated, 1e-6);
    assert!((simulated - collocated).abs() < 2.0 * error, "{simulated} ± {error}, collocated {collocated}");
    // Two elements are far from the exact onset, and know it.
    let (p, error) = summary
        .points
        .iter()
        .find(|point| point.label == "straight/HB1")
        .map(|point| (point.parameters["p"], point.errors["p"]))
        .expect("an onset");
    assert!((p - ONSET).abs() < 3.0 * error && error < 10.0, "{p} ± {error}");
}

#[test]
fn its_matrices_are_banded() {
    for (degree, band) in [(2, 26), (8, 68)] {
        let model = uniform((20, degree, 1.0));
        let rest = model.straight();
        let (gu, _) = model.problem.matrices(At { u: &rest, v: &rest, p: &model.p });
        assert!(matches!(gu, Matrix::Banded(ref a) if a.lower() < band && a.upper() < band));
    }
}
