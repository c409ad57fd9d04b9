//! Whether a JPEG file has its end: the decoder fills what is missing with grey and says nothing.

const START_OF_IMAGE: u8 = 0xd8;
const END_OF_IMAGE: u8 = 0xd9;

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
