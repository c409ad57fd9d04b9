//! materials.json and the texture files that it names.

use super::around;
use crate::engine::Recovered;
use crate::{Error, Job};
use glam::Vec3;
use indexmap::IndexMap;
use std::path::Path;
use unrender_formats::materials::{
    AlternativeEntry, GroupEntry, LightEntry, MaterialsFile, StatusEntry, StdEntry, VERSION,
};
use unrender_formats::picture;
use unrender_recover::{Alternative, Deviations, GroupResult};
use unrender_scene::{Hypothesis, Image, Material, Rgb, RgbImage, Source};

/// The contents of materials.json; writes the textures beside it and counts bad values in `bad`.
pub(super) fn write_textures(
    job: &Job,
    recovered: &Recovered,
    folder: &Path,
    bad: &mut usize,
) -> Result<MaterialsFile, Error> {
    let mut file = build(job, recovered);
    let groups = recovered.recovery.groups.iter().enumerate();
    for ((index, group), entry) in groups.zip(file.groups.values_mut()) {
        entry.texture = write_texture(group, index, folder, bad)?;
    }
    Ok(file)
}

/// The contents of materials.json without the names of textures.
pub(crate) fn build(job: &Job, recovered: &Recovered) -> MaterialsFile {
    let recovery = &recovered.recovery;
    let mut file = MaterialsFile {
        version: Some(VERSION),
        brdf: Some(job.scene.brdf.name().to_owned()),
        exposure: Some(recovery.exposure.to_array()),
        photograph: recovered.photograph.clone(),
        seconds: Some((recovered.times.all * 100.0).round() / 100.0),
        termination: Some(recovery.termination.message(recovery.iterations.len())),
        ..MaterialsFile::default()
    };
    file.lights = lights(job, recovered);
    for group in &recovery.groups {
        file.groups.insert(group.name.clone(), entry(job, group));
    }
    file
}

/// The lights that were asked for, by name.
pub(super) fn lights(job: &Job, recovered: &Recovered) -> IndexMap<String, LightEntry> {
    let around = job.scene.environment_parts().start;
    let of = |source: Source<'_>| {
        if source.index == around {
            return Some((source.name.to_owned(), around::entry(job, recovered)?));
        }
        let light = recovered.recovery.lights.iter().find(|l| l.source == source.index)?;
        let entry = LightEntry {
            intensity: Some((source.strength * light.factor).to_array()),
            std: Some((source.strength * light.std).to_array()),
            panorama: None,
        };
        Some((source.name.to_owned(), entry))
    };
    job.scene.sources().filter_map(of).collect()
}

/// Where the numbers of a group come from.
pub(super) fn status(job: &Job, group: &GroupResult) -> StatusEntry {
    if let Some(other) = job.project.same_as.get(&group.name) {
        return StatusEntry::SameAs(other.clone());
    }
    let is_ignored = job.project.ignored.contains(&group.name);
    if is_ignored { StatusEntry::Ignored } else { StatusEntry::Of(group.status) }
}

fn entry(job: &Job, group: &GroupResult) -> GroupEntry {
    let material = &group.material;
    let anisotropic = group.hypothesis == Hypothesis::Anisotropic;
    GroupEntry {
        hypothesis: Some(group.hypothesis),
        status: Some(status(job, group)),
        rho_d: Some(material.rho_d.to_array()),
        rho_s: Some(material.rho_s.to_array()),
        alpha_x: Some(material.alpha_x),
        alpha_y: Some(material.alpha_y),
        theta_deg: Some(material.theta_rad.to_degrees()),
        direction: group.direction.filter(|_| anisotropic).map(|d| Vec3::to_array(&d)),
        texture: None,
        std: group.std.map(|std| std_entry(&std, material)),
        pixels: Some(group.pixels as u64),
        error: group.error,
        note: group.note.clone(),
        alternatives: group.alternatives.iter().map(alternative).collect(),
    }
}

fn alternative(alternative: &Alternative) -> AlternativeEntry {
    let material = &alternative.material;
    AlternativeEntry {
        hypothesis: Some(alternative.hypothesis),
        rho_d: Some(material.rho_d.to_array()),
        rho_s: Some(material.rho_s.to_array()),
        alpha_x: Some(material.alpha_x),
        alpha_y: Some(material.alpha_y),
        theta_deg: Some(material.theta_rad.to_degrees()),
        error: Some(alternative.error),
    }
}

/// Standard deviations in the file's units: of a roughness itself, of an angle in degrees.
fn std_entry(std: &Deviations, material: &Material) -> StdEntry {
    StdEntry {
        rho_d: std.rho_d.map(|v| v.to_array()),
        rho_s: std.rho_s.map(|v| v.to_array()),
        alpha_x: std.ln_alpha_x.map(|v| v * material.alpha_x),
        alpha_y: std.ln_alpha_y.map(|v| v * material.alpha_y),
        theta_deg: std.theta_rad.map(f32::to_degrees),
    }
}

/// Writes a group's texture as PNG and EXR and the mask of the texels that the photograph shows;
/// returns the PNG's name.
fn write_texture(
    group: &GroupResult,
    index: usize,
    folder: &Path,
    bad: &mut usize,
) -> Result<Option<String>, Error> {
    let Some(texture) = &group.material.texture else { return Ok(None) };
    let stem = format!("texture_{index}_{}", file_name(&group.name));
    let png = format!("{stem}.png");
    *bad += picture::write_png_srgb(&folder.join(&png), &texture.image)?;
    *bad += picture::write_exr(&folder.join(format!("{stem}.exr")), &texture.image)?;
    if let Some(seen) = &group.seen_texels {
        let mask = mask_picture(seen);
        *bad += picture::write_png_srgb(&folder.join(format!("{stem}_seen.png")), &mask)?;
    }
    Ok(Some(png))
}

/// White where the photograph shows the texel, black where it was filled from its neighbours.
fn mask_picture(seen: &Image<bool>) -> RgbImage {
    seen.map(|seen| if *seen { Rgb::ONE } else { Rgb::ZERO })
}

/// A group's name as part of a file name: letters and digits, the rest as underscores.
fn file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}
