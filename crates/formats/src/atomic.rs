//! Whole files or none: write to a temporary name beside the target, then rename.
//!
//! A symbolic link stays a link: the file it points to is replaced. A write-protected file is not
//! replaced. The bytes are on the disk before the file is renamed.

use crate::FileError;
use std::fs::{self, File, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes `bytes` to `path` so that nobody ever sees half of them.
///
/// # Errors
/// If the folder does not exist or cannot be written, or if the file is write-protected; nothing is
/// left behind then.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    try_write(path, bytes).map_err(|error| FileError::because(path, "cannot be written", error))
}

/// Checks that [`write()`] could write to `path` now, by writing an empty file beside it.
///
/// # Errors
/// As those of [`write()`].
pub fn check(path: &Path) -> Result<(), FileError> {
    let target = target(path);
    target
        .and_then(|(path, permissions)| beside(&path, permissions).and_then(NamedTempFile::close))
        .map_err(|error| FileError::because(path, "cannot be written", error))
}

fn try_write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (path, permissions) = target(path)?;
    // Removed again when it is dropped.
    let mut file = beside(&path, permissions)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(&path).map_err(|error| error.error)?;
    sync_folder(folder_of(&path));
    Ok(())
}

/// Moves the whole file `from` to `to`, as [`write()`] does with bytes.
///
/// # Errors
/// As those of [`write()`].
pub fn move_file(from: &Path, to: &Path) -> Result<(), FileError> {
    let moved = target(to).and_then(|(path, _)| {
        File::open(from)?.sync_all()?;
        fs::rename(from, &path)?;
        sync_folder(folder_of(&path));
        Ok(())
    });
    moved.map_err(|error| FileError::because(to, "cannot be written", error))
}

/// What is written when `path` is: where its links end, and the permissions of the file there.
fn target(path: &Path) -> io::Result<(PathBuf, Option<Permissions>)> {
    let path = followed(path)?;
    let Ok(meta) = fs::metadata(&path) else { return Ok((path, None)) };
    if meta.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder; name a file"));
    }
    if !meta.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    if meta.permissions().readonly() {
        let problem = "it is write-protected; remove the protection, or name another file";
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, problem));
    }
    Ok((path, Some(meta.permissions())))
}

/// The longest chain of symbolic links that is followed; Linux has the same limit.
const LINKS: usize = 40;

/// Where the links from `path` end, whether or not something is there.
fn followed(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        match fs::read_link(&path) {
            Ok(link) => path = folder_of(&path).join(link),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("its symbolic links lead round in a circle"))
}

/// A new file beside `path` with these `permissions`, or those of any new file.
fn beside(path: &Path, permissions: Option<Permissions>) -> io::Result<NamedTempFile> {
    if path.file_name().is_none() {
        return Err(io::Error::other("it is not the name of a file"));
    }
    let file = temporary().tempfile_in(folder_of(path))?;
    if let Some(permissions) = permissions {
        // If they cannot be set, the file keeps its own.
        let _ = file.as_file().set_permissions(permissions);
    }
    Ok(file)
}

/// The names of temporary files and folders, which nobody else has.
fn temporary() -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(".tmp");
    // New files of users have these, less the umask; temporary files have fewer.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// What the names of temporary files and folders begin with.
pub const PREFIX: &str = ".unrender-";

/// A new empty folder in `folder`, which is removed when it is dropped.
///
/// # Errors
/// If it cannot be made.
pub fn staging(folder: &Path) -> io::Result<tempfile::TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(".tmp");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    builder.tempdir_in(folder)
}

/// Writes `bytes` to `path` directly; for files of a folder that still has a temporary name.
pub(crate) fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Gives the folder that is called `from` the name `to`.
pub(crate) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fs::rename(from, to)?;
    sync_folder(folder_of(to));
    Ok(())
}

/// The folder that `path` is in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes names survive a power cut. Not all systems can; the files are whole without it.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        fs::create_dir_all(folder.join("taken")).unwrap();
        let error = write(&folder.join("taken"), b"x").unwrap_err();
        assert!(error.to_string().contains("cannot be written"), "{error}");
        assert_eq!(fs::read_dir(folder).unwrap().count(), 1, "only the folder in the way");
        write(&folder.join("fine"), b"x").unwrap();
        assert_eq!(fs::read(folder.join("fine")).unwrap(), b"x");
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_links_and_protected_files_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("elsewhere")).unwrap();
        fs::write(path("elsewhere/real"), "old").unwrap();
        fs::set_permissions(path("elsewhere/real"), Permissions::from_mode(0o640)).unwrap();
        symlink("elsewhere/real", path("link")).unwrap();
        write(&path("link"), b"new").unwrap();
        assert!(fs::symlink_metadata(path("link")).unwrap().is_symlink());
        assert_eq!(fs::read(path("elsewhere/real")).unwrap(), b"new");
        let mode = fs::metadata(path("elsewhere/real")).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        symlink("elsewhere/none", path("dangling")).unwrap();
        write(&path("dangling"), b"new").unwrap();
        assert_eq!(fs::read(path("elsewhere/none")).unwrap(), b"new");
        symlink("circle", path("circle")).unwrap();
        assert!(write(&path("circle"), b"new").is_err());

        fs::write(path("protected"), "old").unwrap();
        fs::set_permissions(path("protected"), Permissions::from_mode(0o444)).unwrap();
        for result in [write(&path("protected"), b"new"), check(&path("protected"))] {
            let error = result.unwrap_err().to_string();
            assert!(error.contains("write-protected"), "{error}");
        }
        assert_eq!(fs::read(path("protected")).unwrap(), b"old");
        write(&path("plain"), b"new").unwrap();
        let mode = fs::metadata(path("plain")).unwrap().permissions().mode();
        assert_ne!(mode & 0o044, 0, "others may read it, as what `touch` makes: {mode:o}");
    }
}
