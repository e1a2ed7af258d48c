//! A TOML document as plain data that remembers lines. Not serde: an own tree lets `--set` and the file feed one
//! reader, and lets every message name line, key and allowed values.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::SceneError;

/// A value and the line it stands on (that of its key in a table; None if it comes from `--set`).
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub line: Option<usize>,
    /// Line and column at which a string begins, where the file has it letter by letter, without escapes.
    pub begins: Option<(usize, usize)>,
    pub content: Content,
}

impl Node {
    /// One that is in no file.
    pub fn set(content: Content) -> Node {
        Node { line: None, begins: None, content }
    }
}

#[derive(Clone, Debug)]
pub(super) enum Content {
    Text(String),
    Integer(i64),
    Number(f64),
    Flag(bool),
    /// A date or time, which no entry of a scene takes.
    Date(String),
    List(Vec<Node>),
    Table(Table),
}

/// Entries in the order of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    pub entries: Vec<(String, Node)>,
}

impl Table {
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.entries.iter().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    pub fn get_mut(&mut self, key: &str) -> Option<&mut Node> {
        self.entries.iter_mut().find(|(name, _)| name == key).map(|(_, node)| node)
    }

    pub fn set(&mut self, key: &str, node: Node) {
        match self.get_mut(key) {
            Some(old) => *old = node,
            None => self.entries.push((key.to_owned(), node)),
        }
    }
}

impl Content {
    /// For messages: the kind of value and, where it is short, the value.
    pub fn describe(&self) -> String {
        match self {
            Content::Text(text) if text.chars().count() <= 60 => format!("the string {text:?}"),
            Content::Text(_) => "a long string".to_owned(),
            Content::Integer(value) => format!("the whole number {value}"),
            Content::Number(value) => format!("the number {value:?}"),
            Content::Flag(value) => format!("{value}"),
            Content::Date(text) => format!("the date or time {text}"),
            Content::List(items) => format!("a list of {}", items.len()),
            Content::Table(_) => "a table".to_owned(),
        }
    }
}

impl Content {
    /// The value as a file has it.
    pub fn written(&self) -> String {
        match self {
            Content::Text(text) => text.clone(),
            Content::Integer(value) => value.to_string(),
            Content::Number(value) if *value != 0.0 && !(1e-3..1e6).contains(&value.abs()) => format!("{value:e}"),
            Content::Number(value) => value.to_string(),
            Content::Flag(value) => value.to_string(),
            Content::Date(text) => text.clone(),
            Content::List(items) => {
                let items: Vec<String> = items.iter().map(|item| item.content.written()).collect();
                format!("[{}]", items.join(", "))
            }
            Content::Table(table) => {
                let entries = table.entries.iter().map(|(key, node)| format!("{key} = {}", node.content.written()));
                format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
            }
        }
    }
}

/// Reads a document.
pub(super) fn document(text: &str, path: &Path) -> Result<Table, SceneError> {
    let lines = Lines::new(text);
    let refuse = |offset: usize, message: String| SceneError::Syntax {
        path: path.to_owned(),
        line: lines.line(offset),
        column: lines.column(text, offset),
        message,
    };
    let place = Locator { text, lines: &lines };
    let table = DeTable::parse(text).map_err(|error| {
        let offset = error.span().map_or(text.len(), |span| span.start);
        refuse(offset, error.message().to_owned())
    })?;
    convert_table(table.get_ref(), Some(&place)).map_err(|(offset, message)| refuse(offset, message))
}

/// Reads one value, as `--set` gives it.
pub(super) fn value(text: &str) -> Result<Node, String> {
    let value = DeValue::parse(text).map_err(|error| error.message().to_owned())?;
    convert(&value, None).map_err(|(_, message)| message)
}

/// Where things stand in a file.
struct Locator<'a> {
    text: &'a str,
    lines: &'a Lines,
}

impl Locator<'_> {
    /// Where the content of a string begins, if the file has it letter by letter.
    fn begins(&self, span: Range<usize>, content: &str) -> Option<(usize, usize)> {
        let raw = self.text.get(span.clone())?;
        let quotes = ["\"\"\"\n", "'''\n", "\"\"\"", "'''", "\"", "'"];
        let quote = quotes.iter().find(|quote| raw.starts_with(**quote))?;
        let start = span.start + quote.len();
        let verbatim = raw.get(quote.len()..)?.starts_with(content);
        verbatim.then(|| (self.lines.line(start), self.lines.column(self.text, start)))
    }
}

