//! XPPAUT's `.ode` files, the common subset: equations `x' = ...` and `dx/dt = ...`, algebraic equations `0 = ...` with
//! `solv`, `par`, `init`, `number`, `aux`, functions, fixed quantities `R = ...` and derived parameters `!b = ...`.
//!
//! (Ermentrout 2002, doi:10.1137/1.9780898718195.) Letters are the same in both cases there; all become small here.

use super::{ImportError, Imported, Remark};
use crate::expression::{Function, Node, RESERVED, suggest};
use std::collections::BTreeMap;

/// What a line says.
#[derive(Debug)]
enum Line {
    Rate { name: String, right: String },
    Algebraic { right: String },
    Fixed { name: String, right: String },
    Own { name: String, arguments: Vec<String>, right: String },
    Derived { name: String, right: String },
    Parameters(Vec<(String, String)>),
    Numbers(Vec<(String, String)>),
    Start(Vec<(String, String)>),
    Auxiliary { name: String, right: String },
    Options(String),
}

/// Words that begin lines which a scene has no place for, and why.
const REFUSED: [(&str, &str); 12] = [
    ("global", "events that change the state"),
    ("markov", "random processes"),
    ("wiener", "noise"),
    ("table", "tables"),
    ("volt", "integral equations"),
    ("bdry", "boundary conditions"),
    ("special", "networks"),
    ("network", "networks"),
    ("export", "libraries"),
    ("vector", "vectors"),
    ("@delay", "delays"),
    ("delay", "delays"),
];

/// Reads a file; `reserved` are names that scenes give to their results.
pub fn read(text: &str, reserved: &[&str]) -> Result<Imported, ImportError> {
    let (mut lines, mut wrong, mut imported) = (Vec::new(), Vec::new(), Imported::default());
    for (line, content) in joined(text) {
        if content.eq_ignore_ascii_case("done") || content.eq_ignore_ascii_case("d") {
            break;
        }
        match sort(&content.to_lowercase()) {
            Ok(Some(sorted)) => lines.push((line, sorted)),
            Ok(None) => imported.notes.push(Remark { line, message: format!("left out: {content}") }),
            Err(message) => wrong.push(Remark { line, message }),
        }
    }
    let names = Names::new(&lines, reserved, &mut imported.notes, &mut wrong);
    for (line, sorted) in &lines {
        let noted = imported.take(&names, *line, sorted);
        wrong.extend(noted.err().map(|message| Remark { line: *line, message }));
    }
    if wrong.is_empty() && imported.equations.is_empty() {
        wrong.push(Remark { line: 1, message: "there is no equation, such as x' = -x".to_owned() });
    }
    wrong.sort_by_key(|remark| remark.line);
    if wrong.is_empty() { Ok(imported) } else { Err(ImportError(wrong)) }
}

/// Lines with their numbers, continued ones joined, without comments.
fn joined(text: &str) -> Vec<(usize, String)> {
    let mut lines: Vec<(usize, String)> = Vec::new();
    let mut continued = false;
    for (line, content) in (1..).zip(text.lines()) {
        let content = content.trim();
        let (part, goes_on) = match content.strip_suffix('\\') {
            Some(part) => (part, true),
            None => (content, false),
        };
        if let (true, Some((_, last))) = (continued, lines.last_mut()) {
            last.push_str(part);
        } else if !content.is_empty() && !content.starts_with(['#', '%', '"']) {
            lines.push((line, part.split('#').next().unwrap_or("").trim().to_owned()));
        } else {
            continue;
        }
        continued = goes_on;
    }
    lines
}

