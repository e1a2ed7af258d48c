//! Reading `[expect]`.

use super::entry::Section;
use super::label::{self, Announced};
use super::{Expectation, SceneError, Task};

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
