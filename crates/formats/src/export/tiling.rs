//! Textures for programs that repeat a picture or hold its edge, in both directions alike, and what
//! else several targets ask of materials.

use super::{SceneView, anisotropy};
use crate::group_detail;
use glam::Vec2;
use unrender_scene::{Image, Mapped, Material, Mesh, Object, Rgb, Wrap};

/// A picture that repeats or holds its edge as a texture does.
pub(super) struct Tile<T> {
    /// The texels.
    pub(super) image: Image<T>,
    /// Whether the edge is held; else the picture is repeated.
    pub(super) clamps: bool,
    /// In what it differs from the texture, if in anything.
    pub(super) doubt: Option<&'static str>,
}

impl<T> Tile<T> {
    /// How programs call what they do beyond its edges.
    pub(super) fn mode(&self) -> &'static str {
        if self.clamps { "clamp" } else { "repeat" }
    }
}

/// Columns and rows of copies in the tiles of group `index`: two where one of its pictures repeats mirrored, whose tile
/// contains the mirrored copy too; else one.
pub(super) fn copies(shot: &SceneView, index: usize) -> [usize; 2] {
    let detail = group_detail::of_group(shot.scene, index);
    let texture = shot.materials[index].texture.as_ref().map(|t| [t.wrap_u, t.wrap_v]);
    let normals = detail.normals.as_ref().map(|map| [map.normals.wrap_u, map.normals.wrap_v]);
    let holes = detail.coverage.as_ref().map(|c| [c.alpha.wrap_u, c.alpha.wrap_v]);
    [0, 1].map(|side| {
        let mut wraps = [texture, normals, holes].into_iter().flatten();
        let is_mirrored = wraps.any(|wraps| wraps[side] == Wrap::MirroredRepeat);
        if is_mirrored { 2 } else { 1 }
    })
}

/// The tile of `texture` in a group of so many [`copies`].
pub(super) fn tile<T: Copy>(texture: &Mapped<T>, [across, down]: [usize; 2]) -> Tile<T> {
    let source = &texture.image;
    let (width, height) = (source.width(), source.height());
    let image = Image::from_fn(across * width, down * height, |x, y| {
        let column = texture.wrap_u.apply(x as i64, width);
        *source.at(column, texture.wrap_v.apply(y as i64, height))
    });
    let clamped = [texture.wrap_u, texture.wrap_v].map(|wrap| wrap == Wrap::ClampToEdge);
    Tile {
        image,
        clamps: clamped == [true; 2],
        doubt: (clamped[0] != clamped[1])
            .then_some("its texture repeats beyond the edges that it should hold"),
    }
}

/// Whether `material` has an anisotropy direction.
pub(super) fn is_anisotropic(material: &Material) -> bool {
    material.is_glossy() && material.alpha_x != material.alpha_y
}

/// Which edge of a picture a program counts v from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum From {
    /// As we do: Mitsuba.
    Top,
    /// Blender, PBRT, Radiance.
    Bottom,
}

/// The mesh of `object` for programs that count v from the edge `from` of a [`tile`] and angles from
/// growing u: where there is no texture, u grows along the angle `theta_rad` of a brushed group.
pub(super) fn mesh(shot: &SceneView, object: &Object, theta_rad: f32, from: From) -> Mesh {
    let material = &shot.materials[object.group];
    let has_pictures =
        material.texture.is_some() || !group_detail::of_group(shot.scene, object.group).is_none();
    if !has_pictures && is_anisotropic(material) {
        return anisotropy::along_u(&object.mesh, theta_rad);
    }
    if !has_pictures {
        return object.mesh.clone();
    }
    let [across, down] = copies(shot, object.group).map(|copies| copies as f32);
    let placed = |uv: &Vec2| match from {
        From::Top => Vec2::new(uv.x / across, uv.y / down),
        From::Bottom => Vec2::new(uv.x / across, 1.0 - uv.y / down),
    };
    Mesh { uvs: object.mesh.uvs.iter().map(placed).collect(), ..object.mesh.clone() }
}

/// The share of the specular part in a blend that leaves both parts at most one, if any share does.
pub(super) fn specular_share(material: &Material) -> f32 {
    let brightest = |a: Rgb, b: &Rgb| a.max(*b);
    let texture = material.texture.as_ref();
    let rho_d =
        texture.map_or(material.rho_d, |t| t.image.pixels().iter().fold(Rgb::ZERO, brightest));
    let (diffuse, specular) = (rho_d.max_element(), material.rho_s.max_element());
    if specular <= 0.0 { 0.0 } else { specular / (diffuse + specular) }
}
