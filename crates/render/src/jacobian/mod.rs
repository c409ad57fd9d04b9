//! Jacobian images: radiance and its derivative by every parameter, in one pass (design, section 5).
//!
//! Forward mode would carry `dC/dp = C sum over the path's vertices of (df/dp)/f` along each path.
//! Going back from the path's end gives the same sum with the work of one path and without the
//! division: with `T_i` what is left of the light on its way from vertex `i` to the camera, `f_i`
//! the reflectance there, `w_i = f_i cos/pdf`, and `L_i` the radiance that arrives at vertex `i`
//! along the path,
//!
//! ```text
//! L_(i-1) = emitted_i + direct_i + w_i L_i
//! dC/dp   = sum over the vertices i of p's group:  T_i (d direct_i/dp + dw_i/dp L_i)
//! ```
//!
//! Sampling densities are held fixed: the paths, the shares of the two strategies and the paths'
//! random ends belong to the question *where* light is looked for, not how much there is. (The same
//! sum, with adjoint radiance as `T_i`, is radiative backpropagation [Nimier-David et al. 2020].)
//!
//! A brightness `p` of a source multiplies whatever comes from it, so the derivative is that light
//! without the factor.
//!
//! What a path meets goes onto a tape (module `tape`); which sums it feeds is looked up in a plan
//! (module `plan`).

mod plan;
mod tape;

use crate::film::{CHUNK, STREAM, Settings, camera_ray};
use crate::path::Transport;
use crate::sampler::Sampler;
use crate::seen::Lookup;
use crate::tracer::{Appearance, Tracer};
use glam::DVec3;
use plan::Plan;
use rayon::prelude::*;
use tape::Tape;
use unrender_scene::{Camera, Rgb};

/// What a derivative is taken by. Each stands for three numbers, one a channel, except that the
/// roughnesses and the angle are shared by the channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// The diffuse reflectance of a group; of a textured one, a factor on its texture.
    RhoD(u32),
    /// The specular reflectance of a group.
    RhoS(u32),
    /// The roughness along a group's brushed direction; of a perfect mirror, nothing.
    AlphaX(u32),
    /// The roughness across it.
    AlphaY(u32),
    /// The angle of a group's brushed direction, per radian.
    Theta(u32),
    /// How many times as bright as in the scene a source shines ([`Appearance::lights`]).
    Light(u32),
    /// A factor on the radiance that paths take from the cache ([`crate::SeenRadiance`]).
    Seen,
}

/// Radiance and its derivatives in some pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Jacobian {
    /// The radiance of each pixel, W sr^-1 m^-2 per channel.
    pub radiance: Vec<Rgb>,
    /// For each pixel, one behind the other, its derivative by each parameter: channel c holds
    /// `dL_c / dp_c`, W sr^-1 m^-2 per unit of the parameter.
    pub derivatives: Vec<Rgb>,
}

