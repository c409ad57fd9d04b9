//! A recovery with the photograph that it was of: its camera, its scene and its pictures.

use crate::Job;
use crate::registered::RegisteredModel;
use unrender_formats::materials::PhotographEntry;
use unrender_photo::develop;
use unrender_recover::{Options, Recovery};
use unrender_scene::{Camera, Image, RgbImage, Scene};

/// A recovery, how it was asked for and how long it took.
pub struct Recovered {
    /// What came out.
    pub recovery: Recovery,
    /// How it was asked for.
    pub options: Options,
    /// The numbers of the camera, where they were asked for.
    pub photograph: Option<PhotographEntry>,
    /// How the model was found to lie on the photograph.
    pub(crate) registered: RegisteredModel,
    /// The group of every pixel, or [`unrender_render::NOTHING`].
    pub group_map: Image<u32>,
    /// The object of every pixel, likewise.
    pub object_map: Image<u32>,
    /// The re-rendering in all pixels of the photograph, radiance, where it was asked for and `recovery` has fewer.
    pub full: Option<RgbImage>,
    /// When each part of the work was done.
    pub times: Times,
}

/// Seconds since the beginning.
pub struct Times {
    /// Until the model lay on the photograph.
    pub registered: f64,
    /// Until the camera's numbers were near enough.
    pub developed: f64,
    /// Until the end of each iteration.
    pub iterations: Vec<f64>,
    /// Until all was done.
    pub all: f64,
}

impl Recovered {
    /// The camera of the photograph of `job` that the recovery went on with.
    pub fn camera(&self, job: &Job) -> Camera {
        job.camera_of_photograph(&self.registered.camera)
    }

    /// The scene of `job` with the recovered materials and lights.
    pub fn scene(&self, job: &Job) -> Scene {
        let mut scene = job.scene.clone();
        for (object, group) in scene.objects.iter_mut().zip(&job.own_groups) {
            object.group = *group;
        }
        for (group, result) in scene.groups.iter_mut().zip(&self.recovery.groups) {
            group.material = result.material.clone();
        }
        for light in &self.recovery.lights {
            scene.scale_source(light.source, light.factor);
        }
        scene
    }

    /// The re-rendering, radiance: in all pixels of the photograph where that was asked for, else at the size at which it
    /// was worked on.
    pub fn rerendered(&self) -> &RgbImage {
        self.full.as_ref().unwrap_or(&self.recovery.rerendered)
    }

    /// The photograph of `job`, developed, at the same size.
    pub fn photo(&self, job: &Job) -> RgbImage {
        match &self.full {
            Some(_) => develop(&job.picture, &job.transfer).radiance,
            None => job.photo.radiance.clone(),
        }
    }
}
