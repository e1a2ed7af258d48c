//! Functions that a text defines: what they stand for where they are used.

use super::{Local, Scope};
use crate::expression::{Fault, Node, Offset, RESERVED};
use crate::models::text::Wrong;
use crate::models::text::graph::Id;

/// `f(x, y) = body`
pub(super) struct Own<'a> {
    arguments: Vec<&'a str>,
    body: &'a Node,
    /// Whether it is being worked out.
    busy: bool,
}

impl<'a> Scope<'a> {
    pub fn define_function(
        &mut self,
        (name, at): (&'a str, usize),
        arguments: &'a [Node],
        body: &'a Node,
    ) -> Result<(), Wrong> {
        self.check_free(name, at)?;
        let mut names: Vec<&str> = Vec::new();
        for argument in arguments {
            let Node::Name(argument, Offset(at)) = argument else {
                return Err(Wrong::new(at, format!("the arguments of {name} must be names, as in {name}(x) = x^2")));
            };
            if RESERVED.contains(&argument.as_str()) || names.contains(&argument.as_str()) {
                return Err(Wrong::new(*at, format!("{argument:?} cannot be an argument here; choose another name")));
            }
            names.push(argument);
        }
        self.functions.insert(name, Own { arguments: names, body, busy: false });
        Ok(())
    }

    /// All functions once, so that what is wrong in them is found whether they are used or not.
    pub fn try_functions(&mut self) -> Result<(), Wrong> {
        let any = self.graph.constant(0.5);
        let all: Vec<(&'a Node, Vec<&'a str>)> =
            self.functions.values().map(|own| (own.body, own.arguments.clone())).collect();
        for (body, arguments) in all {
            let arguments: Vec<(&str, Id)> = arguments.iter().map(|&name| (name, any)).collect();
            self.build(body, Local { indices: &[], arguments: &arguments })?;
        }
        Ok(())
    }

    pub(super) fn apply(
        &mut self,
        name: &str,
        arguments: &[Node],
        Offset(at): Offset,
        local: Local<'_>,
    ) -> Result<Id, Wrong> {
        let Some(own) = self.functions.get_mut(name) else {
            if self.symbols.contains_key(name) {
                return Err(Wrong::new(
                    at,
                    format!("{name} is no function; write a product with *, an element with [ ]"),
                ));
            }
            let own: Vec<&str> = self.functions.keys().copied().collect();
            return Err(Wrong::new(at, Fault::unknown_function(name, &own).to_string()));
        };
        if own.arguments.len() != arguments.len() {
            let message = format!("{name} takes {} arguments, but has {} here", own.arguments.len(), arguments.len());
            return Err(Wrong::new(at, message));
        }
        if own.busy {
            return Err(Wrong::new(at, format!("the function {name} is defined by itself")));
        }
        let (names, body) = (own.arguments.clone(), own.body);
        let mut bound = Vec::with_capacity(names.len());
        for (name, argument) in names.into_iter().zip(arguments) {
            bound.push((name, self.build(argument, local)?));
        }
        self.set_busy(name, true);
        let value = self.build(body, Local { indices: &[], arguments: &bound })?;
        self.set_busy(name, false);
        Ok(value)
    }

    fn set_busy(&mut self, name: &str, busy: bool) {
        if let Some(own) = self.functions.get_mut(name) {
            own.busy = busy;
        }
    }
}
