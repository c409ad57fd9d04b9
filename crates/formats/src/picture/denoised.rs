//! Pictures from which noise was removed: an EXR says so.
//!
//! Their pixels have errors in common with their neighbours, which nobody can see. The attribute
//! `unrenderDenoised` says it to whoever reads the file.

use super::write::write;
use crate::{FileError, atomic};
use exr::meta::attribute::AttributeValue;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
    WritableImage,
};
use std::io::Cursor;
use std::path::Path;
use unrender_scene::RgbImage;

/// The attribute that says that noise was removed.
pub(super) const ATTRIBUTE: &str = "unrenderDenoised";

/// As [`write()`] does; an EXR has the attribute `unrenderDenoised`, and whoever reads it is told. Returns how many
/// values were not finite and were written as zero.
///
/// # Errors
/// If the extension is another one or the file cannot be written.
pub fn write_denoised(path: &Path, picture: &RgbImage) -> Result<usize, FileError> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("exr")) {
        return write(path, picture);
    }
    let values = || picture.pixels().iter();
    let channel = |c: usize| {
        let samples = values().map(|v| if v[c].is_finite() { v[c] } else { 0.0 }).collect();
        AnyChannel::new(["R", "G", "B"][c], FlatSamples::F32(samples))
    };
    let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = (0..3).map(channel).collect();
    let mut attributes = LayerAttributes::default();
    attributes.other.insert(ATTRIBUTE.into(), AttributeValue::I32(1));
    let size = (picture.width(), picture.height());
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| FileError::new(path, format!("cannot be encoded: {error}")))?;
    atomic::write(path, bytes.get_ref())?;
    Ok(values().flat_map(|v| v.to_array()).filter(|v| !v.is_finite()).count())
}