/// What a line in small letters says; None for what has no meaning here, such as options of the program.
fn sort(line: &str) -> Result<Option<Line>, String> {
    if let Some(options) = line.strip_prefix('@') {
        return Ok(Some(Line::Options(options.to_owned())));
    }
    let first: String = line.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
    let rest = line[first.len()..].trim_start();
    let keyword =
        !first.is_empty() && line[first.len()..].starts_with(char::is_whitespace) && !rest.starts_with(['=', '\'']);
    if keyword {
        if let Some((_, what)) =
            REFUSED.iter().find(|(word, _)| first.starts_with(word) || first == word[..1] && *word == "bdry")
        {
            return Err(format!("a scene has no {what}"));
        }
        return match first.as_str() {
            "set" | "only" | "options" => Ok(None),
            "aux" | "a" => {
                let (name, right) = rest.split_once('=').ok_or("aux needs NAME = EXPRESSION")?;
                Ok(Some(Line::Auxiliary { name: name.trim().to_owned(), right: right.trim().to_owned() }))
            }
            _ if first.starts_with('p') => assignments(rest).map(|list| Some(Line::Parameters(list))),
            _ if first.starts_with('i') || first == "solv" || first == "solve" => {
                assignments(rest).map(|list| Some(Line::Start(list)))
            }
            _ if first.starts_with('n') => assignments(rest).map(|list| Some(Line::Numbers(list))),
            _ => Err(format!(
                "cannot be read: {line}; known are x' = ..., par, init, number, aux, solv, f(x) = ..., done"
            )),
        };
    }
    let Some((left, right)) = line.split_once('=') else {
        return Err(format!("cannot be read: {line}; it is no equation"));
    };
    let (left, right) = (left.trim(), right.trim().to_owned());
    let is_name = |text: &str| {
        text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
    };
    if left.contains('[') {
        return Err(
            "arrays of names, x[1..n], are not supported; a scene writes them as u[i]' = ... for i = 1..N".to_owned()
        );
    }
    if left == "0" {
        return Ok(Some(Line::Algebraic { right }));
    }
    if let Some(name) = left.strip_prefix('!').map(str::trim).filter(|name| is_name(name)) {
        return Ok(Some(Line::Derived { name: name.to_owned(), right }));
    }
    let rate = left.strip_suffix('\'').or_else(|| left.strip_prefix('d')?.strip_suffix("/dt")).map(str::trim);
    if let Some(name) = rate.filter(|name| is_name(name)) {
        return Ok(Some(Line::Rate { name: name.to_owned(), right }));
    }
    if is_name(left) {
        return Ok(Some(Line::Fixed { name: left.to_owned(), right }));
    }
    let call = left.split_once('(').and_then(|(name, rest)| Some((name.trim(), rest.strip_suffix(')')?)));
    match call {
        Some((name, "0")) if is_name(name) => Ok(Some(Line::Start(vec![(name.to_owned(), right)]))),
        Some((name, "t" | "t+1")) if is_name(name) => Err("maps and integral equations are not supported".to_owned()),
        Some((name, arguments)) if is_name(name) => {
            let arguments = arguments.split(',').map(|argument| argument.trim().to_owned()).collect();
            Ok(Some(Line::Own { name: name.to_owned(), arguments, right }))
        }
        _ => Err(format!("cannot be read: {left}; write x' = ..., dx/dt = ..., 0 = ..., R = ... or f(x) = ...")),
    }
}

