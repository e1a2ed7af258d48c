//! Curves of critical cycles in two parameters: folds, flips (period doublings) and torus bifurcations.
//!
//! The extended system of [`CriticalCycle`] with x = (nodes, P, [cos(theta)], z1) and lambda = z2. It is regular through
//! cusps and strong resonances: at cos(theta) = ±1 a torus curve goes on as one of neutral saddles. The mesh follows the
//! orbit, and borders the null vectors, from step to step.

use super::signs::{flip, torus};
use super::{Critical, CriticalCycle, CriticalFactors, CycleNormalForm, Place};
use crate::bifurcation::{Coordinate, Locus, Segment};
use crate::continuation::{Border, Corrected, Counts, Failure, Point, System, correct, inner, normalise};
use crate::linalg::{Singular, c64};
use crate::orbit::{Collocation, Orbit, Transitions, multipliers};
use crate::problem::Refinement;
use std::sync::{Arc, Mutex};

/// What was factored last: Newton's method asks for residual and factors at the same points.
type Cache = Arc<Mutex<Option<(Vec<f64>, Arc<Place>)>>>;

/// The system of a curve.
#[derive(Clone)]
pub struct CycleCurve {
    /// In two coordinates.
    pub cycle: CriticalCycle,
    cache: Cache,
}

impl CycleCurve {
    /// The system near a critical cycle, and the point of the curve there, with a tangent along which z2 does not fall.
    pub fn start(
        system: &Collocation,
        (orbit, p): (&Orbit, &[f64]),
        (kind, cosine): (Critical, f64),
        (first, second): (Coordinate, Coordinate),
        counts: &mut Counts,
    ) -> Result<(Self, Point), Failure> {
        let (cycle, mut x) = CriticalCycle::new(system, (orbit, p), (kind, cosine), &[first, second])?;
        let lambda = x.pop().ok_or(Singular)?;
        let curve = Self { cycle, cache: Cache::default() };
        let last = x.len() - 1;
        // A border across the curve is not known: one of its unknowns may be held, best the one along which it runs.
        let mut best: Option<Corrected<CriticalFactors>> = None;
        for along_first in [false, true] {
            let mut border = Border { row: vec![0.0; x.len()], lambda: 0.0 };
            if along_first {
                border.row[last] = 1.0 / first.width;
            } else {
                border.lambda = 1.0 / second.width;
            }
            let Ok(found) = correct(&curve, (x.clone(), lambda), &border, counts) else { continue };
            let steep = if along_first {
                found.point.tangent[last] / first.width
            } else {
                found.point.tangent_lambda / second.width
            };
            if best.is_none() || steep.abs() > 0.5 {
                best = Some(found);
            }
        }
        let mut point = best.ok_or(Failure::Singular(Singular))?.point;
        if point.tangent_lambda < 0.0 || point.tangent_lambda == 0.0 && point.tangent[last] < 0.0 {
            crate::bifurcation::reverse(&mut point);
        }
        Ok((curve, point))
    }

    /// The unknowns of [`CriticalCycle`].
    pub fn unknowns(point: &Point) -> Vec<f64> {
        point.x.iter().copied().chain([point.lambda]).collect()
    }

    fn place(&self, x: &[f64], lambda: f64) -> Result<Arc<Place>, Singular> {
        let x: Vec<f64> = x.iter().copied().chain([lambda]).collect();
        let mut cache = self.cache.lock().map_err(|_| Singular)?;
        if let Some((known, place)) = &*cache
            && *known == x
        {
            return Ok(place.clone());
        }
        let place = Arc::new(self.cycle.place(&x)?);
        *cache = Some((x, place.clone()));
        Ok(place)
    }

    pub fn parameters(&self, point: &Point) -> Vec<f64> {
        self.cycle.parameters(&Self::unknowns(point))
    }

    pub fn orbit(&self, point: &Point) -> Orbit {
        self.cycle.orbit(&Self::unknowns(point))
    }

    /// cos(theta) of a torus bifurcation.
    pub fn cosine(&self, point: &Point) -> Option<f64> {
        self.cycle.cosine(&Self::unknowns(point))
    }

    pub fn normal_form(&self, point: &Point) -> Result<CycleNormalForm, Singular> {
        CycleNormalForm::new(&self.cycle, &Self::unknowns(point))
    }

