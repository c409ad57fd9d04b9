//! Identifiability: what the photograph determines of a group, estimated before anything is
//! recovered: a first gathering of light with few rays in the scene as guessed so far, twice with
//! independent noise.
//!
//! With the white diffuse surface's radiance `D` and that of Ward's lobe `S` (`rho_s = 1`, one of
//! [`ALPHAS`]), a group shows its roughness if `S` varies over its pixels in a way that `D` does not:
//! [`contrast`] is the standard deviation of `S - c D` relative to the mean of `D`, with the `c` that
//! minimises it. Light straight from lamps makes highlights, all other light mirror images.
//!
//! If the response is right, the photograph `P` of a diffuse surface is proportional to `D`: the
//! slope of `ln P` over `ln D` is one; it is near 1/2.2 for encoded values that were taken as linear,
//! and near 2.2 for linear ones that were decoded.

use unrender_recover::evidence::{Evidence, SampleBudget};
use unrender_recover::observe::model_error::{Allowance, LightError, ModelError};
use unrender_recover::observe::sample::Stage;
use unrender_render::{Appearance, ProbeSettings, ProposalLobe};
use unrender_scene::Rgb;
use unrender_scene::color::luminance;

/// The roughnesses that are tried: fine enough for mirror images, and wide enough for highlights.
const ALPHAS: [f32; 2] = [0.05, 0.1];
/// Reflections that are followed: in middle grey the rest carries a sixteenth of the light.
const BOUNCES: u32 = 4;
/// The allowance for errors in a scene of unknown reflectances.
const ALLOWANCE: Allowance =
    Allowance { light: LightError { share: 0.1 }, floor: ModelError { share: 0.01 } };
/// Directions in which each pixel's light is sampled, for diffuse surfaces and for each lobe.
const COSINE: u32 = 8;
const PER_LOBE: u32 = 8;

/// What the photograph determines of one group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Identifiability {
    /// The share of its pixels, 0 to 1, that get light straight from a lamp.
    pub(super) lit: f32,
    /// The mean luminance of a white diffuse surface in its place, W sr^-1 m^-2.
    pub(super) light: f32,
    /// The photograph's mean luminance there, W sr^-1 m^-2.
    pub(super) photo: f32,
    /// How visible lamps would be in it: the [`contrast`] of a highlight.
    pub(super) highlight: f32,
    /// How visible its surroundings would be: the contrast of a mirror image.
    pub(super) image: f32,
    /// The slope of the photograph over the light, if both vary enough over the group.
    pub(super) slope: Option<f32>,
}

/// Examines `group` at no more than `count` of `pixels`. None if no ray hits it.
pub(super) fn identifiability(
    stage: &Stage<'_>,
    appearance: Appearance<'_>,
    group: usize,
    pixels: &[u32],
    (count, seed): (usize, u64),
) -> Option<Identifiability> {
    let gather = |max_bounces| {
        let probe = ProbeSettings {
            cosine: COSINE,
            per_lobe: PER_LOBE,
            lobes: ProposalLobe::round(&ALPHAS),
            keep_incident: true,
            seed,
            max_bounces,
            ..ProbeSettings::default()
        };
        Evidence::gather(
            stage,
            appearance,
            group,
            pixels,
            &SampleBudget { pixels: count, pixels_seed: probe.seed, allowance: ALLOWANCE, probe },
        )
    };
    // The same seed sends the same rays through the same pixels.
    let (direct, all) = (gather(1), gather(BOUNCES));
    if all.is_empty() {
        return None;
    }
    let of = |basis: [Vec<Rgb>; 2]| basis.map(|half| half.into_iter().map(luminance).collect());
    let light: [Vec<f32>; 2] = of(all.light.diffuse());
    let straight: [Vec<f32>; 2] = of(direct.light.diffuse());
    let shine = ALPHAS.map(|alpha| {
        let lobe =
            |of_light: &Evidence| -> [Vec<f32>; 2] { of(of_light.light.lobe(alpha, alpha, 0.0)) };
        let (highlight, mut image) = (lobe(&direct), lobe(&all));
        for (all, direct) in image.iter_mut().zip(&highlight) {
            all.iter_mut().zip(direct).for_each(|(all, direct)| *all -= direct);
        }
        [contrast(&highlight, &light), contrast(&image, &light)]
    });
    let most = |which: usize| shine[0][which].max(shine[1][which]);
    let photo: Vec<f32> = all.sample.pixels.iter().map(|pixel| luminance(pixel.radiance)).collect();
    let is_lit = |i: &usize| straight[0][*i] + straight[1][*i] > 0.0;
    Some(Identifiability {
        lit: (0..photo.len()).filter(is_lit).count() as f32 / photo.len() as f32,
        light: 0.5 * (mean(&light[0]) + mean(&light[1])),
        photo: mean(&photo),
        highlight: most(0),
        image: most(1),
        slope: slope(&photo, &light),
    })
}

