//! Importance sampling of the environment map.
//!
//! The panorama is bilinear within the cells between the centres of its pixels; at the poles half a
//! row is left. A cell is drawn with a probability proportional to the mean luminance of its
//! corners times its solid angle, which is exactly proportional to the difference of the cosines of
//! the polar angle. A direction is then drawn uniformly over the cell's solid angle, after [Pharr
//! et al. 2023, section 12.5]. The density is the cell's luminance over the integral of luminance;
//! it is bounded at the poles and positive wherever the radiance is.

use glam::Vec3;
use std::f64::consts::{PI, TAU};
use unrender_scene::color::luminance;
use unrender_scene::{Environment, Rgb};

/// An environment with its sampling distribution.
#[derive(Clone, Debug)]
pub struct EnvironmentSampler {
    environment: Environment,
    /// Cells in a row; the first lies between the centres of the first and the second column.
    columns: usize,
    /// The cosine of the polar angle at the start of each row of cells, and at the end of the last.
    cosines: Vec<f32>,
    /// Density of each cell over solid angle, sr^-1, row by row.
    densities: Vec<f32>,
    /// The cumulative distribution of the rows; ends with one.
    rows: Vec<f32>,
    /// For each row, the cumulative distribution of its cells; ends with one.
    cells: Vec<f32>,
    /// The integral of the radiance's luminance over all directions, W m^-2.
    flux: f32,
    /// The solid angle that the light comes from, sr.
    spread_sr: f32,
}

impl EnvironmentSampler {
    /// Prepares `environment`; none if it is black.
    pub fn new(environment: &Environment) -> Option<Self> {
        let panorama = environment.panorama();
        let (columns, height) = (panorama.width(), panorama.height());
        let at = |x: usize, y: usize| f64::from(luminance(*panorama.at(x % columns, y)));
        let cosine = |row: usize| (PI * ((row as f64 - 0.5) / height as f64).clamp(0.0, 1.0)).cos();
        let cosines: Vec<f64> = (0..=height + 1).map(cosine).collect();
        let mut brightness = Vec::with_capacity(columns * (height + 1));
        let mut rows = Vec::with_capacity(height + 1);
        let mut cells = Vec::with_capacity(columns * (height + 1));
        let mut squares = 0.0;
        for row in 0..=height {
            let (above, below) = (row.saturating_sub(1), row.min(height - 1));
            let mean = |x: usize| {
                0.25 * (at(x, above) + at(x + 1, above) + at(x, below) + at(x + 1, below))
            };
            let of_row: Vec<f64> = (0..columns).map(mean).collect();
            let solid_angle = TAU / columns as f64 * (cosines[row] - cosines[row + 1]);
            rows.push(of_row.iter().sum::<f64>() * solid_angle);
            squares += of_row.iter().map(|b| b * b).sum::<f64>() * solid_angle;
            cells.extend(cumulative(&of_row));
            brightness.extend(of_row);
        }
        let flux: f64 = rows.iter().sum();
        (flux > 0.0 && flux.is_finite()).then(|| Self {
            environment: environment.clone(),
            columns,
            cosines: cosines.iter().map(|c| *c as f32).collect(),
            densities: brightness.iter().map(|b| (b / flux) as f32).collect(),
            rows: cumulative(&rows).collect(),
            cells,
            flux: flux as f32,
            spread_sr: (flux * flux / squares) as f32,
        })
    }

    /// The solid angle that most of the light comes from, sr: the square of the integral of the
    /// luminance over that of its square, 4 pi if all directions are alike.
    pub fn spread_sr(&self) -> f32 {
        self.spread_sr
    }

    /// The integral of the radiance's luminance over all directions, W m^-2.
    pub fn flux(&self) -> f32 {
        self.flux
    }

    /// The radiance that arrives from the direction of the unit vector `wi`.
    pub fn radiance(&self, wi: Vec3) -> Rgb {
        self.environment.radiance(wi)
    }

    /// The density over solid angle with which [`EnvironmentSampler::sample`] draws `wi`.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let (u, _) = self.environment.place(wi);
        let height = self.environment.up().height(wi);
        // The cosines decrease; the last entry is the end of the last row.
        let row = self.cosines.partition_point(|&c| c > height).clamp(1, self.rows.len()) - 1;
        let column = (u * self.columns as f32 - 0.5).rem_euclid(self.columns as f32) as usize;
        self.densities[row * self.columns + column.min(self.columns - 1)]
    }

    /// Draws a direction from two numbers in [0, 1): the unit vector and its density over solid
    /// angle.
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

/// The cumulative distribution of `weights`; ends with one, or is all zeros.
fn cumulative(weights: &[f64]) -> impl Iterator<Item = f32> {
    let total: f64 = weights.iter().sum();
    let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
    weights.iter().scan(0.0, move |sum, weight| {
        *sum += weight * scale;
        Some(*sum as f32)
    })
}

/// The entry of a cumulative distribution that `u` falls into, and the position within it, 0 to 1.
fn draw(cumulative: &[f32], u: f32) -> (usize, f32) {
    let index = cumulative.partition_point(|&sum| sum <= u).min(cumulative.len() - 1);
    let before = if index == 0 { 0.0 } else { cumulative[index - 1] };
    let within = (u - before) / (cumulative[index] - before).max(f32::MIN_POSITIVE);
    (index, within.clamp(0.0, 1.0))
}
