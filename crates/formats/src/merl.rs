//! Measured BRDFs in the format of MERL's database [Matusik et al. 2003]: `.binary`.
//!
//! The file is three 32-bit little-endian whole numbers (the cells along `theta_h`, `theta_d` and `phi_d`, 90, 90 and 180
//! in the database), then the reds of all cells, the greens, the blues, as 64-bit little-endian floats. A float times
//! 1/1500 (red), 1.15/1500 (green) or 1.66/1500 (blue) is the BRDF, sr^-1. Cells that were not measured are negative. The
//! angles of the cells are those of [`unrender_scene::measured`].

use crate::entry::{Entry, Table, passed, read as row, refused};
use crate::{FileError, Input, atomic, input};
use std::path::Path;
use unrender_scene::{MeasuredBrdf, Rgb};

/// The BRDF of a number in the file, by channel, sr^-1: those of the database's own reader. Half or double of them is another
/// BRDF.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// The bytes before the numbers: three of 32 bits. The format has no other.
const HEADER: usize = 12;
/// The bytes of a cell: three channels of 64 bits. The format has no other.
const CELL: usize = 24;
/// The size of a table of the database, bytes, which a message gives: no other follows from 90 x 90 x 180 cells.
const USUAL: usize = HEADER + 90 * 90 * 180 * CELL;

/// What is read of the file.
const ROWS: [Entry; 4] = [
    row("dimensions", "any three numbers of cells that the length of the file bears out"),
    row("values", "times 1/1500, 1.15/1500 and 1.66/1500, at the centres of the cells"),
    passed("negative values", "and such as are not finite: these cells were not measured"),
    refused("other lengths", "the file is cut short or of another format"),
];

/// What is read of MERL's tables.
pub(crate) fn table() -> Table {
    Table::new("Measured BRDFs: MERL", "part", &ROWS)
}

/// Reads the table of `input`.
///
/// # Errors
/// If the file cannot be read or is no such table.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<MeasuredBrdf, FileError> {
    let input = input.into();
    let path = input.path;
    let bytes = input::read(input).map_err(|error| FileError::because(path, "", error))?;
    parse(&bytes).map_err(|problem| FileError::new(path, problem))
}

/// As [`read`], from the bytes of the file.
///
/// # Errors
/// As [`read`], in words without the file's name.
pub fn parse(bytes: &[u8]) -> Result<MeasuredBrdf, String> {
    let counts = counts(bytes)?;
    let size: usize = counts.iter().product();
    let numbers = &bytes[HEADER..];
    let channel = |cell: usize, channel: usize| {
        let at = (channel * size + cell) * size_of::<f64>();
        let bytes = numbers.get(at..at + size_of::<f64>()).and_then(|b| b.try_into().ok());
        let number = bytes.map_or(f64::NAN, f64::from_le_bytes);
        (number * SCALES[channel]) as f32
    };
    let cells = (0..size).map(|cell| Rgb::from_array([0, 1, 2].map(|c| channel(cell, c))));
    MeasuredBrdf::new(counts, cells.collect()).ok_or_else(|| "has no cells".into())
}

/// The numbers of cells, which the length of the file bears out.
fn counts(bytes: &[u8]) -> Result<[usize; 3], String> {
    let is_text =
        bytes.iter().take(HEADER).all(|byte| byte.is_ascii_graphic() || byte.is_ascii_whitespace());
    if bytes.len() < HEADER || is_text {
        return Err(format!(
            "is not a measured BRDF in MERL's binary format, which begins with three 32-bit numbers of cells; give a file \
             such as gold-metallic-paint.binary ({USUAL} bytes)"
        ));
    }
    let number = |at: usize| i32::from_le_bytes([0, 1, 2, 3].map(|byte| bytes[4 * at + byte]));
    let stated = [number(0), number(1), number(2)];
    let shown = stated.map(|n| n.to_string()).join(" x ");
    let counts = stated.map(|n| usize::try_from(n).unwrap_or(0));
    let needed = counts
        .iter()
        .try_fold(CELL, |size, count| size.checked_mul(*count))
        .and_then(|size| size.checked_add(HEADER))
        .filter(|_| counts.iter().all(|count| *count > 0));
    let Some(needed) = needed else {
        return Err(format!(
            "states {shown} cells, which no measured BRDF has (MERL's have 90 x 90 x 180); is it another format?"
        ));
    };
    if needed != bytes.len() {
        let kind = if bytes.len() < needed { "is cut short" } else { "is too long" };
        return Err(format!(
            "{kind}: {shown} cells need {needed} bytes, and it has {}; copy or download it again",
            bytes.len()
        ));
    }
    Ok(counts)
}

/// Writes `table` to `path`; cells that were not measured become -1.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, table: &MeasuredBrdf) -> Result<(), FileError> {
    atomic::write(path, &to_bytes(table))
}

/// The bytes of the file of `table`.
pub fn to_bytes(table: &MeasuredBrdf) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + CELL * table.len());
    for count in table.counts() {
        bytes.extend_from_slice(&(count as i32).to_le_bytes());
    }
    for (channel, scale) in SCALES.into_iter().enumerate() {
        for cell in 0..table.len() {
            let value = table.value(cell).map_or(-1.0, |v| f64::from(v[channel]) / scale);
            bytes.extend_from_slice(&value.to_le_bytes());
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of one value for each cell and channel, made here byte by byte.
    fn file(dims: [i32; 3], values: &[f64]) -> Vec<u8> {
        let mut bytes: Vec<u8> = dims.iter().flat_map(|n| n.to_le_bytes()).collect();
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        bytes
    }

    #[test]
    fn channels_follow_each_other_with_scales_of_their_own() {
        let values = [1500.0, 3000.0, 1500.0, -1.0, 1500.0, 750.0];
        let table = parse(&file([1, 2, 1], &values)).unwrap();
        assert_eq!(table.counts(), [1, 2, 1]);
        let first = table.value(0).unwrap();
        assert!((first - Rgb::new(1.0, 1.15, 1.66)).abs().max_element() < 1e-6, "{first}");
        assert_eq!(table.value(1), None, "a negative green was not measured");
    }

    #[test]
    fn what_is_written_reads_back() {
        let f = |wo: glam::Vec3, wi: glam::Vec3| Rgb::new(wo.z.abs(), wi.z.abs(), 0.5);
        let table = MeasuredBrdf::from_fn([4, 3, 5], f).unwrap();
        let back = parse(&to_bytes(&table)).unwrap();
        for cell in 0..table.len() {
            let (a, b) = (table.value(cell).unwrap(), back.value(cell).unwrap());
            assert!((a - b).abs().max_element() < 1e-6);
        }
    }

    #[test]
    fn cut_long_and_foreign_files_are_refused_in_words() {
        let good = file([1, 2, 1], &[1.0; 6]);
        for length in 0..good.len() {
            assert!(parse(&good[..length]).is_err(), "{length} bytes");
        }
        assert!(parse(&good[..40]).unwrap_err().contains("is cut short"));
        assert!(parse(&[good.clone(), vec![0]].concat()).unwrap_err().contains("is too long"));
        assert!(parse(b"# a text of some words").unwrap_err().contains("MERL's binary format"));
        for dims in [[0, 90, 180], [-1, 2, 1], [i32::MAX, i32::MAX, i32::MAX]] {
            assert!(parse(&file(dims, &[1.0; 6])).is_err(), "{dims:?}");
        }
        // A picture.
        assert!(parse(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").is_err());
    }
}
