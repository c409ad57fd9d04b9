//! `unrender merge-exposures`: a bracket of photographs becomes one linear picture.

use crate::global::Global;
use crate::project::{Frames, seconds};
use crate::text_table::table;
use crate::{Error, bracket, interrupt, output, photograph};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender_formats::picture;
use unrender_formats::response_curve::{self, ResponseRows};
use unrender_photo::Response;
use unrender_photo::bracket::{Bracket, ResponseFit, Settings};
use unrender_scene::Rgb;

/// Merges photographs of several exposures into one linear picture.
///
/// The photographs are of one scene by one camera that did not move, and differ in exposure time, aperture or
/// ISO number, which their EXIF data state. The camera's response is fitted to them, unless it is stated or
/// the files have floating-point values. The picture has the unit of the best exposed photograph: 1 is its
/// white. Its variances are in the channels variance.R, variance.G and variance.B. A project takes it as its
/// photo, or names the photographs itself: photo = { bracket = ["a.jpg", "b.jpg"] }.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    unrender merge-exposures dark.jpg middle.jpg bright.jpg --out merged.exr\n  \
    unrender merge-exposures a.png b.png c.png --times 1/60,1/15,1/4 --response-out curve.csv --out merged.exr")]
pub struct Args {
    /// The photographs, in any order.
    #[arg(required = true, value_name = "PHOTO")]
    pub photos: Vec<PathBuf>,
    /// Their exposure times, in the same order [default: time, ISO number and f-number by EXIF].
    #[arg(long, value_name = "T,T,...", value_delimiter = ',', value_parser = seconds)]
    pub times: Option<Vec<f64>>,
    /// The camera's response: srgb, linear, or a file as for projects [default: found from the photographs].
    #[arg(long, value_name = "FILE")]
    pub response: Option<PathBuf>,
    /// The pixel value of no light, where 1 is white.
    #[arg(long, value_name = "X", default_value_t = 0.0, value_parser = black)]
    pub black_level: f32,
    /// The pixel value from which on the photographs are clipped [default: the greatest of the file; none
    /// for floating-point files].
    #[arg(long, value_name = "X", value_parser = white)]
    pub white_level: Option<f32>,
    /// Write the fitted response to this file, to state it later.
    #[arg(long, value_name = "FILE.csv")]
    pub response_out: Option<PathBuf>,
    /// The picture to write.
    #[arg(long, value_name = "FILE.exr")]
    pub out: PathBuf,
}

/// Runs the command.
///
/// # Errors
/// If a photograph cannot be read, the photographs are no bracket, no response can be fitted, or a
/// result cannot be written.
pub fn run(args: &Args, global: &Global) -> Result<ExitCode, Error> {
    check_outputs(args)?;
    let response = args.response.as_deref().map(response).transpose()?;
    let is_stated = response.is_some();
    let settings = Settings {
        response,
        black_level: Rgb::splat(args.black_level),
        white_level: Rgb::splat(args.white_level.unwrap_or(f32::INFINITY)),
    };
    let frames = Frames { files: args.photos.clone(), times: args.times.clone() };
    let place = bracket::Place::Command;
    let (merged, warnings) = bracket::read_and_merge(&frames, &settings, global.limits(), place)?;
    global.console.warn(&warnings);
    let fit = merged.report.fit.as_ref();
    if args.response_out.is_some() && fit.is_none() {
        let why = if is_stated { "it is stated" } else { "the photographs are linear" };
        return Err(Error::Request(format!("--response-out: no response was found, as {why}")));
    }
    let _until_written = interrupt::writing();
    if let (Some(path), Some(fit)) = (&args.response_out, fit) {
        let ResponseFit { codes, linear, .. } = fit;
        let rows = ResponseRows { codes: codes.clone(), linear: linear.clone() };
        response_curve::write(path, &rows, "found by unrender merge-exposures")?;
    }
    picture::write_merged(&args.out, &merged.picture)?;
    global.console.print(&summary(&merged, &args.photos));
    Ok(ExitCode::SUCCESS)
}

fn black(text: &str) -> Result<f32, String> {
    let level = text.parse().ok().filter(|level| (0.0..0.5).contains(level));
    level.ok_or_else(|| "is not a pixel value from 0 to below 0.5, where 1 is white".into())
}

fn white(text: &str) -> Result<f32, String> {
    let level = text.parse().ok().filter(|level: &f32| level.is_finite() && *level >= 0.5);
    level.ok_or_else(|| "is not a pixel value of at least 0.5, where 1 is white".into())
}

fn check_outputs(args: &Args) -> Result<(), Error> {
    output::check_file(&args.out, &["exr"], "end the name of the merged picture in .exr")?;
    let inputs = || args.photos.iter().chain(&args.response).map(PathBuf::as_path);
    output::check_inputs(&args.out, inputs())?;
    if let Some(path) = &args.response_out {
        output::check_file(path, &["csv"], "end the name of the response file in .csv")?;
        output::check_inputs(path, inputs())?;
    }
    Ok(())
}

fn response(value: &Path) -> Result<Response, Error> {
    match value.to_str().and_then(|name| name.parse().ok()) {
        Some(response) => Ok(response),
        None => Ok(photograph::measured(value)?),
    }
}

/// The summary of the merging, for the terminal.
fn summary(merged: &Bracket, photos: &[PathBuf]) -> String {
    let report = &merged.report;
    let mut rows = vec![["photograph", "shift", "left out"].map(str::to_owned)];
    for (index, path) in photos.iter().enumerate() {
        let [right, down] = report.shifts[index];
        let left_out = match index == report.reference {
            true => "reference: 1 is its white".to_owned(),
            false => format!("{:.2} %", 100.0 * report.ghosts[index]),
        };
        rows.push([path.display().to_string(), format!("{right}, {down}"), left_out]);
    }
    let mut text = table(&rows);
    if let Some(fit) = &report.fit {
        text.push_str(&format!(
            "response found; the polynomial of Mitsunaga and Nayar differs by {:.2} % of white\n",
            100.0 * fit.disagreement
        ));
    }
    if let Some(noise) = &report.noise {
        let [base, slope] = [noise.base, noise.slope].map(|v| v.iter().sum::<f64>() / 3.0);
        text.push_str(&format!(
            "noise of the reference, of white: variance {base:.1e} + {slope:.1e} L\n"
        ));
    }
    let white = merged.picture.merged.as_ref().map(|m| m.white_level.to_array());
    if let Some([r, g, b]) = white.filter(|white| white.iter().all(|w| w.is_finite())) {
        text.push_str(&format!("clipped from {r:.4}, {g:.4}, {b:.4} on\n"));
    }
    text
}
