//! The photograph's noise, estimated from the photograph itself.
//!
//! In the interior of a group the second difference of neighbouring pixels, `x_0 - (x_-1 + x_1) / 2`, holds
//! 3/2 of the noise's variance and little of the picture. It gives `variance = step^2/12 + r + s B`, quantisation,
//! read noise `r` and shot noise `s` [Foi et al. 2008].
//!
//! Read noise is what is left where there is no light: a dark group shows it. Without it the noise of a channel that a
//! group does not reflect would be zero under the right hypothesis, and only a texture could explain it.
//!
//! A camera has about the same `s` everywhere. Where a group's differences are far larger than those of most
//! pixels, they may be a pattern (a mirror image, a fine texture); or the photograph is a rendering, whose noise
//! is larger in some groups than in others. Noise is uncorrelated from one pixel to the next, a pattern is not: with
//! the second differences `V_1` of neighbours and `V_2` of every other pixel, the variance extrapolated to distance
//! zero is `2 V_1 - V_2` if that of the pattern grows in proportion to the distance, and less if it grows faster.
//! Geostatistics calls it the nugget effect [Matheron 1963]. That much is noise, however large.

use serde::{Deserialize, Serialize};
use unrender_scene::{Rgb, RgbImage};

/// The photograph's noise at one pixel: its variance is `base + slope L` where the scene has the
/// radiance `L`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Of quantisation and reading, squared radiance.
    pub base: Rgb,
    /// Of the shot noise, radiance.
    pub slope: Rgb,
}

impl Noise {
    /// No noise at all.
    pub const NONE: Self = Self { base: Rgb::ZERO, slope: Rgb::ZERO };

    /// The variance where the scene has the radiance `radiance`.
    pub fn variance(&self, radiance: Rgb) -> Rgb {
        self.base + self.slope * radiance.max(Rgb::ZERO)
    }

    /// That of one of so many pixels, of whose mean it is.
    pub(crate) fn of_one_in(&self, pixels: usize) -> Self {
        let times = pixels as f32;
        Self { base: times * self.base, slope: times * self.slope }
    }
}

/// A group's noise is not estimated from fewer differences than this: forty give it to a quarter. At half of
/// it chance rules in small groups, at double more of them have the noise of the others.
const DIFFERENCES_MIN: usize = 40;
/// Up to this many times the noise of most pixels a group's differences are taken as noise without another
/// look: the same camera took all groups. At half of it the noise of groups that lie a little above is measured by
/// the nugget, which is less exact; at double, mirror images and fine textures pass for noise.
const LIKE_OTHERS: f32 = 2.0;

/// The noise of a photograph beyond quantisation.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct PhotographNoise {
    /// Read noise: variance, squared value, per channel.
    pub read: Rgb,
    /// For each group its shot noise: variance per unit of value, per channel.
    pub shot_of_group: Vec<Rgb>,
}

impl PhotographNoise {
    /// That of the photograph's `values`, with the quantisation `steps`, and the pixels of each group in scanline
    /// order.
    pub(crate) fn of(
        (values, steps): (&RgbImage, &RgbImage),
        pixels_of_group: &[Vec<u32>],
    ) -> Self {
        let mut members = Members::of(values, steps, pixels_of_group);
        members.read = read_noise(&members);
        Self { read: members.read, shot_of_group: shot_of_groups(&members) }
    }
}

