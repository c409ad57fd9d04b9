//! The hypothesis of a group's reflectance, and the origin of its parameters.
//!
//! The names are those of project and result files, so these two enums are serialisable.

use crate::{Material, Reflectance};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A rung of the paper's hierarchy of BRDF models [Boivin and Gagalowicz 2002, section 4.2].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hypothesis {
    /// Lambertian.
    Diffuse,
    /// A perfect mirror of reflectance one.
    Mirror,
    /// A perfect mirror of lower reflectance.
    PartialMirror,
    /// Lambertian with a perfect mirror.
    DiffuseSpecular,
    /// Isotropic Ward.
    Isotropic,
    /// Anisotropic Ward.
    Anisotropic,
    /// A diffuse texture.
    Textured,
    /// A dielectric's lobe over a diffuse base; on the ladder an isotropic lobe.
    Plastic,
    /// A metal's lobe; on the ladder an isotropic one.
    Metal,
    /// A diffuse texture under a lobe.
    TexturedGlossy,
    /// A diffuse texture under a dielectric's lobe.
    TexturedPlastic,
}

impl Hypothesis {
    /// The rungs of the ladder, the simplest first.
    pub const ALL: [Self; 7] = [
        Self::Diffuse,
        Self::Mirror,
        Self::PartialMirror,
        Self::DiffuseSpecular,
        Self::Isotropic,
        Self::Anisotropic,
        Self::Textured,
    ];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Mirror => "mirror",
            Self::PartialMirror => "partial-mirror",
            Self::DiffuseSpecular => "diffuse-specular",
            Self::Isotropic => "isotropic",
            Self::Anisotropic => "anisotropic",
            Self::Textured => "textured",
            Self::Plastic => "plastic",
            Self::Metal => "metal",
            Self::TexturedGlossy => "textured-glossy",
            Self::TexturedPlastic => "textured-plastic",
        }
    }

    /// The rung of the ladder that it belongs to.
    pub fn of_paper(self) -> Self {
        match self {
            Self::Plastic | Self::Metal => Self::Isotropic,
            Self::TexturedGlossy | Self::TexturedPlastic => Self::Textured,
            rung => rung,
        }
    }

    /// The word for this rung where its material is `material`.
    pub fn named(self, material: &Material) -> Self {
        let is_shiny = material.rho_s.max_element() > 0.0;
        match (self, material.reflectance) {
            (Self::Textured, Reflectance::Dielectric { .. }) => Self::TexturedPlastic,
            (Self::Textured, _) if is_shiny => Self::TexturedGlossy,
            (_, Reflectance::Dielectric { .. }) => Self::Plastic,
            (_, Reflectance::Metal { .. }) => Self::Metal,
            (rung, Reflectance::Free) => rung,
        }
    }
}

impl fmt::Display for Hypothesis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl std::str::FromStr for Hypothesis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = Self::ALL.into_iter().find(|hypothesis| hypothesis.name() == text);
        named.ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("there is no hypothesis \"{text}\"; there are {names}")
        })
    }
}

/// The origin of a group's parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// Recovered from the photograph.
    Recovered,
    /// Given by the user.
    Known,
    /// Not determined by this photograph; a note says why.
    Assumed,
    /// From the photograph, but noise and model error do not explain its residual, or leave open which hypothesis it
    /// is; a note says why.
    Doubtful,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Recovered => "recovered",
            Self::Known => "known",
            Self::Assumed => "assumed",
            Self::Doubtful => "doubtful",
        })
    }
}
