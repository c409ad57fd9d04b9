//! The tape: records one path forwards and differentiates it backwards.

use super::plan::{Plan, Slot};
use crate::appearance::LightSource;
use crate::bsdf::ward::LobeDerivatives;
use crate::bsdf::{BsdfSample, Specular, Terms};
use crate::path::{DirectLight, Emission, PathObserver, Vertex};
use glam::DVec3;
use unrender_scene::Rgb;

/// A vertex of the path.
struct Entry {
    group: u32,
    /// `T`: the throughput from here to the camera.
    throughput: Rgb,
    /// The diffuse reflectance.
    rho_d: Rgb,
    /// The terms of the BRDF in the direction of the path; zero if it ends here.
    terms: Terms,
    /// `cos/pdf` over the probability of surviving Russian roulette.
    scale: f32,
    /// `w`: the BRDF times `scale`.
    weight: Rgb,
    /// The reflected light of the light samples.
    direct: Rgb,
    /// The emission that the path hits next.
    emitted: Rgb,
}

/// The tape of one path, and the sums over the paths of a pixel.
pub(super) struct Tape<'a> {
    plan: &'a Plan<'a>,
    entries: Vec<Entry>,
    /// `T` at the end of the path.
    throughput: Rgb,
    /// The radiance of the path so far.
    radiance: Rgb,
    /// The cached radiance of the surface at which the path ends; zero without a cache hit.
    cached: Rgb,
    /// The derivative by the parameter of each slot, summed over the paths.
    pub(super) sums: Vec<DVec3>,
}

impl<'a> Tape<'a> {
    pub(super) fn new(plan: &'a Plan<'a>) -> Self {
        Self {
            plan,
            entries: Vec::new(),
            throughput: Rgb::ONE,
            radiance: Rgb::ZERO,
            cached: Rgb::ZERO,
            sums: vec![DVec3::ZERO; plan.count],
        }
    }

    /// Starts a path whose camera ray hits `emission`.
    pub(super) fn start(&mut self, emission: &Emission) {
        self.entries.clear();
        self.throughput = Rgb::ONE;
        self.radiance = Rgb::ZERO;
        self.cached = Rgb::ZERO;
        if emission.radiance != Rgb::ZERO {
            self.record_emission(Rgb::ONE, emission, 1.0);
        }
    }

    /// The reverse pass: adds the derivatives of the path to the sums. Returns its radiance.
    pub(super) fn finish(&mut self) -> Rgb {
        if self.plan.count == 0 {
            return self.radiance;
        }
        let mut reflected = self.cached;
        for index in (0..self.entries.len()).rev() {
            let entry = &self.entries[index];
            let arriving = entry.emitted + reflected;
            let (group, rho_d, terms) = (entry.group, entry.rho_d, entry.terms);
            let light = entry.throughput * arriving * entry.scale;
            reflected = entry.direct + entry.weight * arriving;
            self.add_derivatives(group, rho_d, &terms, light);
        }
        self.radiance
    }

    /// Adds light of `source`, without the factor on it, to the derivatives by that factor.
    #[inline]
    fn add_light(&mut self, source: LightSource, light: Rgb) {
        for (slot, share) in self.plan.light(source) {
            add(&mut self.sums, slot, light * share);
        }
    }

    /// Adds the derivatives by the BRDF parameters of a vertex of `group`, where `light` is the
    /// contribution of the path through the vertex divided by its BRDF.
    #[inline]
    fn add_derivatives(&mut self, group: u32, rho_d: Rgb, terms: &Terms, light: Rgb) {
        let group = &self.plan.groups[group as usize];
        if !group.asked || light == Rgb::ZERO {
            return;
        }
        let material = group.material;
        let base = if material.texture.is_some() { rho_d } else { Rgb::ONE };
        let LobeDerivatives { value, by_alpha_x, by_alpha_y, by_theta } = terms.specular;
        let rho_s = material.rho_s;
        let factors = [
            base * terms.diffuse,
            Rgb::splat(value),
            rho_s * by_alpha_x,
            rho_s * by_alpha_y,
            rho_s * by_theta,
        ];
        for (slot, factor) in group.slots.into_iter().zip(factors) {
            add(&mut self.sums, slot, light * factor);
        }
    }
    /// Adds the derivatives by the specular reflectance of the groups of mirrors on the way of a light
    /// sample, which would contribute `light` if all of them reflected everything.
    #[inline]
    fn add_mirror_derivatives(&mut self, groups: &[u32], light: Rgb) {
        for (index, group) in groups.iter().enumerate() {
            let others = groups.iter().enumerate().filter(|(other, _)| *other != index);
            let others = others.map(|(_, other)| self.plan.groups[*other as usize].mirror());
            let light = light * others.product::<Rgb>();
            let group = &self.plan.groups[*group as usize];
            let is_mirror = group.specular == Specular::Mirror;
            add(&mut self.sums, group.slots[1].filter(|_| is_mirror), light);
        }
    }
}

