//! A folder of results as one unit: complete or not written at all, from one run, written by one
//! process at a time; it replaces no files of others.
//!
//! Files are written into a new folder inside, and moved to their names when all exist.
//! `manifest.json` has the SHA-256 of every file. It is written before the files are moved, with the
//! earlier hashes too, so that [`check`] can detect an interruption. A file belongs to us if its hash
//! is in the manifest.

mod manifest;

pub use manifest::check;
pub(crate) use manifest::{hash, note};

use crate::own_project::OwnProject;
use crate::project::some_names;
use crate::{Error, interrupt, output};
use manifest::{Entry, Manifest};
use std::collections::BTreeMap;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use unrender_formats::{FileError, atomic};

/// The name of the file with the materials in a folder of results.
pub(crate) const MATERIALS: &str = "materials.json";

/// The file of materials that `path` names: itself, or that of a folder of results, which are those of one run.
///
/// # Errors
/// As those of [`check`].
pub(crate) fn materials(path: &Path) -> Result<PathBuf, Error> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    check(path)?;
    Ok(path.join(MATERIALS))
}

/// A folder into which a command writes its results.
pub(crate) struct ResultFolder {
    path: PathBuf,
    /// The name of the command in the manifest.
    command: &'static str,
    /// Held until the command ends, so that other processes notice it; none if the system has no
    /// locks on folders, or if several processes may share the folder.
    lock: Option<File>,
    /// Whether its pictures are denoised.
    is_denoised: bool,
    /// The folders that were made for it, the innermost first.
    made: Vec<PathBuf>,
}

impl Drop for ResultFolder {
    /// Removes the folders that were made if they are empty, so that a refused input leaves nothing behind.
    fn drop(&mut self) {
        self.lock = None;
        // Folders that are not empty are not removed, nor their parents.
        let _ = self.made.iter().try_for_each(fs::remove_dir);
    }
}

impl ResultFolder {
    /// Makes the folder at `path` if it is missing, and checks before the work whether results can be
    /// written there: the files whose names (relative to the folder, with forward slashes) `writes`
    /// accepts. `inputs` are the files that the command reads.
    ///
    /// # Errors
    /// If another process is writing there, if files cannot be made, or if results would replace an
    /// input or a file that is not ours.
    pub(crate) fn open(
        path: &Path,
        command: &'static str,
        writes: &dyn Fn(&str) -> bool,
        inputs: &[&Path],
    ) -> Result<Self, Error> {
        let mut folder = Self::open_shared(path, command, writes, inputs)?;
        folder.lock = lock(path)?;
        if folder.lock.is_some() {
            sweep(path);
        }
        Ok(folder)
    }

    /// As [`ResultFolder::open`], for commands of which several may write into one folder at a
    /// time.
    pub(crate) fn open_shared(
        path: &Path,
        command: &'static str,
        writes: &dyn Fn(&str) -> bool,
        inputs: &[&Path],
    ) -> Result<Self, Error> {
        let is_missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let made = path.ancestors().take_while(is_missing).map(Path::to_owned).collect();
        let folder = Self { path: path.to_owned(), command, lock: None, is_denoised: false, made };
        output::prepare_folder(path)?;
        let there = manifest::files(path).map_err(|error| folder.unreadable(&error))?;
        let at_risk: Vec<&String> = there.iter().filter(|name| writes(name)).collect();
        let is_input = |name: &&&String| {
            inputs.iter().any(|input| output::is_same_file(&path.join(name.as_str()), input))
        };
        let replaced: Vec<&String> = at_risk.iter().filter(is_input).copied().collect();
        folder.refuse(&replaced, "which are inputs of this run; name another folder by --out")?;
        let manifest = Manifest::read(path)?;
        folder.check_foreign(at_risk.into_iter().cloned().collect(), &manifest)?;
        if manifest.files.is_empty() {
            folder.check_empty()?;
        }
        Ok(folder)
    }

    /// The same folder; its manifest states whether the pictures written from now on are denoised.
    pub(crate) fn denoised(mut self, is_denoised: bool) -> Self {
        self.is_denoised = is_denoised;
        self
    }

