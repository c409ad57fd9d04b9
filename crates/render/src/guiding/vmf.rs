//! Mixtures of von Mises-Fisher lobes (spherical Gaussians), for guiding directions:
//!
//! ```text
//! pdf(w) = kappa exp(kappa (w . axis - 1)) / (2 pi (1 - exp(-2 kappa)))      [Fisher 1953]
//! ```
//!
//! with `kappa = 1 / deviation^2`, sampled by inverting the distribution of `w . axis` [Jakob
//! 2012].

use crate::lanes::{Vec3x4, dot, set_lane};
use crate::surface::Frame;
use crate::turn;
use glam::{Vec3, Vec4};
use std::f32::consts::TAU;

/// Most lobes of a mixture. Half of it misses lamps in rooms with several; double of it makes each
/// evaluation twice as expensive.
pub(crate) const LOBES_MAX: usize = 4;
/// A lobe counts as zero where it is below `exp(-EXPONENT_MAX)` of its peak, 3e-8: the share of its
/// samples beyond that is below the rounding error of single precision. Half of it would cut the
/// density at 2e-4 of the peak and bias estimates; double of it evaluates exponentials in vain.
const EXPONENT_MAX: f32 = 17.3;
/// Bounds of a lobe's standard deviation, radians: narrower ones exceed single precision, wider
/// ones are hardly lobes.
const DEVIATION: [f32; 2] = [2e-3, 0.5];

/// One lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
struct VmfLobe {
    axis: Vec3,
    kappa: f32,
    norm: f32,
}

/// A mixture of up to `LOBES_MAX` lobes of equal weight, and the probability of using it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VmfMixture {
    lobes: [VmfLobe; LOBES_MAX],
    count: usize,
    /// The share of directions to draw from the mixture, if it has lobes.
    share: f32,
}

impl VmfLobe {
    fn new(axis: Vec3, deviation: f32) -> Self {
        let kappa = 1.0 / (deviation * deviation);
        Self { axis, kappa, norm: kappa / (TAU * (1.0 - (-2.0 * kappa).exp())) }
    }

    fn pdf(&self, wi: Vec3) -> f32 {
        // 1 - cos from the difference of the vectors, which keeps its digits near the axis.
        let exponent = 0.5 * self.kappa * (wi - self.axis).length_squared();
        if exponent > EXPONENT_MAX { 0.0 } else { self.norm * (-exponent).exp() }
    }

    fn sample(&self, u: [f32; 2]) -> Vec3 {
        let below = (-2.0 * self.kappa).exp();
        // 1 - cos theta, distributed as exp(-kappa (1 - cos)).
        let versine = -(1.0 - u[0] * (1.0 - below)).ln() / self.kappa;
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let (y, x) = turn::sin_cos(u[1]);
        let (tangent, bitangent) = self.axis.any_orthonormal_pair();
        self.axis * (1.0 - versine) + (tangent * x + bitangent * y) * sin
    }
}

impl VmfMixture {
    /// The mixture without lobes.
    pub const NONE: Self = Self {
        lobes: [VmfLobe { axis: Vec3::Z, kappa: 0.0, norm: 0.0 }; LOBES_MAX],
        count: 0,
        share: 0.2,
    };

    /// Lobes about the first `LOBES_MAX` of the `axes`, each with its standard deviation in
    /// radians in the tangent plane of the sphere, clamped to 0.002 to 0.5.
    pub fn towards(axes: &[(Vec3, f32)]) -> Self {
        let mut mixture = Self::NONE;
        for (axis, deviation) in axes {
            if let Some(axis) = axis.try_normalize() {
                _ = mixture.push(axis, deviation.clamp(DEVIATION[0], DEVIATION[1]));
            }
        }
        mixture
    }

    /// A mixture without lobes yet, to be used for `share` of the directions.
    pub(super) fn with_share(share: f32) -> Self {
        Self { share, ..Self::NONE }
    }

    /// Adds the lobe about `axis`; returns whether there is room for another one.
    pub(super) fn push(&mut self, axis: Vec3, deviation: f32) -> bool {
        if let Some(lobe) = self.lobes.get_mut(self.count) {
            *lobe = VmfLobe::new(axis, deviation);
            self.count += 1;
        }
        self.count < LOBES_MAX
    }

    /// The share of directions to draw from the mixture; zero without lobes.
    pub(crate) fn share(&self) -> f32 {
        if self.count == 0 { 0.0 } else { self.share }
    }

    fn all(&self) -> &[VmfLobe] {
        &self.lobes[..self.count]
    }

    /// The density of [`VmfMixture::sample`] over solid angle; zero without lobes.
    pub(crate) fn pdf(&self, wi: Vec3) -> f32 {
        let sum: f32 = self.all().iter().map(|lobe| lobe.pdf(wi)).sum();
        sum / self.count.max(1) as f32
    }

