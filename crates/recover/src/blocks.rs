//! Blocks of neighbouring pixels of one group.
//!
//! What a model gets wrong, and what a camera's processing does to a picture, is alike in neighbouring
//! pixels. Pixels are therefore not independent observations; the means over blocks nearly are. Blocks
//! are a share of their group, not a number of pixels, so that a picture at twice the resolution has
//! the same blocks.

use std::collections::BTreeMap;
use unrender_scene::Rgb;

/// Blocks of a group at most, about. Half as many tell small highlights less well from their
/// surroundings, twice as many are correlated.
const BLOCKS: usize = 256;
/// Sampled pixels of a block, about: with those around it and the rest of the group they tell the
/// rendering noise. One or two leave it uncertain, which likelihoods then mistake for evidence; a dozen
/// leave small groups with too few blocks to tell anything.
const SAMPLES: usize = 4;

/// The side of a block, pixels, of a group of `pixels` of which `sampled` are looked at.
pub fn side(pixels: usize, sampled: usize) -> usize {
    let blocks = (sampled.min(pixels) / SAMPLES).clamp(1, BLOCKS);
    (pixels / blocks).isqrt().max(1)
}

/// Some pixels of a picture, sorted into square blocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blocks {
    /// The block of every pixel.
    pub of_pixel: Vec<u32>,
    /// The column and row of every block, in units of its side.
    pub places: Vec<(usize, usize)>,
    /// The number of pixels of every block.
    pub sizes: Vec<u32>,
}

impl Blocks {
    /// The blocks of `side` pixels of `pixels`, indices into a picture of `width` columns.
    pub fn of(pixels: &[u32], width: usize, side: usize) -> Self {
        let place = |pixel: u32| (pixel as usize % width / side, pixel as usize / width / side);
        let mut number: BTreeMap<(usize, usize), u32> = BTreeMap::new();
        pixels.iter().for_each(|&p| *number.entry(place(p)).or_default() += 1);
        let sizes = number.values().copied().collect();
        let places: Vec<(usize, usize)> = number.keys().copied().collect();
        number.values_mut().enumerate().for_each(|(i, n)| *n = i as u32);
        let of_pixel = pixels.iter().map(|&p| number[&place(p)]).collect();
        Self { of_pixel, places, sizes }
    }

    /// The number of blocks.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The blocks without the pixels that are flagged; blocks that are left empty go.
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
        Self {
            of_pixel: kept().map(|block| number[block as usize]).collect(),
            places: (0..self.len()).filter(stays).map(|block| self.places[block]).collect(),
            sizes: sizes.iter().copied().filter(|size| *size > 0).collect(),
        }
    }

    /// The mean over every block of the `values` whose index `counts`; zero where none does.
    pub fn mean_where(&self, values: &[Rgb], counts: impl Fn(usize) -> bool) -> Vec<Rgb> {
        let mut sums = vec![(Rgb::ZERO, 0.0f32); self.len()];
        for (i, &block) in self.of_pixel.iter().enumerate().filter(|(i, _)| counts(*i)) {
            let (sum, count) = &mut sums[block as usize];
            *sum += values[i];
            *count += 1.0;
        }
        sums.into_iter().map(|(sum, count)| sum / count.max(1.0)).collect()
    }

    /// For every block: the mean of `values`, one a pixel, over it and the blocks around it.
    pub fn smooth(&self, values: &[Rgb]) -> Vec<Rgb> {
        let mut sums = vec![Rgb::ZERO; self.len()];
        for (value, &block) in values.iter().zip(&self.of_pixel) {
            sums[block as usize] += *value;
        }
        let number: BTreeMap<(usize, usize), usize> =
            self.places.iter().enumerate().map(|(i, place)| (*place, i)).collect();
        let around = |&(x, y): &(usize, usize)| {
            let rows = y.saturating_sub(1)..=y + 1;
            let places = rows.flat_map(|row| (x.saturating_sub(1)..=x + 1).map(move |c| (c, row)));
            let blocks = places.filter_map(|place| number.get(&place).copied());
            let (sum, count) =
                blocks.fold((Rgb::ZERO, 0), |(s, n), b| (s + sums[b], n + self.sizes[b]));
            sum / count.max(1) as f32
        };
        self.places.iter().map(around).collect()
    }

    /// All pairs of blocks side by side or one above the other.
    pub fn neighbours(&self) -> Vec<(usize, usize)> {
        let number: BTreeMap<(usize, usize), usize> =
            self.places.iter().enumerate().map(|(i, place)| (*place, i)).collect();
        let beside = |(i, &(x, y)): (usize, &(usize, usize))| {
            let next = [(x + 1, y), (x, y + 1)];
            next.map(|place| number.get(&place).map(|&j| (i, j))).into_iter().flatten()
        };
        self.places.iter().enumerate().flat_map(beside).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 8 x 8 pixels in blocks of 2 x 2.
    fn square() -> Blocks {
        Blocks::of(&(0..64).collect::<Vec<u32>>(), 8, 2)
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
