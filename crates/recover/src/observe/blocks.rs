//! Blocks of neighbouring pixels of one group.
//!
//! The errors of a model, and those of a camera's processing, are alike in neighbouring pixels. Pixels are therefore
//! not independent observations; the means over blocks nearly are. Blocks are a share of their group, not a number of
//! pixels, so that a picture at twice the resolution has the same blocks.
//!
//! Where the photograph changes within a block (a highlight, the edge of a shadow), the shape of the change
//! distinguishes hypotheses, and the block's mean would hide it: such a block is divided into fine ones, and more of
//! its pixels are looked at ([`Grid`]).

use crate::observe::observation::Observation;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use unrender_render::sampler::mix;
use unrender_scene::Rgb;
use unrender_scene::Sheet;

/// About the most blocks of a group in one photograph, before uneven ones are divided. Half as many separate small
/// highlights less well from their surroundings, twice as many are correlated.
const BLOCKS: usize = 256;
/// About how many pixels of a block are sampled: with those around it and the rest of the group they determine the
/// rendering noise. One or two leave it uncertain, and likelihoods mistake that for evidence; a dozen leave small
/// groups with too few blocks for any test.
const SAMPLES: usize = 4;
/// A block is uneven if its pixels' standard deviation is this share of their level, noise apart. At
/// half of it slow gradients count, at double the flanks of faint highlights do not.
const UNEVEN: f32 = 0.12;
/// An uneven block is divided into so many fine ones along each side. Two do not show the shape of a small
/// highlight; eight are single pixels.
const FINE: usize = 4;
/// The least share of a sample that uneven blocks get, where they have enough pixels. At half of it the smallest
/// highlights are a dozen pixels; at double the rest of the group has none.
const UNEVEN_SHARE: f32 = 0.4;

/// The side of a block, in pixels, for a group of `pixels`, so many of them `sampled`, in at most `most` blocks.
fn side(pixels: usize, sampled: usize, most: usize) -> usize {
    let blocks = (sampled.min(pixels) / SAMPLES).clamp(1, most);
    (pixels / blocks).isqrt().max(1)
}

/// Where a block lies: column and row in its photograph, in units of the side of blocks like it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Place {
    /// The photograph.
    pub photograph: usize,
    /// Whether it is a fine block: one of those that an uneven block is divided into.
    pub fine: bool,
    /// Column.
    pub column: usize,
    /// Row.
    pub row: usize,
}

impl Place {
    /// How many times the variance of the model error is that of a whole block: all fine blocks of an uneven one together
    /// weigh as much as an undivided one, so that the numbers of a wrong model do not depend on how its pixels were
    /// chosen.
    pub fn fine_blocks(self) -> f32 {
        if self.fine { (FINE * FINE) as f32 } else { 1.0 }
    }

    /// It and the places of the same kind around it.
    pub fn around(self) -> impl Iterator<Item = Self> {
        let columns = move || self.column.saturating_sub(1)..=self.column + 1;
        let rows = self.row.saturating_sub(1)..=self.row + 1;
        rows.flat_map(move |row| columns().map(move |column| Self { column, row, ..self }))
    }
}

/// How the pixels of one group are sorted into blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    sheet: Sheet,
    side: usize,
    /// Whether each block is uneven, photograph by photograph, row by row, up to the last one that is.
    uneven: Vec<bool>,
}

impl Grid {
    /// Blocks of one `side`, pixels, in the photographs of `sheet`.
    pub fn even(sheet: &Sheet, side: usize) -> Self {
        Self { sheet: sheet.clone(), side, uneven: Vec::new() }
    }

    /// For `pixels` of `group`, of which at most `count` are looked at.
    pub fn of(observation: &Observation, group: usize, pixels: &[u32], count: usize) -> Self {
        let side = side(pixels.len(), count, observation.sheet.of_all(BLOCKS));
        let even = Self::even(&observation.sheet, side);
        even.dividing_uneven(observation, group, pixels)
    }