    /// The point on a finer discretisation, by one Newton step with one coordinate held: the error of the error is left.
    pub fn finer(
        &self,
        point: &Point,
        held: usize,
        refinement: Option<&Refinement>,
        counts: &mut Counts,
    ) -> Option<(CriticalCycle, Vec<f64>)> {
        let (fine, mut x) = self.cycle.refined(&Self::unknowns(point), refinement)?;
        let mut row = vec![0.0; x.len()];
        row[x.len() - 2 + held] = 1.0 / self.cycle.coordinates[held].width;
        let step = fine.newton(&x, &[&row], counts).ok()?;
        x.iter_mut().zip(&step).for_each(|(x, d)| *x += d);
        Some((fine, x))
    }

    /// The unknowns of the cycle itself.
    fn of_cycle(&self, point: &Point) -> Point {
        let orbit = self.orbit(point);
        let unknowns = orbit.nodes.len() - orbit.dim + 1;
        let [x, tangent] = [&point.x, &point.tangent].map(|x| x[..unknowns].to_vec());
        Point { x, tangent, lambda: 0.0, tangent_lambda: 0.0 }
    }

    fn fold(&self, point: &Point) -> Result<f64, Singular> {
        self.place(&point.x, point.lambda)?.fold(&self.multipliers(point)?)
    }

    /// Multipliers over the computed part, the trivial one left out.
    pub fn multipliers(&self, point: &Point) -> Result<Vec<c64>, Singular> {
        let place = self.place(&point.x, point.lambda)?;
        let transitions = Transitions::new(&place.linear.condensed.intervals())?;
        Ok(multipliers(&transitions, (place.linear.symmetry(), 1), 1, None).map_err(|_| Singular)?.values)
    }
}

impl System for CycleCurve {
    type Factors = CriticalFactors;

    fn residual(&self, x: &[f64], lambda: f64, r: &mut [f64]) {
        // A singular bordered matrix has no scalar: the residual then is not a number, and the step fails.
        match self.place(x, lambda) {
            Ok(place) => r.copy_from_slice(&self.cycle.residual(x, &place)),
            Err(Singular) => r.fill(f64::NAN),
        }
    }

    fn factor(&self, x: &[f64], lambda: f64, border: &Border) -> Result<CriticalFactors, Singular> {
        let place = self.place(x, lambda)?;
        let row: Vec<f64> = border.row.iter().copied().chain([border.lambda]).collect();
        let unknowns: Vec<f64> = x.iter().copied().chain([lambda]).collect();
        CriticalFactors::new(&self.cycle, place, &unknowns, &[&row])
    }

    fn dual(&self, t: &[f64]) -> Vec<f64> {
        let inner = t.len() - 1;
        let orbital = inner - usize::from(self.cycle.kind == Critical::Torus);
        let mut row = self.cycle.system.dual(&t[..orbital]);
        row.extend(&t[orbital..inner]);
        row.push(t[inner] / self.cycle.coordinates[0].width.powi(2));
        row
    }

    fn dual_lambda(&self) -> f64 {
        self.cycle.coordinates[1].width.powi(-2)
    }

    /// Moves the mesh, takes the point as phase reference and the null vectors as borders.
    fn prepare(&mut self, point: &mut Point) -> bool {
        let before = self.orbit(point);
        let mut cycle = self.of_cycle(point);
        let unknowns = cycle.x.len();
        let moved = self.cycle.system.prepare(&mut cycle);
        if moved {
            point.x.splice(..unknowns, cycle.x);
            point.tangent.splice(..unknowns, cycle.tangent);
            self.cycle.borders = self.cycle.borders.interpolated(&before, &self.cycle.system.mesh, before.degree);
        }
        self.cache = Cache::default();
        // Old borders serve where new ones cannot be had.
        let _ = self.cycle.follow(&Self::unknowns(point));
        self.align(point);
        normalise(self, point);
        moved
    }

    fn align(&self, past: &mut Point) {
        let mut cycle = self.of_cycle(past);
        self.cycle.system.align(&mut cycle);
        past.x[..cycle.x.len()].copy_from_slice(&cycle.x);
        past.tangent[..cycle.x.len()].copy_from_slice(&cycle.tangent);
    }
}

/// A step of a curve of critical cycles.
pub type CycleSegment = Segment<CycleCurve>;

/// A function along the curve whose zero is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CycleTest {
    /// The first (0) or second (1) coordinate takes a value.
    Value(usize, f64),
    /// The normal form's coefficient vanishes (its numerator; of a torus the real part): a cusp of cycles, a generalised
    /// period doubling, a Chenciner point.
    Degenerate,
    /// `g(G_v v)` vanishes: the critical multiplier is double. Resonance 1:1 on folds, 1:2 on flips.
    Double,
    /// cos(theta) takes a value: strong resonances on torus curves.
    Cosine(f64),
    /// Another multiplier is +1 (on flips and tori), -1 (on folds and tori), on the circle (on folds and flips).
    Fold,
    Flip,
    Torus,
}

