//! `[model.conserved] total = "x + y"`: quantities c(u) that the flow keeps, `grad c . F = 0`.
//!
//! Along with such a quantity the Jacobian is singular on whole branches. Its value becomes a parameter, and
//! `0 = c(u) - total` takes the place of one of the equations, which follows from it and the others: that of the unknown
//! on which c depends most. c must be linear in the unknowns: where a factor depends on the state, it may vanish, and the
//! equation does not follow any more. On the level set the problem is the same, the trivial eigenvalue zero is gone from the pencil
//! (a row of M is zero), and all that is done to equilibria, curves and cycles holds as it stands.

use super::formula::Text;
use super::graph::{Code, Graph, Id};
use super::rows::{self, Row};
use super::scope::{Local, Scope};
use super::symmetry::scattered;
use super::tape::Tape;
use super::unknowns::Unknowns;
use super::{Part, TextError, Written, WrittenDefault, WrittenParameter, Wrong};
use crate::expression::Node;
use crate::problem::Default;
use num_dual::Dual64;

/// Relative to the terms that must cancel.
const TOLERANCE: f64 = 1e-9;
/// Random states that are tried.
const STATES: usize = 3;

/// One quantity.
pub(super) struct Quantity {
    /// The index of the parameter that is its value.
    parameter: usize,
    id: Id,
    name: String,
    /// Whether its value is that of the start.
    free: bool,
}

/// The text with a parameter for each quantity; those that are not declared get their values from the start.
pub(super) fn with_parameters(written: &Written) -> Written {
    let mut all = written.clone();
    for (name, expression) in &written.conserved {
        if written.parameters.iter().all(|parameter| parameter.name != *name) {
            all.parameters.push(WrittenParameter {
                name: name.clone(),
                default: WrittenDefault::Number(0.0),
                unit: String::new(),
                meaning: format!("conserved: {expression}"),
                least: f64::NEG_INFINITY,
                most: f64::INFINITY,
            });
        }
    }
    all
}

/// Reads the quantities, tries whether they are conserved, and puts each in the place of an equation.
pub(super) fn replace(
    scope: &mut Scope<'_>,
    (written, declared): (&Written, usize),
    unknowns: &Unknowns,
    equations: &mut [Row],
) -> Result<Vec<Quantity>, TextError> {
    let mut read = Vec::new();
    for (name, expression) in &written.conserved {
        let wrong = |wrong: Wrong| TextError { part: Part::Conserved(name.clone()), wrong };
        let node = Node::parse(expression).map_err(|error| wrong(error.into()))?;
        scope.graph.site = u64::MAX >> 1;
        let id = scope.build(&node, Local::NONE).map_err(wrong)?;
        let mut row = [Row { id, at: 0, unknowns: Vec::new(), rates: Vec::new() }];
        rows::dependencies(&scope.graph, &mut row).map_err(wrong)?;
        let [row] = row;
        if row.unknowns.is_empty() || !row.rates.is_empty() {
            let message = "a conserved quantity is an expression in the unknowns, without rates of change".to_owned();
            return Err(wrong(Wrong { offset: None, message }));
        }
        let Some(parameter) = written.parameters.iter().position(|parameter| parameter.name == *name) else { continue };
        read.push((Quantity { parameter, id, name: name.clone(), free: parameter >= declared }, row));
    }
    let gradients = gradients(&scope.graph, unknowns, equations, (&read, written.parameters.len()))?;
    let places = places(gradients, &read)?;
    for ((quantity, row), i) in read.iter_mut().zip(places) {
        let value = scope.graph.parameter(quantity.parameter);
        row.id = scope.graph.binary(Code::Subtract, quantity.id, value);
        row.at = equations[i].at;
        equations[i] = row.clone();
    }
    Ok(read.into_iter().map(|(quantity, _)| quantity).collect())
}

