//! Importance sampling of the environment map.
//!
//! The panorama is bilinear within the cells between the centres of its pixels; at the poles half a
//! row is left. A cell is drawn with a probability proportional to the mean luminance of its
//! corners times its solid angle, which is exactly proportional to the difference of the cosines of
//! the polar angle. A direction is then drawn uniformly over the cell's solid angle, after [Pharr
//! et al. 2023, section 12.5]. The density is the cell's luminance over the integral of luminance;
//! it is bounded at the poles and positive wherever the radiance is.

use crate::distribution::Distribution;
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
    /// The rows of cells, and in each the density of its cells over solid angle, sr^-1.
    rows: Distribution<Distribution<f32>>,
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
        let mut squares = 0.0;
        let row = |row: usize| {
            let (above, below) = (row.saturating_sub(1), row.min(height - 1));
            let mean = |x: usize| {
                0.25 * (at(x, above) + at(x + 1, above) + at(x, below) + at(x + 1, below))
            };
            let of_row: Vec<f64> = (0..columns).map(mean).collect();
            let solid_angle = TAU / columns as f64 * (cosines[row] - cosines[row + 1]);
            squares += of_row.iter().map(|b| b * b).sum::<f64>() * solid_angle;
            let flux = of_row.iter().sum::<f64>() * solid_angle;
            (of_row, flux)
        };
        let rows: Vec<(Vec<f64>, f64)> = (0..=height).map(row).collect();
        let flux: f64 = rows.iter().map(|row| row.1).sum();
        let cells = |of_row: Vec<f64>| {
            Distribution::new(of_row.into_iter().map(|b| ((b / flux) as f32, b)))
        };
        (flux > 0.0 && flux.is_finite()).then(|| Self {
            environment: environment.clone(),
            columns,
            cosines: cosines.iter().map(|c| *c as f32).collect(),
            rows: Distribution::new(rows.into_iter().map(|(row, flux)| (cells(row), flux))),
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
        *self.rows.at(row).at(column.min(self.columns - 1))
    }

    /// Draws a direction from two numbers in [0, 1): the unit vector and its density over solid
    /// angle.
    pub fn sample(&self, u: [f32; 2]) -> (Vec3, f32) {
        let (row, down) = self.rows.draw(u[1]);
        let cells = self.rows.at(row);
        let (column, right) = cells.draw(u[0]);
        let (top, bottom) = (self.cosines[row], self.cosines[row + 1]);
        let heading = (column as f32 + 0.5 + right) / self.columns as f32;
        let wi = self.environment.direction(heading, top + (bottom - top) * down);
        (wi, *cells.at(column))
    }
}
