//! The composite: the change of a restaging in its photograph.

use super::Restaging;
use super::developed::Photograph;
use unrender_photo::clipping;
use unrender_recover::{Observation, PhotographNoise, Picture};
use unrender_render::{Accumulator, GeometryBuffers, Tracer};
use unrender_restage::composite::{self, Gain, How};
use unrender_restage::pair::{self, Paired};
use unrender_restage::{grain, touched};
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
    /// How each pixel was made.
    how: Image<How>,
}

impl Composite {
    /// Composites the change between the two renderings in `layers` ([`pair::LAYERS`]) into the photograph, with the
    /// `denoised` picture after the edits where it shows something else; `grain` is the seed of noise for synthetic parts, if
    /// they get any.
    pub fn new(
        restaging: &Restaging,
        photograph: &Photograph,
        (layers, denoised): (&[Accumulator], Option<&RgbImage>),
        gain: Gain,
        grain: Option<u64>,
    ) -> Self {
        let scene = &restaging.start.scene;
        let (width, height) = photograph.size();
        let geometry = Tracer::new(scene).geometry(&photograph.camera, width, height);
        let mut paired = pair::smoothed(layers, &photograph.camera, &geometry);
        let after = denoised.cloned().unwrap_or_else(|| pair::after(&paired));
        if denoised.is_some() {
            let replaced = paired.pixels_mut().iter_mut().filter(|pixel| pixel.replaced == 1.0);
            replaced.for_each(|pixel| pixel.after_variance = Rgb::ZERO);
        }
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
        let composite::Composite { mut radiance, how } =
            composite::composite(&seen, (&paired, &after), &changes, gain);
        if let Some(seed) = grain {
            let noise = noise(photograph, &geometry, scene.groups.len());
            grain::add(&mut radiance, &paired, noise, seed);
        }
        let touched = changes.map(Option::is_some);
        Self { paired, touched, radiance, how }
    }

    /// How the pixels that changed were made, in words.
    pub fn in_words(&self) -> String {
        let changed = 1.0 - self.share(How::Untouched);
        if changed == 0.0 {
            return "No pixel changes.".to_owned();
        }
        let percent = |how: How| 100.0 * self.share(how) / changed;
        format!(
            "Of the pixels that change {:.0} % are those of the photograph times the ratio of the light, {:.0} % plus its \
             difference, {:.0} % show another surface.",
            percent(How::Ratio),
            percent(How::Difference),
            percent(How::Replaced)
        )
    }

    /// The share, 0 to 1, of the pixels that were made in this way.
    pub fn share(&self, how: How) -> f32 {
        let count = self.how.pixels().iter().filter(|own| **own == how).count();
        count as f32 / self.how.pixels().len().max(1) as f32
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
