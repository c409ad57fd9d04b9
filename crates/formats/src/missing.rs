//! The files that a scene names and that are not there: collected while it is read, so that one error lists them all.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::Path;

/// The most files in the error; half as many would cut the lists of published scenes with hundreds of meshes, twice
/// as many fill no screen usefully.
const LISTED: usize = 200;

/// The names of files that are not there, each once.
#[derive(Debug, Default)]
pub(crate) struct Missing(RefCell<BTreeSet<String>>);

/// Whether there is nothing at `path`. What cannot be looked at is not missing.
pub(crate) fn is_missing(path: &Path) -> bool {
    std::fs::metadata(path).is_err_and(|error| error.kind() == ErrorKind::NotFound)
}

impl Missing {
    /// Notes that the file that the scene calls `name` is not there.
    pub(crate) fn note(&self, name: &str) {
        self.0.borrow_mut().insert(name.to_owned());
    }

    /// The error that lists them; none if all files are there.
    pub(crate) fn error(&self) -> Result<(), String> {
        let names = self.0.borrow();
        let (what, them) = match names.len() {
            0 => return Ok(()),
            1 => ("a file that it names is missing".to_owned(), "it"),
            count => (format!("{count} files that it names are missing"), "them"),
        };
        let mut text = format!(
            "{what}; put {them} there, or read the scene without {them} by --allow-missing:"
        );
        names.iter().take(LISTED).for_each(|name| text.extend(["\n  ", name.as_str()]));
        if let Some(more @ 1..) = names.len().checked_sub(LISTED) {
            text.push_str(&format!("\n  and {more} more"));
        }
        Err(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_missing_file_is_listed_once() {
        let missing = Missing::default();
        assert_eq!(missing.error(), Ok(()));
        ["b.obj", "a.png", "b.obj"].iter().for_each(|name| missing.note(name));
        let error = missing.error().unwrap_err();
        assert!(error.starts_with("2 files") && error.ends_with("\n  a.png\n  b.obj"), "{error}");
    }

    #[test]
    fn long_lists_end() {
        let missing = Missing::default();
        (0..LISTED + 3).for_each(|k| missing.note(&format!("{k:04}.obj")));
        assert!(missing.error().unwrap_err().ends_with("and 3 more"));
    }
}
