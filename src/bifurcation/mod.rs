//! Where the number or the stability of solutions changes, and what is born there.

mod branches;
mod calibration;
mod coordinate;
mod equilibria;
mod hopf;
mod hopf_curve;
mod normal_form;
mod spectra;

pub use branches::{Ambiguous, Followed, follow, settle};
pub use calibration::{Analysis, Calibration, Fit, FitError, Lost, Place, Quantity, Target, Unknown};
pub use coordinate::Coordinate;
pub use equilibria::Equilibria;
pub use hopf::{Hopf, HopfError};
pub use hopf_curve::{HopfCurve, Segment, Test, reverse};
pub use normal_form::HopfNormalForm;
pub use spectra::{Mark, Sample, Spectra, leading};
