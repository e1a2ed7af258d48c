//! Critical cycles as solutions of an extended system, and its factored Jacobian.
//!
//! Unknowns are x = (nodes, P, [cos(theta)], z1) - and z2 along a curve - with z the parameters or their logarithms;
//! equations are those of the orbit with its phase condition, and one or two scalars of a [`Place`]. The Jacobian is
//! solved with by blocks: the orbit's variations with borders first, then a small system for their size along the
//! border's solution, d cos(theta) and dz, in which second derivatives enter along a few directions only.

use super::linear::Field;
use super::{Borders, Place};
use crate::bifurcation::Coordinate;
use crate::continuation::{Counts, Factored, Failure, System};
use crate::linalg::{Lu, Singular, dot, finite};
use crate::orbit::{Collocation, Orbit};
use crate::problem::Refinement;
use faer::Mat;
use std::sync::Arc;

/// Which multiplier nu over the computed part P of the period is on the unit circle. On half-period orbits a multiplier
/// over the period is nu².
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Critical {
    /// A double nu = 1: a fold.
    Fold,
    /// nu = -1: period doubling; on half-period orbits the breaking of the symmetry.
    Flip,
    /// nu = exp(±i theta): a torus is born.
    Torus,
}

/// Newton steps, in the metric's norm, shrink to this or to rounding.
const TOLERANCE: f64 = 1e-12;
const ROUNDING: f64 = 1e-9;
const MOST_STEPS: usize = 12;
/// Steps that make good borders of any.
const FOLLOWED: usize = 3;

/// The extended system in one or two parameters.
#[derive(Clone)]
pub struct CriticalCycle {
    pub system: Collocation,
    pub kind: Critical,
    pub coordinates: Vec<Coordinate>,
    pub borders: Borders,
}

impl CriticalCycle {
    /// Near an orbit at parameters p, with cos(theta) of the critical multiplier; and the unknowns (z included).
    pub fn new(
        system: &Collocation,
        (orbit, p): (&Orbit, &[f64]),
        (kind, cosine): (Critical, f64),
        coordinates: &[Coordinate],
    ) -> Result<(Self, Vec<f64>), Singular> {
        let mut system = system.clone();
        system.frame.p = p.to_vec();
        let borders = Borders::any(orbit, kind);
        let mut cycle = Self { system, kind, coordinates: coordinates.to_vec(), borders };
        let mut x = Collocation::unknowns(orbit);
        x.extend((kind == Critical::Torus).then_some(cosine));
        x.extend(coordinates.iter().map(|c| c.of(p[c.index])));
        for _ in 0..FOLLOWED {
            cycle.follow(&x)?;
        }
        Ok((cycle, x))
    }

    /// Entries of x before z: (nodes, P, [cos(theta)]).
    pub fn inner(&self, x: &[f64]) -> usize {
        x.len() - self.coordinates.len()
    }

    /// Entries of nodes and P.
    fn orbital(&self, x: &[f64]) -> usize {
        self.inner(x) - usize::from(self.kind == Critical::Torus)
    }

    pub fn orbit(&self, x: &[f64]) -> Orbit {
        self.system.orbit(&x[..self.orbital(x)])
    }

    /// cos(theta), where it is an unknown.
    pub fn cosine(&self, x: &[f64]) -> Option<f64> {
        (self.kind == Critical::Torus).then(|| x[self.inner(x) - 1])
    }

    pub fn parameters(&self, x: &[f64]) -> Vec<f64> {
        let mut p = self.system.frame.p.clone();
        for (coordinate, z) in self.coordinates.iter().zip(&x[self.inner(x)..]) {
            p[coordinate.index] = coordinate.value(*z);
        }
        p
    }

    pub fn place(&self, x: &[f64]) -> Result<Place, Singular> {
        let cosine = self.cosine(x).unwrap_or(0.0);
        Place::new(&self.system, (self.orbit(x), self.parameters(x)), (self.kind, cosine), &self.borders)
    }

    /// Takes the null vectors at x as borders.
    pub fn follow(&mut self, x: &[f64]) -> Result<(), Singular> {
        let place = self.place(x)?;
        self.borders.follow(&place);
        Ok(())
    }

