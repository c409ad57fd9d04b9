//! Holes: `mixpict`, a mixture of a material with nothing by a picture.

use super::pictures::{place, with_frame, within};
use crate::export::maps;
use crate::texels;
use unrender_scene::{Coverage, Rgb};

/// The holes of a group.
pub(super) struct Holes {
    /// The path and the contents of their picture.
    pub(super) picture: (String, Vec<u8>),
    /// Expressions for the place in it.
    across: String,
    up: String,
}

impl Holes {
    /// Those of `coverage` in the group called `id`.
    pub(super) fn of(coverage: &Coverage, id: &str) -> Result<Self, String> {
        let stencil = maps::stencil(coverage);
        let (width, height) = (stencil.image.width(), stencil.image.height());
        let shorter = (width.min(height) + 2) as f32;
        let wraps = [stencil.wrap_u, stencil.wrap_v];
        let colors = stencil.image.map(|there| Rgb::splat(*there));
        let picture = texels::hdr(&with_frame(&colors, wraps))?;
        Ok(Self {
            picture: (format!("textures/{id}-holes.hdr"), picture),
            across: place(&within("Lu", stencil.wrap_u), width, shorter),
            up: place(&within("Lv", stencil.wrap_v), height, shorter),
        })
    }

    /// The material called `id`: `inner` where there is no hole.
    pub(super) fn about(&self, inner: &str, id: &str) -> String {
        let (path, across, up) = (&self.picture.0, &self.across, &self.up);
        format!("void mixpict {id}\n7 {inner} void grey ./{path} . {across} {up}\n0\n0\n")
    }
}
