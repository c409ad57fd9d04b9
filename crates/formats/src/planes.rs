//! Pictures of whole numbers: EXR files with channels of 32-bit unsigned integers.
//!
//! For results that must come back to the bit. The channels that EXR viewers look for, R, G and B,
//! hold a picture for the eye; they are not read back. A text in the header's attribute `unrender`
//! describes the numbers.

use crate::input::{Input, Scope};
use crate::{FileError, atomic, picture};
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::prelude::*;
use std::io::Cursor;
use std::path::Path;
use unrender_scene::RgbImage;

/// The header's attribute that holds the text.
const ATTRIBUTE: &str = "unrender";
/// A header with more pixels than this is taken to be corrupt.
const MAX_PIXELS: usize = 1 << 28;
/// ZIP expands a byte of the file to at most this many.
const MAX_UNPACKING: usize = 1100;

/// Whole numbers for every pixel of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Planes {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// A description of the numbers.
    pub text: String,
    /// Named channels, each with a number for every pixel, row by row from the top left.
    pub channels: Vec<(String, Vec<u32>)>,
}

impl Planes {
    /// The numbers of the channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&[u32]> {
        self.channels.iter().find(|(n, _)| n == name).map(|(_, numbers)| numbers.as_slice())
    }
}

/// Writes `planes` and, for the eye, `picture` of the same size.
///
/// # Errors
/// If the file cannot be written.
pub fn write(
    path: &Path,
    planes: Planes,
    picture: &RgbImage,
) -> std::result::Result<(), FileError> {
    let channel = |name: &str, numbers| AnyChannel::new(name, FlatSamples::U32(numbers));
    let colour = |name: &str, index: usize| {
        let values = picture.pixels().iter().map(|rgb| rgb[index]).collect();
        AnyChannel::new(name, FlatSamples::F32(values))
    };
    let mut channels: SmallVec<_> =
        planes.channels.into_iter().map(|(name, numbers)| channel(&name, numbers)).collect();
    channels.extend(["R", "G", "B"].into_iter().enumerate().map(|(i, name)| colour(name, i)));
    let mut attributes = LayerAttributes::default();
    let text = AttributeValue::Text(planes.text.as_str().into());
    attributes.other.insert(ATTRIBUTE.into(), text);
    let size = (planes.width, planes.height);
    let channels = AnyChannels::sort(channels);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut image = Image::from_layer(layer);
    image.attributes.chromaticities = Some(picture::ColourSpace::LinRec709.chromaticities());
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| FileError::new(path, format!("cannot be encoded: {error}")))?;
    atomic::write(path, bytes.get_ref())
}

/// Reads what [`write()`] has written.
///
/// # Errors
/// If the file is missing, cut short, corrupt or of another kind.
pub fn read<'a>(input: impl Into<Input<'a>>) -> std::result::Result<Planes, FileError> {
    let input = input.into();
    let path = input.path;
    let fault = |problem: String| FileError::new(path, problem);
    let scope = Scope::new(input);
    let bytes = scope.read(path).map_err(fault)?;
    let corrupt = |error: Error| fault(picture::exr_fault(&bytes, &error));
    let meta = MetaData::read_from_buffered(Cursor::new(&bytes), true).map_err(corrupt)?;
    let foreign = || fault("is an EXR file without the sums that unrender writes".into());
    let header = meta.headers.first().ok_or_else(foreign)?;
    let Some(AttributeValue::Text(text)) = header.own_attributes.other.get(ATTRIBUTE.as_bytes())
    else {
        return Err(foreign());
    };
    let text = text.to_string();
    let Vec2(width, height) = header.layer_size;
    let unpacked = width.saturating_mul(height).saturating_mul(4 * header.channels.list.len());
    let plausible = bytes.len().saturating_mul(MAX_UNPACKING).max(64 << 20);
    if width.saturating_mul(height) > MAX_PIXELS || unpacked > plausible {
        return Err(fault(format!("claims {width} x {height} pixels, which it cannot hold")));
    }
    let block = picture::exr_block(header, bytes.len() as u64).map_err(fault)?;
    scope.charge(unpacked as u64 + 2 * block).map_err(fault)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(&bytes))
        .map_err(corrupt)?;
    let whole = |channel: AnyChannel<FlatSamples>| match channel.sample_data {
        FlatSamples::U32(numbers) => Some((channel.name.to_string(), numbers)),
        _ => None,
    };
    let channels = image.layer_data.channel_data.list.into_iter().filter_map(whole).collect();
    Ok(Planes { width, height, text, channels })
}