    /// The same with the uneven blocks of `pixels` of `group` divided.
    #[must_use]
    pub fn dividing_uneven(
        mut self,
        observation: &Observation,
        group: usize,
        pixels: &[u32],
    ) -> Self {
        let last = pixels.iter().map(|pixel| self.number_of(*pixel)).max();
        let mut blocks = vec![Spread::default(); last.map_or(0, |last| last + 1)];
        let mut all = Spread::default();
        for &pixel in pixels {
            let value = observation.picture.values.pixels()[pixel as usize];
            let noise = observation.noise(group, pixel, Rgb::ONE).variance(value);
            blocks[self.number_of(pixel)].add(value, noise);
            all.add(value, noise);
        }
        let mean = all.mean();
        self.uneven = blocks.iter().map(|spread| spread.is_uneven(mean)).collect();
        self
    }

    /// The place of a pixel's block of this `side`.
    fn place_by(&self, pixel: u32, side: usize, fine: bool) -> Place {
        let (width, _) = self.sheet.size();
        let photograph = self.sheet.photograph_of(pixel);
        let [_, first_row, ..] = self.sheet.place(photograph);
        let (x, y) = (pixel as usize % width, pixel as usize / width - first_row);
        Place { photograph, fine, column: x / side, row: y / side }
    }

    /// The number of a pixel's undivided block, photograph by photograph, row by row.
    fn number_of(&self, pixel: u32) -> usize {
        let Place { photograph, column, row, .. } = self.place_by(pixel, self.side, false);
        let (width, height) = (self.sheet.size().0, self.sheet.highest());
        let [columns, rows] = [width, height].map(|length| length.div_ceil(self.side));
        (photograph * rows + row) * columns + column
    }

    /// Whether a pixel's block is uneven.
    fn is_uneven(&self, pixel: u32) -> bool {
        self.uneven.get(self.number_of(pixel)).is_some_and(|uneven| *uneven)
    }

    /// The place of a pixel's block.
    pub fn place(&self, pixel: u32) -> Place {
        if self.is_uneven(pixel) {
            return self.place_by(pixel, (self.side / FINE).max(1), true);
        }
        self.place_by(pixel, self.side, false)
    }

    /// At most `count` of `pixels`, spread evenly but for the uneven blocks, of which more are taken;
    /// sorted.
    pub fn sample(&self, pixels: &[u32], count: usize, seed: u64) -> Vec<u32> {
        if pixels.len() <= count {
            let mut all = pixels.to_vec();
            all.sort_unstable();
            return all;
        }
        let (uneven, even): (Vec<u32>, Vec<u32>) =
            pixels.iter().partition(|pixel| self.is_uneven(**pixel));
        let share = (uneven.len() as f32 / pixels.len() as f32).max(UNEVEN_SHARE);
        let of_uneven = ((share * count as f32) as usize).min(uneven.len());
        let mut sample = spread(&uneven, of_uneven, seed);
        sample.extend(spread(&even, count - of_uneven, seed));
        sample.sort_unstable();
        sample
    }
}

/// The values of some pixels.
#[derive(Clone, Copy, Default)]
struct Spread {
    sum: Rgb,
    squares: Rgb,
    noise: Rgb,
    pixels: f32,
}

/// A block of fewer pixels is not divided.
const DIVIDED_MIN: f32 = 4.0;

impl Spread {
    fn add(&mut self, value: Rgb, noise: Rgb) {
        self.sum += value;
        self.squares += value * value;
        self.noise += noise;
        self.pixels += 1.0;
    }

    fn mean(&self) -> Rgb {
        self.sum / self.pixels.max(1.0)
    }

