//! Pixels so close to black that their noise is clipped from below.
//!
//! Where noise extends below the black level, the file has black instead, and the mean of a region
//! is biased upwards. Excluding the black pixels alone would increase the bias, since the brighter
//! half of the noise would remain. So a pixel is tested by its neighbours, independently of its own
//! value: it is excluded if some of them are clipped among others that clearly are not. Regions
//! that are black, and black pixels beside an edge, are kept.

use unrender_scene::{Image, Picture, Rgb};

/// Values this far above black (of 1) are clearly not clipped: two steps of 8 bits. At one step
/// rounding would count as noise, at four steps weak noise is missed.
const CLEARLY: f32 = 1.5 / 255.0;
/// Neighbours this far above black (of 1) are an edge and not noise: a dozen steps of 8 bits. Half
/// of it keeps regions of strong noise, double of it excludes black beside dim objects.
const EDGE: f32 = 12.5 / 255.0;
/// Below this share of the picture the bias is negligible and no pixel is excluded.
const HARMLESS: f32 = 5e-4;

/// The indices of the pixels with a channel in the noise near black; none where they are few, and
/// none for floating-point files. `floor` is the pixel value at and below which a channel is
/// clipped.
pub fn dark_pixels(picture: &Picture, floor: Rgb) -> Vec<usize> {
    if picture.depth.max_code().is_none() {
        return Vec::new();
    }
    let count = picture.values.pixels().len();
    let measured = picture.measured();
    let is_dark = |index: &usize| is_dark(picture, &measured, floor, *index);
    let dark: Vec<usize> = (0..count).filter(is_dark).collect();
    if (dark.len() as f32) < HARMLESS * count as f32 { Vec::new() } else { dark }
}

fn is_dark(picture: &Picture, measured: &Image<bool>, floor: Rgb, index: usize) -> bool {
    let (values, measured) = (picture.values.pixels(), measured.pixels());
    // Pixels without a measurement are not black, whatever their values.
    let counts = |n: usize| n != index && measured[n];
    let neighbours = || picture.values.neighbourhood(index).filter(move |&n| counts(n));
    (0..3).any(|channel| {
        let floor = floor[channel];
        let clipped = neighbours().any(|n| values[n][channel] <= floor);
        if !clipped || neighbours().any(|n| values[n][channel] > floor + EDGE) {
            return false;
        }
        let clearly = neighbours().filter(|&n| values[n][channel] > floor + CLEARLY).count();
        2 * clearly >= neighbours().count()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::Depth;

    const SIDE: usize = 300;

    /// Noise of standard deviation one: the sum of twelve hashed numbers from 0 to 1, less six.
    fn noise(seed: usize) -> f32 {
        let uniform = |k: u64| {
            let mut x = (12 * seed as u64 + k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((x ^ (x >> 31)) >> 40) as f32 / (1u64 << 24) as f32
        };
        (0..12).map(uniform).sum::<f32>() - 6.0
    }

    fn picture(code: impl Fn(usize, usize) -> f32) -> Picture {
        let code = |x, y| Rgb::splat(code(x, y).round().clamp(0.0, 255.0) / 255.0);
        Picture::new(Image::from_fn(SIDE, SIDE, code), Depth::Eight)
    }

    #[test]
    fn the_valid_pixels_are_not_biased_upwards() {
        const SIGMA: f32 = 2.0;
        // A ramp from black to 12 steps; its lower half is in the noise.
        let level = |x: usize| 12.0 * x as f32 / SIDE as f32;
        let noisy = picture(|x, y| level(x) + SIGMA * noise(y * SIDE + x));
        let dark = dark_pixels(&noisy, Rgb::ZERO);
        let mut stays = vec![true; SIDE * SIDE];
        dark.iter().for_each(|&index| stays[index] = false);
        let bias = |keep: &dyn Fn(usize) -> bool, columns: std::ops::Range<usize>| {
            let kept: Vec<usize> =
                (0..SIDE * SIDE).filter(|&i| columns.contains(&(i % SIDE)) && keep(i)).collect();
            let code = |i: &usize| 255.0 * noisy.values.pixels()[*i].x - level(i % SIDE);
            (kept.iter().map(code).sum::<f32>() / kept.len() as f32, kept.len())
        };
        // Between 3 and 5 steps, where the noise is sometimes clipped.
        let columns = 75..125;
        let (judged_by_neighbours, count) = bias(&|i| stays[i], columns.clone());
        let (all, _) = bias(&|_| true, columns.clone());
        let (without_black, _) = bias(&|i| noisy.values.pixels()[i].x > 0.0, columns);
        assert!(count > 3000, "{count}");
        assert!(judged_by_neighbours <= all + 0.01, "{judged_by_neighbours} against {all}");
        assert!(without_black > all + 0.05, "{without_black} against {all}");
        // Most of the pixels between 1.5 and 3 steps are excluded.
        let (_, count) = bias(&|i| stays[i], 38..75);
        assert!((count as f32) < 0.45 * 37.0 * SIDE as f32, "{count}");
    }

    #[test]
    fn what_has_no_measurement_is_not_black() {
        // A dim picture with holes at every third pixel.
        let third = |n: usize| n.is_multiple_of(3);
        let mut holes = picture(|x, y| if third(x) && third(y) { 0.0 } else { 8.0 });
        assert!(dark_pixels(&holes, Rgb::ZERO).len() > SIDE);
        let is_hole = |i: &usize| third(i % SIDE) && third(i / SIDE);
        holes.invalid = (0..SIDE * SIDE).filter(is_hole).collect();
        assert!(dark_pixels(&holes, Rgb::ZERO).is_empty());
    }

    #[test]
    fn black_regions_and_edges_are_kept() {
        let half = picture(|x, _| if x < SIDE / 2 { 0.0 } else { 90.0 });
        assert!(dark_pixels(&half, Rgb::ZERO).is_empty());
        assert!(dark_pixels(&picture(|_, _| 0.0), Rgb::ZERO).is_empty());
        // Rounding by one step is not noise.
        assert!(dark_pixels(&picture(|x, y| ((x + y) % 2) as f32), Rgb::ZERO).is_empty());
    }
}
