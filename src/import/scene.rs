//! The text of a scene.

use super::Imported;
use std::fmt::Write;

impl Imported {
    /// A scene with the model and a first task.
    pub fn scene(&self, title: &str) -> String {
        let mut out = format!("title = {title:?}\n\n[model]\nequations = \"\"\"\n");
        for statement in &self.equations {
            let _ = writeln!(out, "{statement}");
        }
        out += "\"\"\"\n";
        let number = |value: &str| value.parse::<f64>().is_ok();
        let sections = [("parameters", &self.parameters), ("start", &self.start), ("observables", &self.observables)];
        for (section, entries) in sections {
            if entries.is_empty() {
                continue;
            }
            let _ = writeln!(out, "\n[model.{section}]");
            for (name, value) in entries {
                let _ = match number(value) && section != "observables" {
                    true => writeln!(out, "{name} = {value}"),
                    false => writeln!(out, "{name} = \"{value}\""),
                };
            }
        }
        let free = self.parameters.iter().find_map(|(name, value)| Some((name, value.parse::<f64>().ok()?)));
        if let Some((free, value)) = free {
            let wide = value.abs().max(1.0);
            let (from, to) = self.range.unwrap_or((value - wide, value + wide));
            let start = value.clamp(from, to);
            let _ = write!(
                out,
                "\n[[task]]                          # equilibria from the start; choose parameter and range\n\
                 name = \"steady\"\nkind = \"equilibria\"\nfree = \"{free}\"\nrange = [{from}, {to}]\nstart = {start}\n\
                 spectrum = 4\ndetect = [\"HB\", \"LP\"]\n"
            );
        }
        out
    }
}
