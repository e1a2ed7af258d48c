//! What a diagram draws: for each branch and column its numbers, in runs of one stability.

use crate::branch::{Branch, BranchKind, Kind};
use crate::plot::geometry::Point;
use crate::plot::{marker, style, value};
use plotters::style::RGBColor;

/// What a cycle has several of, and an equilibrium one.
const EXTREMES: [&str; 3] = ["max ", "min ", "mean "];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    Stable,
    Unstable,
    Unknown,
    /// Folds have none.
    Neither,
}

/// One column of one branch. Its points are pairs of numbers, not yet places on the page.
pub struct Series<'a> {
    pub branch: &'a Branch,
    /// Number of the branch among those of the figure.
    pub task: usize,
    pub colour: RGBColor,
    pub x: usize,
    pub y: usize,
}

/// Neighbouring points that are drawn in one style.
#[derive(Debug, PartialEq)]
pub struct Run {
    pub stability: Stability,
    pub points: Vec<Point>,
}

/// The columns that exist, of the branches that have them and numbers in them.
pub fn series<'a>(x: &str, y: &[String], branches: &[&'a Branch]) -> Vec<Series<'a>> {
    let mut found: Vec<Series> = Vec::new();
    let mut cycles = 0;
    for (task, branch) in branches.iter().enumerate() {
        let colour = match branch.kind {
            BranchKind::Equilibria => style::EQUILIBRIA,
            // A grid is no curve.
            BranchKind::Map => continue,
            _ => style::cycles(cycles),
        };
        let before = found.len();
        let Some(x) = column(branch, x) else { continue };
        for y in y.iter().filter_map(|y| column(branch, y)) {
            let series = Series { branch, task, colour, x, y };
            let known = (found.iter().skip(before)).any(|s| s.y == y);
            if !known && series.points().next().is_some() {
                found.push(series);
            }
        }
        cycles += usize::from(branch.kind != BranchKind::Equilibria && found.len() > before);
    }
    found
}

/// A column by its name, or by its name without "max ", "min " or "mean ".
pub fn column(branch: &Branch, name: &str) -> Option<usize> {
    branch.column(name).or_else(|| branch.column(base(name)))
}

pub fn base(name: &str) -> &str {
    let stripped = EXTREMES.iter().find_map(|e| name.strip_prefix(e));
    stripped.unwrap_or(name)
}

