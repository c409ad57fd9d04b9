//! The evidence on one group: what the photograph shows in a sample of its pixels, and the light
//! that arrives there, gathered twice with independent noise.
//!
//! Two sets, A and B, because the noise of a rendering is not the model's fault: the product of the
//! two residuals `(B - L_A)(B - L_B)` has the mean `(B - L)^2`, without the variance of either.
//! Reflectances minimise that product, so the rendering noise does not bias them ([`crate::fit::linear`]); the shapes
//! of lobes are searched by the deviance ([`crate::compare::likelihood`]), which includes the noise.

use crate::coated::Coated;
use crate::expected::Expected;
use crate::observe::model_error::{Allowance, ModelError};
use crate::observe::sample::{Sample, Stage};
use rayon::prelude::*;
use std::collections::BTreeSet;
use unrender_render::sampler::mix;
use unrender_render::{Appearance, LobeSums, Probe, ProbeSettings, Probes, Query};
use unrender_scene::{BrdfModel, LobeAlbedo, Material, Reflectance, Rgb};

/// What is known of one group in one iteration.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// The pixels.
    pub sample: Sample,
    /// The light at the same pixels.
    pub light: Light,
    /// How much model error is always allowed for.
    pub allowance: Allowance,
    /// The least noise of every block for all candidates, where it is known.
    pub least_noise: Option<Vec<Rgb>>,
    /// Bounds and starting values of the group's numbers.
    pub expected: Expected,
    /// The group if nothing but its colour is known, black.
    pub plain: Material,
}

/// The light at some pixels of one group, twice with independent noise.
#[derive(Clone, Debug)]
pub struct Light {
    /// The lobe.
    pub model: BrdfModel,
    /// Both sets.
    pub sets: [Gathered; 2],
}

/// The light at each pixel of the sample, under one seed.
#[derive(Clone, Debug, Default)]
pub struct Gathered {
    /// The probes of all pixels, in the order of the pixels.
    pub probes: Vec<Probe>,
    /// The index of the first probe of every pixel, and the number of all probes.
    pub starts: Vec<u32>,
    /// Their incident samples, prepared for lobes; none where none were kept.
    lobes: Option<LobeSums>,
    /// The same for plastics; none where the scene's model has none.
    coated: Option<Coated>,
}

/// How much to gather.
#[derive(Clone, Debug)]
pub struct SampleBudget {
    /// Pixels of the group at most.
    pub pixels: usize,
    /// The seed of their choice; the same seed chooses the same pixels.
    pub pixels_seed: u64,
    /// How well the light can be known at this budget.
    pub allowance: Allowance,
    /// The rest.
    pub probe: ProbeSettings,
}

impl Evidence {
    /// Gathers the evidence on group `group` behind `pixels`, under the current `appearance`.
    pub fn gather(
        stage: &Stage<'_>,
        appearance: Appearance<'_>,
        group: usize,
        pixels: &[u32],
        budget: &SampleBudget,
    ) -> Self {
        let (wanted, grid) =
            Sample::choose(stage.observation, group, pixels, budget.pixels, budget.pixels_seed);
        let (light, seen) = Light::gather(stage, appearance, group, &wanted, &budget.probe);
        let allowance = budget.allowance;
        let sample = Sample::of(stage, group, (&seen, &grid), allowance.light);
        let (least_noise, expected) = (None, Expected::default());
        let plain = Material::diffuse(Rgb::ZERO);
        Self { sample, light, allowance, least_noise, expected, plain }
    }

    /// The same for a group of which something is `expected`.
    #[must_use]
    pub fn expecting(self, expected: Expected) -> Self {
        Self { expected, ..self }
    }

    /// The same for a group that is like `plain` if nothing but its colour is known.
    pub(crate) fn beside(self, plain: Material) -> Self {
        Self { plain, ..self }
    }

    /// Weights every residual by the inverse of its variance, with `material` as the model whose light says how bright each
    /// pixel is, and `error` the group's model error.
    pub fn reweigh(&mut self, material: &Material, error: ModelError) {
        let light = self.light.mean_radiance(material);
        self.sample.reweigh(&light, error);
    }

    /// Whether nothing was seen of the group.
    pub fn is_empty(&self) -> bool {
        self.sample.pixels.is_empty()
    }

