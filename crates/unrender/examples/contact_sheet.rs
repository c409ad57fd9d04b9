//! Lays pictures side by side into one PNG or JPEG.
//!
//! `cargo run --release --example contact_sheet -- OUT SHRINK PICTURE...`: each picture is reduced
//! by the whole number SHRINK, by the mean of linear light over SHRINK x SHRINK pixels.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use unrender::formats::{FileError, atomic, picture};
use unrender::scene::color::srgb_from_linear;
use unrender::scene::{Rgb, RgbImage};

/// White pixels between two pictures.
const GAP: usize = 8;
/// The quality of a JPEG, 1 to 100: at 92 its errors are not visible at this size; at 80 edges show
/// rings.
const JPEG_QUALITY: u8 = 92;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, shrink, pictures @ ..] = arguments.as_slice() else { return usage() };
    let Some(shrink) = shrink.parse().ok().filter(|&s: &usize| s > 0) else { return usage() };
    let paths: Vec<PathBuf> = pictures.iter().map(PathBuf::from).collect();
    match write_sheet(Path::new(out), shrink, &paths) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn usage() -> ExitCode {
    eprintln!("usage: contact_sheet OUT.png|OUT.jpg SHRINK PICTURE...");
    ExitCode::from(2)
}

fn write_sheet(out: &Path, shrink: usize, paths: &[PathBuf]) -> Result<(), FileError> {
    let mut pictures = Vec::new();
    for path in paths {
        let (read, _) = picture::read(path)?;
        pictures.push(smaller(&read.to_linear(), shrink));
    }
    let sheet = beside(&pictures);
    if out.extension().is_none_or(|extension| extension != "jpg") {
        picture::write_png_srgb(out, &sheet)?;
        return Ok(());
    }
    let codes = sheet.map(|rgb| Rgb::from_array(rgb.to_array().map(srgb_from_linear)));
    let bytes = picture::jpeg_bytes(&codes, JPEG_QUALITY);
    atomic::write(out, &bytes.map_err(|problem| FileError::new(out, problem))?)
}

/// The mean over each `shrink` x `shrink` block; the rest at the edges is cut off.
fn smaller(picture: &RgbImage, shrink: usize) -> RgbImage {
    let mean = |x: usize, y: usize| {
        let rows = y * shrink..(y + 1) * shrink;
        let block = rows.flat_map(|row| (x * shrink..(x + 1) * shrink).map(move |col| (col, row)));
        // A lamp counts as white, or it would bleed into the pixels around it.
        let shown = |(col, row)| picture.at(col, row).clamp(Rgb::ZERO, Rgb::ONE);
        block.map(shown).sum::<Rgb>() / (shrink * shrink) as f32
    };
    RgbImage::from_fn(picture.width() / shrink, picture.height() / shrink, mean)
}

/// The pictures from left to right on white, their upper edges in line.
fn beside(pictures: &[RgbImage]) -> RgbImage {
    let height = pictures.iter().map(RgbImage::height).max().unwrap_or(1);
    let gaps = GAP * pictures.len().saturating_sub(1);
    let width = pictures.iter().map(RgbImage::width).sum::<usize>() + gaps;
    let mut sheet = RgbImage::from_fn(width.max(1), height, |_, _| Rgb::ONE);
    let mut left = 0;
    for picture in pictures {
        for y in 0..picture.height() {
            for x in 0..picture.width() {
                sheet.pixels_mut()[y * width + left + x] = *picture.at(x, y);
            }
        }
        left += picture.width() + GAP;
    }
    sheet
}
