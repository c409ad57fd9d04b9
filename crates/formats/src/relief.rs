//! Normal maps, heights and holes, as several formats state them: what meshes need for them, and what pictures mean.

use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;
use unrender_scene::color::luminance;
use unrender_scene::{Coverage, Detail, Image, Mapped, Mesh, NormalMap, Rgb};

/// The least coverage of a place that is there, where a file states none.
pub(crate) const CUTOFF: f32 = 0.5;

/// Coverage between these is half-transparent: the edges of leaves are blurred beyond it, too, but by less.
const HALF: [f32; 2] = [0.1, 0.9];
/// The share of half-transparent texels from which on a picture shows a veil. Blurred edges of leaves and grids are a few
/// per cent of it; with half of that some of them would be told of, with double some veils would not.
const VEILED: f32 = 0.05;

/// The mean of a normal map: the code of a normal that is that of the mesh.
const FLAT_CODE: Rgb = Rgb::new(0.5, 0.5, 1.0);
/// How far the mean of a normal map may be from [`FLAT_CODE`], per channel. Steep ones have a mean blue of 0.85; heights are
/// grey, 0.25 away in some channel at least. With half of it steep maps are taken for heights.
const NEAR_FLAT: f32 = 0.2;

/// Gives `mesh` the detail of its material, and tangents where normals need some; none without texture coordinates.
pub(crate) fn give(mesh: &mut Mesh, detail: &Detail) {
    if mesh.uvs.is_empty() {
        return;
    }
    if detail.normals.is_some() && mesh.tangents.is_empty() {
        mesh.tangents = along_u(mesh);
    }
    mesh.detail = detail.clone();
}

/// The direction of growing u at each vertex, with glTF's handedness of the picture upon it; where there is none, world
/// +x, or +z on surfaces that face along x, as for meshes without texture coordinates.
pub(crate) fn along_u(mesh: &Mesh) -> Vec<Vec4> {
    // Tangents, and areas in the texture.
    let mut sums = vec![Vec4::ZERO; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let [s, t, w] = triangle.map(|i| mesh.uvs[i as usize]);
        let (t, w) = (t - s, w - s);
        // Weighted by the area, with the sign of the area in the texture.
        let area = t.perp_dot(w);
        let tangent = ((b - a) * w.y - (c - a) * t.y) * area.signum();
        triangle.iter().for_each(|&i| sums[i as usize] += tangent.extend(area));
    }
    let on_surface = |(sum, normal): (&Vec4, &Vec3)| {
        let projected = |v: Vec3| (v - normal.dot(v) * *normal).try_normalize();
        let wanted = [sum.truncate().normalize_or_zero(), Vec3::X, Vec3::Z];
        let is_along = |v: &Vec3| v.cross(*normal).length() > 1e-3;
        let tangent = wanted.into_iter().filter(is_along).find_map(projected);
        // v grows downwards in the picture.
        tangent.unwrap_or(Vec3::X).extend(if sum.w < 0.0 { 1.0 } else { -1.0 })
    };
    sums.iter().zip(&mesh.normals).map(on_surface).collect()
}

/// The lengths of `dp/du` and `dp/dv` of `mesh`: how far it is from one end of the picture to the other, in metres. The mean
/// over its area; zero where no texture coordinates say.
fn span(mesh: &Mesh) -> Vec2 {
    let (mut sum, mut total) = (Vec2::ZERO, 0.0);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let [s, t, w] = triangle.map(|i| mesh.uvs[i as usize]);
        let (b, c, t, w) = (b - a, c - a, t - s, w - s);
        let (area, in_picture) = (b.cross(c).length(), t.perp_dot(w));
        let lengths = Vec2::new((b * w.y - c * t.y).length(), (c * t.x - b * w.x).length());
        let lengths = lengths / in_picture.abs();
        if lengths.is_finite() && area > 0.0 {
            sum += area * lengths;
            total += area;
        }
    }
    if total > 0.0 { sum / total } else { Vec2::ZERO }
}

