//! Reading a task of kind `diagram`.

use super::along::{self, MAX_POINTS, range_ends};
use super::entry::{Entry, Section};
use super::task::{inside, multipliers};
use super::{Along, Cycles, Diagram, Equilibria, Fault, Guess, Place, Range, SceneError};

/// Default of how many switches lie between the first branch and the last ones.
const DEPTH: usize = 3;
const MOST_BRANCHES: usize = 50;

pub(super) const KEYS: [&str; 22] = [
    "name",
    "kind",
    "free",
    "range",
    "log",
    "start",
    "values",
    "max_step",
    "max_points",
    "observables",
    "errors",
    "spectrum",
    "states",
    "deflate",
    "box",
    "depth",
    "max_branches",
    "cycles",
    "intervals",
    "degree",
    "multipliers",
    "symmetry",
];

pub(super) fn read(section: &Section<'_>, name: &str) -> Result<Diagram, SceneError> {
    let along = along::read(section)?;
    let cycles = match section.get("cycles") {
        Some(entry) => entry.flag()?,
        None => true,
    };
    let count = |key: &str, allowed: std::ops::RangeInclusive<usize>, default: usize| match section.get(key) {
        Some(entry) => entry.count(allowed),
        None => Ok(default),
    };
    let mut found = Diagram {
        states: Vec::new(),
        deflate: Vec::new(),
        depth: count("depth", 0..=100, DEPTH)?,
        max_branches: count("max_branches", 1..=MAX_POINTS, MOST_BRANCHES)?,
        cycles: cycles.then(|| cycles_of(section, &along, name)).transpose()?,
        equilibria: Equilibria {
            from: None,
            start: section.get("start").map(|entry| inside(&entry, &along)).transpose()?,
            guess: None,
            bounds: bounds(section)?,
            spectrum: count("spectrum", 0..=1000, 0)?,
            all_eigenvalues: None,
            detect: ["HB", "LP", "BP"].map(str::to_owned).to_vec(),
            along: along.clone(),
        },
    };
    if let Some(entry) = section.get("states") {
        for item in entry.list("a list of states such as [{ x = 1, y = 2 }]")? {
            found.states.push(guess(&item)?);
        }
    }
    if let Some(entry) = section.get("deflate") {
        for item in entry.list("a list of values of the free parameter")? {
            found.deflate.push(inside(&item, &along)?);
        }
    }
    Ok(found)
}

fn cycles_of(section: &Section<'_>, along: &Along, name: &str) -> Result<Cycles, SceneError> {
    Ok(Cycles {
        relative: false,
        along: along.clone(),
        from: format!("{name}-1/HB1"),
        from_at: section.at.clone(),
        intervals: section.get("intervals").map(|entry| entry.count(2..=10_000)).transpose()?,
        tolerance: None,
        detect: Vec::new(),
        degree: section.get("degree").map_or(Ok(4), |entry| entry.count(2..=7))?,
        gauss: false,
        multipliers: section.get("multipliers").map_or(Ok(2), |entry| multipliers(&entry))?,
        symmetry: match section.get("symmetry") {
            Some(entry) => entry.choice("symmetry", &["auto", "none"])? == "auto",
            None => true,
        },
    })
}

/// `{ x = 1, y = 2 }`: unknowns, and perhaps the free parameter; which there are only the model knows.
pub(super) fn guess(entry: &Entry<'_>) -> Result<Guess, SceneError> {
    const EXPECTED: &str = "a table of unknowns such as { x = 1, y = 2 }";
    let table = entry.section(EXPECTED)?;
    let mut values: Vec<(String, f64, Place)> = Vec::new();
    for (name, value) in table.entries() {
        values.push((name.to_owned(), value.number()?, value.at.clone()));
    }
    if values.is_empty() {
        return Err(entry.error(Fault::Empty { expected: EXPECTED.to_owned() }));
    }
    Ok(Guess { values, at: entry.at.clone() })
}

/// `box = { x = [-2, 2] }`: observables with the ranges in which branches are followed.
fn bounds(section: &Section<'_>) -> Result<Vec<(String, Range)>, SceneError> {
    let Some(entry) = section.get("box") else { return Ok(Vec::new()) };
    let table = entry.section("a table of observables such as { x = [-2, 2] }")?;
    table.entries().map(|(name, ends)| Ok((name.to_owned(), range_ends(&ends, "[from, to], two numbers")?))).collect()
}
