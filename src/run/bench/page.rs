//! A study's part of the page of scenes.

use super::report::Report;
use super::table::{conclusion, significant, words};
use std::fmt::Write;
use std::path::Path;

impl Report {
    /// In Markdown, with a figure that lies at `figure`: what each error costs in each family, orders, how many printed
    /// errors hold.
    pub fn section(&self, figure: Option<&Path>) -> String {
        let machine = &self.machine;
        let mut out = format!("\n### {0}\n\n**{1}** ([`{0}.toml`](bench/{0}.toml))\n\n", self.bench, self.title);
        if let Some(figure) = figure {
            let _ = writeln!(out, "![{}]({})\n", self.title, figure.display());
        }
        for quantity in &self.quantities {
            let value =
                quantity.value.map_or("unknown".to_owned(), |value| format!("{value} ± {:.0e}", quantity.error));
            let _ = writeln!(out, "{} = {value} ({})\n", quantity.name, quantity.source);
            let names: Vec<&str> = self.families.iter().map(|family| family.name.as_str()).collect();
            let _ =
                writeln!(out, "| seconds to an error | {} |\n|---|{}", names.join(" | "), "---|".repeat(names.len()));
            for reach in self.reach.iter().filter(|reach| reach.quantity == quantity.name) {
                let cell = |name: &&str| reach.seconds.get(*name).map_or("-".to_owned(), |s| significant(*s));
                let cells: Vec<String> = names.iter().map(cell).collect();
                let _ = writeln!(out, "| {:.0e} | {} |", reach.error, cells.join(" | "));
            }
            out.push('\n');
            for family in &self.families {
                let _ = writeln!(out, "- {}: {}", family.name, conclusion(family, &quantity.name));
            }
            out.push('\n');
        }
        let _ = writeln!(
            out,
            "Printed errors of the study: {}. {:.0} s on {}, {} threads.",
            words(self.coverage()),
            self.seconds,
            machine.processor,
            machine.threads
        );
        out
    }
}
