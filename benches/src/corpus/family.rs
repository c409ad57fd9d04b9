//! The families of scenes, the renderers that photograph them, and the choice of both by a seed.

use super::dice::Dice;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};
use unrender::scene::{BrdfModel, WardModel};

/// Whether the recovery's model can express the reflection of the scene's surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Family {
    /// Ward's and GGX's lobes with the recovery's own parameters.
    InModel,
    /// Reflectances of other models: Principled, coated plastic, conductors.
    Foreign,
}

impl Family {
    /// Its name on the command line and on the page.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::InModel => "in-model",
            Self::Foreign => "foreign",
        }
    }
}

/// The program that photographs a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Renderer {
    /// Mitsuba 3.
    Mitsuba,
    /// Blender's Cycles.
    Cycles,
    /// Radiance.
    Radiance,
}

impl Renderer {
    /// Its name on the command line and on the page.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Mitsuba => "mitsuba",
            Self::Cycles => "cycles",
            Self::Radiance => "radiance",
        }
    }

    /// The difference of a group's mean radiance, besides noise, that is allowed between its picture
    /// and ours of one scene. Meshes, lobes and lights are the same; the renderers differ in how
    /// they treat shading normals at the boundary of light and shadow. Radiance's sampling of glossy
    /// surfaces is less exact (docs/validation/exports.md).
    pub(crate) fn alike(self) -> f64 {
        match self {
            Self::Mitsuba | Self::Cycles => 0.01,
            Self::Radiance => 0.03,
        }
    }
}

/// The renderer that photographs a scene, and the lobe that is recovered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Style {
    pub(crate) family: Family,
    pub(crate) renderer: Renderer,
    /// The lobe of the in-model family; for the foreign one, the lobe that is recovered.
    pub(crate) brdf: BrdfModel,
}

/// Shares of the renderers with the lobes that they have exactly. Mitsuba's share is the largest
/// since only it has both lobes in any direction, and Radiance's the smallest since its pictures
/// take the longest.
const IN_MODEL: [((Renderer, BrdfModel), f32); 4] = [
    ((Renderer::Mitsuba, BrdfModel::Ward(WardModel::WardGmd)), 0.4),
    ((Renderer::Mitsuba, BrdfModel::Ggx), 0.2),
    ((Renderer::Cycles, BrdfModel::Ggx), 0.28),
    ((Renderer::Radiance, BrdfModel::Ward(WardModel::WardGmd)), 0.12),
];

/// As [`IN_MODEL`], for the foreign family.
const FOREIGN: [((Renderer, BrdfModel), f32); 3] = [
    ((Renderer::Mitsuba, BrdfModel::Ward(WardModel::WardGmd)), 0.3),
    ((Renderer::Mitsuba, BrdfModel::Ggx), 0.3),
    ((Renderer::Cycles, BrdfModel::Ggx), 0.4),
];

impl Style {
    /// The choice of `seed`, or the requested renderer with a lobe that it has.
    pub(crate) fn new(seed: u64, family: Family, asked: Option<Renderer>) -> Self {
        let table: &[((Renderer, BrdfModel), f32)] = match family {
            Family::InModel => &IN_MODEL,
            Family::Foreign => &FOREIGN,
        };
        let possible: Vec<_> = table
            .iter()
            .copied()
            .filter(|((renderer, _), _)| asked.is_none_or(|asked| asked == *renderer))
            .collect();
        let fallback = [table[0]];
        let possible = if possible.is_empty() { &fallback[..] } else { &possible };
        let (renderer, brdf) = Dice::new(seed, "style").weighted(possible);
        Self { family, renderer, brdf }
    }
}
