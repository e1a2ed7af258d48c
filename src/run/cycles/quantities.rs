//! What is measured on a cycle: period, frequency, extremes of observables, and the means and norms that are asked for.

use crate::orbit::Orbit;
use crate::problem::{At, Problem, Reflection};
use crate::run::equilibria::frequency;
use crate::run::study::Prepared;

/// An average over the period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Average {
    /// `norm`: of the whole state, `sqrt(1/T int |u|² dt)`.
    State,
    /// `mean NAME`: of an observable.
    Mean(usize),
    /// `norm NAME`: of an observable, `sqrt(1/T int x² dt)`.
    Norm(usize),
}

impl Average {
    /// What "mean x", "norm x" or "norm" stands for, given the observables' names.
    pub fn named(name: &str, observables: &[&str]) -> Option<Self> {
        let find = |name: &str| observables.iter().position(|known| *known == name);
        match name.split_once(' ') {
            Some(("mean", of)) => find(of).map(Average::Mean),
            Some(("norm", of)) => find(of).map(Average::Norm),
            None if name == "norm" => Some(Average::State),
            _ => None,
        }
    }
}

/// Names and units of what [`measure`] gives, for orbits with so many drift velocities.
pub fn columns(prepared: &Prepared, drifts: usize) -> Vec<(String, String)> {
    let time = prepared.problem.time_unit();
    let mut columns = vec![("period".to_owned(), time.to_owned()), ("frequency".to_owned(), frequency(time))];
    let turning = if time.is_empty() { String::new() } else { format!("rad/{time}") };
    columns.extend((1..=drifts).map(|k| (format!("drift_{k}"), turning.clone())));
    let list = prepared.problem.observables();
    for &i in &prepared.observables {
        for extreme in ["max", "min"] {
            columns.push((format!("{extreme} {}", list[i].name), list[i].unit.to_owned()));
        }
    }
    for average in &prepared.averages {
        columns.push(match *average {
            Average::State => ("norm".to_owned(), String::new()),
            Average::Mean(i) => (format!("mean {}", list[i].name), list[i].unit.to_owned()),
            Average::Norm(i) => (format!("norm {}", list[i].name), list[i].unit.to_owned()),
        });
    }
    columns
}

/// The numbers in these columns, of an orbit of the task's problem or of a refinement of it.
pub fn measure(
    prepared: &Prepared,
    problem: &dyn Problem,
    orbit: &Orbit,
    symmetry: &Reflection,
    p: &[f64],
) -> Vec<f64> {
    let mut values = vec![orbit.period(), 1.0 / orbit.period()];
    values.extend_from_slice(&orbit.drift);
    for &i in &prepared.observables {
        let extremes = orbit.extremes(problem, i, p, symmetry);
        values.extend([extremes.max, extremes.min]);
    }
    for average in &prepared.averages {
        let observe = |i: usize, u: &[f64], v: &[f64]| {
            let mut v = v.to_vec();
            orbit.add_drift(problem, u, &mut v);
            problem.observe(i, At { u, v: &v, p })
        };
        values.push(match *average {
            Average::State => orbit.mean(symmetry, &|u, _| crate::linalg::dot(u, u)).sqrt(),
            Average::Mean(i) => orbit.mean(symmetry, &|u, v| observe(i, u, v)),
            Average::Norm(i) => orbit.mean(symmetry, &|u, v| observe(i, u, v).powi(2)).sqrt(),
        });
    }
    values
}
