//! Reading simulations: motions in time.

use std::collections::BTreeMap;

use super::entry::{Entry, Section};
use super::label::{self, Announced};
use super::tree::Content;
use super::{Along, Axis, Fault, Happening, Range, SceneError, Simulate, Start, Task, diagram};

/// Keys that no other kind has.
pub(super) const OWN: [&str; 9] =
    ["amplitude", "parameters", "time", "ramp", "over", "method", "absolute", "samples", "events"];

pub(super) const KEYS: [&str; 16] = [
    "name",
    "kind",
    "from",
    "start",
    "amplitude",
    "parameters",
    "time",
    "ramp",
    "over",
    "method",
    "tolerance",
    "absolute",
    "samples",
    "events",
    "observables",
    "errors",
];

/// Of the relative tolerance; the absolute one follows it.
const TOLERANCE: f64 = 1e-6;
const FINEST: f64 = 1e-13;
const COARSEST: f64 = 0.1;
const SAMPLES: usize = 1000;
const MOST: usize = 1_000_000;

pub(super) fn read(section: &Section<'_>, read: &[Task], announced: &[Announced]) -> Result<Simulate, SceneError> {
    let from = match section.get("from") {
        Some(entry) => {
            label::check(entry.text()?, read, announced).map_err(|fault| entry.error(fault))?;
            if let Some(start) = section.get("start") {
                let message = "a motion starts at a point (from) or at values of the unknowns (start); keep one";
                return Err(start.error(Fault::Other(message.into())));
            }
            Some((entry.text()?.to_owned(), entry.at))
        }
        None => None,
    };
    let start = match section.get("start") {
        Some(entry) if matches!(entry.node.content, Content::Table(_)) => Some(Start::Named(diagram::guess(&entry)?)),
        Some(entry) => {
            let items = entry.list("a list of numbers, one for each unknown, or a table such as { x = 1 }")?;
            Some(Start::List(items.iter().map(Entry::number).collect::<Result<Vec<f64>, _>>()?, entry.at))
        }
        None => None,
    };
    let events = match (section.get("events"), section.get("over")) {
        (Some(entry), Some(_)) => {
            let message = "events are those of one motion; leave out events or over";
            return Err(entry.error(Fault::Other(message.into())));
        }
        (Some(entry), None) => {
            let items = entry.list("a list such as [{ of = \"x\", value = 0 }]")?;
            items.iter().map(happening).collect::<Result<Vec<_>, _>>()?
        }
        (None, _) => Vec::new(),
    };
    let time = section.need("time", "time = [0, 10], when the motion begins and ends")?;
    let time = super::along::range_ends(&time, "[begin, end], two times")?;
    let parameters = match section.get("parameters") {
        Some(entry) => {
            let table = entry.section("a table such as { p = 360 }")?;
            table
                .entries()
                .map(|(name, value)| Ok((name.to_owned(), value.number()?)))
                .collect::<Result<Vec<_>, _>>()?
        }
        None => Vec::new(),
    };
    let ramp = match section.get("ramp") {
        Some(entry) => {
            let (name, ends) = one(&entry, "{ p = [300, 500] }, a parameter and its values at both ends")?;
            let items = ends.list("two numbers")?;
            let [first, last] = &items[..] else { return ends.type_error("two numbers") };
            Some((name, [first.number()?, last.number()?]))
        }
        None => None,
    };
    let over = match section.get("over") {
        Some(entry) => {
            if let Some(ramp) = section.get("ramp") {
                let message =
                    "a parameter rises during one motion (ramp) or from one motion to the next (over); keep one";
                return Err(ramp.error(Fault::Other(message.into())));
            }
            let (name, list) = one(&entry, "{ p = [340, 350, 360] }, a parameter and its values")?;
            let items = list.list("a list of numbers")?;
            if items.is_empty() {
                return Err(list.error(Fault::Empty { expected: "at least one number".to_owned() }));
            }
            Some((name, items.iter().map(Entry::number).collect::<Result<Vec<f64>, _>>()?))
        }
        None => None,
    };
    let tolerance = tolerance(section, "tolerance", TOLERANCE)?;
    // The parameters that this task sets, those that vary last.
    let mut set: Vec<(String, [f64; 2], super::Place)> = Vec::new();
    let at = |key: &str| section.get(key).map_or_else(|| section.at.clone(), |entry| entry.at);
    set.extend(parameters.iter().map(|(name, value)| (name.clone(), [*value; 2], at("parameters"))));
    set.extend(ramp.iter().map(|(name, ends)| (name.clone(), *ends, at("ramp"))));
    set.extend(over.iter().map(|(name, values)| {
        let extreme = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick).unwrap_or(f64::NAN);
        (name.clone(), [extreme(f64::min), extreme(f64::max)], at("over"))
    }));
    for (k, (name, _, place)) in set.iter().enumerate() {
        if set[..k].iter().any(|(known, ..)| known == name) {
            return Err(section.source.error(place.clone(), Fault::Repeated { found: name.clone() }));
        }
    }
    let range = |[a, b]: [f64; 2], at: super::Place| Range { from: a.min(b), to: a.max(b), at };
    let nowhere = (String::new(), [0.0; 2], section.at.clone());
    let (free, ends, free_at) = set.pop().unwrap_or(nowhere);
    let others = set.into_iter().map(|(name, ends, at)| Axis { name, range: Some(range(ends, at)) }).collect();
    let along = Along {
        free,
        range: range(ends, free_at.clone()),
        free_at,
        others,
        logarithmic: Vec::new(),
        values: BTreeMap::new(),
        max_step: None,
        max_points: MOST,
        observables: match section.get("observables") {
            Some(entry) => entry.texts()?,
            None => Vec::new(),
        },
        errors: match section.get("errors") {
            Some(entry) => entry.flag()?,
            None => true,
        },
        places: section.entries().map(|(key, entry)| (key.to_owned(), entry.at)).collect(),
    };
    Ok(Simulate {
        along,
        from,
        start,
        events,
        amplitude: match section.get("amplitude") {
            Some(entry) => Some(entry.number()?),
            None => None,
        },
        parameters,
        ramp,
        over,
        time: [time.from, time.to],
        sdirk: match section.get("method") {
            Some(entry) => entry.choice("method", &["bdf", "sdirk"])? == "sdirk",
            None => false,
        },
        tolerance,
        absolute: self::tolerance(section, "absolute", tolerance)?,
        samples: match section.get("samples") {
            Some(entry) => entry.count(1..=MOST)?,
            None => SAMPLES,
        },
    })
}

