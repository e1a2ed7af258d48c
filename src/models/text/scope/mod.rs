//! What the names of a text stand for, and expressions in them as vertices of the graph.

mod functions;

use crate::expression::{Function, Indices, Node, Operator, RESERVED, Statement, suggest};
use crate::models::text::graph::{Code, Graph, Id};
use crate::models::text::index::{Indexed, Whole, values};
use crate::models::text::{MAX_VERTICES, Wrong};
use functions::Own;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;

/// Deepest nesting of expressions, definitions and functions in each other: bounds the recursion.
const MAX_DEPTH: usize = 700;

/// A name with its elements: a scalar has one, without indices.
pub struct Symbol {
    pub indices: usize,
    pub cells: HashMap<Vec<i64>, Cell>,
}

/// What an element stands for.
#[derive(Clone, Debug)]
pub enum Cell {
    Unknown(usize),
    /// A definition: the statement and the values of its indices.
    Defined(usize, Indexed),
    /// A definition that is being worked out.
    Busy,
    Known(Id),
}

pub struct Scope<'a> {
    pub graph: Graph,
    statements: &'a [Statement],
    pub constants: &'a [(String, i64)],
    parameters: &'a [String],
    functions: BTreeMap<&'a str, Own<'a>>,
    pub symbols: BTreeMap<String, Symbol>,
    depth: usize,
    steps: usize,
}

/// Names that only a part of the text knows.
#[derive(Clone, Copy)]
pub struct Local<'b> {
    pub indices: &'b [(String, i64)],
    pub arguments: &'b [(&'b str, Id)],
}

impl<'b> Local<'b> {
    pub const NONE: Local<'static> = Local { indices: &[], arguments: &[] };

    pub fn indexed(indices: &'b Indexed) -> Self {
        Local { indices, arguments: &[] }
    }
}

impl<'a> Scope<'a> {
    pub fn new(statements: &'a [Statement], constants: &'a [(String, i64)], parameters: &'a [String]) -> Self {
        let (functions, symbols) = (BTreeMap::new(), BTreeMap::new());
        let graph = Graph::default();
        Self { graph, statements, constants, parameters, functions, symbols, depth: 0, steps: 0 }
    }

