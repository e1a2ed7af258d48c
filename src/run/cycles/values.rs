//! User values (UZ): points where the parameter, the period or an observable's extreme is as wanted.

use super::Cycles;
use super::special::{Between, Special};
use crate::branch::Kind;
use crate::continuation::{Counts, Point, Step, at_lambda, crossing, inner};
use crate::orbit::{Collocation, OrbitFactors};
use crate::run::watch::Watch;

impl Cycles<'_> {
    /// The wanted values: columns, where the free parameter is the first, and numbers.
    pub fn goals(&self) -> impl Iterator<Item = (usize, f64)> {
        let values = self.task.along.values.iter();
        values.flat_map(|(name, wanted)| {
            let column = self.branch.column(name).unwrap_or(0);
            wanted.iter().map(move |&goal| (column, goal))
        })
    }

    /// How far a point's number in a column is from a wanted one.
    pub fn beyond(&self, system: &Collocation, point: &Point, (column, goal): (usize, f64)) -> f64 {
        match column {
            0 => point.lambda - goal,
            k => {
                let orbit = system.orbit(&point.x);
                self.measure(&orbit, &system.frame.symmetry, &system.parameters(point.lambda))[k - 1] - goal
            }
        }
    }

    /// Points between two accepted ones where the parameter, the period or an observable's extreme is as wanted. A search
    /// that fails leaves a gap in what was found, not in the branch.
    pub fn user_values(
        &self,
        system: &Collocation,
        Step { from, to, factors, .. }: &Step<OrbitFactors>,
        (counts, watch): (&mut Counts, &Watch),
    ) -> Vec<Between> {
        let mut found = Vec::new();
        let mut places = vec![from.clone(), to.clone()];
        // Next to a fold the parameter takes a value twice within a step.
        if from.tangent_lambda * to.tangent_lambda < 0.0 && self.goals().any(|(column, _)| column == 0) {
            let turn = crossing(system, (from, to), &|point: &Point| point.tangent_lambda, counts);
            places.splice(1..1, turn.ok());
        }
        for (piece, ends) in places.windows(2).enumerate() {
            let (from, to) = (&ends[0], &ends[1]);
            for wanted in self.goals() {
                // A row that has the value is not to be found again, where moving the mesh has moved it by rounding.
                let row = self.branch.rows.last().filter(|_| piece == 0);
                if row.is_some_and(|row| row.values[wanted.0] == Some(wanted.1)) {
                    continue;
                }
                let value = |point: &Point| self.beyond(system, point, wanted);
                let (a, b) = (value(from), value(to));
                if !(a * b < 0.0 || b == 0.0) {
                    continue;
                }
                let lambda = match wanted {
                    (0, goal) => Ok(goal),
                    _ => crossing(system, (from, to), &value, counts).map(|point| point.lambda),
                };
                let held = (piece + 2 == places.len()).then_some(&**factors);
                match lambda.and_then(|lambda| at_lambda(system, (from, to), lambda, held, counts)) {
                    Ok(corrected) => found.push(Between {
                        fraction: fraction(system, (&places[0], &places[places.len() - 1]), &corrected.point),
                        point: corrected.point,
                        factors: Some(corrected.factors.into()),
                        kind: Kind::UZ,
                        special: Special::default(),
                    }),
                    Err(failure) => {
                        let (column, goal) = (&self.branch.columns[wanted.0].name, wanted.1);
                        watch.say(format!("{column} = {goal} was passed, but could not be solved for: {failure}"));
                    }
                }
            }
        }
        found
    }
}

/// How far along the chord of a step a point lies.
fn fraction(system: &Collocation, (from, to): (&Point, &Point), point: &Point) -> f64 {
    let gap = |to: &Point| -> (Vec<f64>, f64) {
        (to.x.iter().zip(&from.x).map(|(a, b)| a - b).collect(), to.lambda - from.lambda)
    };
    let (chord, part) = (gap(to), gap(point));
    let chord = (&chord.0[..], chord.1);
    inner(system, (&part.0, part.1), chord) / inner(system, chord, chord)
}
