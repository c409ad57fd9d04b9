//! The chunks of a PNG file that its decoder does not return: declared colours and the shape of pixels.

use crate::entry::{Entry, read};

/// Declared colours, by the codes of ITU-T H.273.
pub(super) const CICP: Entry = read(
    "cICP",
    "the colours are turned into those of sRGB; PQ, HLG and a narrow range are refused",
);
/// Pixels per metre.
const PHYS: Entry = read("pHYs", "pixels that are not square are taken as square, with a warning");

/// The chunks that are read, those with colours in their order of precedence.
pub(super) const CHUNKS: [Entry; 8] = [
    CICP,
    read("iCCP", "a profile of primaries and curves; a warning for one of tables"),
    read("sRGB", "the colours are those of sRGB, whatever gAMA and cHRM say"),
    read("gAMA", "the curve from codes to light"),
    read("cHRM", "the colours are turned into those of sRGB"),
    read("tRNS", "coverage: where it is zero a photograph has no measurement, with a warning"),
    read("eXIf", "see EXIF"),
    PHYS,
];

/// The data of the first chunk before the pixels that `row` names.
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
        // After the checksum.
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