/// The gradients, constant in the state, after `grad c . F = 0` was tried at several random states.
fn gradients(
    graph: &Graph,
    unknowns: &Unknowns,
    equations: &[Row],
    (read, parameters): (&[(Quantity, Row)], usize),
) -> Result<Vec<Vec<f64>>, TextError> {
    let n = unknowns.names.len();
    let ids: Vec<Id> = equations.iter().map(|row| row.id).collect();
    let residual = Tape::new(graph, &unknowns.order, parameters, &ids);
    let mut last = Vec::new();
    for (quantity, row) in read {
        let refuse = |message: String| {
            let part = Part::Conserved(quantity.name.clone());
            Err(TextError { part, wrong: Wrong { offset: None, message } })
        };
        let tape = Tape::new(graph, &unknowns.order, parameters, &[quantity.id]);
        let mut known = None;
        for seed in 0..STATES {
            let (u, v) = (scattered(seed, n), scattered(1000 + seed, n));
            let (p, rest) = (scattered(5000 + seed, parameters), vec![0.0; n]);
            let (mut still, mut moving) = (vec![0.0; n], vec![0.0; n]);
            residual.evaluate(&u, &rest, &p, &mut still);
            residual.evaluate(&u, &v, &p, &mut moving);
            let dual = |x: &[f64]| x.iter().map(|&x| Dual64::from(x)).collect::<Vec<_>>();
            let (held, values) = (dual(&rest), dual(&p));
            let slope = |u: &[f64], i: usize| {
                let mut at = dual(u);
                at[i].eps = 1.0;
                let mut out = [Dual64::from(0.0)];
                tape.evaluate(&at, &held, &values, &mut out);
                out[0].eps
            };
            let mut gradient = vec![0.0; n];
            let (mut drift, mut scale) = (0.0_f64, 0.0_f64);
            for i in row.unknowns.iter().map(|&i| i as usize) {
                gradient[i] = slope(&u, i);
                if (slope(&v, i) - gradient[i]).abs() > TOLERANCE * gradient[i].abs() {
                    let x = &unknowns.names[i];
                    return refuse(format!(
                        "is not linear in {x}; a conserved quantity must be linear in the unknowns"
                    ));
                }
                let terms = gradient[i] * still[i];
                (drift, scale) = (drift + terms, scale.max(terms.abs()));
                if (moving[i] - still[i] - v[i]).abs() > TOLERANCE * (moving[i].abs() + still[i].abs() + 1.0) {
                    let x = &unknowns.names[i];
                    return refuse(format!("{x} is part of it: its equation must then be of the form {x}' = ..."));
                }
            }
            if !drift.is_finite() {
                continue;
            }
            if drift.abs() > TOLERANCE * scale {
                return refuse(format!(
                    "is not conserved: at a random state it changes at a rate of {:.3e} (terms of {scale:.3e} do not cancel)",
                    -drift
                ));
            }
            known = Some(gradient);
        }
        match known {
            Some(gradient) => last.push(gradient),
            None => {
                let message = "whether it is conserved cannot be tried: it or the equations have no value at unknowns \
                               and parameters between 0.2 and 0.8";
                return refuse(message.to_owned());
            }
        }
    }
    Ok(last)
}

/// The unknowns whose equations give way, by elimination with the largest entries as pivots.
fn places(mut gradients: Vec<Vec<f64>>, read: &[(Quantity, Row)]) -> Result<Vec<usize>, TextError> {
    let size = |row: &[f64]| row.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    let mut places: Vec<usize> = Vec::new();
    for (k, (quantity, _)) in read.iter().enumerate() {
        let before = size(&gradients[k]);
        let (done, rest) = gradients.split_at_mut(k);
        for (pivot, &i) in done.iter().zip(&places) {
            let factor = rest[0][i] / pivot[i];
            rest[0].iter_mut().zip(pivot).for_each(|(x, y)| *x -= factor * y);
            rest[0][i] = 0.0;
        }
        let left = size(&rest[0]);
        let place = rest[0].iter().position(|x| x.abs() == left).filter(|_| left > TOLERANCE * before);
        let Some(place) = place else {
            let message =
                "follows from the other conserved quantities, or from none of the unknowns; remove it".to_owned();
            let part = Part::Conserved(quantity.name.clone());
            return Err(TextError { part, wrong: Wrong { offset: None, message } });
        };
        places.push(place);
    }
    Ok(places)
}

/// Gives the parameters that are not declared the values that the quantities have at the start.
pub(super) fn begin(text: &mut Text, unknowns: &[u32], quantities: &[Quantity]) -> Result<(), TextError> {
    let n = text.names.len();
    // Whatever depends on a parameter is not a number.
    let (rest, open) = (vec![0.0; n], vec![f64::NAN; text.parameters.len()]);
    let mut u = rest.clone();
    text.start.evaluate(&rest, &rest, &open, &mut u);
    for quantity in quantities.iter().filter(|quantity| quantity.free) {
        let mut value = [f64::NAN];
        Tape::new(&text.graph, unknowns, open.len(), &[quantity.id]).evaluate(&u, &rest, &open, &mut value);
        if !value[0].is_finite() {
            let name = &quantity.name;
            let message =
                format!("its value at the start depends on parameters; give it: [model.parameters] {name} = ...");
            return Err(TextError { part: Part::Conserved(name.clone()), wrong: Wrong { offset: None, message } });
        }
        text.parameters[quantity.parameter].default = Default::Value(value[0]);
    }
    Ok(())
}
