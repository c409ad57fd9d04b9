//! A sketch of the photograph: every group diffuse, quickly fitted. Near the edges of the model it says which
//! of two cameras took the photograph.
//!
//! The photograph's edges alone ([`unrender_register`]) do not: some are of shadows and reflections, and pull a correct
//! camera off by a fraction of a pixel. A rendering has these edges too.

use std::collections::BTreeMap;
use unrender_recover::{Options, Problem, RecoverError, sketched};
use unrender_register::edges::is_interior;
use unrender_render::GeometryBuffers;
use unrender_scene::color::luminance;
use unrender_scene::{Rgb, RgbImage};

/// Pixels that are looked at, at most, and paths a pixel. A quarter of either leaves a camera that is a third
/// of a pixel off undecided in small pictures, four times as many take longer than the fits.
const PIXELS: usize = 12_000;
const SPP: u32 = 48;
/// Differences of more than this share of the local light have other causes than the camera: they count as this much.
/// At half of it the edges of dark things beside bright ones count no more than others, at double a lamp's reflection
/// dominates.
const MOST: f32 = 0.5;
/// Differences are relative to the light around plus this share of the picture's.
const DARK: f32 = 0.1;
/// The side of a block of pixels that one displaced edge makes wrong together.
const BLOCK: usize = 8;

/// The pixels at the edges of the model, as either camera sees it: at most twelve thousand, evenly taken.
pub(crate) fn edge_pixels(geometries: [&GeometryBuffers; 2]) -> Vec<u32> {
    let at_edge = |index: &usize| geometries.iter().any(|g| !is_interior(g, *index));
    let all: Vec<u32> =
        (0..geometries[0].pixels().len()).filter(at_edge).map(|index| index as u32).collect();
    let every = all.len().div_ceil(PIXELS).max(1);
    all.into_iter().step_by(every).collect()
}

/// How far a sketch of the photograph is from it at `pixels`, as shares of the local light; zero where the
/// photograph has no value.
///
/// # Errors
/// If the camera sees nothing, or the anchor cannot fix the exposure.
pub(crate) fn differences(
    problem: &Problem<'_>,
    options: &Options,
    pixels: &[u32],
) -> Result<Vec<f32>, RecoverError> {
    let sketched = sketched(problem, options, (pixels, SPP))?;
    let picture = &problem.observation.picture;
    let levels = levels(&picture.values, pixels);
    let difference = |((&pixel, model), level): ((&u32, Rgb), f32)| {
        let at = pixel as usize;
        if !picture.valid.pixels()[at] {
            return 0.0;
        }
        ((luminance(picture.values.pixels()[at]) - luminance(model)).abs() / level).min(MOST)
    };
    Ok(pixels.iter().zip(sketched).zip(levels).map(difference).collect())
}

/// The light around each of `pixels`, and a share of the whole picture's.
fn levels(values: &RgbImage, pixels: &[u32]) -> Vec<f32> {
    let light = values.map(|value| luminance(*value).max(0.0));
    let all = light.pixels();
    let mean = all.iter().sum::<f32>() / all.len().max(1) as f32;
    let around = |&pixel: &u32| {
        let near = light.neighbourhood(pixel as usize);
        let (sum, count) = near.fold((0.0, 0.0), |(sum, n), at| (sum + all[at], n + 1.0));
        (sum / count + DARK * mean).max(f32::MIN_POSITIVE)
    };
    pixels.iter().map(around).collect()
}

/// By how many standard deviations the `first` differences at `pixels` of a picture so many pixels wide are
/// larger than the `second` ones: pixels of a block count as one.
pub(crate) fn preference(first: &[f32], second: &[f32], pixels: &[u32], width: usize) -> f64 {
    let mut blocks: BTreeMap<(usize, usize), f64> = BTreeMap::new();
    for ((pixel, first), second) in pixels.iter().zip(first).zip(second) {
        let at = *pixel as usize;
        let block = (at % width / BLOCK, at / width / BLOCK);
        *blocks.entry(block).or_default() += f64::from(first - second);
    }
    let (sum, squares) =
        blocks.values().fold((0.0, 0.0), |(sum, squares), b| (sum + b, squares + b * b));
    if squares > 0.0 { sum / squares.sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smaller_differences_are_preferred() {
        let pixels: Vec<u32> = (0..6400).collect();
        let first: Vec<f32> = pixels.iter().map(|p| 0.2 + 0.001 * (p % 7) as f32).collect();
        let second: Vec<f32> = pixels.iter().map(|p| 0.1 + 0.001 * (p % 5) as f32).collect();
        assert!(preference(&first, &second, &pixels, 80) > 5.0);
        assert!(preference(&second, &first, &pixels, 80) < -5.0);
        assert_eq!(preference(&first, &first, &pixels, 80), 0.0);
    }

    #[test]
    fn what_a_few_blocks_say_is_not_certain() {
        let pixels: Vec<u32> = (0..6400).collect();
        let first: Vec<f32> = pixels.iter().map(|p| if *p < 8 { 0.5 } else { 0.1 }).collect();
        let second = vec![0.1; 6400];
        assert!(preference(&first, &second, &pixels, 80) < 1.5);
    }
}
