//! The model registered with the photograph.

use crate::Job;
use serde::{Deserialize, Serialize};
use unrender_recover::{Observation, Picture};
use unrender_register::Registration;
use unrender_render::GeometryBuffers;
use unrender_scene::{Camera, Image, Warnings};

/// The registration of the model, and the camera that the recovery uses.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct RegisteredModel {
    /// That camera.
    pub(crate) camera: Camera,
    /// The distance to an edge within which no pixel is valid.
    pub(crate) margins: Image<f32>,
    /// The registration with the given camera, if the photograph determines it.
    pub(crate) registration: Option<Registration>,
    /// Warnings for the user.
    pub(crate) warnings: Warnings,
}

impl RegisteredModel {
    /// The same, with warnings that begin with the name of the photograph, `called`.
    pub(crate) fn named(mut self, called: &str) -> Self {
        self.warnings.0.iter_mut().for_each(|warning| warning.insert_str(0, called));
        self
    }

    /// The `photograph` of `job` sorted by the groups of `geometry`, seen by its camera.
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
        for (index, counts) in
            job.counts(photograph, (&self.camera, geometry)).into_iter().enumerate()
        {
            // Pixels that are left out are not lower bounds either.
            picture.valid.pixels_mut()[index] &= counts;
            picture.saturated.pixels_mut()[index] &= counts;
        }
        Observation::with_margins(picture, geometry, &self.margins, job.scene.groups.len())
    }
}
