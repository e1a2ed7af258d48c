//! Reading `[[task]]`.

use super::entry::{Entry, Section};
use super::label::{self, Announced};
use super::simulate;
use super::tree::Content;
use super::{Along, Cycles, Equilibria, Fault, SceneError, Task, TaskKind, along, calibration, map, several};

/// Kinds of tasks, as a scene names them.
pub const TASK_KINDS: [&str; 11] = [
    "equilibria",
    "cycles",
    "hopf-curve",
    "fold-curve",
    "lpc-curve",
    "pd-curve",
    "ns-curve",
    "hopf-surface",
    "calibration",
    "map",
    "simulate",
];

const COMMON: [&str; 9] =
    ["name", "kind", "free", "range", "values", "max_step", "max_points", "observables", "errors"];
const EQUILIBRIA: [&str; 5] = ["log", "from", "start", "spectrum", "detect"];
const CYCLES: [&str; 7] = ["from", "intervals", "degree", "points", "multipliers", "symmetry", "detect"];
const CURVE: [&str; 9] = ["name", "kind", "from", "free", "range", "log", "values", "max_points", "errors"];
const CALIBRATION: [&str; 9] = ["name", "kind", "from", "free", "range", "log", "targets", "starts", "errors"];
const MAP: [&str; 7] = ["name", "kind", "free", "range", "log", "grid", "errors"];
const HOPF_SURFACE: [&str; 9] = ["name", "kind", "from", "free", "range", "log", "tolerance", "max_points", "errors"];

const MAX_COLUMNS: usize = 1000;

/// Reads one task; `read` are those before it, `announced` are all.
pub(super) fn read(
    section: &Section<'_>,
    name: String,
    read: &[Task],
    announced: &[Announced],
) -> Result<Task, SceneError> {
    // A misspelt "kind" is to be named as such, so first the keys that no kind knows.
    section.allow(
        "key",
        &[&COMMON[..], &EQUILIBRIA, &CYCLES, &["targets", "starts", "grid", "tolerance"], &simulate::OWN].concat(),
    )?;
    let kinds = TASK_KINDS.map(|kind| format!("{kind:?}")).join(" or ");
    let kind = section.need("kind", &format!("kind = {kinds}"))?;
    let kind = match kind.choice("task kind", &TASK_KINDS)? {
        "cycles" => {
            section.allow("key of a cycles task", &[&COMMON[..], &CYCLES].concat())?;
            TaskKind::Cycles(cycles(section, read, announced)?)
        }
        "hopf-curve" => {
            section.allow("key of a hopf-curve task", &CURVE)?;
            TaskKind::HopfCurve(several::curve(
                section,
                read,
                announced,
                "from = \"TASK/HB1\", a Hopf point of the curve",
            )?)
        }
        "fold-curve" => {
            section.allow("key of a fold-curve task", &CURVE)?;
            TaskKind::FoldCurve(several::curve(section, read, announced, "from = \"TASK/LP1\", a fold of the curve")?)
        }
        kind @ ("lpc-curve" | "pd-curve" | "ns-curve") => {
            section.allow("key of a curve of cycles", &CURVE)?;
            let example = match kind {
                "lpc-curve" => "from = \"TASK/LPC1\", a fold of cycles",
                "pd-curve" => "from = \"TASK/PD1\", a period doubling",
                _ => "from = \"TASK/NS1\", a torus bifurcation",
            };
            let curve = several::curve(section, read, announced, example)?;
            match kind {
                "lpc-curve" => TaskKind::LpcCurve(curve),
                "pd-curve" => TaskKind::PdCurve(curve),
                _ => TaskKind::NsCurve(curve),
            }
        }
        "calibration" => {
            section.allow("key of a calibration task", &CALIBRATION)?;
            TaskKind::Calibration(calibration::read(section, read, announced)?)
        }
        "simulate" => {
            section.allow("key of a simulate task", &simulate::KEYS)?;
            TaskKind::Simulate(simulate::read(section, read, announced)?)
        }
        "map" => {
            section.allow("key of a map task", &MAP)?;
            TaskKind::Map(map::task(section)?)
        }
        "hopf-surface" => {
            section.allow("key of a hopf-surface task", &HOPF_SURFACE)?;
            TaskKind::HopfSurface(several::surface(section, read, announced)?)
        }
        _ => {
            section.allow("key of an equilibria task", &[&COMMON[..], &EQUILIBRIA].concat())?;
            TaskKind::Equilibria(equilibria(section, read, announced)?)
        }
    };
    Ok(Task { name, kind, at: section.at.clone() })
}

