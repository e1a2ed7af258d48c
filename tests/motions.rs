//! Motions in time against exact solutions, published values and each other's methods.

use hopfline::continuation::Counts;
use hopfline::problem::{Automatic, Formula, Parameter, Scalar};
use hopfline::simulate::{Attractor, Control, Course, Cycle, Method, Motion, Search, SimulateError, integrate, settle};
use std::ops::ControlFlow;

const METHODS: [Method; 2] = [Method::Bdf, Method::Sdirk];

fn control(method: Method, tolerance: f64) -> Control {
    Control { method, tolerance, absolute: tolerance }
}

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "{what}: {found} instead of {expected}");
}

fn end<F: Formula + Send + Sync>(
    formula: F,
    start: &[f64],
    to: f64,
    control: Control,
) -> Result<Motion, SimulateError> {
    let mut counts = Counts::default();
    let course = Course::steady(0.0, to, &[]);
    integrate(&Automatic(formula), start, &course, &control, &mut counts, &mut |_| ControlFlow::Continue(()))
}

macro_rules! formula {
    ($name:ident, $n:expr, |$u:ident, $v:ident, $g:ident| $body:block) => {
        struct $name;
        impl Formula for $name {
            fn dim(&self) -> usize {
                $n
            }
            fn parameters(&self) -> &[Parameter] {
                &[]
            }
            fn residual<S: Scalar>(&self, $u: &[S], $v: &[S], _p: &[S], $g: &mut [S]) $body
        }
    };
}

// The van der Pol oscillator at mu = 1, lengths in units of 1e-6 and time in units of 1e-3.
struct Pol {
    length: f64,
    time: f64,
}

impl Formula for Pol {
    fn dim(&self) -> usize {
        2
    }
    fn parameters(&self) -> &[Parameter] {
        &[]
    }
    fn residual<S: Scalar>(&self, u: &[S], v: &[S], _p: &[S], g: &mut [S]) {
        let (x, y) = (u[0] / self.length, u[1] / self.length);
        g[0] = v[0] * (self.time / self.length) - y;
        g[1] = v[1] * (self.time / self.length) - (-(x * x - 1.0) * y - x);
    }
}

fn pol(length: f64, time: f64, method: Method, tolerance: f64) -> Box<Cycle> {
    let problem = Automatic(Pol { length, time });
    let course = Course::steady(0.0, 200.0 * time, &[]);
    let search = Search { observables: &[], recognise: true, stop: true, errors: true };
    let mut counts = Counts::default();
    let nothing = &mut |_: &hopfline::simulate::Step| ControlFlow::Continue(());
    let control = control(method, tolerance);
    let found = settle(&problem, &[0.1 * length, 0.0], (&course, &control), &search, &mut counts, nothing);
    match found.expect("a motion").attractor {
        Attractor::Cycle(cycle) => cycle,
        other => panic!("{other:?}"),
    }
}

#[test]
fn van_der_pol_settles_on_its_cycle_with_both_methods() {
    const PERIOD: f64 = 6.663_286_859_323_13;
    for (method, tolerance) in [(Method::Bdf, 1e-6), (Method::Bdf, 1e-9), (Method::Sdirk, 1e-7)] {
        let cycle = pol(1.0, 1.0, method, tolerance);
        let error = (cycle.period - PERIOD).abs();
        assert!(error <= 100.0 * tolerance * PERIOD, "{method:?} {tolerance}: {error}");
        assert!(error <= 2.0 * cycle.errors[0], "{method:?} {tolerance}: {error} is more than {}", cycle.errors[0]);
        assert_eq!(cycle.crossings, 1);
    }
}

#[test]
fn units_do_not_matter() {
    let plain = pol(1.0, 1.0, Method::Bdf, 1e-6);
    let scaled = pol(1e-9, 1e9, Method::Bdf, 1e-6);
    // Rounding moves the steps, and with them errors of the size of the tolerance, by its own size only.
    close("period", scaled.period / 1e9, plain.period, 1e-6);
}

