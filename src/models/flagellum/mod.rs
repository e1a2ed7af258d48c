//! Models of beating flagella.

mod basis;
mod linearisation;
mod observables;
mod two_doublet;

pub use two_doublet::{Law, Load, TwoDoublet};
