//! What is read of pictures, as tables: kinds of files, and the data of each beside its pixels.

use super::{bmp, exif, exr_says, hdr_header, jpeg, png_chunks, raw, tiff_tags};
use crate::entry::{Entry, Table, read, refused, told};

/// The files that are read; the content decides, not the name.
const FILES: [Entry; 6] = [
    read("PNG", "8 and 16 bits; grey, palettes, coverage"),
    read("JPEG", "sequential and progressive, of 8 bits"),
    read("BMP", "whole numbers of all sizes, and palettes"),
    read("TIFF", "whole numbers of 8 and 16 bits, RGB of 32-bit floats; strips and tiles; BigTIFF"),
    read(
        "OpenEXR",
        "scanlines and tiles, several parts, layers, half and single floats and whole numbers",
    ),
    read("Radiance HDR", "red, green and blue with an exponent (RGBE)"),
];

const TIFF_KINDS: [Entry; 5] = [
    refused("floats of 16, 24 or 64 bits", "save it with 32 bits, or as an EXR"),
    refused("values of a sensor under colour filters", "a raw file: it has to be developed first"),
    refused("previews alone", "save the picture itself"),
    told("several pictures", "the first one of full size is read, and no other"),
    told("CMYK", "inks are converted to red, green and blue without a profile"),
];

/// The tables of pictures.
pub(crate) fn tables() -> Vec<Table> {
    let mut files = Table::new("Pictures: files", "kind", &FILES);
    raw::rows().iter().for_each(|row| files.add("", [row]));
    let mut tiff = Table::new("Pictures: TIFF", "tag, or kind", &TIFF_KINDS);
    tiff.add("", tiff_tags::TAGS.iter().map(|(_, row)| row));
    let mut exr = Table::new("Pictures: OpenEXR", "channel, attribute or kind", &exr_says::ROWS);
    exr.add("", &exr_says::spaces());
    vec![
        files,
        Table::new("Pictures: PNG", "chunk", &png_chunks::CHUNKS),
        Table::new("Pictures: JPEG", "kind, or segment", jpeg::rows()),
        Table::new("Pictures: BMP", "kind, or field of the header", &bmp::SAYS),
        tiff,
        exr,
        Table::new("Pictures: Radiance HDR", "line of the header", &hdr_header::LINES),
        Table::new("Pictures: EXIF", "tag", &exif::TAGS),
    ]
}
