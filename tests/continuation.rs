//! The walk along curves that are known in closed form.

mod common;

use common::near;
use faer::Mat;
use hopfline::continuation::{
    Border, Counts, Failure, Point, Step, StepControl, Stop, System, Walk, at_fraction, at_lambda, correct,
};
use hopfline::linalg::{BorderedMatrix, Matrix, Singular};

/// One equation `f(x, lambda) = 0` with its derivatives (f, f_x, f_lambda).
struct Curve<F>(F);

impl<F: Fn(f64, f64) -> [f64; 3]> System for Curve<F> {
    type Factors = BorderedMatrix;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        r[0] = (self.0)(x[0], lambda)[0];
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<BorderedMatrix, Singular> {
        let [_, by_x, by_lambda] = (self.0)(x[0], lambda);
        let by_x = Matrix::Dense(Mat::from_fn(1, 1, |_, _| by_x));
        BorderedMatrix::new(&by_x, &[&[by_lambda]], &[&border.row], &[&[border.lambda]])
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        t.to_vec()
    }

    fn dual_lambda(&self) -> f64 {
        1.0
    }
}

fn circle(x: f64, lambda: f64) -> [f64; 3] {
    [x * x + lambda * lambda - 1.0, 2.0 * x, 2.0 * lambda]
}

/// The point near (x, lambda) with this lambda, its tangent toward larger lambda.
fn start<S: System>(system: &S, x: f64, lambda: f64) -> Point {
    let border = Border { row: vec![0.0], lambda: 1.0 };
    correct(system, (vec![x], lambda), &border, &mut Counts::default()).expect("a point of the curve").point
}

fn control(step: f64, most: f64) -> StepControl {
    StepControl { step, least: 1e-8, most }
}

/// All steps until the walk stops, and why.
fn walk<S: System>(walk: &mut Walk<S>, most: usize) -> (Vec<Step<S::Factors>>, Stop) {
    let mut steps = Vec::new();
    while steps.len() < most {
        match walk.step() {
            Ok(mut step) => {
                let stop = step.stop.take();
                steps.push(step);
                if let Some(stop) = stop {
                    return (steps, stop);
                }
            }
            Err(stop) => return (steps, stop),
        }
    }
    (steps, Stop::MaxPoints)
}

#[test]
fn a_closed_curve_passes_both_folds_and_stops_where_it_began() {
    let mut system = Curve(circle);
    let first = start(&system, 1.0, 0.1);
    let (steps, stop) = walk(&mut Walk::new(&mut system, first, control(0.1, 0.3), (-2.0, 2.0)), 1000);
    assert_eq!(stop, Stop::Closed);
    let mut angle = 0.0;
    let mut folds = 0;
    for step in &steps {
        // Newton's tolerance of 1e-11 in a norm in which the circle has radius 1.
        near("radius", step.to.x[0].hypot(step.to.lambda), 1.0, 1e-11);
        near("tangent along", step.to.tangent[0] * step.to.x[0] + step.to.tangent_lambda * step.to.lambda, 0.0, 1e-11);
        near("tangent length", step.to.tangent[0].hypot(step.to.tangent_lambda), 1.0, 1e-14);
        let (a, b) = (&step.from, &step.to);
        angle += (a.x[0] * b.lambda - a.lambda * b.x[0]).asin();
        folds += usize::from(a.tangent_lambda * b.tangent_lambda < 0.0);
    }
    assert_eq!(folds, 2);
    // Once around but for less than the last step, one way all the time.
    near("angle", angle, std::f64::consts::TAU, 0.31);
}

#[test]
fn the_end_of_the_range_is_hit_exactly_from_both_sides() {
    for (range, backward) in [((-1.0, 0.625), false), ((-0.375, 1.0), true)] {
        // x = lambda³ + lambda: no fold.
        let mut system = Curve(|x: f64, l: f64| [l * l * l + l - x, -1.0, 3.0 * l * l + 1.0]);
        let mut first = start(&system, 0.0, 0.0);
        if backward {
            first.tangent[0] = -first.tangent[0];
            first.tangent_lambda = -first.tangent_lambda;
        }
        let mut along = Walk::new(&mut system, first, control(0.1, 0.2), range);
        let (steps, stop) = walk(&mut along, 100);
        assert_eq!(stop, Stop::RangeEnd);
        let end = if backward { range.0 } else { range.1 };
        let to = &steps[steps.len() - 1].to;
        near("lambda", to.lambda, end, 1e-15);
        near("x", to.x[0], end * end * end + end, 1e-11);
        assert!(steps.iter().all(|s| s.to.lambda >= range.0 && s.to.lambda <= range.1), "nothing is beyond the range");
        assert_eq!(along.state.point, *to);
    }
}