impl Tracer {
    /// Radiance of `pixels` (indices into a picture of `size`) and its derivatives by `parameters`;
    /// paths end where `seen` knows the radiance, except at the surface that the camera looks at.
    /// Parameters of groups and sources that are not there have no effect.
    ///
    /// The paths are those of [`Tracer::render_pixels`] under the same seed, so the radiance is the
    /// same too. Not so where a reflectance asked for is so near to zero that those paths would
    /// hardly look at what it would bring: there the directions are drawn as if it were larger.
    ///
    /// # Panics
    /// If the appearance has fewer materials than the scene has groups.
    #[expect(clippy::too_many_arguments, reason = "each is a different part of the question")]
    pub fn jacobian<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        pixels: &[u32],
        parameters: &[Parameter],
        settings: &Settings,
        seen: Option<Lookup<'_>>,
    ) -> Jacobian {
        let appearance = appearance.into();
        let drawn = plan::drawn(appearance.materials, parameters);
        let sampled_as = Appearance { materials: &drawn, ..appearance };
        let estimator = Estimator {
            transport: Transport::new(self, sampled_as, settings.max_bounces).ending_at(seen),
            plan: Plan::new(self, appearance, sampled_as, parameters),
            camera,
            size,
            settings,
        };
        if parameters.is_empty() {
            return Jacobian { radiance: estimator.radiance(pixels), derivatives: Vec::new() };
        }
        let mut radiance = vec![Rgb::ZERO; pixels.len()];
        let mut derivatives = vec![Rgb::ZERO; pixels.len() * parameters.len()];
        let rows = derivatives.par_chunks_mut(CHUNK * parameters.len());
        let outputs = radiance.par_chunks_mut(CHUNK).zip(rows);
        pixels.par_chunks(CHUNK).zip(outputs).for_each(|(pixels, (radiance, rows))| {
            let mut tape = Tape::new(&estimator.plan);
            let rows = rows.chunks_exact_mut(parameters.len());
            for ((&pixel, radiance), row) in pixels.iter().zip(radiance).zip(rows) {
                *radiance = estimator.pixel(pixel, &mut tape);
                let scale = 1.0 / estimator.paths();
                for (derivative, &slot) in row.iter_mut().zip(&estimator.plan.slots) {
                    *derivative = (tape.sums[slot as usize] * scale).as_vec3();
                }
            }
        });
        Jacobian { radiance, derivatives }
    }

    /// The radiance of `pixels` under `appearance`, by the paths that `sampled_as` would draw (those
    /// of [`Tracer::render_pixels`] under the same seed): importance sampling with the appearance
    /// of another scene. Two appearances on the same paths differ by what differs in them and not by
    /// their noise.
    ///
    /// The mean is right if `sampled_as` reflects wherever `appearance` does: a group that is
    /// diffuse, glossy or a perfect mirror in one has to be so in the other, and not black.
    ///
    /// # Panics
    /// If an appearance has fewer materials than the scene has groups.
    #[expect(clippy::too_many_arguments, reason = "each is a different part of the question")]
    pub fn radiance_reweighted<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        sampled_as: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        pixels: &[u32],
        settings: &Settings,
        seen: Option<Lookup<'_>>,
    ) -> Vec<Rgb> {
        let sampled_as = sampled_as.into();
        let estimator = Estimator {
            transport: Transport::new(self, sampled_as, settings.max_bounces).ending_at(seen),
            plan: Plan::new(self, appearance.into(), sampled_as, &[]),
            camera,
            size,
            settings,
        };
        estimator.radiance(pixels)
    }
}

/// All that the estimates of the pixels share.
struct Estimator<'a> {
    /// Draws the paths.
    transport: Transport<'a>,
    /// What they are evaluated by.
    plan: Plan<'a>,
    camera: &'a Camera,
    size: (usize, usize),
    settings: &'a Settings,
}

impl Estimator<'_> {
    /// The number of paths that the sums of a pixel are over.
    fn paths(&self) -> f64 {
        f64::from(self.settings.spp.max(1))
    }

    /// The radiance of `pixels` and nothing else.
    fn radiance(&self, pixels: &[u32]) -> Vec<Rgb> {
        let chunk = |chunk: &[u32]| -> Vec<Rgb> {
            let mut tape = Tape::new(&self.plan);
            chunk.iter().map(|&pixel| self.pixel(pixel, &mut tape)).collect()
        };
        pixels.par_chunks(CHUNK).flat_map_iter(chunk).collect()
    }

    /// The radiance of one pixel; leaves the sums over its paths on the tape.
    fn pixel(&self, pixel: u32, tape: &mut Tape<'_>) -> Rgb {
        let Settings { spp, seed, .. } = *self.settings;
        let mut radiance = DVec3::ZERO;
        tape.sums.fill(DVec3::ZERO);
        for index in 0..spp {
            let mut sampler = Sampler::new(seed ^ STREAM, u64::from(pixel), index);
            let ray = camera_ray(self.camera, self.size, pixel, &mut sampler);
            if let Some(surface) = self.transport.surface(&ray) {
                let emission = self.transport.emission(&surface);
                tape.start(surface.group, emission);
                self.transport.walk(surface, -ray.direction, &mut sampler, 0, tape);
            } else {
                let (source, emission) = self.transport.background(ray.direction);
                tape.start(source, emission);
            }
            radiance += tape.finish().as_dvec3();
        }
        (radiance / self.paths()).as_vec3()
    }
}
