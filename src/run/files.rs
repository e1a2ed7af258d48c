//! The folder of a run: `output/SCENE/` with branches, points, figures, summary and log.

use crate::branch::{
    Branch, BranchKind, StoreError, is_temporary, write_atomically, write_branch, write_mesh, write_point,
};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

pub struct Folder {
    root: PathBuf,
}

impl Folder {
    /// Makes sure that the folder can be written before anything is computed.
    pub fn open(out: &Path, scene: &str) -> Result<Self, StoreError> {
        let folder = Self { root: out.join(scene) };
        sweep(&folder.root);
        folder.write_log("")?;
        Ok(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    /// Removes what an earlier run left of these tasks, and its summary.
    pub fn clear<'a>(&self, tasks: impl Iterator<Item = &'a str>) {
        remove(&self.path("summary.json"));
        for task in tasks {
            remove(&self.path("branches").join(format!("{task}.csv")));
            remove(&self.path(&mesh(task)));
            remove(&self.path("resume").join(format!("{task}.json")));
            if let Ok(entries) = std::fs::read_dir(self.path("points").join(task)) {
                entries
                    .flatten()
                    .filter(|e| e.path().extension().is_some_and(|x| x == "npz"))
                    .for_each(|e| remove(&e.path()));
            }
        }
    }

    /// Removes the branches of a diagram: those of other numbers would be left.
    pub fn clear_parts(&self, task: &str) {
        let number =
            |name: &str| name.strip_prefix(task).and_then(|rest| rest.strip_prefix('-')?.parse::<usize>().ok());
        for entry in std::fs::read_dir(self.path("branches")).into_iter().flatten().flatten() {
            let path = entry.path();
            let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default().to_owned();
            if number(&stem).is_some() {
                remove(&path);
                let _ = std::fs::remove_dir_all(self.path("points").join(stem));
            }
        }
    }

    pub fn write_branch(&self, branch: &Branch) -> Result<(), StoreError> {
        if branch.rows.is_empty() {
            return Ok(());
        }
        write_branch(&self.path("branches").join(format!("{}.csv", branch.name)), branch)?;
        if branch.kind == BranchKind::HopfSurface {
            write_mesh(&self.path(&mesh(&branch.name)), branch)?;
        }
        for point in &branch.points {
            write_point(&self.path("points").join(format!("{}.npz", point.label)), point)?;
        }
        Ok(())
    }

    pub fn write_figure(&self, name: &str, svg: &str) -> Result<(), StoreError> {
        write_figure(&self.root, name, svg)
    }

    pub fn write_json(&self, name: &str, content: &impl Serialize) -> Result<(), StoreError> {
        write_atomically(&self.path(name), |file| {
            serde_json::to_writer_pretty(file, content).map_err(std::io::Error::from)
        })
    }

    pub fn write_log(&self, log: &str) -> Result<(), StoreError> {
        write_atomically(&self.path("run.log"), |file| file.write_all(log.as_bytes()))
    }
}

/// Writes a figure into the folder of a run.
pub fn write_figure(root: &Path, name: &str, svg: &str) -> Result<(), StoreError> {
    write_atomically(&root.join("figures").join(format!("{name}.svg")), |file| file.write_all(svg.as_bytes()))
}

/// Where the triangles of a task are, in the run's folder.
pub fn mesh(task: &str) -> String {
    format!("meshes/{task}.ply")
}

/// Removes the temporary files of a run that was killed while it wrote.
fn sweep(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            sweep(&path);
        } else if is_temporary(&path) {
            remove(&path);
        }
    }
}

/// A file that is not there is as good as removed; one that cannot be removed will be overwritten or fail there.
fn remove(path: &Path) {
    let _ = std::fs::remove_file(path);
}
