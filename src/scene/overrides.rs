//! `--set KEY=VALUE`: single values laid over the scene, before it is checked as if written so.

use super::tree::{self, Content, Node, Table};
use super::{Fault, SceneError};

/// One `--set` argument, taken apart.
#[derive(Clone, Debug)]
pub(super) struct Override {
    argument: String,
    /// "task", "beat", "range"
    path: Vec<String>,
    value: Node,
}

/// Longest path; `task.beat.values.p` has four parts.
const MAX_PARTS: usize = 8;

const ROOTS: [&str; 6] = ["title", "budget", "model", "parameters", "task", "figure"];

impl Override {
    pub fn parse(argument: &str) -> Result<Override, SceneError> {
        let refuse = |fault| SceneError::Override { argument: argument.to_owned(), fault };
        let (key, value) = argument.split_once('=').ok_or_else(|| refuse(Fault::NotAnAssignment))?;
        let path = path(key).map_err(refuse)?;
        let value = value.trim();
        if value.is_empty() {
            let key = key.trim().to_owned();
            return Err(refuse(Fault::NoValue { key }));
        }
        Ok(Override { argument: argument.to_owned(), path, value: read_value(value).map_err(refuse)? })
    }

    /// An entry of a file that changes another one, `"task.beat.degree" = 4`; here another model may take the whole place of
    /// one.
    pub fn entry(key: &str, value: &Node) -> Result<Override, Fault> {
        let path = if key == "model" { vec![key.to_owned()] } else { path(key)? };
        Ok(Override { argument: key.to_owned(), path, value: value.clone() })
    }

    /// Key and value, for people.
    pub fn words(&self) -> (String, String) {
        (self.path.join("."), self.value.content.written())
    }

    /// What is wrong with the argument.
    pub fn refuse(&self, fault: Fault) -> SceneError {
        SceneError::Override { argument: self.argument.clone(), fault }
    }

    /// Whether the model's numbers change, so that expectations need not hold any more.
    pub fn touches_model(&self) -> bool {
        matches!(self.path.first().map(String::as_str), Some("model" | "parameters"))
    }

    pub fn apply(&self, scene: &mut Table) -> Result<(), Fault> {
        match self.path.as_slice() {
            [root, name, rest @ ..] if root == "task" || root == "figure" => {
                let what = if root == "task" { "task" } else { "figure" };
                named(scene, what, name).and_then(|table| put(table, rest, &self.value))
            }
            path => put(scene, path, &self.value),
        }
    }
}

/// The argument that an entry without a line comes from: the last one at, above or below its key.
pub(super) fn behind(arguments: &[String], key: &str) -> Option<String> {
    let is_above = |above: &str, below: &str| {
        below.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
    };
    let touches = |argument: &&String| {
        argument.split_once('=').is_some_and(|(path, _)| {
            let path = split(path).join(".");
            is_above(&path, key) || is_above(key, &path)
        })
    };
    arguments.iter().rev().find(touches).cloned()
}

/// `task.beat.range` into its parts.
fn split(key: &str) -> Vec<&str> {
    key.split('.').map(str::trim).collect()
}

/// The parts of a key that may be overridden.
fn path(key: &str) -> Result<Vec<String>, Fault> {
    let path = split(key);
    if path.contains(&"") {
        return Err(Fault::EmptyKey);
    }
    check_path(&path)?;
    Ok(path.into_iter().map(str::to_owned).collect())
}

fn check_path(path: &[&str]) -> Result<(), Fault> {
    match path {
        _ if path.len() > MAX_PARTS => Err(Fault::NotOverridable { key: path.join(".") }),
        ["title" | "budget"] | ["model" | "parameters", _, ..] => Ok(()),
        ["task" | "figure", _, key, ..] if *key != "name" => Ok(()),
        [root, ..] if !ROOTS.contains(root) && *root != "expect" => Err(Fault::unknown("section", root, ROOTS)),
        _ => Err(Fault::NotOverridable { key: path.join(".") }),
    }
}

/// A TOML value, or a bare string where the text does not even look like one: `tau/200`, `distal`.
fn read_value(text: &str) -> Result<Node, Fault> {
    match tree::value(text) {
        // A date is not a value that scenes know: 2026-01-01 is meant as text.
        Ok(Node { content: Content::Date(_), .. }) => Ok(bare(text)),
        Ok(node) => Ok(node),
        Err(message) if text.starts_with(['"', '\'', '[', '{']) => Err(Fault::Value { message }),
        Err(_) => Ok(bare(text)),
    }
}

fn bare(text: &str) -> Node {
    Node::set(Content::Text(text.to_owned()))
}

/// The `[[task]]` or `[[figure]]` of the given name.
fn named<'a>(scene: &'a mut Table, what: &'static str, name: &str) -> Result<&'a mut Table, Fault> {
    let mut tables = match scene.get_mut(what) {
        Some(Node { content: Content::List(items), .. }) => items
            .iter_mut()
            .filter_map(|item| match &mut item.content {
                Content::Table(table) => Some(table),
                _ => None,
            })
            .collect(),
        _ => Vec::new(),
    };
    match tables.iter().position(|table| name_of(table) == Some(name)) {
        Some(at) => Ok(tables.swap_remove(at)),
        None => {
            let known = tables.iter().filter_map(|table| name_of(table));
            Err(Fault::unknown(what, name, known))
        }
    }
}

fn name_of(table: &Table) -> Option<&str> {
    match table.get("name") {
        Some(Node { content: Content::Text(name), .. }) => Some(name),
        _ => None,
    }
}

/// Sets the value at the path, making the tables above it where they are missing.
fn put(table: &mut Table, path: &[String], value: &Node) -> Result<(), Fault> {
    let Some((key, rest)) = path.split_first() else {
        return Ok(());
    };
    if rest.is_empty() {
        table.set(key, value.clone());
        return Ok(());
    }
    if table.get(key).is_none() {
        let content = Content::Table(Table::default());
        table.set(key, Node::set(content));
    }
    match table.get_mut(key).map(|node| &mut node.content) {
        Some(Content::Table(inner)) => put(inner, rest, value),
        Some(other) => {
            Err(Fault::Type { expected: format!("a table for {}", path.join(".")), found: other.describe() })
        }
        None => Ok(()),
    }
}
