//! Pictures over surfaces, by their texture coordinates.

use crate::{Image, Rgb};
use glam::Vec2;
use serde::{Deserialize, Serialize};

/// How a picture continues beyond its edge: the wrapping modes of glTF's samplers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Wrap {
    /// Repeated.
    #[default]
    Repeat,
    /// Repeated, every other time mirrored.
    MirroredRepeat,
    /// Clamped to the outermost texel.
    ClampToEdge,
}

impl Wrap {
    /// The texel of 0..`size` at the integer position `texel`.
    pub fn apply(self, texel: i64, size: usize) -> usize {
        let size = size as i64;
        let wrapped = match self {
            Self::Repeat => texel.rem_euclid(size),
            Self::MirroredRepeat => {
                let folded = texel.rem_euclid(2 * size);
                folded.min(2 * size - 1 - folded)
            }
            Self::ClampToEdge => texel.clamp(0, size - 1),
        };
        wrapped as usize
    }
}

/// A picture over a surface, mapped by `TEXCOORD_0`.
///
/// glTF's orientation: uv (0, 0) is the top left corner of the picture, (1, 1) the bottom right.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(bound(deserialize = "T: Deserialize<'de>"))]
pub struct Mapped<T> {
    /// The picture.
    pub image: Image<T>,
    /// Wrapping at the left and right edges.
    pub wrap_u: Wrap,
    /// Wrapping at the upper and lower edges.
    pub wrap_v: Wrap,
}

/// A diffuse reflectance texture: linear reflectance, 0 to 1 per channel.
pub type Texture = Mapped<Rgb>;

/// The four texels about a place, row by row, and how far it lies from the first towards the last of each row and column.
struct Around<T> {
    texels: [[T; 2]; 2],
    across: f32,
    down: f32,
}

impl<T: Copy> Mapped<T> {
    fn around(&self, uv: Vec2) -> Around<T> {
        let (width, height) = (self.image.width(), self.image.height());
        let x = uv.x * width as f32 - 0.5;
        let y = uv.y * height as f32 - 0.5;
        let (x0, y0) = (x.floor(), y.floor());
        let (across, down) = (x - x0, y - y0);
        let (x0, y0) = (x0 as i64, y0 as i64);
        let texel = |dx: i64, dy: i64| {
            let column = self.wrap_u.apply(x0.saturating_add(dx), width);
            let row = self.wrap_v.apply(y0.saturating_add(dy), height);
            *self.image.at(column, row)
        };
        Around { texels: [0, 1].map(|dy| [0, 1].map(|dx| texel(dx, dy))), across, down }
    }
}

impl Mapped<Rgb> {
    /// The same picture times `factor`.
    pub fn scaled(&self, factor: f32) -> Self {
        let image = self.image.map(|texel| *texel * factor);
        Self { image, wrap_u: self.wrap_u, wrap_v: self.wrap_v }
    }

    /// The bilinearly interpolated value at `uv`.
    ///
    /// ```
    /// use glam::Vec2;
    /// use unrender_scene::{Image, Rgb, Texture, Wrap};
    ///
    /// let image = Image::new(2, 1, vec![Rgb::ZERO, Rgb::ONE]);
    /// let texture = Texture { image, wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::Repeat };
    /// assert_eq!(texture.sample(Vec2::new(0.25, 0.5)), Rgb::ZERO);
    /// assert_eq!(texture.sample(Vec2::new(0.5, 0.5)), Rgb::splat(0.5));
    /// assert_eq!(texture.sample(Vec2::new(7.0, 0.5)), Rgb::ONE);
    /// ```
    pub fn sample(&self, uv: Vec2) -> Rgb {
        let Around { texels, across, down } = self.around(uv);
        let [top, bottom] = texels.map(|[left, right]| left.lerp(right, across));
        top.lerp(bottom, down)
    }
}

impl Mapped<f32> {
    /// The bilinearly interpolated value at `uv`.
    pub fn sample(&self, uv: Vec2) -> f32 {
        let Around { texels, across, down } = self.around(uv);
        let between = |a: f32, b: f32, share: f32| a * (1.0 - share) + b * share;
        let [top, bottom] = texels.map(|[left, right]| between(left, right, across));
        between(top, bottom, down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_follow_gltf() {
        let at = |wrap: Wrap| (-2..6).map(|i| wrap.apply(i, 3)).collect::<Vec<_>>();
        assert_eq!(at(Wrap::Repeat), [1, 2, 0, 1, 2, 0, 1, 2]);
        assert_eq!(at(Wrap::MirroredRepeat), [1, 0, 0, 1, 2, 2, 1, 0]);
        assert_eq!(at(Wrap::ClampToEdge), [0, 0, 0, 1, 2, 2, 2, 2]);
    }

    #[test]
    fn texel_centres_return_the_texel() {
        let image = Image::from_fn(4, 2, |x, y| Rgb::splat((x + 4 * y) as f32));
        let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
        let value = texture.sample(Vec2::new(2.5 / 4.0, 1.5 / 2.0));
        assert_eq!(value, Rgb::splat(6.0));
    }
}
