//! Which photograph to take next: what each candidate would add to the existing photographs.
//!
//! A candidate is a camera and the lamps that are off. Its photograph is rendered with the recovered materials,
//! gets the noise of the first photograph, and joins the others; one joint refinement gives the standard
//! deviations of all parameters with it, and another one those without it. So a prediction is only as right as the
//! materials, and it does not include errors of the model, which cannot be known before the photograph is taken.

mod candidates;
mod predicted;
mod synthetic;

pub use candidates::{Candidate, candidates};
pub use predicted::{GroupPrediction, Known, KnownGroup, Prediction};

use crate::problem::with_problem;
use crate::registered::RegisteredModel;
use crate::registration::{self, Alignment};
use crate::{Error, Job};
use unrender_formats::materials::MaterialsFile;
use unrender_photo::Exposure;
use unrender_recover::{GroupSpec, Observation, Observer, Options, Problem, Role};
use unrender_render::Tracer;
use unrender_scene::{Material, Rgb};

/// A job with its recovered materials.
pub struct RecoveredJob {
    job: Job,
    materials: Vec<Material>,
    registered: Vec<RegisteredModel>,
    tracer: Tracer,
    /// Scene radiance per unit of the developed photographs' values.
    exposure: Rgb,
}

impl RecoveredJob {
    /// `job`, whose scene has the materials of `found`, with the lights and exposures of `found`.
    pub fn new(mut job: Job, found: &MaterialsFile) -> Self {
        job.reduce();
        let indices: Vec<(usize, Rgb)> = job
            .scene
            .sources()
            .filter_map(|source| {
                let intensity = found.lights.get(source.name)?.intensity?;
                Some((source.index, Rgb::from_array(intensity)))
            })
            .collect();
        for (index, intensity) in indices {
            job.scene.strength_mut(index).into_iter().for_each(|strength| *strength = intensity);
        }
        let base = found.exposure.map_or(Rgb::ONE, Rgb::from_array);
        let is_open = job.project.exposure == Exposure::Auto;
        for k in 1..job.photographs() {
            if let Some(exposure) = found.photographs.get(k).and_then(|of| of.exposure) {
                let mut transfer = job.transfer_of(k).clone();
                transfer.exposure =
                    Rgb::from_array(exposure) / if is_open { base } else { Rgb::ONE };
                job.develop_again(k, transfer);
            }
        }
        let tracer = Tracer::new(&job.scene);
        let one = |k: usize| registration::register(&job.alone(k), &tracer, Alignment::Auto);
        let registered = (0..job.photographs()).map(one).collect();
        let materials = job.scene.materials();
        let exposure = if is_open { base } else { Rgb::ONE };
        Self { job, materials, registered, tracer, exposure }
    }

    /// The job.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// The standard deviations from the existing photographs.
    ///
    /// # Errors
    /// As those of a recovery.
    pub fn known_now(
        &self,
        options: &Options,
        observer: &mut dyn Observer,
    ) -> Result<Known, Error> {
        self.refined(&self.job, &self.registered, options, observer)
    }

    /// The standard deviations with a photograph by `candidate` in addition.
    ///
    /// # Errors
    /// As those of a recovery.
    pub fn known_with(
        &self,
        candidate: &Candidate,
        options: &Options,
        observer: &mut dyn Observer,
    ) -> Result<Known, Error> {
        let mut job = self.job.clone();
        let observation = self.first_observation();
        let (shot, registered) = synthetic::photograph(self, candidate, &observation, options.seed);
        job.further.push(shot);
        let mut all = self.registered.clone();
        all.push(registered);
        self.refined(&job, &all, options, observer)
    }

    fn first_observation(&self) -> Observation {
        let photo = &self.job.photo.radiance;
        let (width, height) = (photo.width(), photo.height());
        let first = &self.registered[0];
        first.observe((&self.job, 0), &self.tracer.geometry(&first.camera, width, height))
    }

    fn refined(
        &self,
        job: &Job,
        registered: &[RegisteredModel],
        options: &Options,
        observer: &mut dyn Observer,
    ) -> Result<Known, Error> {
        let refine = |problem: &Problem<'_>| {
            let std = unrender_recover::deviations_at(problem, &self.materials, options, observer)?;
            let pixels = &problem.observation.all_pixels_of_group;
            let group = |(spec, (std, pixels)): (&GroupSpec, (_, &Vec<u32>))| KnownGroup {
                name: spec.name.clone(),
                is_asked: spec.role == Role::Unknown,
                std,
                is_seen: !pixels.is_empty(),
            };
            Ok(Known(problem.groups.iter().zip(std.into_iter().zip(pixels)).map(group).collect()))
        };
        Ok(with_problem(job, &self.tracer, registered, (&[], None), refine)?)
    }
}
