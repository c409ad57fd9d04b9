//! The model as it lies on the photograph.

use crate::Job;
use unrender_recover::{Observation, Picture};
use unrender_register::Registration;
use unrender_render::GeometryBuffers;
use unrender_scene::{Camera, Image, Warnings};

/// How the model lies, and with what camera the recovery goes on.
#[derive(Clone)]
pub(crate) struct RegisteredModel {
    /// That camera.
    pub(crate) camera: Camera,
    /// How close to an edge no pixel is valid.
    pub(crate) margins: Image<f32>,
    /// How the model lies under the camera as given, if the photograph shows it.
    pub(crate) registration: Option<Registration>,
    /// What the user should know.
    pub(crate) warnings: Warnings,
}

impl RegisteredModel {
    /// The same, whose warnings begin with what the photograph is `called`.
    pub(crate) fn named(mut self, called: &str) -> Self {
        self.warnings.0.iter_mut().for_each(|warning| warning.insert_str(0, called));
        self
    }

    /// The `photograph` of `job` sorted by the groups of `geometry`, which is what its camera sees.
    pub(crate) fn observe(
        &self,
        (job, photograph): (&Job, usize),
        geometry: &GeometryBuffers,
    ) -> Observation {
        let photo = job.photo_of(photograph);
        let mut picture = Picture {
            values: photo.radiance.clone(),
            valid: photo.valid.clone(),
            saturated: photo.saturated.clone(),
            quantisation_step: photo.quantisation_step.clone(),
        };
        for (index, counts) in job.counts(photograph, geometry).into_iter().enumerate() {
            // What does not count is no lower bound either.
            picture.valid.pixels_mut()[index] &= counts;
            picture.saturated.pixels_mut()[index] &= counts;
        }
        Observation::with_margins(picture, geometry, &self.margins, job.scene.groups.len())
    }
}
