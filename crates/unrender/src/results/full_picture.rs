//! The re-rendering in all pixels of a photograph that was worked on in squares of them.

use super::with_recovered_materials;
use crate::Job;
use crate::engine::Recovered;
use unrender_recover::{Renderer, View};
use unrender_render::{Appearance, Integrator, Settings, Tracer};
use unrender_scene::{Material, RgbImage};

/// What the photograph's camera sees with what was `recovered` for `job`, radiance. `tell` hears the share done.
pub(crate) fn render(job: &Job, recovered: &Recovered, tell: &(dyn Fn(f64) + Sync)) -> RgbImage {
    let scene = with_recovered_materials(job, recovered);
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