/// `a=1, b=2 c=-3e2`
fn assignments(text: &str) -> Result<Vec<(String, String)>, String> {
    let spaced = text.replace('=', " = ").replace(',', " ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    words
        .chunks(3)
        .map(|chunk| match chunk {
            [name, "=", value] if value.parse::<f64>().is_ok_and(f64::is_finite) => {
                // A form that the scene's grammar reads, too: .5 and 2. become 0.5 and 2.
                Ok(((*name).to_owned(), value.parse::<f64>().map_or(String::new(), |value| format!("{value:?}"))))
            }
            _ => Err(format!("expected NAME = NUMBER, found {:?}", chunk.join(" "))),
        })
        .collect()
}

/// Names of the file, as the scene has them.
struct Names {
    renamed: BTreeMap<String, String>,
    /// Functions of the file.
    functions: Vec<String>,
    /// Names that the equations know, not functions.
    known: Vec<String>,
    states: Vec<String>,
}

impl Names {
    fn new(lines: &[(usize, Line)], reserved: &[&str], notes: &mut Vec<Remark>, wrong: &mut Vec<Remark>) -> Names {
        let mut names =
            Names { renamed: BTreeMap::new(), functions: Vec::new(), known: Vec::new(), states: Vec::new() };
        for (line, sorted) in lines {
            let mut add = |name: &String, function: bool| {
                let list = if function { &mut names.functions } else { &mut names.known };
                if list.contains(name) {
                    wrong.push(Remark { line: *line, message: format!("{name} is given twice") });
                }
                list.push(name.clone());
                if Function::named(name).is_some()
                    || RESERVED.contains(&name.as_str())
                    || reserved.contains(&name.as_str())
                {
                    let new = format!("{name}_");
                    notes.push(Remark { line: *line, message: format!("{name} is called {new}") });
                    names.renamed.insert(name.clone(), new);
                }
            };
            match sorted {
                Line::Rate { name, .. } => {
                    add(name, false);
                    names.states.push(name.clone());
                }
                Line::Fixed { name, .. } | Line::Derived { name, .. } => add(name, false),
                Line::Own { name, .. } => add(name, true),
                Line::Parameters(list) | Line::Numbers(list) => list.iter().for_each(|(name, _)| add(name, false)),
                Line::Start(_) | Line::Auxiliary { .. } | Line::Algebraic { .. } | Line::Options(_) => {}
            }
        }
        // What `solv` lists and nothing else gives is an unknown of the algebraic equations.
        if lines.iter().any(|(_, sorted)| matches!(sorted, Line::Algebraic { .. })) {
            for (name, _) in lines
                .iter()
                .filter_map(|(_, sorted)| if let Line::Start(list) = sorted { Some(list) } else { None })
                .flatten()
            {
                if !names.known.contains(name) {
                    names.known.push(name.clone());
                    names.states.push(name.clone());
                }
            }
        }
        names
    }

    fn of(&self, name: &str) -> String {
        self.renamed.get(name).cloned().unwrap_or_else(|| name.to_owned())
    }

    /// An expression of the file in the grammar of scenes.
    fn translate(&self, text: &str, arguments: &[String]) -> Result<String, String> {
        if text.contains("if(") || text.contains("if (") || text.contains(['<', '>', '&', '|', '!']) {
            return Err("conditions (if, <, >, &, |) are not supported".to_owned());
        }
        let mut node = Node::parse(&text.replace("**", "^")).map_err(|error| format!("{}: {text}", error.fault))?;
        self.rename(&mut node, arguments)?;
        Ok(node.to_string())
    }

    fn rename(&self, node: &mut Node, arguments: &[String]) -> Result<(), String> {
        match node {
            Node::Number(_) | Node::Pi => {}
            Node::Name(name, _) if arguments.contains(name) => {}
            Node::Name(name, _) if self.known.contains(name) => *name = self.of(name),
            Node::Name(name, _) if name == "t" => return Err("time t in a right-hand side is not supported".to_owned()),
            Node::Name(name, _) => {
                let advice = suggest(name, self.known.iter().map(String::as_str));
                let advice = advice.map_or(String::new(), |meant| format!("; did you mean {meant}?"));
                return Err(format!("unknown name {name}{advice}"));
            }
            Node::Negate(inner) | Node::Call(_, inner, _) => self.rename(inner, arguments)?,
            Node::Binary(_, left, right, _) => {
                self.rename(left, arguments)?;
                self.rename(right, arguments)?;
            }
            Node::Apply(name, parts, at) => {
                parts.iter_mut().try_for_each(|part| self.rename(part, arguments))?;
                match (name.as_str(), parts.len()) {
                    ("ln", 1) => {
                        let (argument, at) = (parts.remove(0), *at);
                        *node = Node::Call(Function::Log, Box::new(argument), at);
                    }
                    _ if self.functions.contains(name) => *name = self.of(name),
                    _ => return Err(format!("the function {name} is not supported")),
                }
            }
            Node::Element(..) | Node::Rate(_) | Node::Sum(..) => {
                return Err("arrays, rates and sums in expressions are not supported".to_owned());
            }
        }
        Ok(())
    }
}

impl Imported {
    fn take(&mut self, names: &Names, line: usize, sorted: &Line) -> Result<(), String> {
        match sorted {
            Line::Rate { name, right } => {
                self.equations.push(format!("{}' = {}", names.of(name), names.translate(right, &[])?));
            }
            Line::Algebraic { right } => self.equations.push(format!("0 = {}", names.translate(right, &[])?)),
            Line::Fixed { name, right } => {
                self.equations.push(format!("{} = {}", names.of(name), names.translate(right, &[])?));
            }
            Line::Own { name, arguments, right } => {
                let body = names.translate(right, arguments)?;
                self.equations.push(format!("{}({}) = {body}", names.of(name), arguments.join(", ")));
            }
            Line::Derived { name, right } => self.parameters.push((names.of(name), names.translate(right, &[])?)),
            Line::Parameters(list) => {
                self.parameters.extend(list.iter().map(|(name, value)| (names.of(name), value.clone())))
            }
            Line::Numbers(list) => {
                self.equations.extend(list.iter().map(|(name, value)| format!("{} = {value}", names.of(name))));
            }
            Line::Start(list) => {
                for (name, value) in list {
                    let given = value.parse::<f64>().is_ok_and(f64::is_finite);
                    let value = if given { value.clone() } else { names.translate(value, &[])? };
                    if names.states.contains(name) {
                        self.start.retain(|(known, _)| *known != names.of(name));
                        self.start.push((names.of(name), value));
                    } else {
                        self.notes.push(Remark {
                            line,
                            message: format!("left out: the start of {name}, which is no unknown"),
                        });
                    }
                }
            }
            Line::Auxiliary { name, right } => match names.translate(right, &[]) {
                Ok(expression) if names.states.contains(name) => {
                    self.observables.push((format!("{name}_aux"), expression));
                }
                Ok(expression) => self.observables.push((names.of(name), expression)),
                Err(why) => self.notes.push(Remark { line, message: format!("left out: aux {name}: {why}") }),
            },
            Line::Options(options) => {
                let value = |key: &str| {
                    let list = assignments(options).unwrap_or_default();
                    list.iter().find(|(name, _)| name == key).and_then(|(_, value)| value.parse::<f64>().ok())
                };
                match (value("parmin"), value("parmax")) {
                    (Some(from), Some(to)) if from < to => self.range = Some((from, to)),
                    _ => {}
                }
                self.notes.push(Remark { line, message: format!("left out: @{options}") });
            }
        }
        Ok(())
    }
}
