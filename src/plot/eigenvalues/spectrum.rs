//! Eigenvalues as a branch stores them: columns `re_1`, `im_1`, `re_2`, ...

use crate::branch::{Branch, Kind};
use crate::plot::axis::range;
use crate::plot::geometry::Point;
use crate::plot::{marker, value};

/// Parameter, real part, imaginary part.
pub type Eigenvalue = (f64, f64, f64);

/// One eigenvalue along one branch; `None` where it does not exist.
pub struct Curve {
    values: Vec<Option<Eigenvalue>>,
}

impl Curve {
    /// The parts between gaps.
    pub fn pieces(&self) -> impl Iterator<Item = Vec<Eigenvalue>> {
        (self.values.split(Option::is_none))
            .map(|piece| piece.iter().flatten().copied().collect::<Vec<_>>())
            .filter(|piece| !piece.is_empty())
    }
}

#[derive(Default)]
pub struct Spectrum {
    pub curves: Vec<Curve>,
    /// Parameter and label.
    pub hopf: Vec<(f64, String)>,
    pub exceptional: Vec<Eigenvalue>,
    pub x_unit: String,
    pub re_unit: String,
    pub im_unit: String,
    /// The least that the second and the fourth largest real part of a row become.
    second: f64,
    fourth: f64,
}

impl Spectrum {
    pub fn new(x: &str, branches: &[&Branch]) -> Spectrum {
        let mut spectrum = Spectrum::default();
        for branch in branches {
            if let Some(x) = branch.column(x) {
                spectrum.add(branch, x);
            }
        }
        spectrum
    }

    fn add(&mut self, branch: &Branch, x: usize) {
        let table = Table { branch, x, pairs: pairs(branch) };
        let rows = || 0..branch.rows.len();
        let unit = |column: usize| branch.columns.get(column).map(|c| c.unit.clone());
        for &pair in &table.pairs {
            let values: Vec<_> = rows().map(|row| table.at(row, pair)).collect();
            if values.iter().all(Option::is_none) {
                continue;
            }
            if self.curves.is_empty() {
                self.x_unit = unit(x).unwrap_or_default();
                self.re_unit = unit(pair.0).unwrap_or_default();
                self.im_unit = unit(pair.1).unwrap_or_default();
            }
            self.curves.push(Curve { values });
        }
        for row in rows() {
            let mut real: Vec<f64> = table.row(row).map(|(_, re, _)| re).collect();
            real.sort_by(|a, b| b.total_cmp(a));
            self.second = real.iter().take(2).copied().fold(self.second, f64::min);
            self.fourth = real.iter().take(4).copied().fold(self.fourth, f64::min);
        }
        for mark in marker::marks(branch) {
            match mark.kind {
                Kind::HB | Kind::KC => {
                    let place = branch.rows.get(mark.row).and_then(|row| value(row, x));
                    self.hopf.extend(place.map(|x| (x, mark.label)));
                }
                Kind::XP => self.exceptional.extend(table.meeting(mark.row)),
                _ => {}
            }
        }
    }

    pub fn is_empty(&self) -> bool {
        self.curves.is_empty()
    }

    pub fn x_range(&self) -> (f64, f64) {
        range(self.all().map(|(x, _, _)| x), 0.03)
    }

    /// The range of real parts that is shown: from the largest down to the second of every row (a pair that becomes
    /// unstable, and its two real ancestors), zero included; and on down to the fourth of every row, as far as the
    /// first two keep half of the height. The rest of the spectrum, often thousands of times faster, is cut off.
    pub fn real_range(&self) -> (f64, f64) {
        let top = self.all().map(|(_, re, _)| re).fold(0.0, f64::max);
        let bottom = self.fourth.max(top - 2.0 * (top - self.second));
        range([bottom, top], 0.06)
    }

    /// Zero and the imaginary parts of what the panel of real parts, which ends at `low`, shows.
    pub fn imaginary_range(&self, low: f64) -> (f64, f64) {
        let shown = self.all().filter(|(_, re, _)| *re >= low);
        range(shown.map(|(_, _, im)| im).chain([0.0]), 0.08)
    }

    fn all(&self) -> impl Iterator<Item = Eigenvalue> {
        self.curves.iter().flat_map(|c| c.values.iter().flatten().copied())
    }
}

/// The columns of a branch that hold eigenvalues.
struct Table<'a> {
    branch: &'a Branch,
    x: usize,
    /// Real and imaginary part.
    pairs: Vec<(usize, usize)>,
}

