//! Cross-filtering: each half is filtered with weights from the other one, so that weights are independent of the
//! noise that they average [Rousselle et al. 2012; Bitterli et al. 2016].
//!
//! Models are fitted at every other pixel of every other row, and each predicts all pixels that are similar to its own;
//! the predictions are averaged by weight (collaborative regression [Moon et al. 2014; Bitterli et al. 2016]).

use super::regression::Window;
use super::signal::{Planes, Signal};
use super::similarity::{self, OFFSETS, RADIUS, SIDE, Tile};
use glam::Vec3;
use rayon::prelude::*;
use unrender_scene::Rgb;

/// Pixels whose weight, to the power, is below this are not in a model, to save time. With half of it or double of it
/// the result is the same to a percent.
const WEIGHT_MIN: f32 = 0.01;
/// The least nearness that differences of nearness are divided by, 1/metres: that of a megametre. With half of it or
/// double of it nothing changes.
const NEARNESS_MIN: f32 = 1e-6;
/// The candidates: the power of the weights, 1 / k^2. k = 1 averages much, k = 1/2 keeps more of what the features do
/// not show [Bitterli et al. 2016].
pub(super) const POWERS: [i32; 2] = [1, 4];
/// The distance of pixels at which models are fitted. With 1 the time is four times as long, with 4 thin
/// features have no model of their own.
const STEP: usize = 2;
/// The size of tiles, pixels: their weights fit into a cache of a megabyte.
const TILE: (usize, usize) = (64, 32);
/// Tiles that are filtered before their predictions are added up: enough for many threads, few enough for memory.
const BATCH: usize = 64;
/// The weight of the pixel itself among the predictions: it stands alone where no other pixel is like it.
const OWN_WEIGHT: f32 = 0.05;

/// A half, filtered: for each candidate the signal of every pixel.
pub(super) type Filtered = [Vec<Rgb>; POWERS.len()];

/// Filters one half of the signal, with weights from the other.
pub(super) fn filter(signal: &Signal, half: usize) -> Filtered {
    let (width, height) = signal.size();
    let values = &signal.halves[half];
    let mut sums = POWERS.map(|_| -> Vec<Prediction> {
        let own = |pixel| Prediction { sum: OWN_WEIGHT * values.at(pixel), weight: OWN_WEIGHT };
        (0..width * height).map(own).collect()
    });
    let tiles = tiles(width, height);
    for batch in tiles.chunks(BATCH) {
        let predicted: Vec<_> =
            batch.par_iter().map(|tile| predictions(signal, half, tile)).collect();
        for (tile, predicted) in batch.iter().zip(predicted) {
            let grown = tile.grown(RADIUS, (width, height));
            for (sums, predicted) in sums.iter_mut().zip(predicted) {
                let rows = predicted.chunks(grown.columns.len().max(1));
                for (y, row) in grown.rows.clone().zip(rows) {
                    let place = y * width + grown.columns.start;
                    let sums = &mut sums[place..place + row.len()];
                    sums.iter_mut().zip(row).for_each(|(sum, prediction)| sum.add(prediction));
                }
            }
        }
    }
    sums.map(|sums| sums.iter().map(|prediction| prediction.sum / prediction.weight).collect())
}

/// A weighted sum of predictions of one pixel.
#[derive(Clone, Copy, Default)]
struct Prediction {
    sum: Vec3,
    weight: f32,
}

impl Prediction {
    fn add(&mut self, other: &Self) {
        self.sum += other.sum;
        self.weight += other.weight;
    }
}

fn tiles(width: usize, height: usize) -> Vec<Tile> {
    let rows = (0..height).step_by(TILE.1);
    let tile = |x: usize, y: usize| Tile {
        columns: x..(x + TILE.0).min(width),
        rows: y..(y + TILE.1).min(height),
    };
    rows.flat_map(|y| (0..width).step_by(TILE.0).map(move |x| tile(x, y))).collect()
}

/// The predictions of the models in `tile`: of all pixels of the tile and its margin, row by row, by candidate.
fn predictions(signal: &Signal, half: usize, tile: &Tile) -> [Vec<Prediction>; POWERS.len()] {
    let (width, height) = signal.size();
    let grown = tile.grown(RADIUS, (width, height));
    let values: &Planes = &signal.halves[half];
    let (picture, variance) = (&signal.halves[1 - half], &signal.variances[1 - half]);
    let weights = similarity::weights(picture, variance, signal.epsilon, tile, STEP);
    let place = |x: usize, y: usize| {
        (y - grown.rows.start) * grown.columns.len() + (x - grown.columns.start)
    };
    let empty = vec![Prediction::default(); grown.columns.len() * grown.rows.len()];
    let mut predictions = POWERS.map(|_| empty.clone());
    let mut window = Window::default();
    for ((x, y), weights) in tile.centres(STEP).zip(weights.chunks(OFFSETS)) {
        window.clear();
        let centre = signal.guides[y * width + x];
        for (offset, &weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            // Weights are zero outside of the picture.
            let (column, row) = (x + offset % SIDE - RADIUS, y + offset / SIDE - RADIUS);
            let pixel = row * width + column;
            let mut guide = signal.guides[pixel];
            guide.iter_mut().zip(centre).for_each(|(feature, centre)| *feature -= centre);
            guide[3] /= centre[3].max(NEARNESS_MIN);
            window.push(offset, weight, guide, values.at(pixel));
        }
        for (power, predictions) in POWERS.into_iter().zip(&mut predictions) {
            window.regress(power, WEIGHT_MIN, |offset, weight, value| {
                let (column, row) = (x + offset % SIDE - RADIUS, y + offset / SIDE - RADIUS);
                predictions[place(column, row)].add(&Prediction { sum: weight * value, weight });
            });
        }
    }
    predictions
}
