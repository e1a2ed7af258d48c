//! Points that tasks start from: which may be named, and what of them was stored.

use super::study::Prepared;
use crate::bifurcation::Coordinate;
use crate::branch::SpecialPoint;
use crate::linalg::c64;
use crate::problem::Problem;
use crate::scene::{self, Along, Label, Place, Range, Scene, SceneError, TaskKind, owner};
use thiserror::Error;

/// Cycles and curves start at a Hopf point: of a branch of equilibria, at a wanted value or end of a Hopf curve, or
/// found by a calibration.
pub fn check(scene: &Scene, from: &str, at: &Place) -> Result<(), SceneError> {
    let allowed = Label::parse(from).and_then(|label| {
        let task = owner(&scene.tasks, label.task)?;
        Some(match task.kind {
            TaskKind::Equilibria(_) | TaskKind::Diagram(_) => label.kind == "HB",
            TaskKind::HopfCurve(_) => ["UZ", "EP", "GH"].contains(&label.kind),
            TaskKind::Calibration(_) => label.kind == "UZ",
            _ => false,
        })
    });
    match allowed {
        Some(true) => Ok(()),
        _ => Err(scene.refuse(
            at,
            format!(
                "the start must be a Hopf point, such as \"TASK/HB1\" of a task of kind \"equilibria\" or \"TASK/UZ1\" of \
                 one of kind \"hopf-curve\" or \"calibration\", not {from:?}"
            ),
        )),
    }
}

#[derive(Debug, Error)]
pub enum StartError {
    #[error("the start has {name} = {value}, which does not lie inside the range {from} to {to}")]
    Outside { name: String, value: f64, from: f64, to: f64 },
    #[error("{0} is logarithmic, but the start has {0} = {1}")]
    NotPositive(String, f64),
}

/// A first parameter without a range counts in parts of so many times its value at the start: the second sets the pace.
const WIDE: f64 = 10.0;

/// A free parameter as a coordinate; the start, with parameters p, must lie inside its range.
pub fn coordinate(
    prepared: &Prepared,
    along: &Along,
    (index, range): (usize, Option<&Range>),
    p: &[f64],
) -> Result<Coordinate, StartError> {
    let name = prepared.problem.parameters()[index].name.to_owned();
    let logarithmic = along.logarithmic.contains(&name);
    let value = p[index];
    if logarithmic && value <= 0.0 {
        return Err(StartError::NotPositive(name, value));
    }
    let mut coordinate = Coordinate { index, logarithmic, width: 1.0 };
    match range {
        Some(range) => {
            let slack = 1e-12 * (range.to - range.from);
            if !(range.from - slack..=range.to + slack).contains(&value) {
                return Err(StartError::Outside { name, value, from: range.from, to: range.to });
            }
            coordinate.width = coordinate.of(range.to) - coordinate.of(range.from);
        }
        None if !logarithmic && value != 0.0 => coordinate.width = WIDE * value.abs(),
        None => {}
    }
    Ok(coordinate)
}

/// Both free parameters of a curve.
pub fn coordinates(prepared: &Prepared, along: &Along, p: &[f64]) -> Result<(Coordinate, Coordinate), StartError> {
    let range = along.others.first().and_then(|axis| axis.range.as_ref());
    let make = |index, range| coordinate(prepared, along, (index, range), p);
    Ok((make(prepared.first(), range)?, make(prepared.free, Some(&along.range))?))
}

/// Curves start at a point of their kind; that its task finds such points is known of a label.
pub fn check_point(
    scene: &Scene,
    (from, at): (&str, &Place),
    (kind, what): (&str, &str),
    of: &str,
) -> Result<(), SceneError> {
    if Label::parse(from).is_some_and(|label| label.kind == kind) {
        return Ok(());
    }
    let message = format!("the start must be {what}, such as \"TASK/{kind}1\" of a task of kind {of:?}, not {from:?}");
    Err(scene.refuse(at, message))
}

/// Branches of equilibria start at any equilibrium.
pub fn check_equilibrium(scene: &Scene, from: &str, at: &Place) -> Result<(), SceneError> {
    let label = Label::parse(from);
    let task = label.and_then(|label| owner(&scene.tasks, label.task));
    match task.map(|task| &task.kind) {
        Some(
            TaskKind::Equilibria(_)
            | TaskKind::Diagram(_)
            | TaskKind::HopfCurve(_)
            | TaskKind::FoldCurve(_)
            | TaskKind::BranchPointCurve(_)
            | TaskKind::Calibration(_),
        ) => Ok(()),
        _ => Err(scene.refuse(
            at,
            format!(
                "the start must be an equilibrium, such as \"TASK/BP1\" of a task of kind \"equilibria\", not {from:?}"
            ),
        )),
    }
}

/// Whether a start is a cycle: a point of another task of cycles, or samples in a file.
pub fn is_cycle(scene: &Scene, from: &str) -> bool {
    let of_cycles = |label: Label| {
        let task = owner(&scene.tasks, label.task);
        match task.map(|task| &task.kind) {
            Some(TaskKind::Cycles(_)) => true,
            Some(TaskKind::Simulate(_)) => label.kind == "LC",
            _ => false,
        }
    };
    scene::is_file(from) || Label::parse(from).is_some_and(of_cycles)
}

/// Relative periodic orbits are those of models with rotations, and start at cycles.
pub fn check_relative(scene: &Scene, prepared: &Prepared, from: &str, at: &Place) -> Result<(), SceneError> {
    if prepared.problem.rotations().is_empty() {
        let message =
            "relative = true needs a model with rotations, such as rotations = [\"x -> -y, y -> x\"] in [model]";
        return Err(scene.refuse(at, message.to_owned()));
    }
    let label = Label::parse(from);
    let task = label.and_then(|label| scene.tasks.iter().find(|task| task.name == label.task));
    match (label, task.map(|task| &task.kind)) {
        (Some(label), Some(TaskKind::Cycles(_))) if ["NS", "UZ", "EP"].contains(&label.kind) => Ok(()),
        _ => Err(scene.refuse(
            at,
            format!(
                "relative periodic orbits start at \"TASK/NS1\" (a rotating wave), \"TASK/UZ1\" or \"TASK/EP1\" of a \
                 task of kind \"cycles\", not at {from:?}"
            ),
        )),
    }
}

/// State and parameters of a stored equilibrium.
pub fn equilibrium(prepared: &Prepared, from: &SpecialPoint) -> Option<(Vec<f64>, Vec<f64>)> {
    let list = prepared.problem.parameters();
    let p = list.iter().map(|q| from.parameters.get(q.name).copied().unwrap_or(f64::NAN)).collect();
    Some((from.arrays.get("state")?.data.clone(), p))
}

/// State, parameters, frequency and eigenvector of a stored Hopf point; None where any is missing.
pub struct Stored {
    pub u: Vec<f64>,
    pub p: Vec<f64>,
    pub omega: f64,
    pub q: Vec<c64>,
}

impl Stored {
    pub fn read(prepared: &Prepared, from: &SpecialPoint) -> Option<Self> {
        let array = |name: &str| from.arrays.get(name).map(|a| &a.data);
        let (re, im) = (array("q_re")?, array("q_im")?);
        let (u, p) = equilibrium(prepared, from)?;
        Some(Self {
            u,
            p,
            omega: *from.values.get("omega")?,
            q: re.iter().zip(im).map(|(&re, &im)| c64::new(re, im)).collect(),
        })
    }
}
