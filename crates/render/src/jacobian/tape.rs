//! The tape: records one path forwards and differentiates it backwards.

use super::plan::{GroupPlan, Plan, Slot};
use crate::appearance::LightSource;
use crate::bsdf::{BsdfSample, Terms};
use crate::path::{DirectLight, Emission, PathObserver, Vertex, Way};
use crate::radiance_cache::Cached;
use crate::virtual_lamps::{MirrorsPassed, Passed};
use glam::{DVec3, Vec2, Vec3};
use unrender_scene::Rgb;

/// A vertex of the path.
struct Entry {
    group: u32,
    /// Towards the camera, in the anisotropy frame of the group as it is evaluated.
    wo: Vec3,
    /// `T`: the throughput from here to the camera.
    throughput: Rgb,
    /// The diffuse reflectance.
    rho_d: Rgb,
    /// The normal of the mesh below bumps, in that frame.
    mesh: Option<Vec3>,
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
    /// The colour of the glass on the way there.
    filter: Rgb,
}

impl Entry {
    /// The terms of the BRDF of its `group` for light from `wi`.
    #[inline]
    fn terms(&self, group: &GroupPlan<'_>, wi: Vec3) -> Terms {
        let bsdf = self.mesh.map_or(group.bsdf, |mesh| group.bsdf.bumped(mesh));
        bsdf.terms(self.rho_d, self.wo, wi)
    }
}

/// Light that a light sample brings to a vertex.
pub(super) struct Arriving {
    pub(super) source: LightSource,
    /// Radiance over density, or irradiance over probability, times the weight of multiple importance sampling,
    /// in the scene as it is.
    pub(super) weight: Rgb,
    /// The mirrors on the way.
    pub(super) passed: MirrorsPassed,
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

    /// Starts a path.
    pub(super) fn begin(&mut self) {
        self.entries.clear();
        self.throughput = Rgb::ONE;
        self.radiance = Rgb::ZERO;
        self.cached = Rgb::ZERO;
    }

    /// The path arrives at a vertex of `group`; `wo` points towards the camera, in the anisotropy frame that paths
    /// are drawn in.
    #[inline]
    pub(super) fn vertex(&mut self, group: u32, uv: Vec2, wo: Vec3) {
        let plan = &self.plan.groups[group as usize];
        self.entries.push(Entry {
            group,
            wo: plan.rotated(wo),
            throughput: self.throughput,
            rho_d: plan.material.rho_d_at(uv),
            mesh: None,
            terms: Terms::default(),
            scale: 0.0,
            weight: Rgb::ZERO,
            direct: Rgb::ZERO,
            emitted: Rgb::ZERO,
            filter: Rgb::ONE,
        });
    }

    /// The vertex has bumps that shade themselves, on a mesh of the normal `mesh`.
    #[inline]
    pub(super) fn bumps(&mut self, mesh: Vec3) {
        if let Some(entry) = self.entries.last_mut() {
            entry.mesh = Some(self.plan.groups[entry.group as usize].rotated(mesh));
        }
    }

    /// A light sample along `wi` contributes at the vertex.
    #[inline]
    pub(super) fn light(&mut self, wi: Vec3, light: &Arriving) {
        let Some(entry) = self.entries.last_mut() else { return };
        let group = &self.plan.groups[entry.group as usize];
        let terms = entry.terms(group, group.rotated(wi));
        let f_cos = terms.value * wi.z;
        let factor = self.plan.brightness(light.source);
        let passed = light.passed.all();
        let mirrors = passed.iter().map(|mirror| self.plan.mirror(mirror).value);
        let arriving = light.weight * mirrors.product::<Rgb>();
        let direct = f_cos * arriving * factor;
        entry.direct += direct;
        self.radiance += self.throughput * direct;
        if self.plan.count > 0 {
            let (group, rho_d) = (entry.group, entry.rho_d);
            let unit = self.throughput * arriving;
            self.add_light(light.source, unit * f_cos);
            self.add_derivatives(group, rho_d, &terms, unit * factor * wi.z);
            let unit = self.throughput * f_cos * light.weight * factor;
            self.add_mirror_derivatives(passed, unit);
        }
    }

    /// The path continues along `wi`; `scale` is the cosine over the density and over the probability of
    /// surviving Russian roulette.
    #[inline]
    pub(super) fn bounce(&mut self, wi: Vec3, scale: f32) {
        let Some(entry) = self.entries.last_mut() else { return };
        let group = &self.plan.groups[entry.group as usize];
        entry.terms = entry.terms(group, group.rotated(wi));
        self.go_on(scale);
    }