#[test]
fn a_fold_beyond_the_range_is_not_seen_and_one_inside_is_passed() {
    // lambda = 1 - x²: fold at (0, 1).
    let parabola = |x: f64, l: f64| [l - 1.0 + x * x, 2.0 * x, 1.0];
    let mut system = Curve(parabola);
    let first = start(&system, 1.0, 0.0);
    let (steps, stop) = walk(&mut Walk::new(&mut system, first.clone(), control(0.05, 0.2), (-0.5, 0.9)), 100);
    assert_eq!(stop, Stop::RangeEnd);
    near("x", steps[steps.len() - 1].to.x[0], 0.1_f64.sqrt(), 1e-11);
    let (steps, stop) = walk(&mut Walk::new(&mut system, first, control(0.05, 0.2), (-0.5, 2.0)), 100);
    assert_eq!(stop, Stop::RangeEnd);
    let to = &steps[steps.len() - 1].to;
    near("lambda", to.lambda, -0.5, 1e-15);
    near("x", to.x[0], -1.5_f64.sqrt(), 1e-11);
}

/// The line x = lambda, on which the first solution at a fixed lambda fails, as beside a fold just beyond it.
struct Hesitant(std::cell::Cell<bool>);

impl System for Hesitant {
    type Factors = BorderedMatrix;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        r[0] = x[0] - lambda;
    }

    fn factor(&self, _: &[f64], _: f64, border: &Border) -> Result<BorderedMatrix, Singular> {
        if border.row == [0.0] && self.0.take() {
            return Err(Singular);
        }
        let one = Matrix::Dense(Mat::from_fn(1, 1, |_, _| 1.0));
        BorderedMatrix::new(&one, &[&[-1.0]], &[&border.row], &[&[border.lambda]])
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        t.to_vec()
    }

    fn dual_lambda(&self) -> f64 {
        1.0
    }
}

#[test]
fn an_end_that_is_not_reached_in_one_step_is_reached_in_shorter_ones() {
    let mut system = Hesitant(std::cell::Cell::new(false));
    let first = start(&system, 0.0, 0.0);
    let mut along = Walk::new(&mut system, first, control(0.1, 0.2), (-1.0, 0.5));
    // One failure at the end, then none.
    along.system.0.set(true);
    let (steps, stop) = walk(&mut along, 100);
    assert_eq!(stop, Stop::RangeEnd);
    near("lambda", steps[steps.len() - 1].to.lambda, 0.5, 1e-15);
}

#[test]
fn a_curve_that_ends_is_followed_to_its_end_and_the_reason_is_said() {
    // x = sqrt(1 - lambda) + lambda: real up to lambda = 1, NaN beyond.
    let mut system = Curve(|x: f64, l: f64| {
        let root = (1.0 - l).sqrt();
        [root + l - x, -1.0, 1.0 - 0.5 / root]
    });
    let first = start(&system, 1.0, 0.0);
    let mut along = Walk::new(&mut system, first, StepControl { step: 0.1, least: 1e-6, most: 0.5 }, (-1.0, 2.0));
    let (steps, stop) = walk(&mut along, 1000);
    let Stop::Stagnation { least, lambda, reason } = stop else { panic!("{stop}") };
    assert_eq!(least, 1e-6);
    assert!(!reason.is_empty());
    // Near the end lambda = 1 - d², x = 1 + d: steps stay possible until d is some multiples of the least step.
    near("the last lambda", lambda, 1.0, 1e-3);
    assert_eq!(lambda, steps[steps.len() - 1].to.lambda);

    // Nothing but NaN beyond lambda = 1/2.
    let mut system = Curve(|x: f64, l: f64| if l < 0.5 { [l - x, -1.0, 1.0] } else { [f64::NAN; 3] });
    let first = start(&system, 0.0, 0.0);
    let mut along = Walk::new(&mut system, first, StepControl { step: 0.1, least: 1e-6, most: 0.5 }, (-1.0, 2.0));
    let (_, stop) = walk(&mut along, 1000);
    let Stop::Stagnation { lambda, reason, .. } = stop else { panic!("{stop}") };
    near("the last lambda", lambda, 0.5, 1e-5);
    let known = [Failure::NotFinite.to_string(), Failure::Singular(Singular).to_string()];
    assert!(known.contains(&reason), "{reason}");
}

/// Steps along an ellipse with half-axes 1 and `flat` (in lambda), by their lengths and the tangent's turn.
fn lengths(flat: f64) -> Vec<(f64, f64)> {
    let mut system = Curve(move |x: f64, l: f64| {
        let l = l / flat;
        [x * x + l * l - 1.0, 2.0 * x, 2.0 * l / flat]
    });
    let first = start(&system, 0.1, flat * 0.99_f64.sqrt());
    let (steps, stop) = walk(&mut Walk::new(&mut system, first, control(0.02, 0.5), (-2.0, 2.0)), 2000);
    assert_eq!(stop, Stop::Closed);
    let along = |s: &Step<BorderedMatrix>| {
        let (a, b) = (&s.from, &s.to);
        let turn = (a.tangent[0] * b.tangent[0] + a.tangent_lambda * b.tangent_lambda).clamp(-1.0, 1.0).acos();
        ((b.x[0] - a.x[0]).hypot(b.lambda - a.lambda), turn)
    };
    steps.iter().map(along).collect()
}

