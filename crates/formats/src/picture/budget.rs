//! Checks of what a picture file claims, before its decoder allocates or works for it.

use super::bmp;
use super::claims::{plausible, unbelievable};
use crate::input::Scope;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use image::ImageDecoder;
use image::ImageFormat;
use image::codecs::jpeg::JpegDecoder;
use std::io::Cursor;

/// What a PNG decoder may allocate beside the pixels, bytes: rows, colour profile and texts. A row of
/// the longest picture that is read has 2 MiB a channel; profiles have up to 4 MiB. With half of it
/// nothing changes; with double, a file of 200 kB costs half a second to be refused.
pub(super) const BESIDE_PIXELS: u64 = 64 << 20;

/// The most pixels that a byte of a JPEG stands for. Each block of 8 x 8 of some channel takes a bit
/// at least, which makes 512, and four times as many where that channel has half the resolution.
/// With half of it, such files would be refused if they are all of one colour.
const JPEG_PIXELS_A_BYTE: u64 = 2048;

/// Progressive JPEGs have about ten scans, and none needs more than one per coefficient and bit,
/// which is this many. Each takes a pass over all blocks.
const JPEG_SCANS: usize = 1000;

/// Refuses sizes that the bytes of the file cannot hold, and counts the memory of a decoder beside
/// the pixels.
pub(crate) fn check(
    scope: &Scope,
    bytes: &[u8],
    format: Option<ImageFormat>,
) -> Result<(), String> {
    match format {
        Some(ImageFormat::Jpeg) => jpeg(bytes),
        Some(ImageFormat::Bmp) => bmp::check(bytes),
        Some(ImageFormat::OpenExr) => exr(scope, bytes),
        _ => Ok(()),
    }
}

fn jpeg(bytes: &[u8]) -> Result<(), String> {
    // The reader reports what the decoder cannot read.
    let Ok(decoder) = JpegDecoder::new(Cursor::new(bytes)) else { return Ok(()) };
    let (width, height) = decoder.dimensions();
    let [width, height, length] = [width.into(), height.into(), bytes.len() as u64];
    if width * height > length.saturating_mul(JPEG_PIXELS_A_BYTE) {
        return Err(unbelievable(width, height, length));
    }
    let scans = bytes.windows(2).filter(|pair| *pair == [0xff, 0xda]).count();
    if scans > JPEG_SCANS {
        return Err(format!("is a JPEG of {scans} scans; save it again"));
    }
    Ok(())
}

/// Decoders allocate for the data window, which need not be the display window.
fn exr(scope: &Scope, bytes: &[u8]) -> Result<(), String> {
    let Ok(meta) = MetaData::read_from_buffered(Cursor::new(bytes), false) else { return Ok(()) };
    let length = bytes.len() as u64;
    let mut largest = 0;
    for header in &meta.headers {
        let [width, height] = [header.layer_size.x(), header.layer_size.y()].map(|n| n as u64);
        let unpacked = bytes_of(header, width, height);
        if unpacked.is_none_or(|unpacked| unpacked > plausible(length)) {
            return Err(unbelievable(width, height, length));
        }
        largest = largest.max(exr_block(header, length)?);
    }
    scope.charge(2 * largest)
}

/// The bytes of the largest block of an EXR, unpacked: a tile, or some scan lines. Decoders work on one
/// at a time, and allocate the same again for its packed bytes, even for small pictures.
///
/// # Errors
/// If the file cannot hold such a block.
pub(crate) fn exr_block(header: &Header, file_bytes: u64) -> Result<u64, String> {
    let (width, height) = match header.blocks {
        BlockDescription::Tiles(tiles) => (tiles.tile_size.x(), tiles.tile_size.y()),
        BlockDescription::ScanLines => {
            (header.layer_size.x(), header.compression.scan_lines_per_block())
        }
    };
    let block = bytes_of(header, width as u64, height as u64);
    block.filter(|block| *block <= plausible(file_bytes)).ok_or_else(|| {
        format!(
            "claims blocks of {width} x {height} pixels, which its {file_bytes} bytes cannot hold"
        )
    })
}

/// The unpacked bytes of `width` x `height` pixels with all channels; none if that overflows.
fn bytes_of(header: &Header, width: u64, height: u64) -> Option<u64> {
    let samples = header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample() as u64);
    let each: u64 = samples.sum();
    width.checked_mul(height).and_then(|pixels| pixels.checked_mul(each.max(1)))
}
