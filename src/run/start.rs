//! Hopf points that tasks start from: which may be named, and what of them was stored.

use super::study::Prepared;
use crate::branch::SpecialPoint;
use crate::linalg::c64;
use crate::problem::Problem;
use crate::scene::{Label, Place, Scene, SceneError, TaskKind};

/// Cycles and curves start at a Hopf point: of a branch of equilibria, or at a wanted value or end of a Hopf curve.
pub fn check(scene: &Scene, from: &str, at: &Place) -> Result<(), SceneError> {
    let allowed = Label::parse(from).and_then(|label| {
        let task = scene.tasks.iter().find(|task| task.name == label.task)?;
        Some(match task.kind {
            TaskKind::Equilibria(_) => label.kind == "HB",
            TaskKind::HopfCurve(_) => ["UZ", "EP", "GH"].contains(&label.kind),
            TaskKind::Cycles(_) | TaskKind::HopfSurface(_) => false,
        })
    });
    match allowed {
        Some(true) => Ok(()),
        _ => Err(scene.refuse(
            at,
            format!(
                "the start must be a Hopf point, such as \"TASK/HB1\" of a task of kind \"equilibria\" or \"TASK/UZ1\" of \
                 one of kind \"hopf-curve\", not {from:?}"
            ),
        )),
    }
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
        let list = prepared.problem.parameters();
        Some(Self {
            u: array("state")?.clone(),
            p: list.iter().map(|q| from.parameters.get(q.name).copied().unwrap_or(f64::NAN)).collect(),
            omega: *from.values.get("omega")?,
            q: re.iter().zip(im).map(|(&re, &im)| c64::new(re, im)).collect(),
        })
    }
}
