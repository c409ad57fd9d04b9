//! The brightness of a converted lobe in its scene.
//!
//! Lobes that reflect the same share of uniform light differ in directional light. The camera sees
//! a group's specular reflection
//!
//! ```text
//! ratio = sum rho_s' S' / sum rho_s S,   S = integral w L cos_i dwi,  S' = integral w' L' cos_i dwi
//! ```
//!
//! times as bright as before, over pixels that show the group. If that is further from one than
//! `TOLERANCE`, `rho_s'` gets the factor that brings it to that limit, and no more, since the light
//! in other directions was right. `L` is the light in the original scene and `L'` that in the
//! converted one, rendered with the nearest lobe that the renderer has. As the factors change the
//! light between groups, this is iterated a few times.

use super::target::TargetLobe;
use glam::Vec3;
use unrender_recover::Renderer;
use unrender_recover::observe::blocks::spread;
use unrender_render::probe::ProposalLobe;
use unrender_render::{Appearance, ProbeSettings, Probes, Query};
use unrender_scene::{Lobe, Material, Rgb};

/// Pixels of a group.
const PIXELS: usize = 1024;
/// Directions of each kind for a pixel.
const DIRECTIONS: u32 = 24;
/// The tolerated relative error of the mean that the camera sees.
const TOLERANCE: f64 = 0.02;
/// Iterations between the light and the factors.
const ITERATIONS: usize = 4;

/// The original scene, and the scene with the nearest lobe that the renderer has, both from one
/// camera.
#[derive(Clone, Copy)]
pub struct Views<'a> {
    /// With the lobe of the scene's materials.
    pub original: &'a dyn Renderer,
    /// With [`Lobe::nearest_model`] of the lobe that they are converted to.
    pub converted: &'a dyn Renderer,
}

/// The factors of all groups, for `converted` instead of `original` materials; one for groups that
/// have not changed, or that the camera does not see.
pub(super) fn factors(
    views: Views<'_>,
    original: &[Material],
    converted: &[Material],
    to: Lobe,
) -> Vec<f64> {
    let pixels = pixels_of_groups(views.original, original.len());
    let changed = |g: &usize| converted[*g] != original[*g] && !pixels[*g].is_empty();
    let groups: Vec<usize> = (0..original.len()).filter(changed).collect();
    let from = Lobe::Model(views.original.model());
    let mean = |view: &dyn Renderer, materials: &[Material], lobe: Lobe, g: usize| {
        let probes = probe(view, materials, [&original[g], &converted[g]], &pixels[g], g);
        reflected(&probes, &materials[g], lobe)
    };
    let wanted: Vec<f64> =
        groups.iter().map(|&g| mean(views.original, original, from, g)).collect();
    let mut factors = vec![1.0; original.len()];
    for _ in 0..ITERATIONS {
        let with = |(m, factor): (&Material, &f64)| Material {
            rho_s: m.rho_s * *factor as f32,
            ..m.clone()
        };
        let materials: Vec<Material> = converted.iter().zip(&factors).map(with).collect();
        for (&g, wanted) in groups.iter().zip(&wanted) {
            let found = mean(views.converted, &materials, to, g);
            if *wanted > 0.0 && found > 0.0 {
                let ratio = found / (wanted * factors[g]);
                let most = 1.0 / f64::from(converted[g].rho_s.max_element());
                factors[g] = (ratio.clamp(1.0 - TOLERANCE, 1.0 + TOLERANCE) / ratio).min(most);
            }
        }
    }
    factors
}

/// Some pixels of each group.
fn pixels_of_groups(view: &dyn Renderer, groups: usize) -> Vec<Vec<u32>> {
    let mut pixels = vec![Vec::new(); groups];
    for (index, pixel) in view.geometry().pixels().iter().enumerate() {
        if let Some(list) = pixels.get_mut(pixel.group as usize) {
            list.push(index as u32);
        }
    }
    pixels.iter().map(|list| spread(list, PIXELS, 0)).collect()
}

/// The light at `pixels` of `group`, sampled by `lobes`.
fn probe(
    view: &dyn Renderer,
    materials: &[Material],
    lobes: [&Material; 2],
    pixels: &[u32],
    group: usize,
) -> Probes {
    let settings = ProbeSettings {
        cosine: DIRECTIONS,
        per_lobe: DIRECTIONS,
        lobes: lobes.map(ProposalLobe::of).to_vec(),
        keep_incident: true,
        ..ProbeSettings::default()
    };
    let mut probes = view.probe(&Query::new(Appearance::from(materials), pixels, &settings));
    probes.probes.retain(|probe| probe.group as usize == group);
    probes
}

/// The mean over `probes` and channels of the specular reflection of `material`.
fn reflected(probes: &Probes, material: &Material, lobe: Lobe) -> f64 {
    let target = TargetLobe::new(lobe, [material.alpha_x, material.alpha_y]);
    let (sin, cos) = material.theta_rad.sin_cos();
    let turn = |v: Vec3| Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
    let sums = probes.probes.iter().map(|probe| {
        let wo = turn(probe.wo);
        let parts = probes.incident_of(probe).iter();
        let sum: Rgb = parts.map(|i| i.irradiance * target.value(wo, turn(i.wi))).sum();
        f64::from((material.rho_s * sum).element_sum())
    });
    sums.sum::<f64>() / probes.probes.len().max(1) as f64
}
