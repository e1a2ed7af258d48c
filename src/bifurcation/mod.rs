//! Where the number or the stability of solutions changes, and what is born there.

mod branches;
mod equilibria;
mod hopf;
mod normal_form;
mod spectra;

pub use branches::{Ambiguous, Followed, follow, settle};
pub use equilibria::Equilibria;
pub use hopf::{Hopf, HopfError};
pub use normal_form::HopfNormalForm;
pub use spectra::{Mark, Sample, Spectra, leading};
