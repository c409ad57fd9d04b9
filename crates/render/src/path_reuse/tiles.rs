//! Squares that cover a picture.

use super::SIDE;

/// Squares of [`SIDE`] pixels, those at the border cut.
pub(super) struct Grid {
    /// The picture's.
    size: (usize, usize),
    /// How far the first square begins to the left of the picture, and above it.
    shift: (usize, usize),
    columns: usize,
    rows: usize,
}

impl Grid {
    /// The squares of a picture of `size`, moved to the upper left by `shift`, less than [`SIDE`].
    pub(super) fn new(size: (usize, usize), shift: (usize, usize)) -> Self {
        let count = |side: usize, shift: usize| (side + shift).div_ceil(SIDE);
        Self { size, shift, columns: count(size.0, shift.0), rows: count(size.1, shift.1) }
    }

    /// How many there are.
    pub(super) fn squares(&self) -> usize {
        self.columns * self.rows
    }

    /// The pixels of a square by index, row by row.
    pub(super) fn pixels(&self, square: usize) -> impl Iterator<Item = u32> + Clone + use<> {
        let (width, height) = self.size;
        let (left, right) = ends(square % self.columns, self.shift.0, width);
        let (top, bottom) = ends(square / self.columns, self.shift.1, height);
        (top..bottom).flat_map(move |y| (left..right).map(move |x| (y * width + x) as u32))
    }

    /// The square of a pixel, and where it comes among that square's pixels.
    pub(super) fn place(&self, x: usize, y: usize) -> (usize, usize) {
        let (column, row) = ((x + self.shift.0) / SIDE, (y + self.shift.1) / SIDE);
        let (left, right) = ends(column, self.shift.0, self.size.0);
        let (top, _) = ends(row, self.shift.1, self.size.1);
        (row * self.columns + column, (y - top) * (right - left) + x - left)
    }
}

/// Where a square begins and ends in one direction, within the picture.
fn ends(square: usize, shift: usize, side: usize) -> (usize, usize) {
    ((square * SIDE).saturating_sub(shift), ((square + 1) * SIDE - shift).min(side))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_is_in_one_square_at_its_place() {
        for size in [(1, 1), (8, 8), (17, 9), (5, 40)] {
            for shift in [(0, 0), (3, 7), (7, 1)] {
                let grid = Grid::new(size, shift);
                let mut seen = vec![0; size.0 * size.1];
                for square in 0..grid.squares() {
                    for (place, pixel) in grid.pixels(square).enumerate() {
                        let (x, y) = (pixel as usize % size.0, pixel as usize / size.0);
                        assert_eq!(grid.place(x, y), (square, place), "{size:?} {shift:?}");
                        seen[pixel as usize] += 1;
                    }
                }
                assert!(seen.iter().all(|count| *count == 1), "{size:?} {shift:?}");
            }
        }
    }
}
