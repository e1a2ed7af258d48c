//! From a text to its model.

use super::formula::Text;
use super::graph::{Code, Id};
use super::index::values;
use super::intern::intern;
use super::linearisation::Linearisation;
use super::rows::{self, Row};
use super::scope::{Cell, Local, Scope, Symbol};
use super::tape::Tape;
use super::unknowns::{self, Unknowns, defines};
use super::{Part, TextError, Written, WrittenDefault, Wrong, conserved, symmetry};
use crate::expression::{Expression, Function, Node, RESERVED, Statement, statement, statements, suggest};
use crate::problem::{Bounds, Default, Observable, Parameter, Rotation};
use std::sync::Arc;

/// Up to so many unknowns are all observables by their names.
const SMALL: usize = 12;

/// Reads everything and checks it.
pub fn build(written: &Written) -> Result<Arc<Text>, TextError> {
    let declared = written.parameters.len();
    let written = &conserved::with_parameters(written);
    check_names(written)?;
    let text = statements(&written.equations).map_err(|wrong| TextError::in_equations(wrong.into()))?;
    if text.is_empty() {
        let message = "there is no equation; write one such as x' = -x".to_owned();
        return Err(TextError::in_equations(Wrong { offset: None, message }));
    }
    let names: Vec<String> = written.parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let mut scope = Scope::new(&text, &written.constants, &names);
    let starts = written.start.iter().map(read_start).collect::<Result<Vec<Statement>, TextError>>()?;
    functions(&mut scope, &text).map_err(TextError::in_equations)?;
    let unknowns = unknowns::find(&mut scope, &text, written, &starts)?;
    let n = unknowns.names.len();
    // Inputs first: the order of operands, and so the runs of the tape, follow that of the vertices.
    scope.graph.enter_inputs(n, names.len());
    define(&mut scope, &text).map_err(TextError::in_equations)?;
    let mut equations = equations(&mut scope, &text).map_err(TextError::in_equations)?;
    rows::dependencies(&scope.graph, &mut equations).map_err(TextError::in_equations)?;
    count(&unknowns, &equations, written)?;
    let mut rows = rows::assign(equations, n);
    let quantities = conserved::replace(&mut scope, (written, declared), &unknowns, &mut rows)?;
    let structure = rows::structure(&rows).map_err(TextError::in_equations)?;
    let start = start(&mut scope, &unknowns, written, &starts)?;
    let (observables, measures) = observables(&mut scope, &unknowns, written)?;
    let tape = |outputs: &[Id]| Tape::new(&scope.graph, &unknowns.order, names.len(), outputs);
    let ids: Vec<Id> = rows.iter().map(|row| row.id).collect();
    let mut text = Text {
        parameters: parameters(written)?,
        residual: tape(&ids),
        start: tape(&start),
        measures: measures.iter().map(|&id| tape(&[id])).collect(),
        observables,
        structure,
        linearisation: Linearisation::new(&scope.graph, &rows),
        reflection: None,
        rotations: Vec::new(),
        time_unit: intern(&written.time_unit),
        names: unknowns.names,
        start_names: written.start.iter().map(|(name, _)| name.clone()).collect(),
        rows,
        graph: scope.graph,
    };
    conserved::begin(&mut text, &unknowns.order, &quantities)?;
    let reflection = match &written.symmetry {
        None => None,
        Some(symmetry) => {
            let read = symmetry::read(&text, symmetry, &written.constants);
            Some(read.map_err(|wrong| TextError { part: Part::Symmetry, wrong })?)
        }
    };
    let rotations = written.rotations.iter().enumerate().map(|(k, rotation)| {
        let read = symmetry::rotation(&text, rotation, &written.constants);
        read.map_err(|wrong| TextError { part: Part::Rotation(k), wrong })
    });
    let rotations: Vec<Rotation> = rotations.collect::<Result<_, _>>()?;
    if let Some(k) = (1..rotations.len()).find(|&k| rotations[..k].iter().any(|other| !other.commutes(&rotations[k]))) {
        let message =
            "rotations must commute; this one does not with one before it, or turns the same pairs".to_owned();
        return Err(TextError { part: Part::Rotation(k), wrong: Wrong { offset: None, message } });
    }
    Ok(Arc::new(Text { reflection, rotations, ..text }))
}

