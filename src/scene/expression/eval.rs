//! Evaluation on any scalar of num-dual: values, or values with derivatives of any order.

use std::f64::consts::PI;

use num_dual::DualNum;

use super::{Expression, ExpressionError, Function, Node, Operator};

/// Above this, tanh is taken from exp(-2|x|): num-dual's sinh / cosh is inf / inf from 711 on.
const LARGE_TANH: f64 = 20.0;

impl Expression {
    /// The value, with whatever derivatives `S` carries. `lookup` gives the value of a name, or None where it knows
    /// none. Division by zero, log(0) and the like follow IEEE arithmetic: check that the result is finite.
    /// A power with a name in its exponent needs a positive base.
    pub fn eval<S: DualNum<Primitive = f64> + Clone>(
        &self,
        lookup: &dyn Fn(&str) -> Option<S>,
    ) -> Result<S, ExpressionError> {
        self.root.eval(lookup)
    }
}

impl Node {
    pub(super) fn eval<S: DualNum<Primitive = f64> + Clone>(
        &self,
        lookup: &dyn Fn(&str) -> Option<S>,
    ) -> Result<S, ExpressionError> {
        Ok(match self {
            Node::Number(value) => S::from(*value),
            Node::Pi => S::from(PI),
            Node::Name(name) => lookup(name).ok_or_else(|| ExpressionError::UnknownName { name: name.clone() })?,
            Node::Negate(inner) => -inner.eval(lookup)?,
            Node::Call(function, inner) => function.apply(inner.eval(lookup)?),
            Node::Binary(operator, left, right) => {
                let left = left.eval(lookup)?;
                if *operator == Operator::Power
                    && let Some(exponent) = right.constant()
                {
                    return Ok(power(left, exponent));
                }
                let right = right.eval(lookup)?;
                match operator {
                    Operator::Add => left + right,
                    Operator::Subtract => left - right,
                    Operator::Multiply => left * right,
                    Operator::Divide => left / right,
                    Operator::Power => left.powd(right),
                }
            }
        })
    }
}

impl Function {
    fn apply<S: DualNum<Primitive = f64> + Clone>(self, x: S) -> S {
        match self {
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.tan(),
            Function::Exp => x.exp(),
            Function::Log => x.ln(),
            Function::Log10 => x.log10(),
            Function::Sqrt => x.sqrt(),
            Function::Abs => x.abs(),
            Function::Sinh => x.sinh(),
            Function::Cosh => x.cosh(),
            Function::Tanh => tanh(x),
        }
    }
}

fn tanh<S: DualNum<Primitive = f64> + Clone>(x: S) -> S {
    let value = x.re();
    if value.abs() < LARGE_TANH || value.is_nan() {
        return x.tanh();
    }
    let small = (x.abs() * -2.0).exp();
    let result = (-small.clone() + 1.0) / (small + 1.0);
    if value < 0.0 { -result } else { result }
}

/// x^exponent. Whole exponents are multiplied out: num-dual's `powi` forms products of exponents in i32, which
/// overflow, and x^(n-3), which is not finite where x^n is.
fn power<S: DualNum<Primitive = f64> + Clone>(x: S, exponent: f64) -> S {
    if exponent.fract() != 0.0 || exponent.abs() > f64::from(i32::MAX) {
        return x.powf(exponent);
    }
    // Exact: a whole number within the range of i32.
    let mut rest = exponent.abs() as u32;
    let mut square = x;
    let mut result: Option<S> = None;
    while rest > 0 {
        if rest % 2 == 1 {
            result = Some(match result {
                Some(result) => result * &square,
                None => square.clone(),
            });
        }
        rest /= 2;
        if rest > 0 {
            square = square.clone() * &square;
        }
    }
    let result = result.unwrap_or_else(S::one);
    if exponent < 0.0 { result.recip() } else { result }
}