fn happening(entry: &Entry<'_>) -> Result<Happening, SceneError> {
    const EXAMPLE: &str = "{ of = \"x\", value = 0, direction = \"up\" }, an observable and the value that it crosses";
    let section = entry.section(EXAMPLE)?;
    section.allow("key of an event", &["of", "value", "direction", "stop"])?;
    Ok(Happening {
        of: section.need("of", EXAMPLE)?.text()?.to_owned(),
        value: section.need("value", EXAMPLE)?.number()?,
        direction: match section.get("direction") {
            Some(entry) => entry.choice("direction", &["up", "down", "any"])?,
            None => "any",
        },
        stop: match section.get("stop") {
            Some(entry) => entry.flag()?,
            None => false,
        },
        at: entry.at.clone(),
    })
}

fn tolerance(section: &Section<'_>, key: &str, default: f64) -> Result<f64, SceneError> {
    let Some(entry) = section.get(key) else { return Ok(default) };
    let value = entry.positive()?;
    if (FINEST..=COARSEST).contains(&value) {
        return Ok(value);
    }
    let allowed = format!("numbers from {FINEST:e} to {COARSEST}");
    Err(entry.error(Fault::OutOfBounds { found: value.to_string(), allowed }))
}

/// The one entry of a table.
fn one<'a>(entry: &Entry<'a>, expected: &str) -> Result<(String, Entry<'a>), SceneError> {
    let table = entry.section(expected)?;
    let mut entries = table.entries();
    match (entries.next(), entries.next()) {
        (Some((name, value)), None) => Ok((name.to_owned(), value)),
        _ => entry.type_error(expected),
    }
}
