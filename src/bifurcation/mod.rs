//! Where the number or the stability of solutions changes, and what is born there.

mod branches;
mod coordinate;
mod equilibria;
mod hopf;
mod hopf_curve;
mod hopf_surface;
mod normal_form;
mod spectra;

pub use branches::{Ambiguous, Followed, follow, settle};
pub use coordinate::Coordinate;
pub use equilibria::Equilibria;
pub use hopf::{Hopf, HopfError};
pub use hopf_curve::{HopfCurve, Segment, Test, reverse};
pub use hopf_surface::HopfSurface;
pub use normal_form::HopfNormalForm;
pub use spectra::{Mark, Sample, Spectra, leading};
