//! `materials.json`: the recovered numbers of every group and light.
//!
//! On reading, keys that are absent or null mean "as in the scene" and unknown keys are ignored,
//! so that a hand-written file with two numbers in it works. [`apply`] applies a file to a scene.

mod alternative;
mod apply;
mod light_entry;
mod photograph_entry;
mod reflectance_entry;
mod status_entry;
mod std_entry;

pub use alternative::AlternativeEntry;
pub use apply::{apply, apply_from, mean_of, read_texture, read_texture_beside};
pub use light_entry::{LightEntry, PanoramaEntry};
pub use photograph_entry::{PhotographEntry, PhotographStd};
pub use reflectance_entry::ReflectanceEntry;
pub use status_entry::StatusEntry;
pub use std_entry::StdEntry;

use crate::{FileError, Input, atomic};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::Path;
use unrender_scene::{BrdfModel, Layering, Material, Rgb};
pub use unrender_scene::{Hypothesis, Status};

/// The version of the format that this crate writes.
pub const VERSION: u32 = 1;

/// A whole `materials.json`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct MaterialsFile {
    /// [`VERSION`]; may be absent in files of other programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub version: Option<u32>,
    /// The name of the BRDF model that the numbers belong to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brdf: Option<String>,
    /// Scene radiance per unit of linear pixel value, by channel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exposure: Option<[f32; 3]>,
    /// The groups by name, in the order of the scene.
    pub groups: IndexMap<String, GroupEntry>,
    /// The lights whose brightness was recovered, by name, in the order of the scene.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub lights: IndexMap<String, LightEntry>,
    /// The photometric parameters of the camera, if they were recovered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub photograph: Option<PhotographEntry>,
    /// The photometric parameters of each of several photographs, in the order of the project.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub photographs: Vec<PhotographEntry>,
    /// How long the recovery took.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// Why the recovery ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub termination: Option<String>,
}

/// One group of a `materials.json`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct GroupEntry {
    /// The selected hypothesis.
    pub hypothesis: Option<Hypothesis>,
    /// Where the numbers come from.
    pub status: Option<StatusEntry>,
    /// Diffuse reflectance; the mean of a texture. Under a dielectric it is the base: Blender's *Base Color*.
    pub rho_d: Option<[f32; 3]>,
    /// The diffuse reflectance as lit and seen at normal incidence: `rho_d` times the share of light that a dielectric lets
    /// through. Not read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub albedo_d: Option<[f32; 3]>,
    /// Specular reflectance; of a dielectric or a metal that at normal incidence.
    pub rho_s: Option<[f32; 3]>,
    /// What `rho_s` means.
    #[serde(flatten)]
    pub reflectance: ReflectanceEntry,
    /// Roughness along the anisotropy direction.
    pub alpha_x: Option<f32>,
    /// Roughness across it.
    pub alpha_y: Option<f32>,
    /// Anisotropy direction from the surface's tangent, degrees counter-clockwise.
    pub theta_deg: Option<f32>,
    /// The anisotropy direction as a unit vector in the world.
    pub direction: Option<[f32; 3]>,
    /// The texture of `rho_d`, a path relative to the file.
    pub texture: Option<String>,
    /// Standard deviations of the numbers above.
    pub std: Option<StdEntry>,
    /// How many pixels of the photograph show the group.
    pub pixels: Option<u64>,
    /// The relative error of the re-rendering over those pixels.
    pub error: Option<f64>,
    /// A remark, such as why a number was assumed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Other materials that explain the photograph as well.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<AlternativeEntry>,
}

/// Reads a `materials.json` or a file like it.
///
/// # Errors
/// If the file is missing, is not JSON, has no groups, or a key has a value of the wrong kind.
pub fn read<'a>(input: impl Into<Input<'a>>) -> Result<MaterialsFile, FileError> {
    let input = input.into();
    let path = input.path;
    let text = crate::input::text(input).map_err(|error| FileError::because(path, "", error))?;
    let file: MaterialsFile =
        serde_json::from_str(&text).map_err(|error| FileError::because(path, "", error))?;
    if file.version.is_some_and(|version| version > VERSION) {
        let problem = format!("is of a later version than {VERSION}; use a newer unrender");
        return Err(FileError::new(path, problem));
    }
    Ok(file)
}

/// Writes `file` with the keys in a fixed order; numbers that are not finite become null.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, file: &MaterialsFile) -> Result<(), FileError> {
    let mut file = file.clone();
    file.groups.values_mut().for_each(GroupEntry::drop_not_finite);
    file.lights.values_mut().for_each(LightEntry::drop_not_finite);
    let mut text =
        serde_json::to_string_pretty(&file).map_err(|error| FileError::because(path, "", error))?;
    text.push('\n');
    atomic::write(path, text.as_bytes())
}

impl GroupEntry {
    /// The share of `rho_d` that is seen at normal incidence, under light from there: what a dielectric lets through.
    pub fn base_seen(&self) -> f32 {
        let alpha_x = self.alpha_x.or(self.alpha_y).unwrap_or(0.0);
        let mut material = Material {
            rho_s: self.rho_s.map_or(Rgb::ZERO, Rgb::from_array),
            alpha_x,
            alpha_y: self.alpha_y.unwrap_or(alpha_x),
            ..Material::diffuse(Rgb::ZERO)
        };
        let any = BrdfModel::Principled(Layering::default());
        // What is no valid reflectance is refused where the file is applied.
        let applied = self.reflectance.apply(self.rho_s.is_some(), any, &mut material);
        if applied.is_ok() { material.base_seen() } else { 1.0 }
    }

    /// The diffuse reflectance as lit and seen at normal incidence.
    pub fn seen_albedo(&self) -> Option<[f32; 3]> {
        self.albedo_d.or_else(|| self.rho_d.map(|rho| rho.map(|rho| rho * self.base_seen())))
    }

    fn drop_not_finite(&mut self) {
        drop_triple(&mut self.rho_d);
        drop_triple(&mut self.albedo_d);
        drop_triple(&mut self.rho_s);
        drop_triple(&mut self.direction);
        drop_number(&mut self.alpha_x);
        drop_number(&mut self.alpha_y);
        drop_number(&mut self.theta_deg);
        self.error = self.error.filter(|e| e.is_finite());
        self.alternatives.iter_mut().for_each(AlternativeEntry::drop_not_finite);
        if let Some(std) = &mut self.std {
            drop_triple(&mut std.rho_d);
            drop_triple(&mut std.rho_s);
            drop_number(&mut std.alpha_x);
            drop_number(&mut std.alpha_y);
            drop_number(&mut std.theta_deg);
        }
    }
}

fn drop_triple(value: &mut Option<[f32; 3]>) {
    *value = value.filter(|v| v.iter().all(|x| x.is_finite()));
}

fn drop_number(value: &mut Option<f32>) {
    *value = value.filter(|x| x.is_finite());
}
