//! Explaining noise: the paths of a picture that are much brighter than the rest, and what happened
//! along each.
//!
//! [`Tracer::bright_paths`] traces the very paths of the picture again, with the same random
//! numbers, and keeps those that bring in more light than a threshold. The [kind](BrightPath::kind)
//! of a path is a word with a letter for each vertex and one for how the light was found:
//!
//! | letter | what happened |
//! |---|---|
//! | `D` | the direction was drawn as from the diffuse part of the BRDF |
//! | `G` | it was drawn as from the glossy lobe |
//! | `M` | it was drawn from a perfect mirror |
//! | `P` | the way from there, or from the camera, went through panes |
//! | `T` | it was bent or reflected by glass |
//! | `L` | a ray in a drawn direction hit a lamp |
//! | `l` | a light sample found a lamp or a light without a surface |
//! | `E`, `e` | the same for the environment |
//! | `v` | a light sample found any of them by way of planar mirrors |
//! | `g` | before `l`, `e` and `v`: the glossy lobe reflects most of it, else the diffuse part does |
//!
//! So `l` is light that comes straight to a diffuse surface which the camera sees, and `DML` a
//! caustic: from a diffuse surface by way of a mirror to a lamp. `Dgl` is a light sample at a glossy
//! surface that happens to lie where a diffuse one sees the light in it.

use crate::appearance::{Appearance, LightSource};
use crate::bsdf::{Bsdf, BsdfSample, Specular, lambert};
use crate::camera_sample::camera_ray;
use crate::path::{DirectLight, Emission, PathObserver, Transport, Vertex, Way};
use crate::radiance_cache::Cached;
use crate::settings::Settings;
use crate::tracer::Tracer;
use glam::Vec3;
use rayon::prelude::*;
use unrender_scene::{Camera, Rgb};

/// A path from the camera to a light. One sample of a pixel has several of them, since light is
/// looked for at every vertex.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BrightPath {
    /// The index of the pixel.
    pub pixel: u32,
    /// The number of the sample in the pixel, from zero.
    pub sample: u32,
    /// What the path adds to its sample, W sr^-1 m^-2 per channel; the pixel has the mean of all
    /// its samples.
    pub radiance: Rgb,
    /// What happened along the path, a letter each ([module](self)).
    pub kind: String,
}

impl Tracer {
    /// The paths of the picture that [`Tracer::render`] makes with [`Integrator::Path`] whose
    /// radiance, the mean of the three channels, is above `threshold`. They come in the order of
    /// the pixels and of their samples. Light that the camera sees itself is left out.
    ///
    /// [`Integrator::Path`]: crate::Integrator::Path
    pub fn bright_paths<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        settings: &Settings,
        threshold: f32,
    ) -> Vec<BrightPath> {
        let transport = Transport::new(self, appearance.into(), settings.max_bounces);
        bright_paths(&transport, camera, size, settings, threshold)
    }
}

/// [`Tracer::bright_paths`], compiled once.
fn bright_paths(
    transport: &Transport<'_>,
    camera: &Camera,
    size: (usize, usize),
    settings: &Settings,
    threshold: f32,
) -> Vec<BrightPath> {
    let of_pixel = |pixel: u32| {
        let mut observer = Bright::new(transport, threshold, pixel);
        for sample in settings.samples() {
            let mut sampler = settings.pixels(size.0).sampler(pixel, sample);
            let ray = camera_ray(camera, size, pixel, &mut sampler);
            observer.begin(sample);
            transport.trace_ray(&ray, &mut sampler, &mut observer);
        }
        observer.found
    };
    (0..(size.0 * size.1) as u32).into_par_iter().flat_map_iter(of_pixel).collect()
}

/// The observer that keeps the bright paths of one pixel.
struct Bright<'a> {
    transport: &'a Transport<'a>,
    threshold: f32,
    pixel: u32,
    sample: u32,
    /// The letters of the path so far.
    kind: String,
    /// Whether what it meets is what the camera sees.
    is_seen: bool,
    found: Vec<BrightPath>,
}

impl<'a> Bright<'a> {
    fn new(transport: &'a Transport<'a>, threshold: f32, pixel: u32) -> Self {
        Self {
            transport,
            threshold,
            pixel,
            sample: 0,
            kind: String::new(),
            is_seen: true,
            found: Vec::new(),
        }
    }

    /// From here on the events are those of the sample number `sample`.
    fn begin(&mut self, sample: u32) {
        self.sample = sample;
        self.is_seen = true;
        self.kind.clear();
    }

