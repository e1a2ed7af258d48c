//! Cycles that tasks start from, as samples in a file: a simulation's or a measurement's.
//!
//! The file is a table (CSV): a head, then rows with the time and all states of the model in their order. The last turn is
//! taken: from the last row back to where the motion was nearest to it before. Newton's method makes a cycle of it.

use super::study::Prepared;
use crate::branch::{Array, Kind, SpecialPoint};
use crate::orbit::{Orbit, Points, Scheme};
use crate::problem::Problem;
use std::path::{Path, PathBuf};
use thiserror::Error;

#[derive(Debug, Error)]
pub enum RecordedError {
    #[error("cannot read {}: {cause}", path.display())]
    Read { path: PathBuf, cause: std::io::Error },
    #[error("{}, line {line}: {problem}", path.display())]
    Line { path: PathBuf, line: usize, problem: String },
    #[error("{}: {problem}", path.display())]
    Content { path: PathBuf, problem: String },
}

/// Times, and states at them.
struct Samples {
    t: Vec<f64>,
    u: Vec<Vec<f64>>,
}

/// A return counts as one if it comes nearer than this part of the largest distance.
const NEAR: f64 = 0.2;
const FEWEST: usize = 8;

/// Reads the file and makes its last turn a stored cycle at the scene's parameters, `intervals` of a degree.
pub fn cycle(
    path: &Path,
    label: &str,
    prepared: &Prepared,
    (intervals, degree): (usize, usize),
) -> Result<SpecialPoint, RecordedError> {
    let samples = read(path, prepared.problem.dim())?;
    let content = |problem: String| RecordedError::Content { path: path.to_owned(), problem };
    let turn = samples.last_turn().ok_or_else(|| {
        content("the samples do not come back to where they end; give at least one period of a cycle".to_owned())
    })?;
    let orbit = turn.orbit(intervals, degree);
    let p = prepared.problem.resolve(&prepared.p);
    let nodes = |data: Vec<f64>| Array { shape: vec![data.len() / orbit.dim, orbit.dim], data };
    let mut point = SpecialPoint::new(label.to_owned(), Kind::EP, 0);
    let names = prepared.problem.parameters().iter();
    point.parameters = names.zip(&p).map(|(q, &x)| (q.name.to_owned(), x)).collect();
    point.arrays = [
        ("state", nodes(orbit.nodes.clone())),
        ("tangent", nodes(vec![0.0; orbit.nodes.len()])),
        ("tangent_part_lambda", Array::vector(vec![0.0, 0.0])),
        ("mesh", Array::vector(orbit.mesh.clone())),
        ("degree_parts", Array::vector(vec![degree as f64, 1.0])),
        ("part", Array::vector(vec![orbit.part])),
        ("gauss_free", Array::vector(vec![0.0, prepared.free as f64])),
    ]
    .map(|(name, array)| (name.to_owned(), array))
    .into();
    Ok(point)
}

fn read(path: &Path, dim: usize) -> Result<Samples, RecordedError> {
    let text = std::fs::read_to_string(path).map_err(|cause| RecordedError::Read { path: path.to_owned(), cause })?;
    let fault = |line: usize, problem: String| RecordedError::Line { path: path.to_owned(), line, problem };
    let mut samples = Samples { t: Vec::new(), u: Vec::new() };
    for (line, row) in text.lines().enumerate().skip(1).filter(|(_, row)| !row.trim().is_empty()) {
        let numbers: Result<Vec<f64>, _> = row.split(',').map(|cell| cell.trim().parse::<f64>()).collect();
        let numbers = numbers.map_err(|e| fault(line + 1, format!("not a row of numbers: {e}")))?;
        if numbers.len() != dim + 1 {
            let found = numbers.len();
            return Err(fault(
                line + 1,
                format!("{found} numbers; there must be {}: the time and {dim} states", dim + 1),
            ));
        }
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(fault(line + 1, "a number is not finite".to_owned()));
        }
        if samples.t.last().is_some_and(|last| *last >= numbers[0]) {
            return Err(fault(line + 1, format!("the time {} does not come after the one before it", numbers[0])));
        }
        samples.t.push(numbers[0]);
        samples.u.push(numbers[1..].to_vec());
    }
    if samples.t.len() < FEWEST {
        let problem = format!("{} samples; at least {FEWEST} are needed", samples.t.len());
        return Err(RecordedError::Content { path: path.to_owned(), problem });
    }
    Ok(samples)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

