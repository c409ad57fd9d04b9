//! The fields of a BMP's header that its decoder ignores: its size in bytes, its colours, and the shape of its
//! pixels.

use super::claims::unbelievable;
use super::icc;
use super::primaries::of_primaries;
use crate::entry::{Entry, read, refused};
use unrender_scene::Profile;

const SQUARE: &str = "pixels that are not square are taken as square, with a warning";
const RUNS: Entry = refused("run lengths (RLE)", "save it as PNG");

/// What is read of BMP files.
pub(super) const SAYS: [Entry; 5] = [
    RUNS,
    refused("a JPEG or PNG within", "save it as PNG"),
    read(
        "CSType",
        "an ICC profile of primaries and curves; a warning for one of tables or in another file, and for own primaries",
    ),
    read("XPelsPerMeter", SQUARE),
    read("YPelsPerMeter", SQUARE),
];

/// Where the header begins, behind the mark and the sizes of the file.
const HEADER: usize = 14;
/// Where the offset of the rows is stored.
const ROWS: usize = 10;
/// The least length of headers that state their colours (version 4), or may hold an ICC profile (version 5).
const V4: u32 = 108;
const V5: u32 = 124;
/// The oldest header, with 16 bits for each side.
const CORE: u32 = 12;

/// Refuses sizes that the bytes of the file cannot hold, and codings that leave pixels without a
/// value.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    let short = || "is cut short: the header of the BMP is missing".to_owned();
    let length = u32_at(bytes, HEADER).ok_or_else(short)?;
    let (width, height, bits, packing) = if length == CORE {
        let side = |at| u16_at(bytes, at).map(u64::from);
        (side(18), side(20), u16_at(bytes, 24), Some(0))
    } else {
        // A height below zero counts the rows from the top.
        let side = |at| u32_at(bytes, at).map(|side| u64::from((side as i32).unsigned_abs()));
        (side(18), side(22), u16_at(bytes, 28), u32_at(bytes, 30))
    };
    let (Some(width), Some(height), Some(bits), Some(packing)) = (width, height, bits, packing)
    else {
        return Err(short());
    };
    // Run lengths may skip pixels, which then have no value.
    if matches!(packing, 1 | 2) {
        return Err(format!("is a BMP with {}, which is not read; {}", RUNS.name, RUNS.done));
    }
    // Rows are whole numbers of four bytes. Other packings are refused by the decoder.
    let row = (width * u64::from(bits)).div_ceil(32) * 4;
    let room = (bytes.len() as u64).saturating_sub(u64::from(u32_at(bytes, ROWS).unwrap_or(0)));
    if matches!(packing, 0 | 3) && row.saturating_mul(height) > room {
        return Err(unbelievable(width, height, bytes.len() as u64));
    }
    Ok(())
}

/// The colours that the header declares.
pub(super) fn profile(bytes: &[u8]) -> Option<Profile> {
    let length = u32_at(bytes, HEADER).filter(|length| *length >= V4)?;
    let space = bytes.get(HEADER + 56..HEADER + 60)?;
    match space {
        b"DEBM" if length >= V5 => {
            let at = (u32_at(bytes, HEADER + 112)? as usize).checked_add(HEADER)?;
            let end = at.checked_add(u32_at(bytes, HEADER + 116)? as usize)?;
            Some(icc::profile(bytes.get(at..end)?))
        }
        b"KNIL" => Some(of_primaries(None, "an ICC profile in another file")),
        // Many programs announce primaries of its own and then state none.
        [0, 0, 0, 0] if bytes.get(HEADER + 60..HEADER + 96)?.iter().any(|byte| *byte != 0) => {
            Some(of_primaries(None, "primaries of its own in its header"))
        }
        _ => None,
    }
}

/// How many times as wide as high the pixels are, by the resolutions of the header.
pub(super) fn pixel_aspect(bytes: &[u8]) -> Option<f64> {
    u32_at(bytes, HEADER).filter(|length| *length > CORE)?;
    let [across, down] = [u32_at(bytes, HEADER + 24)?, u32_at(bytes, HEADER + 28)?];
    Some(f64::from(down) / f64::from(across))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|four| u32::from_le_bytes(*four))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|two| u16::from_le_bytes(*two))
}