    /// Whether materials of an earlier run are there.
    pub(crate) fn has_results(&self) -> bool {
        self.path.join(MATERIALS).exists()
    }

    /// Lets `make` write the file `name` before the results it belongs to are whole, again and again, and returns its
    /// place.
    ///
    /// # Errors
    /// Those of `make`; or if it cannot be written.
    pub(crate) fn grow(
        &self,
        name: &str,
        make: impl FnOnce(&Path) -> Result<(), Error>,
    ) -> Result<PathBuf, Error> {
        let _until_written = interrupt::writing();
        let staging = atomic::staging(&self.path).map_err(|error| self.unwritable(&error))?;
        make(&staging.path().join(name))?;
        let to = self.path.join(name);
        let mut manifest = Manifest::read(&self.path)?;
        let sha256 = manifest::hash(&staging.path().join(name)).map_err(|e| self.unwritable(&e))?;
        let entry = Entry { sha256, by: self.command.to_owned(), denoised: false };
        manifest.files.insert(name.to_owned(), entry);
        manifest.write(&self.path)?;
        atomic::move_file(&staging.path().join(name), &to)?;
        Ok(to)
    }

    /// Removes the file `name` that has grown, where no results came of it.
    pub(crate) fn remove_grown(&self, name: &str) {
        let Ok(mut manifest) = Manifest::read(&self.path) else { return };
        let is_ours = manifest.files.get(name).is_some_and(|entry| entry.by == self.command);
        if self.has_results() || !is_ours {
            return;
        }
        manifest.files.remove(name);
        // What cannot be removed does no harm.
        let _ = fs::remove_file(self.path.join(name));
        if manifest.files.is_empty() {
            let _ = fs::remove_file(self.path.join(Manifest::FILE));
        } else {
            let _ = manifest.write(&self.path);
        }
    }

    /// Lets `make` write into a new folder, and then moves its files to their names. Files of
    /// earlier runs stay only if `keeps`. Ctrl-C waits until all is done.
    ///
    /// # Errors
    /// Those of `make`; or if files cannot be written, in which case the folder is unchanged.
    pub(crate) fn write<T>(
        &self,
        keeps: bool,
        make: impl FnOnce(&Path) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let _until_written = interrupt::writing();
        // If several processes share the folder, each locks it while it writes.
        let _shared = if self.lock.is_some() { None } else { wait_for_lock(&self.path) };
        // Another process may have made the folder, and removed it again when it was refused.
        let staging = fs::create_dir_all(&self.path).and_then(|()| atomic::staging(&self.path));
        let staging = staging.map_err(|error| self.unwritable(&error))?;
        let made = make(staging.path())?;
        let names = manifest::files(staging.path()).map_err(|error| self.unwritable(&error))?;
        let before = Manifest::read(&self.path)?;
        if let Err(error) = self.check_foreign(names.clone(), &before) {
            let kept = staging.keep();
            let problem = format!("{error}. The new results are in {}", kept.display());
            return Err(Error::Request(problem));
        }
        self.swap(&before, staging.path(), &names, keeps)?;
        Ok(made)
    }

    fn swap(
        &self,
        before: &Manifest,
        staging: &Path,
        names: &[String],
        keeps: bool,
    ) -> Result<(), Error> {
        let mut files: BTreeMap<String, Entry> = before.files.clone();
        let is_stale = |name: &String, entry: &Entry| {
            !keeps && entry.by == self.command && !names.contains(name)
        };
        let stale: Vec<String> =
            files.iter().filter(|(n, e)| is_stale(n, e)).map(|(n, _)| n.clone()).collect();
        stale.iter().for_each(|name| {
            files.remove(name);
        });
        for name in names {
            let sha256 = manifest::hash(&staging.join(name)).map_err(|e| self.unwritable(&e))?;
            let is_picture = [".exr", ".png"].iter().any(|extension| name.ends_with(extension));
            let denoised = self.is_denoised && is_picture;
            files.insert(name.clone(), Entry { sha256, by: self.command.to_owned(), denoised });
        }
        let mut after = Manifest { files, before: Some(before.known()), ..Manifest::default() };
        after.write(&self.path)?;
        for name in &stale {
            // It is ours, and it does no harm if it cannot be removed.
            let _ = fs::remove_file(self.path.join(name));
        }
        for name in names {
            let to = self.path.join(name);
            if let Some(parent) = to.parent() {
                fs::create_dir_all(parent).map_err(|error| self.unwritable(&error))?;
            }
            atomic::move_file(&staging.join(name), &to)?;
        }
        after.before = None;
        Ok(after.write(&self.path)?)
    }

