//! Whether a group has a texture, and what lobe lies over it: texels from some of its pixels predict the others better than
//! a uniform reflectance does, through the same light.
//!
//! A texture explains every pixel that it is fitted to, so only pixels that it was not fitted to speak for it [Stone 1974]. The pixels
//! are those of a checkerboard; one half is fitted, the other is predicted, and the reverse. With a lobe `S` and the light
//! `D` on a white base of the mean reflectance `m`, the models of a pixel are
//!
//! ```text
//! uniform:   D m (1 + g) + S       or the best uniform reflectance, and D m g
//! textured:  D m (1 + g + t) + S
//! ```
//!
//! where `g` changes slowly over the picture, as errors of the light do, and `t` are texels. Both are from the fitted half.
//! The square of what is left is a product of two renderings, so that their noise is neither a gain nor a loss.
//!
//! The lobe of a plastic has one number, its roughness, since Fresnel's equations fix how strong it is. It is the one under
//! which texels that repeat predict best, across large squares and without `g`: the same texels are seen in and out of the
//! highlight.
//!
//! Squares count in units of the variance that the best uniform reflectance leaves around them: where a highlight or the edge
//! of a shadow is modelled badly, what is left is large under every model, and says little.

use super::both;
use super::footprint::{Footprint, Rows, lattice};
use super::lit::{Lit, mean};
use super::near::Near;
use super::texels::{Prior, Texels};
use crate::compare::{CERTAIN, Measured, WORSE};
use glam::DVec3;
use unrender_render::GeometryBuffers;
use unrender_scene::Rgb;

/// How pixels are fitted and predicted in turn.
struct Scale {
    /// The side of the squares of the checkerboard, pixels.
    square: usize,
    /// The pixels between what is fitted and what is predicted: noise of a compressed photograph is alike in neighbours.
    gap: usize,
    /// Errors of the light change over this many pixels, a standard deviation; zero if there are none.
    slow: f32,
    /// The share of the usual variance of a pixel that every one has at least.
    even: f32,
    /// So many times the usual contrast makes a texture.
    contrast: f64,
    /// Squares are summed over squares of so many pixels along each side, which are taken as independent.
    independent: usize,
}

/// A texture that repeats is predicted across large squares; one that is smooth, too, across small ones with a gap. With a
/// double `slow` a lobe that is not modelled passes for a texture of 3 % contrast; at none noise of the light does. A picture
/// of a few hundred pixels is predicted from neighbours alone, where much else may be, so that it has to have more contrast:
/// at twice as much fine grain is missed, at two thirds uniform groups of a room of metal have a texture.
const SCALES: [Scale; 3] = [
    Scale { square: 16, gap: 1, slow: 10.0, even: 0.0, contrast: 1.0, independent: 16 },
    Scale { square: 4, gap: 1, slow: 6.0, even: 0.0, contrast: 1.0, independent: 8 },
    Scale { square: 2, gap: 0, slow: 16.0, even: 1.0, contrast: 3.0, independent: 2 },
];
/// What repeats is predicted across squares in which a highlight comes and goes. In squares of half the side neighbours
/// predict the highlight, too; in double ones too few are left.
const REPEATS: Scale =
    Scale { square: 16, gap: 1, slow: 0.0, even: 0.0, contrast: 1.0, independent: 16 };
/// How much alike neighbouring texels may be asked to be: the one that predicts best counts. One alone misses fine or faint
/// textures.
const ALIKE: [f32; 3] = [0.1, 1.0, 10.0];
/// The same where lobes are compared: a tenth of it moves the roughness of a public room's floor from 0.09 to 0.1; ten
/// times was not tried.
const ALIKE_REPEATED: f32 = 1.0;
/// How small texels are asked to be, in units of a texel's mean weight: where nothing is known, nothing is predicted. Half
/// and double of it were not tried.
const SMALL: f32 = 0.05;
/// Texels along a pixel, of the sharper ones. Double of it takes four times as long; half of it misses fine patterns.
const DENSITY: f32 = 1.0;
/// Texels along a side at most: the pixels that are looked at show no more. Half and double of it were not tried.
const SIDE_MAX: f32 = 1024.0;
/// Rounds in which the slow part and the texels are fitted in turn. One leaves a part of the texture to the slow one; more
/// change nothing.
const ROUNDS: usize = 2;
/// Relative residuals count up to so many robust standard deviations: a highlight in a single place is no certainty, however
/// bright it is. Half and double of it were not tried.
const FAR: f32 = 4.0;
/// What the best uniform reflectance leaves is averaged over so many pixels around, a standard deviation: less follow single
/// pixels, which then count most where they are explained by chance; more do not tell a highlight's place from others. Half and
/// double of it were not tried.
const AROUND: f32 = 6.0;

