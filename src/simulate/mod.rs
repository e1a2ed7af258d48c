//! Time integration of `G(u, u', p) = 0`, and what it settles on.
//!
//! All masses, constant, singular or dependent on the solution, are integrated in one form. With `d` the unknowns whose
//! rates the equations hold (the columns of `G_v` that are not zero) and `a` the others,
//!
//! ```text
//! u_d' = v_d,
//! 0    = G(u, v, p)      v = (v_d, 0),
//! ```
//!
//! a system for (u, v_d) with a constant diagonal mass, of index 1 wherever `[G_{v_d}, G_{u_a}]` is regular. Inverting
//! the mass instead would fill a sparse Jacobian and exclude singular masses; here the matrix of a Newton step is as
//! sparse as `G_u` and `G_v`, and the sparse LU eliminates the first rows without fill, so that the rates cost nothing.
//! Local errors are controlled in u alone: the rates follow from u (Brenan, Campbell and Petzold 1996,
//! doi:10.1137/1.9781611971224, chapter 5).

mod attractor;
mod drift;
mod equations;
mod event;
mod form;
mod integrate;
mod returns;
mod ring;

pub use attractor::{Attractor, Cycle, Search, Settled, settle};
pub use event::{Direction, Event};
pub use integrate::{Control, Course, Method, Motion, Step, integrate};
pub use returns::Range;
pub use ring::Ring;

use thiserror::Error;

/// Why a motion could not be followed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SimulateError {
    #[error("the start is not finite; give it numbers inside the model's domain")]
    Start,
    #[error(
        "no consistent start: with the differential unknowns as given, the algebraic equations could not be solved \
         (the residual falls to {residual:.1e} of what it was); start closer to a solution of them"
    )]
    Inconsistent { residual: f64 },
    #[error(
        "the equations cannot be solved for the rates and the algebraic unknowns at t = {time}: the matrix \
         [dG/dv, dG/du] of these is singular, so that the problem is no differential-algebraic one of index 1 there"
    )]
    Index { time: f64 },
    #[error("the equations have no finite value at t = {time}; the motion leaves the model's domain there")]
    NotFinite { time: f64 },
    #[error(
        "the rate of unknown {unknown} entered the equations at t = {time}, but its column of the mass is zero at the \
         start; start elsewhere"
    )]
    Rate { unknown: usize, time: f64 },
    #[error(
        "the step size fell below {step:.1e} at t = {time}: the solution is not smooth there, or grows without bound"
    )]
    Step { time: f64, step: f64 },
    #[error("the integrator gave up at t = {time}: {reason}")]
    Integrator { time: f64, reason: String },
}
