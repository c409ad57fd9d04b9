//! Values of a group's pixels averaged over the pixels of the group near them in the picture.

use glam::Vec4;
use rayon::prelude::*;
use unrender_scene::Rgb;

/// Where pixels are, in the smallest rectangle of the picture that holds them.
#[derive(Clone, Debug)]
pub(super) struct Near {
    /// Column and row of each pixel, from the rectangle's corner.
    pub(super) places: Vec<[usize; 2]>,
    size: [usize; 2],
}

impl Near {
    /// Of `pixels` of a picture of this `width`.
    pub(super) fn of(pixels: &[u32], width: usize) -> Self {
        let place = |pixel: &u32| [*pixel as usize % width, *pixel as usize / width];
        let places: Vec<[usize; 2]> = pixels.iter().map(place).collect();
        let first = [0, 1].map(|axis| places.iter().map(|p| p[axis]).min().unwrap_or(0));
        let last = [0, 1].map(|axis| places.iter().map(|p| p[axis]).max().unwrap_or(0));
        let within = |p: &[usize; 2]| [p[0] - first[0], p[1] - first[1]];
        let size = [0, 1].map(|axis| last[axis] - first[axis] + 1);
        Self { places: places.iter().map(within).collect(), size }
    }

    /// The number in a checkerboard of squares of `side` pixels of each pixel, zero or one, and whether its neighbours
    /// within a `gap` have the same.
    pub(super) fn checkers(&self, side: usize, gap: usize) -> Vec<(usize, bool)> {
        let number = |x: usize, y: usize| (x / side + y / side) % 2;
        let of = |place: &[usize; 2]| {
            let [x, y] = place.map(|at| at + side);
            let beside = [(x + gap, y), (x - gap, y), (x, y + gap), (x, y - gap)];
            let own = number(x, y);
            (own, beside.into_iter().all(|(x, y)| number(x, y) == own))
        };
        self.places.iter().map(of).collect()
    }

    /// The square of `side` pixels that each pixel lies in, by number.
    pub(super) fn squares(&self, side: usize) -> Vec<usize> {
        let across = self.size[0].div_ceil(side);
        self.places.iter().map(|[x, y]| y / side * across + x / side).collect()
    }

    /// The means of `values` under a Gaussian of the standard deviation `sigma`, pixels, with these weights; where there
    /// is hardly any weight nearby, towards zero.
    pub(super) fn blurred(&self, values: &[Rgb], weights: &[f32], sigma: f32) -> Vec<Rgb> {
        let [width, height] = self.size;
        let mut sums = vec![Vec4::ZERO; width * height];
        for ([x, y], (value, weight)) in self.places.iter().zip(values.iter().zip(weights)) {
            sums[y * width + x] += (*weight * *value).extend(*weight);
        }
        let radius = (3.0 * sigma).ceil() as usize;
        let kernel: Vec<f32> =
            (0..=radius).map(|d| (-0.5 * (d as f32 / sigma).powi(2)).exp()).collect();
        let along = |of: &[Vec4], at: usize, end: usize, stride: usize, start: usize| {
            let (from, to) = (at.saturating_sub(radius), (at + radius).min(end - 1));
            (from..=to).map(|i| kernel[i.abs_diff(at)] * of[start + i * stride]).sum::<Vec4>()
        };
        let rows: Vec<Vec4> = (0..width * height)
            .into_par_iter()
            .with_min_len(1024)
            .map(|i| along(&sums, i % width, width, 1, i / width * width))
            .collect();
        let least = 1e-4 * weights.iter().sum::<f32>() / weights.len().max(1) as f32;
        let mean = |[x, y]: &[usize; 2]| {
            let sum = along(&rows, *y, height, width, *x);
            sum.truncate() / (sum.w + least).max(f32::MIN_POSITIVE)
        };
        self.places.par_iter().with_min_len(1024).map(mean).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_over_the_pixels_that_count() {
        let pixels: Vec<u32> = (0..400).filter(|p| p % 20 < 12).collect();
        let near = Near::of(&pixels, 20);
        let values: Vec<Rgb> = pixels.iter().map(|p| Rgb::splat((p % 2) as f32)).collect();
        let weights: Vec<f32> = pixels.iter().map(|p| (p % 2) as f32).collect();
        let means = near.blurred(&values, &weights, 2.0);
        assert!(means.iter().all(|mean| (mean.x - 1.0).abs() < 1e-3));
        let checkers = near.checkers(4, 1);
        let ones = checkers.iter().filter(|(number, _)| *number == 1).count();
        assert_eq!(ones, pixels.len() / 2 - 8);
        // Two of four pixels along each side are not beside another square.
        assert_eq!(checkers.iter().filter(|(_, inside)| *inside).count() * 4, pixels.len());
    }
}