/// The roughnesses that are tried, closer to each other than the photograph can tell. Smoother lobes are nearly mirrors,
/// whose images no texels predict.
pub(super) const ALPHAS: [f32; 7] = [0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4];

/// What texels predict of a group.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pattern {
    /// The root mean square of the predicted part of the reflectance, relative, less where it is predicted from neighbours
    /// alone; negative where the prediction is worse.
    pub(crate) contrast: f64,
    /// The squares that are explained, in units of their variance.
    pub(crate) gain: f64,
    /// The standard deviation of that, from square to square.
    pub(crate) deviation: f64,
    /// How many standard deviations it is by the ranks of the squares: a texture is everywhere.
    pub(crate) certainty: f64,
    /// The contrast that there may be, by [`WORSE`] of these.
    pub(crate) at_most: f64,
}

impl Pattern {
    /// The same for the record, of a texture that `holds` or does not: the squares have to gain the price, which is that of
    /// the `least` contrast.
    pub(crate) fn measured(&self, holds: bool, least: f64) -> Measured {
        let share = (least.min(1e6) / self.contrast.abs().max(1e-6)).powi(2);
        let price = share * self.gain.abs();
        // What makes the difference so many deviations as it is by ranks; of either sign they may differ.
        let certainty = (self.gain.signum() * self.certainty).max(1e-3);
        Measured { holds, difference: -self.gain, deviation: self.gain.abs() / certainty, price }
    }

    /// Whether it is a texture of at least this contrast.
    pub(crate) fn is_texture(&self, least: f64) -> bool {
        self.contrast > least && self.certainty > WORSE
    }
}

/// The contrast that any of `all` may have.
fn at_most(all: &[Pattern]) -> f64 {
    all.iter().map(|of| of.at_most).fold(f64::NEG_INFINITY, f64::max)
}

/// A group's pixels, by which its textures are judged.
pub(super) struct Judge {
    near: Near,
    texels: Texels,
    /// The radiance of a diffuse surface of the mean reflectance, in which all residuals are measured.
    unit: Vec<Rgb>,
    /// What uniform reflectances leave of the photograph, in this unit, twice.
    uniform: Vec<[Vec<Rgb>; 2]>,
    /// The mean square of what the best of them leaves around each pixel.
    variance: Vec<f32>,
}

impl Judge {
    /// Of the pixels of `plain`, which has no lobe and of which uniform reflectances show `uniform`, twice; none without
    /// texture coordinates.
    pub(super) fn of(
        plain: &Lit,
        uniform: &[[Vec<Rgb>; 2]],
        geometry: &GeometryBuffers,
    ) -> Option<Self> {
        let footprint = |pixel: &u32| Footprint::of(geometry, *pixel as usize);
        let footprints: Vec<Footprint> = plain.pixels.iter().map(footprint).collect();
        let lattice = lattice(&footprints, DENSITY, SIDE_MAX)?;
        let texels = Texels::new(Rows::of(&footprints, lattice), lattice);
        let near = Near::of(&plain.pixels, geometry.width());
        let light = plain.light();
        let (mean, dark) = (mean_reflectance(&plain.shown, &light), dark(&light));
        let unit: Vec<Rgb> = light.iter().map(|d| mean * d.max(dark)).collect();
        let uniform: Vec<_> =
            uniform.iter().map(|shows| over(&plain.shown, shows, &unit)).collect();
        let around: Vec<Vec<f32>> = uniform.iter().map(|left| around(&near, left)).collect();
        let least = |i: usize| around.iter().map(|of| of[i]).fold(f32::INFINITY, f32::min);
        let variance = (0..unit.len()).map(least).collect();
        Some(Self { near, texels, unit, uniform, variance })
    }