impl Table<'_> {
    fn at(&self, row: usize, (re, im): (usize, usize)) -> Option<Eigenvalue> {
        let row = self.branch.rows.get(row)?;
        Some((value(row, self.x)?, value(row, re)?, value(row, im)?))
    }

    fn row(&self, row: usize) -> impl Iterator<Item = Eigenvalue> {
        self.pairs.iter().filter_map(move |&pair| self.at(row, pair))
    }

    /// Where two eigenvalues meet: the closest two of those that are real on one side of the row and complex on the
    /// other; of all, where that cannot be seen.
    fn meeting(&self, row: usize) -> Option<Eigenvalue> {
        let real = |row: usize, pair| self.at(row, pair).map(|(_, _, im)| im == 0.0);
        let turns = |pair| {
            let sides = real(row.saturating_sub(1), pair).zip(real(row.saturating_add(1), pair));
            sides.is_some_and(|(before, after)| before != after)
        };
        let turning: Vec<Eigenvalue> =
            (self.pairs.iter()).filter(|pair| turns(**pair)).filter_map(|&pair| self.at(row, pair)).collect();
        let all: Vec<Eigenvalue> = self.row(row).collect();
        closest(&turning).or_else(|| closest(&all))
    }
}

/// The columns of real and imaginary parts, in the order of their numbers.
fn pairs(branch: &Branch) -> Vec<(usize, usize)> {
    let mut pairs: Vec<(u32, usize, usize)> = (branch.columns.iter().enumerate())
        .filter_map(|(re, column)| {
            let number = column.name.strip_prefix("re_")?;
            let im = branch.column(&format!("im_{number}"))?;
            Some((number.parse().ok()?, re, im))
        })
        .collect();
    pairs.sort_unstable();
    pairs.into_iter().map(|(_, re, im)| (re, im)).collect()
}

/// The middle of the closest two.
fn closest(values: &[Eigenvalue]) -> Option<Eigenvalue> {
    let distance = |a: &Eigenvalue, b: &Eigenvalue| (a.1 - b.1).hypot(a.2 - b.2);
    let mut found: Option<(f64, Eigenvalue)> = None;
    for (i, a) in values.iter().enumerate() {
        for b in values.iter().skip(i + 1) {
            let apart = distance(a, b);
            if found.is_none_or(|(least, _)| apart < least) {
                let middle: Point = ((a.1 + b.1) / 2.0, (a.2 + b.2) / 2.0);
                found = Some((apart, (a.0, middle.0, middle.1)));
            }
        }
    }
    found.map(|(_, middle)| middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::{BranchKind, Column, Row};

    fn spectrum(rows: &[&[Option<f64>]]) -> Spectrum {
        let names = ["p", "re_2", "im_2", "re_1", "im_1", "re_10", "im_10", "re_x"];
        let branch = Branch {
            name: "straight".into(),
            kind: BranchKind::Equilibria,
            free: vec!["p".into()],
            columns: (names.iter()).map(|n| Column { name: n.to_string(), unit: String::new() }).collect(),
            rows: (rows.iter().enumerate())
                .map(|(i, values)| Row { label: Some(format!("XP{}", i + 1)), stable: None, values: values.to_vec() })
                .collect(),
            points: vec![],
            triangles: vec![],
        };
        Spectrum::new("p", &[&branch])
    }

    #[test]
    fn the_stiff_part_of_the_spectrum_is_cut_off() {
        let row = |p: f64, a: f64, b: f64| [p, b, 0.0, a, 0.0, -1e6, 0.0, 7.0].map(Some);
        let spectrum = spectrum(&[&row(0.0, -10.0, -300.0), &row(1.0, 50.0, 50.0)]);
        assert_eq!(spectrum.curves.len(), 3);
        let (low, high) = spectrum.real_range();
        assert!((-750.0..-650.0).contains(&low) && (50.0..120.0).contains(&high));
        assert_eq!(spectrum.exceptional[1], (1.0, 50.0, 0.0));
    }

    #[test]
    fn what_does_not_exist_is_a_gap() {
        let gap = [Some(1.0), None, None, Some(f64::NAN), Some(0.0), Some(0.0), Some(0.0), None];
        let full = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0].map(Some);
        let spectrum = spectrum(&[&full, &gap, &full]);
        let pieces: Vec<usize> = spectrum.curves.iter().map(|c| c.pieces().count()).collect();
        assert_eq!(pieces, [2, 2, 1]);
        assert_eq!(spectrum.imaginary_range(-1.0), (-1.0, 1.0));
    }
}
