//! Orbits of a chain whose Jacobian is banded: the same as with dense algebra, and exact at onset.

mod common;

use common::brusselator::Brusselator;
use common::{close, first_cycle, near};
use hopfline::continuation::{Border, Factored, Point, StepControl, System, Walk};
use hopfline::orbit::{Collocation, Points};

#[test]
fn the_onset_is_the_exact_one() {
    for (points, onset) in [(32, 0.512826224909809), (64, 0.512969999560477)] {
        let hopf = Brusselator::hopf(&Brusselator::chain(points, true));
        close("L", hopf.p[0], onset, 1e-12);
        close("omega", hopf.omega, 2.13950928953347, 1e-12);
    }
}

/// The first cycle, on a mesh, ready to walk.
fn first(points: usize, banded: bool, mesh: (usize, usize, Points)) -> (Collocation, Point) {
    let problem = Brusselator::chain(points, banded);
    let hopf = Brusselator::hopf(&problem);
    first_cycle(problem, &hopf, 0.3, mesh, (1.0, 1.0))
}

#[test]
fn banded_and_dense_factors_solve_alike() {
    for mesh in [(6, 4, Points::Radau), (5, 3, Points::Gauss)] {
        let (banded, Point { x, lambda, .. }) = first(5, true, mesh);
        let (dense, _) = first(5, false, mesh);
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
        let (mut system, start) = first(8, banded, (12, 4, Points::Radau));
        let control = StepControl { step: 0.05, least: 1e-6, most: 0.2 };
        let goal = start.lambda + 0.1;
        let mut walk = Walk::new(&mut system, start, control, (0.0, goal));
        let last = loop {
            let step = walk.step().expect("a step");
            if step.stop.is_some() {
                break step;
            }
        };
        let found = last.factors.multipliers(None).expect("multipliers");
        // As wrong as the orbit on so few intervals.
        assert!(found.trivial_error < 1e-5, "{:.1e}", found.trivial_error);
        ends.push((walk.system.orbit(&last.to.x).period(), found.values[0].re));
    }
    close("period", ends[0].0, ends[1].0, 1e-10);
    near("multiplier", ends[0].1, ends[1].1, 1e-8);
}