    /// The path continues as from a perfect mirror; `scale` is one over the probability of that and of surviving.
    #[inline]
    pub(super) fn reflection(&mut self, scale: f32) {
        let Some(entry) = self.entries.last_mut() else { return };
        // f cos of a perfect mirror is its reflectance times the delta distribution that the density is the
        // specular share of.
        entry.terms = self.plan.groups[entry.group as usize].bsdf.mirror_terms(entry.wo.z);
        self.go_on(scale);
    }

    #[inline]
    fn go_on(&mut self, scale: f32) {
        let Some(entry) = self.entries.last_mut() else { return };
        entry.scale = scale;
        entry.weight = entry.terms.value * scale;
        self.throughput *= entry.weight;
    }

    /// Glass on the way colours all that follows by `filter`.
    #[inline]
    pub(super) fn glass(&mut self, filter: Rgb) {
        self.throughput *= filter;
        if let Some(entry) = self.entries.last_mut() {
            entry.filter = filter;
        }
    }

    /// The path's ray hits what `source` emits; `radiance` times the weight of multiple importance sampling, in the
    /// scene as it is.
    #[inline]
    pub(super) fn emission(&mut self, source: LightSource, radiance: Rgb) {
        let emitted = radiance * self.plan.brightness(source);
        self.radiance += self.throughput * emitted;
        if let Some(entry) = self.entries.last_mut() {
            entry.emitted = emitted;
        }
        self.add_light(source, self.throughput * radiance);
    }

    /// The path ends at a surface whose reflected `radiance` is in the cache.
    #[inline]
    pub(super) fn cached(&mut self, radiance: Rgb) {
        self.cached = radiance;
        self.radiance += self.throughput * radiance;
        add(&mut self.sums, self.plan.cache, self.throughput * radiance);
    }

    /// The reverse pass: adds the derivatives of the path to the sums. Returns its radiance.
    pub(super) fn finish(&mut self) -> Rgb {
        if self.plan.count == 0 {
            return self.radiance;
        }
        let mut reflected = self.cached;
        for index in (0..self.entries.len()).rev() {
            let entry = &self.entries[index];
            let arriving = entry.filter * (entry.emitted + reflected);
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
        let Terms { by_rho_d, by_rho_s, by_alpha_x, by_alpha_y, by_theta, .. } = *terms;
        let factors = [base * by_rho_d, by_rho_s, by_alpha_x, by_alpha_y, by_theta];
        for (slot, factor) in group.slots.into_iter().zip(factors) {
            add(&mut self.sums, slot, light * factor);
        }
    }

    /// Adds the derivatives by the specular reflectance of the groups of mirrors on the way of a light
    /// sample, which would contribute `light` if all of them reflected everything.
    #[inline]
    fn add_mirror_derivatives(&mut self, mirrors: &[Passed], light: Rgb) {
        for (index, mirror) in mirrors.iter().enumerate() {
            let others = mirrors.iter().enumerate().filter(|(other, _)| *other != index);
            let others = others.map(|(_, other)| self.plan.mirror(other).value);
            let light = light * others.product::<Rgb>() * self.plan.mirror(mirror).by_rho_s;
            let slot = self.plan.groups[mirror.group as usize].slots[1];
            add(&mut self.sums, slot, light);
        }
    }
}

/// The factor on the BRDF, or on the reflectance of a perfect mirror, where a path goes on.
#[inline]
pub(super) fn scale(at: &Vertex<'_>, sample: &BsdfSample, survival: f32) -> f32 {
    if sample.pdf.is_finite() {
        sample.wi.z / (sample.pdf * survival)
    } else {
        1.0 / (at.bsdf.specular_share() * survival)
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
        self.vertex(at.surface.group, at.surface.uv, at.wo);
        at.bsdf.mesh().into_iter().for_each(|mesh| self.bumps(mesh));
    }

    #[inline]
    fn record_direct(&mut self, _: Rgb, _: &Vertex<'_>, light: &DirectLight<'_>) {
        let DirectLight { wi, sample, passed, mis, .. } = *light;
        self.light(wi, &Arriving { source: sample.source, weight: sample.weight * mis, passed });
    }

    #[inline]
    fn record_bounce(&mut self, at: &Vertex<'_>, sample: &BsdfSample, survival: f32) {
        let scale = scale(at, sample, survival);
        if sample.pdf.is_finite() {
            self.bounce(sample.wi, scale);
        } else {
            self.reflection(scale);
        }
    }

    #[inline]
    fn record_glass(&mut self, way: &Way) {
        self.glass(way.passage.filter);
    }

    #[inline]
    fn record_emission(&mut self, _: Rgb, emission: &Emission, mis: f32) {
        self.emission(emission.source, emission.radiance * mis);
    }

    #[inline]
    fn record_cache_hit(&mut self, _: Rgb, cached: &Cached) {
        self.cached(cached.radiance);
    }
}
