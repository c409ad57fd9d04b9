//! The detail of surfaces below their triangles: normals and holes by texture coordinate.
//!
//! It is shape, as meshes are: stated by the scene's file, rendered, and never recovered.

use crate::{Mapped, Rgb};
use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The detail of a mesh; its texture coordinates say where. Without them it has no effect.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Detail {
    /// Shading normals.
    #[serde(with = "crate::serial::shared")]
    pub normals: Option<Arc<NormalMap>>,
    /// Holes.
    #[serde(with = "crate::serial::shared")]
    pub coverage: Option<Arc<Coverage>>,
}

impl Detail {
    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        self.normals.is_none() && self.coverage.is_none()
    }
}

/// Shading normals in tangent space, as glTF has them: x along the tangent (rightwards in the picture), y along the
/// bitangent (upwards in it), z along the normal of the mesh. They need not have length one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NormalMap {
    /// The normals.
    pub normals: Mapped<Vec3>,
    /// Whether bumps shade themselves where light grazes the mesh, as in Blender [Conty Estevez et al. 2019]; Mitsuba's
    /// do not.
    pub shades_itself: bool,
}

impl NormalMap {
    /// The map of a picture of values 0 to 1 that stand for -1 to 1, its x and y times `scale`.
    pub fn decoded(picture: &Mapped<Rgb>, scale: f32, shades_itself: bool) -> Self {
        let normal = |code: &Rgb| (2.0 * *code - 1.0) * Vec3::new(scale, scale, 1.0);
        let Mapped { image, wrap_u, wrap_v } = picture;
        let normals = Mapped { image: image.map(normal), wrap_u: *wrap_u, wrap_v: *wrap_v };
        Self { normals, shades_itself }
    }

    /// The unit normal at `uv`; that of the mesh where the map has none.
    ///
    /// ```
    /// use glam::{Vec2, Vec3};
    /// use unrender_scene::{Image, Mapped, NormalMap, Rgb, Wrap};
    ///
    /// let image = Image::new(1, 1, vec![Rgb::new(1.0, 0.5, 1.0)]);
    /// let picture = Mapped { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    /// let normal = NormalMap::decoded(&picture, 1.0, true).at(Vec2::ZERO);
    /// assert!((normal - Vec3::new(0.5f32.sqrt(), 0.0, 0.5f32.sqrt())).length() < 1e-6);
    /// assert_eq!(NormalMap::decoded(&picture, 0.0, true).at(Vec2::ZERO), Vec3::Z);
    /// ```
    pub fn at(&self, uv: Vec2) -> Vec3 {
        self.normals.sample(uv).try_normalize().unwrap_or(Vec3::Z)
    }
}

/// Which places of a surface are there: those whose coverage is at least the cutoff. The others are holes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coverage {
    /// The coverage, 0 to 1.
    pub alpha: Mapped<f32>,
    /// The least coverage of a place that is there.
    pub cutoff: f32,
}

impl Coverage {
    /// Whether there is a hole at `uv`.
    pub fn is_hole(&self, uv: Vec2) -> bool {
        self.alpha.sample(uv) < self.cutoff
    }
}