    /// Keeps the path if it is bright. Light of `source` was found as `lamp` says, or, if it is of
    /// the environment, as `environment` says.
    fn keep(&mut self, radiance: Rgb, source: LightSource, [lamp, environment]: [&str; 2]) {
        let radiance = radiance * self.transport.brightness(source);
        if radiance.element_sum() / 3.0 > self.threshold {
            let of_environment = matches!(source, LightSource::Environment(_));
            let mut kind = self.kind.clone();
            kind.push_str(if of_environment { environment } else { lamp });
            let (pixel, sample) = (self.pixel, self.sample);
            self.found.push(BrightPath { pixel, sample, radiance, kind });
        }
    }
}

impl PathObserver for Bright<'_> {
    fn record_vertex(&mut self, _: &Vertex<'_>) {
        self.is_seen = false;
    }

    fn record_direct(&mut self, throughput: Rgb, at: &Vertex<'_>, light: &DirectLight<'_>) {
        let arriving = light.sample.weight * light.transmittance;
        let radiance = throughput * (light.f_cos * arriving * light.mis);
        let letters = match (light.passed.all().is_empty(), is_glossy(at, light.wi)) {
            (true, false) => ["l", "e"],
            (true, true) => ["gl", "ge"],
            (false, false) => ["v", "v"],
            (false, true) => ["gv", "gv"],
        };
        self.keep(radiance, light.sample.source, letters);
    }

    fn record_bounce(&mut self, at: &Vertex<'_>, sample: &BsdfSample, _: f32) {
        self.kind.push(letter(at.bsdf, at.wo, sample));
    }

    fn record_glass(&mut self, way: &Way) {
        self.kind.push(if way.is_straight { 'P' } else { 'T' });
    }

    fn record_emission(&mut self, throughput: Rgb, emission: &Emission, mis: f32) {
        if self.is_seen {
            return;
        }
        self.keep(throughput * (emission.radiance * mis), emission.source, ["L", "E"]);
    }

    /// No transport here has a cache.
    fn record_cache_hit(&mut self, _: Rgb, _: &Cached) {}
}

/// The letter of a drawn direction. A sample does not say which lobe it was drawn from: it is called
/// glossy if the glossy lobe draws this direction more often than the diffuse part does.
fn letter(bsdf: &Bsdf<'_>, wo: Vec3, sample: &BsdfSample) -> char {
    if sample.pdf.is_infinite() {
        return 'M';
    }
    let Specular::Glossy(lobe) = bsdf.specular else { return 'D' };
    let by_lobe = bsdf.specular_share() * lobe.pdf(wo, sample.wi);
    if by_lobe > 0.5 * sample.pdf { 'G' } else { 'D' }
}

/// Whether the glossy lobe reflects more of the light from `wi` than the diffuse part does.
fn is_glossy(at: &Vertex<'_>, wi: Vec3) -> bool {
    let base = at.bsdf.rho_d * (lambert::VALUE * at.bsdf.coat.base(at.wo.z, wi.z));
    let whole = at.bsdf.value(at.wo, wi);
    whole.element_sum() > 2.0 * base.element_sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::lobe::GlossyLobe;
    use unrender_scene::WardModel;

    #[test]
    fn a_direction_is_named_by_the_lobe_that_draws_it_more_often() {
        let lobe = Specular::Glossy(GlossyLobe::new(WardModel::WardGmd, 0.05, 0.05));
        let half = Rgb::splat(0.5);
        let wo = Vec3::new(0.6, 0.0, 0.8);
        let named = |specular, wi: Vec3| {
            let bsdf = Bsdf::with(half, half, specular);
            letter(
                &bsdf,
                wo,
                &BsdfSample { wi, weight: Rgb::ONE, unguided: Rgb::ONE, pdf: bsdf.pdf(wo, wi) },
            )
        };
        let mirrored = Vec3::new(-0.6, 0.0, 0.8);
        assert_eq!(named(lobe, mirrored), 'G');
        assert_eq!(named(lobe, wo), 'D');
        assert_eq!(named(Specular::None, mirrored), 'D');
        let mirror = Bsdf::with(half, half, Specular::Mirror);
        let drawn = mirror.sample(wo, [0.0; 3]).unwrap();
        assert_eq!(letter(&mirror, wo, &drawn), 'M');
        assert_eq!(letter(&mirror, wo, &mirror.sample(wo, [0.9, 0.5, 0.5]).unwrap()), 'D');
    }
}