/// The normals of a surface that the luminance of `heights` times `scale`, in metres, lifts off `mesh`: to first order, and
/// as if the picture was equally large all over the mesh.
pub(crate) fn of_heights(heights: &Mapped<Rgb>, scale: f32, mesh: &Mesh) -> NormalMap {
    let Mapped { image, wrap_u, wrap_v } = heights;
    let (width, height) = (image.width(), image.height());
    let span = span(mesh).map(|length| if length > 0.0 { length } else { f32::INFINITY });
    let at = |x: i64, y: i64| luminance(*image.at(wrap_u.apply(x, width), wrap_v.apply(y, height)));
    let normal = |x: usize, y: usize| {
        let (x, y) = (x as i64, y as i64);
        let per_u = 0.5 * (at(x + 1, y) - at(x - 1, y)) * width as f32;
        let per_v = 0.5 * (at(x, y + 1) - at(x, y - 1)) * height as f32;
        // v grows downwards in the picture, y upwards.
        Vec3::new(-scale * per_u / span.x, scale * per_v / span.y, 1.0)
    };
    let normals = Image::from_fn(width, height, normal);
    let normals = Mapped { image: normals, wrap_u: *wrap_u, wrap_v: *wrap_v };
    NormalMap { normals, shades_itself: false }
}

/// Whether a picture of codes is a normal map, as its mean is.
pub(crate) fn is_normal_map(mean: Rgb) -> bool {
    (mean - FLAT_CODE).abs().max_element() < NEAR_FLAT
}

/// The holes where `alpha` is below a half; none if it never is.
pub(crate) fn holes(alpha: Mapped<f32>) -> Option<Arc<Coverage>> {
    let has_holes = alpha.image.pixels().iter().any(|alpha| *alpha < CUTOFF);
    has_holes.then(|| Arc::new(Coverage { alpha, cutoff: CUTOFF }))
}

/// Whether much of it is half-transparent.
pub(crate) fn is_veil(alpha: &Image<f32>) -> bool {
    let is_half = |alpha: &&f32| HALF[0] < **alpha && **alpha < HALF[1];
    let half = alpha.pixels().iter().filter(is_half).count();
    half as f32 > VEILED * alpha.pixels().len() as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::Wrap;

    /// Two metres wide and one metre high, its front towards +z, with the picture upright on it.
    fn board() -> Mesh {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]].map(Vec2::from_array);
        let uvs = corners.map(|corner| Vec2::new(0.5 * corner.x, 1.0 - corner.y));
        let positions = corners.map(|corner| corner.extend(0.0));
        Mesh::flat(&positions, &uvs, &[[0, 1, 2], [0, 2, 3]])
    }

    #[test]
    fn heights_that_grow_lean_the_normal_back() {
        // It grows by 0.1 m a metre rightwards, and by 0.2 m a metre upwards.
        let height = |x: usize, y: usize| Rgb::splat((0.2 * x as f32 + 0.2 * (7 - y) as f32) / 8.0);
        let image = Image::from_fn(8, 8, height);
        let (wrap_u, wrap_v) = (Wrap::ClampToEdge, Wrap::ClampToEdge);
        let map = of_heights(&Mapped { image, wrap_u, wrap_v }, 1.0, &board());
        let expected = Vec3::new(-0.1, -0.2, 1.0).normalize();
        assert!((map.at(Vec2::splat(0.5)) - expected).length() < 1e-5);
        let tangents = along_u(&board());
        assert!(tangents.iter().all(|tangent| *tangent == Vec4::new(1.0, 0.0, 0.0, 1.0)));
    }

    #[test]
    fn normal_maps_are_blue() {
        assert!(
            is_normal_map(Rgb::new(0.5, 0.5, 1.0)) && is_normal_map(Rgb::new(0.52, 0.45, 0.85))
        );
        assert!((0..=10).all(|grey| !is_normal_map(Rgb::splat(grey as f32 / 10.0))));
    }

    #[test]
    fn veils_are_half_transparent() {
        let with = |count: usize| {
            Image::from_fn(10, 10, |x, y| if x + 10 * y < count { 0.5 } else { 1.0 })
        };
        assert!(!is_veil(&with(5)) && is_veil(&with(6)));
    }
}
