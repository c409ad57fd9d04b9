//! The header of a Radiance picture: the factor by which its values were multiplied, primaries, the shape of
//! pixels.
//!
//! Lines that begin with a blank belong to the pictures that this one was made from, as Radiance's programs
//! write them, and do not apply to this one.

use super::primaries::Corners;
use crate::entry::{Entry, find, passed, read as read_row};

/// The lines that are read.
pub(super) const LINES: [Entry; 6] = [
    read_row("EXPOSURE", "the values are divided by it, and by those of all lines before"),
    read_row("COLORCORR", "the same for each channel"),
    read_row("PRIMARIES", "the colours are turned into those of sRGB"),
    read_row("PIXASPECT", "pixels that are not square are taken as square, with a warning"),
    read_row("FORMAT", "RGBE; CIE XYZ (32-bit_rle_xyze) is refused"),
    passed("others", "such as lines that begin with a blank, which belong to earlier pictures"),
];

/// What the header says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    /// The factor by which the values of each channel were multiplied: the product of all lines EXPOSURE=
    /// and COLORCORR=.
    pub factor: [f32; 3],
    /// Primaries and white.
    pub primaries: Option<Corners>,
    /// How many times as high as wide the pixels are: the product of all lines PIXASPECT=.
    pub height_of_pixels: f64,
}

/// Reads the header at the beginning of `bytes`.
///
/// # Errors
/// If a line is not valid, as the end of a sentence about the file.
pub(crate) fn read(bytes: &[u8]) -> Result<Header, String> {
    let mut header = Header { factor: [1.0; 3], primaries: None, height_of_pixels: 1.0 };
    for line in bytes.split(|byte| *byte == b'\n').take_while(|line| !line.is_empty()) {
        let line = String::from_utf8_lossy(line);
        let Some((key, value)) = line.split_once('=') else { continue };
        match find(&LINES, key.trim_end()).map_or("", |line| line.name) {
            "EXPOSURE" => {
                let [factor] = positive(key, value)?;
                header.factor = header.factor.map(|f| f * factor);
            }
            "COLORCORR" => {
                let factors: [f32; 3] = positive(key, value)?;
                (0..3).for_each(|c| header.factor[c] *= factors[c]);
            }
            "PIXASPECT" => {
                let [aspect] = positive(key, value)?;
                header.height_of_pixels *= f64::from(aspect);
            }
            "PRIMARIES" => {
                let xy: [f32; 8] = numbers(key, value)?;
                header.primaries = Some([0, 1, 2, 3].map(|k| [xy[2 * k], xy[2 * k + 1]]));
            }
            "FORMAT" if value.trim() == "32-bit_rle_xyze" => {
                return Err(
                    "holds CIE XYZ (32-bit_rle_xyze); convert it to RGB by ra_xyze -r".into()
                );
            }
            _ => {}
        }
    }
    let is_usable = |factor: f32| factor.is_finite() && factor > 0.0;
    if !header.factor.into_iter().all(is_usable) {
        return Err(
            "has lines EXPOSURE= or COLORCORR= whose product is no number above zero".into()
        );
    }
    Ok(header)
}

fn numbers<const N: usize>(key: &str, value: &str) -> Result<[f32; N], String> {
    let parsed: Result<Vec<f32>, _> = value.split_whitespace().map(str::parse).collect();
    let wrong = || format!("has a line {}={value} that has no {N} number(s)", key.trim_end());
    let numbers: [f32; N] = parsed.ok().and_then(|n| n.try_into().ok()).ok_or_else(wrong)?;
    if numbers.iter().all(|n| n.is_finite()) { Ok(numbers) } else { Err(wrong()) }
}

fn positive<const N: usize>(key: &str, value: &str) -> Result<[f32; N], String> {
    let numbers = numbers(key, value)?;
    if numbers.iter().all(|n: &f32| *n > 0.0) {
        return Ok(numbers);
    }
    Err(format!("has a line {}={value} that is not above zero", key.trim_end()))
}
