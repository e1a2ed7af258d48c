//! The two-doublet model about its straight state.
//!
//! The numbers come from two independent codes (a Galerkin and a boundary-value one) that agree to the digits given;
//! a digit that is not given is not tested.

mod common;

use common::{Flagellum, close, close_complex, matrices, near, spectrum};
use hopfline::bifurcation::HopfNormalForm;
use hopfline::linalg::c64;
use hopfline::models::{Law, Load};
use hopfline::problem::At;
use std::f64::consts::TAU;

/// Enough for 11 digits of every onset here.
const FUNCTIONS: usize = 28;

fn uniform() -> Flagellum {
    Flagellum::new(FUNCTIONS, Load::Uniform, Law::Printed)
}

/// Onset load and frequency to 1e-9: the table gives omega to 12 digits, p to 12.
#[track_caller]
fn onset(case: &str, model: &Flagellum, p: f64, omega: f64) {
    let hopf = model.hopf(p, 0);
    close(case, hopf.p[model.index("p")], p, 1e-9);
    close(case, hopf.omega, omega, 1e-9);
}

#[test]
fn the_onset_at_baseline_has_the_known_load_and_frequency() {
    let hopf = uniform().hopf(330.0, 0);
    close("p", hopf.p[uniform().index("p")], 338.889485397848, 1e-11);
    close("omega", hopf.omega, 202.675023170, 1e-11);
}

#[test]
fn the_onset_without_shear_coupling_has_the_known_load_and_frequency() {
    onset("k_T = b_T = 0", &uniform().with("k_T", 0.0), 324.648709262, 217.576764018);
}

#[test]
fn the_onset_of_a_shorter_flagellum_has_the_known_load_and_frequency_in_both_conventions() {
    let short = uniform().with("L", 10.0);
    onset("tau_c fixed", &short, 426.090903937, 257.436661609);
    let tau = short.get("tau");
    onset("tau_c = tau/200", &short.with("tau_c", tau / 200.0), 427.829901502, 508.416715403);
}

#[test]
fn the_onset_with_weak_normal_coupling_has_the_known_load_and_frequency() {
    onset("k_N = 1000", &uniform().with("k_N", 1000.0), 136.356825057, 351.258231833);
    onset("k_N = 0", &uniform().with("k_N", 0.0), 21.497443667, 1049.312744222);
}

#[test]
fn the_onset_under_distal_load_has_the_known_load_and_frequency() {
    onset("distal", &Flagellum::new(FUNCTIONS, Load::Distal, Law::Printed), 425.711221652, 124.123377727);
}

#[test]
fn the_onset_with_quick_coupling_has_the_known_load_and_frequency() {
    onset("tau_c = 1e-4", &uniform().with("tau_c", 1e-4), 342.691293674, 1426.587683351);
}

#[test]
fn the_second_and_third_pairs_cross_at_the_known_loads() {
    // The third needs 36 functions for as many digits as the second has with 28.
    let model = Flagellum::new(36, Load::Uniform, Law::Printed);
    for (rank, p) in [(1, 438.342), (2, 556.962)] {
        let hopf = model.hopf(p, rank);
        // Six digits are given.
        near("p", hopf.p[model.index("p")], p, 5e-4);
    }
}

#[test]
fn leading_eigenvalues_have_the_known_values() {
    let leading = |p: f64| -> Vec<c64> {
        let model = uniform().with("p", p);
        let pairs = spectrum(&model.problem, (&model.straight(), &model.p), 3e3, 0);
        pairs.into_iter().map(|(value, _)| value).collect()
    };
    let found = leading(330.0);
    let expected = [
        c64::new(-67.43217869, 190.52031234),
        c64::new(-67.43217869, -190.52031234),
        c64::new(-358.88712721, 0.0),
        c64::new(-709.34221909, 132.30385541),
        c64::new(-709.34221909, -132.30385541),
    ];
    for (found, expected) in found.iter().zip(expected) {
        // Eight decimals are given, of which the last is rounded.
        near("re", found.re, expected.re, 1e-8);
        near("im", found.im, expected.im, 1e-8);
    }
    // Two or three decimals of the real part, four of the frequency.
    for (p, re, hertz, digits) in
        [(350.0, 87.776, 34.3885, 3), (400.0, 530.0, 42.5839, 2), (500.0, 1625.44, 58.3129, 2)]
    {
        let found = leading(p)[0];
        near("re", found.re, re, 0.51 * 0.1_f64.powi(digits));
        near("frequency", found.im / TAU, hertz, 0.51e-4);
    }
}

#[test]
fn the_pair_crosses_at_the_known_rate() {
    let model = uniform();
    let hopf = model.hopf(330.0, 0);
    // p-bar = p L³/EI, sigma-bar = sigma tau.
    let scale = model.get("tau") * model.get("EI") / model.get("L").powi(3);
    // Nine decimals are given.
    close_complex("d sigma / dp", hopf.slope * scale, c64::new(0.278044654, 0.046124962), 2e-9);
}

#[test]
fn the_onset_converges_from_above_with_the_number_of_functions() {
    let onset = |functions: usize| {
        let model = Flagellum::new(functions, Load::Uniform, Law::Printed);
        model.hopf(350.0, 0).p[model.index("p")]
    };
    let exact = 338.889485397848;
    let mut last = f64::INFINITY;
    for (functions, p, half_digit) in [(8, 371.0, 0.5), (12, 340.8, 0.05), (16, 338.913, 5e-4), (24, 338.88949, 5e-6)] {
        let found = onset(functions);
        near(&format!("{functions} functions"), found, p, half_digit);
        // At 24 functions the rest is of the size of the reference's last digits.
        assert!(found < last && found > exact - 1e-9, "{functions} functions: {found}");
        last = found;
    }
}

