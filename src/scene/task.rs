//! Reading `[[task]]`.

use super::entry::{Entry, Section};
use super::label::{self, Announced};
use super::simulate;
use super::tree::Content;
use super::{
    Along, CycleKind, Cycles, Equilibria, Fault, SceneError, Task, TaskKind, along, calibration, diagram, map, several,
};

/// Kinds of tasks, as a scene names them.
const TASK_KINDS: [&str; 14] = [
    "equilibria",
    "diagram",
    "cycles",
    "hopf-curve",
    "fold-curve",
    "branch-point-curve",
    "lpc-curve",
    "pd-curve",
    "bpc-curve",
    "ns-curve",
    "hopf-surface",
    "calibration",
    "map",
    "simulate",
];

const COMMON: [&str; 9] =
    ["name", "kind", "free", "range", "values", "max_step", "max_points", "observables", "errors"];
const EQUILIBRIA: [&str; 7] = ["log", "from", "start", "state", "spectrum", "all_eigenvalues", "detect"];
const CYCLES: [&str; 9] =
    ["from", "intervals", "tolerance", "degree", "points", "multipliers", "symmetry", "detect", "relative"];
const CURVE: [&str; 9] = ["name", "kind", "from", "free", "range", "log", "values", "max_points", "errors"];
/// Folds and branch points are compared with no finer discretisation.
const STEADY_CURVE: [&str; 8] = ["name", "kind", "from", "free", "range", "log", "values", "max_points"];
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
        &[
            &COMMON[..],
            &EQUILIBRIA,
            &CYCLES,
            &["targets", "starts", "grid", "tolerance"],
            &diagram::KEYS,
            &simulate::OWN,
        ]
        .concat(),
    )?;
    let kinds = TASK_KINDS.map(|kind| format!("{kind:?}")).join(" or ");
    let kind = section.need("kind", &format!("kind = {kinds}"))?;
    let kind = match kind.choice("task kind", &TASK_KINDS)? {
        "cycles" => {
            section.allow("key of a cycles task", &[&COMMON[..], &CYCLES].concat())?;
            TaskKind::Cycles(cycles(section, read, announced)?)
        }
        "diagram" => {
            section.allow("key of a diagram task", &diagram::KEYS)?;
            TaskKind::Diagram(Box::new(diagram::read(section, &name)?))
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
            section.allow("key of a fold-curve task", &STEADY_CURVE)?;
            TaskKind::FoldCurve(several::curve(section, read, announced, "from = \"TASK/LP1\", a fold of the curve")?)
        }
        "branch-point-curve" => {
            section.allow("key of a branch-point-curve task", &STEADY_CURVE)?;
            let example = "from = \"TASK/BP1\", a branch point of the curve";
            TaskKind::BranchPointCurve(several::curve(section, read, announced, example)?)
        }
        kind @ ("lpc-curve" | "pd-curve" | "bpc-curve" | "ns-curve") => {
            section.allow("key of a curve of cycles", &CURVE)?;
            let kind = CycleKind::ALL.into_iter().find(|known| known.task() == kind).unwrap_or(CycleKind::Ns);
            let (point, what) = kind.point();
            let example = format!("from = \"TASK/{point}1\", {what}");
            TaskKind::CycleCurve(kind, several::curve(section, read, announced, &example)?)
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
            for key in ["start", "state"] {
                if let Some(other) = section.get(key) {
                    let message = format!(
                        "a branch starts at a point (from) or near a state (start, state); leave out from or {key}"
                    );
                    return Err(other.error(Fault::Other(message)));
                }
            }
            Some((entry.text()?.to_owned(), entry.at))
        }
        None => None,
    };
    Ok(Equilibria {
        from,
        guess: section.get("state").map(|entry| diagram::guess(&entry)).transpose()?,
        bounds: Vec::new(),
        start: match section.get("start") {
            Some(entry) => Some(inside(&entry, &along)?),
            None => None,
        },
        along,
        spectrum: match section.get("spectrum") {
            Some(entry) => entry.count(0..=MAX_COLUMNS)?,
            None => 0,
        },
        all_eigenvalues: section.get("all_eigenvalues").map(|entry| entry.flag()).transpose()?,
        detect: match section.get("detect") {
            Some(entry) => detect(&entry, &["HB", "LP", "BP"])?,
            None => Vec::new(),
        },
    })
}

/// A number in the range of the free parameter.
pub(super) fn inside(entry: &Entry<'_>, along: &Along) -> Result<f64, SceneError> {
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
    let relative = match section.get("relative") {
        Some(entry) => entry.flag()?,
        None => false,
    };
    if let (true, Some(detect)) = (relative, section.get("detect"))
        && detect.texts()?.iter().any(|kind| kind == "BPC")
    {
        let message = "branch points of relative periodic orbits are not looked for; only LPC, PD and NS are";
        return Err(detect.error(Fault::Other(message.to_owned())));
    }
    if !is_file(from.text()?) {
        label::check(from.text()?, read, announced).map_err(|fault| from.error(fault))?;
    }
    Ok(Cycles {
        relative,
        along: along::read(section)?,
        from: from.text()?.to_owned(),
        from_at: from.at,
        intervals: match section.get("intervals") {
            Some(entry) => Some(entry.count(2..=10_000)?),
            None => None,
        },
        tolerance: match section.get("tolerance") {
            Some(entry) => Some(tolerance(&entry)?),
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

/// Whether a start is a file of samples rather than a label.
pub fn is_file(from: &str) -> bool {
    from.ends_with(".csv")
}

/// A relative error.
fn tolerance(entry: &Entry<'_>) -> Result<f64, SceneError> {
    let found = entry.positive()?;
    if (1e-13..1.0).contains(&found) {
        return Ok(found);
    }
    let allowed = "an error relative to the size of the orbit, from 1e-13 to below 1".to_owned();
    Err(entry.error(Fault::OutOfBounds { found: found.to_string(), allowed }))
}

pub(super) fn multipliers(entry: &Entry<'_>) -> Result<usize, SceneError> {
    match entry.node.content {
        Content::Flag(true) => Ok(6),
        Content::Flag(false) => Ok(0),
        Content::Integer(_) => entry.count(0..=MAX_COLUMNS),
        _ => entry.type_error(&format!("true, false or a whole number from 0 to {MAX_COLUMNS}")),
    }
}
