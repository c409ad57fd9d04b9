//! Whole files or none: write to a temporary name beside the target, then rename.

use crate::FileError;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes `bytes` to `path` so that nobody ever sees half of them.
///
/// # Errors
/// If the folder does not exist or cannot be written; nothing is left behind then.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let temporary = temporary_beside(path);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|error| {
        // The temporary file may not exist; there is nothing more to clean up then.
        let _ = fs::remove_file(&temporary);
        FileError::new(path, format!("cannot be written: {error}"))
    })
}

/// Writes `bytes` to `path` as they come; for files of a folder that has not its name yet.
pub(crate) fn put(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    fs::write(path, bytes)
}

/// Gives what is called `from` the name `to`.
pub(crate) fn rename(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::rename(from, to)
}

/// A name beside `path` that nobody else has.
pub(crate) fn temporary_beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_nothing_behind() {
        let folder = std::env::temp_dir().join(format!("unrender-atomic-{}", std::process::id()));
        fs::create_dir_all(folder.join("taken")).unwrap();
        let error = write(&folder.join("taken"), b"x").unwrap_err();
        assert!(error.to_string().contains("cannot be written"), "{error}");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "only the folder in the way");
        write(&folder.join("fine"), b"x").unwrap();
        assert_eq!(fs::read(folder.join("fine")).unwrap(), b"x");
        fs::remove_dir_all(folder).unwrap();
    }
}
