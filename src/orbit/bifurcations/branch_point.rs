//! Branch points of cycles, located and left by a regular system.
//!
//! On the branch itself the Jacobian [H_x, H_lambda] loses rank at a branch point, and what is computed near it loses half
//! of all digits. With two border rows c_1, c_2 and the unfolding alpha b in the closing condition,
//!
//! ```text
//! H(x, lambda) + alpha b = 0,    g_1 = g_2 = 0,       [ H_x  H_lambda  b ] [ q_i ]   [  0  ]
//!                                                     [      c_1       0 ] [     ] = [ e_i ],
//!                                                     [      c_2       0 ] [ g_i ]
//! ```
//!
//! has as many equations as unknowns (x, lambda, alpha), is regular where two branches cross at an angle, and has
//! alpha = 0 there (Griewank and Reddien 1984, doi:10.1093/imanum/4.2.245; Govaerts 2000,
//! doi:10.1137/1.9780898719543). With `a_ij` the derivative of g_i along q_j, tangents t = s_1 q_1 + s_2 q_2 solve
//! `sum a_ij s_i s_j = 0`, the algebraic bifurcation equation (Keller 1977).

use super::closing::{Closed, Closing, Right, Solution};
use super::linear::{Field, Linear};
use super::place::negated;
use crate::continuation::{Counts, Failure, Point, System};
use crate::linalg::{Lu, Singular, any, dot, finite, unit};
use crate::orbit::{Collocation, Orbit};
use faer::Mat;

const TOLERANCE: f64 = 1e-12;
const ROUNDING: f64 = 1e-9;
const MOST_STEPS: usize = 12;
/// Steps that make a good second border of any.
const FOLLOWED: usize = 3;

/// A branch point and both directions in which branches leave it.
#[derive(Clone, Debug)]
pub struct BranchPoint {
    /// The point with the tangent of the branch on which it was found.
    pub point: Point,
    /// The point with the tangent of the other branch; None where the branches touch.
    pub other: Option<Point>,
    /// alpha: how far the crossing is from perfect, in units of the state.
    pub unfolding: f64,
}

/// Borders in the metric: rows for (nodes, P, lambda).
struct Rows {
    column: Vec<f64>,
    nodes: [Vec<f64>; 2],
    direct: [[f64; 2]; 2],
}

/// The bordered system at one point.
struct Cross {
    linear: Linear,
    closed: Closed,
    /// q_1 and q_2 with g_1 and g_2.
    solutions: [Solution; 2],
    fields: [Field; 2],
    free: usize,
}

impl Cross {
    fn new(system: &Collocation, (orbit, lambda): (Orbit, f64), rows: &Rows) -> Result<Self, Singular> {
        let linear = Linear::new(system, orbit, system.parameters(lambda), &[&rows.nodes[0], &rows.nodes[1]])?;
        let closing = Closing {
            kappa: Mat::identity(1, 1),
            scalars: 2,
            column: Some(rows.column.clone()),
            rows: vec![(0, [0.0; 2]), (1, rows.direct[0]), (2, rows.direct[1])],
        };
        let closed = Closed::new(&linear, closing)?;
        let solution = |e: [f64; 3]| closed.solve(&linear, &[Right { rows: &e, ..Right::default() }]);
        let solutions = [solution([0.0, 1.0, 0.0]), solution([0.0, 0.0, 1.0])];
        let free = system.frame.free;
        let fields = [0, 1].map(|i| field(&linear, &solutions[i], free));
        Ok(Self { linear, closed, solutions, fields, free })
    }

    /// Derivatives of (g_1, g_2) along a variation.
    fn along(&self, direction: &Field) -> [f64; 2] {
        [0, 1].map(|i| {
            let equations = negated(self.linear.second(&self.fields[i], direction));
            self.closed.solve(&self.linear, &[Right { equations: &equations, ..Right::default() }]).g[0]
        })
    }
}

fn field(linear: &Linear, solution: &Solution, free: usize) -> Field {
    let mut p = vec![0.0; linear.p.len()];
    p[free] = solution.z[1];
    linear.field(&solution.nodes[0], solution.z[0], p)
}

