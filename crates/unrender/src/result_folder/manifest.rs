//! `manifest.json`: which files are the results in a folder, and the hashes of their contents.

use crate::Error;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::Path;
use unrender_formats::{FileError, atomic, input};

/// The version of the file that is written; later ones cannot be read.
const VERSION: u32 = 1;
/// Folders of results have one level of folders inside; deeper ones are not ours.
const DEPTH: usize = 2;

/// The file.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Manifest {
    pub(super) version: u32,
    /// The results, by their paths relative to the folder, with forward slashes.
    pub(super) files: BTreeMap<String, Entry>,
    /// Only while results are being replaced: the hashes of the earlier files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) before: Option<BTreeMap<String, BTreeSet<String>>>,
}

/// One result.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct Entry {
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub(super) sha256: String,
    /// The command that wrote it.
    pub(super) by: String,
    /// Whether it is a picture from which noise was removed.
    #[serde(default, skip_serializing_if = "is_false")]
    pub(super) denoised: bool,
}

fn is_false(is: &bool) -> bool {
    !is
}

impl Default for Manifest {
    fn default() -> Self {
        Self { version: VERSION, files: BTreeMap::new(), before: None }
    }
}

impl Manifest {
    pub(super) const FILE: &str = "manifest.json";

    /// The manifest of `folder`; an empty one if there is none.
    pub(super) fn read(folder: &Path) -> Result<Self, FileError> {
        let path = folder.join(Self::FILE);
        if !path.exists() {
            return Ok(Self::default());
        }
        let fault = |problem: String| FileError::new(&path, problem);
        let text = input::text(&path).map_err(|error| FileError::because(&path, "", error))?;
        let read: Self = serde_json::from_str(&text).map_err(|error| {
            fault(format!("is not a list of results of unrender ({error}); name another folder"))
        })?;
        if read.version > VERSION {
            return Err(fault(format!(
                "is of a later version than {VERSION}; use a newer unrender"
            )));
        }
        Ok(read)
    }

    pub(super) fn write(&self, folder: &Path) -> Result<(), FileError> {
        let path = folder.join(Self::FILE);
        let text = serde_json::to_string_pretty(self)
            .map_err(|error| FileError::new(&path, format!("cannot be written: {error}")))?;
        atomic::write(&path, (text + "\n").as_bytes())
    }

    /// The hashes of every file that a run has written; after an interrupted replacement, the
    /// earlier ones too.
    pub(super) fn known(&self) -> BTreeMap<String, BTreeSet<String>> {
        let mut known = self.before.clone().unwrap_or_default();
        for (name, entry) in &self.files {
            known.entry(name.clone()).or_default().insert(entry.sha256.clone());
        }
        known
    }

    /// Whether the file at `path`, called `name` here, is an unchanged result of `command`.
    pub(super) fn owns(&self, path: &Path, name: &str, command: &str) -> bool {
        if self.files.get(name).is_some_and(|entry| entry.by != command) {
            return false;
        }
        let known = self.known();
        let Some(hashes) = known.get(name) else { return false };
        hash(path).is_ok_and(|hash| hashes.contains(&hash))
    }
}

/// Checks by the manifest that the results in `folder` are those of one run. Folders without a
/// manifest, of earlier versions, pass.
///
/// # Errors
/// If they are not.
pub fn check(folder: &Path) -> Result<(), Error> {
    let manifest = Manifest::read(folder)?;
    let is_half = manifest.before.is_some();
    let is_other = |name: &&String| {
        let path = folder.join(name.as_str());
        match hash(&path) {
            Ok(hash) => hash != manifest.files[name.as_str()].sha256,
            // A missing file was removed on purpose.
            Err(_) => is_half || path.exists(),
        }
    };
    let others: Vec<&str> = manifest.files.keys().filter(is_other).map(String::as_str).collect();
    if others.is_empty() {
        return Ok(());
    }
    let problem = if is_half {
        "the writing of its results was interrupted, and files of two runs are mixed in it; run \
         the command that wrote it again"
            .to_owned()
    } else {
        format!(
            "{} changed since they were written, and do not belong to the other results; run the \
             command that wrote them again, or, if the change is intended, remove {}",
            others.join(", "),
            Manifest::FILE
        )
    };
    Err(FileError::new(folder, problem).into())
}

/// Updates the manifest, if there is one, after the result `name` in `folder` has changed.
pub(crate) fn note(folder: &Path, name: &str, by: &str) -> Result<(), Error> {
    let mut manifest = Manifest::read(folder)?;
    if manifest.files.is_empty() {
        return Ok(());
    }
    let path = folder.join(name);
    let sha256 = hash(&path).map_err(|error| FileError::new(&path, error))?;
    let entry = Entry { sha256, by: by.to_owned(), denoised: false };
    manifest.files.insert(name.to_owned(), entry);
    Ok(manifest.write(folder)?)
}

/// SHA-256 of the file at `path`.
pub(crate) fn hash(path: &Path) -> io::Result<String> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("is not a regular file"));
    }
    let mut digest = Sha256::new();
    io::copy(&mut fs::File::open(path)?, &mut Writing(&mut digest))?;
    Ok(digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

struct Writing<'a>(&'a mut Sha256);

impl io::Write for Writing<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The files in `folder` and the folders in it, relative to it, with forward slashes, in order.
/// Temporary ones are left out.
pub(super) fn files(folder: &Path) -> io::Result<Vec<String>> {
    let mut found = Vec::new();
    collect(folder, "", DEPTH, &mut found)?;
    found.sort();
    Ok(found)
}

fn collect(folder: &Path, prefix: &str, depth: usize, found: &mut Vec<String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with(atomic::PREFIX) {
            continue;
        }
        let name = format!("{prefix}{name}");
        // Links to folders are not followed: their targets are not ours.
        if !entry.file_type()?.is_dir() {
            found.push(name);
        } else if depth > 1 {
            collect(&entry.path(), &format!("{name}/"), depth - 1, found)?;
        }
    }
    Ok(())
}