    /// A third of the pixels of a large sample, for searches whose last steps see all of them.
    #[must_use]
    pub fn thinned(&self) -> Self {
        /// Samples of fewer pixels are kept whole. Half and double of it were not tried.
        const ENOUGH: usize = 1500;
        if self.sample.pixels.len() < ENOUGH {
            return self.clone();
        }
        let flags: Vec<bool> = (0..self.sample.pixels.len()).map(|i| i % 3 != 0).collect();
        self.clone().without(&flags)
    }

    /// The same without the pixels of the sample that are flagged.
    #[must_use]
    pub fn without(mut self, flags: &[bool]) -> Self {
        self.sample = self.sample.without(flags);
        self.light.sets.iter_mut().for_each(|set| set.remove(flags));
        self.least_noise = None;
        self
    }
}

impl Light {
    /// The light behind those of `pixels` in which both sets meet `group`, under the current `appearance`; and these pixels.
    pub fn gather(
        stage: &Stage<'_>,
        appearance: Appearance<'_>,
        group: usize,
        pixels: &[u32],
        probe: &ProbeSettings,
    ) -> (Self, Vec<u32>) {
        let sets = [0u64, 1].map(|half| {
            let seed = mix(probe.seed).wrapping_add(half);
            let settings = ProbeSettings { seed, ..probe.clone() };
            let query = Query { seen: stage.seen, ..Query::new(appearance, pixels, &settings) };
            stage.renderer.probe(&query)
        });
        let seen = pixels_of_both(&sets, group as u32);
        let model = stage.renderer.model();
        let sets = sets.map(|probes| Gathered::of(model, probes, &seen, group as u32));
        (Self { model, sets }, seen)
    }

    /// The mean of the two renderings of `material` at every pixel.
    pub fn mean_radiance(&self, material: &Material) -> Vec<Rgb> {
        let [a, b] = self.radiance(material);
        a.iter().zip(&b).map(|(a, b)| 0.5 * (*a + *b)).collect()
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
        self.sets.each_ref().map(|set| set.lobe([alpha_x, alpha_y, theta_rad]))
    }

    /// The radiance of `material` with a white base and without its lobe at every pixel, twice.
    pub fn base(&self, material: &Material) -> [Vec<Rgb>; 2] {
        self.base_under(material, |probe| probe.diffuse)
    }

    /// The part of [`Self::base`] that comes straight from lights.
    pub fn straight(&self, material: &Material) -> [Vec<Rgb>; 2] {
        self.base_under(material, |probe| probe.straight)
    }

    /// The radiance of a white base under the lobe of `material` in the `light` of every probe, twice.
    fn base_under(
        &self,
        material: &Material,
        light: impl Fn(&Probe) -> Rgb + Sync,
    ) -> [Vec<Rgb>; 2] {
        let Reflectance::Dielectric { ior, layering } = material.reflectance else {
            return self.each(|probe| probe.throughput * light(probe));
        };
        let alpha = (material.alpha_x * material.alpha_y).sqrt();
        let taken = LobeAlbedo::over(layering, ior, alpha);
        self.sets.each_ref().map(|set| set.base((alpha, &taken), &light))
    }

    /// The specular basis of `material`, twice: what its `rho_s` is the factor of.
    pub fn specular(&self, material: &Material) -> [Vec<Rgb>; 2] {
        let shape = [material.alpha_x, material.alpha_y, material.theta_rad];
        if let (Reflectance::Dielectric { .. }, true) = (material.reflectance, material.is_glossy())
        {
            return self.sets.each_ref().map(|set| set.coat(shape));
        }
        if material.is_glossy() {
            self.lobe(material.alpha_x, material.alpha_y, material.theta_rad)
        } else {
            self.mirror()
        }
    }

    /// The radiance of `material` at every pixel, twice.
    pub fn radiance(&self, material: &Material) -> [Vec<Rgb>; 2] {
        let mut radiance =
            self.base(material).map(|d| d.iter().map(|d| material.rho_d * *d).collect());
        if material.rho_s != Rgb::ZERO {
            let add = |(sum, s): (&mut Vec<Rgb>, Vec<Rgb>)| {
                sum.iter_mut().zip(s).for_each(|(sum, s)| *sum += material.rho_s * s);
            };
            radiance.iter_mut().zip(self.specular(material)).for_each(add);
        }
        radiance
    }

