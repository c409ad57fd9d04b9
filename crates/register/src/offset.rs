//! How far from an edge of the model the photograph has one: the strongest change of the
//! photograph along a line across the edge [Harris and Stennett 1990].
//!
//! It uses the photograph's square root, in which shot noise is alike everywhere, a little
//! smoothed.

use super::edges::Edgel;
use glam::Vec2;
use unrender_scene::{Rgb, RgbImage};

/// Samples along the line, per pixel.
const PER_PIXEL: usize = 2;
/// An edge must change the photograph by so many standard deviations of its noise ...
const ABOVE_NOISE: f32 = 6.0;
/// ... by this share of the values there ...
const ABOVE_VALUE: f32 = 0.02;
/// ... and by so many times the median change along the line.
const ABOVE_LINE: f32 = 3.0;
/// A second edge of this share of the first leaves open which one is meant.
const RIVAL: f32 = 0.6;
/// Changes closer than this to the strongest are part of it, pixels.
const WIDTH: f32 = 2.0;

/// The photograph, ready to be searched for edges.
#[derive(Clone, Debug)]
pub struct EdgePicture {
    values: RgbImage,
    /// Standard deviation of the noise in `values`, all channels together.
    noise: f32,
}

impl EdgePicture {
    /// Prepares linear values.
    pub fn new(values: &RgbImage) -> Self {
        let roots = values.map(|v| v.max(Rgb::ZERO).map(f32::sqrt));
        let values = smoothed(&smoothed(&roots));
        Self { noise: noise(&values), values }
    }

    /// The smoothed square roots of the values.
    pub fn roots(&self) -> &RgbImage {
        &self.values
    }

    /// The standard deviation of their noise, all channels together.
    pub fn noise(&self) -> f32 {
        self.noise
    }

    /// The signed distance along `edgel.across` to the photograph's edge, in pixels, none if there
    /// is no clear one within `reach` pixels.
    pub fn offset(&self, edgel: &Edgel, reach: f32) -> Option<f32> {
        let (width, height) = (self.values.width() as f32, self.values.height() as f32);
        let margin = reach + 3.0;
        let inside = |v: f32, side: f32| v > margin && v < side - margin;
        if !inside(edgel.at.x, width) || !inside(edgel.at.y, height) {
            return None;
        }
        let half = (reach * PER_PIXEL as f32) as isize;
        let change: Vec<f32> = (-half..=half).map(|i| self.change(edgel, step(i))).collect();
        let strongest = (0..change.len()).max_by(|&a, &b| change[a].total_cmp(&change[b]))?;
        let peak = change[strongest];
        let mut sorted = change.clone();
        let middle = sorted.len() / 2;
        let median = *sorted.select_nth_unstable_by(middle, f32::total_cmp).1;
        let least = (ABOVE_NOISE * self.noise).max(ABOVE_LINE * median);
        if peak <= least.max(ABOVE_VALUE * self.sample(edgel.at).length()) {
            return None;
        }
        let apart = (WIDTH * PER_PIXEL as f32) as usize;
        let rival = |i: usize| i.abs_diff(strongest) > apart && change[i] > RIVAL * peak;
        if strongest == 0 || strongest + 1 == change.len() || (0..change.len()).any(rival) {
            return None;
        }
        // The top of the parabola through the strongest change and those beside it.
        let (before, after) = (change[strongest - 1], change[strongest + 1]);
        let bend = before - 2.0 * peak + after;
        let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        Some((strongest as f32 - half as f32 + shift) / PER_PIXEL as f32)
    }

    /// Whether the photograph has some edge within `reach` pixels of `edgel`, even if others beside it are as clear: a
    /// place where it changes more than before and after.
    pub fn has_edge(&self, edgel: &Edgel, reach: f32) -> bool {
        let (width, height) = (self.values.width() as f32, self.values.height() as f32);
        let margin = reach + 3.0;
        let inside = |v: f32, side: f32| v > margin && v < side - margin;
        if !inside(edgel.at.x, width) || !inside(edgel.at.y, height) {
            return false;
        }
        let half = (reach * PER_PIXEL as f32) as isize + 1;
        let change: Vec<f32> = (-half..=half).map(|i| self.change(edgel, step(i))).collect();
        let least = (ABOVE_NOISE * self.noise).max(ABOVE_VALUE * self.sample(edgel.at).length());
        change.windows(3).any(|w| w[1] > least && w[1] > w[0] && w[1] >= w[2])
    }

    /// How much the photograph changes across the point at `along`, over two pixels; the mean of
    /// three lines side by side.
    fn change(&self, edgel: &Edgel, along: f32) -> f32 {
        let beside = edgel.across.perp();
        let mean = |along: f32| -> Rgb {
            let at = edgel.at + edgel.across * along;
            [-1.0, 0.0, 1.0].map(|side| self.sample(at + beside * side)).iter().sum::<Rgb>() / 3.0
        };
        (mean(along + 1.0) - mean(along - 1.0)).length()
    }

    /// The value at a point, pixels from the top left; between the centres, bilinear.
    fn sample(&self, at: Vec2) -> Rgb {
        let corner = (at - 0.5).floor();
        let part = at - 0.5 - corner;
        let (x, y) = (corner.x as usize, corner.y as usize);
        let row = |y: usize| self.values.at(x, y).lerp(*self.values.at(x + 1, y), part.x);
        row(y).lerp(row(y + 1), part.y)
    }
}

fn step(i: isize) -> f32 {
    i as f32 / PER_PIXEL as f32
}

/// The mean over 3 x 3 pixels with the weights 1 2 1.
fn smoothed(values: &RgbImage) -> RgbImage {
    let (width, height) = (values.width(), values.height());
    let weight = |a: usize, b: usize| if a == b { 2.0 } else { 1.0 };
    RgbImage::from_fn(width, height, |x, y| {
        let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
        for n in values.neighbourhood(y * width + x) {
            let w = weight(n % width, x) * weight(n / width, y);
            sum += w * values.pixels()[n];
            weights += w;
        }
        sum / weights
    })
}

/// The noise of `values`, from the median difference of neighbours in a row.
fn noise(values: &RgbImage) -> f32 {
    let rows = values.pixels().chunks(values.width().max(1));
    let mut differences: Vec<f32> =
        rows.flat_map(|row| row.windows(2).map(|w| (w[1] - w[0]).length())).collect();
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    *differences.select_nth_unstable_by(middle, f32::total_cmp).1
}
