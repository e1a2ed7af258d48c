//! A cycle that a motion has settled on, as branches of cycles store theirs.

use super::{Simulation, TaskError};
use crate::branch::{Array, Kind};
use crate::continuation::Counts;
use crate::orbit::{Points, Scheme};
use crate::problem::Problem;
use crate::simulate::{Control, Course, Cycle, Motion, SimulateError, integrate};
use std::ops::ControlFlow;

/// Fewest and most intervals of the stored cycle's mesh.
const INTERVALS: [usize; 2] = [40, 200];
const DEGREE: usize = 4;
/// Steps of the integrator that an interval takes the place of.
const STEPS: usize = 2;

impl Simulation<'_> {
    /// Stores the cycle as a point: one more period to learn the integrator's steps, which are short where the motion is
    /// fast, and another one sampled at the nodes of a mesh that shares them out.
    pub fn cycle(&mut self, cycle: &Cycle, p: &[f64]) -> Result<(), TaskError> {
        let problem = &*self.prepared.problem;
        let mut counts = self.counts;
        let mut steps = vec![0.0];
        let course = Course::steady(0.0, cycle.period, p);
        integrate(problem, &cycle.at, &course, &self.control, &mut counts, &mut |step| {
            steps.push(step.to.t / cycle.period);
            ControlFlow::Continue(())
        })?;
        let mesh = mesh(&steps);
        let scheme = Scheme::new(Points::Radau, DEGREE);
        let mut places: Vec<f64> = mesh
            .windows(2)
            .flat_map(|w| scheme.nodes[..DEGREE].iter().map(|x| w[0] + x * (w[1] - w[0])).collect::<Vec<f64>>())
            .collect();
        places.push(1.0);
        let mut nodes = sample(problem, cycle, p, &self.control, &places, &mut counts)?;
        self.counts = counts;
        // The cycle closes to the integrator's error; stored ones close exactly.
        if let [first, .., last] = &mut nodes[..] {
            last.u.clone_from(&first.u);
        }
        let n = cycle.at.len();
        let state = Array { shape: vec![nodes.len(), n], data: nodes.iter().flat_map(|node| node.u.clone()).collect() };
        let mut point = self.point(Kind::LC, p, &cycle.at);
        // A motion knows nothing of its neighbours at other parameters.
        let tangent = Array { shape: state.shape.clone(), data: vec![0.0; state.data.len()] };
        point.arrays.extend([
            ("tangent".to_owned(), tangent),
            ("tangent_part_lambda".to_owned(), Array::vector(vec![0.0, 1.0])),
            ("state".to_owned(), state),
            ("mesh".to_owned(), Array::vector(mesh)),
            ("degree_parts".to_owned(), Array::vector(vec![DEGREE as f64, 1.0])),
            ("part".to_owned(), Array::vector(vec![cycle.period])),
            ("gauss_free".to_owned(), Array::vector(vec![0.0, self.prepared.free as f64])),
        ]);
        let list = problem.observables();
        let names =
            self.prepared.observables.iter().flat_map(|&i| ["max", "min"].map(|e| format!("{e} {}", list[i].name)));
        let names = std::iter::once("period".to_owned()).chain(names);
        let ranges = cycle.ranges.iter().flat_map(|range| [range.max, range.min]);
        let numbers = std::iter::once(cycle.period).chain(ranges).zip(&cycle.errors);
        for (name, (value, error)) in names.zip(numbers) {
            if value.is_finite() {
                point.values.insert(name.clone(), value);
            }
            if self.task.along.errors && error.is_finite() {
                point.errors.insert(name, *error);
            }
        }
        point.values.insert("t".to_owned(), cycle.time);
        let frequency = 1.0 / cycle.period;
        point.values.insert("frequency".to_owned(), frequency);
        if let Some(error) = point.errors.get("period").copied() {
            point.errors.insert("frequency".to_owned(), error * frequency * frequency);
        }
        self.store(point);
        Ok(())
    }
}

/// The motion over one period, at increasing parts of it from 0 to 1.
fn sample(
    problem: &dyn Problem,
    cycle: &Cycle,
    p: &[f64],
    control: &Control,
    parts: &[f64],
    counts: &mut Counts,
) -> Result<Vec<Motion>, SimulateError> {
    let course = Course::steady(0.0, cycle.period, p);
    let mut seen: Vec<Motion> = Vec::with_capacity(parts.len());
    integrate(problem, &cycle.at, &course, control, counts, &mut |step| {
        while let Some(part) = parts.get(seen.len()).filter(|part| **part * cycle.period <= step.to.t) {
            seen.push(step.at(part * cycle.period));
        }
        ControlFlow::Continue(())
    })?;
    Ok(seen)
}

/// Intervals with equal shares of the integrator's steps, whose ends are given.
fn mesh(steps: &[f64]) -> Vec<f64> {
    let count = (steps.len() / STEPS).clamp(INTERVALS[0], INTERVALS[1]);
    let mut mesh: Vec<f64> = (0..count)
        .map(|k| {
            let place = (steps.len() - 1) as f64 * k as f64 / count as f64;
            let (j, share) = (place as usize, place.fract());
            steps[j] + share * (steps[j + 1] - steps[j])
        })
        .collect();
    mesh.push(1.0);
    mesh
}