#[test]
fn steps_are_short_in_bends_and_long_on_straights() {
    let steps = lengths(0.05);
    let longest = steps.iter().map(|s| s.0).fold(0.0, f64::max);
    let shortest = steps.iter().skip(1).map(|s| s.0).fold(f64::INFINITY, f64::min);
    // At the sharp ends the radius of curvature is 0.05² = 0.0025; a turn of 0.3 there is a step of 0.00075.
    assert!(shortest < 0.005 && longest > 0.1, "{shortest} {longest}");
    // A turn by more than a right angle is never accepted; the mean turn is what the control aims at or less.
    let turns: Vec<f64> = steps.iter().map(|s| s.1).collect();
    let mean = turns.iter().sum::<f64>() / turns.len() as f64;
    assert!(turns.iter().all(|t| *t < 1.06) && mean < 0.3, "{mean}");
}

#[test]
fn steps_grow_on_a_straight_line_to_the_most_allowed() {
    let mut system = Curve(|x: f64, l: f64| [l - x, -1.0, 1.0]);
    let first = start(&system, 0.0, 0.0);
    let mut along = Walk::new(&mut system, first, control(0.01, 0.25), (-1.0, 3.0));
    let (steps, stop) = walk(&mut along, 100);
    assert_eq!(stop, Stop::RangeEnd);
    let lengths: Vec<f64> =
        steps.iter().map(|s| (s.to.x[0] - s.from.x[0]).hypot(s.to.lambda - s.from.lambda)).collect();
    let full = lengths.len() - 1;
    assert!(lengths[..full].windows(2).all(|w| w[1] >= w[0] * (1.0 - 1e-12)), "{lengths:?}");
    assert!(lengths[..full].windows(2).all(|w| w[1] <= 1.6 * w[0] * (1.0 + 1e-12)), "{lengths:?}");
    near("the longest", lengths[full - 1], 0.25, 1e-12);
}

#[test]
fn an_interrupted_walk_goes_on_bit_by_bit_as_if_it_had_not_stopped() {
    let collect = |pause: usize| -> Vec<Point> {
        let mut system = Curve(circle);
        let first = start(&system, 1.0, 0.1);
        let mut along = Walk::new(&mut system, first, control(0.07, 0.2), (-2.0, 2.0));
        let (mut steps, mut stop) = walk(&mut along, pause);
        if stop == Stop::MaxPoints {
            let state = along.state.clone();
            let (rest, end) = walk(&mut Walk::resume(&mut Curve(circle), state, (-2.0, 2.0)), 1000);
            steps.extend(rest);
            stop = end;
        }
        assert_eq!(stop, Stop::Closed);
        steps.into_iter().map(|s| s.to).collect()
    };
    let whole = collect(1000);
    for pause in [1, 2, 7] {
        assert_eq!(collect(pause), whole);
    }
}

#[test]
fn points_between_two_others_lie_on_the_curve_where_they_were_asked_for() {
    let system = Curve(circle);
    let (a, b) = (start(&system, 1.0, 0.0), start(&system, 0.8, 0.6));
    let counts = &mut Counts::default();
    let there = at_lambda(&system, (&a, &b), 0.28, None, counts).expect("a point").point;
    near("lambda", there.lambda, 0.28, 1e-15);
    near("x", there.x[0], 0.96, 1e-11);
    for theta in [0.0, 0.25, 0.5, 1.0] {
        let there = at_fraction(&system, (&a, &b), theta, counts).expect("a point").point;
        near("on the circle", there.x[0].hypot(there.lambda), 1.0, 1e-11);
        // The hyperplane is across the chord, through the cubic's point; the cubic between unit tangents, as long as the
        // chord, is symmetric: its middle projects onto the chord's middle.
        if theta != 0.25 {
            let along = ((there.x[0] - 1.0) * -0.2 + there.lambda * 0.6) / 0.4;
            near("along the chord", along, theta, 1e-11);
        }
    }
}

/// The first point of a step that the equations are evaluated at is the predicted one: by one, two, three points with their
/// tangents.
#[test]
fn predictions_gain_two_orders_with_each_point() {
    let misses = |h: f64| -> Vec<f64> {
        let asked = std::cell::RefCell::new(Vec::new());
        let mut system = Curve(|x: f64, l: f64| {
            asked.borrow_mut().push(x.hypot(l) - 1.0);
            circle(x, l)
        });
        let first = start(&system, 1.0, 0.0);
        let mut along = Walk::new(&mut system, first, control(h, h), (-2.0, 2.0));
        (0..3)
            .map(|_| {
                asked.borrow_mut().clear();
                along.step().expect("a step");
                asked.borrow()[0].abs()
            })
            .collect()
    };
    for (k, (coarse, fine)) in misses(0.1).iter().zip(misses(0.05)).enumerate() {
        near("the order", (coarse / fine).log2(), 2.0 * (k + 1) as f64, 0.2);
    }
}
