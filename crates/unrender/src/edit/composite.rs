//! The composite: the change of a restaging in its photograph.

use super::Restaging;
use super::developed::Photograph;
use unrender_photo::clipping;
use unrender_recover::{Observation, PhotographNoise, Picture};
use unrender_render::{GeometryBuffers, Tracer};
use unrender_restage::composite::{self, Gain};
use unrender_restage::pair::Paired;
use unrender_restage::{grain, touched};
use unrender_scene::color::luminance;
use unrender_scene::{Image, Rgb, RgbImage};

/// The photograph with the change in it.
#[derive(Clone, Debug)]
pub struct Composite {
    /// The scene before and after, as the photograph's camera sees it.
    pub paired: Image<Paired>,
    /// The pixels of the photograph that the edits touch.
    pub touched: Image<bool>,
    /// Radiance, W sr^-1 m^-2 per channel.
    pub radiance: RgbImage,
}

impl Composite {
    /// Composites the change between the two renderings `paired` into the photograph; `grain` is
    /// the seed of noise for synthetic parts, if they get any.
    pub fn new(
        restaging: &Restaging,
        photograph: &Photograph,
        paired: Image<Paired>,
        gain: Gain,
        grain: Option<u64>,
    ) -> Self {
        let scene = &restaging.start.scene;
        let (width, height) = photograph.size();
        let geometry = Tracer::new(scene).geometry(&photograph.camera, width, height);
        let changes = touched::touched(&paired, &geometry, &photograph.photo.quantisation_step);
        let mut clipped = geometry.map(|_| false);
        for index in clipping::clipped_pixels(&photograph.picture, &photograph.transfer) {
            clipped.pixels_mut()[index] = true;
        }
        let seen = composite::Photograph {
            radiance: &photograph.photo.radiance,
            clipped: &clipped,
            geometry: &geometry,
            materials: &scene.materials(),
        };
        let mut radiance = composite::composite(&seen, &paired, &changes, gain);
        if let Some(seed) = grain {
            let noise = noise(photograph, &geometry, scene.groups.len());
            grain::add(&mut radiance, &paired, noise, seed);
        }
        let touched = changes.map(Option::is_some);
        Self { paired, touched, radiance }
    }

    /// The share of the pixels, 0 to 1, that differ from the `photograph` by more than half of what it shows there.
    pub fn changed_much(&self, photograph: &Photograph) -> f32 {
        /// Of what is shown. Half and double of it were not tried.
        const MUCH: f32 = 0.5;
        let before = photograph.photo.radiance.pixels();
        let is_much = |(after, before): &(&Rgb, &Rgb)| {
            (luminance(**after) - luminance(**before)).abs() > MUCH * luminance(**before)
        };
        let count = self.radiance.pixels().iter().zip(before).filter(is_much).count();
        count as f32 / before.len().max(1) as f32
    }

    /// The code values of the photograph's camera; pixels that are not touched keep those of the
    /// photograph to the bit.
    pub fn codes(&self, photograph: &Photograph) -> RgbImage {
        let mut codes = photograph.transfer.codes(&self.radiance);
        let old = photograph.picture.values.pixels();
        let pixels = codes.pixels_mut().iter_mut().zip(old).zip(self.touched.pixels());
        pixels.filter(|(_, touched)| !**touched).for_each(|((new, old), _)| *new = *old);
        codes
    }
}

/// The photograph's noise: its variance without light, and that per unit of radiance, the median over its groups.
fn noise(photograph: &Photograph, geometry: &GeometryBuffers, groups: usize) -> [Rgb; 2] {
    let photo = &photograph.photo;
    let picture = Picture {
        values: photo.radiance.clone(),
        valid: photo.valid.clone(),
        saturated: photo.saturated.clone(),
        quantisation_step: photo.quantisation_step.clone(),
    };
    let observation = Observation::new(picture, geometry, groups);
    let PhotographNoise { read, shot_of_group: shots } = &observation.noise_of_photograph[0];
    let median = |channel: usize| {
        let mut values: Vec<f32> = shots.iter().map(|s| s[channel]).filter(|s| *s > 0.0).collect();
        values.sort_by(f32::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    [*read, Rgb::new(median(0), median(1), median(2))]
}
