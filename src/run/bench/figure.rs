//! From a study's report to its figures.

use super::super::RunError;
use super::report::{QuantityLine, Report};
use crate::plot::{WorkPrecision, Worked, draw_work};

/// The figure of a number and its name; None where there is nothing to draw.
pub fn draw(report: &Report, quantity: &QuantityLine) -> Result<Option<(String, String)>, RunError> {
    let families: Vec<WorkPrecision> = report
        .families
        .iter()
        .map(|family| WorkPrecision {
            name: family.name.clone(),
            order: family.orders.get(&quantity.name).and_then(|orders| orders.unknowns).map(|law| law.exponent),
            points: family
                .settings
                .iter()
                .filter_map(|line| {
                    let found = line.found.get(&quantity.name)?;
                    let seconds = line.seconds;
                    Some(Worked {
                        error: found.error,
                        seconds: seconds.median,
                        spread: (seconds.least, seconds.most),
                        unknowns: line.unknowns.map(|unknowns| unknowns as f64),
                    })
                })
                .collect(),
        })
        .collect();
    if families.iter().all(|family| family.points.is_empty()) {
        return Ok(None);
    }
    let what = if quantity.value == Some(0.0) { "error" } else { "relative error" };
    let label = format!("{what} of {}", quantity.name);
    let svg = draw_work(&report.title, &label, quantity.relative_error(), &families)?;
    let name = quantity.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    Ok(Some((name, svg)))
}
