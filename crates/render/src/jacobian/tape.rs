//! One path, forwards and back: what it brought, and what the parameters of its vertices did to
//! that.

use super::plan::{NONE, Plan};
use crate::bsdf::ward::LobeDerivatives;
use crate::bsdf::{BsdfSample, Specular, Terms};
use crate::emitters::LightSample;
use crate::path::{Ledger, Vertex};
use glam::{DVec3, Vec3};
use unrender_scene::Rgb;

/// A vertex of the path.
struct Entry {
    group: u32,
    /// `T`: what is left of the light from here on its way to the camera.
    throughput: Rgb,
    /// The diffuse reflectance.
    rho_d: Rgb,
    /// What its reflectance is made of in the direction that the path took; zero if it took none.
    terms: Terms,
    /// `cos/pdf` over the probability that the path went on.
    scale: f32,
    /// `w`: the reflectance times `scale`.
    weight: Rgb,
    /// What the vertex reflects of the light sample.
    direct: Rgb,
    /// What the surface emits that the path met next.
    emitted: Rgb,
}

/// The path that is being traced, and the sums over the paths of a pixel.
pub(super) struct Tape<'a> {
    plan: &'a Plan<'a>,
    entries: Vec<Entry>,
    /// `T` at the path's end.
    throughput: Rgb,
    /// What the path has brought so far.
    radiance: Rgb,
    /// What the surface reflects at which the path ends, if that is known.
    known: Rgb,
    /// The derivative by each slot's parameter, summed over the paths.
    pub(super) sums: Vec<DVec3>,
}

impl<'a> Tape<'a> {
    pub(super) fn new(plan: &'a Plan<'a>) -> Self {
        Self {
            plan,
            entries: Vec::new(),
            throughput: Rgb::ONE,
            radiance: Rgb::ZERO,
            known: Rgb::ZERO,
            sums: vec![DVec3::ZERO; plan.count],
        }
    }

    /// Starts a path at a surface of the group `source` that emits `emission`.
    pub(super) fn start(&mut self, source: u32, emission: Rgb) {
        self.entries.clear();
        self.throughput = Rgb::ONE;
        self.radiance = Rgb::ZERO;
        self.known = Rgb::ZERO;
        if emission != Rgb::ZERO {
            self.emission(Rgb::ONE, source, emission, 1.0);
        }
    }

    /// Goes back along the path and adds what it says to the sums; returns its radiance.
    pub(super) fn finish(&mut self) -> Rgb {
        if self.plan.count == 0 {
            return self.radiance;
        }
        let mut reflected = self.known;
        for index in (0..self.entries.len()).rev() {
            let entry = &self.entries[index];
            let arriving = entry.emitted + reflected;
            let (group, rho_d, terms) = (entry.group, entry.rho_d, entry.terms);
            let light = entry.throughput * arriving * entry.scale;
            reflected = entry.direct + entry.weight * arriving;
            self.deposit(group, rho_d, &terms, light);
        }
        self.radiance
    }

    /// Adds `light`, which reached the camera through a vertex of `group` but for its reflectance,
    /// to the derivatives by that reflectance.
    #[inline]
    fn deposit(&mut self, group: u32, rho_d: Rgb, terms: &Terms, light: Rgb) {
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
}

#[inline]
fn add(sums: &mut [DVec3], slot: u32, value: Rgb) {
    if slot != NONE {
        sums[slot as usize] += value.as_dvec3();
    }
}

impl Ledger for Tape<'_> {
    #[inline]
    fn arrive(&mut self, at: &Vertex<'_>) {
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
    fn direct(
        &mut self,
        _: Rgb,
        at: &Vertex<'_>,
        wi: Vec3,
        _: Rgb,
        light: &LightSample,
        share: f32,
    ) {
        let Some(entry) = self.entries.last_mut() else { return };
        let group = &self.plan.groups[entry.group as usize];
        let terms = group.specular.terms(group.turned(at.wo), group.turned(wi));
        let f_cos = terms.value(entry.rho_d, group.material.rho_s) * wi.z;
        let factor = self.plan.appearance.light(light.source);
        entry.direct = f_cos * light.weight * factor * share;
        self.radiance += self.throughput * entry.direct;
        if self.plan.count > 0 {
            let rho_d = entry.rho_d;
            let unit = self.throughput * light.weight * share;
            add(&mut self.sums, self.plan.light(light.source), unit * f_cos);
            self.deposit(at.surface.group, rho_d, &terms, unit * factor * wi.z);
        }
    }

    #[inline]
    fn bounce(&mut self, at: &Vertex<'_>, sample: &BsdfSample, survival: f32) {
        let Some(entry) = self.entries.last_mut() else { return };
        let group = &self.plan.groups[entry.group as usize];
        if sample.pdf.is_finite() {
            entry.terms = group.specular.terms(group.turned(at.wo), group.turned(sample.wi));
            entry.scale = sample.wi.z / sample.pdf;
        } else {
            // A perfect mirror's f cos is rho_s times a peak, of which the density takes a share.
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
    fn emission(&mut self, _: Rgb, source: u32, radiance: Rgb, share: f32) {
        let emitted = radiance * self.plan.appearance.light(source);
        self.radiance += self.throughput * emitted * share;
        if let Some(entry) = self.entries.last_mut() {
            entry.emitted = emitted * share;
        }
        add(&mut self.sums, self.plan.light(source), self.throughput * radiance * share);
    }

    #[inline]
    fn known(&mut self, _: Rgb, radiance: Rgb) {
        self.known = radiance;
        self.radiance += self.throughput * radiance;
        add(&mut self.sums, self.plan.seen, self.throughput * radiance);
    }
}

/// The reflectance in the direction that the path took, times the entry's scale.
fn terms_weight(entry: &Entry, rho_s: Rgb) -> Rgb {
    entry.terms.value(entry.rho_d, rho_s) * entry.scale
}
