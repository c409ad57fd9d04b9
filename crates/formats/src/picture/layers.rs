//! Light layers as EXR: a picture, and what each light contributes to it.
//!
//! R, G and B are the picture. Each light has three more channels, `NAME.R`, `NAME.G` and `NAME.B`: a layer in
//! the terms of EXR, which compositing programs show by name. NAME is the light's name with an underscore for
//! each character that is not an ASCII letter, digit or hyphen, and with a number where two would be the same;
//! the attribute `unrenderLayers` has the original names, a JSON array of pairs of channel prefix and name.

use super::budget;
use super::colour_space::ColourSpace;
use super::exr_refused::fault;
use super::exr_says;
use super::one_layer::{self, Channel, channels};
use crate::input::{Input, Scope};
use crate::{FileError, ascii_json};
use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, Vec2};
use std::io::Cursor;
use std::path::Path;
use unrender_scene::{Rgb, RgbImage};

/// A header with more pixels than this is taken to be corrupt.
const MAX_PIXELS: usize = 1 << 28;
/// ZIP expands a byte of the file to at most this many.
const MAX_UNPACKING: usize = 1100;

/// The contribution of one light to a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct LightLayer {
    /// The light's name.
    pub name: String,
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: RgbImage,
}

/// Writes `picture` with its `layers` of the same size as an EXR of 32-bit floats of `space`; values that are not finite
/// become zero. Returns how many of the picture's values were not.
///
/// # Errors
/// If the file cannot be written.
pub fn write_layers(
    path: &Path,
    picture: &RgbImage,
    layers: &[LightLayer],
    space: ColourSpace,
) -> Result<usize, FileError> {
    let (channels, names) = of_lights("", layers, space);
    one_layer::write_with(path, &space.of(picture), space, channels, |_, own| {
        own.other.insert(ATTRIBUTE.into(), names);
    })
}

/// The attribute that holds the names of lights.
pub(super) const ATTRIBUTE: &str = "unrenderLayers";

/// The channels of `layers`, whose names begin with `stem`, in `space`, and the value of [`ATTRIBUTE`].
pub(super) fn of_lights(
    stem: &str,
    layers: &[LightLayer],
    space: ColourSpace,
) -> (Vec<Channel>, AttributeValue) {
    let prefixes: Vec<String> =
        prefixes(layers).into_iter().map(|prefix| format!("{stem}{prefix}")).collect();
    let named = || prefixes.iter().zip(layers);
    let channel = |(prefix, layer): (&String, &LightLayer)| {
        let prefix = format!("{prefix}.");
        channels(&prefix, ["R", "G", "B"], &space.of(&layer.radiance)).collect::<Vec<_>>()
    };
    let names = named().map(|(prefix, layer)| serde_json::json!([prefix, layer.name]));
    let names = ascii_json::escaped(&serde_json::Value::from_iter(names).to_string());
    (named().flat_map(channel).collect(), AttributeValue::Text(names.as_str().into()))
}

/// The prefixes of the channels of each layer.
fn prefixes(layers: &[LightLayer]) -> Vec<String> {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    let mut taken: Vec<String> = Vec::new();
    for layer in layers {
        // EXR's names have at most 255 bytes.
        let stem: String = layer.name.chars().take(200).map(plain).collect();
        let numbered = (2..).map(|number| format!("{stem}_{number}"));
        let free = std::iter::once(stem.clone()).chain(numbered).find(|p| !taken.contains(p));
        taken.extend(free);
    }
    taken
}

/// Reads the layers that [`write_layers`] has written, with the primaries of Rec. 709.
///
/// # Errors
/// If the file is missing, cut short, corrupt or of another kind.
pub fn read_layers<'a>(input: impl Into<Input<'a>>) -> Result<Vec<LightLayer>, FileError> {
    let input = input.into();
    let path = input.path;
    let scope = Scope::new(input);
    let bytes = scope.read(path).map_err(|problem| FileError::new(path, problem))?;
    layers_of(&scope, &bytes).map_err(|problem| FileError::new(path, problem))
}

