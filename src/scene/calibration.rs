//! Reading `kind = "calibration"`: unknown parameters, their ranges, the targets.

use std::collections::BTreeMap;

use super::entry::{Entry, Section};
use super::label::{self, Announced, Label};
use super::several::{among, ranges};
use super::{Along, Axis, Calibration, Fault, Range, SceneError, Task, TaskKind, Wanted};

/// Numbers of a Hopf point that can be targets, besides the parameter that is solved for.
pub const QUANTITIES: [&str; 5] = ["omega", "frequency", "lyapunov", "dsigma_re", "dsigma_im"];
const MOST_STARTS: usize = 10_000;
const STARTS: usize = 16;

pub(super) fn read(section: &Section<'_>, read: &[Task], announced: &[Announced]) -> Result<Calibration, SceneError> {
    let from = section.need("from", "from = \"TASK/HB1\", the Hopf point that is to meet the targets")?;
    label::check(from.text()?, read, announced).map_err(|fault| from.error(fault))?;
    let source = Label::parse(from.text()?).filter(|label| label.kind == "HB").and_then(|label| {
        let task = read.iter().find(|task| task.name == label.task)?;
        matches!(task.kind, TaskKind::Equilibria(_)).then(|| task.kind.along().free.clone())
    });
    let Some(solved) = source else {
        let message = format!(
            "a calibration starts at a Hopf point of a task of kind \"equilibria\", such as \"TASK/HB1\", not {:?}",
            from.text()?
        );
        return Err(from.error(Fault::Other(message)));
    };
    let free = section.need("free", "free = [\"L\"], the parameters to find")?;
    let names = free.texts()?;
    if names.is_empty() {
        return Err(free.error(Fault::Empty { expected: "at least one parameter".to_owned() }));
    }
    if names.contains(&solved) {
        let message = format!("{solved} is solved for at {}: it can be a target, not an unknown", from.text()?);
        return Err(free.error(Fault::Other(message)));
    }
    let targets = targets(section, &solved)?;
    if names.len() > targets.len() {
        let message = format!(
            "{} unknowns ({}) need at least as many targets; there are {}: {}",
            names.len(),
            names.join(", "),
            targets.len(),
            targets.iter().map(|t| t.quantity.as_str()).collect::<Vec<_>>().join(", ")
        );
        return Err(free.error(Fault::Other(message)));
    }
    let along = along(section, &free, names, solved)?;
    let starts = match section.get("starts") {
        Some(entry) => entry.count(1..=MOST_STARTS)?,
        None => STARTS,
    };
    Ok(Calibration { along, from: from.text()?.to_owned(), from_at: from.at, targets, starts })
}

/// The parameter that is solved for, without a range, and the unknowns, each with one.
fn along(section: &Section<'_>, free: &Entry<'_>, names: Vec<String>, solved: String) -> Result<Along, SceneError> {
    let logarithmic = match section.get("log") {
        Some(entry) => among(&entry, &names)?,
        None => Vec::new(),
    };
    let mut bounded: Vec<(String, Range)> = Vec::new();
    for (name, range) in names.iter().zip(ranges(section, &names, &logarithmic)?) {
        let Some(range) = range else {
            let example = format!("range = {{ {name} = [from, to] }}");
            return Err(section.error(Fault::Missing { what: format!("the range of {name:?}"), example }));
        };
        bounded.push((name.clone(), range));
    }
    let Some((last, range)) = bounded.pop() else {
        return Err(free.error(Fault::Empty { expected: "at least one parameter".to_owned() }));
    };
    let unknowns = bounded.into_iter().map(|(name, range)| Axis { name, range: Some(range) });
    Ok(Along {
        free: last,
        free_at: free.at.clone(),
        range,
        others: std::iter::once(Axis { name: solved, range: None }).chain(unknowns).collect(),
        logarithmic,
        values: BTreeMap::new(),
        max_step: None,
        max_points: 1,
        observables: Vec::new(),
        errors: match section.get("errors") {
            Some(entry) => entry.flag()?,
            None => true,
        },
        places: section.entries().map(|(key, entry)| (key.to_owned(), entry.at)).collect(),
    })
}

/// `{ p = 450, frequency = { value = 30, sigma = 1 } }`: all with a standard deviation, or none.
fn targets(section: &Section<'_>, solved: &str) -> Result<Vec<Wanted>, SceneError> {
    let example = format!("{{ {solved} = 450 }} or {{ {solved} = {{ value = 450, sigma = 5 }} }}");
    let entry = section.need("targets", &format!("targets = {example}"))?;
    let mut targets: Vec<Wanted> = Vec::new();
    for (name, entry) in entry.section(&format!("a table such as {example}"))?.entries() {
        if name != solved && !QUANTITIES.contains(&name) {
            return Err(entry.error(Fault::unknown("target", name, [solved].into_iter().chain(QUANTITIES))));
        }
        let (value, sigma) = match entry.section("a number, or { value = NUMBER, sigma = NUMBER }") {
            Ok(table) => {
                table.allow("key of a target", &["value", "sigma"])?;
                let sigma = table.get("sigma").map(|sigma| sigma.positive()).transpose()?;
                (table.need("value", "value = NUMBER")?.number()?, sigma)
            }
            Err(_) => (entry.number()?, None),
        };
        targets.push(Wanted { quantity: name.to_owned(), value, sigma, at: entry.at });
    }
    if targets.is_empty() {
        return Err(entry.error(Fault::Empty { expected: example }));
    }
    let (given, bare): (Vec<&Wanted>, Vec<&Wanted>) = targets.iter().partition(|target| target.sigma.is_some());
    if let (Some(given), Some(bare)) = (given.first(), bare.first()) {
        let message = format!(
            "{} has a sigma, {} has none; give all targets one (its standard deviation), or none",
            given.quantity, bare.quantity
        );
        return Err(entry.error(Fault::Other(message)));
    }
    Ok(targets)
}