/// The variance without light: the least of a group, which is a dark one if there is any, less the shot noise that its
/// light has in most pixels.
fn read_noise(members: &Members<'_>) -> Rgb {
    let measured: Vec<Option<[Rgb; 2]>> = (0..members.pixels_of_group.len())
        .map(|group| members.beyond_quantisation(group, ALONG_ROWS, 1))
        .collect();
    let per_value = |measured: &Option<[Rgb; 2]>| {
        measured.map_or(Rgb::ZERO, |[variance, level]| {
            Rgb::select(level.cmpgt(Rgb::ZERO), variance / level, Rgb::ZERO)
        })
    };
    let shots: Vec<Rgb> = measured.iter().map(per_value).collect();
    let usual = of_most_pixels(&shots, members.pixels_of_group);
    let of_channel = |channel: usize| {
        let groups = measured.iter().flatten();
        let least = groups.min_by(|[a, _], [b, _]| a[channel].total_cmp(&b[channel]));
        let Some([variance, level]) = least.filter(|_| usual[channel].is_finite()) else {
            return 0.0;
        };
        (variance[channel] - usual[channel] * level[channel].max(0.0)).max(0.0)
    };
    Rgb::new(of_channel(0), of_channel(1), of_channel(2))
}

/// For each group its shot noise: that of most pixels where it is too small to tell. Far above that, only the uncorrelated
/// part is noise.
fn shot_of_groups(members: &Members<'_>) -> Vec<Rgb> {
    let pixels_of_group = members.pixels_of_group;
    let along_rows = |group| members.shot_noise(group, ALONG_ROWS, 1);
    let shots: Vec<Option<Rgb>> = (0..pixels_of_group.len()).map(along_rows).collect();
    let known: Vec<Rgb> = shots.iter().map(|shot| shot.unwrap_or_default()).collect();
    let usual = of_most_pixels(&known, pixels_of_group);
    let of_most = Rgb::select(usual.is_finite_mask(), usual, Rgb::ZERO);
    let most = LIKE_OTHERS * usual;
    let of_group = |(group, shot): (usize, &Option<Rgb>)| match shot {
        None => of_most,
        Some(shot) if shot.cmple(most).all() => *shot,
        Some(shot) => shot.min(most.max(members.nugget(group))),
    };
    shots.iter().enumerate().map(of_group).collect()
}

/// The median over all pixels of the shot noise of their groups, where it is not zero.
fn of_most_pixels(shots: &[Rgb], pixels: &[Vec<u32>]) -> Rgb {
    let median = |channel: usize| {
        let measured = shots.iter().zip(pixels).filter(|(shot, _)| shot[channel] > 0.0);
        let mut sorted: Vec<(f32, usize)> =
            measured.map(|(shot, pixels)| (shot[channel], pixels.len())).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = sorted.iter().map(|s| s.1).sum::<usize>() / 2;
        let mut count = 0;
        let middle = sorted.iter().find(|(_, pixels)| {
            count += pixels;
            count > half
        });
        middle.map_or(f32::INFINITY, |(shot, _)| *shot)
    };
    Rgb::new(median(0), median(1), median(2))
}

/// A direction of the picture: columns and rows to go.
type Direction = [usize; 2];
/// To the next pixel of the row, and of the column.
const ALONG_ROWS: Direction = [1, 0];
const ALONG_COLUMNS: Direction = [0, 1];

/// The photograph's values, and the group of each valid pixel.
struct Members<'a> {
    values: &'a RgbImage,
    /// The quantisation step at each pixel, in units of the values.
    quantisation_step: &'a RgbImage,
    pixels_of_group: &'a [Vec<u32>],
    /// The group of each pixel, plus one; zero for those that are not valid.
    group: Vec<u32>,
    /// The variance of read noise, as far as it is known.
    read: Rgb,
}

impl<'a> Members<'a> {
    fn of(
        values: &'a RgbImage,
        quantisation_step: &'a RgbImage,
        pixels_of_group: &'a [Vec<u32>],
    ) -> Self {
        let mut group = vec![0; values.pixels().len()];
        for (pixels, index) in pixels_of_group.iter().zip(1..) {
            pixels.iter().for_each(|&p| group[p as usize] = index);
        }
        Self { values, quantisation_step, pixels_of_group, group, read: Rgb::ZERO }
    }

