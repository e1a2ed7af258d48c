//! A branch as CSV: a header with names and units, then one row per point.
//!
//! `label,stable,p [pN µm⁻¹],max tip_deflection [µm]` and below it `HB1,true,338.889485397848,0`. A number is the
//! shortest text that reads back to the same bits; what does not exist is an empty cell.

use super::csv::{Problem, records, write_record};
use super::store::{StoreError, write_atomically};
use super::{Branch, BranchKind, Column, Row};
use std::path::Path;

/// Writes the rows and columns of a branch. Its special points go elsewhere (see [`super::write_point`]).
pub fn write_branch(path: &Path, branch: &Branch) -> Result<(), StoreError> {
    let width = branch.columns.len();
    if let Some((i, row)) = (branch.rows.iter().enumerate()).find(|(_, r)| r.values.len() != width) {
        return Err(StoreError::Shape {
            path: path.to_owned(),
            what: format!("row {i} of the branch {}", branch.name),
            found: row.values.len(),
            wanted: format!("{width} columns"),
        });
    }
    write_atomically(path, |file| {
        let heads = branch.columns.iter().map(head);
        let fixed = ["label".to_owned(), "stable".to_owned()];
        write_record(file, fixed.into_iter().chain(heads))?;
        for row in &branch.rows {
            let label = row.label.clone().unwrap_or_default();
            let stable = row.stable.map(|s| s.to_string()).unwrap_or_default();
            let values = row.values.iter().map(|v| v.map(number).unwrap_or_default());
            write_record(file, [label, stable].into_iter().chain(values))?;
        }
        Ok(())
    })
}

/// Reads rows and columns; what a table does not hold is given (name, kind, free parameters) or left empty (points).
pub fn read_branch(path: &Path, name: &str, kind: BranchKind, free: &[String]) -> Result<Branch, StoreError> {
    let text = std::fs::read_to_string(path).map_err(|cause| StoreError::Read { path: path.to_owned(), cause })?;
    let (columns, rows) =
        table(&text).map_err(|(line, problem)| StoreError::Table { path: path.to_owned(), line, problem })?;
    Ok(Branch { rows, ..Branch::new(name, kind, free.to_vec(), columns) })
}

fn table(text: &str) -> Result<(Vec<Column>, Vec<Row>), Problem> {
    let mut records = records(text)?.into_iter();
    let columns: Vec<Column> = match records.next() {
        Some((_, head)) if matches!(&head[..], [a, b, ..] if a == "label" && b == "stable") => {
            head.iter().skip(2).map(|text| column(text)).collect()
        }
        _ => return Err((1, "the header must begin with `label,stable,`".into())),
    };
    let mut rows = Vec::with_capacity(records.len());
    for (line, cells) in records {
        if cells.len() != columns.len() + 2 {
            let (found, wanted) = (cells.len(), columns.len() + 2);
            return Err((line, format!("{found} cells where the header has {wanted}")));
        }
        rows.push(row(&cells).map_err(|problem| (line, problem))?);
    }
    Ok((columns, rows))
}

fn row(cells: &[String]) -> Result<Row, String> {
    let mut row = Row::default();
    for (i, cell) in cells.iter().enumerate() {
        let text = cell.trim();
        match i {
            0 => row.label = (!text.is_empty()).then(|| text.to_owned()),
            1 => {
                row.stable = match text {
                    "" => None,
                    "true" => Some(true),
                    "false" => Some(false),
                    _ => return Err(format!("`{text}` is neither `true` nor `false` nor empty")),
                }
            }
            _ if text.is_empty() => row.values.push(None),
            _ => match text.parse() {
                Ok(value) => row.values.push(Some(value)),
                Err(_) => return Err(format!("`{text}` is not a number")),
            },
        }
    }
    Ok(row)
}

/// "name [unit]". A name without unit that ends in a bracket gets an empty unit, so that it reads back as it was.
fn head(column: &Column) -> String {
    if column.unit.is_empty() && !column.name.ends_with(']') {
        column.name.clone()
    } else {
        format!("{} [{}]", column.name, column.unit)
    }
}

fn column(head: &str) -> Column {
    let (name, unit) = head.strip_suffix(']').and_then(|rest| rest.rsplit_once(" [")).unwrap_or((head, ""));
    Column { name: name.to_owned(), unit: unit.to_owned() }
}

