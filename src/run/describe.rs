//! `hopfline models`: what there is to compute on.

use super::RunError;
use crate::models::{Options, REGISTRY, find};
use crate::problem::Default;
use crate::scene::Fault;
use std::fmt::Write;

/// A line a model.
pub fn models() -> String {
    let list: String = REGISTRY.iter().map(|model| format!("{:14} {}\n", model.name, model.meaning)).collect();
    list + "\nAny other model is written in the scene: [model] with equations = \"x' = ...\" (README: Write a model as text).\n"
}

/// Options, parameters and observables of a model.
pub fn one_model(name: &str) -> Result<String, RunError> {
    let model = find(name)
        .ok_or_else(|| RunError::Input(Fault::unknown("model", name, REGISTRY.iter().map(|m| m.name)).to_string()))?;
    let problem = (model.build)(&Options::default()).map_err(|e| RunError::Input(e.to_string()))?;
    let mut out = format!("{}: {}\n\noptions ([model])\n", model.name, model.meaning);
    for (option, values, meaning) in model.options {
        let _ = writeln!(out, "  {option:10} {values:28} {meaning}");
    }
    let _ = writeln!(out, "\nparameters ([parameters])");
    for q in problem.parameters() {
        let default = match q.default {
            Default::Value(x) => format!("{x}"),
            Default::Tie(text) => text.to_owned(),
            Default::Derived(text) => format!("always {text}"),
        };
        let _ = writeln!(out, "  {:6} {:24} {:12} {:12} {}", q.name, default, q.unit, q.bounds, q.meaning);
    }
    for (option, values, _) in model.options {
        // Some parameters exist only with some options.
        let other = values.split('|').nth(1).map(|v| v.trim().trim_matches('"').to_owned());
        let Some(other) = other else { continue };
        let mut options = Options::default();
        options.0.insert((*option).to_owned(), crate::models::Choice::Text(other.clone()));
        let Ok(varied) = (model.build)(&options) else { continue };
        for q in varied.parameters().iter().filter(|q| !problem.parameters().iter().any(|p| p.name == q.name)) {
            let default = if let Default::Value(x) = q.default { format!("{x}") } else { String::new() };
            let _ = writeln!(
                out,
                "  {:6} {default:24} {:12} {:12} {} (only with {option} = \"{other}\")",
                q.name, q.unit, q.bounds, q.meaning
            );
        }
    }
    let _ = writeln!(out, "\nobservables");
    for o in problem.observables() {
        let _ = writeln!(out, "  {:20} {:8} {}", o.name, o.unit, o.meaning);
    }
    Ok(out)
}