    /// The pixels `steps` before and after `pixel`, if they are of its group too.
    fn neighbours(
        &self,
        pixel: usize,
        [columns, rows]: Direction,
        steps: usize,
    ) -> Option<[usize; 2]> {
        let width = self.values.width();
        let column = pixel % width;
        if column < columns * steps || column + columns * steps >= width {
            return None;
        }
        let distance = steps * (columns + rows * width);
        let both = [pixel.checked_sub(distance)?, pixel + distance];
        let is_like = |p: usize| self.group.get(p) == Some(&self.group[pixel]);
        both.into_iter().all(is_like).then_some(both)
    }

    /// A group's variance beyond quantisation, by the second differences of pixels that are `steps` apart along
    /// `direction`, and its mean value; none with too few of them.
    fn beyond_quantisation(
        &self,
        group: usize,
        direction: Direction,
        steps: usize,
    ) -> Option<[Rgb; 2]> {
        let pixels = &self.pixels_of_group[group];
        let value = |p: usize| self.values.pixels()[p];
        let (mut squares, mut count) = (Rgb::ZERO, 0);
        for &pixel in pixels {
            if let Some([before, after]) = self.neighbours(pixel as usize, direction, steps) {
                let difference = value(pixel as usize) - 0.5 * (value(before) + value(after));
                squares += difference * difference;
                count += 1;
            }
        }
        if count < DIFFERENCES_MIN {
            return None;
        }
        let step = |p: usize| self.quantisation_step.pixels()[p];
        let mean = |f: &dyn Fn(usize) -> Rgb| {
            pixels.iter().map(|&p| f(p as usize)).sum::<Rgb>() / pixels.len() as f32
        };
        let quantisation = mean(&|p| step(p) * step(p)) / 12.0;
        let excess = (squares / (1.5 * count as f32) - quantisation).max(Rgb::ZERO);
        Some([excess, mean(&value)])
    }

    /// A group's variance beyond quantisation and reading per unit of value, per channel, likewise.
    fn shot_noise(&self, group: usize, direction: Direction, steps: usize) -> Option<Rgb> {
        let [excess, level] = self.beyond_quantisation(group, direction, steps)?;
        let shot = (excess - self.read).max(Rgb::ZERO) / level.max(Rgb::splat(1e-20));
        Some(Rgb::select(level.cmpgt(Rgb::ZERO), shot, Rgb::ZERO))
    }

