//! The evidence on one group: what the photograph shows in a sample of its pixels, and the light
//! that arrives there, gathered twice with independent noise.
//!
//! Two sets, A and B, because the noise of a rendering is not the model's fault: the product of the
//! two residuals `(B - L_A)(B - L_B)` has the mean `(B - L)^2`, without the variance of either. All
//! fits minimise that product, and no noise of ours biases them.

use crate::observation::Observation;
use crate::rerender::Renderer;
use glam::Vec3;
use rayon::prelude::*;
use unrender_render::sampler::mix;
use unrender_render::{Appearance, GlossyLobe, Probe, ProbeSettings, Probes, RadianceCache};
use unrender_scene::{BrdfModel, Material, Rgb};

/// What is known of one group in one turn.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// The lobe.
    pub model: BrdfModel,
    /// One entry a pixel of the sample.
    pub pixels: Vec<Observed>,
    /// The light at the same pixels, twice.
    pub sets: [Gathered; 2],
}

/// One pixel of the photograph.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observed {
    /// The pixel's index.
    pub pixel: u32,
    /// Its radiance.
    pub radiance: Rgb,
    /// The variance of its noise.
    pub variance: Rgb,
    /// The radiance around it, dark pixels raised to a share of the group's mean: what relative
    /// errors are relative to.
    pub level: Rgb,
    /// The weight of its residual in fits.
    pub weight: Rgb,
}

/// The light at each pixel of the sample, under one seed.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    /// One probe a pixel, and their incident samples.
    pub probes: Probes,
}

/// Where evidence comes from: the photograph, the scale of its values, and the renderer.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// The photograph, sorted by groups.
    pub observation: &'a Observation,
    /// Scene radiance per unit of the photograph's values.
    pub exposure: Rgb,
    /// The renderer, behind the photograph's camera.
    pub renderer: &'a dyn Renderer,
    /// Where the photograph itself says what radiance the surfaces send.
    pub seen: Option<&'a RadianceCache>,
}

/// How much to gather.
#[derive(Clone, Debug)]
pub struct Effort {
    /// Pixels of the group at most.
    pub pixels: usize,
    /// The rest.
    pub probe: ProbeSettings,
}

/// Residuals count relative to this share of the local radiance: it stands for what no model of a
/// real scene gets right, and keeps single bright pixels from ruling a fit.
const RELATIVE: f32 = 0.02;
/// Dark pixels count relative to this share of the group's mean.
const DARK: f32 = 0.1;

impl Evidence {
    /// Gathers the evidence on group `group` behind `pixels`, under the current `appearance`.
    pub fn gather(
        stage: &Stage<'_>,
        appearance: Appearance<'_>,
        group: usize,
        pixels: &[u32],
        effort: &Effort,
    ) -> Self {
        let Stage { observation, exposure, renderer, seen: known } = *stage;
        let wanted = spread(pixels, effort.pixels, effort.probe.seed ^ group as u64);
        let sets = [0u64, 1].map(|half| {
            let seed = mix(effort.probe.seed).wrapping_add(half);
            let settings = ProbeSettings { seed, probes_per_pixel: 1, ..effort.probe.clone() };
            renderer.probe(appearance, &wanted, &settings, known)
        });
        let seen = pixels_of_both(&sets, group as u32);
        let sets = sets.map(|probes| Gathered { probes: keep_pixels(probes, &seen, group as u32) });
        let pixels = observe(observation, exposure, group, &seen);
        Self { model: renderer.model(), pixels, sets }
    }

    /// Whether nothing was seen of the group.
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// The radiance of a white diffuse surface at every pixel, twice.
    pub fn diffuse(&self) -> [Vec<Rgb>; 2] {
        self.each(|p| p.throughput * p.diffuse)
    }

    /// The radiance of a perfect mirror at every pixel, twice.
    pub fn mirror(&self) -> [Vec<Rgb>; 2] {
        self.each(|p| p.throughput * p.mirror)
    }

    /// The radiance of the lobe with `rho_s = 1` at every pixel, twice.
    pub fn lobe(&self, alpha_x: f32, alpha_y: f32, theta_rad: f32) -> [Vec<Rgb>; 2] {
        let lobe = GlossyLobe::new(self.model, alpha_x, alpha_y);
        self.sets.each_ref().map(|set| set.lobe(&lobe, theta_rad))
    }

    /// The specular basis of `material`, twice.
    pub fn specular(&self, material: &Material) -> [Vec<Rgb>; 2] {
        if material.is_glossy() {
            self.lobe(material.alpha_x, material.alpha_y, material.theta_rad)
        } else {
            self.mirror()
        }
    }

