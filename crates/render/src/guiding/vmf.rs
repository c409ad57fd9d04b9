//! The mirror images that a surface looks for: a mixture of spherical Gaussians.

use super::{DEVIATION_MAX, DEVIATION_MIN};
use crate::lanes::{Vec3x4, dot, put};
use crate::surface::Frame;
use glam::{Vec3, Vec4};
use std::f32::consts::TAU;

/// Mirror images that one surface looks for at most: the strongest that it may see.
pub(super) const IMAGES_MAX: usize = 4;
/// Where the Gaussian is below `exp(-DEPTH_MAX)` of its peak, 3e-8, it counts as nothing.
const DEPTH_MAX: f32 = 17.3;

/// One spherical Gaussian on the sphere of directions (von Mises-Fisher):
/// `pdf = kappa exp(kappa (cos - 1)) / (2 pi (1 - exp(-2 kappa)))`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Image {
    axis: Vec3,
    kappa: f32,
    norm: f32,
}

/// The mirror images that one surface looks for: nothing, or a few Gaussians of equal weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Images {
    images: [Image; IMAGES_MAX],
    count: usize,
    /// The share of directions to draw towards them, if there are any.
    share: f32,
}

impl Image {
    fn new(axis: Vec3, deviation: f32) -> Self {
        let kappa = 1.0 / (deviation * deviation);
        Self { axis, kappa, norm: kappa / (TAU * (1.0 - (-2.0 * kappa).exp())) }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        // 1 - cos from the difference of the vectors, which keeps its digits near the axis.
        let depth = 0.5 * self.kappa * (wi - self.axis).length_squared();
        if depth > DEPTH_MAX { 0.0 } else { self.norm * (-depth).exp() }
    }

    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let below = (-2.0 * self.kappa).exp();
        // 1 - cos theta, distributed as exp(-kappa (1 - cos)).
        let versine = -(1.0 - u[0] * (1.0 - below)).ln() / self.kappa;
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (y, x) = (TAU * u[1]).sin_cos();
        let (tangent, bitangent) = self.axis.any_orthonormal_pair();
        self.axis * (1.0 - versine) + (tangent * x + bitangent * y) * sin
    }
}

impl Images {
    /// No mirror image anywhere.
    pub const NONE: Self = Self {
        images: [Image { axis: Vec3::Z, kappa: 0.0, norm: 0.0 }; IMAGES_MAX],
        count: 0,
        share: 0.2,
    };

    /// Gaussians about the first few of the `axes`, each with its standard deviation in radians
    /// (within reason) on the sphere's tangent plane, all of equal weight.
    pub fn towards(axes: &[(Vec3, f32)]) -> Self {
        let mut images = Self::NONE;
        for (axis, deviation) in axes {
            if let Some(axis) = axis.try_normalize() {
                _ = images.push(axis, deviation.clamp(DEVIATION_MIN, DEVIATION_MAX));
            }
        }
        images
    }

    /// None yet, and the share of directions to draw towards those that come.
    pub(super) fn with_share(share: f32) -> Self {
        Self { share, ..Self::NONE }
    }

    /// Adds the Gaussian about `axis`; false if there is no room for another.
    pub(super) fn push(&mut self, axis: Vec3, deviation: f32) -> bool {
        if let Some(image) = self.images.get_mut(self.count) {
            *image = Image::new(axis, deviation);
            self.count += 1;
        }
        self.count < IMAGES_MAX
    }

    /// The share of directions to draw towards images.
    pub(crate) fn share(&self) -> f32 {
        if self.count == 0 { 0.0 } else { self.share }
    }

    fn all(&self) -> &[Image] {
        &self.images[..self.count]
    }

    /// The density of [`Images::sample`] over solid angle; zero without images.
    pub(crate) fn pdf(&self, wi: Vec3) -> f32 {
        let sum: f32 = self.all().iter().map(|image| image.pdf(wi)).sum();
        sum / self.count.max(1) as f32
    }

    /// Draws a direction; `pick` in [0, 1) chooses the image, of which there is at least one. It may
    /// fall below the surface.
    pub(crate) fn sample(&self, pick: f32, u: [f32; 2]) -> Vec3 {
        let image = ((pick * self.count as f32) as usize).min(self.count.saturating_sub(1));
        self.images[image].sample(u).normalize()
    }
}