    /// Draws a direction; `pick` in [0, 1) chooses the lobe, of which there is at least one. The
    /// direction may lie below the surface.
    pub(crate) fn sample(&self, pick: f32, u: [f32; 2]) -> Vec3 {
        let lobe = ((pick * self.count as f32) as usize).min(self.count.saturating_sub(1));
        self.lobes[lobe].sample(u).normalize()
    }
}

/// The mixtures of four surfaces, one per lane, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VmfMixture4 {
    lobes: [VmfLobe4; LOBES_MAX],
    count: usize,
    share: Vec4,
}

/// One lobe of each of four mixtures; where a mixture has fewer lobes the norm is zero.
#[derive(Clone, Copy, Debug)]
struct VmfLobe4 {
    axis: Vec3x4,
    kappa: Vec4,
    /// The factor of the density, divided by the mixture's number of lobes.
    norm: Vec4,
}

impl VmfMixture4 {
    /// The mixtures of up to four surfaces, each with the frame that it is given in.
    pub(crate) fn new<'a>(surfaces: impl Iterator<Item = (&'a VmfMixture, &'a Frame)>) -> Self {
        let nothing = VmfLobe4 { axis: [Vec4::ZERO; 3], kappa: Vec4::ZERO, norm: Vec4::ZERO };
        let mut four = Self { lobes: [nothing; LOBES_MAX], count: 0, share: Vec4::ZERO };
        for (lane, (mixture, frame)) in surfaces.take(4).enumerate() {
            four.share[lane] = mixture.share();
            four.count = four.count.max(mixture.count);
            for (slot, lobe) in four.lobes.iter_mut().zip(mixture.all()) {
                set_lane(&mut slot.axis, lane, frame.world_from_local(lobe.axis));
                slot.kappa[lane] = lobe.kappa;
                slot.norm[lane] = lobe.norm / mixture.count as f32;
            }
        }
        four
    }

    /// For each surface the density over solid angle of the unit vector `wi` (world space) under
    /// the mixture and under cosine sampling, which has the density `cosine_pdf`, together.
    #[inline]
    pub(crate) fn pdf(&self, wi: Vec3x4, cosine_pdf: Vec4) -> Vec4 {
        let mut pdf = Vec4::ZERO;
        for lobe in &self.lobes[..self.count] {
            let away = [0, 1, 2].map(|i| wi[i] - lobe.axis[i]);
            let exponent = 0.5 * lobe.kappa * dot(away, away);
            let counts = exponent.cmple(Vec4::splat(EXPONENT_MAX));
            if counts.any() {
                pdf += Vec4::select(counts, lobe.norm * (-exponent).exp(), Vec4::ZERO);
            }
        }
        (1.0 - self.share) * cosine_pdf + self.share * pdf
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::FRAC_1_PI;

    #[test]
    fn a_mixture_has_few_lobes() {
        let axes = [(Vec3::Z, 0.1); 9];
        assert_eq!(VmfMixture::towards(&axes).count, LOBES_MAX);
        assert_eq!(VmfMixture::towards(&[(Vec3::ZERO, 0.1), (Vec3::NAN, 0.1)]), VmfMixture::NONE);
        assert_eq!(VmfMixture::towards(&[]).share(), 0.0);
    }

    #[test]
    fn four_mixtures_at_once_have_the_densities_of_each() {
        let frame = |z: Vec3| Frame::new(z.normalize(), Vec3::new(0.3, -0.2, 0.9), true);
        let frames = [Vec3::Z, Vec3::Y, Vec3::new(0.3, 0.4, 0.5), Vec3::NEG_X].map(frame);
        let axes =
            [(Vec3::Z, 0.3), (Vec3::new(0.5, 0.1, 0.4), 0.05), (Vec3::new(-0.4, 0.2, 0.9), 0.1)];
        let mixtures = [0, 1, 3].map(|count| VmfMixture::towards(&axes[..count]));
        // One lane is not there.
        let four = VmfMixture4::new(mixtures.iter().zip(&frames));
        let mut guided = 0;
        for k in 0..1000 {
            let [u, v, lane, _] = sobol_burley::sample_4d(k, 0, 3);
            let lane = (3.0 * lane) as usize;
            let local = if mixtures[lane].share() > 0.0 && k % 2 == 0 {
                mixtures[lane].sample(u, [v, 0.37])
            } else {
                Vec3::new(u - 0.5, v - 0.5, 0.6).normalize()
            };
            let cosine_pdf = local.z.max(0.0) * FRAC_1_PI;
            let wi = frames[lane].world_from_local(local);
            let share = mixtures[lane].share();
            let expected = (1.0 - share) * cosine_pdf + share * mixtures[lane].pdf(local);
            let found = four.pdf(wi.to_array().map(Vec4::splat), Vec4::splat(cosine_pdf))[lane];
            assert!((found - expected).abs() <= 1e-3 * expected, "{found} {expected}");
            guided += usize::from(expected > 2.0 * cosine_pdf);
        }
        assert!(guided > 100, "{guided}");
    }
}
