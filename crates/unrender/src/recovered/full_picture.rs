//! The re-rendering in all pixels of a photograph that was reduced to squares.

use super::Recovered;
use crate::Job;
use std::time::Instant;
use unrender_recover::{Renderer, View};
use unrender_render::{Appearance, Integrator, Settings, Tracer};
use unrender_scene::{Material, Rgb, RgbImage};

impl Recovered {
    /// Renders what each photograph's camera sees in all pixels of the photograph of `job`, for [`Recovered::full`].
    /// `tell` is called with the share done.
    pub fn render_full(&mut self, job: &Job, tell: &(dyn Fn(f64) + Sync)) {
        let started = Instant::now();
        let count = job.photographs();
        let picture = |k: usize| {
            let tell = |done: f64| tell((k as f64 + done) / count as f64);
            render(&job.alone(k), &self.alone(job, k), &tell)
        };
        self.full = (0..count).map(picture).collect();
        self.times.all += started.elapsed().as_secs_f64();
    }
}

fn render(job: &Job, recovered: &Recovered, tell: &(dyn Fn(f64) + Sync)) -> RgbImage {
    let mut scene = recovered.scene(job);
    job.off.iter().for_each(|source| scene.scale_source(*source as usize, Rgb::ZERO));
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
