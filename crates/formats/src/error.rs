//! The one error of this crate: which file, what is wrong, what to do.

use std::fmt;
use std::path::{Path, PathBuf};

/// A file that cannot be read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", path.display())]
#[non_exhaustive]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it and what to do, without a final full stop.
    pub problem: String,
}

impl FileError {
    /// The error that `path` has `problem`.
    pub fn new(path: &Path, problem: impl fmt::Display) -> Self {
        Self { path: path.to_owned(), problem: problem.to_string() }
    }
}
