//! What the photograph shows of a group, pixel by pixel, and the light that arrives there.

use crate::evidence::Light;
use crate::observe::observation::{Noise, Reading};
use crate::observe::sample::Stage;
use rayon::prelude::*;
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
    /// The radiance of a white base there.
    pub(super) base: [Vec<Rgb>; 2],
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
            base: light.base(material),
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
        self.base.iter_mut().zip(other.base).for_each(|(all, more)| all.extend(more));
        self.shine.iter_mut().zip(other.shine).for_each(|(all, more)| all.extend(more));
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
        self.base.iter_mut().for_each(|half| filter(half, kept));
        self.shine.iter_mut().for_each(|half| filter(half, kept));
    }

    /// The same with the light averaged over the neighbours that show the same object: it changes slowly.
    pub(super) fn smoothed(mut self, geometry: &GeometryBuffers) -> Self {
        let mut index = vec![u32::MAX; geometry.pixels().len()];
        self.pixels.iter().enumerate().for_each(|(i, pixel)| index[*pixel as usize] = i as u32);
        let smooth = |light: &Vec<Rgb>| -> Vec<Rgb> {
            let mean = |pixel: &u32| {
                let centre = geometry.pixels()[*pixel as usize].object;
                let near = geometry.neighbourhood(*pixel as usize);
                let same = near.filter(|&n| geometry.pixels()[n].object == centre);
                let (sum, count) = same
                    .filter_map(|n| light.get(index[n] as usize))
                    .fold((Rgb::ZERO, 0.0), |(sum, count), v| (sum + *v, count + 1.0));
                sum / f32::max(count, 1.0)
            };
            self.pixels.par_iter().with_min_len(256).map(mean).collect()
        };
        (self.base, self.shine) =
            (self.base.each_ref().map(smooth), self.shine.each_ref().map(smooth));
        self
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
