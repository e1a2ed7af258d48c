//! Where a branch of equilibria starts: near the model's start, or at a stored point of another branch.

use crate::bifurcation::{Coordinate, Equilibria, Tangent, leaving};
use crate::branch::{Kind, SpecialPoint};
use crate::continuation::{Border, Counts, Failure, Point, System, correct, inner};
use crate::linalg::{Singular, any};
use crate::problem::Problem;
use crate::run::start::{StartError, coordinate, equilibrium};
use crate::run::study::Prepared;
use crate::scene;
use thiserror::Error;

#[derive(Debug, Error)]
pub enum BeginError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error(transparent)]
    Place(#[from] StartError),
    #[error("{0} is not stored with its state and tangent")]
    Incomplete(String),
    #[error("the branch through {0} has no single direction in {1}: {2}")]
    NoTangent(String, String, Failure),
}

/// Where a branch comes from.
#[derive(Clone, Copy)]
pub enum Origin<'a> {
    /// The state that the task gives, or the model's start.
    Model,
    /// Near a state at a value of the free parameter.
    State(&'a [f64], f64),
    /// A stored point.
    Point(&'a SpecialPoint),
}

/// The system and its first point, with the sign of the bordered determinant there where it is known.
pub fn begin(
    prepared: &Prepared,
    task: &scene::Equilibria,
    origin: Origin,
    counts: &mut Counts,
) -> Result<(Equilibria, (Point, Option<f64>)), BeginError> {
    let begin = task.start.unwrap_or(task.along.range.from);
    match (origin, &task.guess) {
        (Origin::Point(from), _) => stored(prepared, task, from, counts),
        (Origin::State(u, free), _) => fresh(prepared, task, (Some(u.to_vec()), free), counts),
        (Origin::Model, Some(guess)) => {
            let (u, free) = guessed(prepared, guess, begin);
            fresh(prepared, task, (Some(u), free), counts)
        }
        (Origin::Model, None) => fresh(prepared, task, (None, begin), counts),
    }
}

/// The state that a scene describes: the model's start but for what is given; and the free parameter there.
pub fn guessed(prepared: &Prepared, guess: &scene::Guess, free: f64) -> (Vec<f64>, f64) {
    let free = guess.free(&prepared.free_name).unwrap_or(free);
    let mut p = prepared.p.clone();
    p[prepared.free] = free;
    (given(prepared, guess, &p), free)
}

/// The model's start at p but for the unknowns that are given.
pub fn given(prepared: &Prepared, guess: &scene::Guess, p: &[f64]) -> Vec<f64> {
    let mut u = prepared.problem.start(p);
    let names = prepared.problem.unknowns();
    for (name, value, _) in &guess.values {
        if let Some(i) = names.iter().position(|known| known == name) {
            u[i] = *value;
        }
    }
    u
}

/// From a state at a value of the free parameter.
fn fresh(
    prepared: &Prepared,
    task: &scene::Equilibria,
    (state, begin): (Option<Vec<f64>>, f64),
    counts: &mut Counts,
) -> Result<(Equilibria, (Point, Option<f64>)), BeginError> {
    let along = &task.along;
    let logarithmic = along.logarithmic.contains(&along.free);
    let mut coordinate = Coordinate { index: prepared.free, logarithmic, width: 1.0 };
    coordinate.width = coordinate.of(along.range.to) - coordinate.of(along.range.from);
    let mut system = system(prepared, task, prepared.p.clone(), coordinate);
    let begin = coordinate.of(begin);
    let u = state.unwrap_or_else(|| prepared.problem.start(&system.parameters(begin)));
    system.scale_state = scale(&u);
    let border = Border { row: vec![0.0; u.len()], lambda: 1.0 };
    let first = correct(&system, (u, begin), &border, counts)?;
    Ok((system, (first.point, first.factors.sign())))
}

/// From a stored point: the other branch where it is a branch point in the same parameter, and else the branch through it.
fn stored(
    prepared: &Prepared,
    task: &scene::Equilibria,
    from: &SpecialPoint,
    counts: &mut Counts,
) -> Result<(Equilibria, (Point, Option<f64>)), BeginError> {
    let incomplete = || BeginError::Incomplete(from.label.clone());
    let (u, p) = equilibrium(prepared, from).ok_or_else(incomplete)?;
    let n = prepared.problem.dim();
    if u.len() != n {
        return Err(incomplete());
    }
    let coordinate = coordinate(prepared, &task.along, (prepared.free, Some(&task.along.range)), &p)?;
    let lambda = coordinate.of(p[prepared.free]);
    let mut system = system(prepared, task, p, coordinate);
    // A state that is zero but for rounding says nothing of the scale.
    let known = from.arrays.get("scale").and_then(|array| array.data.first()).copied();
    system.scale_state = known.map_or(scale(&u), |known| known.max(rms(&u)));
    if from.kind == Kind::BP && from.arrays.get("free").is_some_and(|free| free.data == [prepared.free as f64]) {
        let other =
            &from.arrays.get("other_tangent").filter(|array| array.data.len() == n + 1).ok_or_else(incomplete)?;
        let tangent = Tangent { u: other.data[..n].to_vec(), p: other.data[n] };
        let point = leaving(&system, &u, lambda, &tangent);
        return Ok((system, (point, None)));
    }
    let point = through(&system, u, lambda, counts)
        .map_err(|failure| BeginError::NoTangent(from.label.clone(), prepared.free_name.clone(), failure))?;
    Ok((system, point))
}

/// The solution with its tangent, found by a border in no special direction.
fn through(
    system: &Equilibria,
    u: Vec<f64>,
    lambda: f64,
    counts: &mut Counts,
) -> Result<(Point, Option<f64>), Failure> {
    let n = u.len();
    let any = any(n);
    let length = inner(system, (&any, 0.0), (&any, 0.0)).sqrt();
    let row = system.dual(&any).iter().map(|x| x / length).collect();
    let mut border = Border { row, lambda: 1.0 / system.coordinate.width };
    for _ in 0..2 {
        let mut t = vec![0.0; n + 1];
        t[n] = 1.0;
        counts.factorisations += 1;
        system.factor(&u, lambda, &border)?.solve(&mut t);
        let along = (&t[..n], t[n]);
        let length = inner(system, along, along).sqrt();
        if !length.is_finite() {
            return Err(Singular.into());
        }
        let unit: Vec<f64> = t.iter().map(|t| t / length).collect();
        border = Border { row: system.dual(&unit[..n]), lambda: system.dual_lambda() * unit[n] };
    }
    let corrected = correct(system, (u, lambda), &border, counts)?;
    let (mut point, mut sign) = (corrected.point, corrected.factors.sign());
    if point.tangent_lambda < 0.0 {
        crate::bifurcation::reverse(&mut point);
        sign = sign.map(|sign| -sign);
    }
    Ok((point, sign))
}

fn system(prepared: &Prepared, task: &scene::Equilibria, p: Vec<f64>, coordinate: Coordinate) -> Equilibria {
    let (problem, all_eigenvalues) = (prepared.problem.clone(), task.all_eigenvalues);
    Equilibria { problem, p, coordinate, scale_state: 1.0, all_eigenvalues }
}

/// The root mean square of a state, or one where it is zero up to rounding: a branch point at zero is stored as 1e-18.
fn scale(u: &[f64]) -> f64 {
    let rms = rms(u);
    if rms > f64::EPSILON { rms } else { 1.0 }
}

fn rms(u: &[f64]) -> f64 {
    (u.iter().map(|u| u * u).sum::<f64>() / u.len() as f64).sqrt()
}
