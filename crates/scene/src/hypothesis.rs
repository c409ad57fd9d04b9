//! The hypothesis of a group's reflectance, and the origin of its parameters.
//!
//! The names are those of project and result files, so these two enums are serialisable.

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
}

impl Hypothesis {
    /// All hypotheses, the simplest first.
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