fn equilibria(section: &Section<'_>, read: &[Task], announced: &[Announced]) -> Result<Equilibria, SceneError> {
    let along = along::read(section)?;
    let from = match section.get("from") {
        Some(entry) => {
            label::check(entry.text()?, read, announced).map_err(|fault| entry.error(fault))?;
            if let Some(start) = section.get("start") {
                return Err(start
                    .error(Fault::Other("a branch starts at a point (from) or at a value (start); keep one".into())));
            }
            Some((entry.text()?.to_owned(), entry.at))
        }
        None => None,
    };
    Ok(Equilibria {
        from,
        start: match section.get("start") {
            Some(entry) => Some(inside(&entry, &along)?),
            None => None,
        },
        along,
        spectrum: match section.get("spectrum") {
            Some(entry) => entry.count(0..=MAX_COLUMNS)?,
            None => 0,
        },
        detect: match section.get("detect") {
            Some(entry) => detect(&entry, &["HB", "LP", "BP"])?,
            None => Vec::new(),
        },
    })
}

/// A number in the range of the free parameter.
fn inside(entry: &Entry<'_>, along: &Along) -> Result<f64, SceneError> {
    let (value, (from, to)) = (entry.number()?, (along.range.from, along.range.to));
    if (from..=to).contains(&value) { Ok(value) } else { Err(entry.error(Fault::OutsideRange { value, from, to })) }
}

fn detect(entry: &Entry<'_>, kinds: &[&'static str]) -> Result<Vec<String>, SceneError> {
    for item in entry.list(&format!("a list such as {kinds:?}"))? {
        item.choice("kind of point to detect", kinds)?;
    }
    entry.texts()
}

fn cycles(section: &Section<'_>, read: &[Task], announced: &[Announced]) -> Result<Cycles, SceneError> {
    let from = section.need("from", "from = \"TASK/HB1\", the point where the cycles are born")?;
    label::check(from.text()?, read, announced).map_err(|fault| from.error(fault))?;
    Ok(Cycles {
        along: along::read(section)?,
        from: from.text()?.to_owned(),
        from_at: from.at,
        intervals: match section.get("intervals") {
            Some(entry) => Some(entry.count(2..=10_000)?),
            None => None,
        },
        detect: match section.get("detect") {
            Some(entry) => detect(&entry, &["LPC", "PD", "NS", "BPC"])?,
            None => Vec::new(),
        },
        degree: match section.get("degree") {
            Some(entry) => entry.count(2..=7)?,
            None => 4,
        },
        multipliers: match section.get("multipliers") {
            Some(entry) => multipliers(&entry)?,
            None => 0,
        },
        gauss: match section.get("points") {
            Some(entry) => entry.choice("points", &["radau", "gauss"])? == "gauss",
            None => false,
        },
        symmetry: match section.get("symmetry") {
            Some(entry) => entry.choice("symmetry", &["auto", "none"])? == "auto",
            None => true,
        },
    })
}

fn multipliers(entry: &Entry<'_>) -> Result<usize, SceneError> {
    match entry.node.content {
        Content::Flag(true) => Ok(6),
        Content::Flag(false) => Ok(0),
        Content::Integer(_) => entry.count(0..=MAX_COLUMNS),
        _ => entry.type_error(&format!("true, false or a whole number from 0 to {MAX_COLUMNS}")),
    }
}