fn number(value: f64) -> String {
    let mut text = format!("{value:?}");
    if text.ends_with(".0") {
        text.truncate(text.len() - 2);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn branch(columns: &[(&str, &str)], rows: Vec<Row>) -> Branch {
        let column = |(name, unit): &(&str, &str)| Column { name: name.to_string(), unit: unit.to_string() };
        Branch {
            name: "beat".into(),
            kind: BranchKind::Cycles,
            free: vec!["p".into()],
            columns: columns.iter().map(column).collect(),
            rows,
            points: vec![],
            triangles: vec![],
        }
    }

    fn row(label: Option<&str>, stable: Option<bool>, values: &[Option<f64>]) -> Row {
        Row { label: label.map(str::to_owned), stable, values: values.to_vec() }
    }

    fn round_trip(branch: &Branch) -> (String, Branch) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("branches/beat.csv");
        write_branch(&path, branch).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let back = read_branch(&path, &branch.name, branch.kind, &branch.free).unwrap();
        (text, back)
    }

    fn problem(text: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("beat.csv");
        std::fs::write(&path, text).unwrap();
        read_branch(&path, "beat", BranchKind::Cycles, &[]).unwrap_err().to_string()
    }

    #[test]
    fn the_format_is_the_documented_one() {
        let columns = [("p", "pN µm⁻¹"), ("max tip_deflection", "µm"), ("ratio", "")];
        let rows = vec![
            row(Some("HB1"), Some(true), &[Some(338.889485397848), Some(0.0), None]),
            row(None, None, &[Some(1e-12), Some(-2.5e20), Some(1.0 / 3.0)]),
        ];
        let branch = branch(&columns, rows);
        let (text, back) = round_trip(&branch);
        assert_eq!(
            text,
            "label,stable,p [pN µm⁻¹],max tip_deflection [µm],ratio\n\
             HB1,true,338.889485397848,0,\n,,1e-12,-2.5e20,0.3333333333333333\n"
        );
        assert_eq!(back, branch);
    }

    #[test]
    fn awkward_names_and_numbers_come_back() {
        let columns = [("a, \"b\"\nc", "m"), ("d [e]", ""), ("f [g]", "1/s")];
        let extremes = [f64::MAX, f64::MIN_POSITIVE, 5e-324, -0.0, f64::INFINITY, 0.1 + 0.2];
        let rows = extremes.iter().map(|&v| row(Some("U,Z\"1"), Some(false), &[Some(v), None, Some(-v)])).collect();
        let branch = branch(&columns, rows);
        assert_eq!(round_trip(&branch).1, branch);
    }

    #[test]
    fn no_rows_and_no_columns_come_back() {
        for branch in [branch(&[], vec![]), branch(&[], vec![row(None, None, &[])])] {
            assert_eq!(round_trip(&branch).1, branch);
        }
    }

    #[test]
    fn files_of_other_programs_are_read() {
        let (columns, rows) = table("\u{feff}label,stable,p [1/s]\r\n\r\n,true, 2\r\n").unwrap();
        assert_eq!(columns[0].unit, "1/s");
        assert_eq!(rows, [row(None, Some(true), &[Some(2.0)])]);
    }

    #[test]
    fn a_ragged_branch_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("beat.csv");
        let ragged = branch(&[("p", "")], vec![row(None, None, &[])]);
        let message = write_branch(&path, &ragged).unwrap_err().to_string();
        assert!(message.contains("row 0 of the branch beat"), "{message}");
        assert!(!path.exists());
    }

    #[test]
    fn problems_name_file_line_and_cell() {
        for (text, wanted) in [
            ("", "line 1: the header"),
            ("p,q\n", "line 1: the header"),
            ("label,stable,p\n,,1\n,,x\n", "line 3: `x` is not a number"),
            ("label,stable,p\n,yes,1\n", "line 2: `yes` is neither"),
            ("label,stable,p\n,,1,2\n", "line 2: 4 cells where the header has 3"),
            ("label,stable,p\n\n\"a\n,,1\n", "line 3: a quotation mark"),
        ] {
            let message = problem(text);
            assert!(message.contains("beat.csv") && message.contains(wanted), "{message}");
        }
    }
}
