//! Why a start is not a number.

use super::formula::Text;
use super::graph::{Code, Id, Vertex, compute};
use super::{Part, TextError, Wrong};
use crate::expression::Function;
use crate::problem::Formula;
use std::sync::Arc;

impl Text {
    /// The first equation that is not finite at the start, and the operation in it that is to blame.
    pub fn complaint(self: &Arc<Self>, p: &[f64]) -> Option<TextError> {
        let u = self.start(p);
        if let Some(i) = u.iter().position(|u| !u.is_finite()) {
            let entry = self.start_names.iter().find(|name| name.split('[').next() == self.names[i].split('[').next());
            let message = format!("{} starts at {}, which is not a finite number", self.names[i], u[i]);
            let part = Part::Start(entry.cloned().unwrap_or_default());
            return Some(TextError { part, wrong: Wrong { offset: None, message } });
        }
        let vertices = &self.graph.vertices;
        let mut values: Vec<f64> = Vec::with_capacity(vertices.len());
        for placed in vertices {
            values.push(match placed.vertex {
                Vertex::Unknown(i) => u[i as usize],
                Vertex::Rate(_) => 0.0,
                Vertex::Parameter(i) => p[i as usize],
                Vertex::Constant(bits) => f64::from_bits(bits),
                Vertex::Operation(code, a, b) => compute(code, values[a as usize], values[b as usize]),
            });
        }
        let finite = |id: Id| values[id as usize].is_finite();
        let (row, name) = self.rows.iter().zip(&self.names).find(|(row, _)| !finite(row.id))?;
        let mut culprit = row.id;
        // Down to an operation whose operands are finite.
        while let Vertex::Operation(_, a, b) = vertices[culprit as usize].vertex {
            match [a, b].into_iter().find(|&id| !finite(id)) {
                Some(below) => culprit = below,
                None => break,
            }
        }
        let (placed, value) = (vertices[culprit as usize], values[culprit as usize]);
        let what = match placed.vertex {
            Vertex::Operation(code, a, b) => describe(code, values[a as usize], values[b as usize], value),
            Vertex::Parameter(i) => format!("the parameter {} is {value}", self.parameters[i as usize].name),
            _ => format!("a constant is {value}"),
        };
        let message = format!(
            "the equation of {name} is not finite at the start: {what}; change [model.start] or the parameters"
        );
        Some(TextError::in_equations(Wrong::new(placed.at, message)))
    }
}

fn describe(code: Code, a: f64, b: f64, value: f64) -> String {
    match code {
        Code::Divide if b == 0.0 => format!("{a} is divided by zero"),
        Code::Call(function @ (Function::Log | Function::Log10 | Function::Sqrt)) if a <= 0.0 => {
            format!("{} is taken of {a}", function.name())
        }
        Code::Call(function) => format!("{}({a}) is {value}", function.name()),
        Code::Power | Code::RealPower => format!("{a}^{b} is {value}"),
        Code::Add => format!("{a} + {b} is {value}"),
        Code::Subtract => format!("{a} - {b} is {value}"),
        Code::Multiply => format!("{a} * {b} is {value}"),
        Code::Divide => format!("{a} / {b} is {value}"),
        Code::Negate => format!("-{a} is {value}"),
    }
}
