//! Directions to the environment, drawn by how bright it is.
//!
//! The panorama is divided into cells between the centres of its pixels, within which it is
//! bilinear; at the poles half a row is left. A cell is drawn with a probability proportional to
//! the mean luminance of its corners times its solid angle (the sine of the polar angle, exactly:
//! the difference of the cosines), then a direction in it uniformly over the solid angle [after
//! Pharr, Jakob and Humphreys, *Physically Based Rendering*, 4th ed., section 12.5]. The density is
//! the cell's luminance over the luminance of all directions, has no pole, and is positive wherever
//! light comes from.

use glam::Vec3;
use std::f64::consts::{PI, TAU};
use unrender_scene::color::luminance;
use unrender_scene::{Environment, Rgb};

/// An environment that can be sampled.
#[derive(Clone, Debug)]
pub struct EnvironmentSampler {
    environment: Environment,
    /// Cells in a row; the first lies between the centres of the first and the second column.
    columns: usize,
    /// For each row of cells, and their end: the cosine of the polar angle where it begins.
    cosines: Vec<f32>,
    /// Density of each cell over solid angle, sr^-1, row by row.
    densities: Vec<f32>,
    /// Running sums of the probabilities of the rows; ends with one.
    rows: Vec<f32>,
    /// For each row, the running sums of the probabilities of its cells; ends with one.
    cells: Vec<f32>,
    /// The integral of the radiance's luminance over all directions, W m^-2.
    flux: f32,
}

impl EnvironmentSampler {
    /// Prepares `environment`; nothing if no light comes from it.
    pub fn new(environment: &Environment) -> Option<Self> {
        let panorama = environment.panorama();
        let (columns, height) = (panorama.width(), panorama.height());
        let at = |x: usize, y: usize| f64::from(luminance(*panorama.at(x % columns, y)));
        let cosine = |row: usize| (PI * ((row as f64 - 0.5) / height as f64).clamp(0.0, 1.0)).cos();
        let cosines: Vec<f64> = (0..=height + 1).map(cosine).collect();
        let mut brightness = Vec::with_capacity(columns * (height + 1));
        let mut rows = Vec::with_capacity(height + 1);
        let mut cells = Vec::with_capacity(columns * (height + 1));
        for row in 0..=height {
            let (above, below) = (row.saturating_sub(1), row.min(height - 1));
            let mean = |x: usize| {
                0.25 * (at(x, above) + at(x + 1, above) + at(x, below) + at(x + 1, below))
            };
            let of_row: Vec<f64> = (0..columns).map(mean).collect();
            let solid_angle = TAU / columns as f64 * (cosines[row] - cosines[row + 1]);
            rows.push(of_row.iter().sum::<f64>() * solid_angle);
            cells.extend(running_shares(&of_row));
            brightness.extend(of_row);
        }
        let flux: f64 = rows.iter().sum();
        (flux > 0.0 && flux.is_finite()).then(|| Self {
            environment: environment.clone(),
            columns,
            cosines: cosines.iter().map(|c| *c as f32).collect(),
            densities: brightness.iter().map(|b| (b / flux) as f32).collect(),
            rows: running_shares(&rows).collect(),
            cells,
            flux: flux as f32,
        })
    }

    /// The integral of the radiance's luminance over all directions, W m^-2.
    pub fn flux(&self) -> f32 {
        self.flux
    }

    /// The radiance that arrives along the unit vector `wi` from far away.
    pub fn radiance(&self, wi: Vec3) -> Rgb {
        self.environment.radiance(wi)
    }

    /// The density over solid angle with which [`EnvironmentSampler::sample`] draws `wi`.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let (u, _) = self.environment.place(wi);
        // The cosines fall; the last entry is the end of the last row.
        let row = self.cosines.partition_point(|&c| c > wi.y).clamp(1, self.rows.len()) - 1;
        let column = (u * self.columns as f32 - 0.5).rem_euclid(self.columns as f32) as usize;
        self.densities[row * self.columns + column.min(self.columns - 1)]
    }

    /// Draws a direction to the environment from two numbers in [0, 1): the unit vector and its
    /// density over solid angle.
    pub fn sample(&self, u: [f32; 2]) -> (Vec3, f32) {
        let (row, down) = draw(&self.rows, u[1]);
        let first = row * self.columns;
        let (column, right) = draw(&self.cells[first..first + self.columns], u[0]);
        let (top, bottom) = (self.cosines[row], self.cosines[row + 1]);
        let heading = (column as f32 + 0.5 + right) / self.columns as f32;
        let wi = self.environment.direction(heading, top + (bottom - top) * down);
        (wi, self.densities[first + column])
    }
}

/// The running sums of `weights` over their sum; ends with one, or is all zeros.
fn running_shares(weights: &[f64]) -> impl Iterator<Item = f32> {
    let total: f64 = weights.iter().sum();
    let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
    weights.iter().scan(0.0, move |sum, weight| {
        *sum += weight * scale;
        Some(*sum as f32)
    })
}

/// The entry that `u` falls into by running sums, and where in it, both from 0 to 1.
fn draw(running: &[f32], u: f32) -> (usize, f32) {
    let index = running.partition_point(|&sum| sum <= u).min(running.len() - 1);
    let before = if index == 0 { 0.0 } else { running[index - 1] };
    let within = (u - before) / (running[index] - before).max(f32::MIN_POSITIVE);
    (index, within.clamp(0.0, 1.0))
}