    pub fn whole(&self) -> Whole<'_> {
        Whole { constants: self.constants }
    }

    /// A new name must not have another meaning.
    pub fn check_free(&self, name: &str, at: usize) -> Result<(), Wrong> {
        let taken = if RESERVED.contains(&name) {
            Some("a word of the language")
        } else if Function::named(name).is_some() {
            Some("a function that is built in")
        } else if self.functions.contains_key(name) {
            Some("a function already")
        } else if self.parameters.iter().any(|known| known == name) {
            Some("a parameter already")
        } else if self.constants.iter().any(|(known, _)| known == name) {
            Some("a constant already")
        } else {
            None
        };
        match taken {
            None => Ok(()),
            Some(what) => Err(Wrong::new(at, format!("{name:?} is {what}; choose another name"))),
        }
    }

    /// An index may hide nothing.
    pub fn check_index(&self, range: &Indices) -> Result<(), Wrong> {
        self.check_free(&range.name, range.at.0)?;
        match self.symbols.get(&range.name) {
            None => Ok(()),
            Some(_) => {
                let message =
                    format!("{:?} is an unknown or a definition already; name the index otherwise", range.name);
                Err(Wrong::new(range.at.0, message))
            }
        }
    }

    /// Enters an element; none may be given twice.
    pub fn enter(&mut self, name: &str, element: Vec<i64>, cell: Cell, at: usize) -> Result<(), Wrong> {
        let shown = show(name, &element);
        let new = !self.symbols.contains_key(name);
        if new {
            self.check_free(name, at)?;
        }
        let indices = element.len();
        let symbol = self.symbols.entry(name.to_owned()).or_insert_with(|| Symbol { indices, cells: HashMap::new() });
        if symbol.indices != indices {
            let message = format!("{name:?} has {} indices elsewhere, but {indices} here", symbol.indices);
            return Err(Wrong::new(at, message));
        }
        match symbol.cells.insert(element, cell) {
            None => Ok(()),
            Some(Cell::Unknown(_)) => Err(Wrong::new(
                at,
                format!(
                    "{shown} is an unknown, given by its rate of change or by [model.start]; it cannot be defined as well"
                ),
            )),
            Some(_) => Err(Wrong::new(at, format!("{shown} is defined twice"))),
        }
    }

    /// An expression as a vertex.
    pub fn build(&mut self, node: &Node, local: Local<'_>) -> Result<Id, Wrong> {
        let at = match node {
            Node::Name(_, at) | Node::Element(_, _, at) | Node::Binary(.., at) | Node::Call(_, _, at) => at.0,
            Node::Apply(_, _, at) => at.0,
            _ => self.graph.at,
        };
        self.steps += 1;
        self.graph.site += 1;
        self.graph.at = at;
        if self.depth >= MAX_DEPTH {
            let message = "expressions, definitions and functions are nested too deeply in each other";
            return Err(Wrong::new(at, message.to_owned()));
        }
        if self.steps > 5 * MAX_VERTICES || self.graph.vertices.len() > MAX_VERTICES {
            let message = format!("the equations hold more than {MAX_VERTICES} operations; choose a smaller size");
            return Err(Wrong::new(at, message));
        }
        self.depth += 1;
        let id = self.build_inner(node, local);
        self.depth -= 1;
        id
    }

    fn build_inner(&mut self, node: &Node, local: Local<'_>) -> Result<Id, Wrong> {
        Ok(match node {
            Node::Number(value) => self.graph.constant(*value),
            Node::Pi => self.graph.constant(PI),
            Node::Name(name, at) => self.name(name, at.0, local)?,
            Node::Element(name, indices, at) => self.element(name, indices, at.0, local)?,
            Node::Rate(inner) => self.rate(inner, local)?,
            Node::Negate(inner) => {
                let inner = self.build(inner, local)?;
                self.graph.unary(Code::Negate, inner)
            }
            Node::Call(function, inner, at) => {
                let inner = self.build(inner, local)?;
                self.graph.at = at.0;
                self.graph.unary(Code::Call(*function), inner)
            }
            Node::Binary(operator, left, right, at) => {
                let (left, right) = (self.build(left, local)?, self.build(right, local)?);
                let code = match operator {
                    Operator::Add => Code::Add,
                    Operator::Subtract => Code::Subtract,
                    Operator::Multiply => Code::Multiply,
                    Operator::Divide => Code::Divide,
                    Operator::Power => Code::Power,
                };
                self.graph.at = at.0;
                self.graph.binary(code, left, right)
            }
            Node::Apply(name, arguments, at) => self.apply(name, arguments, *at, local)?,
            Node::Sum(body, indices) => {
                let (first, last) = self.whole().range(indices, local.indices)?;
                self.check_index(indices)?;
                let mut terms = Vec::new();
                let mut inner: Indexed = local.indices.to_vec();
                inner.push((indices.name.clone(), 0));
                let site = self.graph.site;
                for i in first..=last {
                    self.graph.site = site;
                    if let Some(last) = inner.last_mut() {
                        last.1 = i;
                    }
                    terms.push(self.build(body, Local { indices: &inner, ..local })?);
                }
                self.total(terms)
            }
        })
    }

    /// By halves, which keeps the levels few and the rounding small.
    fn total(&mut self, mut terms: Vec<Id>) -> Id {
        while terms.len() > 1 {
            let half = terms.len().div_ceil(2);
            self.graph.site += 1;
            for i in half..terms.len() {
                terms[i - half] = self.graph.binary(Code::Add, terms[i - half], terms[i]);
            }
            terms.truncate(half);
        }
        match terms.first() {
            Some(&sum) => sum,
            None => self.graph.constant(0.0),
        }
    }

    fn name(&mut self, name: &str, at: usize, local: Local<'_>) -> Result<Id, Wrong> {
        if let Some((_, id)) = local.arguments.iter().find(|(known, _)| *known == name) {
            return Ok(*id);
        }
        let index = local.indices.iter().rev().find(|(known, _)| known == name);
        if let Some((_, value)) = index.or_else(|| self.constants.iter().find(|(known, _)| known == name)) {
            return Ok(self.graph.constant(*value as f64));
        }
        if let Some(i) = self.parameters.iter().position(|known| known == name) {
            return Ok(self.graph.parameter(i));
        }
        match self.symbols.get(name) {
            Some(Symbol { indices: 0, .. }) => self.cell(name, Vec::new(), at),
            Some(symbol) => Err(Wrong::new(at, format!("{name} is an array; write {}", example(name, symbol.indices)))),
            None => Err(self.unknown_name(name, at, local)),
        }
    }

    fn unknown_name(&self, name: &str, at: usize, local: Local<'_>) -> Wrong {
        let known: Vec<&str> = (local.arguments.iter().map(|(name, _)| *name))
            .chain(local.indices.iter().map(|(name, _)| name.as_str()))
            .chain(self.symbols.keys().map(String::as_str))
            .chain(self.parameters.iter().map(String::as_str))
            .chain(self.constants.iter().map(|(name, _)| name.as_str()))
            .collect();
        let advice = match suggest(name, known.iter().copied()) {
            Some(meant) => format!("did you mean {meant:?}?"),
            None if name == "t" => "time cannot enter: write the forcing as an oscillator of its own".to_owned(),
            None => format!(
                "known are {}; an unknown whose rate of change does not occur needs a value in [model.start]",
                if known.is_empty() { "none".to_owned() } else { known.join(", ") }
            ),
        };
        Wrong::new(at, format!("unknown name {name:?}; {advice}"))
    }

    fn element(&mut self, name: &str, indices: &[Node], at: usize, local: Local<'_>) -> Result<Id, Wrong> {
        let element = self.locate(name, indices, at, local)?;
        self.cell(name, element, at)
    }

    /// The indices of an element of a known array.
    fn locate(&self, name: &str, indices: &[Node], at: usize, local: Local<'_>) -> Result<Vec<i64>, Wrong> {
        match self.symbols.get(name) {
            Some(symbol) if symbol.indices == indices.len() => values(&self.whole(), indices, local.indices),
            Some(symbol) if symbol.indices == 0 => Err(Wrong::new(at, format!("{name} is not an array"))),
            Some(symbol) => Err(Wrong::new(
                at,
                format!("{name} has {} indices; write {}", symbol.indices, example(name, symbol.indices)),
            )),
            None => Err(self.unknown_name(name, at, local)),
        }
    }

    fn rate(&mut self, inner: &Node, local: Local<'_>) -> Result<Id, Wrong> {
        let (name, indices, at) = match inner {
            Node::Name(name, at) => (name, &[][..], at.0),
            Node::Element(name, indices, at) => (name, &indices[..], at.0),
            _ => return Err(Wrong::new(self.graph.at, "only unknowns have rates of change".to_owned())),
        };
        let element = self.locate(name, indices, at, local)?;
        match self.symbols.get(name).and_then(|symbol| symbol.cells.get(&element)) {
            Some(Cell::Unknown(i)) => Ok(self.graph.rate(*i)),
            _ => Err(Wrong::new(at, format!("{} is no unknown: it has no rate of change", show(name, &element)))),
        }
    }

    /// An element of a known name; a definition is worked out when it is first used.
    pub fn cell(&mut self, name: &str, element: Vec<i64>, at: usize) -> Result<Id, Wrong> {
        let Some(symbol) = self.symbols.get_mut(name) else {
            return Err(Wrong::new(at, format!("unknown name {name:?}")));
        };
        let Some(cell) = symbol.cells.get_mut(&element) else {
            return Err(self.missing(name, &element, at));
        };
        match cell {
            Cell::Unknown(i) => {
                let i = *i;
                Ok(self.graph.unknown(i))
            }
            Cell::Known(id) => Ok(*id),
            Cell::Busy => Err(Wrong::new(at, format!("{} is defined by itself", show(name, &element)))),
            Cell::Defined(statement, indices) => {
                let (statement, indices) = (*statement, std::mem::take(indices));
                *cell = Cell::Busy;
                let site = self.graph.site;
                self.begin(statement);
                let statements = self.statements;
                let id = self.build(&statements[statement].right, Local::indexed(&indices))?;
                (self.graph.site, self.graph.at) = (site, at);
                if let Some(cell) = self.symbols.get_mut(name).and_then(|symbol| symbol.cells.get_mut(&element)) {
                    *cell = Cell::Known(id);
                }
                Ok(id)
            }
        }
    }

    /// From here on vertices come from this statement.
    pub fn begin(&mut self, statement: usize) {
        self.graph.site = (statement as u64 + 1) << 32;
        self.graph.at = self.statements[statement].start;
    }

    fn missing(&self, name: &str, element: &[i64], at: usize) -> Wrong {
        let shown = show(name, element);
        let keys = || self.symbols.get(name).into_iter().flat_map(|symbol| symbol.cells.keys());
        let (first, last) = (keys().min(), keys().max());
        let known = match (first, last) {
            (Some(first), Some(last)) => format!("{} to {}", show(name, first), show(name, last)),
            _ => "none".to_owned(),
        };
        Wrong::new(
            at,
            format!(
                "{shown} is not defined, only {known}; give a neighbour beyond the ends a value, such as {shown} = 0"
            ),
        )
    }
}

/// `x`, `u[3]`, `w[1, 2]`
pub fn show(name: &str, element: &[i64]) -> String {
    if element.is_empty() {
        return name.to_owned();
    }
    let indices: Vec<String> = element.iter().map(i64::to_string).collect();
    format!("{name}[{}]", indices.join(", "))
}

fn example(name: &str, indices: usize) -> String {
    match indices {
        0 => name.to_owned(),
        1 => format!("{name}[i]"),
        _ => format!("{name}[{}]", vec!["i"; indices].join(", ")),
    }
}
