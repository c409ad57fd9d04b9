//! How bright a converted lobe is in its scene.
//!
//! Lobes that reflect the same share of an even light do not look alike in light that comes from
//! somewhere. What the camera sees of a group's specular reflection is
//!
//! ```text
//! ratio = sum rho_s' S' / sum rho_s S,   S = integral w L cos_i dwi,  S' = integral w' L' cos_i dwi
//! ```
//!
//! times as bright as before, over pixels that show the group. If that is further from one than
//! `TOLERANCE`, `rho_s'` gets the factor that brings it there, and no more: what the group sends
//! elsewhere was right. `L` is the light in the scene as it is and `L'` that in the
//! converted one, rendered with the nearest lobe that the renderer has; what one group sends to
//! another has changed in it, so it is looked for again a few times.

use super::TargetLobe;
use crate::evidence::spread;
use unrender_render::probe::ProposalLobe;
use unrender_render::{ProbeSettings, Probes, Tracer};
use unrender_scene::{BrdfModel, Camera, Lobe, Material, Scene, WardModel};

/// Pixels of a group.
const PIXELS: usize = 1024;
/// Directions of each kind for a pixel.
const DIRECTIONS: u32 = 24;
/// The longer side of the picture that they are taken from, pixels.
const LONGER_SIDE: usize = 384;
/// How far the mean of what the camera sees may be off, relative.
const TOLERANCE: f64 = 0.02;
/// Turns between the light and the factors.
const TURNS: usize = 4;

/// The factors of all groups, for `materials` in the place of the scene's; one for groups that have
/// not changed, or that the camera does not see.
pub(super) fn factors(
    scene: &Scene,
    camera: &Camera,
    size: (usize, usize),
    materials: &[Material],
    to: Lobe,
) -> Vec<f64> {
    let size = reduced(size);
    let original = scene.materials();
    let tracer = Tracer::new(scene);
    let pixels = pixels_of_groups(&tracer, camera, size, original.len());
    let changed = |g: &usize| materials[*g] != original[*g] && !pixels[*g].is_empty();
    let groups: Vec<usize> = (0..original.len()).filter(changed).collect();
    let mut factors = vec![1.0; original.len()];
    if groups.is_empty() {
        return factors;
    }
    let view = View { camera, size, pixels: &pixels };
    let wanted = groups.iter().map(|&g| {
        let probes = view.probe(&tracer, &original, [&original[g], &materials[g]], g);
        reflected(&probes, &original[g], Lobe::Model(scene.brdf))
    });
    let wanted: Vec<f64> = wanted.collect();
    let converted = Tracer::new(&Scene { brdf: nearest(to), ..scene.clone() });
    let mut materials = materials.to_vec();
    for _ in 0..TURNS {
        let found = groups.iter().map(|&g| {
            let probes = view.probe(&converted, &materials, [&original[g], &materials[g]], g);
            reflected(&probes, &materials[g], to)
        });
        let found: Vec<f64> = found.collect();
        for ((&g, wanted), found) in groups.iter().zip(&wanted).zip(found) {
            if *wanted > 0.0 && found > 0.0 {
                let most = 1.0 / f64::from(materials[g].rho_s.max_element());
                let ratio = found / wanted;
                let step = (ratio.clamp(1.0 - TOLERANCE, 1.0 + TOLERANCE) / ratio).min(most);
                factors[g] *= step;
                materials[g].rho_s *= step as f32;
            }
        }
    }
    factors
}

/// The lobe of the renderer's that is most like `to`.
fn nearest(to: Lobe) -> BrdfModel {
    match to {
        Lobe::Model(model) => model,
        Lobe::Beckmann => WardModel::WardGmd.into(),
    }
}

fn reduced((width, height): (usize, usize)) -> (usize, usize) {
    let scale = (LONGER_SIDE as f64 / width.max(height) as f64).min(1.0);
    let side = |n: usize| ((n as f64 * scale).round() as usize).max(1);
    (side(width), side(height))
}

/// Some pixels of each group.
fn pixels_of_groups(
    tracer: &Tracer,
    camera: &Camera,
    (width, height): (usize, usize),
    groups: usize,
) -> Vec<Vec<u32>> {
    let mut pixels = vec![Vec::new(); groups];
    for (index, pixel) in tracer.geometry(camera, width, height).pixels().iter().enumerate() {
        if let Some(list) = pixels.get_mut(pixel.group as usize) {
            list.push(index as u32);
        }
    }
    pixels.iter().map(|list| spread(list, PIXELS, 0)).collect()
}

struct View<'a> {
    camera: &'a Camera,
    size: (usize, usize),
    pixels: &'a [Vec<u32>],
}

impl View<'_> {
    /// The light at the pixels of `group`, looked for where `lobes` reflect.
    fn probe(
        &self,
        tracer: &Tracer,
        materials: &[Material],
        lobes: [&Material; 2],
        group: usize,
    ) -> Probes {
        let lobes = lobes.map(|m| ProposalLobe {
            alpha_x: m.alpha_x,
            alpha_y: m.alpha_y,
            theta_rad: m.theta_rad,
        });
        let settings = ProbeSettings {
            cosine: DIRECTIONS,
            per_lobe: DIRECTIONS,
            lobes: lobes.to_vec(),
            keep_incident: true,
            ..ProbeSettings::default()
        };
        let pixels = &self.pixels[group];
        let mut probes = tracer.probe(materials, self.camera, self.size, pixels, &settings, None);
        probes.probes.retain(|probe| probe.group as usize == group);
        probes
    }
}

/// The mean over `probes`, and over the channels, of what `material` reflects by its lobe.
fn reflected(probes: &Probes, material: &Material, lobe: Lobe) -> f64 {
    let target = TargetLobe::new(lobe, [material.alpha_x, material.alpha_y]);
    let (sin, cos) = material.theta_rad.sin_cos();
    let turn = |v: glam::Vec3| glam::Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
    let sums = probes.probes.iter().map(|probe| {
        let wo = turn(probe.wo);
        let parts = probes.incident_of(probe).iter();
        let sum: unrender_scene::Rgb =
            parts.map(|i| i.irradiance * target.value(wo, turn(i.wi))).sum();
        f64::from((material.rho_s * sum).element_sum())
    });
    sums.sum::<f64>() / probes.probes.len().max(1) as f64
}
