//! Models of beating flagella.

mod linearisation;
mod observables;
mod two_doublet;

pub use two_doublet::{Law, TwoDoublet};