/// The standard deviation of `values - c light` relative to the mean of `light`, for the best `c`;
/// both are given twice with independent noise, which cancels.
fn contrast(values: &[Vec<f32>; 2], light: &[Vec<f32>; 2]) -> f32 {
    let product = |a: &[f32], b: &[f32]| -> f64 {
        a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
    };
    let [[s, t], [d, e]] = [values, light].map(|both| both.each_ref().map(Vec::as_slice));
    let lights = product(d, e);
    if lights <= 0.0 {
        return 0.0;
    }
    let share = 0.5 * (product(s, e) + product(t, d)) / lights;
    let left = product(s, t) - share * share * lights;
    let level = 0.5 * f64::from(mean(d) + mean(e));
    ((left.max(0.0) / s.len() as f64).sqrt() / level) as f32
}

/// The slope of the logarithm of `photo` over that of `light`. None if the light varies too little,
/// or if something else dominates the photograph.
fn slope(photo: &[f32], light: &[Vec<f32>; 2]) -> Option<f32> {
    /// A slope through fewer pixels is noise.
    const PIXELS_MIN: usize = 50;
    /// The least standard deviation of the light's logarithm: where light varies less, other influences
    /// dominate.
    const VARIES: f64 = 0.2;
    /// The least correlation of photograph and light for the light to dominate.
    const CORRELATED: f64 = 0.8;
    let [a, b] = light;
    let positive = |i: &usize| photo[*i].min(a[*i]).min(b[*i]) > 0.0;
    let counted: Vec<usize> = (0..photo.len()).filter(positive).collect();
    if counted.len() < PIXELS_MIN {
        return None;
    }
    let centred = |values: &[f32]| -> Vec<f64> {
        let logs: Vec<f64> = counted.iter().map(|&i| f64::from(values[i]).ln()).collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        logs.into_iter().map(|log| log - mean).collect()
    };
    let covariance = |x: &[f64], y: &[f64]| -> f64 {
        x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>() / x.len() as f64
    };
    let (photo, a, b) = (centred(photo), centred(a), centred(b));
    // The covariance of the two halves is free of noise, which would flatten the line.
    let lights = covariance(&a, &b);
    let both = 0.5 * (covariance(&photo, &a) + covariance(&photo, &b));
    if lights < VARIES * VARIES {
        return None;
    }
    let correlation = both / (lights * covariance(&photo, &photo)).sqrt();
    (correlation > CORRELATED).then_some((both / lights) as f32)
}

/// What shows a group's roughness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RoughnessCue {
    /// A lamp is visible in it.
    Highlight,
    /// Its surroundings are.
    Image,
    /// Both.
    Both,
    /// Whatever its roughness, it would look the same.
    Nothing,
}

impl Identifiability {
    /// A specular reflectance of a tenth on a surface of middle grey is visible from this contrast
    /// on: it changes the picture by 1 %.
    const SHOWS: f32 = 0.05;

    /// What roughness can be estimated from.
    pub(super) fn roughness_cue(&self) -> RoughnessCue {
        match (self.highlight > Self::SHOWS, self.image > Self::SHOWS) {
            (true, true) => RoughnessCue::Both,
            (true, false) => RoughnessCue::Highlight,
            (false, true) => RoughnessCue::Image,
            (false, false) => RoughnessCue::Nothing,
        }
    }
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `f` at hundred places, twice, with noise of the opposite sign.
    fn twice(f: impl Fn(f32) -> f32, noise: f32) -> [Vec<f32>; 2] {
        [1.0, -1.0].map(|sign: f32| {
            let at = |i: usize| {
                let alternating = if (i / 2).is_multiple_of(2) { noise } else { -noise };
                let own =
                    if sign > 0.0 || i.is_multiple_of(2) { alternating } else { -alternating };
                f(i as f32 / 99.0) + own
            };
            (0..100).map(at).collect()
        })
    }

    #[test]
    fn contrast_is_what_the_light_does_not_explain_without_the_noise() {
        let light = twice(|x| 1.0 + x, 0.0);
        assert!(contrast(&twice(|x| 3.0 * (1.0 + x), 0.0), &light) < 1e-3);
        assert!(contrast(&twice(|_| 0.0, 0.5), &light) < 0.1);
        // A peak of 1 on a tenth of the pixels: standard deviation 0.3, less the part correlated
        // with the light.
        let peak =
            contrast(&twice(|x| if (0.45..0.55).contains(&x) { 1.5 } else { 0.0 }, 0.0), &light);
        assert!((0.25..0.32).contains(&peak), "{peak}");
    }

    #[test]
    fn the_slope_tells_a_wrong_response() {
        let light = twice(|x| 0.5 + x, 0.0);
        for gamma in [1.0f32, 2.2, 1.0 / 2.2] {
            let photo: Vec<f32> = light[0].iter().map(|d| 0.3 * d.powf(gamma)).collect();
            let found = slope(&photo, &light).unwrap();
            assert!((found - gamma).abs() < 1e-3, "{found} for {gamma}");
        }
        let even = twice(|x| 1.0 + 0.1 * x, 0.0);
        assert_eq!(slope(&even[0], &even), None);
        let pattern = twice(|x| if (20.0 * x) as i32 % 2 == 0 { 0.1 } else { 1.0 }, 0.0);
        assert_eq!(slope(&pattern[0], &light), None);
    }
}
