//! Brackets of exposures: reading their files as frames, and merging them.

use crate::project::Frames;
use std::path::{Path, PathBuf};
use unrender_formats::picture::{self, ExifExposure};
use unrender_formats::{FileError, Input, Limits, input};
use unrender_photo::bracket::{Bracket, Frame, Settings, merge};
use unrender_scene::Warnings;

/// Where a bracket is stated, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place<'a> {
    /// By the command `merge-exposures`.
    Command,
    /// By this project.
    Project(&'a Path),
}

impl<'a> Place<'a> {
    fn path(self) -> &'a Path {
        match self {
            Self::Command => Path::new("merge-exposures"),
            Self::Project(path) => path,
        }
    }

    /// How to state exposure times there.
    fn of_times(self) -> &'static str {
        match self {
            Self::Command => "by --times 1/60,1/15,1/4",
            Self::Project(_) => {
                "in the project, as in photo = { bracket = [...], times = [\"1/60\", \"1/15\", \"1/4\"] }"
            }
        }
    }
}

/// Reads the files of `bracket` and merges them as `settings` say.
///
/// # Errors
/// If a file cannot be read, if no exposure time is stated or in the file, or if the frames are no
/// bracket; the last error names `place`.
pub(crate) fn read_and_merge(
    bracket: &Frames,
    settings: &Settings,
    limits: Limits,
    place: Place<'_>,
) -> Result<(Bracket, Warnings), FileError> {
    let (frames, mut warnings) = read(bracket, limits, place)?;
    let merged =
        merge(&frames, settings).map_err(|problem| FileError::new(place.path(), problem))?;
    let names: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
    warnings.extend(merged.report.doubts(&names));
    Ok((merged, warnings))
}

fn read(
    bracket: &Frames,
    limits: Limits,
    place: Place<'_>,
) -> Result<(Vec<Frame>, Warnings), FileError> {
    let mut warnings = Warnings::default();
    let mut frames = Vec::new();
    let mut exposures = Vec::new();
    for path in &bracket.files {
        let bytes = input::read(Input::new(path, limits))
            .map_err(|error| FileError::because(path, "", error))?;
        exposures.push(picture::exposure_of(&bytes));
        drop(bytes);
        let (picture, noted) = picture::read(Input::new(path, limits))?;
        warnings.extend(noted);
        frames.push(Frame { name: name(path), picture, exposure: 1.0, gain: 1.0 });
    }
    match &bracket.times {
        Some(times) if times.len() != frames.len() => {
            let problem = format!(
                "there are {} exposure times for {} photographs of the bracket; give one for each, \
                 in the same order",
                times.len(),
                frames.len()
            );
            return Err(FileError::new(place.path(), problem));
        }
        Some(times) => {
            frames.iter_mut().zip(times).for_each(|(frame, time)| frame.exposure = *time);
        }
        None => warnings.extend(by_files(&mut frames, &bracket.files, &exposures, place)?),
    }
    Ok((frames, warnings))
}

/// The exposures that the files state: time, times sensitivity, divided by the square of the f-number.
fn by_files(
    frames: &mut [Frame],
    files: &[PathBuf],
    exposures: &[ExifExposure],
    place: Place<'_>,
) -> Result<Warnings, FileError> {
    let mut warnings = Warnings::default();
    let count = |of: &dyn Fn(&ExifExposure) -> Option<f64>| exposures.iter().filter_map(of).count();
    let all = exposures.len();
    let [apertures, speeds] = [count(&|e| e.f_number), count(&|e| e.iso)];
    for (found, what) in [(apertures, "f-number"), (speeds, "ISO number")] {
        if found > 0 && found < all {
            warnings.push(format!(
                "{found} of {all} photographs of the bracket state their {what}; it was taken to be \
                 the same in all"
            ));
        }
    }
    for ((frame, exposure), file) in frames.iter_mut().zip(exposures).zip(files) {
        let seconds = exposure.seconds.ok_or_else(|| {
            let problem = format!(
                "states no exposure time; give those of all photographs of the bracket {}",
                place.of_times()
            );
            FileError::new(file, problem)
        })?;
        let f_number = exposure.f_number.filter(|_| apertures == all).unwrap_or(1.0);
        frame.gain = exposure.iso.filter(|_| speeds == all).unwrap_or(1.0);
        frame.exposure = seconds * frame.gain / (f_number * f_number);
    }
    Ok(warnings)
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
