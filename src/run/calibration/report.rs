//! Columns, rows and special points of a calibration.

use super::{Analysis, Calibration, HopfError, Place, Tool, error, quantity};
use crate::bifurcation::Quantity;
use crate::branch::{Array, Branch, BranchKind, Column, Kind, Row, SpecialPoint};
use crate::problem::Problem;
use crate::run::equilibria::frequency;
use crate::run::study::Prepared;
use crate::scene;
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The branch without its rows: unknowns and the parameter that is solved for, then what is known of the Hopf point and
/// of the fit, then errors.
pub fn empty(prepared: &Prepared, name: &str, task: &scene::Calibration) -> Branch {
    let list = prepared.problem.parameters();
    let unit = |name: &str| list.iter().find(|q| q.name == name).map_or("", |q| q.unit).to_owned();
    let solved = list[prepared.first()].name;
    let unknowns: Vec<&str> = task.unknowns().into_iter().map(|(name, _)| name).collect();
    let free: Vec<String> = unknowns.iter().copied().chain([solved]).map(str::to_owned).collect();
    let time = prepared.problem.time_unit();
    let per_time = |with: &str| if time.is_empty() { String::new() } else { format!("{with}/{time}") };
    let of_quantity = |name: &str| match name {
        "omega" => per_time("rad"),
        "frequency" => frequency(time),
        "lyapunov" | "dsigma_re" | "dsigma_im" => String::new(),
        parameter => unit(parameter),
    };
    let mut columns: Vec<(String, String)> = free.iter().map(|name| (name.clone(), unit(name))).collect();
    columns.extend(task.along.logarithmic.iter().map(|name| (format!("log10 {name}"), String::new())));
    columns.extend(scene::QUANTITIES.iter().map(|name| ((*name).to_owned(), of_quantity(name))));
    columns.extend(task.targets.iter().map(|t| (format!("residual {}", t.quantity), of_quantity(&t.quantity))));
    columns.extend(["chi2", "condition"].map(|name| (name.to_owned(), String::new())));
    if deviations(task) {
        columns.extend(unknowns.iter().map(|name| (format!("sigma {name}"), unit(name))));
    }
    if task.along.errors {
        let with_error =
            columns.iter().filter(|(name, _)| free.contains(name) || scene::QUANTITIES[..3].contains(&name.as_str()));
        let errors: Vec<(String, String)> =
            with_error.map(|(name, unit)| (format!("error {name}"), unit.clone())).collect();
        columns.extend(errors);
    }
    Branch::new(
        name,
        BranchKind::Calibration,
        free,
        columns.into_iter().map(|(name, unit)| Column { name, unit }).collect(),
    )
}

/// Whether unknowns get standard deviations: from those of the targets, or from the scatter of targets in excess.
fn deviations(task: &scene::Calibration) -> bool {
    task.targets.iter().all(|t| t.sigma.is_some()) || task.targets.len() > task.unknowns().len()
}

/// The row of a point.
pub fn row(branch: &Branch, point: &SpecialPoint, label: String) -> Row {
    let value = |column: &Column| {
        let name = column.name.as_str();
        if let Some(of) = name.strip_prefix("error ") {
            return point.errors.get(of).copied();
        }
        if let Some(of) = name.strip_prefix("log10 ") {
            return point.parameters.get(of).map(|x| x.log10());
        }
        point.parameters.get(name).or(point.values.get(name)).copied()
    };
    let stable = point.values.get("lyapunov").map(|l1| *l1 < 0.0);
    Row { label: Some(label), stable, values: branch.columns.iter().map(value).collect() }
}

