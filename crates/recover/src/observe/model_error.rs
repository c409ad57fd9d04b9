//! The observation model: what a residual may come from, besides a wrong hypothesis.
//!
//! `pixel = model + photograph's noise + rendering noise + model error`.
//!
//! - The **photograph's noise** is measured ([`crate::observe::observation`]) and taken at the model's
//!   brightness, never at the photograph's own: dark pixels would dominate.
//! - The **rendering noise** is that of the two halves' difference.
//! - The **model error** is what no model of a real scene gets right: geometry, lights, a reflectance
//!   that is not exactly the lobe. It has two parts. One changes slowly over a surface: the light
//!   that arrives there is wrong by an amount that varies with place and orientation
//!   ([`LightField`]). The other is independent from block to block, with the standard deviation
//!   `share * level`, `level^2 = (g^2 + m^2) / 2` for the group's mean light `g` and the local light
//!   `m`: the first keeps dark pixels from dominating, the second lets bright ones be wrong in proportion. The sizes of
//!   both are those that make the group's residuals most likely ([`crate::compare::likelihood::Likelihood::of`]).
//!
//! Fits weight by the inverse of these variances, model selection compares squared residuals in units of them
//! ([`crate::selection`]), and the report judges by them what is not explained.
//!
//! A robust loss is not used: a highlight is a minority of bright pixels that a diffuse hypothesis
//! does not explain, and every robust loss throws it away as an outlier. What may be an outlier is
//! decided by physics, after the hypotheses have competed ([`crate::outliers`]).

use crate::observe::blocks::Blocks;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use unrender_render::GeometryBuffers;
use unrender_scene::Rgb;
use unrender_scene::Sheet;

/// How much model error is allowed for before anything else is called wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Allowance {
    /// That of the incident light, slow over a surface.
    pub light: LightError,
    /// The least that is independent from block to block.
    pub floor: ModelError,
}

/// The model error of a group that is independent from block to block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelError {
    /// Its standard deviation as a share of the local level.
    pub share: f64,
}

/// A channel that a group hardly reflects counts as if its mean light were this share of the
/// brightest channel's: a model error of a black channel would be a share of nothing. At half or
/// double, the uncertainty of nearly black channels is half or twice as large.
const DARK: f32 = 0.1;

/// The squared level that a model error is a share of: the mean of the squares of the group's mean
/// light and of the local light.
pub fn level2(mean: Rgb, local: Rgb) -> Rgb {
    let mean = mean.max(Rgb::splat(DARK * mean.max_element()));
    (0.5 * (mean * mean + local * local)).max(Rgb::splat(f32::MIN_POSITIVE))
}

/// Levels follow a model that is brighter than the photograph around a pixel up to about this many times only: with
/// weights from its own light alone, a lobe could grow brighter and brighter at less and less cost. At half of it the
/// photograph's dark pixels begin to dominate, at double sharp lobes grow.
const BRIGHTER: f32 = 2.0;

/// Levels are at least this share of the brighter one of model and photograph: where one is black, an error is still
/// relative to something. A third of the first code of sRGB beside white, so that no
/// photograph of 8 bits shows less; the inverse of its square, 10^8, leaves single precision thirty digits.
pub(crate) const FAINTEST: f32 = 1e-4;

/// A group's mean and local `light`, limited for levels and noise by the mean and local light that
/// the photograph `shows`.
pub fn followed(light: (Rgb, Rgb), shows: (Rgb, Rgb)) -> (Rgb, Rgb) {
    let least = |light: Rgb, shows: Rgb| FAINTEST * light.max(shows).max(Rgb::ZERO);
    let local = light.1.min(shows.0 + BRIGHTER * shows.1);
    let mean = light.0.min(BRIGHTER * shows.0);
    (mean.max(least(light.0, shows.0)), local.max(least(light.1, shows.1)))
}

impl ModelError {
    /// Before any residual is seen. It weights the first fit alone: at half or double of it the
    /// following fits are the same.
    pub const START: Self = Self { share: 0.05 };

    /// The weight of one pixel, of which there are `pixels` in its block: the inverse of its variance.
    /// The noise of a block's pixels averages out, their model error does not.
    pub fn weight(self, noise: Rgb, level2: Rgb, pixels: f32) -> Rgb {
        let model = (self.share * self.share) as f32 * pixels * level2;
        (noise + model).max(Rgb::splat(f32::MIN_POSITIVE)).recip()
    }
}

/// The standard deviation of the incident light's error that changes slowly over a surface, as a
/// share of the light. While the other groups' reflectances are rough estimates, their light on each other is wrong by
/// some percent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightError {
    /// The share.
    pub share: f64,
}

/// Functions of a [`LightField`] at most: a constant, the place and its squares, the normal.
pub(crate) const FUNCTIONS: usize = 13;

/// How the incident light of a group may be wrong: in each photograph, which may be under other lamps, by an amount of
/// its own.
#[derive(Clone, Debug, PartialEq)]
pub struct LightField {
    /// One for each photograph that has blocks.
    pub(crate) photographs: Vec<FieldOfPhotograph>,
    /// The least standard deviation of each field.
    pub(crate) least: LightError,
}

/// How the light in one photograph may be wrong: functions of place and orientation, one row a block, each of unit mean
/// square over the blocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct FieldOfPhotograph {
    /// Its blocks, by their numbers among all.
    pub(crate) blocks: Vec<usize>,
    /// For each of them the values of the functions; zero beyond their number.
    pub(crate) rows: Vec<[f64; FUNCTIONS]>,
    /// The number of functions.
    pub(crate) count: usize,
}