    /// The roughness of the lobe under which texels that repeat predict best, by those of `lobes`, ascending; none if they
    /// do not certainly predict better than under the `plain` one. A highlight is in places, so that squares count by what
    /// they gain: by their ranks a wall's errors of light would be a lobe.
    pub(super) fn roughness(&self, plain: &Lit, lobes: &[(f32, Lit)]) -> Option<f32> {
        let weights = self.weights(&REPEATS);
        let left =
            |lit: &Lit| self.textured(&Relative::of(lit, self), &REPEATS, &weights, ALIKE_REPEATED);
        let all: Vec<Vec<f64>> = lobes.iter().map(|(_, lit)| left(lit)).collect();
        let alphas: Vec<f32> = lobes.iter().map(|(alpha, _)| *alpha).collect();
        let errors: Vec<f64> = all.iter().map(|left| left.iter().sum()).collect();
        let best = (0..errors.len()).min_by(|a, b| errors[*a].total_cmp(&errors[*b]))?;
        let gain = self.pattern(&REPEATS, &weights, [&left(plain), &all[best]]);
        (gain.gain > CERTAIN * gain.deviation).then(|| vertex(&alphas, &errors, best))
    }

    /// What texels under the lobe of `lit` predict beyond what uniform reflectances do.
    pub(super) fn predicted(&self, lit: &Lit) -> Pattern {
        let relative = Relative::of(lit, self);
        let of_scale = |scale: &Scale| {
            let weights = self.weights(scale);
            let mut uniform = vec![self.slow(&relative, scale, &weights)];
            uniform.extend(self.uniform.iter().map(|other| self.left(other, scale, &weights)));
            let of = |alike: &f32| {
                let textured = self.textured(&relative, scale, &weights, *alike);
                // The texture has to beat all of them.
                let beaten =
                    uniform.iter().map(|left| self.pattern(scale, &weights, [left, &textured]));
                beaten.min_by(|a, b| a.certainty.total_cmp(&b.certainty))
            };
            let all: Vec<Pattern> = ALIKE.iter().filter_map(of).collect();
            let best = all.iter().max_by(|a, b| a.gain.total_cmp(&b.gain))?;
            Some(Pattern {
                contrast: best.contrast / scale.contrast,
                at_most: at_most(&all) / scale.contrast,
                ..*best
            })
        };
        let all: Vec<Pattern> = SCALES.iter().filter_map(of_scale).collect();
        let most = at_most(&all);
        // The largest contrast of those that are certain.
        let rank = |of: &Pattern| (of.certainty > WORSE, of.contrast);
        let above = |a: &Pattern, b: &Pattern| {
            let ((a, of_a), (b, of_b)) = (rank(a), rank(b));
            a.cmp(&b).then(of_a.total_cmp(&of_b))
        };
        let found = all.into_iter().max_by(above).unwrap_or_default();
        Pattern { at_most: most, ..found }
    }

    /// The gain of the second of two models, pixel by pixel what they leave.
    fn pattern(&self, scale: &Scale, weights: &[f32], [before, after]: [&Vec<f64>; 2]) -> Pattern {
        let squares = self.near.squares(scale.independent);
        let mut sums = vec![0.0; squares.iter().max().map_or(0, |last| last + 1)];
        for ((before, after), square) in before.iter().zip(after).zip(&squares) {
            sums[*square] += before - after;
        }
        let gain: f64 = sums.iter().sum();
        let deviation = sums.iter().map(|sum| sum * sum).sum::<f64>().sqrt();
        let all: f64 = 3.0 * weights.iter().map(|weight| f64::from(*weight)).sum::<f64>();
        let contrast = |gain: f64| gain.signum() * (gain.abs() / all.max(1e-30)).sqrt();
        let at_most = contrast(gain + WORSE * deviation);
        let certainty = signed_rank(&sums);
        Pattern { contrast: contrast(gain), gain, deviation, certainty, at_most }
    }

    /// The weighted square that each pixel leaves under a light that may be wrong slowly; `left` twice by its halves.
    fn left(&self, left: &[Vec<Rgb>; 2], scale: &Scale, weights: &[f32]) -> Vec<f64> {
        let middle = mean(left);
        self.in_turn(scale, weights, |weights, predicted| {
            let slow = self.near.blurred(&middle, weights, scale.slow);
            predicted(&|i: usize| left.each_ref().map(|half| half[i] - slow[i]));
        })
    }

    /// The same of the mean reflectance under the lobe of `relative`.
    fn slow(&self, relative: &Relative, scale: &Scale, weights: &[f32]) -> Vec<f64> {
        self.in_turn(scale, weights, |weights, predicted| {
            let slow = self.near.blurred(&relative.base, weights, scale.slow);
            predicted(&|i: usize| relative.left(i, slow[i]));
        })
    }

