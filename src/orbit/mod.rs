//! Periodic orbits of `G(u, u', p) = 0` by collocation.

mod algebraic;
mod band;
pub mod bifurcations;
mod collocation;
mod condensation;
mod dense;
mod elimination;
mod factors;
mod floquet;
mod joint;
mod mesh;
mod modulated;
mod pair;
mod rows;
mod scheme;
mod shape;
mod start;
mod turning;

pub use algebraic::Algebraic;
pub use band::Band;
pub use collocation::{Collocation, Frame};
pub use condensation::{Condensed, Interval};
pub use dense::Dense;
pub use elimination::Elimination;
pub use factors::OrbitFactors;
pub use floquet::{FloquetError, Multipliers, Stability, Transitions, multipliers};
pub use mesh::adapted;
pub use modulated::Modulation;
pub use rows::Rows;
pub use scheme::{Points, Scheme};
pub use shape::{Extremes, Orbit};
pub use start::{from_hopf, half_period};
