//! Reading what every branch in one parameter shares: the parameter, its range, the wanted points.

use std::collections::BTreeMap;

use super::entry::{Entry, Section};
use super::several::among;
use super::{Along, Fault, Range, SceneError};

pub(super) const MAX_POINTS: usize = 1_000_000;

pub(super) fn read(section: &Section<'_>) -> Result<Along, SceneError> {
    let free = section.need("free", "free = \"PARAMETER\", the parameter to vary")?;
    let name = free.text()?;
    if name.is_empty() {
        return Err(free.error(Fault::Empty { expected: "the name of a parameter".to_owned() }));
    }
    let range = section.need("range", "range = [from, to], the ends of the free parameter")?;
    let range = read_range(&range, name)?;
    let logarithmic = match section.get("log") {
        Some(entry) => logarithmic(&entry, name, &range)?,
        None => Vec::new(),
    };
    Ok(Along {
        values: match section.get("values") {
            Some(entry) => values(&entry, name, &range)?,
            None => BTreeMap::new(),
        },
        max_step: match section.get("max_step") {
            Some(entry) => Some(entry.positive()?),
            None => None,
        },
        max_points: match section.get("max_points") {
            Some(entry) => entry.count(1..=MAX_POINTS)?,
            None => 1000,
        },
        observables: match section.get("observables") {
            Some(entry) => entry.texts()?,
            None => Vec::new(),
        },
        errors: match section.get("errors") {
            Some(entry) => entry.flag()?,
            None => true,
        },
        places: section.entries().map(|(key, entry)| (key.to_owned(), entry.at)).collect(),
        free: name.to_owned(),
        free_at: free.at,
        range,
        others: Vec::new(),
        logarithmic,
    })
}

/// `true`, or the parameter's name in a list, as where several are free.
fn logarithmic(entry: &Entry<'_>, free: &str, range: &Range) -> Result<Vec<String>, SceneError> {
    let free = vec![free.to_owned()];
    let wanted = match entry.flag() {
        Ok(flag) => flag,
        Err(_) => !among(entry, &free)?.is_empty(),
    };
    if !wanted {
        return Ok(Vec::new());
    }
    if range.from <= 0.0 {
        return Err(entry.error(Fault::OutOfBounds {
            found: format!("a range from {}", range.from),
            allowed: "ranges with ends greater than 0".to_owned(),
        }));
    }
    Ok(free)
}

/// `[0, 500]` or `{ p = [0, 500] }`.
fn read_range(entry: &Entry<'_>, free: &str) -> Result<Range, SceneError> {
    const EXPECTED: &str = "[from, to], two numbers";
    if let Ok(section) = entry.section(EXPECTED) {
        let mut inner = section.entries();
        return match (inner.next(), inner.next()) {
            (Some((key, ends)), None) if key == free => range_ends(&ends, EXPECTED),
            (Some((key, other)), None) => {
                Err(other.error(Fault::RangeOfOther { found: key.to_owned(), free: free.to_owned() }))
            }
            _ => Err(entry.error(Fault::Type {
                expected: format!("one range, {{ {free} = [from, to] }}"),
                found: format!("a table of {}", section.table.entries.len()),
            })),
        };
    }
    range_ends(entry, EXPECTED)
}

pub(super) fn range_ends(entry: &Entry<'_>, expected: &str) -> Result<Range, SceneError> {
    let items = entry.list(expected)?;
    let [from, to] = items.as_slice() else {
        return entry.type_error(expected);
    };
    let (from, to) = (from.number()?, to.number()?);
    if from >= to {
        return Err(entry.error(Fault::Range { from, to }));
    }
    Ok(Range { from, to, at: entry.at.clone() })
}

/// `{ p = [340, 360] }`. Other names than the free parameter's are for the caller to check.
fn values(entry: &Entry<'_>, free: &str, range: &Range) -> Result<BTreeMap<String, Vec<f64>>, SceneError> {
    let example = format!("{{ {free} = [{}, {}] }}", range.from, range.to);
    let section = entry.section(&format!("a table such as {example}"))?;
    if section.table.entries.is_empty() {
        return Err(entry.error(Fault::Empty { expected: example }));
    }
    let mut values = BTreeMap::new();
    for (name, list) in section.entries() {
        let mut wanted: Vec<f64> = Vec::new();
        for item in list.list("a list of numbers")? {
            let value = item.number()?;
            if wanted.contains(&value) {
                let found = value.to_string();
                return Err(item.error(Fault::Repeated { found }));
            }
            if name == free && !(range.from..=range.to).contains(&value) {
                return Err(item.error(Fault::OutsideRange { value, from: range.from, to: range.to }));
            }
            wanted.push(value);
        }
        if wanted.is_empty() {
            return Err(list.error(Fault::Empty { expected: "at least one number, or leave the key out".to_owned() }));
        }
        values.insert(name.to_owned(), wanted);
    }
    Ok(values)
}
