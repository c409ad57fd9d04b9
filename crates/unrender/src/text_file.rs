//! Reads a text file that the user names, and says what the path leads to if it is no such file.

use std::path::{Path, PathBuf};
use unrender_formats::{FileError, Kind, input};

/// A kind of TOML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Expected {
    /// A project.
    Project,
    /// An edit file.
    Edit,
}

impl Expected {
    fn in_words(self) -> &'static str {
        match self {
            Self::Project => {
                "a project file: a text that names the scene and the photo, scene = \"room.glb\" and photo = \"room.png\""
            }
            Self::Edit => {
                "an edit file: a text that names what is edited, recovered = \"out\" or scene = \"room.glb\", and the edits"
            }
        }
    }
}

/// The text of the file at `path`, which should be the `expected` one.
///
/// # Errors
/// If it cannot be read, or is something else.
pub(crate) fn read(path: &Path, expected: Expected) -> Result<String, FileError> {
    let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let kind = Kind::of(path);
    let is_else = |kind: Kind| {
        let there = if kind == Kind::Folder { inside(path) } else { String::new() };
        FileError::new(path, format!("is {kind}; expected {}{there}", expected.in_words()))
    };
    match kind {
        // The beginning of a text may happen to be that of a picture.
        Some(kind) if !(is_toml && kind == Kind::Picture) => Err(is_else(kind)),
        _ => input::text(path)
            .map_err(|error| kind.map_or_else(|| FileError::because(path, "", error), is_else)),
    }
}

/// The TOML files in `folder` that may have been meant, as the end of a sentence.
fn inside(folder: &Path) -> String {
    const SHOWN: usize = 3;
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    found.sort();
    let names: Vec<String> =
        found.iter().take(SHOWN).map(|path| path.display().to_string()).collect();
    if names.is_empty() { String::new() } else { format!("; did you mean {}?", names.join(" or ")) }
}
