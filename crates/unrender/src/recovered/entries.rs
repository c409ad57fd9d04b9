//! The results of a recovery as the entries of materials.json.

use super::{Recovered, around};
use crate::Job;
use glam::Vec3;
use indexmap::IndexMap;
use unrender_formats::materials::{
    AlternativeEntry, GroupEntry, LightEntry, MaterialsFile, PhotographEntry, ReflectanceEntry,
    StatusEntry, StdEntry, VERSION,
};
use unrender_recover::{Alternative, Deviations, GroupResult};
use unrender_scene::{Hypothesis, Material, Source};

impl Recovered {
    /// The contents of materials.json, without the names of textures.
    pub fn materials(&self, job: &Job) -> MaterialsFile {
        build(job, self)
    }
}

fn build(job: &Job, recovered: &Recovered) -> MaterialsFile {
    let recovery = &recovered.recovery;
    let mut file = MaterialsFile {
        version: Some(VERSION),
        brdf: Some(job.scene.brdf.name().to_owned()),
        exposure: Some(recovery.exposure.to_array()),
        photograph: recovered.photographs[0].clone(),
        photographs: if job.photographs() > 1 { photographs(job, recovered) } else { Vec::new() },
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

/// The photometric parameters of each of several photographs.
fn photographs(job: &Job, recovered: &Recovered) -> Vec<PhotographEntry> {
    let one = |(k, found): (usize, &Option<PhotographEntry>)| {
        let exposure = recovered.exposure_of(job, k);
        PhotographEntry { exposure: Some(exposure.to_array()), ..found.clone().unwrap_or_default() }
    };
    recovered.photographs.iter().enumerate().map(one).collect()
}

/// The recovered lights, by name.
pub(crate) fn lights(job: &Job, recovered: &Recovered) -> IndexMap<String, LightEntry> {
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
pub(crate) fn status(job: &Job, group: &GroupResult) -> StatusEntry {
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
        hypothesis: Some(group.hypothesis.named(material)),
        status: Some(status(job, group)),
        rho_d: Some(material.rho_d.to_array()),
        albedo_d: job
            .scene
            .brdf
            .is_principled()
            .then(|| (material.rho_d * material.base_seen()).to_array()),
        rho_s: Some(material.rho_s.to_array()),
        reflectance: ReflectanceEntry::of(material),
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
        hypothesis: Some(alternative.hypothesis.named(material)),
        rho_d: Some(material.rho_d.to_array()),
        rho_s: Some(material.rho_s.to_array()),
        alpha_x: Some(material.alpha_x),
        alpha_y: Some(material.alpha_y),
        theta_deg: Some(material.theta_rad.to_degrees()),
        error: Some(alternative.error),
    }
}

/// Standard deviations in the file's units: roughness, not its logarithm, and angles in degrees.
fn std_entry(std: &Deviations, material: &Material) -> StdEntry {
    StdEntry {
        rho_d: std.rho_d.map(|v| v.to_array()),
        rho_s: std.rho_s.map(|v| v.to_array()),
        alpha_x: std.ln_alpha_x.map(|v| v * material.alpha_x),
        alpha_y: std.ln_alpha_y.map(|v| v * material.alpha_y),
        theta_deg: std.theta_rad.map(f32::to_degrees),
    }
}
