//! The one error of this crate: which file, what is wrong, what to do.

use std::error::Error;
use std::fmt::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use unrender_scene::Warnings;

/// The most warnings that are shown after an error; they fit on a screen.
const SHOWN_BEFORE: usize = 20;

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

    /// The error that `path` has the problem `what` (may be empty) because of `cause`, whose text
    /// becomes part of the problem.
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

    /// This error with the `warnings` that came before it, which may explain it; only the latest, if there
    /// are many.
    ///
    /// ```
    /// use std::path::Path;
    /// use unrender_formats::FileError;
    /// use unrender_scene::Warnings;
    ///
    /// let warnings = Warnings(vec!["the lamp \"a\" was left out".into()]);
    /// let error = FileError::new(Path::new("a.rad"), "has no light").after(&warnings);
    /// assert!(error.to_string().ends_with("has no light\n  before that: the lamp \"a\" was left out"));
    /// ```
    #[must_use]
    pub fn after(mut self, warnings: &Warnings) -> Self {
        let from = warnings.0.len().saturating_sub(SHOWN_BEFORE);
        for warning in &warnings.0[from..] {
            let _ = write!(self.problem, "\n  before that: {warning}");
        }
        self
    }

    /// The error of another library or of the system behind this one, if there is one. Its text is in
    /// [`FileError::problem`] already, so it is not a `source`.
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