    fn each(&self, f: impl Fn(&Probe) -> Rgb + Sync) -> [Vec<Rgb>; 2] {
        self.sets.each_ref().map(|set| set.means(&f))
    }
}

impl Gathered {
    /// Those of `probes` behind `pixels` that lie on `group`.
    fn of(model: BrdfModel, mut probes: Probes, pixels: &[u32], group: u32) -> Self {
        let wanted: std::collections::HashSet<u32> = pixels.iter().copied().collect();
        probes.probes.retain(|p| p.group == group && wanted.contains(&p.pixel));
        Self::new(model, probes)
    }

    /// `probes`, in the order of their pixels, for lobes of `model`.
    pub fn new(model: BrdfModel, probes: Probes) -> Self {
        let lobes = (!probes.incident.is_empty()).then(|| LobeSums::new(model, &probes));
        let coated = Coated::of(model, &probes);
        Self { starts: starts(&probes.probes), probes: probes.probes, lobes, coated }
    }

    /// The probes of every pixel.
    fn of_pixels(&self) -> impl IndexedParallelIterator<Item = &[Probe]> {
        let ends = self.starts.par_windows(2);
        ends.map(|ends| &self.probes[ends[0] as usize..ends[1] as usize])
    }

    /// The first probe of every pixel.
    pub fn first(&self) -> impl Iterator<Item = &Probe> {
        let pixels = self.starts.len().saturating_sub(1);
        self.starts[..pixels].iter().map(|start| &self.probes[*start as usize])
    }

    /// The mean of `f` over the probes of every pixel.
    fn means(&self, f: &(impl Fn(&Probe) -> Rgb + Sync)) -> Vec<Rgb> {
        let mean = |probes: &[Probe]| probes.iter().map(f).sum::<Rgb>() / probes.len() as f32;
        self.of_pixels().with_min_len(64).map(mean).collect()
    }

    /// Removes the pixels that are flagged.
    fn remove(&mut self, flags: &[bool]) {
        let ends = self.starts.windows(2);
        let counts = ends.zip(flags).flat_map(|(e, flag)| (e[0]..e[1]).map(move |_| !flag));
        let kept = counts.collect::<Vec<bool>>();
        let mut next = kept.iter().copied();
        self.probes.retain(|_| next.next().unwrap_or(true));
        let mut next = kept.iter().copied();
        let lobes = self.lobes.iter_mut();
        lobes.for_each(|lobes| lobes.retain(|| next.next().unwrap_or(true)));
        self.coated.iter_mut().for_each(|coated| coated.retain(&kept));
        self.starts = starts(&self.probes);
    }

    /// `S` for one lobe of the shape `[alpha_x, alpha_y, theta]`: the mean over each pixel's probes.
    fn lobe(&self, shape: [f32; 3]) -> Vec<Rgb> {
        self.sums(self.lobes.as_ref(), shape)
    }

    /// The same of a dielectric's lobe, over its reflectance at normal incidence.
    fn coat(&self, shape: [f32; 3]) -> Vec<Rgb> {
        self.sums(self.coated.as_ref().map(|coated| &coated.lobes), shape)
    }

    fn sums(&self, lobes: Option<&LobeSums>, shape: [f32; 3]) -> Vec<Rgb> {
        let Some(lobes) = lobes else {
            return vec![Rgb::ZERO; self.starts.len().saturating_sub(1)];
        };
        self.numbered(|i| self.probes[i].throughput * lobes.of(i, shape))
    }

    /// `D`, or its part in this `light`, under the lobe of a dielectric of this `albedo`.
    fn base(
        &self,
        (alpha, taken): (f32, &LobeAlbedo),
        light: &(impl Fn(&Probe) -> Rgb + Sync),
    ) -> Vec<Rgb> {
        self.numbered(|i| {
            let probe = &self.probes[i];
            let share = match &self.coated {
                Some(coated) => coated.base(i, probe, alpha, taken),
                None => 1.0 - taken.at(probe.wo.z),
            };
            share * probe.throughput * light(probe)
        })
    }