/// Keys of the scene that are to be names in expressions must look like names.
fn check_names(written: &Written) -> Result<(), TextError> {
    let parameters = written.parameters.iter().map(|p| (&p.name, Part::Parameter(p.name.clone())));
    let constants = written.constants.iter().map(|(name, _)| (name, Part::Constant(name.clone())));
    for (name, part) in parameters.chain(constants) {
        let wrong = |message: String| Err(TextError { part: part.clone(), wrong: Wrong { offset: None, message } });
        let begins = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
        if !begins || !name.chars().all(|c| c.is_alphanumeric() || c == '_') {
            return wrong(format!("{name:?} cannot be a name; use letters, digits and \"_\", a letter first"));
        }
        if Function::named(name).is_some() || RESERVED.contains(&name.as_str()) {
            return wrong(format!("{name:?} has a meaning of its own in expressions; choose another name"));
        }
        if written.reserved.contains(name) {
            return wrong(format!("{name:?} is the name of a column of the results; choose another name"));
        }
        if matches!(part, Part::Constant(_)) && written.parameters.iter().any(|p| p.name == *name) {
            return wrong(format!("{name:?} is a parameter, too; choose another name"));
        }
    }
    Ok(())
}

fn functions<'a>(scope: &mut Scope<'a>, text: &'a [Statement]) -> Result<(), Wrong> {
    for statement in text {
        match &statement.left {
            Node::Apply(name, arguments, at) => {
                if let Some(range) = statement.ranges.first() {
                    return Err(Wrong::new(range.at.0, "a function has arguments, not an index".to_owned()));
                }
                scope.define_function((name, at.0), arguments, &statement.right)?;
            }
            Node::Call(function, ..) => {
                let name = function.name();
                let message =
                    format!("{name} is built in; choose another name for a function, or write an equation as 0 = ...");
                return Err(Wrong::new(statement.start, message));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Enters all definitions and works them out.
fn define(scope: &mut Scope<'_>, text: &[Statement]) -> Result<(), Wrong> {
    let mut elements = Vec::new();
    for (s, statement) in text.iter().enumerate() {
        let (name, indices, at) = match &statement.left {
            Node::Name(name, at) => (name, &[][..], at.0),
            Node::Element(name, indices, at) => (name, &indices[..], at.0),
            _ => continue,
        };
        for local in scope.whole().all(&statement.ranges)? {
            let element = values(&scope.whole(), indices, &local)?;
            scope.enter(name, element.clone(), Cell::Defined(s, local), at)?;
            elements.push((name, element, at));
        }
    }
    for statement in text {
        statement.ranges.iter().try_for_each(|range| scope.check_index(range))?;
    }
    scope.try_functions()?;
    elements.into_iter().try_for_each(|(name, element, at)| scope.cell(name, element, at).map(drop))
}

/// `left - right` of every equation.
fn equations(scope: &mut Scope<'_>, text: &[Statement]) -> Result<Vec<Row>, Wrong> {
    let mut rows = Vec::new();
    for (s, statement) in text.iter().enumerate() {
        if defines(&statement.left).is_some() {
            continue;
        }
        for local in scope.whole().all(&statement.ranges)? {
            scope.begin(s);
            let left = scope.build(&statement.left, Local::indexed(&local))?;
            let right = scope.build(&statement.right, Local::indexed(&local))?;
            scope.graph.at = statement.start;
            let id = scope.graph.binary(Code::Subtract, left, right);
            let placed = scope.graph.vertices[id as usize];
            if placed.degree > 1 {
                let message = "rates of change must enter linearly, as in M(u, p) u' = F(u, p)".to_owned();
                return Err(Wrong::new(statement.start, message));
            }
            if !placed.moves {
                let message = format!("this equation holds no unknown: {} = {}", statement.left, statement.right);
                return Err(Wrong::new(statement.start, message));
            }
            rows.push(Row { id, at: statement.start, unknowns: Vec::new(), rates: Vec::new() });
        }
    }
    Ok(rows)
}

/// As many equations as unknowns, and none of the unknowns of [model.start] alone.
fn count(unknowns: &Unknowns, rows: &[Row], written: &Written) -> Result<(), TextError> {
    for &(i, entry) in &unknowns.algebraic {
        if rows.iter().all(|row| row.unknowns.binary_search(&(i as u32)).is_err()) {
            let name = &unknowns.names[i];
            let others: Vec<&str> = unknowns.names.iter().filter(|known| *known != name).map(String::as_str).collect();
            let advice = match suggest(name, others.iter().copied()) {
                Some(meant) => format!("did you mean {meant:?}?"),
                None => format!("unknowns are {}", shorten(&others)),
            };
            let message = format!("{name} occurs in no equation; {advice}");
            return Err(TextError {
                part: Part::Start(written.start[entry].0.clone()),
                wrong: Wrong { offset: None, message },
            });
        }
    }
    let n = unknowns.names.len();
    if rows.len() == n {
        return Ok(());
    }
    let names: Vec<&str> = unknowns.names.iter().map(String::as_str).collect();
    let trouble = if rows.len() < n {
        "add one for each, such as x' = ..."
    } else {
        "remove one, or list its unknown in [model.start]"
    };
    let message = format!("{} equations for {n} unknowns ({}); {trouble}", rows.len(), shorten(&names));
    Err(TextError::in_equations(Wrong { offset: rows.last().map(|row| row.at), message }))
}

/// A list that stays on a line.
pub fn shorten(names: &[&str]) -> String {
    match names {
        [] => "none".to_owned(),
        [first, second, .., last] if names.len() > 8 => format!("{first}, {second}, ..., {last}"),
        _ => names.join(", "),
    }
}

/// `KEY = VALUE` as a statement.
fn read_start((key, value): &(String, String)) -> Result<Statement, TextError> {
    statement(&format!("{key} = {value}")).map_err(|wrong| {
        let mut wrong = Wrong::from(wrong);
        wrong.offset = in_value(key, wrong.offset);
        TextError { part: Part::Start(key.clone()), wrong }
    })
}

/// From a place in `KEY = VALUE` to one in VALUE.
fn in_value(key: &str, offset: Option<usize>) -> Option<usize> {
    offset.and_then(|offset| offset.checked_sub(key.len() + 3))
}

/// The start as vertices, zero where nothing is said.
fn start(
    scope: &mut Scope<'_>,
    unknowns: &Unknowns,
    written: &Written,
    starts: &[Statement],
) -> Result<Vec<Id>, TextError> {
    let mut ids = vec![scope.graph.constant(0.0); unknowns.names.len()];
    for (start, (key, _)) in starts.iter().zip(&written.start) {
        let wrong = |Wrong { offset, message }: Wrong| TextError {
            part: Part::Start(key.clone()),
            wrong: Wrong { offset: in_value(key, offset), message },
        };
        for range in &start.ranges {
            scope.check_index(range).map_err(wrong)?;
        }
        for (i, local) in started(scope, start).map_err(wrong)? {
            scope.graph.site = u64::MAX >> 1;
            let id = scope.build(&start.right, Local::indexed(&local)).map_err(wrong)?;
            if scope.graph.vertices[id as usize].moves {
                let message = "a start may depend on parameters, constants and indices only".to_owned();
                return Err(wrong(Wrong { offset: None, message }));
            }
            ids[i] = id;
        }
    }
    Ok(ids)
}

/// Names of indices with their values.
type Indices = Vec<(String, i64)>;

/// The unknowns that an entry of [model.start] speaks of, with the values of its indices.
fn started(scope: &Scope<'_>, start: &Statement) -> Result<Vec<(usize, Indices)>, Wrong> {
    let (name, indices) = match &start.left {
        Node::Name(name, _) => (name, None),
        Node::Element(name, indices, _) => (name, Some(&indices[..])),
        _ => return Ok(Vec::new()),
    };
    let none = |element: &[i64]| Wrong {
        offset: None,
        message: format!("{} is not an unknown", super::scope::show(name, element)),
    };
    let Some(Symbol { cells, .. }) = scope.symbols.get(name) else { return Err(none(&[])) };
    let unknown = |element: &Vec<i64>| match cells.get(element) {
        Some(Cell::Unknown(i)) => Ok(*i),
        _ => Err(none(element)),
    };
    let free = indices.and_then(|indices| {
        let name = |node: &Node| match node {
            Node::Name(name, _) if !scope.constants.iter().any(|(known, _)| known == name) => Some(name.clone()),
            _ => None,
        };
        indices.iter().map(name).collect::<Option<Vec<String>>>()
    });
    if start.ranges.is_empty() && (indices.is_none() || free.is_some()) {
        let free = free.unwrap_or_default();
        let mut all: Vec<(&Vec<i64>, usize)> = (cells.iter())
            .filter_map(|(element, cell)| if let Cell::Unknown(i) = cell { Some((element, *i)) } else { None })
            .filter(|(element, _)| indices.is_none() || element.len() == free.len())
            .collect();
        if all.is_empty() {
            return Err(none(&[]));
        }
        all.sort();
        return Ok(all
            .into_iter()
            .map(|(element, i)| (i, free.iter().cloned().zip(element.iter().copied()).collect()))
            .collect());
    }
    let mut found = Vec::new();
    for local in scope.whole().all(&start.ranges)? {
        let element = values(&scope.whole(), indices.unwrap_or_default(), &local)?;
        found.push((unknown(&element)?, local));
    }
    Ok(found)
}

fn observables(
    scope: &mut Scope<'_>,
    unknowns: &Unknowns,
    written: &Written,
) -> Result<(Vec<Observable>, Vec<Id>), TextError> {
    let (mut list, mut ids) = (Vec::new(), Vec::new());
    for given in &written.observables {
        let wrong = |wrong: Wrong| TextError { part: Part::Observable(given.name.clone()), wrong };
        let refuse = |message: String| Err(wrong(Wrong { offset: None, message }));
        if written.reserved.contains(&given.name) {
            return refuse(format!("{:?} is the name of a column of the results; choose another name", given.name));
        }
        if written.parameters.iter().any(|parameter| parameter.name == given.name) {
            return refuse(format!("{:?} is the name of a parameter; choose another name", given.name));
        }
        let node = Node::parse(&given.expression).map_err(|error| wrong(error.into()))?;
        scope.graph.site = u64::MAX >> 1;
        ids.push(scope.build(&node, Local::NONE).map_err(wrong)?);
        list.push(Observable {
            name: intern(&given.name),
            unit: intern(&given.unit),
            meaning: intern(if given.meaning.is_empty() { &given.expression } else { &given.meaning }),
        });
    }
    let n = unknowns.names.len();
    let shown = if n <= SMALL { n } else { unknowns.scalars.min(SMALL) };
    for (i, name) in unknowns.names.iter().enumerate().take(shown) {
        if written.reserved.contains(name) || list.iter().any(|o| o.name == name) {
            continue;
        }
        list.push(Observable { name: intern(name), unit: "", meaning: "unknown" });
        ids.push(scope.graph.unknown(i));
    }
    Ok((list, ids))
}

fn parameters(written: &Written) -> Result<Vec<Parameter>, TextError> {
    let known = || written.parameters.iter().map(|parameter| parameter.name.as_str());
    let make = |given: &super::WrittenParameter| {
        let wrong = |offset: Option<usize>, message: String| TextError {
            part: Part::Parameter(given.name.clone()),
            wrong: Wrong { offset, message },
        };
        let bounds = match (given.least, given.most) {
            (f64::NEG_INFINITY, f64::INFINITY) => Bounds::Any,
            (least, most) => Bounds::Within(least, most),
        };
        let default = match &given.default {
            WrittenDefault::Number(value) if bounds.contain(*value) => Default::Value(*value),
            WrittenDefault::Number(value) => return Err(wrong(None, format!("{value}: must be {bounds}"))),
            WrittenDefault::Tie(text) => {
                let tie = Expression::parse(text).map_err(|error| wrong(None, error.to_string()))?;
                if let Some(name) = tie.names().into_iter().find(|name| known().all(|known| known != name)) {
                    let advice =
                        suggest(&name, known()).map_or(String::new(), |meant| format!("; did you mean {meant:?}?"));
                    return Err(wrong(text.find(&name), format!("{name:?} is not a parameter{advice}")));
                }
                Default::Tie(intern(text))
            }
        };
        let (name, unit, meaning) = (intern(&given.name), intern(&given.unit), intern(&given.meaning));
        Ok(Parameter { name, default, unit, meaning, bounds })
    };
    written.parameters.iter().map(make).collect()
}
