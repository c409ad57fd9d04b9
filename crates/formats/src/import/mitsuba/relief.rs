//! What surfaces have below their triangles: `normalmap`, `bumpmap`, and the holes of a `mask`.
//!
//! A normal map is of the shading frame, whose x is along growing u and whose y is the normal times x, whichever way v grows:
//! so the tangents of its meshes are right-handed. A bump map lifts the surface along its normal by the luminance of its
//! picture times `scale`, in units of the scene, which is taken to be equally large all over a shape.

use super::paint::{Context, Picture, texture};
use super::spectrum::Use;
use super::tree::Node;
use crate::input::Scope;
use crate::relief;
use glam::{Affine2, Vec4};
use std::sync::Arc;
use unrender_scene::color::luminance;
use unrender_scene::{Coverage, Detail, Image, Mapped, Mesh, NormalMap, Texture, Wrap};

/// What its picture says of normals.
#[derive(Clone, Debug)]
pub(super) enum Bumps {
    /// Normals in the shading frame.
    Normals(Arc<NormalMap>),
    /// Heights, and the factor on them.
    Heights(Arc<Texture>, f32),
}

/// The detail of a surface, in the texture coordinates of its pictures.
#[derive(Clone, Debug, Default)]
pub(super) struct Relief {
    pub(super) bumps: Option<Bumps>,
    pub(super) holes: Option<Arc<Coverage>>,
}

impl Relief {
    /// Whether there is none.
    pub(super) fn is_none(&self) -> bool {
        self.bumps.is_none() && self.holes.is_none()
    }

    /// Gives `mesh` this detail, and takes its texture coordinates to those of the pictures by `to_uv`.
    pub(super) fn lay(&self, mesh: &mut Mesh, to_uv: Affine2, scope: &Scope) -> Result<(), String> {
        if self.bumps.is_some() {
            scope.charge((mesh.positions.len() * size_of::<Vec4>()) as u64)?;
        }
        if let Some(Bumps::Normals(_)) = self.bumps {
            let right_handed = |tangent: Vec4| tangent.truncate().extend(1.0);
            mesh.tangents = relief::along_u(mesh).into_iter().map(right_handed).collect();
        }
        if to_uv != Affine2::IDENTITY {
            mesh.uvs.iter_mut().for_each(|uv| *uv = to_uv.transform_point2(*uv));
        }
        let normals = match &self.bumps {
            Some(Bumps::Heights(heights, scale)) => {
                scope.charge(size_of_val(heights.image.pixels()) as u64)?;
                Some(Arc::new(relief::of_heights(heights, *scale, mesh)))
            }
            Some(Bumps::Normals(normals)) => Some(normals.clone()),
            None => None,
        };
        relief::give(mesh, &Detail { normals, coverage: self.holes.clone() });
        Ok(())
    }
}

/// The bumps of the `normalmap` or `bumpmap` `node`, their picture, and whether that is taken as raw though it does not say
/// so; none without a texture.
pub(super) fn bumps(
    context: &Context,
    node: Node,
) -> Result<Option<(Bumps, Picture, bool)>, String> {
    let Some(inside) = node.child("texture")? else { return Ok(None) };
    let of_normals = node.kind() == "normalmap";
    let usage = if of_normals { Use::Normal } else { Use::Index };
    let paint = texture(context, inside, usage)?;
    let picture = paint.picture.unwrap_or_else(|| {
        let image = Image::new(1, 1, vec![paint.mean]);
        let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
        Picture { texture: Arc::new(texture), to_uv: Affine2::IDENTITY }
    });
    if !of_normals {
        let scale = node.number("scale", 1.0)?;
        return Ok(Some((Bumps::Heights(picture.texture.clone(), scale), picture, false)));
    }
    let texture = &picture.texture;
    let charged = context.scope.charge(size_of_val(texture.image.pixels()) as u64);
    charged.map_err(|problem| node.fail(problem))?;
    let is_coded = inside.kind() == "bitmap" && !inside.flag("raw", false)?;
    let normals = Arc::new(NormalMap::decoded(texture, 1.0, false));
    Ok(Some((Bumps::Normals(normals), picture, is_coded)))
}

/// The opacity of a picture.
pub(super) fn opacity(picture: &Texture, scope: &Scope) -> Result<Mapped<f32>, String> {
    scope.charge((picture.image.pixels().len() * size_of::<f32>()) as u64)?;
    let image = picture.image.map(|texel| luminance(*texel));
    Ok(Mapped { image, wrap_u: picture.wrap_u, wrap_v: picture.wrap_v })
}