    /// The radiance of `material` at every pixel, twice.
    pub fn radiance(&self, material: &Material) -> [Vec<Rgb>; 2] {
        let mut radiance = self.diffuse().map(|d| d.iter().map(|d| material.rho_d * *d).collect());
        if material.rho_s != Rgb::ZERO {
            let add = |(sum, s): (&mut Vec<Rgb>, Vec<Rgb>)| {
                sum.iter_mut().zip(s).for_each(|(sum, s)| *sum += material.rho_s * s);
            };
            radiance.iter_mut().zip(self.specular(material)).for_each(add);
        }
        radiance
    }

    /// The same without the pixels of the sample that are flagged.
    #[must_use]
    pub fn without(mut self, flags: &[bool]) -> Self {
        let mut kept = flags.iter().map(|flag| !flag);
        self.pixels.retain(|_| kept.next().unwrap_or(true));
        for set in &mut self.sets {
            let mut kept = flags.iter().map(|flag| !flag);
            set.probes.probes.retain(|_| kept.next().unwrap_or(true));
        }
        self
    }

    fn each(&self, f: impl Fn(&Probe) -> Rgb) -> [Vec<Rgb>; 2] {
        self.sets.each_ref().map(|set| set.probes.probes.iter().map(&f).collect())
    }
}

impl Gathered {
    /// `S` for one lobe: the sum over each probe's incident samples.
    fn lobe(&self, lobe: &GlossyLobe, theta_rad: f32) -> Vec<Rgb> {
        let (sin, cos) = theta_rad.sin_cos();
        let turn = |v: Vec3| Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z);
        let at = |probe: &Probe| {
            let wo = turn(probe.wo);
            let incident = self.probes.incident_of(probe).iter();
            let sum: Rgb = incident.map(|i| lobe.value(wo, turn(i.wi)) * i.irradiance).sum();
            probe.throughput * sum
        };
        self.probes.probes.par_iter().with_min_len(64).map(at).collect()
    }
}

/// At most `count` of `pixels`, spread evenly over the list with a jitter.
pub fn spread(pixels: &[u32], count: usize, seed: u64) -> Vec<u32> {
    if pixels.len() <= count {
        return pixels.to_vec();
    }
    let stride = pixels.len() as f64 / count as f64;
    let pick = |i: usize| {
        let jitter = (mix(seed ^ (i as u64) << 20) >> 11) as f64 / (1u64 << 53) as f64;
        pixels[(((i as f64 + jitter) * stride) as usize).min(pixels.len() - 1)]
    };
    (0..count).map(pick).collect()
}

/// The pixels in which both sets met the group, in order.
fn pixels_of_both(sets: &[Probes; 2], group: u32) -> Vec<u32> {
    let of = |probes: &Probes| -> Vec<u32> {
        probes.probes.iter().filter(|p| p.group == group).map(|p| p.pixel).collect()
    };
    let (first, second) = (of(&sets[0]), of(&sets[1]));
    let second: std::collections::HashSet<u32> = second.into_iter().collect();
    first.into_iter().filter(|p| second.contains(p)).collect()
}

fn keep_pixels(mut probes: Probes, pixels: &[u32], group: u32) -> Probes {
    let wanted: std::collections::HashSet<u32> = pixels.iter().copied().collect();
    probes.probes.retain(|p| p.group == group && wanted.contains(&p.pixel));
    probes
}

/// The photograph in some pixels of one group.
pub fn observe(
    observation: &Observation,
    exposure: Rgb,
    group: usize,
    pixels: &[u32],
) -> Vec<Observed> {
    let value = |image: &unrender_scene::RgbImage, p: u32| exposure * image.pixels()[p as usize];
    let mean = pixels.iter().map(|&p| value(&observation.smooth, p)).sum::<Rgb>()
        / pixels.len().max(1) as f32;
    let dark = Rgb::splat(DARK * mean.max_element()).max(DARK * mean);
    let one = |&pixel: &u32| {
        let variance = exposure * exposure * observation.noise_variance(group, pixel);
        let level = value(&observation.smooth, pixel).max(dark);
        let tolerance = level * RELATIVE;
        let weight = (variance + tolerance * tolerance).max(Rgb::splat(f32::MIN_POSITIVE)).recip();
        let radiance = value(&observation.picture.values, pixel);
        Observed { pixel, radiance, variance, level, weight }
    };
    pixels.iter().map(one).collect()
}