    /// Whether they are uneven, in a group of mean `of_group`.
    fn is_uneven(&self, of_group: Rgb) -> bool {
        let mean = self.mean();
        let variance = (self.squares - self.noise) / self.pixels - mean * mean;
        let level2 = 0.5 * (mean * mean + of_group * of_group);
        self.pixels >= DIVIDED_MIN
            && variance.element_sum() > UNEVEN * UNEVEN * level2.element_sum()
    }
}

/// Some pixels of a picture, sorted into square blocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    /// The block of every pixel.
    pub of_pixel: Vec<u32>,
    /// Where every block lies.
    pub places: Vec<Place>,
    /// The number of pixels of every block.
    pub sizes: Vec<u32>,
    /// All pairs of blocks that show the same place of the surface in two photographs, once known.
    pub same: Vec<(usize, usize)>,
}

impl Blocks {
    /// The blocks of `grid` of `pixels`, indices into a picture.
    pub fn of(pixels: &[u32], grid: &Grid) -> Self {
        let mut number: BTreeMap<Place, u32> = BTreeMap::new();
        pixels.iter().for_each(|&p| *number.entry(grid.place(p)).or_default() += 1);
        let sizes = number.values().copied().collect();
        let places: Vec<Place> = number.keys().copied().collect();
        number.values_mut().enumerate().for_each(|(i, n)| *n = i as u32);
        let of_pixel = pixels.iter().map(|&p| number[&grid.place(p)]).collect();
        Self { of_pixel, places, sizes, same: Vec::new() }
    }

    /// The number of blocks.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The blocks without the pixels that are flagged, and without those that are left empty.
    #[must_use]
    pub fn without(&self, flags: &[bool]) -> Self {
        let kept = || self.of_pixel.iter().zip(flags).filter(|(_, flag)| !**flag).map(|(b, _)| *b);
        let mut sizes = vec![0u32; self.len()];
        kept().for_each(|block| sizes[block as usize] += 1);
        let mut next = 0;
        let number: Vec<u32> = sizes
            .iter()
            .map(|size| {
                next += u32::from(*size > 0);
                next.saturating_sub(1)
            })
            .collect();
        let stays = |block: &usize| sizes[*block] > 0;
        let both_stay = |(a, b): &&(usize, usize)| stays(a) && stays(b);
        let renumbered = |(a, b): &(usize, usize)| (number[*a] as usize, number[*b] as usize);
        Self {
            of_pixel: kept().map(|block| number[block as usize]).collect(),
            places: (0..self.len()).filter(stays).map(|block| self.places[block]).collect(),
            same: self.same.iter().filter(both_stay).map(renumbered).collect(),
            sizes: sizes.iter().copied().filter(|size| *size > 0).collect(),
        }
    }

    /// The mean over every block of the `values` whose index `counts`; zero where none does.
    pub fn mean_where(&self, values: &[Rgb], counts: impl Fn(usize) -> bool) -> Vec<Rgb> {
        self.mean_of(values, |i| if counts(i) { Rgb::ONE } else { Rgb::ZERO })
    }

    /// For every block and channel: the mean of `values`, one a pixel, over those of its pixels whose `share` is one, and
    /// not zero, in the channel.
    pub fn mean_of(&self, values: &[Rgb], share: impl Fn(usize) -> Rgb) -> Vec<Rgb> {
        let mut sums = vec![(Rgb::ZERO, Rgb::ZERO); self.len()];
        for (i, &block) in self.of_pixel.iter().enumerate() {
            let (sum, count) = &mut sums[block as usize];
            *sum += share(i) * values[i];
            *count += share(i);
        }
        sums.into_iter().map(|(sum, count)| sum / count.max(Rgb::ONE)).collect()
    }

