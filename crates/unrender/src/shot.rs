//! The photographs of a job, one or several.

use crate::Job;
use crate::project::Project;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use unrender_formats::picture::Picture;
use unrender_photo::{Photo, Transfer};
use unrender_recover::Sheet;
use unrender_scene::{Camera, Image, Rgb, RgbImage, Scene};

/// A further photograph of a job, with the same data that [`Job`] has of the first.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shot {
    /// The project with this photograph alone.
    pub project: Project,
    /// As [`Job::camera`].
    pub camera: Camera,
    /// As [`Job::picture`].
    pub picture: Picture,
    /// As [`Job::photo`]; if the exposure is unknown, at the present estimate.
    pub photo: Photo,
    /// As [`Job::mask`].
    pub mask: Option<Image<bool>>,
    /// As [`Job::transfer`].
    pub transfer: Transfer,
    /// As [`Job::off`].
    pub off: Vec<u32>,
}

impl Job {
    /// The number of its photographs.
    pub fn photographs(&self) -> usize {
        1 + self.further.len()
    }

    /// The same with `photograph` alone.
    pub fn alone(&self, photograph: usize) -> Cow<'_, Self> {
        if self.further.is_empty() {
            return Cow::Borrowed(self);
        }
        let shot = match photograph.checked_sub(1) {
            Some(further) => self.further[further].clone(),
            None => self.first(),
        };
        let Shot { project, camera, picture, photo, mask, transfer, off } = shot;
        Cow::Owned(Self {
            scene: self.scene.clone(),
            camera,
            picture,
            photo,
            side: self.side,
            mask,
            transfer,
            project,
            off,
            further: Vec::new(),
            unknown_lights: self.unknown_lights.clone(),
            own_groups: self.own_groups.clone(),
            warnings: self.warnings.clone(),
        })
    }

    /// The scene in the light of `photograph`: lamps that were off emit nothing.
    pub(crate) fn lit_in(&self, photograph: usize) -> Cow<'_, Scene> {
        let off = photograph.checked_sub(1).map_or(&self.off, |further| &self.further[further].off);
        self.lit_without(off)
    }

    /// The scene in which the lamps `off` emit nothing.
    pub(crate) fn lit_without(&self, off: &[u32]) -> Cow<'_, Scene> {
        if off.is_empty() {
            return Cow::Borrowed(&self.scene);
        }
        let mut scene = self.scene.clone();
        off.iter().for_each(|source| scene.scale_source(*source as usize, Rgb::ZERO));
        Cow::Owned(scene)
    }

    fn first(&self) -> Shot {
        Shot {
            project: Project { further: Vec::new(), ..self.project.clone() },
            camera: self.camera.clone(),
            picture: self.picture.clone(),
            photo: self.photo.clone(),
            mask: self.mask.clone(),
            transfer: self.transfer.clone(),
            off: self.off.clone(),
        }
    }

    /// Sets the transfer function of the job's `photograph` and its radiance by it; everything else stays.
    pub(crate) fn develop_again(&mut self, photograph: usize, transfer: Transfer) {
        let photo = self.developed(photograph, &transfer);
        match photograph.checked_sub(1) {
            Some(further) => {
                let shot = &mut self.further[further];
                (shot.photo, shot.transfer) = (photo, transfer);
            }
            None => (self.photo, self.transfer) = (photo, transfer),
        }
    }

    /// The transfer function of `photograph`.
    pub(crate) fn transfer_of(&self, photograph: usize) -> &Transfer {
        photograph.checked_sub(1).map_or(&self.transfer, |further| &self.further[further].transfer)
    }

    /// The developed `photograph`.
    pub(crate) fn photo_of(&self, photograph: usize) -> &Photo {
        photograph.checked_sub(1).map_or(&self.photo, |further| &self.further[further].photo)
    }

    /// The file of `photograph`.
    pub(crate) fn picture_of(&self, photograph: usize) -> &Picture {
        photograph.checked_sub(1).map_or(&self.picture, |further| &self.further[further].picture)
    }

    /// The mask of `photograph`.
    pub(crate) fn mask_of(&self, photograph: usize) -> Option<&Image<bool>> {
        let further = photograph.checked_sub(1).map(|further| &self.further[further]);
        further.map_or(&self.mask, |shot| &shot.mask).as_ref()
    }

    /// The places of its photographs in the pictures of a recovery, at their working size.
    pub fn sheet(&self) -> Sheet {
        let size = |k: usize| {
            let radiance = &self.photo_of(k).radiance;
            (radiance.width(), radiance.height())
        };
        Sheet::of(&(0..self.photographs()).map(size).collect::<Vec<_>>())
    }

    /// The radiance of all photographs on their sheet.
    pub(crate) fn radiance_on_sheet(&self) -> RgbImage {
        let each = (0..self.photographs()).map(|k| &self.photo_of(k).radiance);
        self.sheet().stack(each, &Rgb::ZERO)
    }

    /// The name of `photograph` at the start of messages about it; empty if there is only one.
    pub(crate) fn called(&self, photograph: usize) -> String {
        if self.further.is_empty() {
            return String::new();
        }
        let path = match photograph.checked_sub(1) {
            Some(further) => &self.further[further].project.photo,
            None => &self.project.photo,
        };
        let name = path.file_name().unwrap_or(path.as_os_str());
        format!("{}: ", name.to_string_lossy())
    }
}
