//! The normal form at a branch point.

use super::{Place, Tangent};
use crate::bifurcation::steady::{Steady, positive};
use crate::linalg::{Matrix, Singular, dot, unit};
use crate::problem::{At, Direction};

/// On the centre manifold, `u = u_0 + x q + m v + ...`, m the deviation of the parameter and (v, 1) the tangent of one of
/// the curves,
///
/// ```text
/// x' = b m x + c x² (transcritical),      x' = b m x + d x³ (pitchfork),      |q| = 1, w^T M q = 1,
/// b = -w^T D²G[(q, 0), (v, 1)],           c = -w^T D²G[q, q] / 2,
/// d = -w^T ( D³G[q, q, q] + 3 D²G[q, h] ) / 6,       G_u h = -D²G[q, q] - 2 c M q
/// ```
///
/// Where zero is a double eigenvalue, as without damping, `w^T M q = 0`: then it is `x'' = ...` with `w^T M q_1 = 1`,
/// `G_u q_1 = -M q`.
///
/// (Kuznetsov 2004, doi:10.1007/978-1-4757-3978-7, section 7.4, where symmetry makes the pitchfork; Golubitsky and Schaeffer 1985,
/// doi:10.1007/978-1-4612-5034-0, chapter 2; written for the implicit form). The largest entry of q is positive.
#[derive(Clone, Debug)]
pub struct BranchForm {
    pub b: f64,
    pub c: f64,
    pub d: f64,
    pub q: Vec<f64>,
    pub w: Vec<f64>,
    /// Whether c is so small that at the state's scale the cubic term decides.
    pitchfork: bool,
}

/// `w^T M q` in parts of the vectors: less is zero.
const DOUBLE: f64 = 1e-8;
/// c in parts of d and the state's scale.
const CUBIC: f64 = 1e-6;

impl BranchForm {
    pub(super) fn new(
        place: &Place,
        at: At,
        (q, w): (&[f64], &[f64]),
        tangents: &[Vec<f64>],
        mass: &Matrix,
    ) -> Result<Self, Singular> {
        let n = at.u.len();
        let (gu, _) = place.problem.matrices(at);
        let q = positive(&unit(q));
        let steady = Steady::structured(&gu, w, &q)?;
        let mut image = vec![0.0; n];
        mass.times(&q, &mut image);
        if dot(w, &image).abs() <= DOUBLE * (dot(w, w) * dot(&image, &image)).sqrt() {
            let right: Vec<f64> = image.iter().map(|m| -m).collect();
            let next = steady.solve(&right, 0.0);
            mass.times(&next[..n], &mut image);
        }
        let product = dot(w, &image);
        let w: Vec<f64> = w.iter().map(|w| w / product).collect();
        let along = Direction { u: &q, v: &[], p: &[] };
        let mut bent = vec![0.0; n];
        place.problem.derivative(at, &[along, along], &mut bent);
        let c = -0.5 * dot(&w, &bent);
        let right: Vec<f64> = bent.iter().zip(&image).map(|(b, m)| -b - 2.0 * c * m).collect();
        let h = steady.solve(&right, 0.0);
        let (mut third, mut mixed) = (vec![0.0; n], vec![0.0; n]);
        place.problem.derivative(at, &[along, along, along], &mut third);
        place.problem.derivative(at, &[along, Direction { u: &h[..n], v: &[], p: &[] }], &mut mixed);
        let d = -(dot(&w, &third) + 3.0 * dot(&w, &mixed)) / 6.0;
        let pitchfork = c.abs() <= CUBIC * d.abs() * place.scales.state;
        // The curve that is followed, unless it is the vertical one.
        let steepest = if tangents[0][n].abs() < tangents[1][n].abs() { 1 } else { 0 };
        let base = place.unscaled(&tangents[if pitchfork { steepest } else { 0 }]);
        let base = Tangent { u: base.u.iter().map(|v| v / base.p).collect(), p: 1.0 };
        let b = place.second(at, &w, &Tangent { u: q.clone(), p: 0.0 }, &base);
        Ok(Self { b, c, d, q, w, pitchfork })
    }

    pub fn pitchfork(&self) -> bool {
        self.pitchfork
    }
}
