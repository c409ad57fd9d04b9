//! Where the noise of each number comes from: how much of its variance each cell of the picture would have with one path.
//!
//! With `n_c` paths in cell `c` the renderings' noise gives a number the variance `sum of a_c / n_c`. Of a roughness almost
//! all of it comes from a highlight and its feet, of a wall out of sight from where its light falls. For a given number
//! of paths, the variance is least if they are proportional to `sqrt(a_c)` [Neyman 1934].

use super::means::Mean;
use super::normal::Normal;
use super::sample::Cell;
use crate::observe::blocks::Place;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The variance of every number by one path of each cell.
#[derive(Default)]
pub(super) struct Origins(BTreeMap<Key, DVector<f64>>);

/// A cell by its group, its place, and whether it is clipped.
type Key = (usize, Place, bool);

impl Origins {
    /// From `means`, their `normal` equations and the `inverse` of the curvature. These must be other renderings than
    /// those whose paths are allocated by it: else more paths would go where bright ones were found by chance, fewer
    /// where they were missed, and the mean would be too dark.
    pub(super) fn of(means: &[Mean], normal: &Normal, inverse: &DMatrix<f64>) -> Self {
        let of_cell = |(index, mean): (usize, &Mean)| {
            let key = (mean.group, mean.place, mean.bound);
            (key, normal.variance_of_path((index, mean), inverse))
        };
        Self(means.par_iter().enumerate().map(of_cell).collect())
    }

    /// For each of `cells`: the variances of the numbers, of which there are so many. Each is the mean over the cell and
    /// those around it: the derivatives of one are noisy.
    pub(super) fn of_cells(&self, cells: &[Cell], numbers: usize) -> Vec<DVector<f64>> {
        let of_cell = |cell: &Cell| {
            let places = cell.place.around();
            let near = places.filter_map(|place| self.0.get(&(cell.group, place, cell.bound)));
            let none = (DVector::zeros(numbers), 0.0);
            let (sum, count) = near.fold(none, |(sum, count), one| (sum + one, count + 1.0));
            sum / f64::max(count, 1.0)
        };
        cells.iter().map(of_cell).collect()
    }
}
