//! Textures for programs that repeat a picture or hold its edge, in both directions alike, and what
//! else several targets ask of materials.

use super::{SceneView, anisotropy};
use glam::Vec2;
use unrender_scene::{Image, Material, Mesh, Object, Rgb, Texture, Wrap};

/// A picture that repeats or holds its edge as a texture does.
pub(super) struct Tile {
    /// The texels.
    pub(super) image: Image<Rgb>,
    /// Texture coordinates of the picture for those of the texture, factor by factor.
    pub(super) scale: Vec2,
    /// Whether the edge is held; else the picture is repeated.
    pub(super) clamps: bool,
    /// In what it differs from the texture, if in anything.
    pub(super) doubt: Option<&'static str>,
}

/// The tile of `texture`: where that repeats mirrored, the tile contains the mirrored copy too.
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
    match &material.texture {
        Some(texture) => {
            let scale = tile(texture).scale;
            let placed = |uv: &Vec2| match from {
                From::Top => *uv * scale,
                From::Bottom => Vec2::new(uv.x * scale.x, 1.0 - uv.y * scale.y),
            };
            Mesh { uvs: object.mesh.uvs.iter().map(placed).collect(), ..object.mesh.clone() }
        }
        None if is_anisotropic(material) => anisotropy::along_u(&object.mesh, theta_rad),
        None => object.mesh.clone(),
    }
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
