//! The triangles of a surface as PLY (ASCII), which ParaView, MeshLab and Blender read.
//!
//! A vertex per row: x, y, z are the surface's coordinates (logarithms where it is followed by these), each from 0 to 1
//! over the surface's extent; then `criticality` (-1 supercritical, 1 subcritical, 0 unknown) and every column
//! that has a number in each row, but error estimates. Faces are counterclockwise triples of rows.

use super::store::{StoreError, write_atomically};
use super::{Branch, Row};
use std::io::Write;
use std::path::Path;

/// Writes the surface of a branch; one without three coordinates in every row cannot be written.
pub fn write_mesh(path: &Path, branch: &Branch) -> Result<(), StoreError> {
    let shape =
        |what: String, found: usize, wanted: String| StoreError::Shape { path: path.to_owned(), what, found, wanted };
    let full =
        |k: usize| branch.rows.iter().all(|row| row.values.get(k).copied().flatten().is_some_and(f64::is_finite));
    let coordinates: Vec<usize> = branch.coordinates().into_iter().filter(|k| full(*k)).collect();
    if coordinates.len() != 3 {
        return Err(shape(
            format!("the surface {}", branch.name),
            coordinates.len(),
            "three coordinates in each row".into(),
        ));
    }
    if let Some(corner) = branch.triangles.iter().flatten().find(|corner| **corner >= branch.rows.len()) {
        return Err(shape(
            format!("a triangle of {}", branch.name),
            *corner,
            format!("rows below {}", branch.rows.len()),
        ));
    }
    let value = |row: &Row, k: usize| row.values.get(k).copied().flatten().unwrap_or(0.0);
    let extent: Vec<(f64, f64)> = coordinates
        .iter()
        .map(|&k| {
            let (low, high) = (branch.rows.iter().map(|row| value(row, k)))
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            (low, if high > low { high - low } else { 1.0 })
        })
        .collect();
    let columns: Vec<usize> =
        (0..branch.columns.len()).filter(|&k| !branch.columns[k].name.starts_with("error ") && full(k)).collect();
    write_atomically(path, |file| {
        writeln!(file, "ply\nformat ascii 1.0")?;
        for (axis, &k) in ["x", "y", "z"].iter().zip(&coordinates) {
            writeln!(file, "comment {axis} is {} from 0 to 1 over the surface's extent", branch.columns[k].name)?;
        }
        for column in columns.iter().map(|&k| &branch.columns[k]).filter(|column| !column.unit.is_empty()) {
            writeln!(file, "comment {} in {}", word(&column.name), column.unit)?;
        }
        writeln!(file, "element vertex {}", branch.rows.len())?;
        writeln!(file, "property double x\nproperty double y\nproperty double z\nproperty char criticality")?;
        for &k in &columns {
            writeln!(file, "property double {}", word(&branch.columns[k].name))?;
        }
        writeln!(file, "element face {}\nproperty list uchar int vertex_indices\nend_header", branch.triangles.len())?;
        for row in &branch.rows {
            for (&k, (low, size)) in coordinates.iter().zip(&extent) {
                write!(file, "{:?} ", (value(row, k) - low) / size)?;
            }
            write!(file, "{}", row.stable.map_or(0, |stable| if stable { -1 } else { 1 }))?;
            for &k in &columns {
                write!(file, " {:?}", value(row, k))?;
            }
            writeln!(file)?;
        }
        for [a, b, c] in &branch.triangles {
            writeln!(file, "3 {a} {b} {c}")?;
        }
        Ok(())
    })
}

/// Reads the triangles back; `rows` is how many rows there are to name.
pub fn read_triangles(path: &Path, rows: usize) -> Result<Vec<[usize; 3]>, StoreError> {
    let text = std::fs::read_to_string(path).map_err(|cause| StoreError::Read { path: path.to_owned(), cause })?;
    let fault = |line: usize, problem: String| StoreError::Table { path: path.to_owned(), line: line + 1, problem };
    let mut lines = text.lines().enumerate();
    let (mut vertices, mut faces) = (None, None);
    for (_, line) in lines.by_ref().take_while(|(_, line)| *line != "end_header") {
        let count = |kind: &str| line.strip_prefix(kind).and_then(|count| count.trim().parse::<usize>().ok());
        vertices = vertices.or(count("element vertex "));
        faces = faces.or(count("element face "));
    }
    let (Some(vertices), Some(faces)) = (vertices, faces) else {
        return Err(fault(0, "the header does not say how many vertices and faces there are".into()));
    };
    let triangle = |line: &str| {
        let mut words = line.split_whitespace().map(str::parse::<usize>);
        match (words.next(), words.next(), words.next(), words.next(), words.next()) {
            (Some(Ok(3)), Some(Ok(a)), Some(Ok(b)), Some(Ok(c)), None) if a.max(b).max(c) < rows => Some([a, b, c]),
            _ => None,
        }
    };
    let read: Result<Vec<[usize; 3]>, StoreError> = lines
        .skip(vertices)
        .take(faces)
        .map(|(number, line)| {
            triangle(line).ok_or_else(|| fault(number, format!("`{line}` is no triangle of {rows} rows")))
        })
        .collect();
    match read {
        Ok(found) if found.len() != faces => {
            Err(fault(text.lines().count(), format!("{} faces where the header says {faces}", found.len())))
        }
        read => read,
    }
}

/// A column's name as one word.
fn word(name: &str) -> String {
    name.replace(' ', "_")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::{BranchKind, Column};

    fn surface() -> Branch {
        let column = |name: &str, unit: &str| Column { name: name.into(), unit: unit.into() };
        let row = |values: [Option<f64>; 5], stable| Row { label: None, stable, values: values.to_vec() };
        Branch {
            name: "onset".into(),
            kind: BranchKind::HopfSurface,
            free: ["p", "L", "k"].map(String::from).to_vec(),
            columns: vec![column("p", "N"), column("L", "m"), column("k", ""), column("log10 k", ""), column("l1", "")],
            rows: vec![
                row([Some(1.0), Some(0.0), Some(1.0), Some(0.0), None], None),
                row([Some(3.0), Some(0.5), Some(10.0), Some(1.0), Some(2.0)], Some(false)),
                row([Some(2.0), Some(2.0), Some(100.0), Some(2.0), Some(-2.0)], Some(true)),
            ],
            points: vec![],
            triangles: vec![[0, 1, 2]],
        }
    }

    #[test]
    fn triangles_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("meshes/onset.ply");
        write_mesh(&path, &surface()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains("comment z is log10 k from 0 to 1"), "{text}");
        assert!(text.contains("\n1.0 0.25 0.5 1 3.0 0.5 10.0 1.0\n"), "{text}");
        assert!(!text.contains("l1"), "a column with gaps is left out");
        assert_eq!(read_triangles(&path, 3).unwrap(), [[0, 1, 2]]);
        assert!(read_triangles(&path, 2).unwrap_err().to_string().contains("no triangle of 2 rows"));
        std::fs::write(&path, text.replace("3 0 1 2\n", "")).unwrap();
        assert!(read_triangles(&path, 3).unwrap_err().to_string().contains("0 faces where the header says 1"));
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("onset.ply");
        let mut wrong = surface();
        wrong.triangles.push([0, 1, 3]);
        assert!(write_mesh(&path, &wrong).unwrap_err().to_string().contains("a triangle of onset"));
        wrong.free.pop();
        assert!(write_mesh(&path, &wrong).unwrap_err().to_string().contains("the surface onset"));
    }
}