impl Series<'_> {
    /// The point of a row, if both its numbers exist.
    pub fn point(&self, row: usize) -> Option<Point> {
        let row = self.branch.rows.get(row)?;
        Some((value(row, self.x)?, value(row, self.y)?))
    }

    /// All points that exist, with their rows.
    pub fn points(&self) -> impl Iterator<Item = (usize, Point)> {
        (0..self.branch.rows.len()).filter_map(|row| Some((row, self.point(row)?)))
    }

    /// The points in runs of one stability; runs that touch share a point. A gap in the numbers is a gap between runs.
    /// Solutions of a calibration are no curve: each stands for itself.
    pub fn runs(&self) -> Vec<Run> {
        if self.branch.kind == BranchKind::Calibration {
            let one = |(row, point)| Run { stability: self.stability_at(row), points: vec![point] };
            return self.points().map(one).collect();
        }
        let turns = self.turns();
        let mut runs: Vec<Run> = Vec::new();
        let mut last: Option<usize> = None;
        for (row, point) in self.points() {
            let previous = last.filter(|&p| p + 1 == row);
            last = Some(row);
            match (previous, runs.last_mut()) {
                (Some(previous), Some(run)) => {
                    let stability = self.stability_between(previous, row, &turns);
                    if run.points.len() == 1 {
                        run.stability = stability;
                    }
                    if run.stability == stability {
                        run.points.push(point);
                    } else {
                        let joint = run.points.last().copied().unwrap_or(point);
                        runs.push(Run { stability, points: vec![joint, point] });
                    }
                }
                _ => runs.push(Run { stability: self.stability_at(row), points: vec![point] }),
            }
        }
        runs
    }

    /// Rows where stability may change. They belong to both sides: their own flag says nothing.
    fn turns(&self) -> Vec<bool> {
        let mut turns = vec![false; self.branch.rows.len()];
        for mark in marker::marks(self.branch) {
            if let Some(turn) = turns.get_mut(mark.row)
                && matches!(
                    mark.kind,
                    Kind::HB | Kind::LP | Kind::GH | Kind::LPC | Kind::PD | Kind::NS | Kind::BPC | Kind::GPD | Kind::CH
                )
            {
                *turn = true;
            }
        }
        turns
    }

    fn stability_at(&self, row: usize) -> Stability {
        if matches!(self.branch.kind, BranchKind::FoldCurve | BranchKind::BranchPointCurve | BranchKind::LpcCurve) {
            return Stability::Neither;
        }
        match self.branch.rows.get(row).and_then(|r| r.stable) {
            Some(true) => Stability::Stable,
            Some(false) => Stability::Unstable,
            None => Stability::Unknown,
        }
    }

    /// Stability of the piece between two neighbouring rows. Where it changes without a special point, the whole piece
    /// is drawn as unstable: the change is somewhere in it.
    fn stability_between(&self, a: usize, b: usize, turns: &[bool]) -> Stability {
        let turn = |row: usize| turns.get(row).copied().unwrap_or(false);
        let (at_a, at_b) = (self.stability_at(a), self.stability_at(b));
        match (turn(a), turn(b)) {
            (true, false) => at_b,
            (false, true) => at_a,
            _ if at_a == at_b => at_a,
            _ if at_a == Stability::Unknown || at_b == Stability::Unknown => Stability::Unknown,
            _ => Stability::Unstable,
        }
    }

    pub fn unit(&self) -> &str {
        (self.branch.columns.get(self.y)).map_or("", |c| c.unit.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::{Column, Row};

    fn branch(columns: &[&str], rows: &[(Option<&str>, Option<bool>, Option<f64>)]) -> Branch {
        Branch {
            name: "straight".into(),
            kind: BranchKind::Equilibria,
            free: vec!["p".into()],
            columns: (columns.iter()).map(|c| Column { name: c.to_string(), unit: "µm".into() }).collect(),
            rows: (rows.iter().enumerate())
                .map(|(i, &(label, stable, y))| Row {
                    label: label.map(str::to_owned),
                    stable,
                    values: vec![Some(i as f64), y],
                })
                .collect(),
            points: vec![],
            triangles: vec![],
        }
    }

    fn runs(rows: &[(Option<&str>, Option<bool>, Option<f64>)]) -> Vec<(Stability, usize)> {
        let branch = branch(&["p", "a"], rows);
        let series = series("p", &["a".into()], &[&branch]);
        (series[0].runs().iter()).map(|r| (r.stability, r.points.len())).collect()
    }

    #[test]
    fn a_special_row_belongs_to_both_sides() {
        use Stability::{Stable, Unstable};
        for at_hopf in [Some(true), Some(false), None] {
            let found = runs(&[
                (Some("EP1"), Some(true), Some(0.0)),
                (None, Some(true), Some(0.0)),
                (Some("HB1"), at_hopf, Some(0.0)),
                (None, Some(false), Some(0.0)),
            ]);
            assert_eq!(found, [(Stable, 3), (Unstable, 2)]);
        }
    }

    #[test]
    fn a_gap_ends_a_run_and_nan_is_a_gap() {
        let row = |y| (None, None, y);
        let rows = [row(Some(0.0)), row(None), row(Some(1.0)), row(Some(f64::NAN)), row(Some(2.0)), row(Some(3.0))];
        let unknown = Stability::Unknown;
        assert_eq!(runs(&rows), [(unknown, 1), (unknown, 1), (unknown, 2)]);
    }

    #[test]
    fn an_equilibrium_has_one_value_for_max_and_min() {
        let branch = branch(&["p", "tip_angle"], &[(None, None, Some(0.0))]);
        let wanted = ["max tip_angle".into(), "min tip_angle".into()];
        let series = series("p", &wanted, &[&branch]);
        assert_eq!(series.len(), 1);
    }
}
