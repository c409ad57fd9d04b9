//! Checks before the work whether results can be written; the one way in which commands write a
//! picture; and the one place that writes to stdout and stderr.
//!
//! Their reader may be gone, or the disk behind them full. No work is lost for that: text that
//! cannot be written is dropped.

use crate::Error;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;
use unrender_formats::picture::{self, ColourSpace};
use unrender_formats::{FileError, atomic};
use unrender_render::Accumulator;
use unrender_scene::{RgbImage, Warnings};

/// Creates the folder for results if it is missing and checks that files can be created in it.
pub(crate) fn prepare_folder(folder: &Path) -> Result<(), FileError> {
    let tried = fs::create_dir_all(folder).and_then(|()| atomic::staging(folder)?.close());
    tried.map_err(|error| {
        FileError::new(folder, format!("results cannot be written there: {error}"))
    })
}

/// Checks that a result at `out` would replace none of `inputs`.
pub(crate) fn check_inputs<'a>(
    out: &Path,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Error> {
    let same = |input: &&Path| is_same_file(out, input);
    match inputs.into_iter().find(same) {
        None => Ok(()),
        Some(_) => {
            let problem =
                "is an input of this run and would be replaced; name another file by --out";
            Err(FileError::new(out, problem).into())
        }
    }
}

/// Whether both paths lead to the same existing file.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    real(a).is_some_and(|a| real(b) == Some(a))
}

/// Checks that a picture can be written to `path`: its extension and its folder.
pub(crate) fn check_picture(path: &Path) -> Result<(), FileError> {
    check_file(path, &["exr", "hdr", "png"], "end the name of the picture in .exr, .hdr or .png")
}

/// How a picture is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Encoding {
    /// The colour space of an EXR.
    pub(crate) space: ColourSpace,
    /// Multiplies all light.
    pub(crate) factor: f32,
}

impl Default for Encoding {
    fn default() -> Self {
        Self { space: ColourSpace::default(), factor: 1.0 }
    }
}

impl Encoding {
    /// The light of `picture`, exposed so.
    pub(crate) fn exposed(self, picture: RgbImage) -> RgbImage {
        if self.factor == 1.0 { picture } else { picture.map(|light| self.factor * *light) }
    }
}

/// Writes the mean of `accumulator`, or the `denoised` picture; warns of values that are not numbers.
pub(crate) fn write_picture(
    path: &Path,
    accumulator: &Accumulator,
    denoised: Option<RgbImage>,
    encoding: Encoding,
) -> Result<Warnings, FileError> {
    match denoised {
        Some(denoised) => {
            picture::write_denoised(path, &encoding.exposed(denoised), encoding.space)?
        }
        None => picture::write_in(path, &encoding.exposed(accumulator.mean()), encoding.space)?,
    };
    Ok(doubts(accumulator))
}

/// Warnings of the paths in `accumulator`.
pub(crate) fn doubts(accumulator: &Accumulator) -> Warnings {
    let mut warnings = Warnings::default();
    if accumulator.faulty() > 0 {
        warnings.push(format!(
            "the radiance of {} path(s) was infinite or not a number: they count as black; are there very large \
             or very small numbers in the scene?",
            accumulator.faulty()
        ));
    }
    warnings
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
    atomic::check(path)
}

/// The extension in small letters.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}

/// The folder that a file is in.
pub(crate) fn folder(path: &Path) -> &Path {
    path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Prints `text` to stdout. A closed reader is ignored; a full disk causes a warning.
pub(crate) fn print(text: &str) {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            tell(&format!("warning: standard output cannot be written: {error}"));
        }
        _ => {}
    }
}

/// Prints the line `text` to stderr, if it is open.
pub(crate) fn tell(text: &str) {
    // One write, so that lines of several threads do not mix.
    let _ = std::io::stderr().lock().write_all(format!("{text}\n").as_bytes());
}
