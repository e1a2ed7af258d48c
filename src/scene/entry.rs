//! Typed access to the entries of a scene, with errors that name the entry.

use std::ops::RangeInclusive;
use std::path::Path;

use super::tree::{Content, Node, Table};
use super::{EntryError, Fault, Place, SceneError, overrides};

/// Where entries come from: the file, and the `--set` arguments laid over it.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    pub sets: &'a [String],
}

impl Source<'_> {
    pub fn error(&self, at: Place, fault: Fault) -> SceneError {
        let argument = match at.line {
            Some(_) => None,
            None => overrides::behind(self.sets, &at.key),
        };
        SceneError::Entry(Box::new(EntryError { path: self.path.to_owned(), at, argument, fault }))
    }
}

/// One value, and where it stands.
pub(super) struct Entry<'a> {
    pub source: &'a Source<'a>,
    pub node: &'a Node,
    pub at: Place,
}

/// A table, and where it stands.
pub(super) struct Section<'a> {
    pub source: &'a Source<'a>,
    pub table: &'a Table,
    pub at: Place,
}

type Found<T> = Result<T, SceneError>;

impl<'a> Entry<'a> {
    pub fn error(&self, fault: Fault) -> SceneError {
        self.source.error(self.at.clone(), fault)
    }

    pub fn type_error<T>(&self, expected: &str) -> Found<T> {
        Err(self.error(Fault::Type { expected: expected.to_owned(), found: self.node.content.describe() }))
    }

    pub fn text(&self) -> Found<&'a str> {
        match &self.node.content {
            Content::Text(text) => Ok(text),
            _ => self.type_error("a string"),
        }
    }

    pub fn flag(&self) -> Found<bool> {
        match self.node.content {
            Content::Flag(flag) => Ok(flag),
            _ => self.type_error("true or false"),
        }
    }

    /// A finite number; whole numbers count.
    pub fn number(&self) -> Found<f64> {
        match self.node.content {
            Content::Integer(value) => Ok(value as f64),
            Content::Number(value) => self.finite(value),
            _ => self.type_error("a number"),
        }
    }

    pub fn finite(&self, value: f64) -> Found<f64> {
        if value.is_finite() {
            Ok(value)
        } else {
            let found = format!("{value}");
            Err(self.error(Fault::NotFinite { found }))
        }
    }

    pub fn positive(&self) -> Found<f64> {
        let value = self.number()?;
        if value > 0.0 {
            Ok(value)
        } else {
            Err(self
                .error(Fault::OutOfBounds { found: format!("{value}"), allowed: "numbers greater than 0".to_owned() }))
        }
    }

    /// A whole number within bounds.
    pub fn count(&self, allowed: RangeInclusive<usize>) -> Found<usize> {
        let (least, most) = (*allowed.start(), *allowed.end());
        match self.node.content {
            Content::Integer(value) => {
                usize::try_from(value).ok().filter(|count| allowed.contains(count)).ok_or_else(|| {
                    self.error(Fault::OutOfBounds {
                        found: value.to_string(),
                        allowed: format!("whole numbers from {least} to {most}"),
                    })
                })
            }
            _ => self.type_error(&format!("a whole number from {least} to {most}")),
        }
    }

    /// One of the words.
    pub fn choice(&self, what: &'static str, words: &[&'static str]) -> Found<&'static str> {
        let found = self.text()?;
        words
            .iter()
            .find(|word| **word == found)
            .copied()
            .ok_or_else(|| self.error(Fault::unknown(what, found, words.iter().copied())))
    }

    pub fn list(&self, expected: &str) -> Found<Vec<Entry<'a>>> {
        let Content::List(items) = &self.node.content else {
            return self.type_error(expected);
        };
        let items = items.iter().enumerate().map(|(i, node)| Entry {
            source: self.source,
            node,
            at: Place { key: format!("{}[{}]", self.at.key, i + 1), line: node.line },
        });
        Ok(items.collect())
    }

    /// Strings, none twice.
    pub fn texts(&self) -> Found<Vec<String>> {
        let mut texts: Vec<String> = Vec::new();
        for item in self.list("a list of strings")? {
            let text = item.text()?;
            if texts.iter().any(|known| known == text) {
                let found = format!("{text:?}");
                return Err(item.error(Fault::Repeated { found }));
            }
            texts.push(text.to_owned());
        }
        Ok(texts)
    }

    pub fn section(&self, expected: &str) -> Found<Section<'a>> {
        match &self.node.content {
            Content::Table(table) => Ok(Section { source: self.source, table, at: self.at.clone() }),
            _ => self.type_error(expected),
        }
    }
}

impl<'a> Section<'a> {
    pub fn error(&self, fault: Fault) -> SceneError {
        self.source.error(self.at.clone(), fault)
    }

    /// Refuses keys that are not among the allowed ones; `what` says what kind of key.
    pub fn allow(&self, what: &'static str, allowed: &[&str]) -> Found<()> {
        match self.entries().find(|(key, _)| !allowed.contains(key)) {
            None => Ok(()),
            Some((key, entry)) => {
                let fault = Fault::unknown(what, key, allowed.iter().copied());
                Err(entry.error(fault))
            }
        }
    }

    pub fn get(&self, key: &str) -> Option<Entry<'a>> {
        self.table.get(key).map(|node| self.entry(key, node))
    }

    /// The entry, or an error that shows an example of it.
    pub fn need(&self, key: &str, example: &str) -> Found<Entry<'a>> {
        self.get(key)
            .ok_or_else(|| self.error(Fault::Missing { what: format!("the key {key:?}"), example: example.to_owned() }))
    }

    pub fn entries(&self) -> impl Iterator<Item = (&'a str, Entry<'a>)> {
        self.table.entries.iter().map(|(key, node)| (key.as_str(), self.entry(key, node)))
    }

    fn entry(&self, key: &str, node: &'a Node) -> Entry<'a> {
        let key = match self.at.key.as_str() {
            "" => key.to_owned(),
            above => format!("{above}.{key}"),
        };
        Entry { source: self.source, node, at: Place { key, line: node.line } }
    }
}
