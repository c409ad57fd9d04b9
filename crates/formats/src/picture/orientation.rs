//! How the pixels that a file stores are turned to stand upright: the orientation of EXIF.

use super::hdr_resolution;
use super::kind::format_of;
use crate::{FileError, Input, input};
use glam::{DMat2, DVec2};
use image::{ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;
use unrender_scene::Image;

/// One of the eight orientations of EXIF, which Radiance pictures have as well. [`read`](super::read()) turns what it reads by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Orientation(u8);

impl Orientation {
    /// Pixels that are upright as they are stored.
    pub const UPRIGHT: Self = Self(1);

    /// The orientation of this number of EXIF, 1 to 8.
    pub fn from_exif(number: u8) -> Option<Self> {
        (1..=8).contains(&number).then_some(Self(number))
    }

    /// Its number.
    pub fn number(self) -> u8 {
        self.0
    }

    /// Whether width and height are exchanged.
    pub fn swaps_sides(self) -> bool {
        self.0 >= 5
    }

    /// Whether the upright picture is a mirror image of the stored one.
    pub fn mirrors(self) -> bool {
        matches!(self.0, 2 | 4 | 5 | 7)
    }

    /// The orientation that remains if the upright picture is mirrored once more, left to right.
    #[must_use]
    pub fn mirrored_back(self) -> Self {
        Self([0, 2, 1, 4, 3, 6, 5, 8, 7][usize::from(self.0)])
    }

    /// `stored`, turned to stand upright.
    pub(super) fn upright<T: Copy>(self, stored: &Image<T>) -> Image<T> {
        let (width, height) = (stored.width(), stored.height());
        let size = if self.swaps_sides() { (height, width) } else { (width, height) };
        Image::from_fn(size.0, size.1, |x, y| {
            // Steps from the left and the right, from the top and the bottom.
            let ([left, right], [top, bottom]) = ([x, size.0 - 1 - x], [y, size.1 - 1 - y]);
            let (column, row) = match self.0 {
                2 => (right, top),
                3 => (right, bottom),
                4 => (left, bottom),
                5 => (top, left),
                6 => (top, right),
                7 => (bottom, right),
                8 => (bottom, left),
                _ => (left, top),
            };
            *stored.at(column, row)
        })
    }

    /// The matrix that it applies to a step of pixels (right, down).
    pub fn upright_from_stored(self) -> DMat2 {
        let [right, down] = [DVec2::X, DVec2::Y];
        // What a step to the right becomes, and one downwards.
        let [x, y] = match self.0 {
            2 => [-right, down],
            3 => [-right, -down],
            4 => [right, -down],
            5 => [down, right],
            6 => [down, -right],
            7 => [-down, -right],
            8 => [-down, right],
            _ => [right, down],
        };
        DMat2::from_cols(x, y)
    }
}

/// How a file stores a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stored {
    /// How it is turned to stand upright.
    pub orientation: Orientation,
    /// Width and height before that, pixels.
    pub size: (usize, usize),
}

/// How the file of `input` stores its picture; none if it is no picture that is read.
///
/// # Errors
/// If the file cannot be read.
pub fn stored<'a>(input: impl Into<Input<'a>>) -> Result<Option<Stored>, FileError> {
    let input = input.into();
    let bytes = input::read(input).map_err(|error| FileError::because(input.path, "", error))?;
    Ok(stored_in(&bytes))
}

/// As [`stored`], from the bytes of a file.
pub fn stored_in(bytes: &[u8]) -> Option<Stored> {
    let format = format_of(bytes)?;
    if format == ImageFormat::Hdr {
        let (rows, number) = hdr_resolution::as_rows(bytes).ok()?;
        let orientation = Orientation::from_exif(number)?;
        let decoder = ImageReader::with_format(Cursor::new(rows), format).into_decoder().ok()?;
        let (width, height) = decoder.dimensions();
        return Some(Stored { orientation, size: (width as usize, height as usize) });
    }
    let mut decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().ok()?;
    let (width, height) = decoder.dimensions();
    let number = decoder.orientation().ok()?.to_exif();
    let orientation = Orientation::from_exif(number).unwrap_or(Orientation::UPRIGHT);
    Some(Stored { orientation, size: (width as usize, height as usize) })
}