    /// An error if there is anything in the folder: results are dozens of files, which nobody wants among others. Hidden
    /// files, empty ones, as a log that has just been begun, and the project of an interrupted run do not count.
    fn check_empty(&self) -> Result<(), Error> {
        let there = fs::read_dir(&self.path).map_err(|error| self.unreadable(&error))?;
        let is_something = |entry: &fs::DirEntry| {
            let is_empty = entry.metadata().is_ok_and(|data| data.is_file() && data.len() == 0);
            let name = entry.file_name();
            !is_empty && !name.as_encoded_bytes().starts_with(b".") && name != OwnProject::FILE
        };
        let others = there.flatten().filter(is_something);
        let mut others: Vec<_> =
            others.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        others.sort();
        if others.is_empty() {
            return Ok(());
        }
        let problem = format!(
            "holds other files ({}), and results would mix with them; name a new folder by --out",
            some_names(others.iter().map(String::as_str))
        );
        Err(FileError::new(&self.path, problem).into())
    }

    /// An error if one of the files `names` exists and is not ours.
    fn check_foreign(&self, names: Vec<String>, manifest: &Manifest) -> Result<(), Error> {
        let is_foreign = |name: &&String| {
            let path = self.path.join(name.as_str());
            name.as_str() != Manifest::FILE
                && path.exists()
                && !manifest.owns(&path, name, self.command)
        };
        let foreign: Vec<&String> = names.iter().filter(is_foreign).collect();
        let remedy = format!(
            "which are not unchanged results of `unrender {}`; name another folder by --out, or \
             move them away",
            self.command
        );
        self.refuse(&foreign, &remedy)
    }

    fn refuse(&self, names: &[&String], why: &str) -> Result<(), Error> {
        const SHOWN: usize = 8;
        if names.is_empty() {
            return Ok(());
        }
        let mut list: Vec<&str> = names.iter().take(SHOWN).map(|name| name.as_str()).collect();
        if names.len() > SHOWN {
            list.push("others");
        }
        let problem = format!("results would replace {}, {why}", list.join(", "));
        Err(FileError::new(&self.path, problem).into())
    }

    fn unwritable(&self, error: &io::Error) -> Error {
        FileError::new(&self.path, format!("results cannot be written there: {error}")).into()
    }

    fn unreadable(&self, error: &io::Error) -> Error {
        FileError::new(&self.path, format!("cannot be read: {error}")).into()
    }
}

/// The lock on the folder at `path`; none where the system has none.
fn lock(path: &Path) -> Result<Option<File>, Error> {
    let Ok(folder) = File::open(path) else { return Ok(None) };
    match folder.try_lock() {
        Ok(()) => Ok(Some(folder)),
        Err(TryLockError::WouldBlock) => {
            let problem = "another unrender is writing into this folder; wait for it, or name \
            another folder by --out";
            Err(FileError::new(path, problem).into())
        }
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

/// Removes the temporary files of killed processes from the folder at `path`, which is locked.
fn sweep(path: &Path) {
    for entry in fs::read_dir(path).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(atomic::PREFIX) && name.ends_with(".tmp") {
            // Files that cannot be removed do no harm.
            let _ = fs::remove_dir_all(entry.path()).or_else(|_| fs::remove_file(entry.path()));
        }
    }
}

fn wait_for_lock(path: &Path) -> Option<File> {
    let folder = File::open(path).ok()?;
    folder.lock().ok().map(|()| folder)
}
