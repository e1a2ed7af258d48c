//! Reading `[model]`.

use super::entry::{Entry, Section};
use super::tree::Content;
use super::{Fault, ModelChoice, ModelOption, OptionValue, SceneError};

pub(super) fn read(root: &Section<'_>) -> Result<ModelChoice, SceneError> {
    let Some(entry) = root.get("model") else {
        return Err(root.error(Fault::Missing {
            what: "the section [model]".to_owned(),
            example: "[model] with name = \"MODEL\" (`hopfline models` lists them)".to_owned(),
        }));
    };
    let section = entry.section("a section, [model]")?;
    let name = section.need("name", "name = \"MODEL\" (`hopfline models` lists them)")?;
    let options = section
        .entries()
        .filter(|(key, _)| *key != "name")
        .map(|(key, entry)| Ok(ModelOption { name: key.to_owned(), value: option_value(&entry)?, at: entry.at }))
        .collect::<Result<_, SceneError>>()?;
    Ok(ModelChoice { name: name.text()?.to_owned(), at: name.at, options })
}

fn option_value(entry: &Entry<'_>) -> Result<OptionValue, SceneError> {
    match &entry.node.content {
        Content::Integer(value) => Ok(OptionValue::Integer(*value)),
        Content::Number(value) => entry.finite(*value).map(OptionValue::Number),
        Content::Text(text) => Ok(OptionValue::Text(text.clone())),
        Content::Flag(flag) => Ok(OptionValue::Flag(*flag)),
        Content::Date(_) | Content::List(_) | Content::Table(_) => {
            entry.type_error("a number, a string, true or false")
        }
    }
}
