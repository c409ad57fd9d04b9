//! Jacobian images: radiance and its derivative by every parameter, in one pass.
//!
//! Forward mode would carry `dC/dp = C sum over the vertices of (df/dp)/f` along each path. Reverse
//! mode gives the same sum with the work of one path and without the division. With `T_i` the
//! throughput from vertex `i` to the camera, `f_i` the BRDF there, `w_i = f_i cos/pdf`, and `L_i`
//! the radiance that arrives at vertex `i` along the path,
//!
//! ```text
//! L_(i-1) = emitted_i + direct_i + w_i L_i
//! dC/dp   = sum over the vertices i of p's group:  T_i (d direct_i/dp + dw_i/dp L_i)
//! ```
//!
//! Sampling densities, weights of multiple importance sampling and Russian roulette are held fixed
//! (detached): they decide which paths are taken, not how much light they carry. The same sum with
//! adjoint radiance as `T_i` is radiative backpropagation [Nimier-David et al. 2020].
//!
//! The brightness `p` of a light source multiplies its emission, so the derivative is the light
//! from the source without that factor.
//!
//! The events of a path are recorded on a tape (module `tape`); a plan maps groups and light
//! sources to the sums that they contribute to (module `plan`). Paths that are kept can be evaluated again under
//! other appearances (module `stored`).

mod plan;
mod stored;
mod tape;

pub use stored::StoredPaths;

use crate::appearance::Appearance;
use crate::camera_sample::camera_ray;
use crate::path::Transport;
use crate::query::Query;
use crate::radiance_cache::CacheLookup;
use crate::settings::Settings;
use crate::tracer::Tracer;
use glam::DVec3;
use plan::Plan;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use tape::Tape;
use unrender_scene::{Camera, Rgb};

/// Pixels per parallel task, where all have as many paths.
const CHUNK: usize = 256;

/// Radiance and its derivatives in some pixels.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Jacobian {
    /// The radiance of each pixel, W sr^-1 m^-2 per channel.
    pub radiance: Vec<Rgb>,
    /// For each pixel, concatenated, its derivative by each parameter: channel c holds
    /// `dL_c / dp_c`, W sr^-1 m^-2 per unit of the parameter.
    pub derivatives: Vec<Rgb>,
}

impl Tracer {
    /// Radiance of the pixels of `query` (indices into a picture of `size`) and its derivatives by
    /// the parameters; the cache ends no path at its first vertex. Derivatives by parameters of
    /// missing groups and light sources are zero.
    ///
    /// The paths are those of [`Tracer::render_pixels`] under the same seed, and so is the
    /// radiance; except where a reflectance among the parameters is so close to zero that those
    /// paths would hardly sample its lobe. There directions are drawn as if it were larger.
    ///
    /// # Panics
    /// If the appearance has fewer materials than the scene has groups.
    pub fn jacobian(
        &self,
        camera: &Camera,
        size: (usize, usize),
        query: &Query<'_, u32, Settings, CacheLookup<'_>>,
    ) -> Jacobian {
        let Query { appearance, pixels, parameters, settings, seen } = *query;
        if parameters.is_empty() {
            let radiance = self.radiance_reweighted(camera, size, appearance, query);
            return Jacobian { radiance, derivatives: Vec::new() };
        }
        let of_pixel = |pixel: &u32| (*pixel, settings.samples());
        let pixels: Vec<(u32, Range<u32>)> = pixels.iter().map(of_pixel).collect();
        let pixels = &pixels;
        let query = Query { appearance, pixels, parameters, settings, seen };
        self.jacobian_of_samples(camera, size, &query)
    }

