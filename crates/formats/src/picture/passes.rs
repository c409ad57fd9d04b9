//! A picture with its passes as one EXR, for compositing programs.
//!
//! R, G and B are the picture. Every other channel has a name as Blender gives it, `ViewLayer.PASS.CHANNEL`: the
//! picture is there again, as `ViewLayer.Combined`, the contributions of lights are `ViewLayer.Combined_NAME`, and the matte by group is `ViewLayer.CryptoMaterial00` and so on.
//! Colours are in the primaries that the file declares; vectors and distances are no colours.

use super::colour_space::ColourSpace;
use super::cryptomatte::Matte;
use super::layers::{ATTRIBUTE, LightLayer, of_lights};
use super::one_layer::{self, Channel, channels};
use crate::FileError;
use exr::meta::attribute::{AttributeValue, Text};
use std::path::Path;
use unrender_scene::{Image, RgbImage};

/// What the names of all passes begin with: the name of Blender's first view layer.
const LAYER: &str = "ViewLayer.";
/// What the names of the channels of the picture begin with, as a pass: Blender offers no channels without a layer.
const COMBINED: &str = "ViewLayer.Combined.";
/// The name of the matte, without the number of its group of channels.
const MATTE: &str = "ViewLayer.CryptoMaterial";
/// What Blender's names of the contributions of groups of lights begin with.
const LIGHT: &str = "ViewLayer.Combined_";
/// By this attribute Blender recognises a file of several passes.
const OF_BLENDER: &str = "BlenderMultiChannel";

/// A pass: a quantity of all pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Its name, without a layer's.
    pub name: &'static str,
    /// Its values.
    pub values: Values,
}

/// The values of a pass.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Light or reflectance, as R, G and B, with the primaries of Rec. 709.
    Colour(RgbImage),
    /// Positions or directions, as X, Y and Z.
    Vector(RgbImage),
    /// Distances, as Z.
    Distance(Image<f32>),
}

/// A picture and its passes, all of one size.
#[derive(Clone, Debug, PartialEq)]
pub struct Passes {
    /// Radiance, W sr^-1 m^-2 per channel.
    pub picture: RgbImage,
    /// The contribution of each light.
    pub lights: Vec<LightLayer>,
    /// Other passes.
    pub others: Vec<Pass>,
    /// The groups in each pixel.
    pub groups: Matte,
}

/// Writes a picture with its passes as an EXR of 32-bit floats, the colours in `space`. Values that are not finite become
/// zero. Returns how many of the picture's values were not.
///
/// # Errors
/// If the file cannot be written.
pub fn write_passes(path: &Path, passes: &Passes, space: ColourSpace) -> Result<usize, FileError> {
    let (mut all, names) = of_lights(LIGHT, &passes.lights, space);
    let picture = space.of(&passes.picture);
    all.extend(channels(COMBINED, ["R", "G", "B"], &picture));
    all.extend(passes.others.iter().flat_map(|pass| of_pass(pass, space)));
    all.extend(passes.groups.channels(MATTE));
    one_layer::write_with(path, &picture, space, all, |_, own| {
        own.other.insert(ATTRIBUTE.into(), names);
        let version: Text = concat!("unrender ", env!("CARGO_PKG_VERSION")).into();
        own.other.insert(OF_BLENDER.into(), AttributeValue::Text(version));
        own.other.extend(passes.groups.attributes(MATTE));
    })
}

fn of_pass(pass: &Pass, space: ColourSpace) -> Vec<Channel> {
    let prefix = format!("{LAYER}{}.", pass.name);
    match &pass.values {
        Values::Colour(colour) => channels(&prefix, ["R", "G", "B"], &space.of(colour)).collect(),
        Values::Vector(vector) => channels(&prefix, ["X", "Y", "Z"], vector).collect(),
        Values::Distance(distance) => vec![(format!("{prefix}Z"), distance.pixels().to_vec())],
    }
}
