//! The chunks of a PNG file that its decoder does not hand on: declared colours and the shape of pixels.

use crate::entry::{Entry, read};

/// Declared colours, by the codes of ITU-T H.273.
pub(super) const CICP: Entry = read(
    "cICP",
    "the colours are turned into those of sRGB; PQ, HLG and a narrow range are refused",
);
/// How many pixels a metre has.
const PHYS: Entry = read("pHYs", "pixels that are not square are told and taken as square");

/// The chunks that are looked at, those with colours in the order in which they count.
pub(super) const CHUNKS: [Entry; 8] = [
    CICP,
    read("iCCP", "a profile of primaries and curves; one of tables is told"),
    read("sRGB", "the colours are those of sRGB, whatever gAMA and cHRM say"),
    read("gAMA", "the curve from codes to light"),
    read("cHRM", "the colours are turned into those of sRGB"),
    read("tRNS", "coverage: where it is zero a photograph has no measurement, which is told"),
    read("eXIf", "see EXIF"),
    PHYS,
];

/// The data of the first chunk of the name of `row` before the pixels.
pub(super) fn find<'a>(bytes: &'a [u8], row: &Entry) -> Option<&'a [u8]> {
    let mut rest = bytes.get(8..)?;
    loop {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (kind, data) = after.split_first_chunk::<4>()?;
        let length = usize::try_from(u32::from_be_bytes(*length)).ok()?;
        if kind == b"IDAT" {
            return None;
        }
        let (data, after) = data.split_at_checked(length)?;
        if kind == row.name.as_bytes() {
            return Some(data);
        }
        // Behind the checksum.
        rest = after.get(4..)?;
    }
}

/// How many times as wide as high the pixels are, by the chunk pHYs.
pub(super) fn pixel_aspect(bytes: &[u8]) -> Option<f64> {
    let data = find(bytes, &PHYS)?;
    let (across, rest) = data.split_first_chunk::<4>()?;
    let (down, _) = rest.split_first_chunk::<4>()?;
    Some(f64::from(u32::from_be_bytes(*down)) / f64::from(u32::from_be_bytes(*across)))
}
