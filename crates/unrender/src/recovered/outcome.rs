//! A recovery with its photograph: its camera, its scene and its pictures.

use super::alike;
use super::parts::{self, ObjectsSeen};
use crate::Job;
use crate::registered::RegisteredModel;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use unrender_formats::materials::PhotographEntry;
use unrender_paper::Paper;
use unrender_photo::{Exposure, develop};
use unrender_recover::{Options, Recovery};
use unrender_scene::{Camera, Image, Rgb, RgbImage, Scene};

/// A recovery, its options and its duration.
#[derive(Clone, Serialize, Deserialize)]
pub struct Recovered {
    /// The recovery.
    pub recovery: Recovery,
    /// Its options.
    pub options: Options,
    /// The settings of the paper's method, if it was that.
    pub paper: Option<Paper>,
    /// For each photograph the photometric parameters, if they were recovered.
    #[serde(with = "crate::as_json")]
    pub photographs: Vec<Option<PhotographEntry>>,
    /// The registration of the model with each photograph.
    pub(crate) registered: Vec<RegisteredModel>,
    /// The group of every pixel, or [`unrender_render::NOTHING`].
    pub group_map: Image<u32>,
    /// The object of every pixel, likewise.
    pub object_map: Image<u32>,
    /// The re-rendering in all pixels of each photograph, radiance, if it was requested and `recovery` has fewer.
    pub full: Vec<RgbImage>,
    /// The end of each stage of the work.
    pub times: Times,
}

/// Seconds since the beginning.
#[derive(Clone, Serialize, Deserialize)]
pub struct Times {
    /// Until the model was registered.
    pub registered: f64,
    /// Until the photometric parameters had converged.
    pub developed: f64,
    /// Until the end of each iteration.
    pub iterations: Vec<f64>,
    /// Until all was done.
    pub all: f64,
}

impl Recovered {
    /// For each group of `job` by its name: the names of those that agree with it. Groups that share a
    /// material in the project are not compared with each other.
    pub fn alike(&self, job: &Job) -> BTreeMap<&str, Vec<&str>> {
        let counts = |name: &str| !job.project.same_as.contains_key(name);
        let groups = self.recovery.groups.iter().filter(|group| counts(&group.name));
        alike::find(&groups.collect::<Vec<_>>())
    }

    /// For each group of `job` to be split by object, by its index: the objects of its parts, the one with the most pixels
    /// first. Groups that share a material in the project are examined one by one.
    pub fn parts(&self, job: &Job) -> BTreeMap<usize, Vec<Vec<usize>>> {
        // The photograph was developed with the stated exposure, or else with an exposure of one.
        let exposure = match job.project.exposure {
            Exposure::Fixed(_) => Rgb::ONE,
            Exposure::Auto => self.recovery.exposure,
        };
        let photograph = job.radiance_on_sheet().map(|value| exposure * *value);
        let (groups, map) = (&job.own_groups[..], &self.object_map);
        parts::find(&self.recovery, &ObjectsSeen { groups, map, photograph: &photograph })
    }

    /// The camera of the first photograph of `job` that the recovery used.
    pub fn camera(&self, job: &Job) -> Camera {
        job.camera_of_photograph(&self.registered[0].camera)
    }

    /// The same with one of the photographs of `job` alone.
    pub fn alone(&self, job: &Job, photograph: usize) -> Cow<'_, Self> {
        if job.photographs() == 1 {
            return Cow::Borrowed(self);
        }
        let sheet = job.sheet();
        let mut recovery = self.recovery.clone();
        recovery.rerendered = sheet.cut(&recovery.rerendered, photograph);
        recovery.noise = sheet.cut(&recovery.noise, photograph);
        recovery.noise_sample = sheet.cut(&recovery.noise_sample, photograph);
        recovery.status = sheet.cut(&recovery.status, photograph);
        Cow::Owned(Self {
            recovery,
            options: self.options.clone(),
            paper: self.paper,
            photographs: vec![self.photographs[photograph].clone()],
            registered: vec![self.registered[photograph].clone()],
            group_map: sheet.cut(&self.group_map, photograph),
            object_map: sheet.cut(&self.object_map, photograph),
            full: self.full.get(photograph).cloned().into_iter().collect(),
            times: self.times.clone(),
        })
    }

    /// Scene radiance per unit of linear value of a photograph of `job`, by channel.
    pub(crate) fn exposure_of(&self, job: &Job, photograph: usize) -> Rgb {
        match job.project.exposure {
            // The photographs were developed with the stated exposure, or one relative to it.
            Exposure::Fixed(_) => job.transfer_of(photograph).exposure,
            Exposure::Auto => job.transfer_of(photograph).exposure * self.recovery.exposure,
        }
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

    /// The re-rendering, radiance: in all pixels of the photograph if that was requested, else at
    /// the reduced size. With several photographs use [`Recovered::alone`].
    pub fn rerendered(&self) -> &RgbImage {
        self.full.first().unwrap_or(&self.recovery.rerendered)
    }

    /// The photograph of `job`, developed, at the same size.
    pub fn photo(&self, job: &Job) -> RgbImage {
        match &self.full[..] {
            [_, ..] => develop(&job.picture, &job.transfer).radiance,
            [] => job.photo.radiance.clone(),
        }
    }
}