    /// All equations.
    pub fn residual(&self, x: &[f64], place: &Place) -> Vec<f64> {
        let mut r = place.linear.residual();
        r.push(self.system.phase_of(x));
        r.extend(place.scalars());
        r
    }

    /// The step of Newton's method at x, with border rows that make the system square and are to stay as they are.
    pub fn newton(&self, x: &[f64], rows: &[&[f64]], counts: &mut Counts) -> Result<Vec<f64>, Failure> {
        let place = Arc::new(self.place(x)?);
        counts.factorisations += 1;
        counts.residuals += 1;
        let mut step = self.residual(x, &place);
        if !finite(&step) {
            return Err(Failure::NotFinite);
        }
        step.resize(step.len() + rows.len(), 0.0);
        CriticalFactors::new(self, place, x, rows)?.solve(&mut step);
        counts.newton += 1;
        step.iter_mut().for_each(|d| *d = -*d);
        if finite(&step) { Ok(step) } else { Err(Singular.into()) }
    }

    /// Solves the extended system in the first parameter alone, from x near its solution.
    pub fn solve(&self, mut x: Vec<f64>, counts: &mut Counts) -> Result<Vec<f64>, Failure> {
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let step = self.newton(&x, &[], counts)?;
            x.iter_mut().zip(&step).for_each(|(x, d)| *x += d);
            let orbital = self.orbital(&x);
            let sizes = self.system.dual(&step[..orbital]);
            let mut size = dot(&step[..orbital], &sizes);
            size += step[orbital..self.inner(&x)].iter().map(|d| d * d).sum::<f64>();
            for (coordinate, d) in self.coordinates.iter().zip(&step[self.inner(&x)..]) {
                size += (d / coordinate.width).powi(2);
            }
            let size = size.sqrt();
            if size < TOLERANCE || (size < ROUNDING && size > 0.1 * last) {
                return Ok(x);
            }
            if size > 1e3 {
                return Err(Failure::Diverged(size));
            }
            last = size;
        }
        Err(Failure::Diverged(last))
    }

    /// The same on a finer discretisation, by a degree more in time, and in space where there is a refinement; and x
    /// there, which is near a solution. None if the refinement lacks the orbit's symmetry.
    pub fn refined(&self, x: &[f64], refinement: Option<&Refinement>) -> Option<(Self, Vec<f64>)> {
        let orbit = self.orbit(x);
        let mut frame = self.system.frame.clone();
        frame.p = self.parameters(x);
        let mut finer = orbit.interpolated(&orbit.mesh, orbit.degree + 1);
        let mut fine = self.clone();
        fine.borders = self.borders.interpolated(&orbit, &orbit.mesh, orbit.degree + 1);
        if let Some(Refinement { problem, prolong }) = refinement {
            fine.borders = fine.borders.mapped(orbit.dim, &**prolong);
            finer = finer.mapped(&**prolong);
            frame = frame.of(problem)?;
        }
        fine.system = Collocation::new(frame, &finer);
        let mut unknowns = Collocation::unknowns(&finer);
        unknowns.extend(&x[self.orbital(x)..]);
        Some((fine, unknowns))
    }
}

/// Factors at one x, with border rows that make the system square: one less than there are coordinates.
pub struct CriticalFactors {
    place: Arc<Place>,
    orbital: usize,
    cosine: bool,
    /// (nodes, P) that the border's solution and the parameters bring.
    kernel: Vec<f64>,
    by_parameters: Vec<Vec<f64>>,
    rows: Vec<Vec<f64>>,
    small: Lu<f64>,
    sizes: Vec<f64>,
}

