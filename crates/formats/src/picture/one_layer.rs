//! An EXR of one layer: channels by their names, and attributes.

use crate::{FileError, atomic};
use exr::meta::header::ImageAttributes;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
    WritableImage,
};
use std::io::Cursor;
use std::path::Path;
use unrender_scene::{Rgb, RgbImage};

/// Writes `pictures` of one size as channels of 32-bit floats: each as R, G and B after its prefix.
/// Values that are not finite become zero; `declare` sets the attributes of picture and layer. Returns how many values of
/// the first picture were not.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn write(
    path: &Path,
    pictures: &[(String, &RgbImage)],
    declare: impl FnOnce(&mut ImageAttributes, &mut LayerAttributes),
) -> Result<usize, FileError> {
    let Some((_, first)) = pictures.first() else { return Ok(0) };
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (prefix, picture) in pictures {
        for (c, colour) in ["R", "G", "B"].iter().enumerate() {
            let finite = |v: &Rgb| if v[c].is_finite() { v[c] } else { 0.0 };
            let samples = FlatSamples::F32(picture.pixels().iter().map(finite).collect());
            channels.push(AnyChannel::new(format!("{prefix}{colour}").as_str(), samples));
        }
    }
    let size = (first.width(), first.height());
    let (attributes, encoding) = (LayerAttributes::default(), Encoding::SMALL_LOSSLESS);
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels));
    let mut image = Image::from_layer(layer);
    declare(&mut image.attributes, &mut image.layer_data.attributes);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| FileError::new(path, format!("cannot be encoded: {error}")))?;
    atomic::write(path, bytes.get_ref())?;
    Ok(first.pixels().iter().flat_map(|v| v.to_array()).filter(|v| !v.is_finite()).count())
}
