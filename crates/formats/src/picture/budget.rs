//! What a picture file claims, asked before its decoder allocates or works for it.

use super::read::{ALWAYS_BELIEVED_BYTES, MAX_UNPACKING};
use exr::meta::MetaData;
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

/// Progressive JPEGs have about ten scans, and none has a reason for more than one a coefficient and
/// bit, which is as many as this. Each takes a walk over all blocks.
const JPEG_SCANS: usize = 1000;

/// Refuses what the bytes of the file cannot hold.
pub(crate) fn check(bytes: &[u8], format: Option<ImageFormat>) -> Result<(), String> {
    match format {
        Some(ImageFormat::Jpeg) => jpeg(bytes),
        Some(ImageFormat::OpenExr) => exr(bytes),
        _ => Ok(()),
    }
}

pub(super) fn unbelievable(width: u64, height: u64, file_bytes: u64) -> String {
    format!("claims {width} x {height} pixels, which its {file_bytes} bytes cannot hold")
}

fn jpeg(bytes: &[u8]) -> Result<(), String> {
    // What it cannot read is told by who reads it.
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
fn exr(bytes: &[u8]) -> Result<(), String> {
    let Ok(meta) = MetaData::read_from_buffered(Cursor::new(bytes), false) else { return Ok(()) };
    let length = bytes.len() as u64;
    let believed = ALWAYS_BELIEVED_BYTES.max(length.saturating_mul(MAX_UNPACKING));
    for header in &meta.headers {
        let [width, height] = [header.layer_size.x(), header.layer_size.y()].map(|n| n as u64);
        let samples = header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample() as u64);
        let each: u64 = samples.sum();
        let unpacked = width.checked_mul(height).and_then(|n| n.checked_mul(each.max(1)));
        if unpacked.is_none_or(|unpacked| unpacked > believed) {
            return Err(unbelievable(width, height, length));
        }
    }
    Ok(())
}
