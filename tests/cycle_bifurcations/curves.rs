//! Curves of critical cycles in two parameters: exact curves with exact points of codimension two.

use super::common::near;
use super::coordinate;
use super::exact::{C, Form, M, OMEGA, exact};
use hopfline::bifurcation::Locus;
use hopfline::continuation::{Counts, Point, StepControl, Walk};
use hopfline::orbit::Collocation;
use hopfline::orbit::bifurcations::{Critical, CycleCurve, CycleSegment, CycleTest};
use std::f64::consts::TAU;

/// Points of codimension two on a curve in (mu, the second parameter), as (test, mu, second).
fn special(kind: Critical, second: usize, upward: bool, (low, high): (f64, f64)) -> Vec<(CycleTest, f64, f64)> {
    let (frame, orbit) = exact(kind, Form::Mass, 0.0);
    let system = Collocation::new(frame, &orbit);
    let coordinates = (coordinate(0, 1.0), coordinate(second, 1.0));
    let mut counts = Counts::default();
    let critical = (kind, (TAU * OMEGA).cos());
    let p = system.frame.p.clone();
    let (mut curve, mut point) =
        CycleCurve::start(&system, (&orbit, &p), critical, coordinates, &mut counts).expect("a curve");
    if (point.tangent_lambda > 0.0) != upward {
        hopfline::bifurcation::reverse(&mut point);
    }
    let control = StepControl { step: 0.01, least: 1e-8, most: 0.05 };
    let mut walk = Walk::new(&mut curve, point, control, (low, high));
    let mut found = Vec::new();
    for _ in 0..200 {
        let step = walk.step().unwrap_or_else(|stop| panic!("{kind:?}: {stop}"));
        let segment = CycleSegment { curve: walk.system.clone(), from: step.from, to: step.to };
        for &test in CycleSegment::tests(kind) {
            if let Some(point) = segment.locate(test, &mut counts).expect("a search") {
                let [mu, z]: [f64; 2] = segment.curve.coordinates(&point);
                found.push((test, mu, z));
            }
        }
        // The line mu = 0, but for folds with a linear term.
        let to: &Point = &segment.to;
        if kind != Critical::Fold && second != 5 {
            near("mu", segment.curve.coordinates(to)[0], 0.0, 1e-9);
        }
        if step.stop.is_some() {
            break;
        }
    }
    found
}

#[track_caller]
fn expect(found: &[(CycleTest, f64, f64)], wanted: &[(CycleTest, f64, f64)]) {
    assert_eq!(found.len(), wanted.len(), "{found:?}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert_eq!(found.0, wanted.0);
        near("first", found.1, wanted.1, 1e-8);
        near("second", found.2, wanted.2, 1e-7);
    }
}

#[test]
fn a_generalised_period_doubling_and_a_chenciner_point_are_where_the_coefficient_vanishes() {
    for kind in [Critical::Flip, Critical::Torus] {
        expect(&special(kind, 1, true, (0.0, 1.0)), &[(CycleTest::Degenerate, 0.0, -C / M)]);
    }
}

#[test]
fn strong_resonances_are_where_the_angle_says() {
    // From omega = 0.37 down through 1/3 and 1/4, and up to 1/2.
    let down = special(Critical::Torus, 2, false, (0.2, 0.45));
    expect(&down, &[(CycleTest::Cosine(-0.5), 0.0, 1.0 / 3.0), (CycleTest::Cosine(0.0), 0.0, 0.25)]);
}

#[test]
fn a_cusp_of_cycles_is_passed() {
    let found = special(Critical::Fold, 3, false, (-0.5, 0.3));
    expect(&found, &[(CycleTest::Degenerate, C.powi(3) / 27.0, -C * C / 3.0)]);
}

#[test]
fn a_fold_of_critical_cycles_is_noticed() {
    // w = (1 - sqrt(1 - 4 feed))/2 and mu = -m w: the curve turns at feed = 1/4, where the multiplier of w passes one.
    for kind in [Critical::Flip, Critical::Torus] {
        let found = special(kind, 5, true, (-0.1, 0.3));
        let folds: Vec<_> = found.iter().copied().filter(|(test, ..)| *test == CycleTest::Fold).collect();
        expect(&folds, &[(CycleTest::Fold, -0.5 * M, 0.25)]);
    }
}
