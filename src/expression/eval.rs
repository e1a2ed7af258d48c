//! Evaluation on any scalar of num-dual: values, or values with derivatives of any order.

use std::f64::consts::PI;

use num_dual::DualNum;

use super::{Expression, ExpressionError, Node, Operator};

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
            Node::Name(name, _) => lookup(name).ok_or_else(|| ExpressionError::UnknownName { name: name.clone() })?,
            Node::Negate(inner) => -inner.eval(lookup)?,
            Node::Call(function, inner, _) => function.apply(inner.eval(lookup)?),
            Node::Binary(operator, left, right, _) => {
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
            // What only models hold; an `Expression` holds none.
            Node::Element(..) | Node::Rate(_) | Node::Apply(..) | Node::Sum(..) => {
                return Err(ExpressionError::UnknownName { name: self.to_string() });
            }
        })
    }
}

/// x^exponent. Whole exponents are multiplied out: num-dual's `powi` forms products of exponents in i32, which
/// overflow, and x^(n-3), which is not finite where x^n is.
pub fn power<S: DualNum<Primitive = f64> + Clone>(x: S, exponent: f64) -> S {
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