    /// The same on the paths whose numbers stand beside each pixel instead of those of the settings; zero
    /// where there are none.
    ///
    /// # Panics
    /// If the appearance has fewer materials than the scene has groups.
    pub fn jacobian_of_samples(
        &self,
        camera: &Camera,
        size: (usize, usize),
        query: &Query<'_, (u32, Range<u32>), Settings, CacheLookup<'_>>,
    ) -> Jacobian {
        let Query { appearance, pixels, parameters, settings, seen: cache } = *query;
        let drawn = plan::drawn(appearance.materials, parameters);
        let sampled_as = Appearance { materials: &drawn, ..appearance };
        let estimator = Estimator {
            transport: Transport::new(self, sampled_as, settings.max_bounces).with_cache(cache),
            plan: Plan::new(self, appearance, sampled_as, parameters),
            camera,
            size,
            settings,
        };
        let mut radiance = vec![Rgb::ZERO; pixels.len()];
        let mut derivatives = vec![Rgb::ZERO; pixels.len() * parameters.len()];
        let rows = derivatives.par_chunks_mut(parameters.len().max(1));
        let outputs = radiance.par_iter_mut().zip(rows);
        let new_tape = || Tape::new(&estimator.plan);
        pixels.par_iter().zip(outputs).for_each_init(new_tape, |tape, (pixel, (radiance, row))| {
            let (pixel, samples) = pixel;
            let scale = 1.0 / f64::from(samples.len().max(1) as u32);
            *radiance = estimator.pixel(*pixel, samples.clone(), tape);
            for (derivative, slot) in row.iter_mut().zip(&estimator.plan.slots) {
                let sum = slot.map_or(DVec3::ZERO, |slot| tape.sums[slot as usize]);
                *derivative = (sum * scale).as_vec3();
            }
        });
        Jacobian { radiance, derivatives }
    }

    /// The radiance of the pixels of `query` under its appearance, estimated on the paths of `sampled_as` (those
    /// of [`Tracer::render_pixels`] under the same seed) by importance weights. On common paths the
    /// noise of two appearances is correlated and mostly cancels in their difference.
    ///
    /// The estimate is unbiased if `sampled_as` reflects wherever the appearance does: a group that
    /// is diffuse, glossy or a perfect mirror in one must be so in the other, and not black.
    ///
    /// # Panics
    /// If an appearance has fewer materials than the scene has groups.
    pub fn radiance_reweighted<'a>(
        &self,
        camera: &Camera,
        size: (usize, usize),
        sampled_as: impl Into<Appearance<'a>>,
        query: &Query<'_, u32, Settings, CacheLookup<'_>>,
    ) -> Vec<Rgb> {
        let Query { appearance, pixels, settings, seen: cache, .. } = *query;
        let sampled_as = sampled_as.into();
        let estimator = Estimator {
            transport: Transport::new(self, sampled_as, settings.max_bounces).with_cache(cache),
            plan: Plan::new(self, appearance, sampled_as, &[]),
            camera,
            size,
            settings,
        };
        estimator.radiance(pixels)
    }
}

/// Estimates radiance and derivatives of pixels.
struct Estimator<'a> {
    /// Draws the paths.
    transport: Transport<'a>,
    /// Evaluates them.
    plan: Plan<'a>,
    camera: &'a Camera,
    size: (usize, usize),
    settings: &'a Settings,
}

impl Estimator<'_> {
    /// The radiance of `pixels`, without derivatives.
    fn radiance(&self, pixels: &[u32]) -> Vec<Rgb> {
        let chunk = |chunk: &[u32]| -> Vec<Rgb> {
            let mut tape = Tape::new(&self.plan);
            let samples = || self.settings.samples();
            chunk.iter().map(|&pixel| self.pixel(pixel, samples(), &mut tape)).collect()
        };
        pixels.par_chunks(CHUNK).flat_map_iter(chunk).collect()
    }

    /// The radiance of one pixel by the paths of these numbers; leaves the sums over them on the tape.
    fn pixel(&self, pixel: u32, samples: Range<u32>, tape: &mut Tape<'_>) -> Rgb {
        let paths = f64::from(samples.len().max(1) as u32);
        let mut radiance = DVec3::ZERO;
        tape.sums.fill(DVec3::ZERO);
        for index in samples {
            let mut sampler = self.settings.pixels(self.size.0).sampler(pixel, index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            tape.begin();
            self.transport.trace_ray(&ray, &mut sampler, tape);
            radiance += tape.finish().as_dvec3();
        }
        (radiance / paths).as_vec3()
    }
}
