//! What the photograph shows of a group, pixel by pixel, and the light that arrives there.

use super::smooth::Surfaces;
use crate::evidence::Light;
use crate::observe::observation::{Noise, Reading};
use crate::observe::sample::Stage;
use glam::Vec3;
use unrender_render::{Appearance, GeometryBuffers, ProbeSettings};
use unrender_scene::{Material, Rgb};

/// Pixels whose light is held at a time: with the most directions a hundred megabytes. Half and double of it give the same.
const CHUNK: usize = 4096;

/// A group's pixels with their light, twice with independent noise.
#[derive(Clone, Debug, Default)]
pub(super) struct Lit {
    pub(super) pixels: Vec<u32>,
    /// The photograph's radiance, and its noise.
    pub(super) shown: Vec<Rgb>,
    pub(super) noise: Vec<Noise>,
    /// The points that they show, world space, metres.
    pub(super) points: Vec<Vec3>,
    /// The radiance of a white base there, and the part of it that comes straight from lights.
    pub(super) base: [Vec<Rgb>; 2],
    pub(super) straight: [Vec<Rgb>; 2],
    /// The radiance of the lobe above it.
    pub(super) shine: [Vec<Rgb>; 2],
}

impl Lit {
    /// The light behind `pixels` of `group` as the lobe of `material` and a white base under it reflect it.
    pub(super) fn gather(
        stage: &Stage<'_>,
        appearance: Appearance<'_>,
        (group, pixels): (usize, &[u32]),
        material: &Material,
        probe: &ProbeSettings,
    ) -> Self {
        let mut all = Self::default();
        for chunk in pixels.chunks(CHUNK) {
            let (light, seen) = Light::gather(stage, appearance, group, chunk, probe);
            all.extend(Self::of(stage, group, (&light, &seen), material));
        }
        all
    }

    /// The same of `light` that was gathered behind `pixels`.
    pub(super) fn of(
        stage: &Stage<'_>,
        group: usize,
        (light, pixels): (&Light, &[u32]),
        material: &Material,
    ) -> Self {
        let observed = stage.observe(group, pixels);
        let shine = if material.rho_s == Rgb::ZERO {
            [vec![Rgb::ZERO; pixels.len()], vec![Rgb::ZERO; pixels.len()]]
        } else {
            light.specular(material).map(|half| half.iter().map(|s| material.rho_s * *s).collect())
        };
        let mut all = Self {
            pixels: pixels.to_vec(),
            shown: observed.iter().map(|seen| seen.radiance).collect(),
            noise: observed.iter().map(|seen| seen.noise).collect(),
            points: light.sets[0].first().map(|probe| probe.point).collect(),
            base: light.base(material),
            straight: light.straight(material),
            shine,
        };
        let counts: Vec<bool> =
            observed.iter().map(|seen| seen.reading != Reading::Nothing).collect();
        all.keep(&counts);
        all
    }

    fn extend(&mut self, other: Self) {
        self.pixels.extend(other.pixels);
        self.shown.extend(other.shown);
        self.noise.extend(other.noise);
        self.points.extend(other.points);
        let light = self.base.iter_mut().chain(&mut self.straight).chain(&mut self.shine);
        let more = other.base.into_iter().chain(other.straight).chain(other.shine);
        light.zip(more).for_each(|(all, more)| all.extend(more));
    }

    /// Drops the pixels that are not `kept`.
    fn keep(&mut self, kept: &[bool]) {
        fn filter<T>(values: &mut Vec<T>, kept: &[bool]) {
            let mut next = kept.iter();
            values.retain(|_| next.next().copied().unwrap_or(true));
        }
        filter(&mut self.pixels, kept);
        filter(&mut self.shown, kept);
        filter(&mut self.noise, kept);
        filter(&mut self.points, kept);
        let light = self.base.iter_mut().chain(&mut self.straight).chain(&mut self.shine);
        light.for_each(|half| filter(half, kept));
    }

    /// The same with the light averaged over pixels that show the same surface: over neighbours, and what comes by way of other
    /// surfaces, which has no edges, over more.
    pub(super) fn smoothed(self, geometry: &GeometryBuffers) -> Self {
        let (pixels, points) = (&self.pixels, &self.points);
        let surfaces = Surfaces { geometry, pixels, points };
        let slow = |half: usize| -> Vec<Rgb> {
            let both = self.base[half].iter().zip(&self.straight[half]);
            both.map(|(all, straight)| *all - *straight).collect()
        };
        let [straight, slow] = [surfaces.near(&self.straight), surfaces.far(&[0, 1].map(slow))];
        let sum = |half: usize| straight[half].iter().zip(&slow[half]).map(|(a, b)| *a + *b);
        let base = [0, 1].map(|half| sum(half).collect());
        let shine = surfaces.near(&self.shine);
        Self { base, straight, shine, ..self }
    }

    /// The relative noise of the mean of both halves of the base's light.
    pub(super) fn scatter(&self) -> f32 {
        let pairs = || self.base[0].iter().zip(&self.base[1]);
        let difference: Rgb = pairs().map(|(a, b)| (*a - *b) * (*a - *b)).sum();
        let sum: Rgb = pairs().map(|(a, b)| (*a + *b) * (*a + *b)).sum();
        (difference / sum.max(Rgb::splat(f32::MIN_POSITIVE))).max_element().sqrt()
    }

    /// The mean of both halves of the base's light.
    pub(super) fn light(&self) -> Vec<Rgb> {
        mean(&self.base)
    }

    /// What the base shows: the photograph without the lobe.
    pub(super) fn under(&self) -> Vec<Rgb> {
        self.shown.iter().zip(mean(&self.shine)).map(|(shown, shine)| *shown - shine).collect()
    }
}

/// The mean of two halves.
pub(super) fn mean([a, b]: &[Vec<Rgb>; 2]) -> Vec<Rgb> {
    a.iter().zip(b).map(|(a, b)| 0.5 * (*a + *b)).collect()
}