    /// For every block: the mean of `values`, one a pixel, over it and the blocks around it.
    pub fn smooth(&self, values: &[Rgb]) -> Vec<Rgb> {
        let mut sums = vec![Rgb::ZERO; self.len()];
        for (value, &block) in values.iter().zip(&self.of_pixel) {
            sums[block as usize] += *value;
        }
        let number = numbers(&self.places);
        let around = |place: &Place| {
            let blocks = place.around().filter_map(|place| number.get(&place).copied());
            let (sum, count) =
                blocks.fold((Rgb::ZERO, 0), |(s, n), b| (s + sums[b], n + self.sizes[b]));
            sum / count.max(1) as f32
        };
        self.places.iter().map(around).collect()
    }

    /// Multiplies the squared level of each block by its [`Place::fine_blocks`]: model errors are a share
    /// of it.
    pub fn spread_over_fine(&self, level2: &mut [Rgb]) {
        level2
            .iter_mut()
            .zip(&self.places)
            .for_each(|(level2, place)| *level2 *= place.fine_blocks());
    }

    /// All pairs of blocks side by side or one above the other.
    pub fn neighbours(&self) -> Vec<(usize, usize)> {
        neighbours(&self.places)
    }
}

/// The index at every place.
fn numbers(places: &[Place]) -> BTreeMap<Place, usize> {
    places.iter().enumerate().map(|(i, place)| (*place, i)).collect()
}

/// All pairs of `places` side by side or one above the other, by their indices.
pub(crate) fn neighbours(places: &[Place]) -> Vec<(usize, usize)> {
    let number = numbers(places);
    let beside = |(i, &place): (usize, &Place)| {
        let right = Place { column: place.column + 1, ..place };
        let below = Place { row: place.row + 1, ..place };
        [right, below].map(|place| number.get(&place).map(|&j| (i, j))).into_iter().flatten()
    };
    places.iter().enumerate().flat_map(beside).collect()
}

/// At most `count` of `pixels`, spread evenly over the list with a jitter.
pub fn spread(pixels: &[u32], count: usize, seed: u64) -> Vec<u32> {
    if pixels.len() <= count {
        return pixels.to_vec();
    }
    let stride = pixels.len() as f64 / count as f64;
    let pick = |i: usize| {
        let jitter = (mix(seed ^ (i as u64) << 20) >> 11) as f64 / (1u64 << 53) as f64;
        pixels[(((i as f64 + jitter) * stride) as usize).min(pixels.len() - 1)]
    };
    (0..count).map(pick).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 8 x 8 pixels in blocks of 2 x 2.
    fn square() -> Blocks {
        Blocks::of(&(0..64).collect::<Vec<u32>>(), &Grid::even(&Sheet::of(&[(8, 8)]), 2))
    }

    #[test]
    fn blocks_hold_neighbouring_pixels() {
        let blocks = square();
        assert_eq!(blocks.len(), 16);
        assert!(blocks.sizes.iter().all(|size| *size == 4));
        assert_eq!(blocks.of_pixel[0], blocks.of_pixel[9]);
        assert_ne!(blocks.of_pixel[1], blocks.of_pixel[2]);
        assert_eq!(blocks.neighbours().len(), 24);
    }

    #[test]
    fn means_are_over_the_pixels_that_count() {
        let blocks = square();
        let values: Vec<Rgb> = (0..64).map(|i| Rgb::splat((i % 8) as f32)).collect();
        assert_eq!(blocks.mean_where(&values, |_| true)[0], Rgb::splat(0.5));
        assert_eq!(blocks.mean_where(&values, |i| i % 8 > 0)[0], Rgb::ONE);
        assert_eq!(blocks.smooth(&values)[0], Rgb::splat(1.5));
    }

    #[test]
    fn without_pixels_empty_blocks_go() {
        let flags: Vec<bool> = (0..64).map(|i| i % 8 < 3).collect();
        let left = square().without(&flags);
        assert_eq!(left.len(), 12);
        assert_eq!(left.of_pixel.len(), 40);
        assert_eq!(left.sizes.iter().sum::<u32>(), 40);
        assert!(left.of_pixel.iter().all(|block| (*block as usize) < 12));
    }
}