impl BranchPoint {
    /// By Newton's method from a point near it.
    pub fn solve(system: &Collocation, near: &Point, counts: &mut Counts) -> Result<Self, Failure> {
        let (n, equations) = (system.frame.symmetry.sign.len(), near.x.len() - 1);
        let row = |t: &[f64], t_lambda: f64| {
            let dual = system.dual(t);
            (dual[..equations].to_vec(), [dual[equations], system.dual_lambda() * t_lambda])
        };
        let column = any(n);
        let spread: Vec<f64> = column.iter().copied().cycle().take(equations).chain([0.0]).collect();
        let (first, second) = (row(&near.tangent, near.tangent_lambda), row(&spread, 0.0));
        let mut rows = Rows { column: unit(&column), nodes: [first.0, second.0], direct: [first.1, second.1] };
        let (mut x, mut lambda, mut alpha) = (near.x.clone(), near.lambda, 0.0);
        for _ in 0..FOLLOWED {
            let cross = Cross::new(system, (system.orbit(&x), lambda), &rows)?;
            counts.factorisations += 1;
            // Apart from the tangent, in the metric.
            let [_, other] = &cross.solutions;
            let mut t = unknowns(other, equations);
            let t_lambda = other.z[1];
            let size = (dot(&t, &system.dual(&t)) + system.dual_lambda() * t_lambda * t_lambda).sqrt();
            t.iter_mut().for_each(|t| *t /= size);
            let next = row(&t, t_lambda / size);
            (rows.nodes[1], rows.direct[1]) = next;
            rows.column = unit(&cross.closed.left(&cross.linear, 0)[0]);
        }
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let mut orbit = system.orbit(&x);
            let end = orbit.nodes.len() - n;
            orbit.nodes[end..].iter_mut().zip(&rows.column).for_each(|(u, b)| *u -= alpha * b);
            let cross = Cross::new(system, (orbit, lambda), &rows)?;
            counts.factorisations += 1;
            counts.residuals += 1;
            counts.newton += 1;
            let residual = cross.linear.residual();
            let phase = system.phase_of(&x);
            let particular = cross
                .closed
                .solve(&cross.linear, &[Right { equations: &residual, rows: &[phase, 0.0, 0.0], end: &[] }]);
            let along = cross.along(&field(&cross.linear, &particular, cross.free));
            let by = [0, 1].map(|j| cross.along(&cross.fields[j]));
            let small = faer::mat![[by[0][0], by[1][0]], [by[0][1], by[1][1]]];
            let mut s = [0, 1].map(|i| cross.solutions[i].g[0] - along[i]);
            Lu::new(small)?.solve(&mut s);
            let mut step = unknowns(&particular, equations);
            let (mut step_lambda, mut step_alpha) = (particular.z[1], particular.g[0]);
            for (s, q) in s.iter().zip(&cross.solutions) {
                step.iter_mut().zip(unknowns(q, equations)).for_each(|(d, q)| *d += s * q);
                step_lambda += s * q.z[1];
                step_alpha += s * q.g[0];
            }
            if !finite(&step) || !step_lambda.is_finite() {
                return Err(Singular.into());
            }
            x.iter_mut().zip(&step).for_each(|(x, d)| *x -= d);
            lambda -= step_lambda;
            alpha -= step_alpha;
            let square = dot(&step, &system.dual(&step)) + system.dual_lambda() * step_lambda * step_lambda;
            let size = square.sqrt() + step_alpha.abs() / system.frame.scale_state;
            if size < TOLERANCE || (size < ROUNDING && size > 0.1 * last) {
                return Ok(Self::leave(system, near, (x, lambda, alpha), &cross, by, equations));
            }
            if size > 1e3 {
                return Err(Failure::Diverged(size));
            }
            last = size;
        }
        Err(Failure::Diverged(last))
    }

    /// Both tangents: s = (s_1, s_2) with `a_11 s_1² + 2 a_12 s_1 s_2 + a_22 s_2² = 0`.
    fn leave(
        system: &Collocation,
        near: &Point,
        (x, lambda, alpha): (Vec<f64>, f64, f64),
        cross: &Cross,
        by: [[f64; 2]; 2],
        equations: usize,
    ) -> Self {
        let [a, b, c] = [by[0][0], 0.5 * (by[0][1] + by[1][0]), by[1][1]];
        let discriminant = b * b - a * c;
        let mut tangents: Vec<Point> = Vec::new();
        // Less is rounding of two equal tangents.
        if discriminant > 1e-10 * (b * b + a.abs().max(c.abs()).powi(2)) {
            // The two roots without cancellation.
            let root = b + b.signum() * discriminant.sqrt();
            for s in [[root, -a], [c, -root]] {
                let mut tangent = vec![0.0; equations + 1];
                let mut tangent_lambda = 0.0;
                for (s, q) in s.iter().zip(&cross.solutions) {
                    tangent.iter_mut().zip(unknowns(q, equations)).for_each(|(t, q)| *t += s * q);
                    tangent_lambda += s * q.z[1];
                }
                let square =
                    dot(&tangent, &system.dual(&tangent)) + system.dual_lambda() * tangent_lambda * tangent_lambda;
                let size = square.sqrt();
                tangent.iter_mut().for_each(|t| *t /= size);
                tangents.push(Point { x: x.clone(), lambda, tangent, tangent_lambda: tangent_lambda / size });
            }
        }
        let dual = system.dual(&near.tangent);
        let cosine = |t: &Point| dot(&t.tangent, &dual) + system.dual_lambda() * t.tangent_lambda * near.tangent_lambda;
        tangents.sort_by(|s, t| cosine(t).abs().total_cmp(&cosine(s).abs()));
        let mut tangents = tangents.into_iter();
        let here = Point { x, lambda, ..near.clone() };
        let point = tangents.next().map_or(here, |mut point| {
            if cosine(&point) < 0.0 {
                crate::bifurcation::reverse(&mut point);
            }
            point
        });
        Self { point, other: tangents.next(), unfolding: alpha }
    }
}

/// (nodes but the last, P).
fn unknowns(solution: &Solution, equations: usize) -> Vec<f64> {
    solution.nodes[0][..equations].iter().copied().chain([solution.z[0]]).collect()
}