impl Tool<'_> {
    /// A solution with all its numbers; errors are differences to the numbers of the same solution on the refined
    /// discretisation, but not less than what rounding of the Hopf point leaves open.
    pub fn special(
        &self,
        calibration: &Calibration,
        (place, analysis): (&Place, &Analysis),
        fine: Option<&BTreeMap<String, f64>>,
    ) -> Result<SpecialPoint, HopfError> {
        let resolved = self.prepared.problem.resolve(&place.hopf.p);
        let list = self.prepared.problem.parameters();
        let mut point = SpecialPoint::new(String::new(), Kind::UZ, 0);
        point.parameters = list.iter().zip(&resolved).map(|(q, &x)| (q.name.to_owned(), x)).collect();
        point.values = self.numbers(calibration, place, analysis)?;
        if let Some(fine) = fine {
            let floors = self.floors(place, analysis);
            for (name, &value) in &point.values {
                if let Some(&other) = fine.get(name) {
                    let floor = floors.get(name).copied().unwrap_or(0.0);
                    point.errors.extend(error(value, other).map(|error| (name.clone(), error.max(floor))));
                }
            }
        }
        point.values.retain(|name, _| !point.parameters.contains_key(name));
        let hopf = &place.hopf;
        point.arrays.insert("state".to_owned(), Array::vector(hopf.u.clone()));
        point.arrays.insert("parameters".to_owned(), Array::vector(resolved));
        for (name, z) in [("q", &hopf.q), ("w", &hopf.w)] {
            point.arrays.insert(format!("{name}_re"), Array::vector(z.iter().map(|z| z.re).collect()));
            point.arrays.insert(format!("{name}_im"), Array::vector(z.iter().map(|z| z.im).collect()));
        }
        for (name, matrix) in [("sensitivity", &analysis.sensitivity), ("covariance", &self.covariance(analysis))] {
            if let Some(matrix) = matrix {
                // By rows; nalgebra keeps columns.
                let data = matrix.transpose().as_slice().to_vec();
                point.arrays.insert(name.to_owned(), Array { shape: vec![matrix.nrows(), matrix.ncols()], data });
            }
        }
        Ok(point)
    }

    /// Unknowns, the Hopf point and what the fit is worth, by name.
    pub fn numbers(
        &self,
        calibration: &Calibration,
        place: &Place,
        analysis: &Analysis,
    ) -> Result<BTreeMap<String, f64>, HopfError> {
        let list = self.prepared.problem.parameters();
        let hopf = &place.hopf;
        let moving = calibration.unknowns.iter().map(|u| u.coordinate.index).chain([calibration.free]);
        let mut numbers: BTreeMap<String, f64> = moving.map(|i| (list[i].name.to_owned(), hopf.p[i])).collect();
        for name in scene::QUANTITIES {
            numbers.insert(name.to_owned(), calibration.quantity(hopf, quantity(name))?);
        }
        numbers.insert("chi2".to_owned(), analysis.chi2);
        numbers.extend(analysis.condition.map(|condition| ("condition".to_owned(), condition)));
        for (target, &residual) in self.task.targets.iter().zip(&analysis.residuals) {
            numbers.insert(format!("residual {}", target.quantity), residual);
        }
        let covariance = self.covariance(analysis);
        for (i, (unknown, _)) in self.task.unknowns().into_iter().enumerate() {
            numbers.extend(covariance.as_ref().map(|c| (format!("sigma {unknown}"), c[(i, i)].sqrt())));
            for (k, target) in self.task.targets.iter().enumerate() {
                let value = analysis.sensitivity.as_ref().map(|s| s[(i, k)]);
                numbers.extend(value.map(|value| (format!("d {unknown}/d {}", target.quantity), value)));
            }
        }
        numbers.retain(|_, value| value.is_finite());
        Ok(numbers)
    }

    /// Covariance of the unknowns: for targets without standard deviations these are equal in parts of the targets, and
    /// their size follows from the scatter, `chi2 / (targets - unknowns)`.
    fn covariance(&self, analysis: &Analysis) -> Option<DMatrix<f64>> {
        if !deviations(self.task) {
            return None;
        }
        let given = self.task.targets.iter().all(|t| t.sigma.is_some());
        let excess = self.task.targets.len() - self.task.unknowns().len();
        let variance = if given { 1.0 } else { analysis.chi2 / excess as f64 };
        analysis.covariance.as_ref().map(|covariance| covariance * variance)
    }

    /// What rounding in p and omega leaves open, and what follows from it for the unknowns.
    fn floors(&self, place: &Place, analysis: &Analysis) -> BTreeMap<String, f64> {
        let (p, omega) = place.hopf.rounding;
        let of = |name: &str| match quantity(name) {
            Quantity::Parameter => p,
            Quantity::Omega => omega,
            Quantity::Frequency => omega / (2.0 * PI),
            _ => 0.0,
        };
        let solved = self.prepared.problem.parameters()[self.prepared.first()].name;
        let mut floors: BTreeMap<String, f64> =
            [solved, "omega", "frequency"].map(|name| (name.to_owned(), of(name))).into();
        for (k, target) in self.task.targets.iter().enumerate() {
            let floor = of(&target.quantity);
            floors.insert(format!("residual {}", target.quantity), floor);
            for (i, (unknown, _)) in self.task.unknowns().into_iter().enumerate() {
                let moved = analysis.sensitivity.as_ref().map_or(0.0, |s| s[(i, k)].abs() * floor);
                *floors.entry(unknown.to_owned()).or_default() += moved;
            }
        }
        floors
    }
}
