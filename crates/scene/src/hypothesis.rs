//! What a group's reflectance was taken to be, and where its numbers come from.
//!
//! The names are those of project and result files, so these two enums alone of this crate know
//! how to be written down.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A rung of the ladder, from simple to complex [Boivin & Gagalowicz 2002, section 4.2].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Hypothesis {
    /// Lambert's surface.
    Diffuse,
    /// Reflects all light in the mirror direction.
    Mirror,
    /// Reflects a share of the light in the mirror direction.
    PartialMirror,
    /// Lambert's surface under a perfect mirror.
    DiffuseSpecular,
    /// Ward's lobe, alike in all directions.
    Isotropic,
    /// Ward's lobe with a brushed direction.
    Anisotropic,
    /// A diffuse reflectance that changes over the surface.
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

/// Where a group's numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// From the photograph.
    Recovered,
    /// From the user.
    Known,
    /// Not determined by this photograph; a note says why.
    Assumed,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Recovered => "recovered",
            Self::Known => "known",
            Self::Assumed => "assumed",
        })
    }
}
