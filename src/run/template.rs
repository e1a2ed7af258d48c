//! `hopfline new`: a commented scene to start from.

use super::RunError;
use crate::models::{Options, REGISTRY, find};
use crate::problem::Default;
use crate::scene::Fault;
use std::fmt::Write;
use std::path::Path;

/// The text of a scene for a model, with its parameters as comments.
pub fn template(name: &str, model: &str) -> Result<String, RunError> {
    let found = find(model).ok_or_else(|| {
        RunError::Input(format!("--model: {}", Fault::unknown("model", model, REGISTRY.iter().map(|m| m.name))))
    })?;
    let problem = (found.build)(&Options::default()).map_err(|e| RunError::Input(e.to_string()))?;
    let title = Path::new(name).file_name().unwrap_or_default().to_string_lossy();
    let title = toml::Value::from(title.as_ref());
    let mut out = format!("title = {title}\n\n[model]\nname = \"{model}\"\n");
    for (option, values, meaning) in found.options {
        let _ = writeln!(out, "# {option}: {values}; {meaning}");
    }
    out += "\n[parameters]                 # only what differs from the defaults\n";
    for q in problem.parameters() {
        match q.default {
            Default::Value(x) => drop(writeln!(out, "# {} = {x}  # {}, {}", q.name, q.unit, q.meaning)),
            Default::Tie(text) => drop(writeln!(out, "# {} = \"{text}\"  # {}, {}", q.name, q.unit, q.meaning)),
            Default::Derived(_) => {}
        }
    }
    let free = problem.parameters().iter().find(|q| q.name == "p").or(problem.parameters().first());
    let free = free.map_or("p", |q| q.name);
    let observable = problem.observables().first().map_or("", |o| o.name);
    let _ = write!(
        out,
        r#"
[[task]]                     # equilibria over a range of one parameter, with eigenvalues and Hopf points
name = "straight"
kind = "equilibria"
free = "{free}"
range = [0, 500]
spectrum = 8
detect = ["HB"]

[[task]]                     # limit cycles from the first Hopf point
name = "beat"
kind = "cycles"
from = "straight/HB1"
free = "{free}"
range = [0, 400]
multipliers = 4
# values = {{ {free} = [360] }} # points wanted exactly there: beat/UZ1, ...

[[figure]]
name = "diagram"
x = "{free}"
y = ["max {observable}", "min {observable}"]
tasks = ["straight", "beat"]

[[figure]]
name = "eigenvalues"
kind = "eigenvalues"
tasks = ["straight"]
"#
    );
    Ok(out)
}
