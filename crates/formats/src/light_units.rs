//! The units of a glTF file's punctual lights.
//!
//! glTF says candela and lux. Blender's exporter (io_scene_gltf2, `exp/lights.py`, Lighting Mode)
//! writes, for a point or spot light of P watts and a sun of E W/m^2:
//!
//! | mode | point and spot | sun |
//! |---|---|---|
//! | Standard, the default | `683 P/(4 pi)` cd | `683 E` lx |
//! | Unitless | `P/(4 pi)` | `E` |
//! | Raw, and all files from before version 3.4 | `P` | `E` |
//!
//! In Cycles that light has the radiant intensity `P/(4 pi)` W/sr in each channel, times its colour, a
//! spot as well as a point, and that sun the irradiance E. Emission of surfaces is always written as
//! radiance.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;
use unrender_scene::LUMENS_PER_WATT;

/// The unit of the intensity of a light in a glTF file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum LightUnits {
    /// W/sr and W/m^2, each channel on its own.
    #[default]
    Radiometric,
    /// Candela and lux by Blender's exporter: 683 times the radiometric number.
    BlenderStandard,
    /// Blender's Unitless: the radiometric number.
    Unitless,
    /// Blender's Raw: watts for point and spot lights, W/m^2 for suns.
    BlenderRaw,
}

impl LightUnits {
    /// All of them.
    pub const ALL: [Self; 4] =
        [Self::BlenderStandard, Self::Unitless, Self::BlenderRaw, Self::Radiometric];

    /// The name in projects and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radiometric => "radiometric",
            Self::BlenderStandard => "blender-standard",
            Self::Unitless => "unitless",
            Self::BlenderRaw => "blender-raw",
        }
    }

    /// The radiometric number (W/sr, or W/m^2 where the light is directional) of an intensity of one.
    pub fn radiometric(self, is_directional: bool) -> f64 {
        match self {
            Self::Radiometric | Self::Unitless => 1.0,
            Self::BlenderStandard => 1.0 / LUMENS_PER_WATT,
            Self::BlenderRaw if is_directional => 1.0,
            Self::BlenderRaw => 1.0 / (4.0 * PI),
        }
    }

    /// The radiant intensity, W/sr, of a candela of a photometric profile in a file in these units. A radiometric file
    /// has its candelas taken as they stand, as those of its other lights.
    pub fn radiometric_of_candela(self) -> f64 {
        match self {
            Self::Radiometric => 1.0,
            Self::BlenderStandard | Self::Unitless | Self::BlenderRaw => 1.0 / LUMENS_PER_WATT,
        }
    }
}

impl fmt::Display for LightUnits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for LightUnits {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|units| units.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there are no light units \"{name}\"; there are {names}")
        })
    }
}