#[inline]
fn add(sums: &mut [DVec3], slot: Slot, value: Rgb) {
    if let Some(slot) = slot {
        sums[slot as usize] += value.as_dvec3();
    }
}

impl PathObserver for Tape<'_> {
    #[inline]
    fn record_vertex(&mut self, at: &Vertex<'_>) {
        let group = at.surface.group;
        self.entries.push(Entry {
            group,
            throughput: self.throughput,
            rho_d: self.plan.groups[group as usize].rho_d(at),
            terms: Terms::default(),
            scale: 0.0,
            weight: Rgb::ZERO,
            direct: Rgb::ZERO,
            emitted: Rgb::ZERO,
        });
    }

    #[inline]
    fn record_direct(&mut self, _: Rgb, at: &Vertex<'_>, light: &DirectLight<'_>) {
        let DirectLight { wi, sample, ref passed, mis, .. } = *light;
        let Some(entry) = self.entries.last_mut() else { return };
        let group = &self.plan.groups[entry.group as usize];
        let terms = group.specular.terms(group.rotated(at.wo), group.rotated(wi));
        let f_cos = terms.value(entry.rho_d, group.material.rho_s) * wi.z;
        let factor = self.plan.brightness(sample.source);
        let mirrors =
            passed.groups().iter().map(|group| self.plan.groups[*group as usize].mirror());
        let arriving = sample.weight * mis * mirrors.product::<Rgb>();
        let direct = f_cos * arriving * factor;
        entry.direct += direct;
        self.radiance += self.throughput * direct;
        if self.plan.count > 0 {
            let rho_d = entry.rho_d;
            let unit = self.throughput * arriving;
            self.add_light(sample.source, unit * f_cos);
            self.add_derivatives(at.surface.group, rho_d, &terms, unit * factor * wi.z);
            let unit = self.throughput * f_cos * sample.weight * factor * mis;
            self.add_mirror_derivatives(passed.groups(), unit);
        }
    }

    #[inline]
    fn record_bounce(&mut self, at: &Vertex<'_>, sample: &BsdfSample, survival: f32) {
        let Some(entry) = self.entries.last_mut() else { return };
        let group = &self.plan.groups[entry.group as usize];
        if sample.pdf.is_finite() {
            entry.terms = group.specular.terms(group.rotated(at.wo), group.rotated(sample.wi));
            entry.scale = sample.wi.z / sample.pdf;
        } else {
            // f cos of a perfect mirror is rho_s times the delta distribution that the density is
            // the specular share of.
            let value = f32::from(group.specular == Specular::Mirror);
            entry.terms.specular.value = value;
            entry.scale = 1.0 / at.bsdf.specular_share();
        }
        let weight = terms_weight(entry, group.material.rho_s);
        self.throughput = self.throughput * weight / survival;
        entry.weight = weight / survival;
        entry.scale /= survival;
    }

    #[inline]
    fn record_emission(&mut self, _: Rgb, emission: &Emission, mis: f32) {
        let Emission { source, radiance } = *emission;
        let emitted = radiance * self.plan.brightness(source);
        self.radiance += self.throughput * emitted * mis;
        if let Some(entry) = self.entries.last_mut() {
            entry.emitted = emitted * mis;
        }
        self.add_light(source, self.throughput * radiance * mis);
    }

    #[inline]
    fn record_cache_hit(&mut self, _: Rgb, radiance: Rgb) {
        self.cached = radiance;
        self.radiance += self.throughput * radiance;
        add(&mut self.sums, self.plan.cache, self.throughput * radiance);
    }
}

/// The BRDF in the direction of the path times the scale of the entry.
fn terms_weight(entry: &Entry, rho_s: Rgb) -> Rgb {
    entry.terms.value(entry.rho_d, rho_s) * entry.scale
}
