//! The problem that a job poses to the recovery.

use crate::Job;
use crate::registered::RegisteredModel;
use crate::working_size::WholePhotographs;
use std::borrow::Cow;
use unrender_photo::Exposure;
use unrender_recover::{
    Detail, Expected, ExposureRule, GroupSpec, Like, Observation, PhotometricParameter, Problem,
    RecoverError, Renderer, Role, View, Views,
};
use unrender_remote::{Remote, Workers};
use unrender_render::Tracer;
use unrender_scene::{Environment, Material, Rgb, Scene};

/// Applies `solve` to the problem of `job`, whose model is `registered` with each photograph; `workers` may render for
/// it.
pub(crate) fn with_problem<T>(
    job: &Job,
    tracer: &Tracer,
    registered: &[RegisteredModel],
    (photometric_parameters, workers): (&[PhotometricParameter], Option<&dyn Workers>),
    solve: impl FnOnce(&Problem<'_>) -> Result<T, RecoverError>,
) -> Result<T, RecoverError> {
    let sheet = job.sheet();
    let scenes: Vec<Cow<'_, Scene>> = (0..registered.len()).map(|k| job.lit_in(k)).collect();
    let dark = scenes.iter().map(|scene| match scene {
        Cow::Borrowed(_) => None,
        Cow::Owned(scene) => Some(Tracer::new(scene)),
    });
    let dark: Vec<Option<Tracer>> = dark.collect();
    let mut observations = Vec::with_capacity(registered.len());
    let mut each: Vec<Box<dyn Renderer + '_>> = Vec::with_capacity(registered.len());
    for (k, registered) in registered.iter().enumerate() {
        let [_, _, width, height] = sheet.place(k);
        let tracer = dark[k].as_ref().unwrap_or(tracer);
        let view = View::new(tracer, &registered.camera, (width, height), job.scene.brdf);
        observations.push(registered.observe((job, k), view.geometry()));
        each.push(match workers {
            Some(workers) => Box::new(Remote::new(view, &scenes[k], workers)),
            None => Box::new(view),
        });
    }
    let observation = Observation::on_sheet(&sheet, observations);
    let renderer = if each.len() == 1 { each.remove(0) } else { Box::new(Views::new(each)) };
    let cameras = registered.iter().map(|registered| &registered.camera).collect();
    let whole = WholePhotographs { job, tracer, cameras };
    solve(&Problem {
        observation: &observation,
        renderer: &*renderer,
        groups: (0..job.scene.groups.len()).map(|group| spec(job, group)).collect(),
        exposure: exposure_rule(job),
        unknown_lights: job.unknown_lights.clone(),
        neighbouring_lights: neighbours(&job.scene),
        coloured_lights: job.project.coloured_sources(&job.scene),
        photometric_parameters,
        detail: (job.side > 1).then_some(&whole as &dyn Detail),
    })
}

/// The pairs of neighbouring parts of an environment in parts; columns close in a ring.
fn neighbours(scene: &Scene) -> Vec<[usize; 2]> {
    let first = scene.environment_parts().start;
    let [columns, rows] = scene.environment.as_ref().map_or([1, 1], Environment::parts);
    let part = |x: usize, y: usize| first + y * columns + x % columns;
    let all = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let pairs = all.flat_map(|(x, y)| {
        let right = [part(x, y), part(x + 1, y)];
        let below = (y + 1 < rows).then(|| [part(x, y), part(x, y + 1)]);
        std::iter::once(right).chain(below)
    });
    pairs.filter(|[a, b]| a != b).collect()
}

/// The project's statements about a group.
pub(crate) fn spec(job: &Job, group: usize) -> GroupSpec {
    let of_scene = &job.scene.groups[group];
    let anchored = job.project.used_anchor().filter(|a| a.group == of_scene.name);
    let (role, material) = if of_scene.is_emitter() {
        (Role::Emitter, of_scene.material.clone())
    } else if let Some(anchor) = anchored {
        (Role::Known, Material::diffuse(anchor.rho_d))
    } else if job.project.known.contains_key(&of_scene.name)
        || job.project.ignored.contains(&of_scene.name)
        || job.project.same_as.contains_key(&of_scene.name)
    {
        (Role::Known, of_scene.material.clone())
    } else {
        (Role::Unknown, of_scene.material.clone())
    };
    GroupSpec {
        name: of_scene.name.clone(),
        role,
        material,
        rungs: job.project.rungs_of(&of_scene.name),
        expected: expected(job, &of_scene.name),
    }
}

/// Bounds and initial values of the group `name`, and the group it is like.
fn expected(job: &Job, name: &str) -> Expected {
    let like = job.project.like.get(name).and_then(|like| {
        let group = job.scene.group_index(&like.group)?;
        Some(Like { group, within: f64::from(like.within) })
    });
    let expected = job.project.expected.get(name).copied().unwrap_or_default();
    Expected { like, ..expected }
}

fn exposure_rule(job: &Job) -> ExposureRule {
    let anchor = job.project.anchor.as_ref();
    let index = anchor.and_then(|a| job.scene.group_index(&a.group).map(|i| (i, a.rho_d)));
    match (job.project.exposure, index) {
        (Exposure::Auto, Some((group, rho_d))) => ExposureRule::Anchor { group, rho_d },
        _ => ExposureRule::Fixed(Rgb::ONE),
    }
}