    /// The same of texels that are `alike` to their neighbours.
    fn textured(
        &self,
        relative: &Relative,
        scale: &Scale,
        weights: &[f32],
        alike: f32,
    ) -> Vec<f64> {
        let n = relative.base.len();
        self.in_turn(scale, weights, |weights, predicted| {
            let mut now = vec![Rgb::ZERO; self.texels.places.len()];
            let (mut pattern, mut slow) = (vec![Rgb::ZERO; n], vec![Rgb::ZERO; n]);
            let less = |values: &[Rgb]| -> Vec<Rgb> {
                relative.base.iter().zip(values).map(|(r, v)| *r - *v).collect()
            };
            for _ in 0..if scale.slow > 0.0 { ROUNDS } else { 1 } {
                if scale.slow > 0.0 {
                    slow = self.near.blurred(&less(&pattern), weights, scale.slow);
                }
                let prior = Prior { alike, small: SMALL };
                now = self.texels.solve(&less(&slow), weights, prior, &now);
                pattern = self.texels.seen(&now);
            }
            predicted(&|i: usize| relative.left(i, slow[i] + pattern[i]));
        })
    }

    /// The weighted square of what each pixel leaves when it is predicted. `fit` gets the weights of those that are fitted,
    /// and tells what the others leave, twice.
    fn in_turn(
        &self,
        scale: &Scale,
        weights: &[f32],
        fit: impl Fn(&[f32], &mut dyn FnMut(&dyn Fn(usize) -> [Rgb; 2])),
    ) -> Vec<f64> {
        let inside = self.near.checkers(scale.square, scale.gap);
        let all = self.near.checkers(scale.square, 0);
        let far = |i: usize| Rgb::splat(far_of(self.variance[i].sqrt()));
        let mut squares = vec![0.0; weights.len()];
        for fitted in [0, 1] {
            let weight = |i: usize| if inside[i] == (fitted, true) { weights[i] } else { 0.0 };
            let of_fitted: Vec<f32> = (0..weights.len()).map(weight).collect();
            fit(&of_fitted, &mut |left| {
                for i in (0..weights.len()).filter(|i| all[*i].0 != fitted) {
                    let [a, b] = left(i).map(|half| half.clamp(-far(i), far(i)));
                    squares[i] = f64::from(weights[i] * (a * b).element_sum());
                }
            });
        }
        squares
    }

    /// Inverse variances: what the best uniform reflectance leaves around each pixel, and the even share of the usual one, and a
    /// percent.
    fn weights(&self, scale: &Scale) -> Vec<f32> {
        let mut sorted = self.variance.clone();
        sorted.sort_by(f32::total_cmp);
        let usual = scale.even * sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        self.variance.iter().map(|variance| 1.0 / (variance + usual + 1e-4)).collect()
    }
}

/// How many standard deviations the sum of the signed ranks of `values` is away from none [Wilcoxon 1945]. A few large ones, as
/// of a highlight in one place, are no certainty, and do not hide that of many small ones.
fn signed_rank(values: &[f64]) -> f64 {
    let mut by_size: Vec<f64> = values.iter().copied().filter(|value| *value != 0.0).collect();
    by_size.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let ranked = by_size.iter().zip(1..).map(|(value, rank)| value.signum() * f64::from(rank));
    let (sum, squares) = ranked.fold((0.0, 0.0), |(s, q), rank| (s + rank, q + rank * rank));
    sum / f64::max(squares, f64::MIN_POSITIVE).sqrt()
}

/// What is left of `shown` under a light, twice, in these units.
fn over(shown: &[Rgb], light: &[Vec<Rgb>; 2], unit: &[Rgb]) -> [Vec<Rgb>; 2] {
    light.each_ref().map(|half| {
        let pixels = shown.iter().zip(half).zip(unit);
        pixels.map(|((shown, light), unit)| (*shown - *light) / *unit).collect()
    })
}

/// The mean square around each pixel of what is `left`, twice, beside what changes slowly.
fn around(near: &Near, left: &[Vec<Rgb>; 2]) -> Vec<f32> {
    let middle = mean(left);
    let even = vec![1.0; middle.len()];
    let slow = near.blurred(&middle, &even, AROUND);
    let fast: Vec<Rgb> = middle.iter().zip(&slow).map(|(all, slow)| *all - *slow).collect();
    let far = far(&fast);
    let square = |r: &Rgb| Rgb::splat(r.clamp(-far, far).length_squared() / 3.0);
    let squares: Vec<Rgb> = fast.iter().map(square).collect();
    near.blurred(&squares, &even, AROUND).iter().map(|around| around.x).collect()
}

