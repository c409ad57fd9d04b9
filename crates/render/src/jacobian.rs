//! Jacobian images: radiance and its derivative by every parameter, in one pass (design, section 5).
//!
//! Forward mode would carry `dC/dp = C sum over the path's vertices of (df/dp)/f` along each path.
//! Going back from the path's end gives the same sum with the work of one path and without the
//! division: with `L_i` the radiance that arrives at vertex `i` and `w_i = f_i cos/pdf`,
//! `L_(i-1) = emitted_i + direct_i + w_i L_i` and `dC/dp = T_(i-1) (d direct_i/dp + dw_i/dp L_i)`,
//! summed over all vertices of the parameter's group. Sampling densities are held fixed.

use crate::film::Settings;
use crate::seen::Lookup;
use crate::tracer::{Appearance, Tracer};
use unrender_scene::{Camera, Rgb};

/// What a derivative is taken by. Each stands for three numbers, one a channel, except that the
/// roughnesses and the angle are shared by the channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// The diffuse reflectance of a group; of a textured one, a factor on its texture.
    RhoD(u32),
    /// The specular reflectance of a group.
    RhoS(u32),
    /// The roughness along a group's brushed direction.
    AlphaX(u32),
    /// The roughness across it.
    AlphaY(u32),
    /// The angle of a group's brushed direction, per radian.
    Theta(u32),
    /// How many times as bright as in the scene a source shines ([`Appearance::lights`]).
    Light(u32),
    /// A factor on the radiance that paths take from the cache ([`crate::SeenRadiance`]).
    Seen,
}

/// Radiance and its derivatives in some pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Jacobian {
    /// The radiance of each pixel.
    pub radiance: Vec<Rgb>,
    /// For each pixel, one behind the other, its derivative by each parameter: channel c holds
    /// `dL_c / dp_c`.
    pub derivatives: Vec<Rgb>,
}

impl Tracer {
    /// Radiance of `pixels` (indices into a picture of `size`) and its derivatives by `parameters`;
    /// paths end where `seen` knows the radiance.
    pub fn jacobian<'a>(
        &self,
        appearance: impl Into<Appearance<'a>>,
        camera: &Camera,
        size: (usize, usize),
        pixels: &[u32],
        parameters: &[Parameter],
        settings: &Settings,
        seen: Option<Lookup<'_>>,
    ) -> Jacobian {
        let _ = (appearance.into(), camera, size, pixels, parameters, settings, seen);
        unimplemented!()
    }
}
