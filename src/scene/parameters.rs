//! Reading `[parameters]`.

use super::entry::{Entry, Section};
use super::tree::Content;
use super::{Expression, Fault, SceneError, Setting, Value, units};

pub(super) fn read(root: &Section<'_>) -> Result<Vec<Setting>, SceneError> {
    let Some(entry) = root.get("parameters") else {
        return Ok(Vec::new());
    };
    entry
        .section("a section, [parameters]")?
        .entries()
        .map(|(name, entry)| Ok(Setting { name: name.to_owned(), value: parameter_value(&entry)?, at: entry.at }))
        .collect()
}

fn parameter_value(entry: &Entry<'_>) -> Result<Value, SceneError> {
    match &entry.node.content {
        Content::Integer(_) | Content::Number(_) => entry.number().map(Value::Number),
        Content::Text(text) => tie(entry, text),
        Content::Table(_) => {
            let section = entry.section("a table")?;
            section.allow("key", &["value", "unit"])?;
            let unit = section.need("unit", "unit = \"UNIT\"")?;
            units::check(unit.text()?).map_err(|error| unit.error(error.into()))?;
            Ok(Value::Quantity {
                value: section.need("value", "value = NUMBER")?.number()?,
                unit: unit.text()?.to_owned(),
            })
        }
        Content::Flag(_) | Content::Date(_) | Content::List(_) => {
            entry.type_error("a number, { value = NUMBER, unit = \"UNIT\" } or an expression in quotes")
        }
    }
}

/// An expression; "12 µm" is none, and the message says how to write what is meant.
fn tie(entry: &Entry<'_>, text: &str) -> Result<Value, SceneError> {
    let error = match Expression::parse(text) {
        Ok(expression) => return Ok(Value::Tie(expression)),
        Err(error) => error,
    };
    let trimmed = text.trim();
    let quantity = trimmed
        .find(char::is_whitespace)
        .or_else(|| trimmed.find(|c: char| !c.is_ascii_digit() && !['.', '-', '+'].contains(&c)));
    let quantity = quantity
        .and_then(|at| trimmed.split_at_checked(at))
        .map(|(number, unit)| (number, unit.trim()))
        .filter(|(number, unit)| number.parse::<f64>().is_ok() && units::check(unit).is_ok());
    Err(entry.error(match quantity {
        Some((number, unit)) => Fault::BareQuantity { value: number.to_owned(), unit: unit.to_owned() },
        None => Fault::Expression(error),
    }))
}
