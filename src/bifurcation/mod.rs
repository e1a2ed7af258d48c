//! Where the number or the stability of solutions changes, and what is born there.

mod bautin;
mod bogdanov_takens;
mod branches;
mod calibration;
mod centre;
mod coordinate;
mod double_hopf;
mod equilibria;
mod fold_curve;
mod hopf;
mod hopf_curve;
mod hopf_surface;
mod leading;
mod multilinear;
mod normal_form;
mod spectra;
mod steady;
mod zero_hopf;

pub use bautin::Bautin;
pub use bogdanov_takens::BogdanovTakens;
pub use branches::{Ambiguous, Followed, follow, settle};
pub use calibration::{Analysis, Calibration, Fit, FitError, Lost, Place, Quantity, Target, Unknown};
pub use coordinate::Coordinate;
pub use double_hopf::DoubleHopf;
pub use equilibria::Equilibria;
pub use fold_curve::{FoldCurve, FoldSegment, FoldTest};
pub use hopf::{Hopf, HopfError};
pub use hopf_curve::{HopfCurve, Segment, Test, reverse};
pub use hopf_surface::HopfSurface;
pub use leading::{Leading, LeadingFailure, Line};
pub use normal_form::HopfNormalForm;
pub use spectra::{Mark, Sample, Spectra, leading};
pub use zero_hopf::ZeroHopf;
