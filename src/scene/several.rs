//! Reading what varies several parameters at once: curves, maps, surfaces.

use std::collections::BTreeMap;

use super::along::{MAX_POINTS, range_ends};
use super::entry::{Entry, Section};
use super::label::{self, Announced};
use super::{Along, Axis, Curve, Fault, Range, SceneError, Surface, Task};

/// Default of a surface's tolerance.
const TOLERANCE: f64 = 5e-4;
/// And of its most points.
const MOST_POINTS: usize = 10_000;
/// Coarser than this a surface is not one.
const COARSEST: f64 = 0.1;

/// A curve in two parameters from a point; only the second parameter needs a range.
pub(super) fn curve(
    section: &Section<'_>,
    read: &[Task],
    announced: &[Announced],
    example: &str,
) -> Result<Curve, SceneError> {
    let from = section.need("from", example)?;
    label::check(from.text()?, read, announced).map_err(|fault| from.error(fault))?;
    let along = along(section, &["p", "L"], 1)?;
    Ok(Curve { along, from: from.text()?.to_owned(), from_at: from.at })
}

/// A surface in three parameters from a point; all need ranges.
pub(super) fn surface(section: &Section<'_>, read: &[Task], announced: &[Announced]) -> Result<Surface, SceneError> {
    let from = section.need("from", "from = \"TASK/HB1\", a Hopf point of the surface")?;
    label::check(from.text()?, read, announced).map_err(|fault| from.error(fault))?;
    let mut along = along(section, &["p", "L", "k_N"], 3)?;
    if section.get("max_points").is_none() {
        along.max_points = MOST_POINTS;
    }
    let tolerance = match section.get("tolerance") {
        Some(entry) => match entry.positive()? {
            value if value <= COARSEST => value,
            value => {
                let allowed = format!("numbers greater than 0, up to {COARSEST}");
                return Err(entry.error(Fault::OutOfBounds { found: value.to_string(), allowed }));
            }
        },
        None => TOLERANCE,
    };
    Ok(Surface { along, from: from.text()?.to_owned(), from_at: from.at, tolerance })
}

/// As many free parameters as the example has names; the last `bounded` ones need a range.
pub(super) fn along(section: &Section<'_>, example: &[&str], bounded: usize) -> Result<Along, SceneError> {
    let count = ["no", "one", "two", "three"][example.len()];
    let what = format!("free = {example:?}, the {count} parameters to vary");
    let free = section.need("free", &what)?;
    let names = free.texts()?;
    if names.len() != example.len() {
        return free.type_error(&format!("{count} names, as in {example:?}"));
    }
    let logarithmic = match section.get("log") {
        Some(entry) => among(&entry, &names)?,
        None => Vec::new(),
    };
    let mut ranges = ranges(section, &names, &logarithmic)?;
    for (name, range) in names.iter().zip(&ranges).skip(names.len() - bounded) {
        if range.is_none() {
            let example = format!("range = {{ {name} = [from, to] }}");
            return Err(section.error(Fault::Missing { what: format!("the range of {name:?}"), example }));
        }
    }
    let values = match section.get("values") {
        Some(entry) => values(&entry, &names, &ranges)?,
        None => BTreeMap::new(),
    };
    let Some((name, range)) = names.last().cloned().zip(ranges.pop().flatten()) else {
        return free.type_error(&format!("{count} names, as in {example:?}"));
    };
    let others = names.into_iter().zip(ranges).map(|(name, range)| Axis { name, range }).collect();
    Ok(Along {
        free: name,
        free_at: free.at,
        range,
        others,
        logarithmic,
        values,
        max_step: None,
        max_points: match section.get("max_points") {
            Some(entry) => entry.count(1..=MAX_POINTS)?,
            None => 1000,
        },
        observables: Vec::new(),
        errors: match section.get("errors") {
            Some(entry) => entry.flag()?,
            None => true,
        },
        places: section.entries().map(|(key, entry)| (key.to_owned(), entry.at)).collect(),
    })
}

/// A list of some of the free parameters.
pub(super) fn among(entry: &Entry<'_>, names: &[String]) -> Result<Vec<String>, SceneError> {
    for item in entry.list("a list of free parameters")? {
        if !names.iter().any(|name| Ok(name.as_str()) == item.text().as_deref().map_err(|_| ())) {
            return Err(item.error(Fault::unknown("free parameter", item.text()?, names.iter().map(String::as_str))));
        }
    }
    entry.texts()
}

/// `{ L = [4, 30], p = [0, 1000] }`: one for each parameter, where given.
pub(super) fn ranges(
    section: &Section<'_>,
    names: &[String],
    logarithmic: &[String],
) -> Result<Vec<Option<Range>>, SceneError> {
    let example = format!("{{ {} = [from, to] }}", names.last().map_or("p", String::as_str));
    let entry = section.need("range", &format!("range = {example}, the bounds"))?;
    let table = entry.section(&format!("a table such as {example}"))?;
    let mut found = vec![None; names.len()];
    for (name, ends) in table.entries() {
        let Some(k) = names.iter().position(|known| known == name) else {
            return Err(ends.error(Fault::unknown("free parameter", name, names.iter().map(String::as_str))));
        };
        let range = range_ends(&ends, "[from, to], two numbers")?;
        if logarithmic.iter().any(|known| known == name) && range.from <= 0.0 {
            let found = format!("[{}, {}]", range.from, range.to);
            return Err(ends.error(Fault::OutOfBounds {
                found,
                allowed: "ends greater than 0 (the parameter is logarithmic)".to_owned(),
            }));
        }
        found[k] = Some(range);
    }
    Ok(found)
}

/// `{ L = [10], p = [400] }`: wanted values of the parameters, inside their ranges.
fn values(
    entry: &Entry<'_>,
    names: &[String],
    ranges: &[Option<Range>],
) -> Result<BTreeMap<String, Vec<f64>>, SceneError> {
    let example = format!("{{ {} = [...] }}", names.last().map_or("p", String::as_str));
    let table = entry.section(&format!("a table such as {example}"))?;
    if table.table.entries.is_empty() {
        return Err(entry.error(Fault::Empty { expected: example }));
    }
    let mut values = BTreeMap::new();
    for (name, list) in table.entries() {
        let Some(k) = names.iter().position(|known| known == name) else {
            return Err(list.error(Fault::unknown("free parameter", name, names.iter().map(String::as_str))));
        };
        let mut wanted: Vec<f64> = Vec::new();
        for item in list.list("a list of numbers")? {
            let value = item.number()?;
            if wanted.contains(&value) {
                return Err(item.error(Fault::Repeated { found: value.to_string() }));
            }
            if let Some(range) = ranges[k].as_ref().filter(|range| !(range.from..=range.to).contains(&value)) {
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
