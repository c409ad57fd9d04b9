//! Whether results can be written, asked before the work and not after it.

use std::fs;
use std::path::Path;
use unrender_formats::FileError;

/// Makes the folder for results where it is missing and checks that files can be made in it.
pub(crate) fn prepare_folder(folder: &Path) -> Result<(), FileError> {
    fs::create_dir_all(folder).and_then(|()| try_file(folder)).map_err(|error| {
        FileError::new(folder, format!("results cannot be written there: {error}"))
    })
}

/// Checks that a picture can be written to `path`: its extension and its folder.
pub(crate) fn check_picture(path: &Path) -> Result<(), FileError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if !["exr", "hdr", "png"].contains(&extension.as_str()) {
        return Err(FileError::new(path, "end the name of the picture in .exr, .hdr or .png"));
    }
    if path.is_dir() {
        return Err(FileError::new(path, "is a folder; name a file"));
    }
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    try_file(folder).map_err(|error| FileError::new(path, format!("cannot be written: {error}")))
}

fn try_file(folder: &Path) -> std::io::Result<()> {
    let name = folder.join(format!(".unrender.{}.tmp", std::process::id()));
    fs::write(&name, [])?;
    fs::remove_file(&name)
}
