//! Elements on x = s/L in [0, 1], the functions on them, and where their coefficients are.
//!
//! On an element xi in [0, 1] a continuous field of degree d has the functions `1 - xi, xi` of its ends and d - 1 bubbles,
//! integrated Legendre polynomials with orthonormal derivatives (Szabo and Babuska 1991, Finite Element Analysis); a broken one
//! of degree d has d + 1 orthonormal Legendre polynomials. Both are hierarchical: a higher degree adds functions.
//!
//! Coefficients are sorted by place: those of an element's left end, of its bubbles of degree 2, 3, ..., then those of
//! the next end. So each element sees one run of them, `width` long, and the next element's begins `stride` later:
//!
//! ```text
//! end       psi_1 psi_2 T_1 T_2 N_1 N_2 f (h)          first function of f, of h: it goes with no end
//! bubble    T_1 T_2 N_1 N_2 f (h) psi_1 psi_2          as many as psi has; T, N, f and h have one more
//! ```
//!
//! Where the fields vanish, psi at the base and T, N at the tip, the run reaches over the ends of the vector.

use super::density::field;
use crate::models::rod::{antiderivative, gauss, legendre};
use faer::Mat;
use std::ops::Range;

/// Of the angles; everything else has one degree more.
pub const SMALLEST_DEGREE: usize = 2;
pub const LARGEST_DEGREE: usize = 8;

/// How finely, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mesh {
    pub elements: usize,
    /// k: degree of the angles.
    pub degree: usize,
    /// Each element is so many times as long as its neighbour nearer to the base or to the tip.
    pub grading: f64,
}

impl Default for Mesh {
    /// Of the meshes on which all eigenvalues are computed, the one whose onset is most accurate.
    fn default() -> Self {
        Self { elements: 4, degree: 8, grading: 1.2 }
    }
}

impl Mesh {
    /// The elements' ends, from 0 to 1.
    fn ends(&self) -> Vec<f64> {
        let sizes: Vec<f64> =
            (0..self.elements).map(|e| self.grading.powi(e.min(self.elements - 1 - e) as i32)).collect();
        let total: f64 = sizes.iter().sum();
        let mut ends = vec![0.0];
        ends.extend(sizes.iter().scan(0.0, |sum, size| {
            *sum += size / total;
            Some(*sum)
        }));
        ends[self.elements] = 1.0;
        ends
    }
}

/// Functions and their slopes (per xi) at the points: `value[point][function]`.
pub struct Shapes {
    pub value: Vec<Vec<f64>>,
    pub slope: Vec<Vec<f64>>,
}

/// The functions of one field, and where in an element's run their coefficients are.
pub struct Field {
    pub broken: bool,
    pub places: Vec<usize>,
}

/// One element's part of x.
pub struct Cell {
    pub width: f64,
    /// The points' x.
    pub x: Vec<f64>,
    /// Where its run begins; below 0 for the first element.
    start: isize,
}

pub struct Elements {
    pub mesh: Mesh,
    ends: Vec<f64>,
    pub cells: Vec<Cell>,
    /// Weights of the points on [0, 1].
    pub weights: Vec<f64>,
    /// From values at the points to the integral from xi = 0.
    pub integral: Mat<f64>,
    continuous: Shapes,
    broken: Shapes,
    /// Of psi_1, psi_2, T_1, T_2, N_1, N_2, f and perhaps h.
    pub fields: Vec<Field>,
    /// What tests the balance of moments (psi's functions), of forces along t and along n (those of T and N), and the laws
    /// of f and h (the same again): all are continuous.
    pub tests: Vec<Field>,
    pub width: usize,
    pub dim: usize,
}

impl Elements {
    /// With h among the unknowns, or without. 2k + 1 points integrate every product of the weak form exactly, but for
    /// those with an exponential load.
    pub fn new(mesh: Mesh, with_separation: bool) -> Self {
        let k = mesh.degree;
        let (xi, weights) = gauss(2 * k + 1);
        let shapes = |at: fn(usize, f64) -> (Vec<f64>, Vec<f64>), degree: usize| {
            let (value, slope) = xi.iter().map(|&xi| at(degree, xi)).unzip();
            Shapes { value, slope }
        };
        let block = if with_separation { 8 } else { 7 };
        let stride = block * (k + 1) - 2;
        let ends = mesh.ends();
        let cells = (0..mesh.elements)
            .map(|e| {
                let (from, width) = (ends[e], ends[e + 1] - ends[e]);
                let x = xi.iter().map(|xi| from + width * xi).collect();
                Cell { width, x, start: (e * stride) as isize - 2 }
            })
            .collect();
        // Places of the function of the left end, and of bubbles.
        let left = |field: usize| field;
        let bubble = |field: usize, j: usize| block * j + if field < 2 { block - 2 + field } else { field - 2 };
        let continuous = |field: usize, degree: usize| Field {
            broken: false,
            places: [left(field), stride + left(field)]
                .into_iter()
                .chain((1..degree).map(|j| bubble(field, j)))
                .collect(),
        };
        let broken = |field: usize| Field {
            broken: true,
            places: std::iter::once(left(field)).chain((1..=k).map(|j| bubble(field, j))).collect(),
        };
        let smooth = || (0..6).map(|field| continuous(field, if field < 2 { k } else { k + 1 }));
        Self {
            continuous: shapes(hats, k + 1),
            broken: shapes(polynomials, k),
            integral: antiderivative(&xi, &weights),
            fields: smooth().chain((6..block).map(broken)).collect(),
            tests: smooth().chain((6..block).map(|field| continuous(field, k + 1))).collect(),

            width: stride + block,
            dim: mesh.elements * stride,
            mesh,
            ends,
            cells,
            weights,
        }
    }