impl Samples {
    /// From the nearest return to the last sample on, closed by spreading what is missing.
    fn last_turn(&self) -> Option<Self> {
        let (last, end) = (self.t.len() - 1, self.u.last()?);
        let gaps: Vec<f64> = self.u.iter().map(|u| distance(u, end)).collect();
        let far = gaps.iter().fold(0.0_f64, |most, gap| most.max(*gap));
        // Backwards: away from the end first, then near it again.
        let away = (0..last).rev().find(|&i| gaps[i] > 0.5 * far)?;
        let back = (0..away).rev().find(|&i| gaps[i] < NEAR * far)?;
        let leaves = (0..back).rev().find(|&i| gaps[i] > NEAR * far).map_or(0, |i| i + 1);
        let start = (leaves..=back).min_by(|&i, &j| gaps[i].total_cmp(&gaps[j]))?;
        let (t, period) = (&self.t[start..], self.t[last] - self.t[start]);
        let missing: Vec<f64> = self.u[start].iter().zip(end).map(|(a, b)| a - b).collect();
        let closed = t.iter().zip(&self.u[start..]).map(|(t, u)| {
            let share = (t - self.t[start]) / period;
            u.iter().zip(&missing).map(|(u, m)| u + share * m).collect()
        });
        Some(Self { t: t.iter().map(|t| t - self.t[start]).collect(), u: closed.collect() })
    }

    /// By linear interpolation, with intervals that share the way along the curve and the time.
    fn orbit(&self, intervals: usize, degree: usize) -> Orbit {
        let period = self.t[self.t.len() - 1];
        let pieces: Vec<f64> = self.u.windows(2).map(|w| distance(&w[0], &w[1])).collect();
        let length: f64 = pieces.iter().sum();
        let mut way = vec![0.0];
        for (k, piece) in pieces.iter().enumerate() {
            way.push(way[k] + 0.5 * piece / length + 0.5 * (self.t[k + 1] - self.t[k]) / period);
        }
        let tau = |goal: f64| {
            let k = way.partition_point(|x| *x <= goal).clamp(1, way.len() - 1);
            let share = (goal - way[k - 1]) / (way[k] - way[k - 1]);
            (self.t[k - 1] + share * (self.t[k] - self.t[k - 1])) / period
        };
        let mut mesh: Vec<f64> = (0..=intervals).map(|j| tau(j as f64 / intervals as f64)).collect();
        (mesh[0], mesh[intervals]) = (0.0, 1.0);
        let scheme = Scheme::new(Points::Radau, degree);
        let mut nodes = Vec::new();
        for w in mesh.windows(2) {
            for x in &scheme.nodes[..degree] {
                nodes.extend(self.at((w[0] + x * (w[1] - w[0])) * period));
            }
        }
        nodes.extend_from_slice(&self.u[0]);
        Orbit {
            mesh,
            points: Points::Radau,
            degree,
            nodes,
            dim: self.u[0].len(),
            part: period,
            parts: 1,
            drift: Vec::new(),
        }
    }

    fn at(&self, t: f64) -> Vec<f64> {
        let k = self.t.partition_point(|x| *x <= t).clamp(1, self.t.len() - 1);
        let share = (t - self.t[k - 1]) / (self.t[k] - self.t[k - 1]);
        self.u[k - 1].iter().zip(&self.u[k]).map(|(a, b)| a + share * (b - a)).collect()
    }
}
