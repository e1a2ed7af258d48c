//! What a curve starts from: the stored Hopf point and the two parameters as coordinates, checked.

use super::Curve;
use crate::bifurcation::{Coordinate, Hopf, HopfError, HopfNormalForm};
use crate::branch::SpecialPoint;
use crate::continuation::Failure;
use crate::problem::Problem;
use crate::run::start::{StartError, Stored};
use thiserror::Error;

#[derive(Debug, Error)]
pub(super) enum CurveError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error("the start is not a Hopf point any more: {0}")]
    Start(#[from] HopfError),
    #[error("{0} is not stored with its eigenvector")]
    Incomplete(String),
    #[error(transparent)]
    Place(#[from] StartError),
    #[error("neither {0} nor {1} moves the Hopf point: there is no curve in these parameters")]
    NoCurve(String, String),
    #[error("{0} changes neither the Hopf point nor its criticality: the problem does not depend on it here")]
    Idle(String),
}

/// Relative changes of sigma below this, over a whole range, are none.
const IDLE: f64 = 1e-10;

impl Curve<'_> {
    /// The stored point, solved for again in whichever parameter moves it.
    pub(super) fn hopf(&self, from: &SpecialPoint) -> Result<Hopf, CurveError> {
        let Stored { u, p, omega, q } =
            Stored::read(self.prepared, from).ok_or_else(|| CurveError::Incomplete(from.label.clone()))?;
        let problem = &*self.prepared.problem;
        let located = |free: usize| Hopf::locate(problem, (&u, &p), free, omega, &q);
        match located(self.prepared.first()) {
            Ok(hopf) => Ok(hopf),
            _ => located(self.prepared.free).map_err(|failure| match failure {
                // Newton's step is 0/0 where a parameter does not matter.
                HopfError::Diverged(step) if !step.is_finite() => {
                    CurveError::NoCurve(self.task.along.others[0].name.clone(), self.task.along.free.clone())
                }
                failure => failure.into(),
            }),
        }
    }

    /// One of the parameters must move the Hopf point, and each must change something.
    pub(super) fn check_influence(
        &self,
        hopf: &Hopf,
        (first, second): (Coordinate, Coordinate),
    ) -> Result<(), CurveError> {
        let problem = &*self.prepared.problem;
        let list = problem.parameters();
        let mut idle = Vec::new();
        for coordinate in [first, second] {
            let z = coordinate.of(hopf.p[coordinate.index]);
            let slope = hopf.clone().along(problem, coordinate.index)?.slope;
            if slope.norm() * coordinate.rate(z) * coordinate.width < IDLE * hopf.omega {
                idle.push(coordinate);
            }
        }
        match idle[..] {
            [a, b] => Err(CurveError::NoCurve(list[a.index].name.to_owned(), list[b.index].name.to_owned())),
            [one] => {
                let mut moved = hopf.clone();
                let z = one.of(hopf.p[one.index]);
                moved.p[one.index] = one.value(z + 0.01 * one.width);
                let form = |hopf: &Hopf| HopfNormalForm::new(problem, hopf);
                let (here, there) = (form(hopf)?.c1, form(&moved)?.c1);
                if (here - there).norm() < IDLE * here.norm() {
                    return Err(CurveError::Idle(list[one.index].name.to_owned()));
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
