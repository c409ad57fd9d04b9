//! Texture coordinates that one texture cannot serve: a recovered texture has one texel for each place
//! of the unit square, so surfaces outside it, or overlapping in it, are averaged.

use glam::Vec2;
use unrender_scene::Scene;

/// The unit square is divided into this many cells per side. Half as many miss seams of thin charts;
/// twice as many find nothing more in the models that were tested.
const CELLS: usize = 256;
/// Charts that overlap by less than this share of the covered cells only touch.
const OVERLAP: f32 = 0.02;
/// Coordinates are outside from here on; unwrapping leaves rounding.
const OUTSIDE: f32 = 1e-3;

/// What is wrong with texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum UvFault {
    /// They reach beyond the unit square, so that the texture repeats.
    Repeat,
    /// This share of the texture is used more than once.
    Overlap(f32),
}

impl UvFault {
    /// That of the group with this index; none if every place of its texture is used once, or it has no coordinates.
    pub(crate) fn of(scene: &Scene, group: usize) -> Option<Self> {
        let meshes = scene.objects.iter().filter(|o| o.group == group).map(|o| &o.mesh);
        let with_uvs = meshes.filter(|mesh| !mesh.uvs.is_empty());
        let triangles: Vec<[Vec2; 3]> = with_uvs
            .flat_map(|mesh| mesh.triangles.iter().map(|t| t.map(|i| mesh.uvs[i as usize])))
            .collect();
        let is_outside =
            |uv: &Vec2| uv.min_element() < -OUTSIDE || uv.max_element() > 1.0 + OUTSIDE;
        if triangles.iter().flatten().any(is_outside) {
            return Some(Self::Repeat);
        }
        Some(overlap(&triangles)).filter(|share| *share >= OVERLAP).map(Self::Overlap)
    }

    /// A word for tables.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Repeat => "uv repeats",
            Self::Overlap(_) => "uv overlaps",
        }
    }

    fn in_words(self) -> String {
        match self {
            Self::Repeat => "reach beyond 0 to 1, so that the texture repeats".to_owned(),
            Self::Overlap(share) => {
                format!("overlap ({:.0} % of the texture is used more than once)", 100.0 * share)
            }
        }
    }
}

/// The warning of the texture coordinates of the group with this index, whose result has a texture or is doubtful.
pub(crate) fn doubt(scene: &Scene, group: usize, is_textured: bool) -> Option<String> {
    let (name, what) = (&scene.groups[group].name, UvFault::of(scene, group)?.in_words());
    let so = if is_textured {
        "its texture is the average of all places that share a texel: unwrap it without overlaps if they differ"
    } else {
        "a pattern that differs where they share a texel is no texture to them: unwrap it without overlaps if the photo \
         shows one"
    };
    Some(format!("group \"{name}\": its texture coordinates {what}; {so}"))
}

/// The share of the covered cells that several triangles cover, by the centres of cells.
fn overlap(triangles: &[[Vec2; 3]]) -> f32 {
    let mut counts = vec![0u32; CELLS * CELLS];
    for [a, b, c] in triangles.iter().map(|t| t.map(|uv| uv * CELLS as f32)) {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let cells =
            |low: f32, high: f32| low.max(0.0) as usize..(high.max(0.0) as usize + 1).min(CELLS);
        let area = (b - a).perp_dot(c - a);
        for (x, y) in cells(low.y, high.y).flat_map(|y| cells(low.x, high.x).map(move |x| (x, y))) {
            let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            // Strictly inside: cells on a common edge belong to neither triangle.
            let side = |a: Vec2, b: Vec2| (b - a).perp_dot(p - a) * area > 0.0;
            counts[y * CELLS + x] += u32::from(side(a, b) && side(b, c) && side(c, a));
        }
    }
    let covered = counts.iter().filter(|count| **count > 0).count();
    let several = counts.iter().filter(|count| **count > 1).count();
    several as f32 / covered.max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use unrender_scene::{Group, Material, Mesh, Object, Rgb};

    fn scene(charts: &[[f32; 4]]) -> Scene {
        let material = Material::diffuse(Rgb::ONE);
        let group = Group { name: "wall".into(), material, emission: Rgb::ZERO };
        let mut scene = Scene { groups: vec![group], ..Scene::default() };
        for [left, low, right, high] in charts {
            let uvs = [[*left, *low], [*right, *low], [*right, *high], [*left, *high]];
            let uvs = uvs.map(Vec2::from_array);
            let mesh = Mesh::flat(&uvs.map(|uv| uv.extend(0.0)), &uvs, &[[0, 1, 2], [0, 2, 3]]);
            assert!(mesh.positions.contains(&Vec3::new(*left, *low, 0.0)));
            scene.objects.push(Object { name: "o".into(), group: 0, mesh });
        }
        scene
    }

    #[test]
    fn overlaps_and_repetitions_are_reported() {
        let noted = |charts: &[[f32; 4]]| doubt(&scene(charts), 0, true);
        assert_eq!(noted(&[[0.0, 0.0, 0.5, 1.0], [0.5, 0.0, 1.0, 1.0]]), None);
        assert!(noted(&[[0.0, 0.0, 2.0, 1.0]]).unwrap().contains("beyond"));
        let said = noted(&[[0.0, 0.0, 0.6, 1.0], [0.4, 0.0, 1.0, 1.0]]).unwrap();
        assert!(said.contains("overlap (20 %"), "{said}");
        assert_eq!(noted(&[]), None);
        // Mirrored: both halves of a sofa in one half of the texture.
        let mirrored = scene(&[[0.0, 0.0, 0.5, 1.0], [0.5, 0.0, 0.0, 1.0]]);
        assert_eq!(UvFault::of(&mirrored, 0), Some(UvFault::Overlap(1.0)));
        assert!(doubt(&mirrored, 0, false).unwrap().contains("no texture to them"));
    }
}
