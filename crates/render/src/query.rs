//! What is asked about some pixels: gathered light, derivatives, or stored paths.

use crate::appearance::Appearance;
use crate::radiance_cache::RadianceCache;
use crate::settings::Settings;
use serde::{Deserialize, Serialize};

/// A parameter of derivatives. Each stands for three numbers, one per channel, except that the
/// roughnesses and the angle are shared by the channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Parameter {
    /// The diffuse reflectance of a group; of a textured one, a factor on its texture.
    RhoD(u32),
    /// The specular reflectance of a group.
    RhoS(u32),
    /// The roughness along a group's anisotropy direction; the derivative of a perfect mirror is
    /// zero.
    AlphaX(u32),
    /// The roughness across it.
    AlphaY(u32),
    /// The angle of a group's anisotropy direction, per radian.
    Theta(u32),
    /// The factor on the emission of a light source, by its place in [`Appearance::lights`].
    Light(u32),
    /// A factor on the radiance in the cache ([`crate::RadianceCache`]).
    Cache,
}

/// What is asked about some pixels. A [`crate::Tracer`] has to know the camera of the cache `seen` and takes a
/// [`crate::radiance_cache::CacheLookup`] there.
#[derive(Clone, Debug)]
pub struct Query<'q, P = u32, S = Settings, C = &'q RadianceCache> {
    /// What the scene looks like.
    pub appearance: Appearance<'q>,
    /// The pixels: indices, some with the numbers of their paths.
    pub pixels: &'q [P],
    /// What derivatives are by.
    pub parameters: &'q [Parameter],
    /// How many paths, and which.
    pub settings: &'q S,
    /// Paths end where this knows the radiance.
    pub seen: Option<C>,
}

impl<'q, P, S, C> Query<'q, P, S, C> {
    /// One without derivatives, and whose paths end nowhere.
    pub fn new(appearance: impl Into<Appearance<'q>>, pixels: &'q [P], settings: &'q S) -> Self {
        Self { appearance: appearance.into(), pixels, parameters: &[], settings, seen: None }
    }

    /// The same with another cache.
    pub(crate) fn with_seen<D>(&self, seen: Option<D>) -> Query<'q, P, S, D> {
        let Self { appearance, pixels, parameters, settings, .. } = *self;
        Query { appearance, pixels, parameters, settings, seen }
    }
}
