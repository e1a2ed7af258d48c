//! Reading `[expect]`.

use super::entry::Section;
use super::label::{self, Announced};
use super::{Expectation, Fault, SceneError, Task, TaskKind};
use std::collections::BTreeMap;

/// `beat.ends = "no step of at least"`: how tasks are expected to end, by their names.
pub(super) fn ends(root: &Section<'_>, tasks: &[Task]) -> Result<BTreeMap<String, String>, SceneError> {
    let mut ends = BTreeMap::new();
    let Some(entry) = root.get("expect") else { return Ok(ends) };
    for (name, entry) in entry.section("a section, [expect]")?.entries() {
        if let Some(task) = tasks.iter().find(|task| task.name == name) {
            if let TaskKind::Diagram(_) = task.kind {
                let message = format!(
                    "{name:?} is a diagram: each of its branches ends in its own way, and none is to be expected"
                );
                return Err(entry.error(Fault::Other(message)));
            }
            let section = entry.section("a table, TASK.ends = \"part of the reason\"")?;
            section.allow("key", &["ends"])?;
            let reason = section.need("ends", "ends = \"part of the reason\"")?.text()?;
            ends.insert(name.to_owned(), reason.to_owned());
        }
    }
    Ok(ends)
}

/// `"straight/HB1".p = { value = ..., tolerance = ... }`
pub(super) fn read(
    root: &Section<'_>,
    tasks: &[Task],
    announced: &[Announced],
) -> Result<Vec<Expectation>, SceneError> {
    const EXPECTED: &str = "a table, \"TASK/HB1\".QUANTITY = { value = NUMBER, tolerance = NUMBER }";
    let mut expectations = Vec::new();
    let Some(entry) = root.get("expect") else {
        return Ok(expectations);
    };
    for (label, entry) in entry.section("a section, [expect]")?.entries() {
        if tasks.iter().any(|task| task.name == label) {
            continue;
        }
        label::check(label, tasks, announced).map_err(|fault| entry.error(fault))?;
        for (quantity, entry) in entry.section(EXPECTED)?.entries() {
            let section = entry.section(EXPECTED)?;
            section.allow("key", &["value", "tolerance", "source"])?;
            expectations.push(Expectation {
                label: label.to_owned(),
                quantity: quantity.to_owned(),
                value: section.need("value", "value = NUMBER")?.number()?,
                tolerance: section
                    .need("tolerance", "tolerance = NUMBER, relative unless the value is 0")?
                    .positive()?,
                source: match section.get("source") {
                    Some(source) => source.text()?.to_owned(),
                    None => String::new(),
                },
                at: entry.at,
            });
        }
    }
    Ok(expectations)
}
