//! Points between the accepted ones where the parameter or an observable takes a wanted value.

use super::describe::observe;
use crate::bifurcation::{Equilibria, Mark, Sample};
use crate::continuation::{Counts, Failure, Point, at_lambda, crossing};
use std::collections::BTreeMap;

/// Points where the free parameter or an observable takes a wanted value.
pub fn user_values(
    system: &Equilibria,
    values: &BTreeMap<String, Vec<f64>>,
    samples: &mut Vec<Sample>,
    counts: &mut Counts,
) -> Result<(), Failure> {
    for (name, wanted) in values {
        let observable = system.problem.observables().iter().position(|o| o.name == name);
        for &goal in wanted {
            let value = |point: &Point| match observable {
                None => point.lambda - system.coordinate.of(goal),
                Some(i) => observe(system, point, i) - goal,
            };
            let mut i = 0;
            while i < samples.len() {
                if value(&samples[i].point) == 0.0 {
                    if let None | Some(Mark::End) = samples[i].mark {
                        samples[i].mark = Some(Mark::User);
                    } else {
                        // A point that is something else, too, is there twice.
                        samples.insert(i, Sample::new(samples[i].point.clone(), Some(Mark::User)));
                        i += 1;
                    }
                } else if i > 0 && value(&samples[i - 1].point) * value(&samples[i].point) < 0.0 {
                    let ends = (&samples[i - 1].point, &samples[i].point);
                    let point = match observable {
                        None => at_lambda(system, ends, system.coordinate.of(goal), None, counts)?.point,
                        Some(_) => crossing(system, ends, &value, counts)?,
                    };
                    samples.insert(i, Sample::new(point, Some(Mark::User)));
                    i += 1;
                }
                i += 1;
            }
        }
    }
    Ok(())
}
