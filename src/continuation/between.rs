//! Solutions between two accepted points of one step.

use super::chord::{Plane, settle};
use super::corrector::{SETTLED, refactor};
use super::{Border, Corrected, Counts, Failure, Point, System, correct};

/// The cubic through both points with their tangents, at theta in [0, 1]; a step's chord is close to its arclength.
fn hermite(a: &Point, b: &Point, length: f64, theta: f64) -> (Vec<f64>, f64) {
    let (t2, t3) = (theta * theta, theta * theta * theta);
    let (h00, h10, h01, h11) = (2.0 * t3 - 3.0 * t2 + 1.0, t3 - 2.0 * t2 + theta, 3.0 * t2 - 2.0 * t3, t3 - t2);
    let mix = |x: f64, t: f64, y: f64, u: f64| h00 * x + h10 * length * t + h01 * y + h11 * length * u;
    let x = (0..a.x.len()).map(|i| mix(a.x[i], a.tangent[i], b.x[i], b.tangent[i])).collect();
    (x, mix(a.lambda, a.tangent_lambda, b.lambda, b.tangent_lambda))
}

fn gap<S: System>(system: &S, a: &Point, b: &Point) -> (Vec<f64>, f64, f64) {
    let d: Vec<f64> = b.x.iter().zip(&a.x).map(|(b, a)| b - a).collect();
    let d_lambda = b.lambda - a.lambda;
    let length = super::inner(system, (&d, d_lambda), (&d, d_lambda)).sqrt();
    (d, d_lambda, length)
}

/// The solution on the hyperplane across the chord from a to b, at a fraction theta of it.
pub fn at_fraction<S: System>(
    system: &S,
    (a, b): (&Point, &Point),
    theta: f64,
    counts: &mut Counts,
) -> Result<Corrected<S::Factors>, Failure> {
    let (d, d_lambda, length) = gap(system, a, b);
    let border = Border {
        row: system.dual(&d).iter().map(|r| r / length).collect(),
        lambda: system.dual_lambda() * d_lambda / length,
    };
    correct(system, hermite(a, b, length, theta), &border, counts)
}

/// The solution with a given lambda between those of a and b; `held` are factors at b, if they are at hand.
pub fn at_lambda<S: System>(
    system: &S,
    (a, b): (&Point, &Point),
    lambda: f64,
    held: Option<&S::Factors>,
    counts: &mut Counts,
) -> Result<Corrected<S::Factors>, Failure> {
    let (_, d_lambda, length) = gap(system, a, b);
    // Bisection on the cubic: it only has to give a start.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let (_, here) = hermite(a, b, length, middle);
        if (here < lambda) == (d_lambda > 0.0) { low = middle } else { high = middle }
    }
    let (x, _) = hermite(a, b, length, low);
    let border = Border { row: vec![0.0; x.len()], lambda: d_lambda.signum() };
    let plane = Some(Plane { border: &border, along: b });
    let mut corrected = match held.map(|held| settle(system, (x.clone(), lambda), (held, plane), SETTLED, counts)) {
        Some(Ok(settled)) => refactor(system, settled, &border, counts)?,
        _ => correct(system, (x, lambda), &border, counts)?,
    };
    // Not even off by rounding.
    corrected.point.lambda = lambda;
    Ok(corrected)
}

/// The solution between a and b where a function of it vanishes: regula falsi (Illinois) along the chord, to the
/// rounding of the function.
pub fn crossing<S: System>(
    system: &S,
    (a, b): (&Point, &Point),
    value: &dyn Fn(&Point) -> f64,
    counts: &mut Counts,
) -> Result<Point, Failure> {
    let (mut low, mut high) = ((0.0_f64, value(a)), (1.0_f64, value(b)));
    let (mut best, mut least) = if low.1.abs() < high.1.abs() { (a.clone(), low.1) } else { (b.clone(), high.1) };
    for _ in 0..60 {
        let theta = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        let point = at_fraction(system, (a, b), theta, counts)?.point;
        let here = value(&point);
        let narrow = (high.0 - low.0).abs() < 1e-12 && here.abs() >= least.abs();
        if here.abs() < least.abs() {
            (least, best) = (here, point);
        }
        if here == 0.0 || narrow || (high.0 - low.0).abs() < 1e-15 {
            break;
        }
        if here * high.1 < 0.0 {
            low = high;
        } else {
            low.1 *= 0.5;
        }
        high = (theta, here);
    }
    Ok(best)
}
