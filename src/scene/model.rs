//! Reading `[model]`: a model's name and options, or a model as text.

use super::entry::{Entry, Section};
use super::tree::Content;
use super::{
    Fault, ModelChoice, ModelOption, ModelText, OptionValue, Place, SceneError, TextObservable, TextParameter,
    TextValue, Words,
};

/// What a model as text may hold; every other key is the name of a whole number.
const TEXT_KEYS: [&str; 8] =
    ["equations", "parameters", "start", "observables", "conserved", "symmetry", "rotations", "time_unit"];

pub(super) fn read(root: &Section<'_>) -> Result<ModelChoice, SceneError> {
    let Some(entry) = root.get("model") else {
        return Err(root.error(Fault::Missing {
            what: "the section [model]".to_owned(),
            example: "[model] with name = \"MODEL\" (`hopfline models` lists them) or with equations = \"x' = ...\""
                .to_owned(),
        }));
    };
    let section = entry.section("a section, [model]")?;
    if let Some(equations) = section.get("equations") {
        return written(&section, &equations);
    }
    let name = section.need("name", "name = \"MODEL\" (`hopfline models` lists them), or equations = \"x' = ...\"")?;
    let options = section
        .entries()
        .filter(|(key, _)| *key != "name")
        .map(|(key, entry)| Ok(ModelOption { name: key.to_owned(), value: option_value(&entry)?, at: entry.at }))
        .collect::<Result<_, SceneError>>()?;
    Ok(ModelChoice { name: name.text()?.to_owned(), at: name.at, options, text: None })
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

fn written(section: &Section<'_>, equations: &Entry<'_>) -> Result<ModelChoice, SceneError> {
    if let Some(name) = section.get("name") {
        let message =
            "a model is either one of those that have a name, or its equations are written; remove one of both";
        return Err(name.error(Fault::Other(message.to_owned())));
    }
    let text = ModelText {
        equations: equations.words("a string, the equations")?,
        constants: constants(section)?,
        parameters: table(section, "parameters", parameter)?,
        start: table(section, "start", |name, entry| {
            Ok((name.to_owned(), entry.words("a number or an expression in quotes")?))
        })?,
        observables: table(section, "observables", observable)?,
        conserved: table(section, "conserved", |name, entry| {
            Ok((name.to_owned(), entry.words("an expression in quotes, such as \"x + y\"")?))
        })?,
        symmetry: match section.get("symmetry") {
            Some(entry) => Some(entry.words("a string such as \"x -> -x, y -> -y\"")?),
            None => None,
        },
        rotations: match section.get("rotations") {
            Some(entry) => {
                let example = "a list such as [\"x -> -y, y -> x\"]";
                let items = entry.list(example)?;
                items.iter().map(|item| item.words("a string such as \"x -> -y, y -> x\"")).collect::<Result<_, _>>()?
            }
            None => Vec::new(),
        },
        time_unit: match section.get("time_unit") {
            Some(entry) => entry.text()?.to_owned(),
            None => String::new(),
        },
    };
    let at = equations.at.clone();
    Ok(ModelChoice { name: "text".to_owned(), at, options: Vec::new(), text: Some(text) })
}

fn constants(section: &Section<'_>) -> Result<Vec<(String, i64, Place)>, SceneError> {
    let mut constants = Vec::new();
    for (key, entry) in section.entries().filter(|(key, _)| !TEXT_KEYS.contains(key)) {
        let Content::Integer(value) = entry.node.content else {
            // A short name is meant for a constant, a longer one for a key.
            if matches!(entry.node.content, Content::Number(_)) {
                let message = "must be a whole number; other numbers are parameters, in [model.parameters]";
                return Err(entry.error(Fault::Other(message.to_owned())));
            }
            return Err(entry.error(Fault::unknown("key of a model as text", key, TEXT_KEYS)));
        };
        constants.push((key.to_owned(), value, entry.at));
    }
    Ok(constants)
}

fn table<T>(
    section: &Section<'_>,
    key: &str,
    read: impl Fn(&str, Entry<'_>) -> Result<T, SceneError>,
) -> Result<Vec<T>, SceneError> {
    match section.get(key) {
        None => Ok(Vec::new()),
        Some(entry) => {
            let section = entry.section(&format!("a section, [model.{key}]"))?;
            section.entries().map(|(name, entry)| read(name, entry)).collect()
        }
    }
}

fn parameter(name: &str, entry: Entry<'_>) -> Result<TextParameter, SceneError> {
    let mut parameter = TextParameter {
        name: name.to_owned(),
        value: TextValue::Number(f64::NAN),
        unit: String::new(),
        meaning: String::new(),
        least: f64::NEG_INFINITY,
        most: f64::INFINITY,
        at: entry.at.clone(),
    };
    let value = |entry: &Entry<'_>| match entry.node.content {
        Content::Integer(_) | Content::Number(_) => entry.number().map(TextValue::Number),
        _ => entry.words("a number, an expression in quotes or { value = NUMBER }").map(TextValue::Tie),
    };
    let Ok(section) = entry.section("a table") else {
        parameter.value = value(&entry)?;
        return Ok(parameter);
    };
    section.allow("key of a parameter", &["value", "unit", "min", "max", "meaning"])?;
    parameter.value = value(&section.need("value", "value = NUMBER")?)?;
    for (key, text) in [("unit", &mut parameter.unit), ("meaning", &mut parameter.meaning)] {
        if let Some(entry) = section.get(key) {
            *text = entry.text()?.to_owned();
        }
    }
    for (key, end) in [("min", &mut parameter.least), ("max", &mut parameter.most)] {
        if let Some(entry) = section.get(key) {
            *end = entry.number()?;
        }
    }
    if parameter.least > parameter.most {
        let (from, to) = (parameter.least, parameter.most);
        return Err(entry.error(Fault::Range { from, to }));
    }
    Ok(parameter)
}

fn observable(name: &str, entry: Entry<'_>) -> Result<TextObservable, SceneError> {
    let Ok(section) = entry.section("a table") else {
        let expression = entry.words("an expression in quotes or { expression = \"...\", unit = \"...\" }")?;
        return Ok(TextObservable { name: name.to_owned(), expression, unit: String::new(), meaning: String::new() });
    };
    section.allow("key of an observable", &["expression", "unit", "meaning"])?;
    let text = |key: &str| section.get(key).map_or(Ok(String::new()), |entry| entry.text().map(str::to_owned));
    Ok(TextObservable {
        name: name.to_owned(),
        expression: section.need("expression", "expression = \"x^2 + y^2\"")?.words("an expression in quotes")?,
        unit: text("unit")?,
        meaning: text("meaning")?,
    })
}

impl Entry<'_> {
    /// A string with its place; a number counts as its digits.
    fn words(&self, expected: &str) -> Result<Words, SceneError> {
        let text = match &self.node.content {
            Content::Text(text) => text.clone(),
            Content::Integer(value) => value.to_string(),
            Content::Number(value) => format!("{:?}", self.finite(*value)?),
            _ => return self.type_error(expected),
        };
        Ok(Words { text, at: self.at.clone(), begins: self.node.begins })
    }
}