    /// The uncorrelated noise of a group per unit of value: the lesser one of that along rows and along columns, as a
    /// pattern may change along one of them alone.
    fn nugget(&self, group: usize) -> Rgb {
        let along = |direction| {
            let at = |steps| self.shot_noise(group, direction, steps);
            // Too few differences at the larger distance say nothing.
            let [near, far] = [at(1)?, at(2)?];
            Some((2.0 * near - far).min(near).max(Rgb::ZERO))
        };
        let [rows, columns] = [ALONG_ROWS, ALONG_COLUMNS].map(|d| along(d).unwrap_or_default());
        rows.min(columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 64;

    /// A number for `i`, uniform from -1 to 1: its variance is a third.
    fn scatter(i: usize) -> f32 {
        let mut x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        2.0 * ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32 - 1.0
    }

    /// The shot noise of two groups in a picture of mean one: three quarters with noise of standard deviation 0.01, and
    /// a last quarter with what `f` adds.
    fn shots(f: impl Fn(usize, usize) -> f32) -> [f32; 2] {
        let of_last = |y: usize| 4 * y >= 3 * SIDE;
        let value = |x: usize, y: usize| {
            let noise = 0.01 * 3f32.sqrt() * scatter(y * SIDE + x);
            1.0 + if of_last(y) { f(x, y) } else { noise }
        };
        let values = RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb::splat(value(x, y)));
        let steps = RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; SIDE * SIDE]);
        let all = (0..(SIDE * SIDE) as u32).partition(|p| !of_last(*p as usize / SIDE));
        let shots = PhotographNoise::of((&values, &steps), &[all.0, all.1]).shot_of_group;
        [shots[0].x, shots[1].x]
    }

    #[test]
    fn noise_is_measured_however_large_it_is() {
        for size in [0.01, 0.03, 0.1, 0.3] {
            let noise =
                |x: usize, y: usize| size * 3f32.sqrt() * scatter(7919 * (y * SIDE + x) + 3);
            let [usual, found] = shots(noise);
            assert!((usual / 1e-4 - 1.0).abs() < 0.1, "{usual}");
            // A thousand pixels; the lesser one of two estimates is a sixth too low.
            assert!((found / (size * size) - 1.0).abs() < 0.2, "{size}: {found}");
        }
    }

    #[test]
    fn a_group_that_is_too_small_to_tell_has_the_noise_of_the_others() {
        let value = |x: usize, y: usize| 1.0 + 0.01 * 3f32.sqrt() * scatter(y * SIDE + x);
        let values = RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb::splat(value(x, y)));
        let steps = RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; SIDE * SIDE]);
        let (small, large) = (0..(SIDE * SIDE) as u32).partition(|p| *p < 20);
        let shots = PhotographNoise::of((&values, &steps), &[large, small]).shot_of_group;
        assert_eq!(shots[0], shots[1]);
        let none = PhotographNoise::of((&values, &steps), &[(0..20).collect()]);
        assert_eq!(none.shot_of_group, [Rgb::ZERO]);
    }

    #[test]
    fn read_noise_is_what_a_dark_group_shows() {
        // Standard deviation 0.02 everywhere, and a variance of 0.001 per unit of value.
        let noise = |x: usize, y: usize, level: f32| {
            let (read, shot) = (scatter(y * SIDE + x), scatter(7919 * (y * SIDE + x) + 3));
            level + 3f32.sqrt() * (0.02 * read + (0.001 * level).sqrt() * shot)
        };
        let level = |y: usize| [1.0, 0.4, 0.0, 0.6][4 * y / SIDE];
        let values =
            RgbImage::from_fn(SIDE, SIDE, |x, y| Rgb::new(noise(x, y, level(y)), level(y), 0.3));
        let steps = RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; SIDE * SIDE]);
        let groups: Vec<Vec<u32>> = (0..4).map(|g| (g * 1024..(g + 1) * 1024).collect()).collect();
        let found = PhotographNoise::of((&values, &steps), &groups);
        assert!((found.read.x / 4e-4 - 1.0).abs() < 0.15, "{}", found.read);
        assert_eq!([found.read.y, found.read.z], [0.0, 0.0]);
        for bright in [0, 1, 3] {
            let shot = found.shot_of_group[bright].x;
            assert!((shot / 0.001 - 1.0).abs() < 0.25, "{bright}: {shot}");
        }
        assert_eq!(found.shot_of_group[2].y, 0.0);
    }

    #[test]
    fn patterns_are_no_noise() {
        let most = 2.0 * 1.1e-4;
        let blocks = |x: usize, y: usize| 0.2 * scatter((y / 3) * SIDE + x / 3);
        let stripes = |x: usize, _: usize| 0.2 * scatter(x);
        let rows = |_: usize, y: usize| 0.2 * scatter(y);
        let waves = |x: usize, y: usize| 0.2 * (0.9 * x as f32 + 0.7 * y as f32).sin();
        assert!(shots(blocks)[1] < most);
        assert!(shots(stripes)[1] < most);
        assert!(shots(rows)[1] < most);
        assert!(shots(waves)[1] < most);
    }

    #[test]
    fn noise_on_a_slow_pattern_is_measured_too() {
        let noise = |x: usize, y: usize| 0.05 * 3f32.sqrt() * scatter(31 * (y * SIDE + x) + 1);
        let ramps =
            |x: usize, y: usize| 0.3 * (0.1 * x as f32 + 0.15 * y as f32).sin() + noise(x, y);
        let found = shots(ramps)[1];
        assert!((found / 0.0025 - 1.0).abs() < 0.15, "{found}");
    }
}
