//! An EXR of one layer: channels by their names, and attributes, the same bytes for the same content.

use super::colour_space::ColourSpace;
use crate::{FileError, atomic};
use exr::meta::header::ImageAttributes;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, SmallVec,
    WritableImage,
};
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;
use unrender_scene::{Rgb, RgbImage};

/// A channel: its name, and a value for every pixel, row by row from the top left.
pub(super) type Channel = (String, Vec<f32>);

/// The three channels of `picture`: their names are those of `names` after `prefix`. Values that are not finite become
/// zero.
pub(super) fn channels(
    prefix: &str,
    names: [&str; 3],
    picture: &RgbImage,
) -> impl Iterator<Item = Channel> {
    names.map(|name| format!("{prefix}{name}")).into_iter().enumerate().map(|(c, name)| {
        let finite = |v: &Rgb| if v[c].is_finite() { v[c] } else { 0.0 };
        (name, picture.pixels().iter().map(finite).collect())
    })
}

/// Writes `picture` as R, G and B of 32-bit floats, of which the file says that they are of `space`. Values that are not
/// finite become zero; `declare` sets other attributes of picture and layer. Returns how many values were not.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn write(
    path: &Path,
    picture: &RgbImage,
    space: ColourSpace,
    declare: impl FnOnce(&mut ImageAttributes, &mut LayerAttributes),
) -> Result<usize, FileError> {
    write_with(path, picture, space, Vec::new(), declare)
}

/// As [`write()`], with these `more` channels.
///
/// # Errors
/// If the file cannot be written.
pub(super) fn write_with(
    path: &Path,
    picture: &RgbImage,
    space: ColourSpace,
    more: Vec<Channel>,
    declare: impl FnOnce(&mut ImageAttributes, &mut LayerAttributes),
) -> Result<usize, FileError> {
    let size = (picture.width(), picture.height());
    if size.0 == 0 || size.1 == 0 {
        return Err(FileError::new(path, "a picture without pixels cannot be written"));
    }
    let all = channels("", ["R", "G", "B"], picture).chain(more);
    let all: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        all.map(|(name, values)| AnyChannel::new(&*name, FlatSamples::F32(values))).collect();
    let (attributes, encoding) = (LayerAttributes::default(), Encoding::SMALL_LOSSLESS);
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(all));
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(space.chromaticities());
    declare(&mut image.attributes, &mut image.layer_data.attributes);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| FileError::new(path, format!("cannot be encoded: {error}")))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes);
    atomic::write(path, &bytes)?;
    Ok(picture.pixels().iter().flat_map(|v| v.to_array()).filter(|v| !v.is_finite()).count())
}

/// Bytes before the first attribute: the magic number and the version.
const HEAD: usize = 8;

/// Puts the attributes of the header of an EXR of one part in the order of their names: the encoder has them in a map whose
/// order is another one each time. Does nothing if this is no such file.
fn sort_attributes(file: &mut [u8]) {
    let Some(attributes) = attributes(file) else { return };
    let mut sorted: Vec<Vec<u8>> =
        attributes.iter().map(|range| file[range.clone()].to_vec()).collect();
    sorted.sort();
    let sorted = sorted.concat();
    if let Some(place) = file.get_mut(HEAD..HEAD + sorted.len()) {
        place.copy_from_slice(&sorted);
    }
}

/// Where the attributes of the header of an EXR of one part are: each is a name and a type, both with a zero behind, and
/// the length of a value before it.
fn attributes(file: &[u8]) -> Option<Vec<Range<usize>>> {
    let mut attributes = Vec::new();
    let mut start = HEAD;
    let after_zero = |from: usize| {
        let length = file.get(from..)?.iter().position(|&byte| byte == 0)?;
        from.checked_add(length)?.checked_add(1)
    };
    while *file.get(start)? != 0 {
        let value = after_zero(after_zero(start)?)?;
        let length =
            file.get(value..)?.first_chunk::<4>().map(|bytes| u32::from_le_bytes(*bytes))?;
        let end = value.checked_add(4)?.checked_add(length as usize)?;
        attributes.push(start..end);
        start = end;
    }
    Some(attributes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_have_one_order() {
        let mut file = b"headversb\0int\0\x04\0\0\0wxyza\0t\0\0\0\0\0\0rest".to_vec();
        sort_attributes(&mut file);
        assert_eq!(file, b"headversa\0t\0\0\0\0\0b\0int\0\x04\0\0\0wxyz\0rest");
        for end in 0..file.len() - 5 {
            let mut cut = file[..end].to_vec();
            sort_attributes(&mut cut);
            assert_eq!(cut, file[..end]);
        }
    }
}
