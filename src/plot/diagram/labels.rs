//! What the axes and the legend of a diagram say.

use super::series::{Series, base, column};
use crate::branch::BranchKind;
use crate::plot::text;
use plotters::style::RGBColor;

/// Colours and what they stand for: all equilibria together, each branch of cycles. Solutions of a calibration are
/// symbols without a curve.
pub fn names(series: &[Series]) -> Vec<(RGBColor, String)> {
    let mut names: Vec<(RGBColor, String)> = Vec::new();
    let mut equilibria: Option<usize> = None;
    let mut last = None;
    for one in series.iter().filter(|one| one.branch.kind != BranchKind::Calibration) {
        if last.replace(one.task) == Some(one.task) {
            continue;
        }
        let name = text::readable(&one.branch.name);
        let known = equilibria.and_then(|i| names.get_mut(i));
        match (one.branch.kind, known) {
            (BranchKind::Equilibria, Some((_, names))) => {
                names.push_str(", ");
                names.push_str(&name);
            }
            (kind, _) => {
                if kind == BranchKind::Equilibria {
                    equilibria = Some(names.len());
                }
                names.push((one.colour, name));
            }
        }
    }
    names
}

/// Name and unit for the x axis.
pub fn x_label(x: &str, series: &[Series]) -> (String, String) {
    let column = series.first().and_then(|s| s.branch.columns.get(s.x));
    let unit = column.map_or("", |c| c.unit.as_str());
    (text::readable(x), unit.to_owned())
}

/// Name and unit for the y axis: "max, min tip deflection" for two columns that differ in the first word only.
pub fn y_label(y: &[String], series: &[Series]) -> (String, String) {
    let wanted: Vec<&str> = (y.iter().map(String::as_str))
        .filter(|name| series.iter().any(|s| column(s.branch, name) == Some(s.y)))
        .collect();
    let unit_of = |name: &str| {
        let of = |s: &&Series| column(s.branch, name) == Some(s.y);
        series.iter().find(of).map_or("", |s| s.unit())
    };
    let Some(&first) = wanted.first() else {
        return Default::default();
    };
    let unit = unit_of(first);
    let extreme = |name: &str| name != base(name) && base(name) == base(first);
    if wanted.iter().all(|name| extreme(name)) {
        let extremes: Vec<&str> =
            (wanted.iter()).filter_map(|name| name.strip_suffix(base(name))).map(str::trim_end).collect();
        let name = format!("{} {}", extremes.join(", "), text::readable(base(first)));
        return (name, unit.to_owned());
    }
    if wanted.iter().all(|name| unit_of(name) == unit) {
        let names: Vec<String> = wanted.iter().map(|name| text::readable(name)).collect();
        return (names.join(", "), unit.to_owned());
    }
    let names: Vec<String> =
        (wanted.iter()).map(|name| text::with_unit(&text::readable(name), unit_of(name), 0)).collect();
    (names.join(", "), String::new())
}

#[cfg(test)]
mod tests {
    use super::super::series::series;
    use super::*;
    use crate::branch::{Branch, Column, Row};

    fn branch(name: &str, units: &[(&str, &str)]) -> Branch {
        let column = |&(name, unit): &(&str, &str)| Column { name: name.into(), unit: unit.into() };
        Branch {
            name: name.into(),
            kind: BranchKind::Equilibria,
            free: vec![],
            columns: units.iter().map(column).collect(),
            rows: vec![Row { values: vec![Some(1.0); units.len()], ..Row::default() }],
            points: vec![],
            triangles: vec![],
        }
    }

    fn label(y: &[&str]) -> (String, String) {
        let units = [("p", ""), ("tip_angle", "rad"), ("max speed", "m/s"), ("turn", "rad")];
        let y: Vec<String> = y.iter().map(|y| y.to_string()).collect();
        let branch = branch("straight", &units);
        y_label(&y, &series("p", &y, &[&branch]))
    }

    #[test]
    fn several_columns_share_a_label() {
        let is = |name: &str, unit: &str| (name.to_owned(), unit.to_owned());
        assert_eq!(label(&["max tip_angle"]), is("max tip angle", "rad"));
        assert_eq!(label(&["max tip_angle", "min tip_angle"]), is("max, min tip angle", "rad"));
        assert_eq!(label(&["tip_angle", "turn", "none"]), is("tip angle, turn", "rad"));
        assert_eq!(label(&["turn", "max speed"]), is("turn (rad), max speed (m/s)", ""));
    }

    #[test]
    fn equilibria_share_an_entry() {
        let branches = ["straight", "buckled_up"].map(|name| branch(name, &[("p", ""), ("a", "")]));
        let series = series("p", &["a".into()], &[&branches[0], &branches[1]]);
        let names: Vec<String> = names(&series).into_iter().map(|(_, name)| name).collect();
        assert_eq!(names, ["straight, buckled up"]);
    }
}
