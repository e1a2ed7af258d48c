//! First points of the branches that leave a bifurcation.
//!
//! At nu = -1 over P the new cycles have twice the period: with v the critical function, `v(t + P) = -S v(t)`,
//!
//! ```text
//! u + eps v on [0, P],    S (u - eps v) on [P, 2P],
//! ```
//!
//! P and lambda changing with eps² only. S = 1 is period doubling; on half-period orbits the new cycles are those of full
//! period without the symmetry. The first point is solved for on the hyperplane at distance eps from the old branch,
//! which the old branch does not meet.

use super::{Critical, CriticalCycle};
use crate::continuation::{Border, Corrected, Counts, Failure, Point, System, correct, inner};
use crate::linalg::Singular;
use crate::orbit::{Collocation, Frame, Orbit, OrbitFactors};
use crate::problem::Reflection;

/// The start of a branch: its system, first point and factors there.
pub struct Departure {
    pub system: Collocation,
    /// The bifurcation itself, as a solution of this system.
    pub origin: Point,
    pub corrected: Corrected<OrbitFactors>,
}

/// A distance that fails is tried again at these multiples.
const DISTANCES: [f64; 4] = [1.0, 0.3, 3.0, 0.1];

/// The orbit over twice its computed part, moved by eps v in the first half and by its opposite in the second.
pub fn doubled(orbit: &Orbit, v: &[f64], eps: f64, symmetry: &Reflection) -> Orbit {
    let (n, count) = (orbit.dim, orbit.intervals() * orbit.degree);
    let mut nodes: Vec<f64> = (0..count * n).map(|i| orbit.nodes[i] + eps * v[i]).collect();
    let mut image = vec![0.0; n];
    for k in 0..=count {
        let state: Vec<f64> = (k * n..(k + 1) * n).map(|i| orbit.nodes[i] - eps * v[i]).collect();
        symmetry.apply(&state, &mut image);
        nodes.extend_from_slice(&image);
    }
    let half = orbit.mesh.iter().map(|t| 0.5 * t);
    let mesh = half.clone().chain(half.skip(1).map(|t| 0.5 + t)).collect();
    Orbit { mesh, nodes, part: 2.0 * orbit.part, parts: 1, ..orbit.clone() }
}

impl Departure {
    /// Onto the cycles that nu = -1 gives rise to, at a distance in arclength.
    pub fn flip((cycle, x): (&CriticalCycle, &[f64]), distance: f64, counts: &mut Counts) -> Result<Self, Failure> {
        debug_assert_eq!(cycle.kind, Critical::Flip);
        let (orbit, p) = (cycle.orbit(x), cycle.parameters(x));
        let frame = &cycle.system.frame;
        let place = cycle.place(x)?;
        let v = place.null_nodes().first().ok_or(Singular)?;
        let symmetry = &frame.symmetry;
        let start = doubled(&orbit, v, 0.0, symmetry);
        let still = Orbit { nodes: vec![0.0; orbit.nodes.len()], ..orbit.clone() };
        let direction = Orbit { part: 0.0, ..doubled(&still, v, 1.0, symmetry) };
        let frame = Frame {
            symmetry: Reflection::identity(orbit.dim),
            parts: 1,
            scale_part: 2.0 * frame.scale_part,
            p,
            ..frame.clone()
        };
        let system = Collocation::new(frame, &start);
        let lambda = system.frame.p[system.frame.free];
        let point = Point {
            x: Collocation::unknowns(&start),
            lambda,
            tangent: Collocation::unknowns(&direction),
            tangent_lambda: 0.0,
        };
        Self::along(system, &point, distance, counts)
    }

    /// Along a tangent that is not the known branch's.
    pub fn along(system: Collocation, point: &Point, distance: f64, counts: &mut Counts) -> Result<Self, Failure> {
        let tangent = (&point.tangent[..], point.tangent_lambda);
        let size = inner(&system, tangent, tangent).sqrt();
        let border = Border {
            row: system.dual(&point.tangent).iter().map(|t| t / size).collect(),
            lambda: system.dual_lambda() * point.tangent_lambda / size,
        };
        let mut last = Failure::Singular(Singular);
        for distance in DISTANCES.map(|factor| factor * distance) {
            let step = distance / size;
            let x = point.x.iter().zip(&point.tangent).map(|(x, t)| x + step * t).collect();
            match correct(&system, (x, point.lambda + step * point.tangent_lambda), &border, counts) {
                // On the hyperplane, but nearer to the prediction than to the branch point.
                Ok(corrected) if corrected.distance < distance => {
                    return Ok(Self { system, origin: point.clone(), corrected });
                }
                Ok(_) => last = Failure::Turned,
                Err(failure) => last = failure,
            }
        }
        Err(last)
    }
}
