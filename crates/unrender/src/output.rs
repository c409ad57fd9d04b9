//! Whether results can be written, asked before the work and not after it; and the one way in which
//! commands write a picture.

use crate::cli::warn;
use std::fs;
use std::path::Path;
use unrender_formats::{FileError, picture};
use unrender_render::Accumulator;
use unrender_scene::Warnings;

/// Makes the folder for results where it is missing and checks that files can be made in it.
pub(crate) fn prepare_folder(folder: &Path) -> Result<(), FileError> {
    fs::create_dir_all(folder).and_then(|()| try_file(folder)).map_err(|error| {
        FileError::new(folder, format!("results cannot be written there: {error}"))
    })
}

/// Checks that a picture can be written to `path`: its extension and its folder.
pub(crate) fn check_picture(path: &Path) -> Result<(), FileError> {
    check_file(path, &["exr", "hdr", "png"], "end the name of the picture in .exr, .hdr or .png")
}

/// Writes the picture that `tally` has come to, and tells what in it is no number.
pub(crate) fn write_picture(path: &Path, tally: &Accumulator) -> Result<(), FileError> {
    picture::write(path, &tally.mean())?;
    let mut warnings = Warnings::default();
    if tally.faulty() > 0 {
        warnings.push(format!(
            "{} path(s) brought no finite number and were counted as black",
            tally.faulty()
        ));
    }
    warn(&warnings);
    Ok(())
}

/// Checks that a file can be written to `path`, whose extension is one of `extensions`; `remedy`
/// says so.
pub(crate) fn check_file(path: &Path, extensions: &[&str], remedy: &str) -> Result<(), FileError> {
    if !extensions.contains(&extension(path).as_str()) {
        return Err(FileError::new(path, remedy));
    }
    if path.is_dir() {
        return Err(FileError::new(path, "is a folder; name a file"));
    }
    try_file(folder(path))
        .map_err(|error| FileError::new(path, format!("cannot be written: {error}")))
}

/// The extension in small letters.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// The folder that a file is in.
pub(crate) fn folder(path: &Path) -> &Path {
    path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Prints to stdout; a reader that has gone away is no fault of ours.
pub(crate) fn print(text: &str) {
    use std::io::Write;
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}

fn try_file(folder: &Path) -> std::io::Result<()> {
    let name = folder.join(format!(".unrender.{}.tmp", std::process::id()));
    fs::write(&name, [])?;
    fs::remove_file(&name)
}