/// What a group shows relative to its mean reflectance under a lobe.
struct Relative {
    /// `(photograph - lobe) / (D m) - 1`.
    base: Vec<Rgb>,
    /// The photograph less the lobe, in units, with each half of the lobe's light.
    under: [Vec<Rgb>; 2],
    /// Each half of `D m`, in units.
    light: [Vec<Rgb>; 2],
}

impl Relative {
    fn of(lit: &Lit, judge: &Judge) -> Self {
        let (light, under) = (lit.light(), lit.under());
        let (m, dark) = (mean_reflectance(&under, &light), dark(&light));
        let pixels = under.iter().zip(&light);
        let base: Vec<Rgb> = pixels.map(|(b, d)| *b / (m * d.max(dark)) - 1.0).collect();
        let far = far(&base);
        let base = base.into_iter().map(|r| r.clamp(-far, far)).collect();
        let white = lit.base.each_ref().map(|half| {
            half.iter().zip(&judge.unit).map(|(light, unit)| m * *light / *unit).collect()
        });
        Self { base, under: over(&lit.shown, &lit.shine, &judge.unit), light: white }
    }

    /// What is left of the pixel of this number with each half of the light, if it is so much brighter than the mean.
    fn left(&self, i: usize, brighter: Rgb) -> [Rgb; 2] {
        [0, 1].map(|half: usize| self.under[half][i] - self.light[half][i] * (1.0 + brighter))
    }
}

/// Where there is less of this `light`, a pixel says nothing: a thousandth of its mean.
fn dark(light: &[Rgb]) -> Rgb {
    1e-3 * light.iter().sum::<Rgb>() / light.len().max(1) as f32
}

/// The diffuse reflectance that explains `shown` best in this `light`.
fn mean_reflectance(shown: &[Rgb], light: &[Rgb]) -> Rgb {
    let [sum, power] = both(shown, light);
    (sum / power.max(DVec3::splat(1e-30))).as_vec3().max(Rgb::splat(1e-4))
}

/// So many robust standard deviations of `values`, and a little.
fn far(values: &[Rgb]) -> Rgb {
    let of = |channel: usize| {
        let mut sizes: Vec<f32> = values.iter().map(|value| value[channel].abs()).collect();
        let middle = sizes.len() / 2;
        if sizes.is_empty() {
            return 0.0;
        }
        far_of(*sizes.select_nth_unstable_by(middle, f32::total_cmp).1 / 0.6745)
    };
    Rgb::from_array([0, 1, 2].map(of))
}

/// So many of this standard deviation, and a little.
fn far_of(deviation: f32) -> f32 {
    FAR * deviation + 0.05
}

/// The least of a parabola through three of the `errors` about the least one, over the logarithms of `alphas`.
fn vertex(alphas: &[f32], errors: &[f64], least: usize) -> f32 {
    if least == 0 || least + 1 == errors.len() {
        return alphas[least];
    }
    let x = [least - 1, least, least + 1].map(|i| f64::from(alphas[i]).ln());
    let y = [errors[least - 1], errors[least], errors[least + 1]];
    let (left, right) = ((y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1]));
    let curvature = (right - left) / (0.5 * (x[2] - x[0]));
    let at = 0.5 * (x[0] + x[1]) - left / curvature;
    at.clamp(x[0], x[2]).exp() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_small_gains_are_certain_and_one_large_gain_is_not() {
        let alternate = |i: usize| if i.is_multiple_of(2) { 0.1 } else { -0.1 };
        let one: Vec<f64> = (0..60).map(|i| if i == 7 { 1e3 } else { alternate(i) }).collect();
        assert!(signed_rank(&one).abs() < 1.0);
        let many: Vec<f64> = (0..60).map(|i| if i == 7 { -1e3 } else { 0.1 }).collect();
        assert!(signed_rank(&many) > CERTAIN && many.iter().sum::<f64>() < 0.0);
        // All of n alike: sqrt(3 n (n + 1) / (2 (2 n + 1))).
        let expected = f64::sqrt(3.0 * 60.0 * 61.0 / (2.0 * 121.0));
        assert!((signed_rank(&[2.0; 60]) - expected).abs() < 1e-9);
        assert!(signed_rank(&[0.0; 4]).abs() < f64::EPSILON);
    }
}
