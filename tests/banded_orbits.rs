//! Orbits of a chain whose Jacobian is banded: the same as with dense algebra, and exact at onset.

mod common;

use common::brusselator::Brusselator;
use common::{close, near};
use hopfline::bifurcation::HopfNormalForm;
use hopfline::continuation::{Border, Counts, Factored, StepControl, System, Walk, correct};
use hopfline::orbit::{Collocation, Frame, Points, from_hopf};
use hopfline::problem::Reflection;
use std::f64::consts::TAU;

#[test]
fn the_onset_is_the_exact_one() {
    for (points, onset) in [(32, 0.512826224909809), (64, 0.512969999560477)] {
        let hopf = Brusselator::hopf(&Brusselator::new(points, true));
        close("L", hopf.p[0], onset, 1e-12);
        close("omega", hopf.omega, 2.13950928953347, 1e-12);
    }
}

/// The first cycle, on a mesh, ready to walk.
fn first(points: usize, banded: bool, mesh: (usize, usize, Points)) -> (Collocation, Vec<f64>, f64) {
    let problem = Brusselator::new(points, banded);
    let hopf = Brusselator::hopf(&problem);
    let form = HopfNormalForm::new(&*problem, &hopf).expect("a normal form");
    let n = problem.dim();
    let symmetry = Reflection::identity(n);
    let (orbit, lambda) = from_hopf((&hopf, &form), 0, 0.3, (&symmetry, 1), mesh);
    let frame = Frame {
        problem,
        p: vec![0.0],
        free: 0,
        symmetry,
        parts: 1,
        scale_state: 1.0,
        scale_part: TAU / hopf.omega,
        scale_lambda: 1.0,
    };
    let system = Collocation::new(frame, &orbit);
    let x = Collocation::unknowns(&orbit);
    (system, x, lambda)
}

#[test]
fn banded_and_dense_factors_solve_alike() {
    for mesh in [(6, 4, Points::Radau), (5, 3, Points::Gauss)] {
        let (banded, x, lambda) = first(5, true, mesh);
        let (dense, ..) = first(5, false, mesh);
        let n = x.len();
        let border = Border { row: (0..n).map(|i| (0.7 * i as f64).sin()).collect(), lambda: 0.3 };
        let mut right: Vec<f64> = (0..=n).map(|i| (1.3 * i as f64 + 0.2).sin()).collect();
        let mut other = right.clone();
        banded.factor(&x, lambda, &border).expect("factors").solve(&mut right);
        dense.factor(&x, lambda, &border).expect("factors").solve(&mut other);
        let size = other.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        for (a, b) in right.iter().zip(&other) {
            near("solution", *a, *b, 1e-11 * size);
        }
    }
}

#[test]
fn a_branch_of_cycles_is_the_same_with_both() {
    let mut ends = Vec::new();
    for banded in [true, false] {
        let (mut system, x, lambda) = first(8, banded, (12, 4, Points::Radau));
        let border = Border { row: vec![0.0; x.len()], lambda: 1.0 };
        let counts = &mut Counts::default();
        let start = correct(&system, (x, lambda), &border, counts).expect("a cycle").point;
        let control = StepControl { step: 0.05, least: 1e-6, most: 0.2 };
        let goal = lambda + 0.1;
        let mut walk = Walk::new(&mut system, start, control, (0.0, goal));
        let last = loop {
            let step = walk.step().expect("a step");
            if step.stop.is_some() {
                break step;
            }
        };
        let found = last.factors.multipliers().expect("multipliers");
        // As wrong as the orbit on so few intervals.
        assert!(found.trivial_error < 1e-5, "{:.1e}", found.trivial_error);
        ends.push((walk.system.orbit(&last.to.x).period(), found.values[0].re));
    }
    close("period", ends[0].0, ends[1].0, 1e-10);
    near("multiplier", ends[0].1, ends[1].1, 1e-8);
}
