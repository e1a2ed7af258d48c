//! Bifurcations of cycles: found along a branch, located, their normal forms, and what leaves them.
//!
//! All comes from one condensation of the linearised collocation equations, closed by `w(P) = kappa S w(0)` with another
//! kappa than the orbit's own 1 (see [`Closing`]). Sign convention on half-period orbits, u(t + P) = S u(t): nu are
//! the multipliers over P and mu = nu² those over the period 2 P, so that
//!
//! | nu | without symmetry (mu = nu) | half-period orbits |
//! |---|---|---|
//! | +1 | fold (LPC), or a branch point of the same kind of cycles (BPC) | the same |
//! | -1 | period doubling (PD) | the symmetry is broken: mu = +1, a branch point (BPC) of the full problem |
//! | e^{±i theta} | torus (NS), angle theta | torus, angle 2 theta over the period |
//! | ±i | strong resonance 1:4 | mu = -1 twice: symmetric cycles do not double their period in one parameter (Swift and Wiesenfeld 1984, doi:10.1103/PhysRevLett.52.705) |

mod borders;
mod branch_point;
mod closing;
mod critical;
mod curve;
mod homoclinic;
mod linear;
mod locate;
mod normal_form;
mod place;
mod signs;
mod switch;
mod vanishing;

pub use borders::Borders;
pub use branch_point::BranchPoint;
pub use closing::{Closed, Closing, Right, Solution};
pub use critical::{Critical, CriticalCycle, CriticalFactors};
pub use curve::{CycleCurve, CycleSegment, CycleTest};
pub use homoclinic::{Homoclinic, KEPT, Passage, Passed};
pub use linear::{Field, Linear};
pub use locate::{Located, Segment};
pub use normal_form::CycleNormalForm;
pub use place::Place;
pub use signs::{Event, Signs};
pub use switch::Departure;
pub use vanishing::{Amplitude, hopf_beside};