#[test]
fn a_refined_model_has_the_prolonged_solution_with_a_smaller_error() {
    let coarse = Flagellum::new(16, Load::Uniform, Law::Printed);
    let refinement = coarse.problem.refined().expect("a refinement");
    let fine = Flagellum { problem: refinement.problem, p: coarse.p.clone() };
    assert!(fine.problem.dim() > coarse.problem.dim());
    let p = fine.index("p");
    let error = |model: &Flagellum| model.hopf(345.0, 0).p[p] - 338.889485397848;
    assert!(error(&fine) < 0.05 * error(&coarse));
    // The same shape: all observables of the state agree to rounding (those of the grid search to its accuracy).
    let u: Vec<f64> = (0..32).map(|i| if i < 16 { 0.4 } else { 0.3 } / (1.0 + i as f64 % 15.0).powi(3)).collect();
    let image = (refinement.prolong)(&u);
    for name in ["tip_deflection", "tip_deflection_2", "tip_angle_1", "energy", "largest_angle", "largest_difference"] {
        let v = |model: &Flagellum, u: &[f64]| model.observe(name, u, &vec![0.0; u.len()]);
        close(name, v(&fine, &image), v(&coarse, &u), 1e-8);
    }
}

/// First Lyapunov coefficient at the first Hopf point.
fn l1(model: &Flagellum) -> f64 {
    HopfNormalForm::new(&*model.problem, &model.hopf(340.0, 0)).expect("a normal form").l1
}

#[test]
fn the_first_hopf_point_is_supercritical_only_by_the_cubic_springs() {
    for law in [Law::Printed, Law::Separation] {
        let model = Flagellum::new(FUNCTIONS, Load::Uniform, law);
        assert!(l1(&model) < 0.0, "{law:?}");
        assert!(l1(&model.with("k_3N", 0.0).with("k_3T", 0.0)) > 0.0, "{law:?}");
    }
}

#[test]
fn the_first_lyapunov_coefficient_vanishes_at_the_known_normal_stiffness() {
    for (law, k_3n) in [(Law::Printed, 2.42e4), (Law::Separation, 5.41e4)] {
        let model = Flagellum::new(FUNCTIONS, Load::Uniform, law);
        let at = |k: f64| l1(&model.clone().with("k_3N", k));
        // A cubic coefficient enters c1 through third derivatives alone: l1 is affine in it.
        let (none, some) = (at(0.0), at(1e5));
        near("l1 is affine in k_3N", at(5e4), 0.5 * (none + some), 1e-9 * (some - none).abs());
        // Three digits are given.
        near("k_3N", 1e5 * none / (none - some), k_3n, 51.0);
    }
}

#[test]
fn the_cycles_near_onset_grow_as_known() {
    // p - p_H = 15.6 y², y the largest tip deflection of the mean line: to first order L int psi_m dx with
    // psi = 2 r Re(q e^{i omega t}); int q_k = L (1/2, 1/(2 sqrt 3), 0, 0, ...) for the integrated Legendre polynomials
    // (here with the sign of q_1 = sqrt 3 (x² - x)).
    let model = uniform();
    let hopf = model.hopf(340.0, 0);
    let form = HopfNormalForm::new(&*model.problem, &hopf).expect("a normal form");
    let q = |k: usize| 0.5 * (hopf.q[k] + hopf.q[FUNCTIONS + k]);
    let tip = (q(0) * 0.5 - q(1) * (3.0_f64.sqrt() / 6.0)) * model.get("L");
    // Three digits are given.
    near("(p - p_H)/y²", form.p2 / (2.0 * tip.norm()).powi(2), 15.6, 0.051);
}

#[test]
fn the_mass_at_the_straight_state_is_symmetric_positive_definite() {
    for load in [Load::Uniform, Load::Distal] {
        let model = Flagellum::new(FUNCTIONS, load, Law::Printed);
        let (u, n) = (model.straight(), model.problem.dim());
        let (_, mass) = matrices(&*model.problem, At { u: &u, v: &u, p: &model.p });
        for i in 0..n {
            for j in 0..i {
                near("symmetry", mass[(i, j)], mass[(j, i)], 1e-15 * mass.norm_max());
            }
        }
        let least = mass.self_adjoint_eigenvalues(faer::Side::Lower).expect("eigenvalues")[0];
        assert!(least > 0.0, "{least}");
    }
}

#[test]
fn the_base_carries_the_whole_load_of_the_straight_state() {
    let rest = vec![0.0; 2 * FUNCTIONS];
    let uniform = uniform().with("p", 123.0);
    let distal = Flagellum::new(FUNCTIONS, Load::Distal, Law::Printed).with("p", 123.0);
    let (l, s0) = (distal.get("L"), distal.get("s0"));
    for (model, length) in [(&uniform, l), (&distal, l - s0 * (1.0 - (-l / s0).exp()))] {
        close("T_1", model.observe("base_tension_1", &rest, &rest), 123.0 * length, 1e-13);
        close("T_2", model.observe("base_tension_2", &rest, &rest), -123.0 * length, 1e-13);
    }
}
