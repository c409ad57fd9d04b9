//! The re-rendering in all pixels of a photograph that was worked on in squares of them.

use super::Recovered;
use crate::Job;
use std::time::Instant;
use unrender_recover::{Renderer, View};
use unrender_render::{Appearance, Integrator, Settings, Tracer};
use unrender_scene::{Material, RgbImage};

impl Recovered {
    /// Renders what the photograph's camera sees in all pixels of the photograph of `job`, for [`Recovered::full`].
    /// `tell` hears the share done.
    pub fn render_full(&mut self, job: &Job, tell: &(dyn Fn(f64) + Sync)) {
        let started = Instant::now();
        self.full = Some(render(job, self, tell));
        self.times.all += started.elapsed().as_secs_f64();
    }
}

fn render(job: &Job, recovered: &Recovered, tell: &(dyn Fn(f64) + Sync)) -> RgbImage {
    let scene = recovered.scene(job);
    let (width, height) = job.photograph_size();
    let (tracer, camera) = (Tracer::new(&scene), recovered.camera(job));
    let view = View::new(&tracer, &camera, (width, height), scene.brdf);
    let materials: Vec<Material> =
        scene.groups.iter().map(|group| group.material.clone()).collect();
    let options = &recovered.options;
    let settings = Settings {
        together: unrender_render::settings::TOGETHER,
        first: 0,
        spp: options.effort.last_spp(width * height),
        seed: options.seed,
        max_bounces: options.max_bounces,
        integrator: Integrator::PathReuse,
    };
    let appearance = Appearance { materials: &materials, lights: &[] };
    RgbImage::new(width, height, view.picture(appearance, &settings, tell))
}
