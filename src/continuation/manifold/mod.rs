//! Surfaces of solutions: N equations in N + 2 unknowns, `F(x) = 0`, covered by charts as far as a box reaches.
//!
//! Henderson 2002 (doi:10.1142/S0218127402004498). A chart is a disc of radius R about a point, in the tangent plane
//! there. Where the discs i and j overlap, the line through both intersections of their circles divides the
//! ground,
//!
//! ```text
//! v . s <= (|s|² + R_i² - R_j²) / 2,      s = Phi_i^T W (x_j - x_i),
//! ```
//!
//! so that each chart keeps a convex polygon. A corner of a polygon outside of its circle is not covered yet: towards it
//! the next chart is placed, on the circle, and corrected across the tangent plane. Radii are such that the surface
//! leaves the tangent plane by a given tolerance at the circle, hence fall where the surface bends. The
//! polygons' neighbours are the edges of the triangulation ([`Cover::triangles`]).
//!
//! The box cuts polygons, too. Unlike Henderson's, charts whose polygons meet its bounds are placed on them, exactly, and so
//! are corners, where two bounds meet: the triangles then end where the box does. Charts that would come close to a
//! bound are placed on it instead, which keeps triangles well shaped (the rule of Ruppert 1995,
//! doi:10.1006/jagm.1995.1021, for Delaunay refinement).

mod chart;
mod cover;
mod polygon;
mod target;
mod triangles;

pub use chart::Chart;
pub use cover::{Cover, CoverControl};

use super::Factored;
use crate::linalg::Singular;

/// A surface with its metric. It must be orientable.
pub trait Surface: Clone + Send + Sync {
    type Factors: Factored;

    /// `r = F(x)`, two fewer than there are unknowns.
    fn residual(&self, x: &[f64], r: &mut [f64]);

    /// Factors the matrix `[F_x; rows]`.
    fn factor(&self, x: &[f64], rows: [&[f64]; 2]) -> Result<Self::Factors, Singular>;

    /// The diagonal of the metric W, the same on the whole surface.
    fn weights(&self) -> &[f64];

    /// The diagonal of the norm that Newton's steps are measured in: unlike the metric, it must count every unknown.
    fn scales(&self) -> &[f64] {
        self.weights()
    }

    /// The same surface with its reference vectors, if it has any, moved to a point.
    fn prepared(&self, _x: &[f64]) -> Self {
        self.clone()
    }

    fn inner(&self, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).zip(self.weights()).map(|((a, b), w)| a * b * w).sum()
    }
}

/// A face of the box: an unknown stays below (or above) a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    pub coordinate: usize,
    pub upper: bool,
    pub value: f64,
}

impl Bound {
    /// How far inside a point is, in units of the coordinate.
    fn room(&self, x: &[f64]) -> f64 {
        let room = self.value - x[self.coordinate];
        if self.upper { room } else { -room }
    }
}
