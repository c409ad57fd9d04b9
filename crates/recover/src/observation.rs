//! What the photograph shows of each group: which pixels may be believed, and how noisy they are.
//!
//! A pixel is believed if the photograph says so (not clipped), and if it and its neighbours show
//! one object with one smooth normal, so that half a pixel of displacement does no harm.
//!
//! The noise of the photograph is estimated from itself: in the interior of a group, the difference
//! of a pixel from the mean of its two neighbours in the row holds 3/2 of the noise's variance and
//! little of the picture. Pooled over all groups it gives `variance = quantum^2/12 + s B`, a shot
//! noise on top of the quantisation; the median over groups keeps textured groups from posing as
//! noise.

use glam::Vec3;
use unrender_render::{GeometryBuffers, NOTHING};
use unrender_scene::{Image, Rgb, RgbImage};

/// The photograph, developed: linear values with a trust and a quantisation step per pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Radiance before the exposure is applied.
    pub values: RgbImage,
    /// False for pixels that are clipped or broken.
    pub trusted: Image<bool>,
    /// What one step of the file's code value means at this pixel; zero for float files.
    pub quantum: RgbImage,
}

/// The photograph, sorted by groups.
#[derive(Clone, Debug)]
pub struct Observation {
    /// The photograph.
    pub picture: Picture,
    /// For each group: the believed pixels, in scanline order.
    pub pixels_of_group: Vec<Vec<u32>>,
    /// For each group: all its pixels, believed or not.
    pub all_pixels_of_group: Vec<Vec<u32>>,
    /// The local mean of the believed pixels of the same object, 5 x 5.
    pub smooth: RgbImage,
    /// Variance of the noise per unit of value, per channel.
    pub shot: Rgb,
}

/// Below this many believed pixels a group falls back on all its unclipped ones.
const FEW_PIXELS: usize = 40;
/// Neighbouring normals further apart than this (cosine) make an edge.
const SAME_NORMAL: f32 = 0.95;
/// A pixel this many times above all its neighbours is a firefly or a hot pixel.
const SPIKE: f32 = 3.0;

impl Observation {
    /// Sorts the photograph by the groups of `geometry`, of which there are `groups`.
    ///
    /// # Panics
    /// If picture and geometry differ in size.
    pub fn new(picture: Picture, geometry: &GeometryBuffers, groups: usize) -> Self {
        assert_eq!(picture.values.pixels().len(), geometry.pixels().len(), "sizes differ");
        let mut pixels_of_group = vec![Vec::new(); groups];
        let mut all_pixels_of_group = vec![Vec::new(); groups];
        for (index, pixel) in geometry.pixels().iter().enumerate() {
            if pixel.group == NOTHING {
                continue;
            }
            all_pixels_of_group[pixel.group as usize].push(index as u32);
            if picture.trusted.pixels()[index]
                && is_interior(geometry, index)
                && !is_spike(&picture.values, index)
            {
                pixels_of_group[pixel.group as usize].push(index as u32);
            }
        }
        for (believed, all) in pixels_of_group.iter_mut().zip(&all_pixels_of_group) {
            if believed.len() < FEW_PIXELS {
                let trusted = |&&p: &&u32| picture.trusted.pixels()[p as usize];
                *believed = all.iter().filter(trusted).copied().collect();
            }
        }
        let smooth = smooth(&picture.values, geometry, &pixels_of_group);
        let shot = shot_noise(&picture, &pixels_of_group);
        Self { picture, pixels_of_group, all_pixels_of_group, smooth, shot }
    }

    /// The variance of the photograph's noise at a pixel, before exposure.
    pub fn noise_variance(&self, pixel: u32) -> Rgb {
        let quantum = self.picture.quantum.pixels()[pixel as usize];
        let level = self.smooth.pixels()[pixel as usize].max(Rgb::ZERO);
        quantum * quantum / 12.0 + self.shot * level
    }
}

fn is_interior(geometry: &GeometryBuffers, index: usize) -> bool {
    let centre = &geometry.pixels()[index];
    geometry.neighbourhood(index).all(|n| {
        let other = &geometry.pixels()[n];
        other.object == centre.object && other.normal.dot(centre.normal) > SAME_NORMAL
    })
}

fn is_spike(values: &RgbImage, index: usize) -> bool {
    let neighbours = values.neighbourhood(index).filter(|&n| n != index);
    let brightest = neighbours.fold(Rgb::ZERO, |m, n| m.max(values.pixels()[n]));
    let (value, around) = (values.pixels()[index].max_element(), brightest.max_element());
    value > SPIKE * around && around > 0.0
}

fn smooth(values: &RgbImage, geometry: &GeometryBuffers, groups: &[Vec<u32>]) -> RgbImage {
    let mut believed = vec![false; values.pixels().len()];
    groups.iter().flatten().for_each(|&p| believed[p as usize] = true);
    let (width, height) = (values.width(), values.height());
    RgbImage::from_fn(width, height, |x, y| {
        let object = geometry.at(x, y).object;
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for row in y.saturating_sub(2)..(y + 3).min(height) {
            for col in x.saturating_sub(2)..(x + 3).min(width) {
                if believed[row * width + col] && geometry.at(col, row).object == object {
                    sum += *values.at(col, row);
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { sum / count } else { *values.at(x, y) }
    })
}

/// The shot noise `s` of each channel, pooled over groups.
fn shot_noise(picture: &Picture, groups: &[Vec<u32>]) -> Rgb {
    let width = picture.values.width();
    Rgb::from_array(std::array::from_fn(|channel| {
        let slopes: Vec<(f32, f32)> = groups
            .iter()
            .filter_map(|pixels| group_slope(picture, pixels, width, channel))
            .collect();
        weighted_median(slopes)
    }))
}

/// One group's variance beyond quantisation per unit of value, and its number of pixels.
fn group_slope(
    picture: &Picture,
    pixels: &[u32],
    width: usize,
    channel: usize,
) -> Option<(f32, f32)> {
    let value = |p: u32| picture.values.pixels()[p as usize][channel];
    // Pixels come in scanline order: three in a row are three neighbours in the list.
    let rough = |w: &[u32]| {
        let in_a_row = w[2] == w[0] + 2 && w[0] as usize / width == w[2] as usize / width;
        in_a_row.then(|| (value(w[1]) - 0.5 * (value(w[0]) + value(w[2]))).abs())
    };
    let mut differences: Vec<f32> = pixels.windows(3).filter_map(rough).collect();
    if differences.len() < FEW_PIXELS {
        return None;
    }
    let count = differences.len() as f32;
    let level = pixels.iter().map(|&p| value(p)).sum::<f32>() / pixels.len() as f32;
    let quantum =
        pixels.iter().map(|&p| picture.quantum.pixels()[p as usize][channel].powi(2)).sum::<f32>()
            / (12.0 * pixels.len() as f32);
    let middle = differences.len() / 2;
    let median = *differences.select_nth_unstable_by(middle, f32::total_cmp).1;
    // Median of the absolute value of a normal variable: 0.6745 sigma.
    let variance = (median / 0.6745).powi(2) / 1.5;
    (level > 0.0).then_some((((variance - quantum) / level).max(0.0), count))
}

fn weighted_median(mut values: Vec<(f32, f32)>) -> f32 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half: f32 = values.iter().map(|v| v.1).sum::<f32>() / 2.0;
    let mut sum = 0.0;
    for (value, weight) in &values {
        sum += weight;
        if sum >= half {
            return *value;
        }
    }
    0.0
}
