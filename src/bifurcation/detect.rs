//! Folds and branch points between neighbours of a branch of equilibria.

use super::{BranchError, BranchPoint, Equilibria, Fold, Mark, Sample, Scales, Tangent};
use crate::continuation::{Counts, Failure, Point, at_fraction, crossing, inner};

/// Folds: the tangent's parameter component changes sign. They are solved for on their defining system. Where it is exactly
/// zero a branch starts at a pitchfork, which is no fold of its arms.
pub fn folds(system: &Equilibria, samples: &mut Vec<Sample>, counts: &mut Counts) -> Result<(), Failure> {
    let index = system.coordinate.index;
    let mut i = 1;
    while i < samples.len() {
        let (a, b) = (&samples[i - 1].point, &samples[i].point);
        if a.tangent_lambda * b.tangent_lambda < 0.0 {
            let mut point = crossing(system, (a, b), &|point: &Point| point.tangent_lambda, counts)?;
            let near = (&point.x[..], &system.parameters(point.lambda)[..]);
            let place = (index, scales(system, point.lambda).parameter);
            let fold = Fold::locate(&*system.problem, near, place, &point.tangent).ok().map(Box::new);
            if let Some(fold) = &fold {
                point.x.copy_from_slice(&fold.u);
                point.lambda = system.coordinate.of(fold.p[index]);
            }
            samples.insert(i, Sample::new(point, Some(Mark::Fold(fold))));
            i += 1;
        }
        i += 1;
    }
    Ok(())
}

/// The scales in which a system's branch points are looked for.
pub fn scales(system: &Equilibria, lambda: f64) -> Scales {
    let state = system.scale_state * (system.problem.dim() as f64).sqrt();
    Scales { state, parameter: system.coordinate.width * system.coordinate.rate(lambda) }
}

/// Branch points: the determinant of the Jacobian bordered by the tangent changes sign (`signs`, one for each sample, None
/// where it is not known). An even number of simple branch points within one step, or one where an even number of curves
/// is added, leaves it as it is. Returns where the sign changes without a branch point, in a sentence each.
pub fn branch_points(
    system: &Equilibria,
    samples: &mut Vec<Sample>,
    signs: &[Option<f64>],
    counts: &mut Counts,
) -> Vec<String> {
    let mut doubts = Vec::new();
    for i in (1..samples.len()).rev() {
        let (Some(before), Some(after)) = (signs[i - 1], signs[i]) else { continue };
        if before == after {
            continue;
        }
        let ends = (&samples[i - 1].point, &samples[i].point);
        match between(system, ends, before, counts) {
            Ok(sample) => samples.insert(i, sample),
            Err(reason) => doubts.push(format!(
                "the determinant changes its sign between {:?} and {:?}, but there is no branch point: {reason}",
                system.coordinate.value(ends.0.lambda),
                system.coordinate.value(ends.1.lambda)
            )),
        }
    }
    doubts
}

/// Bisections by the determinant's sign until Newton's method stays where it should.
const MOST_BISECTIONS: usize = 25;
/// A branch point lies between its neighbours along the chord, but for this part of it, and not further beside it.
const SLACK: f64 = 0.02;
const BESIDE: f64 = 0.5;

fn between(
    system: &Equilibria,
    (from, to): (&Point, &Point),
    before: f64,
    counts: &mut Counts,
) -> Result<Sample, BranchError> {
    let (mut a, mut b) = (from.clone(), to.clone());
    let mut reason = BranchError::Degenerate;
    for _ in 0..MOST_BISECTIONS {
        match located(system, &a, &b) {
            Ok(found) => return Ok(found),
            Err(failure) => reason = failure,
        }
        // The middle may happen to be the branch point.
        let near = [0.5, 0.45, 0.6];
        let middle = near.iter().find_map(|&part| {
            let middle = at_fraction(system, (&a, &b), part, counts).ok()?;
            Some((middle.factors.sign()?, middle.point))
        });
        let Some((sign, middle)) = middle else { break };
        let other = if sign == before { &mut a } else { &mut b };
        *other = middle;
    }
    Err(reason)
}

/// The branch point between two solutions, by Newton's method from their middle.
fn located(system: &Equilibria, a: &Point, b: &Point) -> Result<Sample, BranchError> {
    let coordinate = system.coordinate;
    let middle = |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| 0.5 * (x + y)).collect() };
    let difference = |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| y - x).collect() };
    let lambda = 0.5 * (a.lambda + b.lambda);
    let (u, p) = (middle(&a.x, &b.x), system.parameters(lambda));
    let chord = (difference(&a.x, &b.x), b.lambda - a.lambda);
    let tangent = Tangent { u: chord.0.clone(), p: chord.1 * coordinate.rate(lambda) };
    let scales = scales(system, lambda);
    let found = BranchPoint::locate(&*system.problem, (&u, &p), (coordinate.index, scales), &tangent)?;
    let lambda = coordinate.of(found.p[coordinate.index]);
    let moved = (difference(&a.x, &found.u), lambda - a.lambda);
    let chord = (&chord.0[..], chord.1);
    let length = inner(system, chord, chord);
    let part = inner(system, (&moved.0, moved.1), chord) / length;
    let beside: Vec<f64> = moved.0.iter().zip(chord.0).map(|(m, c)| m - part * c).collect();
    let beside = (&beside[..], moved.1 - part * chord.1);
    let inside = (-SLACK..=1.0 + SLACK).contains(&part) && inner(system, beside, beside) <= BESIDE.powi(2) * length;
    if !inside {
        return Err(Failure::Turned.into());
    }
    let point = leaving(system, &found.u, lambda, &found.along);
    Ok(Sample::new(point, Some(Mark::Branch(Box::new(found)))))
}

/// A point with a tangent of length one in the system's metric.
pub fn leaving(system: &Equilibria, u: &[f64], lambda: f64, tangent: &Tangent) -> Point {
    let tangent_lambda = tangent.p / system.coordinate.rate(lambda);
    let along = (&tangent.u[..], tangent_lambda);
    let length = inner(system, along, along).sqrt();
    let tangent = tangent.u.iter().map(|t| t / length).collect();
    Point { x: u.to_vec(), lambda, tangent, tangent_lambda: tangent_lambda / length }
}
