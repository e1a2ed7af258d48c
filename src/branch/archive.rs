//! The arrays of a special point as NPZ, which numpy reads.

use super::SpecialPoint;
use super::store::{StoreError, write_atomically};
use ndarray::{ArrayD, ArrayViewD, IxDyn};
use ndarray_npy::{NpzReader, NpzWriter, ReadNpzError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::Path;

/// A real array in row-major order.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Array {
    pub shape: Vec<usize>,
    pub data: Vec<f64>,
}

impl Array {
    /// With one index.
    pub fn vector(data: Vec<f64>) -> Self {
        Self { shape: vec![data.len()], data }
    }
}

/// Writes all arrays of a special point, each in its shape.
pub fn write_point(path: &Path, point: &SpecialPoint) -> Result<(), StoreError> {
    let mut views = Vec::with_capacity(point.arrays.len());
    for (name, array) in &point.arrays {
        let view = ArrayViewD::from_shape(IxDyn(&array.shape), &array.data)
            .ok()
            .filter(|view| view.len() == array.data.len())
            .ok_or_else(|| StoreError::Shape {
                path: path.to_owned(),
                what: format!("the array `{name}` of {}", point.label),
                found: array.data.len(),
                wanted: format!("{:?}", array.shape),
            })?;
        views.push((name, view));
    }
    write_atomically(path, |file| {
        let mut archive = NpzWriter::new(file);
        for (name, view) in &views {
            archive.add_array(name.as_str(), view).map_err(io::Error::other)?;
        }
        archive.finish().map_err(io::Error::other)?;
        Ok(())
    })
}

/// Reads all arrays of an NPZ file.
pub fn read_arrays(path: &Path) -> Result<BTreeMap<String, Array>, StoreError> {
    let file = File::open(path).map_err(|cause| StoreError::Read { path: path.to_owned(), cause })?;
    arrays(file).map_err(|cause| StoreError::Archive { path: path.to_owned(), problem: cause.to_string() })
}

fn arrays(file: File) -> Result<BTreeMap<String, Array>, ReadNpzError> {
    let mut archive = NpzReader::new(file)?;
    let mut arrays = BTreeMap::new();
    for (index, name) in archive.names()?.into_iter().enumerate() {
        let array: ArrayD<f64> = archive.by_index(index)?;
        let (shape, data) = (array.shape().to_vec(), array.iter().copied().collect());
        arrays.insert(name, Array { shape, data });
    }
    Ok(arrays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branch::Kind;

    fn point(arrays: &[(&str, &[usize], Vec<f64>)]) -> SpecialPoint {
        let array = |shape: &[usize], data: &Vec<f64>| Array { shape: shape.to_vec(), data: data.clone() };
        SpecialPoint {
            label: "beat/UZ1".into(),
            kind: Kind::UZ,
            row: 0,
            parameters: BTreeMap::new(),
            values: BTreeMap::new(),
            errors: BTreeMap::new(),
            arrays: arrays.iter().map(|(n, s, d)| (n.to_string(), array(s, d))).collect(),
        }
    }

    #[test]
    fn arrays_come_back_in_their_shapes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points/beat-UZ1.npz");
        let point = point(&[
            ("state", &[3], vec![1.0 / 3.0, -0.0, 5e-324]),
            ("wave_x", &[2, 3], (0..6).map(f64::from).collect()),
            ("period", &[], vec![0.1]),
            ("nothing", &[0, 4], vec![]),
        ]);
        write_point(&path, &point).unwrap();
        assert_eq!(read_arrays(&path).unwrap(), point.arrays);
    }

    #[test]
    fn no_arrays_make_an_empty_archive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("HB1.npz");
        write_point(&path, &point(&[])).unwrap();
        assert!(read_arrays(&path).unwrap().is_empty());
    }

    #[test]
    fn a_wrong_shape_is_refused_before_anything_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("HB1.npz");
        for shape in [&[2, 2][..], &[2], &[usize::MAX, 3]] {
            let wrong = point(&[("state", shape, vec![1.0, 2.0, 3.0])]);
            let message = write_point(&path, &wrong).unwrap_err().to_string();
            assert!(message.contains("`state` of beat/UZ1"), "{message}");
        }
        assert!(!path.exists());
    }

    #[test]
    fn what_is_not_an_archive_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("HB1.npz");
        assert!(matches!(read_arrays(&path), Err(StoreError::Read { .. })));
        std::fs::write(&path, "no archive").unwrap();
        let message = read_arrays(&path).unwrap_err().to_string();
        assert!(message.contains("HB1.npz"), "{message}");
    }
}