impl CriticalFactors {
    pub fn new(cycle: &CriticalCycle, place: Arc<Place>, x: &[f64], rows: &[&[f64]]) -> Result<Self, Singular> {
        let (orbital, inner) = (cycle.orbital(x), cycle.inner(x));
        let linear = &place.linear;
        let scalars = place.scalars().len();
        let cosine = usize::from(cycle.kind == Critical::Torus);
        let size = 1 + cosine + cycle.coordinates.len();
        let kernel = place.kernel();
        let unknowns =
            |nodes: &[f64], part: f64| -> Vec<f64> { nodes[..orbital - 1].iter().copied().chain([part]).collect() };
        let flat = unknowns(&kernel.nodes[0], kernel.z[0]);
        let mut small = Mat::zeros(size, size);
        let mut fill = |column: usize, mu: f64, along: Vec<f64>, flat: &[f64], own: &[f64]| {
            small[(0, column)] = mu;
            (0..scalars).for_each(|i| small[(1 + i, column)] = along[i]);
            for (i, row) in rows.iter().enumerate() {
                small[(1 + scalars + i, column)] = dot(&row[..orbital], flat) + own.get(i).copied().unwrap_or(0.0);
            }
        };
        let field = linear.field(&kernel.nodes[0], kernel.z[0], Vec::new());
        fill(0, kernel.g[0], place.along(Some(&field), 0.0), &flat, &[]);
        let entry = |k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
        if cosine == 1 {
            fill(1, 0.0, place.along(None, 1.0), &vec![0.0; orbital], &entry(orbital));
        }
        let mut by_parameters = Vec::new();
        for (k, coordinate) in cycle.coordinates.iter().enumerate() {
            let mut e = vec![0.0; linear.p.len()];
            e[coordinate.index] = coordinate.rate(x[inner + k]);
            let equations = super::place::negated(linear.first(&linear.parametric(e.clone())));
            let solved = place.base(&equations, [0.0; 2]);
            let flat = unknowns(&solved.nodes[0], solved.z[0]);
            let field = linear.field(&solved.nodes[0], solved.z[0], e);
            fill(1 + cosine + k, solved.g[0], place.along(Some(&field), 0.0), &flat, &entry(inner + k));
            by_parameters.push(flat);
        }
        // Rows of one size: the pivots of so small a system would otherwise depend on units.
        let sizes: Vec<f64> =
            (0..size).map(|i| (0..size).map(|j| small[(i, j)].abs()).fold(f64::MIN_POSITIVE, f64::max)).collect();
        let small = Mat::from_fn(size, size, |i, j| small[(i, j)] / sizes[i]);
        Ok(Self {
            orbital,
            cosine: cosine == 1,
            kernel: flat,
            by_parameters,
            rows: rows.iter().map(|row| row[..orbital].to_vec()).collect(),
            small: Lu::new(small)?,
            sizes,
            place,
        })
    }

    pub fn place(&self) -> &Place {
        &self.place
    }
}

impl Factored for CriticalFactors {
    /// `right`: the orbit's equations, the phase, the scalars, the borders; out: nodes, P, [cos(theta)], z.
    fn solve(&self, right: &mut [f64]) {
        let (linear, equations) = (&self.place.linear, self.orbital - 1);
        let trivial = right[..self.orbital].iter().all(|&x| x == 0.0);
        let scalars = self.place.scalars().len();
        let (mut flat, mut y) = (vec![0.0; self.orbital], vec![0.0]);
        y.extend_from_slice(&right[self.orbital..]);
        if !trivial {
            let solved = self.place.base(&right[..equations], [right[equations], 0.0]);
            let field: Field = linear.field(&solved.nodes[0], solved.z[0], Vec::new());
            y[0] = -solved.g[0];
            let along = self.place.along(Some(&field), 0.0);
            y[1..=scalars].iter_mut().zip(&along).for_each(|(y, along)| *y -= along);
            flat = solved.nodes[0][..equations].to_vec();
            flat.push(solved.z[0]);
            y[1 + scalars..].iter_mut().zip(&self.rows).for_each(|(y, row)| *y -= dot(row, &flat));
        }
        y.iter_mut().zip(&self.sizes).for_each(|(y, size)| *y /= size);
        self.small.solve(&mut y);
        let shift = 1 + usize::from(self.cosine);
        for i in 0..self.orbital {
            let moved: f64 = self.by_parameters.iter().zip(&y[shift..]).map(|(by, z)| by[i] * z).sum();
            right[i] = flat[i] + y[0] * self.kernel[i] + moved;
        }
        right[self.orbital..].copy_from_slice(&y[1..]);
    }
}
