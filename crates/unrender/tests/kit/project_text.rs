//! Reads the text of a project.

use std::path::Path;
use unrender::Project;
use unrender::formats::FileError;
use unrender::scene::Warnings;

const FILES: &str = "scene = \"s.glb\"\nphoto = \"p.png\"\n";

/// The project of the text, after the names of its files.
pub(crate) fn parse(text: &str) -> Result<(Project, Warnings), FileError> {
    Project::parse(Path::new("folder/a.toml"), &format!("{FILES}{text}"))
}

/// The same for a text without faults.
pub(crate) fn good(text: &str) -> Project {
    parse(text).unwrap_or_else(|error| panic!("{text}: {error}")).0
}

/// Asserts that each of the texts is refused for the problem beside it.
#[track_caller]
pub(crate) fn are_refused(faults: &[(&str, &str)]) {
    for (text, problem) in faults {
        let error = parse(text).expect_err(text).to_string();
        assert!(error.starts_with("folder/a.toml: ") && error.contains(problem), "{text}: {error}");
    }
}
