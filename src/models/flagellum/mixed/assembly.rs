//! Sums over the elements' points: the residual, and its derivatives from those of the density.

use super::super::parameters::Groups;
use super::MixedTwoDoublet;
use super::density::{INPUTS, OUTPUTS, Part, UNITS, counts, density};
use super::elements::{Cell, Elements, Field};
use crate::linalg::{Banded, Matrix};
use crate::problem::{At, Scalar};
use num_dual::Dual64;

/// An element's run of a vector, zero where the fields vanish.
fn local<S: Scalar>(elements: &Elements, cell: &Cell, u: &[S]) -> Vec<S> {
    let (range, from) = elements.run(cell);
    let mut out = vec![S::from(0.0); elements.width];
    out[from..from + range.len()].copy_from_slice(&u[range]);
    out
}

/// The functions of a field at a point that go with one part of it, and what their slopes are multiplied by.
fn functions<'a>(elements: &'a Elements, cell: &Cell, field: &'a Field, part: Part, point: usize) -> (&'a [f64], f64) {
    let shapes = elements.shapes(field);
    match part {
        Part::Slope => (&shapes.slope[point], 1.0 / cell.width),
        Part::Value | Part::Rate => (&shapes.value[point], 1.0),
    }
}

impl MixedTwoDoublet {
    /// The inputs of the density at a point.
    fn inputs<S: Scalar>(&self, cell: &Cell, point: usize, (u, v): (&[S], &[S])) -> [S; 16] {
        let mut z = [S::from(0.0); 16];
        for (z, (i, part)) in z.iter_mut().zip(INPUTS).take(counts(self.law).0) {
            let field = &self.elements.fields[i];
            let (shapes, scale) = functions(&self.elements, cell, field, part, point);
            let scale = scale * UNITS[i];
            let from = if part == Part::Rate { v } else { u };
            let sum = field.places.iter().zip(shapes).fold(S::from(0.0), |sum, (&i, &shape)| sum + from[i] * shape);
            *z = sum * scale;
        }
        z
    }

    pub(super) fn assemble<S: Scalar>(&self, (u, v): (&[S], &[S]), p: &[S], g: &mut [S]) {
        let elements = &self.elements;
        let groups = Groups::new(p, self.law);
        g.fill(S::from(0.0));
        for cell in &elements.cells {
            let (u, v) = (local(elements, cell, u), local(elements, cell, v));
            let straight = self.straight_tension(&groups, &cell.x, p);
            let mut sums = vec![S::from(0.0); elements.width];
            for (point, weight) in elements.weights.iter().enumerate() {
                let z = self.inputs(cell, point, (&u, &v));
                let y = density(self.law, &groups, straight[point], &z);
                for (&y, (i, part)) in y.iter().zip(OUTPUTS).take(counts(self.law).1) {
                    let test = &elements.tests[i];
                    let (shapes, scale) = functions(elements, cell, test, part, point);
                    let factor = y * (weight * cell.width * scale / UNITS[i]);
                    test.places.iter().zip(shapes).for_each(|(&i, &shape)| sums[i] += factor * shape);
                }
            }
            let (range, from) = elements.run(cell);
            g[range].iter_mut().zip(&sums[from..]).for_each(|(g, &sum)| *g += sum);
        }
    }

    pub(super) fn fill(&self, at: At, gu: &mut Banded, gv: &mut Banded) {
        let elements = &self.elements;
        let (inputs, outputs) = counts(self.law);
        let width = elements.width;
        gu.fill(0.0);
        gv.fill(0.0);
        let groups = Groups::new(at.p, self.law);
        let lifted: Vec<Dual64> = at.p.iter().map(|&p| Dual64::from(p)).collect();
        let lifted = Groups::new(&lifted, self.law);
        for cell in &elements.cells {
            let (u, v) = (local(elements, cell, at.u), local(elements, cell, at.v));
            let straight = self.straight_tension(&groups, &cell.x, at.p);
            let (mut by_state, mut by_rate) = (vec![0.0; width * width], vec![0.0; width * width]);
            let (mut row_state, mut row_rate) = (vec![0.0; width], vec![0.0; width]);
            for (point, weight) in elements.weights.iter().enumerate() {
                let z = self.inputs(cell, point, (&u, &v)).map(Dual64::from);
                let slopes: Vec<[Dual64; 16]> = (0..inputs)
                    .map(|i| {
                        let mut z = z;
                        z[i].eps = 1.0;
                        density(self.law, &lifted, straight[point].into(), &z)
                    })
                    .collect();
                for (o, (test, part)) in OUTPUTS.into_iter().enumerate().take(outputs) {
                    let (test, unit) = (&elements.tests[test], UNITS[test]);
                    row_state.fill(0.0);
                    row_rate.fill(0.0);
                    let mut rates = false;
                    for (slope, (field, part)) in slopes.iter().map(|y| y[o].eps).zip(INPUTS) {
                        if slope == 0.0 {
                            continue;
                        }
                        let (field, unit) = (&elements.fields[field], UNITS[field]);
                        let (shapes, scale) = functions(elements, cell, field, part, point);
                        let row = if part == Part::Rate { &mut row_rate } else { &mut row_state };
                        rates |= part == Part::Rate;
                        field.places.iter().zip(shapes).for_each(|(&j, &shape)| row[j] += slope * scale * unit * shape);
                    }
                    let (shapes, scale) = functions(elements, cell, test, part, point);
                    for (&i, &shape) in test.places.iter().zip(shapes) {
                        let factor = weight * cell.width * scale / unit * shape;
                        add(&mut by_state[i * width..(i + 1) * width], factor, &row_state);
                        if rates {
                            add(&mut by_rate[i * width..(i + 1) * width], factor, &row_rate);
                        }
                    }
                }
            }
            let (range, from) = elements.run(cell);
            for (matrix, sums) in [(&mut *gu, &by_state), (&mut *gv, &by_rate)] {
                for (i, sums) in range.clone().zip(sums.chunks(width).skip(from)) {
                    let first = matrix.columns(i).start;
                    let row = &mut matrix.row_mut(i)[range.start - first..][..range.len()];
                    add(row, 1.0, &sums[from..from + range.len()]);
                }
            }
        }
    }
}

/// `out += factor x`.
fn add(out: &mut [f64], factor: f64, x: &[f64]) {
    out.iter_mut().zip(x).for_each(|(out, x)| *out += factor * x);
}

/// G_u and G_v are banded: nothing else is filled.
pub(super) fn fill(model: &MixedTwoDoublet, at: At, gu: &mut Matrix, gv: &mut Matrix) {
    if let (Matrix::Banded(gu), Matrix::Banded(gv)) = (gu, gv) {
        model.fill(at, gu, gv);
    }
}
