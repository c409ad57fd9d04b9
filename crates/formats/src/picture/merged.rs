//! Merged brackets as EXR: linear values with their variances.
//!
//! Beside R, G and B the file has the channels `variance.R`, `variance.G` and `variance.B`: a layer in the terms
//! of EXR. A variance of -1 marks a pixel without a value. The attribute `unrenderWhiteLevel` has the values
//! from which on the channels are clipped, the greatest finite number if none is; a file without it is not one
//! of ours, whatever the names of its channels. The frames' primaries become the standard attribute
//! `chromaticities`.

use super::colour_space::ColourSpace;
use super::exr_refused::fault;
use crate::{FileError, atomic};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Chromaticities};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, ReadChannels,
    ReadLayers, SmallVec, Vec2, WritableImage,
};
use glam::{Mat3, Vec3};
use std::io::Cursor;
use std::path::Path;
use unrender_scene::{Merged, Picture, Rgb, RgbImage};

/// The attribute that holds the white level.
const WHITE_LEVEL: &str = "unrenderWhiteLevel";
/// The names of the channels of variances.
const VARIANCES: [&str; 3] = ["variance.R", "variance.G", "variance.B"];
/// The variance of a pixel without a value.
const NO_VALUE: f32 = -1.0;
/// CIE XYZ from linear sRGB [IEC 61966-2-1], by columns.
const XYZ_FROM_SRGB: [[f32; 3]; 3] =
    [[0.412_4, 0.212_6, 0.019_3], [0.357_6, 0.715_2, 0.119_2], [0.180_5, 0.072_2, 0.950_5]];

/// Writes a merged picture as an EXR of 32-bit floats, with its variances if it has them. Values that are not
/// finite become zero and are marked as missing.
///
/// # Errors
/// If the file cannot be written.
pub fn write_merged(path: &Path, picture: &Picture) -> Result<(), FileError> {
    let values = &picture.values;
    let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
    let channel = |name: &str, samples: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(samples));
    let of = |image: &RgbImage, c: usize| image.pixels().iter().map(|v| finite(v[c])).collect();
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> =
        ["R", "G", "B"].iter().enumerate().map(|(c, name)| channel(name, of(values, c))).collect();
    let mut attributes = LayerAttributes::default();
    if let Some(merged) = &picture.merged {
        for (c, name) in VARIANCES.iter().enumerate() {
            let mut variances: Vec<f32> = of(&merged.variance, c);
            let broken = values.pixels().iter().enumerate().filter(|(_, v)| !v.is_finite());
            let invalid = broken.map(|(index, _)| index).chain(picture.invalid.iter().copied());
            invalid.for_each(|index| variances[index] = NO_VALUE);
            channels.push(channel(name, variances));
        }
        let white_level = merged.white_level.min(Rgb::MAX);
        let white_level = AttributeValue::FloatVec3(white_level.into());
        attributes.other.insert(WHITE_LEVEL.into(), white_level);
    }
    let size = (values.width(), values.height());
    let channels = AnyChannels::sort(channels);
    let layer = Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut image = Image::from_layer(layer);
    let profile = picture.profile.as_ref();
    let primaries = profile.and_then(|profile| profile.srgb_from_file).map(chromaticities);
    let is_rec709 = profile.is_none_or(|profile| profile.understood);
    let rec709 = || is_rec709.then(|| ColourSpace::LinRec709.chromaticities());
    image.attributes.chromaticities = primaries.or_else(rec709);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|error| FileError::new(path, format!("cannot be encoded: {error}")))?;
    atomic::write(path, bytes.get_ref())
}

/// The primaries of a file whose linear values this matrix converts to linear sRGB.
fn chromaticities(srgb_from_file: Mat3) -> Chromaticities {
    let xyz = Mat3::from_cols_array_2d(&XYZ_FROM_SRGB) * srgb_from_file;
    let xy = |v: Vec3| Vec2(v.x / v.element_sum(), v.y / v.element_sum());
    let white = xy(xyz * Vec3::ONE);
    Chromaticities { red: xy(xyz.x_axis), green: xy(xyz.y_axis), blue: xy(xyz.z_axis), white }
}

/// Reads what [`write_merged`] wrote beside the values of the EXR in `bytes`: variances and white level, and
/// which pixels have no value. None if it is another file, an error if they are incomplete.
pub(super) fn read_merged(bytes: &[u8]) -> Result<Option<(Merged, Vec<usize>)>, String> {
    let corrupt = |error: exr::error::Error| fault(bytes, &error);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(corrupt)?;
    let Some(header) = meta.headers.first() else { return Ok(None) };
    let white_level = match header.own_attributes.other.get(WHITE_LEVEL.as_bytes()) {
        Some(AttributeValue::FloatVec3((r, g, b))) => Rgb::new(*r, *g, *b),
        _ => return Ok(None),
    };
    let unclipped = white_level.cmpge(Rgb::MAX);
    let white_level = Rgb::select(unclipped, Rgb::INFINITY, white_level);
    if white_level.cmple(Rgb::ZERO).any() || white_level.is_nan() {
        return Err(format!("has a {WHITE_LEVEL} that is not above zero"));
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(corrupt)?;
    let Vec2(width, height) = image.layer_data.size;
    let channels = &image.layer_data.channel_data.list;
    let of = |name: &str| match channels.iter().find(|c| c.name.eq(name)).map(|c| &c.sample_data) {
        Some(FlatSamples::F32(samples)) if samples.len() == width * height => Ok(samples),
        _ => Err(format!("has a channel {name} that is missing or is not of 32-bit floats")),
    };
    let [red, green, blue] = [of(VARIANCES[0])?, of(VARIANCES[1])?, of(VARIANCES[2])?];
    let mut invalid = Vec::new();
    let mut variances = Vec::with_capacity(width * height);
    for index in 0..width * height {
        let variance = Rgb::new(red[index], green[index], blue[index]);
        if variance.is_finite() && variance.cmpge(Rgb::ZERO).all() {
            variances.push(variance);
        } else {
            invalid.push(index);
            variances.push(Rgb::ZERO);
        }
    }
    let variance = RgbImage::new(width, height, variances);
    Ok(Some((Merged { variance, white_level }, invalid)))
}
