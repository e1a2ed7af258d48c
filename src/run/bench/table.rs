//! The table of a study, for people.

use super::fit::Power;
use super::report::{Coverage, FamilyLine, QuantityLine, Report, SettingLine, named};
use std::fmt::Write;

impl Report {
    pub fn table(&self, folder: &str) -> String {
        let mut out = format!("{}\n", self.title);
        let machine = &self.machine;
        let _ = writeln!(out, "{}, {} cores, {} threads", machine.processor, machine.cores, machine.threads);
        for quantity in &self.quantities {
            self.errors(&mut out, quantity);
            self.reach(&mut out, quantity);
        }
        let _ = writeln!(out, "\nprinted errors: {}", words(self.coverage()));
        let interrupted = if self.interrupted { "interrupted; " } else { "" };
        let _ = writeln!(out, "{interrupted}{:.1} s; data and figures in {folder}", self.seconds);
        out
    }

    fn errors(&self, out: &mut String, quantity: &QuantityLine) {
        let name = &quantity.name;
        let value = quantity.value.map_or("unknown".to_owned(), |value| format!("{value} ± {:.0e}", quantity.error));
        let _ = writeln!(out, "\n{name} = {value} ({})", quantity.source);
        let setting = |line: &SettingLine| named(&line.setting);
        let lines = self.families.iter().flat_map(|family| &family.settings);
        let width = lines.map(|line| setting(line).chars().count()).max().unwrap_or(0).max(20);
        for family in &self.families {
            let _ = writeln!(
                out,
                "\n  {:width$} {:>9} {:>9} {:>7}  {:>9} {:>21} {:>9} {:>5} {:>9} {:>8} {:>8}",
                format!("{} ({})", family.name, family.point),
                "error",
                "printed",
                "ratio",
                "seconds",
                "(least to most)",
                "processor",
                "runs",
                "unknowns",
                "factors",
                "spectra"
            );
            for line in &family.settings {
                let _ = writeln!(out, "  {:width$} {}", setting(line), row(line, name));
            }
            let _ = writeln!(out, "  {}", conclusion(family, name));
        }
    }

    /// What an error costs in each family, and how many times more than in the fastest.
    fn reach(&self, out: &mut String, quantity: &QuantityLine) {
        let rows: Vec<_> = self.reach.iter().filter(|reach| reach.quantity == quantity.name).collect();
        if rows.is_empty() || self.families.len() < 2 {
            return;
        }
        let _ = write!(out, "\n  {:20}", "seconds to an error");
        for family in &self.families {
            let _ = write!(out, " {:>20}", family.name);
        }
        for reach in rows {
            let _ = write!(out, "\n  {:20}", format!("of {:.0e}", reach.error));
            let fastest = reach.seconds.values().copied().fold(f64::INFINITY, f64::min);
            for family in &self.families {
                let cell = reach.seconds.get(&family.name).map_or("-".to_owned(), |seconds| {
                    format!("{} (x {})", significant(*seconds), significant(seconds / fastest))
                });
                let _ = write!(out, " {cell:>20}");
            }
        }
        out.push('\n');
    }
}

fn row(line: &SettingLine, quantity: &str) -> String {
    let seconds = &line.seconds;
    let taken = format!(
        "{:>9} {:>21} {:>9} {:>5}",
        significant(seconds.median),
        format!("({} to {})", significant(seconds.least), significant(seconds.most)),
        seconds.processor.map_or("-".to_owned(), significant),
        seconds.runs
    );
    let Some(found) = line.found.get(quantity) else {
        let reason = line.reason.as_deref().unwrap_or("the point has no such number");
        return format!("{:>9} {:>9} {:>7}  {taken}  {reason}", "-", "-", "-");
    };
    let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.1e}"));
    // A miss is marked.
    let mark = if found.covered == Some(false) { "<" } else { " " };
    format!(
        "{:>9} {:>9} {:>7}{mark} {taken} {:>9} {:>8} {:>8}",
        number(Some(found.error)),
        number(found.printed),
        found.ratio.map_or("-".to_owned(), significant),
        line.unknowns.map_or("-".to_owned(), |unknowns| unknowns.to_string()),
        line.counts.factorisations,
        line.counts.spectra
    )
}

pub(super) fn conclusion(family: &FamilyLine, quantity: &str) -> String {
    let law = |law: Option<Power>, what: &str| {
        law.map(|law| {
            let deviation = law.deviation.map_or(String::new(), |deviation| format!(" ± {deviation:.1}"));
            format!("{:.1}{deviation} in {what}", law.exponent)
        })
    };
    let orders = family.orders.get(quantity);
    let laws = orders.map_or([None, None], |o| [law(o.unknowns, "unknowns"), law(o.seconds, "seconds")]);
    let laws: Vec<String> = laws.into_iter().flatten().collect();
    let order = if laws.is_empty() { "no order".to_owned() } else { format!("order {}", laws.join(", ")) };
    let coverage = family.coverage.get(quantity).copied().unwrap_or_default();
    format!("{order}; printed errors: {}", words(coverage))
}

pub(super) fn words(coverage: Coverage) -> String {
    let open = match coverage.undecided {
        0 => String::new(),
        n => format!(", {n} undecided"),
    };
    match coverage.cases {
        0 => format!("none to judge{open}"),
        n => format!("{} of {n} are at least the true ones ({:.0} %){open}", coverage.covered, coverage.percent()),
    }
}

/// Three digits.
pub(super) fn significant(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) {
        return format!("{value:.1e}");
    }
    let decimals = if value == 0.0 { 0 } else { (2.0 - value.abs().log10().floor()).clamp(0.0, 5.0) as usize };
    format!("{value:.decimals$}")
}