/// The images of four surfaces side by side, in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Images4 {
    images: [Image4; IMAGES_MAX],
    count: usize,
    share: Vec4,
}

/// One image of each of four surfaces; one that a surface lacks has a norm of zero.
#[derive(Clone, Copy, Debug)]
struct Image4 {
    axis: Vec3x4,
    kappa: Vec4,
    /// Of its density, as one of its surface's images.
    norm: Vec4,
}

impl Images4 {
    /// Those of up to four surfaces, each with the frame that they are given in.
    pub(crate) fn new<'a>(surfaces: impl Iterator<Item = (&'a Images, &'a Frame)>) -> Self {
        let nothing = Image4 { axis: [Vec4::ZERO; 3], kappa: Vec4::ZERO, norm: Vec4::ZERO };
        let mut four = Self { images: [nothing; IMAGES_MAX], count: 0, share: Vec4::ZERO };
        for (lane, (images, frame)) in surfaces.take(4).enumerate() {
            four.share[lane] = images.share();
            four.count = four.count.max(images.count);
            for (slot, image) in four.images.iter_mut().zip(images.all()) {
                put(&mut slot.axis, lane, frame.world_from_local(image.axis));
                slot.kappa[lane] = image.kappa;
                slot.norm[lane] = image.norm / images.count as f32;
            }
        }
        four
    }

    /// For each surface the density over solid angle with which directions are drawn that are
    /// `cosine_pdf` by the cosine and along the unit vectors `wi` (world space) towards the images.
    #[inline]
    pub(crate) fn pdf(&self, wi: Vec3x4, cosine_pdf: Vec4) -> Vec4 {
        let mut pdf = Vec4::ZERO;
        for image in &self.images[..self.count] {
            let away = [0, 1, 2].map(|i| wi[i] - image.axis[i]);
            let depth = 0.5 * image.kappa * dot(away, away);
            let counts = depth.cmple(Vec4::splat(DEPTH_MAX));
            if counts.any() {
                pdf += Vec4::select(counts, image.norm * (-depth).exp(), Vec4::ZERO);
            }
        }
        (1.0 - self.share) * cosine_pdf + self.share * pdf
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::lambert;

    #[test]
    fn there_is_room_for_a_few_images_only() {
        let axes = [(Vec3::Z, 0.1); 9];
        assert_eq!(Images::towards(&axes).count, IMAGES_MAX);
        assert_eq!(Images::towards(&[(Vec3::ZERO, 0.1), (Vec3::NAN, 0.1)]), Images::NONE);
        assert_eq!(Images::towards(&[]).share(), 0.0);
    }

    #[test]
    fn four_surfaces_look_as_each_of_them_does() {
        let frame = |z: Vec3| Frame::new(z.normalize(), Vec3::new(0.3, -0.2, 0.9), true);
        let frames = [Vec3::Z, Vec3::Y, Vec3::new(0.3, 0.4, 0.5), Vec3::NEG_X].map(frame);
        let axes =
            [(Vec3::Z, 0.3), (Vec3::new(0.5, 0.1, 0.4), 0.05), (Vec3::new(-0.4, 0.2, 0.9), 0.1)];
        let images = [0, 1, 3].map(|count| Images::towards(&axes[..count]));
        // One lane is not there.
        let four = Images4::new(images.iter().zip(&frames));
        let mut seen = 0;
        for k in 0..1000 {
            let [u, v, lane, _] = sobol_burley::sample_4d(k, 0, 3);
            let lane = (3.0 * lane) as usize;
            let local = if images[lane].share() > 0.0 && k % 2 == 0 {
                images[lane].sample(u, [v, 0.37])
            } else {
                lambert::sample([u, v])
            };
            let cosine_pdf = lambert::pdf(local);
            let wi = frames[lane].world_from_local(local);
            let share = images[lane].share();
            let expected = (1.0 - share) * cosine_pdf + share * images[lane].pdf(local);
            let found = four.pdf(wi.to_array().map(Vec4::splat), Vec4::splat(cosine_pdf))[lane];
            assert!((found - expected).abs() <= 1e-3 * expected, "{found} {expected}");
            seen += usize::from(expected > 2.0 * cosine_pdf);
        }
        assert!(seen > 100, "{seen}");
    }
}
