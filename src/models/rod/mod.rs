//! Planar inextensible rods in minimal coordinates: what the models of filaments, columns and pipes share.
//!
//! The tangent angle psi(s) is the only unknown. With t = (cos psi, sin psi), n = (-sin psi, cos psi), x = s/L, the rod
//! lies at r = L int_0^x t and moves with r_t = L int_0^x psi_t n; a test angle q displaces it by w = int_0^x q n.
//! d'Alembert's principle, every force tested with w, needs no tension, and all force conditions are natural.

mod basis;
mod forces;
mod halves;
mod line;
mod linearisation;
mod load;
mod motion;
mod refinement;

pub use basis::{Basis, antiderivative, gauss, legendre, peak, times, times_both};
pub use forces::{Forces, Push, State, bracket, end, work};
pub use halves::{slice, slice_mut};
pub use line::line;
pub use linearisation::{product, scaled_rows, slopes};
pub use load::Load;
pub use motion::Motion;
pub use refinement::finer;
