//! Reading untrusted files: which files an input may name, and how much memory it may take.
//!
//! An input is a file that the user names, with all files that it names in turn: buffers, pictures,
//! materials, other scenes. Those are read only where they lie in or below the folder of the input,
//! symbolic links resolved, unless [`Limits::outside`] allows more. Only regular files are read: no
//! devices, pipes or folders. A reader first counts what it is about to allocate against
//! [`Limits::memory`]; the count is never lowered, so it is an upper bound.

use crate::LightUnits;
use crate::missing::{Missing, is_missing};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::cell::Cell;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use unrender_scene::BrdfModel;

/// Why a file is not read, as the end of a sentence about it.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{problem}")]
#[non_exhaustive]
pub struct InputError {
    /// What is wrong with it and what to do, without a final full stop.
    pub problem: String,
    /// The error of the system, if it was involved.
    pub source: Option<Arc<io::Error>>,
}

impl From<&str> for InputError {
    fn from(problem: &str) -> Self {
        Self { problem: problem.to_owned(), source: None }
    }
}

impl From<String> for InputError {
    fn from(problem: String) -> Self {
        Self { problem, source: None }
    }
}

impl From<io::Error> for InputError {
    fn from(error: io::Error) -> Self {
        Self { problem: unreadable(&error), source: Some(Arc::new(error)) }
    }
}

impl From<InputError> for String {
    fn from(error: InputError) -> Self {
        error.problem
    }
}

/// The limits of reading one input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// Whether an input may name files outside its folder.
    pub outside: bool,
    /// Whether a scene is read without the files that it names and that are missing.
    pub missing: bool,
    /// The memory that the input may take, bytes.
    pub memory: u64,
}

/// 2 GiB: 140 million pixels of 8 bits, or 10 million triangles. With half of it, the photographs of
/// some cameras would be refused; with double, machines of 4 GiB would run out of memory.
const DEFAULT_MEMORY: u64 = 2 << 30;

impl Default for Limits {
    fn default() -> Self {
        Self { outside: false, missing: false, memory: DEFAULT_MEMORY }
    }
}

/// A file to read, with the limits of reading it. A path alone has the default limits.
#[derive(Clone, Copy, Debug)]
pub struct Input<'a> {
    /// The file.
    pub path: &'a Path,
    /// The limits of reading it.
    pub limits: Limits,
    /// The units of the lights of a glTF file, where they override the file's own.
    pub light_units: Option<LightUnits>,
    /// The BRDF model of materials whose file states none, as glTF's and OBJ's; none for that of the format.
    pub brdf: Option<BrdfModel>,
    /// The origin of the positions that are read, in the world of the file.
    pub(crate) origin: DVec3,
}

impl<'a> Input<'a> {
    /// The file at `path` within `limits`.
    pub fn new(path: &'a Path, limits: Limits) -> Self {
        let (brdf, origin) = (None, DVec3::ZERO);
        Self { path, limits, light_units: None, brdf, origin }
    }

    /// The same, its lights in these units, if they are stated.
    pub fn in_light_units(self, light_units: Option<LightUnits>) -> Self {
        Self { light_units, ..self }
    }

    /// The same, its materials of this BRDF model, if it states none.
    pub fn with_brdf(self, brdf: BrdfModel) -> Self {
        Self { brdf: Some(brdf), ..self }
    }

    /// The same, its positions counted from `origin`.
    pub(crate) fn about(self, origin: DVec3) -> Self {
        Self { origin, ..self }
    }
}

impl<'a, P: AsRef<Path> + ?Sized> From<&'a P> for Input<'a> {
    fn from(path: &'a P) -> Self {
        Self::new(path.as_ref(), Limits::default())
    }
}

/// An input that is being read: its folder, and the memory that is counted so far.
#[derive(Debug)]
pub(crate) struct Scope {
    /// The folder as the user names it.
    folder: PathBuf,
    limits: Limits,
    brdf: Option<BrdfModel>,
    origin: DVec3,
    used: Cell<u64>,
    missing: Missing,
}

impl Scope {
    pub(crate) fn new(input: Input<'_>) -> Self {
        let folder = input.path.parent().filter(|f| !f.as_os_str().is_empty());
        Self {
            folder: folder.unwrap_or(Path::new(".")).to_owned(),
            limits: input.limits,
            brdf: input.brdf,
            origin: input.origin,
            used: Cell::new(0),
            missing: Missing::default(),
        }
    }

    /// The bytes of the file at `path`, which comes from the user or from [`Scope::beside`]; or what
    /// is wrong, as the end of a sentence about the file.
    pub(crate) fn read(&self, path: &Path) -> Result<Vec<u8>, String> {
        let left = self.limits.memory.saturating_sub(self.used.get());
        let bytes = read_at_most(path, left)?;
        self.charge(bytes.len() as u64)?;
        Ok(bytes)
    }

    /// As [`Scope::read`], as text.
    pub(crate) fn text(&self, path: &Path) -> Result<String, String> {
        String::from_utf8(self.read(path)?).map_err(|_| NO_TEXT.into())
    }

