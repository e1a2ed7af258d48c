//! What a scene's `[model]` table says beside the name.

use std::collections::BTreeMap;
use thiserror::Error;

/// The value of a model option.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    Integer(i64),
    Text(String),
}

#[derive(Debug, Error, PartialEq)]
pub enum ModelError {
    #[error("model.{key} must be {allowed}, not {found}")]
    Value { key: String, allowed: String, found: String },
}

/// Options by name; each `Model` says which it knows.
#[derive(Clone, Debug, Default)]
pub struct Options(pub BTreeMap<String, Choice>);

impl Options {
    /// One of named values; the first is the default.
    pub fn choice<T: Copy>(&self, key: &str, allowed: &[(&str, T)]) -> Result<T, ModelError> {
        let found = match self.0.get(key) {
            None => return Ok(allowed[0].1),
            Some(Choice::Text(text)) => text.clone(),
            Some(Choice::Integer(i)) => i.to_string(),
        };
        allowed.iter().find(|(name, _)| *name == found).map(|(_, value)| *value).ok_or_else(|| {
            let names: Vec<String> = allowed.iter().map(|(name, _)| format!("\"{name}\"")).collect();
            ModelError::Value { key: key.into(), allowed: names.join(" or "), found: format!("\"{found}\"") }
        })
    }

    /// A whole number in a range.
    pub fn integer(&self, key: &str, default: usize, least: usize, most: usize) -> Result<usize, ModelError> {
        let error = |found: String| ModelError::Value {
            key: key.into(),
            allowed: format!("a whole number from {least} to {most}"),
            found,
        };
        match self.0.get(key) {
            None => Ok(default),
            Some(Choice::Integer(i)) => {
                usize::try_from(*i).ok().filter(|i| (least..=most).contains(i)).ok_or_else(|| error(i.to_string()))
            }
            Some(Choice::Text(text)) => Err(error(format!("\"{text}\""))),
        }
    }

    /// A number in a range.
    pub fn number(&self, key: &str, default: f64, least: f64, most: f64) -> Result<f64, ModelError> {
        let (found, value) = match self.0.get(key) {
            None => return Ok(default),
            Some(Choice::Integer(i)) => (i.to_string(), Some(*i as f64)),
            Some(Choice::Text(text)) => match text.parse() {
                Ok(value) => (text.clone(), Some(value)),
                Err(_) => (format!("\"{text}\""), None),
            },
        };
        value.filter(|value| (least..=most).contains(value)).ok_or_else(|| ModelError::Value {
            key: key.into(),
            allowed: format!("a number from {least} to {most}"),
            found,
        })
    }

    /// Refuses options that mean something only with another choice.
    pub fn absent(&self, keys: &[&str], only: &str) -> Result<(), ModelError> {
        let found = keys.iter().find_map(|key| self.0.get(*key).map(|value| (key, value)));
        found.map_or(Ok(()), |(key, value)| {
            let found = match value {
                Choice::Integer(i) => i.to_string(),
                Choice::Text(text) => text.clone(),
            };
            Err(ModelError::Value { key: (*key).into(), allowed: format!("left out without {only}"), found })
        })
    }
}
