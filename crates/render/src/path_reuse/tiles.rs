//! Tilings of a picture by squares, with an offset.

use super::SIDE;

/// A tiling by squares of [`SIDE`] pixels, those at the border cut.
pub(super) struct Tiling {
    /// Of the picture.
    size: (usize, usize),
    /// How far the first tile begins to the left of the picture, and above it.
    shift: (usize, usize),
    columns: usize,
    rows: usize,
}

impl Tiling {
    /// The tiles of a picture of `size`, moved to the upper left by `shift`, less than [`SIDE`].
    pub(super) fn new(size: (usize, usize), shift: (usize, usize)) -> Self {
        let count = |side: usize, shift: usize| (side + shift).div_ceil(SIDE);
        Self { size, shift, columns: count(size.0, shift.0), rows: count(size.1, shift.1) }
    }

    /// The number of tiles.
    pub(super) fn count(&self) -> usize {
        self.columns * self.rows
    }

    /// The pixels of a tile by index, row by row.
    pub(super) fn pixels(&self, tile: usize) -> impl Iterator<Item = u32> + Clone + use<> {
        let (width, height) = self.size;
        let (left, right) = ends(tile % self.columns, self.shift.0, width);
        let (top, bottom) = ends(tile / self.columns, self.shift.1, height);
        (top..bottom).flat_map(move |y| (left..right).map(move |x| (y * width + x) as u32))
    }

    /// The tile of a pixel, and the place of the pixel in the order of [`Tiling::pixels`].
    pub(super) fn place(&self, x: usize, y: usize) -> (usize, usize) {
        let (column, row) = ((x + self.shift.0) / SIDE, (y + self.shift.1) / SIDE);
        let (left, right) = ends(column, self.shift.0, self.size.0);
        let (top, _) = ends(row, self.shift.1, self.size.1);
        (row * self.columns + column, (y - top) * (right - left) + x - left)
    }
}

/// Where a tile begins and ends along one axis, within the picture.
fn ends(tile: usize, shift: usize, side: usize) -> (usize, usize) {
    ((tile * SIDE).saturating_sub(shift), ((tile + 1) * SIDE - shift).min(side))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_tile_at_its_place() {
        for size in [(1, 1), (8, 8), (17, 9), (5, 40)] {
            for shift in [(0, 0), (3, 7), (7, 1)] {
                let tiling = Tiling::new(size, shift);
                let mut found = vec![0; size.0 * size.1];
                for tile in 0..tiling.count() {
                    for (place, pixel) in tiling.pixels(tile).enumerate() {
                        let (x, y) = (pixel as usize % size.0, pixel as usize / size.0);
                        assert_eq!(tiling.place(x, y), (tile, place), "{size:?} {shift:?}");
                        found[pixel as usize] += 1;
                    }
                }
                assert!(found.iter().all(|count| *count == 1), "{size:?} {shift:?}");
            }
        }
    }
}
