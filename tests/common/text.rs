//! Models as text, built without a scene.

use hopfline::models::text::{TextError, Written, WrittenDefault, WrittenParameter, build};
use hopfline::problem::{Automatic, Problem};
use std::sync::Arc;

/// A model with parameters by name and value.
pub fn written(equations: &str, parameters: &[(&str, f64)], start: &[(&str, &str)]) -> Written {
    Written {
        equations: equations.to_owned(),
        parameters: (parameters.iter())
            .map(|&(name, value)| WrittenParameter {
                name: name.to_owned(),
                default: WrittenDefault::Number(value),
                unit: String::new(),
                meaning: String::new(),
                least: f64::NEG_INFINITY,
                most: f64::INFINITY,
            })
            .collect(),
        start: start.iter().map(|&(name, value)| (name.to_owned(), value.to_owned())).collect(),
        ..Written::default()
    }
}

pub fn problem(written: &Written) -> Result<Arc<dyn Problem>, TextError> {
    Ok(Arc::new(Automatic(build(written)?)))
}

/// The same as `lorenz::Lorenz`.
pub fn lorenz() -> Arc<dyn Problem> {
    let equations = "x' = sigma*(y - x)\ny' = x*(rho - z) - y\nz' = x*y - beta*z";
    let parameters = [("rho", 28.0), ("sigma", 10.0), ("beta", 8.0 / 3.0)];
    problem(&written(equations, &parameters, &[])).unwrap()
}

/// The same as `brusselator::Brusselator`.
pub fn brusselator(points: i64) -> Arc<dyn Problem> {
    let equations = "\
        u[i]' = 0.008*lap*(u[i-1] - 2*u[i] + u[i+1]) + u[i]^2*v[i] - 6.45*u[i] + 2    for i = 1..N
        v[i]' = 0.004*lap*(v[i-1] - 2*v[i] + v[i+1]) - u[i]^2*v[i] + 5.45*u[i]        for i = 1..N
        u[0] = 2
        v[0] = 2.725
        u[N+1] = 2
        v[N+1] = 2.725
        lap = ((N + 1)/L)^2";
    let constants = vec![("N".to_owned(), points)];
    let written = Written { constants, ..written(equations, &[("L", 0.4)], &[("u", "2"), ("v", "2.725")]) };
    problem(&written).unwrap()
}
