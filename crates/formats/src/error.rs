//! The one error of this crate: which file, what is wrong, what to do.

use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file that cannot be read or written.
///
/// Two are equal if they say the same of the same file.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}: {problem}", path.display())]
#[non_exhaustive]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it and what to do, without a final full stop.
    pub problem: String,
    cause: Option<Arc<dyn Error + Send + Sync>>,
}

impl FileError {
    /// The error that `path` has `problem`.
    pub fn new(path: &Path, problem: impl fmt::Display) -> Self {
        Self { path: path.to_owned(), problem: problem.to_string(), cause: None }
    }

    /// The error that `path` has the problem `what`, if that says anything, because of `cause`, whose
    /// text becomes part of the problem.
    ///
    /// ```
    /// use std::io;
    /// use std::path::Path;
    /// use unrender_formats::FileError;
    ///
    /// let full = io::Error::from(io::ErrorKind::StorageFull);
    /// let error = FileError::because(Path::new("a.png"), "cannot be written", full);
    /// assert!(error.to_string().starts_with("a.png: cannot be written: "));
    /// let cause = error.cause().and_then(|cause| cause.downcast_ref::<io::Error>());
    /// assert_eq!(cause.unwrap().kind(), io::ErrorKind::StorageFull);
    /// ```
    pub fn because(path: &Path, what: &str, cause: impl Error + Send + Sync + 'static) -> Self {
        let problem = if what.is_empty() { cause.to_string() } else { format!("{what}: {cause}") };
        Self { cause: Some(Arc::new(cause)), ..Self::new(path, problem) }
    }

    /// The error of another library or of the system behind this one, if there is one. Its text is in
    /// [`FileError::problem`] already, so that it is no `source`.
    pub fn cause(&self) -> Option<&(dyn Error + Send + Sync + 'static)> {
        self.cause.as_deref()
    }
}

impl PartialEq for FileError {
    fn eq(&self, other: &Self) -> bool {
        (&self.path, &self.problem) == (&other.path, &other.problem)
    }
}

impl Eq for FileError {}