    pub fn shapes(&self, field: &Field) -> &Shapes {
        if field.broken { &self.broken } else { &self.continuous }
    }

    /// The entries of the vector that an element's run covers, and the first place in the run that has one.
    pub fn run(&self, cell: &Cell) -> (Range<usize>, usize) {
        let first = cell.start.max(0) as usize;
        let last = ((cell.start + self.width as isize) as usize).min(self.dim);
        (first..last, (first as isize - cell.start) as usize)
    }

    /// A continuous field's value at x from the vector.
    pub fn at(&self, field: usize, u: &[f64], x: f64) -> f64 {
        let e = self.ends.partition_point(|&end| end <= x).clamp(1, self.mesh.elements) - 1;
        let cell = &self.cells[e];
        let (value, _) = hats(self.mesh.degree + 1, (x - self.ends[e]) / cell.width);
        let (range, from) = self.run(cell);
        let coefficient = |place: usize| place.checked_sub(from).and_then(|i| u[range.clone()].get(i)).copied();
        self.fields[field].places.iter().zip(value).map(|(&p, v)| v * coefficient(p).unwrap_or(0.0)).sum()
    }

    /// A continuous field, or its slope in x, at an element's points.
    pub fn on_points(&self, cell: &Cell, field: usize, u: &[f64], slopes: bool) -> Vec<f64> {
        let (range, from) = self.run(cell);
        let (shapes, scale) =
            if slopes { (&self.continuous.slope, 1.0 / cell.width) } else { (&self.continuous.value, 1.0) };
        let coefficient = |place: usize| place.checked_sub(from).and_then(|i| u[range.clone()].get(i)).copied();
        let coefficients: Vec<f64> =
            self.fields[field].places.iter().map(|&place| coefficient(place).unwrap_or(0.0)).collect();
        shapes.iter().map(|shapes| scale * crate::linalg::dot(&coefficients, shapes)).collect()
    }

    /// Where the vector holds coefficients of T.
    pub fn places_of_tension(&self) -> impl Iterator<Item = usize> + '_ {
        self.cells.iter().flat_map(|cell| {
            let (range, from) = self.run(cell);
            let places = self.fields[field::T].places.iter().chain(&self.fields[field::T + 1].places);
            places.filter_map(move |place| range.clone().nth(place.checked_sub(from)?))
        })
    }

    /// The same function with the degree raised by one.
    pub fn raised(&self, finer: &Elements, u: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; finer.dim];
        for (cell, fine) in self.cells.iter().zip(&finer.cells) {
            let ((range, from), (fine_range, fine_from)) = (self.run(cell), finer.run(fine));
            for (field, fine) in self.fields.iter().zip(&finer.fields) {
                for (place, fine_place) in field.places.iter().zip(&fine.places) {
                    let source = place.checked_sub(from).and_then(|i| u[range.clone()].get(i));
                    let target = fine_place.checked_sub(fine_from).and_then(|i| out[fine_range.clone()].get_mut(i));
                    if let (Some(source), Some(target)) = (source, target) {
                        *target = *source;
                    }
                }
            }
        }
        out
    }
}

/// Functions of the ends and bubbles up to a degree, and their slopes, at xi.
fn hats(degree: usize, xi: f64) -> (Vec<f64>, Vec<f64>) {
    let p = legendre(degree, xi);
    let (mut value, mut slope) = (vec![1.0 - xi, xi], vec![-1.0, 1.0]);
    for j in 1..degree {
        let scale = ((2 * j + 1) as f64).sqrt();
        value.push((p[j + 1] - p[j - 1]) / (2.0 * scale));
        slope.push(scale * p[j]);
    }
    (value, slope)
}

/// Orthonormal polynomials up to a degree; nobody needs their slopes.
fn polynomials(degree: usize, xi: f64) -> (Vec<f64>, Vec<f64>) {
    let scaled = |(j, p): (usize, f64)| ((2 * j + 1) as f64).sqrt() * p;
    (legendre(degree, xi).into_iter().take(degree + 1).enumerate().map(scaled).collect(), Vec::new())
}
