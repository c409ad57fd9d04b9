//! The segments of a JPEG file: whether it is complete, its kind, and the shape of its pixels.
//!
//! The decoder fills missing parts with grey, without an error.

use crate::entry::{Entry, Taken, read, refused, told};

const START_OF_IMAGE: u8 = 0xd8;
const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;
const JFIF: u8 = 0xe0;
const JPEG_LS: u8 = 0xf7;

/// True if the walk over the file's segments meets the end-of-image marker.
///
/// Segments are skipped by their stated length, so that the end of a thumbnail inside one is not
/// taken for the end of the picture.
pub(super) fn has_end(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    while let Some((marker, after)) = next_marker(rest) {
        rest = match marker {
            END_OF_IMAGE => return true,
            // Markers without a body: start of image, restarts, the reserved 01, and stuffed
            // zeros of the compressed data.
            START_OF_IMAGE | 0xd0..=0xd7 | 0x01 | 0x00 => after,
            _ => match skip_segment(after) {
                Some(body) => body,
                None => return false,
            },
        };
    }
    false
}

/// The kinds of coding, by the first and the last marker of each; other markers have arithmetic coding.
const FRAMES: [(u8, u8, Entry); 5] = [
    (0xc0, 0xc2, read("a sequential or progressive JPEG", "of 8 bits, packed by Huffman's method")),
    (0xc3, 0xc3, refused("a lossless JPEG", SAVE)),
    (0xc5, 0xc7, refused("a hierarchical JPEG", SAVE)),
    (JPEG_LS, JPEG_LS, refused("a JPEG-LS", SAVE)),
    (0xc9, 0xcf, refused("a JPEG with arithmetic coding", SAVE)),
];
const SAVE: &str = "save it as PNG or TIFF";

/// Other parts that are read.
const SEGMENTS: [Entry; 6] = [
    refused("a JPEG of 12 bits", SAVE),
    told("CMYK", "inks are converted to red, green and blue without a profile"),
    read("APP0 (JFIF)", "pixels that are not square are taken as square, with a warning"),
    read("APP1 (EXIF)", "see EXIF"),
    read("APP2 (ICC)", "a profile of primaries and curves; a warning for one of tables"),
    refused("no end of the image", "it is cut short"),
];

/// What is read of JPEG.
pub(super) fn rows() -> impl Iterator<Item = &'static Entry> {
    FRAMES.iter().map(|(_, _, row)| row).chain(&SEGMENTS)
}

/// Why a file of this kind is not read, as the end of a sentence about it: the decoder knows the sequential and the
/// progressive kind, of 8 bits, packed by Huffman's method.
pub(super) fn unread(bytes: &[u8]) -> Option<String> {
    let (frame, body) = frame(bytes)?;
    let kind = FRAMES.iter().find(|(first, last, _)| (*first..=*last).contains(&frame));
    let kind = kind.map(|(_, _, row)| row).filter(|row| row.taken == Taken::Refused);
    let bits = *body.first()?;
    let deep = (bits != 8).then(|| format!("a JPEG of {bits} bits"));
    let kind = kind.map(|row| row.name.to_owned()).or(deep)?;
    Some(format!("is {kind}, which is not read; {SAVE}"))
}

/// Whether its colours are those of four inks.
pub(super) fn has_inks(bytes: &[u8]) -> bool {
    frame(bytes).is_some_and(|(_, body)| body.get(5) == Some(&4))
}

/// The frame header: its marker, and bits, height, width and channels.
fn frame(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let is_other = |marker| [0xc4, 0xc8, 0xcc].contains(&marker);
    let is_frame = |marker| (0xc0..=0xcf).contains(&marker) && !is_other(marker);
    segment(bytes, |marker| is_frame(marker) || marker == JPEG_LS)
}

/// How many times as wide as high the pixels are, by the JFIF header.
pub(super) fn pixel_aspect(bytes: &[u8]) -> Option<f64> {
    let (_, body) = segment(bytes, |marker| marker == JFIF)?;
    let density = body.strip_prefix(b"JFIF\0")?.get(3..7)?;
    let [across, down] =
        [&density[..2], &density[2..]].map(|n| f64::from(u16::from_be_bytes([n[0], n[1]])));
    Some(down / across)
}

/// The first segment before the pixels whose marker `is_wanted`, and its body.
fn segment(bytes: &[u8], is_wanted: impl Fn(u8) -> bool) -> Option<(u8, &[u8])> {
    let mut rest = bytes;
    while let Some((marker, after)) = next_marker(rest) {
        rest = match marker {
            START_OF_SCAN | END_OF_IMAGE => return None,
            START_OF_IMAGE | 0xd0..=0xd7 | 0x01 | 0x00 => after,
            _ => {
                let behind = skip_segment(after)?;
                if is_wanted(marker) {
                    return after.get(2..after.len() - behind.len()).map(|body| (marker, body));
                }
                behind
            }
        };
    }
    None
}

/// The next byte that follows an 0xff (and is not 0xff itself), and what comes after it.
fn next_marker(bytes: &[u8]) -> Option<(u8, &[u8])> {
    let at = bytes.windows(2).position(|pair| pair[0] == 0xff && pair[1] != 0xff)?;
    Some((bytes[at + 1], &bytes[at + 2..]))
}

fn skip_segment(bytes: &[u8]) -> Option<&[u8]> {
    let length = u16::from_be_bytes([*bytes.first()?, *bytes.get(1)?]);
    bytes.get(usize::from(length)..)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_inside_a_segment_does_not_count() {
        let thumbnail = [0xff, 0xd8, 0xff, 0xe1, 0, 6, 0xff, 0xd9, 0, 0];
        assert!(!has_end(&thumbnail));
        let mut whole = thumbnail.to_vec();
        whole.extend([0xff, 0xda, 0, 3, 0, 7, 0xff, 0, 8, 0xff, 0xff, END_OF_IMAGE]);
        assert!(has_end(&whole));
        whole.pop();
        assert!(!has_end(&whole));
    }
}