impl Locus for CycleCurve {
    type Test = CycleTest;
    const SMALL: f64 = 1e-5;

    fn axes(&self) -> [Coordinate; 2] {
        [self.cycle.coordinates[0], self.cycle.coordinates[1]]
    }

    fn coordinates(&self, point: &Point) -> [f64; 2] {
        [point.x[point.x.len() - 1], point.lambda]
    }

    fn taking(k: usize, goal: f64) -> CycleTest {
        CycleTest::Value(k, goal)
    }

    fn goal(test: CycleTest) -> Option<f64> {
        if let CycleTest::Value(1, goal) = test { Some(goal) } else { None }
    }

    fn value(step: &CycleSegment, test: CycleTest, point: &Point) -> f64 {
        let curve = &step.curve;
        let form = |part: fn(&CycleNormalForm) -> f64| curve.normal_form(point).map_or(f64::NAN, |form| part(&form));
        match test {
            CycleTest::Value(k, goal) => curve.coordinates(point)[k] - goal,
            CycleTest::Degenerate if curve.cycle.kind == Critical::Torus => {
                let inside = curve.cosine(point).is_some_and(|c| c.abs() < 1.0);
                if inside { form(|form| form.coefficient.re) } else { f64::NAN }
            }
            CycleTest::Degenerate => form(|form| form.top.re),
            CycleTest::Double => form(|form| form.bottom.re),
            CycleTest::Cosine(goal) => curve.cosine(point).map_or(f64::NAN, |c| c - goal),
            CycleTest::Fold => curve.fold(point).unwrap_or(f64::NAN),
            CycleTest::Flip => curve.multipliers(point).map_or(f64::NAN, |nu| flip(&nu)),
            CycleTest::Torus => curve.multipliers(point).map_or(f64::NAN, |nu| torus(&nu).0),
        }
    }

    /// A real pair with a product of one is a neutral saddle.
    fn genuine(step: &CycleSegment, test: CycleTest, zero: &Point) -> Result<bool, Failure> {
        if test != CycleTest::Torus {
            return Ok(true);
        }
        let nu = step.curve.multipliers(zero)?;
        Ok(torus(&nu).1.is_some_and(|(i, j)| nu[i].im != 0.0 && nu[i] == nu[j].conj()))
    }
}

impl CycleSegment {
    /// The same step on a finer discretisation, if it can be had.
    pub fn refined(&self, refinement: Option<&Refinement>, counts: &mut Counts) -> Option<Self> {
        let before = &self.curve.cycle;
        let (cycle, x) = before.refined(&CycleCurve::unknowns(&self.from), refinement)?;
        let (_, y) = before.refined(&CycleCurve::unknowns(&self.to), refinement)?;
        let curve = CycleCurve { cycle, cache: Cache::default() };
        let split = |mut x: Vec<f64>| x.pop().map(|lambda| (x, lambda));
        let ((x, x_lambda), (y, y_lambda)) = (split(x)?, split(y)?);
        let gap: Vec<f64> = x.iter().zip(&y).map(|(x, y)| y - x).collect();
        let length = inner(&curve, (&gap, y_lambda - x_lambda), (&gap, y_lambda - x_lambda)).sqrt();
        let row = curve.dual(&gap).iter().map(|entry| entry / length).collect();
        let border = Border { row, lambda: curve.dual_lambda() * (y_lambda - x_lambda) / length };
        let from = correct(&curve, (x, x_lambda), &border, counts).ok()?.point;
        let to = correct(&curve, (y, y_lambda), &border, counts).ok()?.point;
        Some(Self { curve, from, to })
    }

    /// What is looked for on a curve, besides values.
    pub fn tests(kind: Critical) -> &'static [CycleTest] {
        match kind {
            Critical::Fold => &[CycleTest::Degenerate, CycleTest::Double, CycleTest::Flip, CycleTest::Torus],
            Critical::Flip => &[CycleTest::Degenerate, CycleTest::Double, CycleTest::Fold, CycleTest::Torus],
            Critical::Torus => &[
                CycleTest::Degenerate,
                CycleTest::Cosine(1.0),
                CycleTest::Cosine(-1.0),
                CycleTest::Cosine(-0.5),
                CycleTest::Cosine(0.0),
                CycleTest::Fold,
                CycleTest::Flip,
            ],
        }
    }
}