formula!(Pendulum, 5, |u, v, g| {
    // A pendulum in Cartesian coordinates; its tension from the twice differentiated constraint: index 1.
    let [x, y, vx, vy, tension] = [u[0], u[1], u[2], u[3], u[4]];
    g[0] = v[0] - vx;
    g[1] = v[1] - vy;
    g[2] = v[2] + tension * x;
    g[3] = v[3] + tension * y + 1.0;
    g[4] = vx * vx + vy * vy - tension * (x * x + y * y) - y;
});

#[test]
fn a_differential_algebraic_start_is_made_consistent() {
    for method in METHODS {
        // Released at rest at 60 degrees; the tension's start is wrong. At rest again after a half period.
        let (sine, cosine) = (0.75_f64.sqrt(), 0.5);
        // 4 K(sin 30 deg) with g = l = 1 (Abramowitz and Stegun 17.3.1).
        const PERIOD: f64 = 4.0 * 1.685_750_354_812_596;
        let motion =
            end(Pendulum, &[sine, -cosine, 0.0, 0.0, 7.0], 0.5 * PERIOD, control(method, 1e-9)).expect("a motion");
        assert!((motion.u[0] + sine).abs() < 1e-6 && (motion.u[1] + cosine).abs() < 1e-6, "{motion:?}");
        assert!((motion.u[4] - cosine).abs() < 1e-6, "{motion:?}");
    }
}

formula!(Mass, 2, |u, v, g| {
    // (1 + x^2) x' = -x, y' + x x' = 0: x^2 / 2 + ln x + t is constant, and so is y + x^2 / 2.
    g[0] = (u[0] * u[0] + 1.0) * v[0] + u[0];
    g[1] = v[1] + u[0] * v[0];
});

#[test]
fn a_mass_may_depend_on_the_solution() {
    for method in METHODS {
        let motion = end(Mass, &[1.0, 0.0], 2.0, control(method, 1e-9)).expect("a motion");
        let [x, y] = motion.u[..] else { panic!("{motion:?}") };
        assert!((0.5 * x * x + x.ln() + 2.0 - 0.5).abs() < 1e-7, "{motion:?}");
        assert!((y + 0.5 * x * x - 0.5).abs() < 1e-7, "{motion:?}");
    }
}

formula!(Root, 1, |u, v, g| {
    g[0] = v[0] + u[0].sqrt() + 0.1;
});
formula!(Blow, 1, |u, v, g| {
    g[0] = v[0] - u[0] * u[0];
});
formula!(NoStart, 2, |u, v, g| {
    g[0] = v[0] - u[1];
    g[1] = u[1] * u[1] + 1.0;
});
formula!(HighIndex, 2, |u, v, g| {
    g[0] = v[0] - u[1];
    g[1] = u[0] - 1.0;
});

#[test]
fn what_cannot_be_followed_is_named() {
    for method in METHODS {
        let control = control(method, 1e-6);
        // x = 1 falls to zero at 2 - 0.2 ln 11.
        let at = 2.0 - 0.2 * 11.0_f64.ln();
        match end(Root, &[1.0], 3.0, control) {
            Err(SimulateError::NotFinite { time }) => close("time", time, at, 1e-3),
            other => panic!("{other:?}"),
        }
        // x = 1 / (1 - t).
        match end(Blow, &[1.0], 2.0, control) {
            Err(SimulateError::Step { time, .. } | SimulateError::NotFinite { time }) => close("time", time, 1.0, 1e-3),
            other => panic!("{other:?}"),
        }
        assert!(matches!(
            end(NoStart, &[0.0, 1.0], 1.0, control),
            Err(SimulateError::Inconsistent { .. } | SimulateError::Index { .. })
        ));
        assert!(matches!(end(HighIndex, &[1.0, 0.0], 1.0, control), Err(SimulateError::Index { .. })));
        assert_eq!(end(Root, &[f64::NAN], 1.0, control).map(drop), Err(SimulateError::Start));
    }
}
