//! Cantilevers with inertia: the weak form of [`super::rod`] as a first-order system in angles and their rates.

mod beam;
mod inertial;
mod pipe;

pub use beam::Column;
pub use pipe::Pipe;