impl LightField {
    /// The field of `blocks` of `pixels`: in each photograph a constant, the place and its squares, the normal.
    pub fn of(
        blocks: &Blocks,
        pixels: &[u32],
        (sheet, geometry): (&Sheet, &GeometryBuffers),
        least: LightError,
    ) -> Self {
        let point = |&pixel: &u32| place_of(pixel, sheet, geometry);
        let normal = |&pixel: &u32| geometry.pixels()[pixel as usize].normal;
        let points: Vec<Vec3> = pixels.iter().map(point).collect();
        let normals: Vec<Vec3> = pixels.iter().map(normal).collect();
        let points = blocks.mean_where(&points, |_| true);
        let normals = blocks.mean_where(&normals, |_| true);
        let mut of_photograph: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (block, place) in blocks.places.iter().enumerate() {
            of_photograph.entry(place.photograph).or_default().push(block);
        }
        let field = |own: Vec<usize>| {
            let of_own = |values: &[Vec3]| own.iter().map(|k| values[*k]).collect::<Vec<Vec3>>();
            let (points, normals) = (of_own(&points), of_own(&normals));
            FieldOfPhotograph::of(own, &points, &normals)
        };
        Self::uniting(of_photograph.into_values().map(field).collect(), least)
    }

    /// A field without any function but a constant, for blocks of which nothing else is known.
    pub fn constant(blocks: usize, least: LightError) -> Self {
        let constant =
            FieldOfPhotograph::from_columns((0..blocks).collect(), vec![vec![1.0; blocks]]);
        Self::uniting(vec![constant], least)
    }

    pub(crate) fn uniting(photographs: Vec<FieldOfPhotograph>, least: LightError) -> Self {
        Self { photographs, least }
    }

    /// The field of the blocks that are left without the pixels that are flagged.
    #[must_use]
    pub fn without(&self, blocks: &Blocks, flags: &[bool]) -> Self {
        let mut left = vec![false; blocks.len()];
        let kept = blocks.of_pixel.iter().zip(flags).filter(|(_, flag)| !**flag);
        kept.for_each(|(block, _)| left[*block as usize] = true);
        let mut next = 0;
        let number = |left: &bool| {
            next += usize::from(*left);
            left.then(|| next - 1)
        };
        let numbers: Vec<Option<usize>> = left.iter().map(number).collect();
        let photographs = self.photographs.iter().map(|field| field.renumbered(&numbers));
        Self { photographs: photographs.collect(), ..*self }
    }
}

impl FieldOfPhotograph {
    /// The field of the blocks `own` at these places with these normals.
    fn of(own: Vec<usize>, points: &[Vec3], normals: &[Vec3]) -> Self {
        let (point, normal) = (centred(points), centred(normals));
        let mut columns: Vec<Vec<f64>> = vec![vec![1.0; own.len()]];
        for axis in 0..3 {
            columns.push(point.iter().map(|p| f64::from(p[axis])).collect());
            columns.push(normal.iter().map(|n| f64::from(n[axis])).collect());
        }
        for (a, b) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
            columns.push(point.iter().map(|p| f64::from(p[a] * p[b])).collect());
        }
        Self::from_columns(own, columns)
    }

    fn from_columns(blocks: Vec<usize>, columns: Vec<Vec<f64>>) -> Self {
        let mut field = Self { rows: vec![[0.0; FUNCTIONS]; blocks.len()], blocks, count: 0 };
        for column in columns {
            let squares: f64 = column.iter().map(|v| v * v).sum();
            let size = (squares / column.len().max(1) as f64).sqrt();
            if size > 1e-6 {
                let Self { rows, count, .. } = &mut field;
                rows.iter_mut().zip(column).for_each(|(row, v)| row[*count] = v / size);
                *count += 1;
            }
        }
        field
    }

    /// Its blocks with their values.
    pub(crate) fn blocks(&self) -> impl Iterator<Item = (usize, &[f64; FUNCTIONS])> {
        self.blocks.iter().copied().zip(&self.rows)
    }

    /// The field of those blocks that have new `numbers`.
    fn renumbered(&self, numbers: &[Option<usize>]) -> Self {
        let left = self.blocks().filter_map(|(k, row)| Some((numbers[k]?, *row)));
        let (blocks, rows) = left.unzip();
        Self { blocks, rows, count: self.count }
    }
}

/// Where the surface behind a pixel is, in units that only depend on the camera; the origin without one.
fn place_of(pixel: u32, sheet: &Sheet, geometry: &GeometryBuffers) -> Vec3 {
    let [_, first_row, width, height] = sheet.place(sheet.photograph_of(pixel));
    let depth = geometry.pixels()[pixel as usize].depth;
    if !depth.is_finite() {
        return Vec3::ZERO;
    }
    let (x, y) = (pixel as usize % geometry.width(), pixel as usize / geometry.width() - first_row);
    let (width, height) = (width as f32, height as f32);
    let (x, y) = ((x as f32 - 0.5 * width) / width, (y as f32 - 0.5 * height) / width);
    depth * Vec3::new(x, y, 1.0)
}

fn centred(values: &[Vec3]) -> Vec<Vec3> {
    let mean = values.iter().copied().sum::<Vec3>() / values.len().max(1) as f32;
    let spread = values.iter().map(|v| v.distance(mean)).fold(1e-20, f32::max);
    values.iter().map(|v| (*v - mean) / spread).collect()
}
