//! The names of the free numbers of a joint refinement. What each of them is (its prior, its bounds,
//! its derivative) is in `refine/parameters`.

use serde::{Deserialize, Serialize};

/// One kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    /// Diffuse reflectance; of a texture the mean, by the light that it sends to other groups.
    RhoD,
    /// Specular reflectance.
    RhoS,
    /// Logarithm of a roughness that is the same in all directions.
    Alpha,
    /// Logarithm of the roughness along the anisotropy direction.
    AlphaX,
    /// Logarithm of the roughness across it.
    AlphaY,
    /// The anisotropy direction, radians.
    Theta,
    /// How many times as bright as in the scene a light is.
    Light,
    /// The exposure, relative to where it started.
    Exposure,
    /// A parameter of the camera, relative to its value when the photograph was developed.
    Camera,
}

impl Quantity {
    /// Whether each channel has a number of its own. (Of a light of known colour all share one.)
    pub(crate) fn has_channels(self) -> bool {
        matches!(self, Self::RhoD | Self::RhoS | Self::Light | Self::Exposure)
    }
}

/// One free number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Unknown {
    /// Its kind.
    pub quantity: Quantity,
    /// The group, the source of light or the number of the camera; zero for the exposure.
    pub of: usize,
    /// Its channel; none for numbers that all channels share.
    pub channel: Option<usize>,
}
