//! Textures for programs that repeat a picture or hold its edge, in both directions alike.

use glam::Vec2;
use unrender_scene::{Image, Rgb, Texture, Wrap};

/// A picture that repeats or holds its edge as a texture does.
pub(super) struct Tile {
    /// The texels.
    pub(super) image: Image<Rgb>,
    /// Texture coordinates of the picture for those of the texture, factor by factor.
    pub(super) scale: Vec2,
    /// Whether the edge is held; else the picture is repeated.
    pub(super) clamps: bool,
    /// What is not the texture's way, if anything is not.
    pub(super) doubt: Option<&'static str>,
}

/// The tile of `texture`: where it repeats mirrored, it holds the mirrored copy too.
pub(super) fn tile(texture: &Texture) -> Tile {
    let twice = |wrap: Wrap| if wrap == Wrap::MirroredRepeat { 2 } else { 1 };
    let (across, down) = (twice(texture.wrap_u), twice(texture.wrap_v));
    let source = &texture.image;
    let (width, height) = (source.width(), source.height());
    let image = Image::from_fn(across * width, down * height, |x, y| {
        let column = texture.wrap_u.apply(x as i64, width);
        *source.at(column, texture.wrap_v.apply(y as i64, height))
    });
    let clamped = [texture.wrap_u, texture.wrap_v].map(|wrap| wrap == Wrap::ClampToEdge);
    Tile {
        image,
        scale: Vec2::new(1.0 / across as f32, 1.0 / down as f32),
        clamps: clamped == [true; 2],
        doubt: (clamped[0] != clamped[1])
            .then_some("its texture repeats beyond the edges that it should hold"),
    }
}