/// The recursion is bounded: `toml` refuses documents nested deeper than 80.
fn convert(value: &Spanned<DeValue<'_>>, place: Option<&Locator<'_>>) -> Result<Node, (usize, String)> {
    let start = value.span().start;
    let content = match value.get_ref() {
        DeValue::String(text) => Content::Text(text.to_string()),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).map(Content::Integer).map_err(|_| {
                (
                    start,
                    format!("{integer} is too large for a whole number; write it with a decimal point or an exponent"),
                )
            })?
        }
        DeValue::Float(float) => {
            float.as_str().parse().map(Content::Number).map_err(|_| (start, format!("{float} is not a number")))?
        }
        DeValue::Boolean(flag) => Content::Flag(*flag),
        DeValue::Datetime(date) => Content::Date(date.to_string()),
        DeValue::Array(items) => {
            Content::List(items.iter().map(|item| convert(item, place)).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => Content::Table(convert_table(table, place)?),
    };
    let begins = match (&content, place) {
        (Content::Text(text), Some(place)) => place.begins(value.span(), text),
        _ => None,
    };
    Ok(Node { line: place.map(|place| place.lines.line(start)), begins, content })
}

fn convert_table(table: &DeTable<'_>, place: Option<&Locator<'_>>) -> Result<Table, (usize, String)> {
    let mut entries = Vec::with_capacity(table.len());
    for (key, value) in table.iter() {
        let mut node = convert(value, place)?;
        node.line = place.map(|place| place.lines.line(key.span().start));
        entries.push((key.get_ref().to_string(), node));
    }
    Ok(Table { entries })
}

/// Where lines start, to turn offsets into line numbers.
struct Lines {
    starts: Vec<usize>,
}

impl Lines {
    fn new(text: &str) -> Lines {
        let after_breaks = text.match_indices('\n').map(|(at, _)| at + 1);
        Lines { starts: std::iter::once(0).chain(after_breaks).collect() }
    }

    /// 1-based.
    fn line(&self, offset: usize) -> usize {
        self.starts.partition_point(|&start| start <= offset)
    }

    /// 1-based, in characters.
    fn column(&self, text: &str, offset: usize) -> usize {
        let start = self.starts.iter().rfind(|&&start| start <= offset);
        let before = start.and_then(|&start| text.get(start..offset.min(text.len())));
        before.map_or(0, |before| before.chars().count()) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_keep_their_lines_and_order() {
        let table = document("b = 1\n\n[a]\nz = [1,\n 2]\ny.w = 2\n[[t]]\n[[t]]\n", Path::new("s")).expect("valid");
        let keys: Vec<&str> = table.entries.iter().map(|(key, _)| key.as_str()).collect();
        assert_eq!(keys, ["b", "a", "t"]);
        let line = |key| table.get(key).and_then(|node| node.line);
        assert_eq!((line("b"), line("a"), line("t")), (Some(1), Some(3), Some(7)));
        let Some(Node { content: Content::Table(a), .. }) = table.get("a") else {
            panic!("a is a table");
        };
        assert_eq!(a.get("y").and_then(|node| node.line), Some(6));
        let Some(Node { content: Content::List(t), .. }) = table.get("t") else {
            panic!("t is a list");
        };
        let lines: Vec<Option<usize>> = t.iter().map(|node| node.line).collect();
        assert_eq!(lines, [Some(7), Some(8)]);
    }

    #[test]
    fn syntax_errors_name_line_and_column() {
        for (text, expected) in [
            ("title = \"a\"\nx = [1,\n", "s.toml:2:8: not valid TOML: unclosed array"),
            ("a = 1\na = 2", "s.toml:2:1: not valid TOML: duplicate key"),
            ("é = \"\"\n", "s.toml:1:1: not valid TOML: invalid unquoted key"),
            ("a = 99999999999999999999", "s.toml:1:5: not valid TOML: 99999999999999999999 is too large"),
            (&"[".repeat(1000), "s.toml:1:"),
        ] {
            let error = document(text, Path::new("s.toml")).expect_err("must be refused");
            assert!(error.to_string().starts_with(expected), "{error}");
        }
    }
}
