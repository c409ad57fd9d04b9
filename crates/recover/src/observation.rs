//! What the photograph shows of each group: which pixels may be believed, and how noisy they are.
//!
//! A pixel is believed if the photograph says so (not clipped), and if it and its neighbours show
//! one object with one smooth normal, so that half a pixel of displacement does no harm.
//!
//! The noise of the photograph is estimated from itself: in the interior of a group, the difference
//! of a pixel from the mean of its two neighbours in the row holds 3/2 of the noise's variance and
//! little of the picture. It gives for each group `variance = quantum^2/12 + s B`, quantisation and
//! a shot noise. What is finer than two pixels in a picture (a coarse weave, say) counts as noise.

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
    /// For each group: variance of the noise per unit of value, per channel.
    pub shot_of_group: Vec<Rgb>,
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
        let shot_of_group = pixels_of_group.iter().map(|p| shot_noise(&picture, p)).collect();
        Self { picture, pixels_of_group, all_pixels_of_group, smooth, shot_of_group }
    }

    /// The variance of the photograph's noise at a pixel of `group`, before exposure.
    pub fn noise_variance(&self, group: usize, pixel: u32) -> Rgb {
        let quantum = self.picture.quantum.pixels()[pixel as usize];
        let level = self.smooth.pixels()[pixel as usize].max(Rgb::ZERO);
        quantum * quantum / 12.0 + self.shot_of_group[group] * level
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

/// A group's variance beyond quantisation per unit of value, per channel.
fn shot_noise(picture: &Picture, pixels: &[u32]) -> Rgb {
    let width = picture.values.width();
    let value = |p: u32| picture.values.pixels()[p as usize];
    let (mut squares, mut count) = (Rgb::ZERO, 0.0);
    // Pixels come in scanline order: three in a row are three neighbours in the list.
    for w in pixels.windows(3) {
        if w[2] == w[0] + 2 && w[0] as usize / width == w[2] as usize / width {
            let difference = value(w[1]) - 0.5 * (value(w[0]) + value(w[2]));
            squares += difference * difference;
            count += 1.0;
        }
    }
    if count < FEW_PIXELS as f32 {
        return Rgb::ZERO;
    }
    let quantum = |p: u32| picture.quantum.pixels()[p as usize];
    let mean =
        |f: &dyn Fn(u32) -> Rgb| pixels.iter().map(|&p| f(p)).sum::<Rgb>() / pixels.len() as f32;
    let quantisation = mean(&|p| quantum(p) * quantum(p)) / 12.0;
    let excess = (squares / (1.5 * count) - quantisation).max(Rgb::ZERO);
    let level = mean(&value);
    Rgb::select(level.cmpgt(Rgb::ZERO), excess / level.max(Rgb::splat(1e-20)), Rgb::ZERO)
}
