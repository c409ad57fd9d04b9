//! The tags of TIFF that are read, and what is done with each.

use super::tiff::tag;
use crate::entry::{Entry, passed, read, refused, told};

const CHOICE: &str = "which page is the picture, and which are previews and masks";
const DEVELOPED: &str = "a raw file: it has to be developed first";

/// All of them, by their numbers. Other tags, such as those of places on the earth, are passed over.
pub(super) const TAGS: [(u16, Entry); 24] = [
    (tag::NEW_SUBFILE_TYPE, read("NewSubfileType", CHOICE)),
    (tag::SUBFILE_TYPE, read("SubfileType", CHOICE)),
    (
        tag::SUB_IFDS,
        read("SubIFDs", "a picture within that is larger: the file is refused as a raw one"),
    ),
    (tag::WIDTH, read("ImageWidth", "pixels")),
    (tag::HEIGHT, read("ImageLength", "pixels")),
    (tag::BITS, read("BitsPerSample", "8 or 16; 32 for floats")),
    (
        tag::COMPRESSION,
        read("Compression", "none, LZW, Deflate, PackBits, JPEG; those of raw files are refused"),
    ),
    (
        tag::PHOTOMETRIC,
        read(
            "PhotometricInterpretation",
            "grey and RGB; a warning for CMYK; those of raw files are refused",
        ),
    ),
    (tag::STRIPS, read("StripOffsets", "where the pixels are")),
    (tag::TILES, read("TileOffsets", "where the pixels are")),
    (tag::SAMPLES, read("SamplesPerPixel", "how many channels there are")),
    (tag::SAMPLE_FORMAT, read("SampleFormat", "whole numbers or floats")),
    (
        tag::EXTRA_SAMPLES,
        read(
            "ExtraSamples",
            "coverage: where it is zero a photograph has no measurement, with a warning",
        ),
    ),
    (tag::TRANSFER_FUNCTION, read("TransferFunction", "the curve from codes to light")),
    (tag::WHITE_POINT, read("WhitePoint", "the colours are turned into those of sRGB")),
    (tag::PRIMARIES, read("PrimaryChromaticities", "the colours are turned into those of sRGB")),
    (
        tag::X_RESOLUTION,
        read("XResolution", "pixels that are not square are taken as square, with a warning"),
    ),
    (
        tag::Y_RESOLUTION,
        read("YResolution", "pixels that are not square are taken as square, with a warning"),
    ),
    (tag::NO_DATA, told("GDAL_NODATA", "pixels of this value are no measurement")),
    (tag::MAKE, passed("Make", "names the kind of a raw file")),
    (tag::DNG_VERSION, refused("DNGVersion", DEVELOPED)),
    (tag::CFA_DIMENSIONS, refused("CFARepeatPatternDim", DEVELOPED)),
    (tag::CFA_PATTERN, refused("CFAPattern", DEVELOPED)),
    (tag::ICC_PROFILE, read("ICCProfile", "of primaries and curves; a warning for one of tables")),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tag_that_is_looked_at_has_a_row() {
        let code = include_str!("tiff.rs");
        let declared = code.lines().filter_map(|line| {
            let (name, number) =
                line.trim().strip_prefix("pub(in super::super) const ")?.split_once(": u16 = ")?;
            let number = number.trim_end_matches(';').replace('_', "");
            Some((name.to_owned(), number.parse::<u16>().unwrap()))
        });
        let mut count = 0;
        for (name, number) in declared {
            assert!(TAGS.iter().any(|(tag, _)| *tag == number), "no row of {name} ({number})");
            count += 1;
        }
        assert_eq!(count, TAGS.len());
    }
}
