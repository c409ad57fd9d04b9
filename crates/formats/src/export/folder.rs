//! Folders of files, written whole or not at all.

use super::Files;
use crate::{FileError, atomic};
use std::fs;
use std::io;
use std::path::Path;

/// Writes `files` as the folder `path`: into a folder beside it, which gets its name at the end.
///
/// # Errors
/// If `path` is there already and is not an empty folder, or if it cannot be written; nothing is
/// left behind then.
pub(super) fn write_folder(path: &Path, files: &Files) -> Result<(), FileError> {
    check_folder(path)?;
    let written = atomic::staging(atomic::folder_of(path)).and_then(|temporary| {
        fill(temporary.path(), files)?;
        // An empty folder of that name may be there; not all systems rename onto one.
        let _ = fs::remove_dir(path);
        atomic::rename(&temporary.keep(), path)
    });
    written.map_err(|error| FileError::new(path, format!("cannot be written: {error}")))
}

/// Writes `bytes` as the file `path`, and `others`, which all are in one folder, as that folder beside it. The folder comes
/// first, so that the file never lacks what it names.
///
/// # Errors
/// If that folder is there already and is not empty, or if one of them cannot be written; nothing is left behind then.
pub(super) fn write_beside(
    path: &Path,
    bytes: &[u8],
    others: &[(String, Vec<u8>)],
) -> Result<(), FileError> {
    let split = |(name, bytes): &(String, Vec<u8>)| {
        let (folder, name) = name.split_once('/')?;
        Some((folder.to_owned(), (name.to_owned(), bytes.clone())))
    };
    let (folders, inside): (Vec<String>, Files) = others.iter().filter_map(split).unzip();
    let folder = folders.first().map(|name| atomic::folder_of(path).join(name));
    if let Some(folder) = &folder {
        write_folder(folder, &inside)?;
    }
    atomic::write(path, bytes).inspect_err(|_| {
        // What was made above is not left behind.
        let _ = folder.map(fs::remove_dir_all);
    })
}

/// Checks that a folder of results could be called `path`.
///
/// # Errors
/// If something with contents has that name already.
pub(super) fn check_folder(path: &Path) -> Result<(), FileError> {
    match fs::read_dir(path) {
        Ok(mut entries) => match entries.next() {
            None => Ok(()),
            Some(_) => Err(FileError::new(
                path,
                "is a folder with something in it; name one that is not there yet",
            )),
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => atomic::check(path),
        Err(_) => Err(FileError::new(path, "is no folder; name one that is not there yet")),
    }
}

fn fill(folder: &Path, files: &Files) -> io::Result<()> {
    for (name, bytes) in files {
        let path = folder.join(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        atomic::put(&path, bytes)?;
    }
    Ok(())
}
