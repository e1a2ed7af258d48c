//! Files written whole or not at all, and what can go wrong with files.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// What can go wrong with the files of a study. Every message names the file.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error(
        "cannot create the folder {}: {cause}; choose another output folder or its permissions",
        path.display()
    )]
    Folder { path: PathBuf, cause: io::Error },
    #[error(
        "cannot write {}: {cause}; an older version of it, if any, is untouched", path.display()
    )]
    Write { path: PathBuf, cause: io::Error },
    #[error("cannot read {}: {cause}; run the scene again to write it", path.display())]
    Read { path: PathBuf, cause: io::Error },
    #[error(
        "{}, line {line}: {problem}; correct that line or run the scene again", path.display()
    )]
    Table { path: PathBuf, line: usize, problem: String },
    #[error(
        "cannot write {}: {what} holds {found} numbers where its shape asks for {wanted}; \
         this is a mistake of whoever computed it", path.display()
    )]
    Shape { path: PathBuf, what: String, found: usize, wanted: String },
    #[error(
        "{} is not an archive of real arrays: {problem}; run the scene again to write it",
        path.display()
    )]
    Archive { path: PathBuf, problem: String },
}

/// Writes a file whole or not at all: into a temporary file of the same folder, which then takes the file's name.
///
/// Folders on the way are created. If `write` fails, an older file stays as it was and nothing new is left behind.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> Result<(), StoreError> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(|cause| StoreError::Folder { path: folder.to_owned(), cause })?;
    replace(path, folder, write).map_err(|cause| StoreError::Write { path: path.to_owned(), cause })
}

fn replace(
    path: &Path,
    folder: &Path,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut temporary = temporary_file(folder)?;
    let mut buffer = BufWriter::new(temporary.as_file_mut());
    write(&mut buffer)?;
    buffer.flush()?;
    drop(buffer);
    temporary.as_file().sync_all()?;
    temporary.persist(path).map_err(|failure| failure.error)?;
    Ok(())
}

const PREFIX: &str = ".hopfline-";
const SUFFIX: &str = ".tmp";

/// Whether a file is one of the temporary ones, which a kill can leave behind.
pub fn is_temporary(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX))
}

/// A hidden file that removes itself unless it is renamed. Temporary files are private to the user by default; results
/// have the permissions of any new file.
fn temporary_file(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn folders_are_created_and_a_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/summary.json");
        write_atomically(&path, |w| w.write_all(b"old")).unwrap();
        write_atomically(&path, |w| w.write_all(b"new")).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(entries(path.parent().unwrap()), ["summary.json"]);
    }

    #[test]
    fn a_failing_writer_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("summary.json");
        write_atomically(&path, |w| w.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |w| {
            w.write_all(&[0; 100_000])?;
            Err(io::Error::other("disk full"))
        });
        let message = failed.unwrap_err().to_string();
        assert!(message.contains("summary.json") && message.contains("disk full"), "{message}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(entries(folder.path()), ["summary.json"]);
    }

    #[test]
    fn a_folder_in_the_way_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("taken");
        std::fs::create_dir(&path).unwrap();
        assert!(write_atomically(&path, |w| w.write_all(b"x")).is_err());
        assert_eq!(entries(folder.path()), ["taken"]);
    }

    #[cfg(unix)]
    #[test]
    fn results_have_the_permissions_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
        write_atomically(&ours, |_| Ok(())).unwrap();
        std::fs::write(&plain, "").unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
    }
}
