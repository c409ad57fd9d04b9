//! The format of a picture, by its first bytes.

use super::tiff::Tiff;
use image::ImageFormat;

/// The format of the bytes, if it is one that is read.
pub(super) fn format_of(bytes: &[u8]) -> Option<ImageFormat> {
    if Tiff::of(bytes).is_some() {
        return Some(ImageFormat::Tiff);
    }
    let format = image::guess_format(bytes).ok()?;
    let read = [
        ImageFormat::Png,
        ImageFormat::Jpeg,
        ImageFormat::Bmp,
        ImageFormat::OpenExr,
        ImageFormat::Hdr,
    ];
    read.contains(&format).then_some(format)
}
