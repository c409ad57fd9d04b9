//! A raster: row-major pixels, (0, 0) at the top left, pixel centres at (x + 0.5, y + 0.5).

use crate::Rgb;
use serde::Serialize;

/// A `width` x `height` raster of `T`, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Default, Serialize)]
pub struct Image<T> {
    width: usize,
    height: usize,
    pixels: Vec<T>,
}

/// A picture of linear RGB values.
pub type RgbImage = Image<Rgb>;

impl<T> Image<T> {
    /// An image from its pixels in row-major order.
    ///
    /// # Panics
    /// If `pixels.len() != width * height`: the caller has mixed up its sizes.
    pub fn new(width: usize, height: usize, pixels: Vec<T>) -> Self {
        assert_eq!(pixels.len(), width * height, "an image needs width x height pixels");
        Self { width, height, pixels }
    }

    /// An image whose pixel (x, y) is `f(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut f: impl FnMut(usize, usize) -> T) -> Self {
        let pixels = (0..width * height).map(|i| f(i % width, i / width)).collect();
        Self { width, height, pixels }
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row; pixel (x, y) has index `y * width + x`.
    pub fn pixels(&self) -> &[T] {
        &self.pixels
    }

    /// All pixels, row by row, as the vector that they are in.
    pub fn into_pixels(self) -> Vec<T> {
        self.pixels
    }

    /// All pixels, row by row, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [T] {
        &mut self.pixels
    }

    /// The pixel in column `x` of row `y`.
    pub fn at(&self, x: usize, y: usize) -> &T {
        &self.pixels[y * self.width + x]
    }

    /// The same raster with left and right exchanged.
    #[must_use]
    pub fn mirrored(&self) -> Self
    where
        T: Clone,
    {
        let rows = self.pixels.chunks(self.width.max(1));
        let pixels = rows.flat_map(|row| row.iter().rev().cloned()).collect();
        Self { width: self.width, height: self.height, pixels }
    }

    /// The same raster with every pixel passed through `f`.
    pub fn map<U>(&self, f: impl FnMut(&T) -> U) -> Image<U> {
        Image {
            width: self.width,
            height: self.height,
            pixels: self.pixels.iter().map(f).collect(),
        }
    }

    /// The up to eight neighbours of pixel `index` and the pixel itself, as indices.
    pub fn neighbourhood(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = (index % self.width, index / self.width);
        let rows = y.saturating_sub(1)..(y + 2).min(self.height);
        rows.flat_map(move |row| {
            (x.saturating_sub(1)..(x + 2).min(self.width)).map(move |col| row * self.width + col)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbourhoods_stop_at_the_border() {
        let image = Image::new(3, 2, vec![0; 6]);
        assert_eq!(image.neighbourhood(0).collect::<Vec<_>>(), [0, 1, 3, 4]);
        assert_eq!(image.neighbourhood(4).count(), 6);
    }
}
