//! Pictures inside the page: JPEG for photographs, PNG where exact colours matter, and reduced to
//! the size of a page.

use crate::Error;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use std::path::Path;
use unrender_formats::FileError;
use unrender_formats::picture::{self, Profile};
use unrender_photo::{Response, Transfer, declared_response};
use unrender_scene::color::srgb_from_linear;
use unrender_scene::{Image, Rgb};

/// Pictures of more pixels are reduced.
const PIXELS_MAX: usize = 1_300_000;
/// Pictures of values under the pointer have no more pixels: they are smooth over several. At half of it the values of
/// small things are those beside them; double of it makes a page of a megapixel a megabyte larger.
const VALUES_MAX: usize = 330_000;
/// The quality of JPEGs, at which they cannot be distinguished from the original beside them.
const QUALITY: u8 = 88;

/// A picture as part of a page.
pub(super) struct Embedded {
    /// A `data:` address.
    pub(super) src: String,
    pub(super) width: usize,
    pub(super) height: usize,
}

/// The picture `file` in `folder`, as a photograph.
pub(super) fn photograph(folder: &Path, file: &str) -> Result<Embedded, Error> {
    let path = folder.join(file);
    let (read, _) = picture::read(&path)?;
    let codes = in_srgb(shrunk(&read.values, PIXELS_MAX, mean), read.profile.as_ref());
    let bytes = picture::jpeg_bytes(&codes, QUALITY).map_err(|e| FileError::new(&path, e))?;
    Ok(embedded(&codes, "jpeg", &bytes))
}

/// Code values as those of sRGB, in which pages show all pictures, by what their file declares.
fn in_srgb(codes: Image<Rgb>, profile: Option<&Profile>) -> Image<Rgb> {
    let Some(profile) = profile.filter(|profile| profile.understood) else { return codes };
    let response = declared_response(profile).unwrap_or(Response::Srgb);
    let srgb_from_file = profile.srgb_from_file;
    if response == Response::Srgb && srgb_from_file.is_none() {
        return codes;
    }
    let transfer = Transfer { srgb_from_file, ..Transfer::plain(response, Rgb::ONE) };
    codes.map(|code| transfer.radiance(*code, 1.0).map(srgb_from_linear))
}

/// The picture `file` in `folder` with exact colours.
pub(super) fn exact(folder: &Path, file: &str) -> Result<Embedded, Error> {
    sampled(folder, file, PIXELS_MAX)
}

/// The picture `file` in `folder` of the values under the pointer.
pub(super) fn values(folder: &Path, file: &str) -> Result<Embedded, Error> {
    sampled(folder, file, VALUES_MAX)
}

/// A picture of which every so many pixels are kept as they are, at most `most`.
fn sampled(folder: &Path, file: &str, most: usize) -> Result<Embedded, Error> {
    let path = folder.join(file);
    let codes = shrunk(&picture::read(&path)?.0.values, most, |block| block[0]);
    let bytes = picture::png_bytes(&codes).map_err(|e| FileError::new(&path, e))?;
    Ok(embedded(&codes, "png", &bytes))
}

impl Embedded {
    /// Its shape for the style, which keeps pictures within the window.
    pub(super) fn aspect(&self) -> String {
        format!("--aspect:{}", self.width as f64 / self.height.max(1) as f64)
    }
}

fn embedded(codes: &Image<Rgb>, kind: &str, bytes: &[u8]) -> Embedded {
    let src = format!("data:image/{kind};base64,{}", BASE64_STANDARD.encode(bytes));
    Embedded { src, width: codes.width(), height: codes.height() }
}

fn mean(block: &[Rgb]) -> Rgb {
    block.iter().sum::<Rgb>() / block.len() as f32
}

/// The picture reduced by blocks of pixels, no larger than necessary, to at most about `most`.
fn shrunk(codes: &Image<Rgb>, most: usize, of_block: fn(&[Rgb]) -> Rgb) -> Image<Rgb> {
    let side = (codes.pixels().len() as f64 / most as f64).sqrt().ceil().max(1.0) as usize;
    let (width, height) = (codes.width(), codes.height());
    Image::from_fn(width.div_ceil(side), height.div_ceil(side), |x, y| {
        let rows = y * side..((y + 1) * side).min(height);
        let columns = x * side..((x + 1) * side).min(width);
        let block: Vec<Rgb> = rows
            .flat_map(|row| columns.clone().map(move |column| *codes.at(column, row)))
            .collect();
        of_block(&block)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_pictures_become_smaller_and_keep_their_shape() {
        let large = Image::from_fn(3001, 2000, |x, _| Rgb::splat((x % 2) as f32));
        let small = shrunk(&large, PIXELS_MAX, mean);
        assert_eq!((small.width(), small.height()), (1001, 667));
        let flat = shrunk(&large, PIXELS_MAX, |block| block[0]);
        assert!(flat.pixels().iter().all(|p| *p == Rgb::ZERO || *p == Rgb::ONE));
        let little = Image::from_fn(100, 50, |x, y| Rgb::splat((x + y) as f32));
        assert_eq!(shrunk(&little, PIXELS_MAX, mean), little);
    }
}
