//! The rungs of the ladder: what a group's reflectance might be, from simple to complex
//! [Boivin & Gagalowicz 2002, section 4.2].
//!
//! One rung is one file with one public function `fit`, which finds the parameters that explain the
//! evidence best under that hypothesis. To add a rung: write its file, name it in [`Hypothesis`] at
//! its place in the order, and send it from [`Hypothesis::fit`].

pub mod anisotropic;
pub mod brushed;
pub mod diffuse;
pub mod diffuse_specular;
pub mod isotropic;
pub mod mirror;
pub mod partial_mirror;
pub mod textured;

use crate::error::{Misfit, misfit};
use crate::evidence::Evidence;
use crate::fit::linear::{self, LinearFit, Terms};
use std::fmt;
use unrender_scene::{Material, Rgb};

/// A rung of the ladder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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
    /// The rungs without a texture, from simple to complex.
    pub const UNIFORM: [Self; 6] = [
        Self::Diffuse,
        Self::Mirror,
        Self::PartialMirror,
        Self::DiffuseSpecular,
        Self::Isotropic,
        Self::Anisotropic,
    ];

    /// The name in result files.
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

    /// Fits a uniform hypothesis to the evidence, near `start` where it has a roughness to find.
    /// The textured hypothesis needs more than a sample of pixels: see [`textured`].
    pub fn fit(self, evidence: &Evidence, start: &Material, search: Search) -> Fit {
        match self {
            Self::Diffuse | Self::Textured => diffuse::fit(evidence),
            Self::Mirror => mirror::fit(evidence),
            Self::PartialMirror => partial_mirror::fit(evidence),
            Self::DiffuseSpecular => diffuse_specular::fit(evidence),
            Self::Isotropic => isotropic::fit(evidence, start, search),
            Self::Anisotropic => anisotropic::fit(evidence, start, search),
        }
    }

    /// The simplest hypothesis that can hold `material`.
    pub fn of(material: &Material) -> Self {
        let diffuse = material.rho_d.max_element() > 0.0;
        match (material.is_delta(), material.is_glossy()) {
            _ if material.texture.is_some() => Self::Textured,
            (true, _) if diffuse => Self::DiffuseSpecular,
            (true, _) if material.rho_s == Rgb::ONE => Self::Mirror,
            (true, _) => Self::PartialMirror,
            (_, true) if material.alpha_x == material.alpha_y => Self::Isotropic,
            (_, true) => Self::Anisotropic,
            _ => Self::Diffuse,
        }
    }
}

impl fmt::Display for Hypothesis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How widely a rung with a roughness looks for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Search {
    /// Over all roughnesses and directions.
    Global,
    /// Downhill from the parameters that are known.
    Local,
}

/// A hypothesis with its best parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The rung.
    pub hypothesis: Hypothesis,
    /// Its parameters.
    pub material: Material,
    /// What they leave unexplained.
    pub misfit: Misfit,
}

/// The fit of `material`, with the bases that it was found with.
fn judged(
    hypothesis: Hypothesis,
    evidence: &Evidence,
    material: Material,
    diffuse: &[Vec<Rgb>; 2],
    specular: Option<&[Vec<Rgb>; 2]>,
) -> Fit {
    let half = |h: usize| -> Vec<Rgb> {
        let specular_at = |i: usize| specular.map_or(Rgb::ZERO, |s| s[h][i]);
        let at = |i: usize| material.rho_d * diffuse[h][i] + material.rho_s * specular_at(i);
        (0..diffuse[h].len()).map(at).collect()
    };
    let misfit = misfit(&evidence.pixels, &[half(0), half(1)]);
    Fit { hypothesis, material, misfit }
}

/// The reflectances that fit best beside a lobe of the given shape.
fn fit_lobe(
    evidence: &Evidence,
    diffuse: &[Vec<Rgb>; 2],
    alpha_x: f32,
    alpha_y: f32,
    theta_rad: f32,
) -> LinearFit {
    let specular = evidence.lobe(alpha_x, alpha_y, theta_rad);
    linear::fit(evidence, diffuse, Some(&specular), Terms::Both)
}
