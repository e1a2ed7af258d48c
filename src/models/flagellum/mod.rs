//! Models of beating flagella.

mod build;
mod linearisation;
mod mixed;
mod observables;
mod parameters;
mod two_doublet;

pub use build::build;
pub use mixed::{Mesh, MixedTwoDoublet};
pub use parameters::Law;
pub use two_doublet::TwoDoublet;
