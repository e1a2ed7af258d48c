//! A graph as a list of steps over registers, for any scalar.
//!
//! The steps are sorted by level and by the place in the text that they come from, so that what an array does for all
//! its elements lies side by side: such steps are one run over consecutive registers, which costs one dispatch and which
//! the compiler turns into vector instructions.

use super::graph::{Code, Graph, Id, Vertex};
use crate::expression::Function;
use crate::problem::Scalar;

/// Tapes with so many registers are evaluated on the stack, step by step; larger ones allocate and go by runs.
const SMALL: usize = 32;
const MEDIUM: usize = 64;

/// `len` registers from the next free one on become `code` of those from a and from b on; an operand that does not
/// advance is one register for the whole run.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Step {
    code: Code,
    len: u32,
    a: u32,
    b: u32,
    advance: (bool, bool),
}

/// `v_rate - r_register`, which most equations end with, or a register alone.
#[derive(Clone, Copy, Debug)]
struct Output {
    rate: Option<u32>,
    register: u32,
}

/// Registers hold, in this order: unknowns, rates where steps use them, parameters, constants, results of the steps.
#[derive(Clone, Debug)]
pub struct Tape {
    /// The unknown in each of the first registers, and the rate in each of those that follow.
    order: Vec<u32>,
    identity: bool,
    rates: bool,
    parameters: usize,
    constants: Vec<f64>,
    steps: Vec<Step>,
    registers: usize,
    /// The register of the first result.
    first: usize,
    outputs: Vec<Output>,
}

impl Tape {
    /// What the outputs need. `order` lists the unknowns array by array; the inputs of an evaluation are in the order of
    /// the problem.
    pub fn new(graph: &Graph, order: &[u32], parameters: usize, outputs: &[Id]) -> Tape {
        let ends: Vec<(Option<u32>, Id)> = outputs.iter().map(|&id| end(graph, id)).collect();
        let needed = reach(graph, ends.iter().map(|(_, id)| *id));
        let mut rates = false;
        let mut constants: Vec<Id> = Vec::new();
        let mut operations: Vec<Id> = Vec::new();
        for id in needed {
            match graph.vertices[id as usize].vertex {
                Vertex::Constant(_) => constants.push(id),
                Vertex::Operation(..) => operations.push(id),
                Vertex::Rate(_) => rates = true,
                Vertex::Unknown(_) | Vertex::Parameter(_) => {}
            }
        }
        operations.sort_by_key(|&id| {
            let placed = &graph.vertices[id as usize];
            let code = if let Vertex::Operation(code, ..) = placed.vertex { Some(code) } else { None };
            (placed.level, code, placed.site, id)
        });
        let n = order.len();
        let mut slot = vec![0_u32; n];
        order.iter().zip(0..).for_each(|(&unknown, at)| slot[unknown as usize] = at);
        let inputs = if rates { 2 * n } else { n };
        let first = inputs + parameters;
        let mut register = vec![u32::MAX; graph.vertices.len()];
        let places = constants.iter().chain(&operations).zip(first as u32..);
        places.for_each(|(&id, at)| register[id as usize] = at);
        let of = |id: Id| match graph.vertices[id as usize].vertex {
            Vertex::Unknown(i) => slot[i as usize],
            Vertex::Rate(i) => n as u32 + slot[i as usize],
            Vertex::Parameter(i) => inputs as u32 + i,
            Vertex::Constant(_) | Vertex::Operation(..) => register[id as usize],
        };
        let mut steps: Vec<Step> = Vec::new();
        let mut begin = (first + constants.len()) as u32;
        let registers = begin as usize + operations.len();
        for &id in &operations {
            let Vertex::Operation(code, a, b) = graph.vertices[id as usize].vertex else { continue };
            let (a, b) = (of(a), of(b));
            let here = register[id as usize];
            if registers > MEDIUM
                && let Some(last) = steps.last_mut()
                && last.join(code, (a, b), begin)
            {
                continue;
            }
            begin = here;
            steps.push(Step { code, len: 1, a, b, advance: (true, true) });
        }
        Tape {
            identity: order.iter().zip(0..).all(|(&unknown, at)| unknown == at),
            order: order.to_vec(),
            parameters,
            constants: constants.iter().filter_map(|&id| graph.value(id)).collect(),
            registers,
            first: first + constants.len(),
            steps,
            rates,
            outputs: ends.iter().map(|&(rate, id)| Output { rate, register: of(id) }).collect(),
        }
    }