fn layers_of(scope: &Scope, bytes: &[u8]) -> Result<Vec<LightLayer>, String> {
    let corrupt = |error: exr::error::Error| fault(bytes, &error);
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(corrupt)?;
    let foreign =
        || "has no light layers; `unrender render --layers` writes a file that has".to_owned();
    let header = meta.headers.first().ok_or_else(foreign)?;
    let Some(AttributeValue::Text(text)) = header.own_attributes.other.get(ATTRIBUTE.as_bytes())
    else {
        return Err(foreign());
    };
    let names: Vec<(String, String)> = serde_json::from_str(&text.to_string())
        .map_err(|error| format!("has an attribute {ATTRIBUTE} that is not a list ({error})"))?;
    let Vec2(width, height) = header.layer_size;
    let channels = header.channels.list.len();
    let unpacked = width.saturating_mul(height).saturating_mul(4 * channels);
    let plausible = bytes.len().saturating_mul(MAX_UNPACKING).max(64 << 20);
    if width.saturating_mul(height) > MAX_PIXELS || unpacked > plausible {
        return Err(format!("claims {width} x {height} pixels, which it cannot hold"));
    }
    let block = budget::exr_block(header, bytes.len() as u64)?;
    // Memory for the channels, and for the pixels.
    scope.charge(2 * unpacked as u64 + 2 * block)?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(corrupt)?;
    let to_rec709 = exr_says::profile(header).and_then(|profile| profile.srgb_from_file);
    // Rounding must not make light negative.
    let converted = |v: Rgb| to_rec709.map_or(v, |matrix| (matrix * v).max(Rgb::ZERO));
    let list = &image.layer_data.channel_data.list;
    let of = |name: String| {
        let found = list.iter().find(|channel| channel.name.eq(name.as_str()));
        match found.map(|channel| &channel.sample_data) {
            Some(FlatSamples::F32(samples)) if samples.len() == width * height => Ok(samples),
            _ => Err(format!("has a channel {name} that is missing or is not of 32-bit floats")),
        }
    };
    let layer = |(prefix, name): (String, String)| {
        let [r, g, b] =
            [of(format!("{prefix}.R"))?, of(format!("{prefix}.G"))?, of(format!("{prefix}.B"))?];
        let pixels: Vec<Rgb> = (0..width * height).map(|i| Rgb::new(r[i], g[i], b[i])).collect();
        if pixels.iter().any(|v| !v.is_finite() || v.min_element() < 0.0) {
            return Err(format!("has light of \"{name}\" that is negative or not finite"));
        }
        let pixels = pixels.into_iter().map(converted).collect();
        Ok(LightLayer { name, radiance: RgbImage::new(width, height, pixels) })
    };
    names.into_iter().map(layer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_come_back_under_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layers.exr");
        let image =
            |value: f32| RgbImage::from_fn(3, 2, |x, y| Rgb::splat(value + (x + 3 * y) as f32));
        let layers: Vec<LightLayer> = ["Lampe à pied", "Lampe à_pied", "sky.1", "ランプ𝄞"]
            .iter()
            .enumerate()
            .map(|(i, name)| LightLayer { name: (*name).into(), radiance: image(i as f32) })
            .collect();
        let space = ColourSpace::LinRec709;
        assert_eq!(prefixes(&layers), ["Lampe___pied", "Lampe___pied_2", "sky_1", "____"]);
        assert_eq!(write_layers(&path, &image(7.0), &layers, space).unwrap(), 0);
        assert_eq!(read_layers(path.as_path()).unwrap(), layers);
        // Other programs see the picture.
        assert_eq!(super::super::read(&path).unwrap().0.to_linear(), image(7.0));
        let bytes = std::fs::read(&path).unwrap();
        for end in [0, 100, bytes.len() / 2, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..end]).unwrap();
            assert!(read_layers(path.as_path()).is_err(), "{end}");
        }
        super::super::write_exr(&path, &image(1.0)).unwrap();
        let error = read_layers(path.as_path()).unwrap_err().to_string();
        assert!(error.contains("has no light layers"), "{error}");
    }
}