    /// The path of the file that the input calls `name`, seen from `folder`; or why it is not read,
    /// as the end of a sentence about the file.
    pub(crate) fn beside(&self, folder: &Path, name: &str) -> Result<PathBuf, String> {
        let path = folder.join(name);
        if self.limits.outside {
            return Ok(path);
        }
        let real = fs::canonicalize(&path).map_err(|error| unreadable(&error))?;
        let root = fs::canonicalize(&self.folder).map_err(|error| unreadable(&error))?;
        if real.starts_with(&root) {
            // The resolved path: a link that changes later cannot lead elsewhere.
            return Ok(real);
        }
        Err(format!(
            "lies outside the folder {} of the file that you named; copy it there, or allow it by \
             --allow-outside",
            self.folder.display()
        ))
    }

    /// As [`Scope::beside`], but none if there is no such file. The reader goes on without it, and asks at the end
    /// for [`Scope::complete`].
    pub(crate) fn find(&self, folder: &Path, name: &str) -> Result<Option<PathBuf>, String> {
        if is_missing(&folder.join(name)) {
            self.missing.note(name);
            return Ok(None);
        }
        self.beside(folder, name).map(Some)
    }

    /// Checks that all files were there, or that the limits allow that they are missing.
    pub(crate) fn complete(&self) -> Result<(), String> {
        if self.limits.missing { Ok(()) } else { self.missing.error() }
    }

    /// The BRDF model of materials whose file states none.
    pub(crate) fn brdf(&self) -> Option<BrdfModel> {
        self.brdf
    }

    /// The origin of the scene's positions, in the world of its file.
    pub(crate) fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Counts `bytes` that are about to be allocated; an error if that is too much.
    pub(crate) fn charge(&self, bytes: u64) -> Result<(), String> {
        let used = self.used.get().saturating_add(bytes);
        if used > self.limits.memory {
            return Err(too_large(used, self.limits.memory));
        }
        self.used.set(used);
        Ok(())
    }
}

/// The bytes of the file that the user has named.
///
/// # Errors
/// If it is not a regular file, is larger than [`Limits::memory`] or cannot be read.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<Vec<u8>, InputError> {
    let input = input.into();
    read_at_most(input.path, input.limits.memory)
}

/// As [`read()`], as text.
///
/// # Errors
/// As [`read()`], and if the file is not UTF-8.
pub fn text<'a>(input: impl Into<Input<'a>>) -> Result<String, InputError> {
    String::from_utf8(read(input)?).map_err(|_| NO_TEXT.into())
}

const NO_TEXT: &str = "is no text (UTF-8)";

fn read_at_most(path: &Path, limit: u64) -> Result<Vec<u8>, InputError> {
    // Checked before opening: opening a pipe waits for its writer.
    let meta = fs::metadata(path)?;
    if !meta.is_file() {
        return Err("is not a regular file, but a folder, a device or a pipe".into());
    }
    if meta.len() > limit {
        return Err(too_large(meta.len(), limit).into());
    }
    let file = File::open(path)?;
    // Files of /proc have the size zero, and others may grow.
    let mut bytes = Vec::with_capacity(meta.len() as usize);
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(bytes.len() as u64, limit).into());
    }
    Ok(bytes)
}

fn unreadable(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "cannot be read: it does not exist".into(),
        _ => format!("cannot be read: {error}"),
    }
}

fn too_large(needed: u64, limit: u64) -> String {
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    format!(
        "needs more memory than inputs may take ({:.2} of {:.2} GiB); if it is meant to, raise the \
         limit by --input-memory",
        gib(needed),
        gib(limit)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_lies_below_the_folder_is_beside() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path().join("scene");
        fs::create_dir_all(root.join("textures")).unwrap();
        fs::write(folder.path().join("secret"), "x").unwrap();
        fs::write(root.join("textures/a.png"), "x").unwrap();
        let path = root.join("scene.gltf");
        let scope = Scope::new(Input::from(&path));
        assert!(scope.beside(&root, "textures/../textures/a.png").is_ok());
        for name in ["../secret", "/etc/passwd", "textures/../../secret"] {
            let problem = scope.beside(&root, name).unwrap_err();
            assert!(problem.contains("--allow-outside"), "{name}: {problem}");
        }
        assert_eq!(scope.beside(&root, "none").unwrap_err(), "cannot be read: it does not exist");
        let limits = Limits { outside: true, ..Limits::default() };
        assert!(Scope::new(Input::new(&path, limits)).beside(&root, "../secret").is_ok());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(folder.path().join("secret"), root.join("link")).unwrap();
            assert!(scope.beside(&root, "link").is_err());
        }
    }

    #[test]
    fn devices_folders_and_large_files_are_not_read() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read(folder.path()).unwrap_err().problem.contains("regular"));
        #[cfg(unix)]
        assert!(read("/dev/zero").unwrap_err().problem.contains("regular"));
        let path = folder.path().join("large");
        File::create(&path).unwrap().set_len(3 << 30).unwrap();
        assert!(read(&path).unwrap_err().problem.contains("--input-memory"));
        let scope = Scope::new(Input::new(&path, Limits { memory: 100, ..Limits::default() }));
        assert!(scope.charge(60).is_ok() && scope.charge(60).is_err() && scope.charge(40).is_ok());
    }
}
