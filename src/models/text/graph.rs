//! What a text computes, as a graph: constants folded, equal subexpressions shared, whole powers multiplied out.

use crate::expression::{Function, power};
use std::collections::HashMap;

/// The position of a vertex; operands come before what is made of them.
pub type Id = u32;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Code {
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    /// The exponent varies; the base must be positive.
    Power,
    /// The exponent is a constant that is not whole.
    RealPower,
    Call(Function),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Vertex {
    Unknown(u32),
    Rate(u32),
    Parameter(u32),
    /// The bits of a number.
    Constant(u64),
    /// Functions of one operand have it twice.
    Operation(Code, Id, Id),
}

/// A vertex and what the tape wants to know of it.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    pub vertex: Vertex,
    /// Longest way from an input.
    pub level: u32,
    /// Degree in the rates: 0, 1, or 2 for all that is not linear.
    pub degree: u8,
    /// Whether it depends on the state, and not on parameters alone.
    pub moves: bool,
    /// Which place of the text made it: the same for all elements of an array.
    pub site: u64,
    /// The byte of the text at which it stands.
    pub at: usize,
}

#[derive(Default)]
pub struct Graph {
    pub vertices: Vec<Placed>,
    known: HashMap<Vertex, Id>,
    /// Where the text is being read.
    pub site: u64,
    pub at: usize,
}

impl Graph {
    /// All of them, in order.
    pub fn enter_inputs(&mut self, unknowns: usize, parameters: usize) {
        for i in 0..unknowns {
            self.unknown(i);
        }
        for i in 0..unknowns {
            self.rate(i);
        }
        for i in 0..parameters {
            self.parameter(i);
        }
    }

    pub fn unknown(&mut self, i: usize) -> Id {
        self.add(Vertex::Unknown(i as u32))
    }

    pub fn rate(&mut self, i: usize) -> Id {
        self.add(Vertex::Rate(i as u32))
    }

    pub fn parameter(&mut self, i: usize) -> Id {
        self.add(Vertex::Parameter(i as u32))
    }

    pub fn constant(&mut self, value: f64) -> Id {
        // One zero: -0 and 0 are the same number to all that is computed here.
        self.add(Vertex::Constant((value + 0.0).to_bits()))
    }

    pub fn value(&self, id: Id) -> Option<f64> {
        match self.vertices[id as usize].vertex {
            Vertex::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Constants are computed at once, and what adds zero or multiplies by one or zero is left out.
    pub fn binary(&mut self, code: Code, a: Id, b: Id) -> Id {
        match (code, self.value(a), self.value(b)) {
            (_, Some(x), Some(y)) => self.constant(compute(code, x, y)),
            (Code::Add, Some(0.0), _) | (Code::Multiply, Some(1.0), _) => b,
            (Code::Add | Code::Subtract, _, Some(0.0)) | (Code::Multiply | Code::Divide, _, Some(1.0)) => a,
            (Code::Subtract, Some(0.0), _) => self.unary(Code::Negate, b),
            (Code::Multiply, Some(0.0), _) | (Code::Multiply, _, Some(0.0)) => self.constant(0.0),
            (Code::Power, _, Some(exponent)) => self.power(a, exponent),
            // Sums and products do not depend on the order of their two parts: one form shares more.
            (Code::Add | Code::Multiply, ..) => self.add(Vertex::Operation(code, a.min(b), a.max(b))),
            _ => self.add(Vertex::Operation(code, a, b)),
        }
    }

    pub fn unary(&mut self, code: Code, a: Id) -> Id {
        match (code, self.value(a), self.vertices[a as usize].vertex) {
            (_, Some(x), _) => self.constant(compute(code, x, x)),
            (Code::Negate, _, Vertex::Operation(Code::Negate, inner, _)) => inner,
            _ => self.add(Vertex::Operation(code, a, a)),
        }
    }

    fn power(&mut self, x: Id, exponent: f64) -> Id {
        if exponent.fract() != 0.0 || exponent.abs() > f64::from(i32::MAX) {
            let exponent = self.constant(exponent);
            return self.add(Vertex::Operation(Code::RealPower, x, exponent));
        }
        let (mut rest, mut square, mut result) = (exponent.abs() as u32, x, None);
        while rest > 0 {
            if rest % 2 == 1 {
                result = Some(result.map_or(square, |result| self.binary(Code::Multiply, result, square)));
            }
            rest /= 2;
            if rest > 0 {
                square = self.binary(Code::Multiply, square, square);
            }
        }
        let one = self.constant(1.0);
        let result = result.unwrap_or(one);
        if exponent < 0.0 { self.binary(Code::Divide, one, result) } else { result }
    }

    fn add(&mut self, vertex: Vertex) -> Id {
        if let Some(&id) = self.known.get(&vertex) {
            return id;
        }
        let of = |id: Id| self.vertices[id as usize];
        let (level, degree, moves) = match vertex {
            Vertex::Operation(code, a, b) => {
                let (a, b) = (of(a), of(b));
                let degree = match code {
                    Code::Add | Code::Subtract | Code::Negate => a.degree.max(b.degree),
                    Code::Multiply => a.degree + b.degree,
                    Code::Divide => a.degree + 2 * b.degree,
                    Code::Power | Code::RealPower | Code::Call(_) => 2 * a.degree.max(b.degree),
                };
                (1 + a.level.max(b.level), degree.min(2), a.moves || b.moves)
            }
            Vertex::Rate(_) => (0, 1, true),
            Vertex::Unknown(_) => (0, 0, true),
            Vertex::Parameter(_) | Vertex::Constant(_) => (0, 0, false),
        };
        let id = self.vertices.len() as Id;
        self.vertices.push(Placed { vertex, level, degree, moves, site: self.site, at: self.at });
        self.known.insert(vertex, id);
        id
    }
}

/// On plain numbers.
pub fn compute(code: Code, a: f64, b: f64) -> f64 {
    match code {
        Code::Add => a + b,
        Code::Subtract => a - b,
        Code::Multiply => a * b,
        Code::Divide => a / b,
        Code::Negate => -a,
        Code::Power | Code::RealPower => power(a, b),
        Code::Call(function) => function.apply(a),
    }
}
