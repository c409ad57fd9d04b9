//! Several photographs as one picture: each stands below the one before it, with empty rows between.
//!
//! All code that reads the photograph addresses the pixels of one picture. With a sheet it need not know how many
//! photographs there are: evidence, fits and comparisons add over the pixels of all of them. Code that reads neighbours
//! (edges, noise, outliers, textures) never mixes two photographs, as there are empty rows between them. Only blocks of
//! pixels, the renderer and properties of one camera depend on the photograph of a pixel.

use crate::Image;

/// The empty rows between two photographs are one in so many of the highest one's, more than any neighbourhood reaches.
/// At half of this number the empty rows are a fifth of the memory; double was not tried.
const GAP: usize = 8;
/// And at least so many: more than the side of a block of the refinement, eight.
const GAP_MIN: usize = 16;

/// Where photographs stand in a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sheet {
    width: usize,
    height: usize,
    shots: Vec<Shot>,
}

/// A photograph's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shot {
    first_row: usize,
    width: usize,
    height: usize,
}

impl Sheet {
    /// The sheet of photographs of these widths and heights, pixels. That of one is the photograph itself.
    pub fn of(sizes: &[(usize, usize)]) -> Self {
        let highest = sizes.iter().map(|size| size.1).max().unwrap_or(0);
        let gap = (highest / GAP).max(GAP_MIN);
        let (mut shots, mut end) = (Vec::with_capacity(sizes.len()), 0);
        for &(width, height) in sizes {
            let first_row = if shots.is_empty() { 0 } else { end + gap };
            shots.push(Shot { first_row, width, height });
            end = first_row + height;
        }
        let width = sizes.iter().map(|size| size.0).max().unwrap_or(0);
        Self { width, height: end, shots }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// The number of photographs.
    pub fn photographs(&self) -> usize {
        self.shots.len()
    }

    /// The pixels to sample in all photographs if `count` are enough for one: a highlight in one of them has as many as
    /// if it were alone.
    pub fn of_all(&self, count: usize) -> usize {
        count.saturating_mul(self.shots.len())
    }

    /// The rows of the highest photograph.
    pub fn highest(&self) -> usize {
        self.shots.iter().map(|shot| shot.height).max().unwrap_or(0)
    }

    /// The first pixel's column and row, the width and the height of `photograph`.
    pub fn place(&self, photograph: usize) -> [usize; 4] {
        let Shot { first_row, width, height } = self.shots[photograph];
        [0, first_row, width, height]
    }

    /// The photograph of `pixel`; for an empty one, that above it.
    pub fn photograph_of(&self, pixel: u32) -> usize {
        let row = pixel as usize / self.width.max(1);
        self.shots.partition_point(|shot| shot.first_row <= row).saturating_sub(1)
    }

    /// The number of `pixel` in its photograph; none for an empty one.
    pub fn in_photograph(&self, pixel: u32) -> Option<u32> {
        let shot = self.shots[self.photograph_of(pixel)];
        let (x, y) = (pixel as usize % self.width, pixel as usize / self.width);
        let is_there = x < shot.width && y < shot.first_row + shot.height;
        is_there.then(|| ((y - shot.first_row) * shot.width + x) as u32)
    }

    /// The pixel that is number `local` of `photograph`.
    pub fn pixel(&self, photograph: usize, local: u32) -> u32 {
        let shot = self.shots[photograph];
        let (x, y) = (local as usize % shot.width, local as usize / shot.width);
        ((shot.first_row + y) * self.width + x) as u32
    }

    /// Puts `pictures`, one a photograph, onto the sheet; `empty` is between them.
    ///
    /// # Panics
    /// If one is not of its photograph's size.
    pub fn stack<'a, T: Clone + 'a>(
        &self,
        pictures: impl IntoIterator<Item = &'a Image<T>>,
        empty: &T,
    ) -> Image<T> {
        let mut pixels = vec![empty.clone(); self.width * self.height];
        for (picture, shot) in pictures.into_iter().zip(&self.shots) {
            assert_eq!((picture.width(), picture.height()), (shot.width, shot.height));
            let rows = picture.pixels().chunks(shot.width.max(1));
            for (row, from) in (shot.first_row..).zip(rows) {
                let first = row * self.width;
                pixels[first..first + shot.width].clone_from_slice(from);
            }
        }
        Image::new(self.width, self.height, pixels)
    }

    /// The part of `picture` that is of `photograph`.
    pub fn cut<T: Clone>(&self, picture: &Image<T>, photograph: usize) -> Image<T> {
        if self.shots.len() == 1 {
            return picture.clone();
        }
        let shot = self.shots[photograph];
        let at = |x: usize, y: usize| picture.at(x, shot.first_row + y).clone();
        Image::from_fn(shot.width, shot.height, at)
    }

    /// The sheet of pictures with `side` x `side` pixels for each pixel.
    #[must_use]
    pub fn finer(&self, side: usize) -> Self {
        let shot = |shot: &Shot| Shot {
            first_row: side * shot.first_row,
            width: side * shot.width,
            height: side * shot.height,
        };
        let shots = self.shots.iter().map(shot).collect();
        Self { width: side * self.width, height: side * self.height, shots }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_go_onto_the_sheet_and_back() {
        let sheet = Sheet::of(&[(3, 2), (2, 5), (4, 1)]);
        assert_eq!(sheet.size(), (4, 2 + 5 + 1 + 2 * GAP_MIN));
        let pictures = [(3, 2, 10), (2, 5, 20), (4, 1, 40)].map(|(width, height, first)| {
            Image::from_fn(width, height, |x, y| first + y * width + x)
        });
        let stacked = sheet.stack(&pictures, &0);
        for (k, picture) in pictures.iter().enumerate() {
            assert_eq!(&sheet.cut(&stacked, k), picture);
            for (local, value) in picture.pixels().iter().enumerate() {
                let pixel = sheet.pixel(k, local as u32);
                assert_eq!(stacked.pixels()[pixel as usize], *value);
                assert_eq!(
                    (sheet.photograph_of(pixel), sheet.in_photograph(pixel)),
                    (k, Some(local as u32))
                );
            }
        }
        let filled = stacked.pixels().iter().filter(|value| **value > 0).count();
        assert_eq!(filled, 6 + 10 + 4);
    }

    #[test]
    fn the_sheet_of_one_photograph_is_the_photograph() {
        let sheet = Sheet::of(&[(5, 4)]);
        let picture = Image::from_fn(5, 4, |x, y| y * 5 + x);
        assert_eq!(sheet.size(), (5, 4));
        assert_eq!(sheet.stack([&picture], &0), picture);
        assert_eq!(
            (sheet.pixel(0, 7), sheet.in_photograph(7), sheet.photograph_of(7)),
            (7, Some(7), 0)
        );
    }

    #[test]
    fn a_finer_sheet_has_its_photographs_in_the_same_places() {
        let sheet = Sheet::of(&[(3, 2), (2, 5)]);
        let finer = sheet.finer(4);
        let [x, y, width, height] = sheet.place(1);
        assert_eq!(finer.place(1), [4 * x, 4 * y, 4 * width, 4 * height]);
        assert_eq!(finer.size(), (4 * sheet.size().0, 4 * sheet.size().1));
    }
}