    /// The outputs at (u, v, p).
    pub fn evaluate<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], out: &mut [S]) {
        if self.registers <= SMALL {
            self.evaluate_small::<S, SMALL>((u, v, p), out);
        } else if self.registers <= MEDIUM {
            self.evaluate_small::<S, MEDIUM>((u, v, p), out);
        } else {
            self.evaluate_large((u, v, p), out);
        }
    }

    /// Up to N registers, a power of two: positions are taken modulo N, which changes none and spares all checks.
    fn evaluate_small<S: Scalar, const N: usize>(&self, (u, v, p): (&[S], &[S], &[S]), out: &mut [S]) {
        let mut r = [S::from(0.0); N];
        let mut next = 0;
        let mut push = |r: &mut [S; N], value: S| {
            r[next % N] = value;
            next += 1;
        };
        if self.identity {
            u.iter().for_each(|&x| push(&mut r, x));
        } else {
            self.order.iter().for_each(|&i| push(&mut r, u[i as usize]));
        }
        if self.rates {
            self.order.iter().for_each(|&i| push(&mut r, v[i as usize]));
        }
        p.iter().for_each(|&p| push(&mut r, p));
        self.constants.iter().for_each(|&value| push(&mut r, S::from(value)));
        for step in &self.steps {
            let (a, b) = (r[step.a as usize % N], r[step.b as usize % N]);
            push(&mut r, apply(step.code, a, b));
        }
        for (out, end) in out.iter_mut().zip(&self.outputs) {
            *out = end.value(v, r[end.register as usize % N]);
        }
    }

    fn evaluate_large<S: Scalar>(&self, (u, v, p): (&[S], &[S], &[S]), out: &mut [S]) {
        let r = &mut vec![S::from(0.0); self.registers][..];
        let n = self.order.len();
        let (unknowns, rest) = r.split_at_mut(n);
        let (rates, rest) = rest.split_at_mut(if self.rates { n } else { 0 });
        unknowns.iter_mut().zip(&self.order).for_each(|(r, &i)| *r = u[i as usize]);
        rates.iter_mut().zip(&self.order).for_each(|(r, &i)| *r = v[i as usize]);
        rest[..self.parameters].copy_from_slice(p);
        rest[self.parameters..].iter_mut().zip(&self.constants).for_each(|(r, &value)| *r = S::from(value));
        let mut next = self.first;
        for step in &self.steps {
            let (a, b, len) = (step.a as usize, step.b as usize, step.len as usize);
            if len == 1 {
                r[next] = apply(step.code, r[a], r[b]);
            } else {
                let (known, rest) = r.split_at_mut(next);
                step.run(known, &mut rest[..len]);
            }
            next += len;
        }
        for (out, end) in out.iter_mut().zip(&self.outputs) {
            *out = end.value(v, r[end.register as usize]);
        }
    }
}

impl Output {
    #[inline(always)]
    fn value<S: Scalar>(self, v: &[S], r: S) -> S {
        match self.rate {
            Some(i) => v[i as usize] - r,
            None => r,
        }
    }
}

/// An output as a rate, from which something is taken, and that, or as itself.
fn end(graph: &Graph, id: Id) -> (Option<u32>, Id) {
    if let Vertex::Operation(Code::Subtract, a, b) = graph.vertices[id as usize].vertex
        && let Vertex::Rate(i) = graph.vertices[a as usize].vertex
    {
        return (Some(i), b);
    }
    (None, id)
}

impl Step {
    /// Takes in the operation with these operands if it continues the run, whose results begin at `begin`.
    fn join(&mut self, code: Code, (a, b): (u32, u32), begin: u32) -> bool {
        if code != self.code {
            return false;
        }
        let (step_a, step_b) = (a.wrapping_sub(self.a), b.wrapping_sub(self.b));
        let advance = (step_a == self.len, step_b == self.len);
        let regular = (advance.0 || step_a == 0) && (advance.1 || step_b == 0);
        // No element may use a result of the same run.
        if !regular || a >= begin || b >= begin || (self.len > 1 && advance != self.advance) {
            return false;
        }
        self.advance = advance;
        self.len += 1;
        true
    }

    fn run<S: Scalar>(&self, known: &[S], out: &mut [S]) {
        match self.code {
            Code::Add => self.each(known, out, |a, b| a + b),
            Code::Subtract => self.each(known, out, |a, b| a - b),
            Code::Multiply => self.each(known, out, |a, b| a * b),
            Code::Divide => self.each(known, out, |a, b| a / b),
            Code::Negate => self.each(known, out, |a, _| -a),
            code => self.each(known, out, |a, b| apply(code, a, b)),
        }
    }

    #[inline(always)]
    fn each<S: Scalar>(&self, known: &[S], out: &mut [S], f: impl Fn(S, S) -> S) {
        let (a, b) = (&known[self.a as usize..], &known[self.b as usize..]);
        match self.advance {
            (true, true) => out.iter_mut().zip(a.iter().zip(b)).for_each(|(out, (&a, &b))| *out = f(a, b)),
            (true, false) => {
                let b = b[0];
                out.iter_mut().zip(a).for_each(|(out, &a)| *out = f(a, b));
            }
            (false, _) => {
                let a = a[0];
                out.iter_mut().zip(b).for_each(|(out, &b)| *out = f(a, b));
            }
        }
    }
}

#[inline(always)]
fn apply<S: Scalar>(code: Code, a: S, b: S) -> S {
    match code {
        Code::Add => a + b,
        Code::Subtract => a - b,
        Code::Multiply => a * b,
        Code::Divide => a / b,
        Code::Negate => -a,
        Code::Power => power(a, b),
        Code::RealPower => real_power(a, b),
        Code::Call(function) => call(function, a),
    }
}

#[cold]
#[inline(never)]
fn power<S: Scalar>(a: S, b: S) -> S {
    a.powd(b)
}

#[cold]
#[inline(never)]
fn real_power<S: Scalar>(a: S, b: S) -> S {
    a.powf(b.re())
}

/// Apart from the frequent operations, which stay short without it.
#[cold]
#[inline(never)]
fn call<S: Scalar>(function: Function, a: S) -> S {
    function.apply(a)
}

/// The vertices that the outputs are made of, in order.
fn reach(graph: &Graph, outputs: impl Iterator<Item = Id>) -> Vec<Id> {
    let mut seen = vec![false; graph.vertices.len()];
    outputs.for_each(|id| seen[id as usize] = true);
    for id in (0..graph.vertices.len()).rev() {
        if let (true, Vertex::Operation(_, a, b)) = (seen[id], graph.vertices[id].vertex) {
            seen[a as usize] = true;
            seen[b as usize] = true;
        }
    }
    (0..graph.vertices.len()).filter(|&id| seen[id]).map(|id| id as Id).collect()
}