    /// The mean of `f`, which takes the number of a probe, over the probes of every pixel.
    fn numbered(&self, f: impl Fn(usize) -> Rgb + Sync) -> Vec<Rgb> {
        let mean = |ends: &[u32]| {
            let probes = ends[0] as usize..ends[1] as usize;
            let count = probes.len() as f32;
            probes.map(&f).sum::<Rgb>() / count
        };
        self.starts.par_windows(2).with_min_len(64).map(mean).collect()
    }
}

/// The index of the first probe of every pixel, and the number of all probes.
fn starts(probes: &[Probe]) -> Vec<u32> {
    let begins = |i: &usize| *i == 0 || probes[*i].pixel != probes[*i - 1].pixel;
    let begins = (0..probes.len()).filter(begins);
    begins.chain([probes.len()]).map(|i| i as u32).collect()
}

/// The pixels in which both sets met the group, in order.
fn pixels_of_both(sets: &[Probes; 2], group: u32) -> Vec<u32> {
    let of = |probes: &Probes| -> BTreeSet<u32> {
        probes.probes.iter().filter(|p| p.group == group).map(|p| p.pixel).collect()
    };
    of(&sets[0]).intersection(&of(&sets[1])).copied().collect()
}

#[cfg(test)]
impl Evidence {
    /// A square of `side` pixels, each lit from the same `lights` and seen from its `wo`, in a scene of `model`; it shows
    /// nothing yet. The light is without noise and may be wrong by a percent.
    pub(crate) fn square(
        model: BrdfModel,
        side: usize,
        lights: &[unrender_render::Incident],
        wo: impl Fn(usize) -> glam::Vec3,
    ) -> Self {
        let irradiance: Rgb = lights.iter().map(|light| light.irradiance).sum();
        let probe = |i: usize| Probe {
            pixel: i as u32,
            group: 0,
            throughput: Rgb::ONE,
            wo: wo(i),
            point: glam::Vec3::ZERO,
            emitted: Rgb::ZERO,
            diffuse: irradiance * std::f32::consts::FRAC_1_PI,
            straight: irradiance * std::f32::consts::FRAC_1_PI,
            mirror: Rgb::ZERO,
            mirrored: None,
            first: (i * lights.len()) as u32,
            count: lights.len() as u32,
        };
        let probes = (0..side * side).map(probe).collect();
        let incident = (0..side * side).flat_map(|_| lights.iter().copied()).collect();
        let set = Gathered::new(model, Probes { probes, incident });
        let sample = Sample::square(side, 3, |_| Rgb::ZERO);
        let allowance = Allowance { light: sample.field.least, floor: ModelError { share: 0.003 } };
        let light = Light { model, sets: [set.clone(), set] };
        let plain = Material::diffuse(Rgb::ZERO);
        let (least_noise, expected) = (None, Expected::default());
        Self { sample, light, allowance, least_noise, expected, plain }
    }

    /// A square of `side` pixels under 25 lamps in one direction of the sky, with what a white base reflects of them.
    pub(crate) fn under_lamps(side: usize) -> (Self, Rgb) {
        let lamp = |i: usize| {
            let (a, b) = ((i % 5) as f32 - 2.0, (i / 5) as f32 - 2.0);
            let wi = glam::Vec3::new(0.3 * a, 0.3 * b - 0.3, 1.0).normalize();
            unrender_render::Incident { wi, irradiance: Rgb::splat(0.2 * wi.z) }
        };
        let lamps: Vec<_> = (0..25).map(lamp).collect();
        let lit: Rgb = lamps.iter().map(|lamp| lamp.irradiance).sum();
        let wo = |i: usize| glam::Vec3::new(0.0, i as f32 / 300.0, 1.0).normalize();
        let evidence = Self::square(BrdfModel::default(), side, &lamps, wo);
        (evidence, lit * std::f32::consts::FRAC_1_PI)
    }

    /// The same with these values shown.
    pub(crate) fn showing(mut self, values: Vec<Rgb>) -> Self {
        let pixels = self.sample.pixels.iter_mut().zip(values);
        pixels.for_each(|(pixel, value)| pixel.radiance = value);
        self
    }
}
