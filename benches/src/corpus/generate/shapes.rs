//! Meshes of simple shapes, each with texture coordinates; their fronts look outwards.

use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use unrender::scene::Mesh;

/// A parallelogram: u grows along `across`, v against `up`; seen from its front, `up` is
/// counter-clockwise from `across`.
pub(crate) fn quad(corner: Vec3, across: Vec3, up: Vec3) -> Mesh {
    let positions = [corner, corner + across, corner + across + up, corner + up];
    let uvs = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO];
    Mesh::flat(&positions, &uvs, &[[0, 1, 2], [0, 2, 3]])
}

/// Several meshes as one; texture coordinates stay if all have them.
pub(crate) fn merged(parts: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    let has_uvs = parts.iter().all(|part| part.uvs.len() == part.positions.len());
    for part in parts {
        let first = all.positions.len() as u32;
        all.positions.extend(&part.positions);
        all.normals.extend(&part.normals);
        if has_uvs {
            all.uvs.extend(&part.uvs);
        }
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    all
}

/// `mesh` turned and moved by a rigid motion.
pub(crate) fn placed(mesh: &Mesh, motion: Affine3A) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.positions.iter_mut().for_each(|p| *p = motion.transform_point3(*p));
    mesh.normals.iter_mut().for_each(|n| *n = motion.transform_vector3(*n).normalize_or(Vec3::Y));
    mesh
}

/// The axes of a box's six faces: outwards, across, up.
const FACES: [[Vec3; 3]; 6] = [
    [Vec3::Z, Vec3::X, Vec3::Y],
    [Vec3::NEG_Z, Vec3::NEG_X, Vec3::Y],
    [Vec3::X, Vec3::NEG_Z, Vec3::Y],
    [Vec3::NEG_X, Vec3::Z, Vec3::Y],
    [Vec3::Y, Vec3::X, Vec3::NEG_Z],
    [Vec3::NEG_Y, Vec3::X, Vec3::Z],
];

/// A box of `size` that stands on the origin, its edges cut at 45 degrees by `bevel` metres; without
/// a bevel every face has its own place of a third by a half in the texture.
pub(crate) fn cuboid(size: Vec3, bevel: f32) -> Mesh {
    let (centre, half) = (0.5 * size.y * Vec3::Y, 0.5 * size);
    let inner = half - Vec3::splat(bevel);
    let mut parts = Vec::new();
    for (index, [out, across, up]) in FACES.into_iter().enumerate() {
        let [a, b] = [across, up].map(|axis| axis * (inner * axis.abs()).element_sum());
        let corner = centre + out * (half * out.abs()).element_sum() - a - b;
        let mut face = quad(corner, 2.0 * a, 2.0 * b);
        let place = Vec2::new((index % 3) as f32, (index / 3) as f32);
        // A margin keeps bilinear lookups of one face out of the next.
        face.uvs.iter_mut().for_each(|uv| {
            *uv = (place + Vec2::splat(0.02) + *uv * 0.96) / Vec2::new(3.0, 2.0);
        });
        parts.push(face);
    }
    if bevel > 0.0 {
        parts.push(bevels(centre, half, inner));
        let mut mesh = merged(&parts);
        mesh.uvs.clear();
        return mesh;
    }
    merged(&parts)
}

/// The twelve strips and eight corners between the faces of a bevelled box.
fn bevels(centre: Vec3, half: Vec3, inner: Vec3) -> Mesh {
    // The corner of the face with outward axis `axis`, at the box's corner of these signs.
    let at = |signs: Vec3, axis: usize| {
        let mut point = inner * signs;
        point[axis] = half[axis] * signs[axis];
        centre + point
    };
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut add = |corners: &[Vec3], outwards: Vec3| {
        let first = positions.len() as u32;
        positions.extend_from_slice(corners);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        for last in 2..corners.len() as u32 {
            let [a, b, c] = [first, first + last - 1, first + last];
            triangles.push(if normal.dot(outwards) > 0.0 { [a, b, c] } else { [a, c, b] });
        }
    };
    for axis in 0..3 {
        let (one, two) = ((axis + 1) % 3, (axis + 2) % 3);
        for (a, b) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            let signs = |along: f32| {
                let mut signs = Vec3::ZERO;
                (signs[axis], signs[one], signs[two]) = (along, a, b);
                signs
            };
            let (low, high) = (signs(-1.0), signs(1.0));
            add(&[at(low, one), at(high, one), at(high, two), at(low, two)], low + high);
        }
    }
    for corner in 0..8 {
        let sign = |bit: u32| if corner & bit == 0 { -1.0 } else { 1.0 };
        let signs = Vec3::new(sign(1), sign(2), sign(4));
        add(&[at(signs, 0), at(signs, 1), at(signs, 2)], signs);
    }
    Mesh::flat(&positions, &[], &triangles)
}

/// A smooth part of a profile: radius and height, and the outward normal in that plane.
type Stretch = Vec<(Vec2, Vec2)>;

/// A surface of revolution about +y; u grows once around, v from its upper end to its lower.
fn turned(stretches: &[Stretch], segments: u32) -> Mesh {
    let length = |stretch: &Stretch| -> f32 {
        stretch.windows(2).map(|pair| (pair[1].0 - pair[0].0).length()).sum()
    };
    let total: f32 = stretches.iter().map(length).sum();
    let mut mesh = Mesh::default();
    let mut travelled = 0.0;
    for stretch in stretches {
        let first = mesh.positions.len() as u32;
        for (ring, (at, normal)) in stretch.iter().enumerate() {
            if ring > 0 {
                travelled += (*at - stretch[ring - 1].0).length();
            }
            for segment in 0..=segments {
                let u = segment as f32 / segments as f32;
                let (sin, cos) = (TAU * u).sin_cos();
                mesh.positions.push(Vec3::new(at.x * cos, at.y, -at.x * sin));
                mesh.normals.push(Vec3::new(normal.x * cos, normal.y, -normal.x * sin));
                mesh.uvs.push(Vec2::new(u, 1.0 - travelled / total));
            }
        }
        for ring in 0..stretch.len() as u32 - 1 {
            for segment in 0..segments {
                let below = first + ring * (segments + 1) + segment;
                let above = below + segments + 1;
                if stretch[ring as usize].0.x > 0.0 {
                    mesh.triangles.push([below, below + 1, above]);
                }
                if stretch[ring as usize + 1].0.x > 0.0 {
                    mesh.triangles.push([above, below + 1, above + 1]);
                }
            }
        }
    }
    mesh
}

/// A ball that touches the ground at the origin.
pub(crate) fn sphere(radius: f32, segments: u32) -> Mesh {
    let rings = segments / 2;
    let point = |ring: u32| {
        let angle = PI * ring as f32 / rings as f32;
        let side = if ring == 0 || ring == rings { 0.0 } else { angle.sin() };
        let normal = Vec2::new(side, -angle.cos());
        (radius * normal + Vec2::new(0.0, radius), normal)
    };
    turned(&[(0..=rings).map(point).collect()], segments)
}

/// A cylinder that stands on the origin.
pub(crate) fn cylinder(radius: f32, height: f32, segments: u32) -> Mesh {
    let at = |x: f32, y: f32, normal: Vec2| (Vec2::new(x, y), normal);
    turned(
        &[
            vec![at(0.0, 0.0, Vec2::NEG_Y), at(radius, 0.0, Vec2::NEG_Y)],
            vec![at(radius, 0.0, Vec2::X), at(radius, height, Vec2::X)],
            vec![at(radius, height, Vec2::Y), at(0.0, height, Vec2::Y)],
        ],
        segments,
    )
}

/// A ring of the two radii that lies on the ground about the origin.
pub(crate) fn torus(radius: f32, thickness: f32, segments: u32) -> Mesh {
    let rings = segments / 2;
    let point = |ring: u32| {
        let angle = TAU * ring as f32 / rings as f32;
        let normal = Vec2::new(angle.cos(), angle.sin());
        (Vec2::new(radius, thickness) + thickness * normal, normal)
    };
    turned(&[(0..=rings).map(point).collect()], segments)
}

/// A vase of about the given radius that stands on the origin: `bulge` and `neck` are shares of the
/// radius by which a wave widens it below and narrows it above.
pub(crate) fn vase(radius: f32, height: f32, [bulge, neck]: [f32; 2], segments: u32) -> Mesh {
    let rings = segments / 2;
    let width = |t: f32| {
        let wave = (TAU * (0.85 * t + 0.05)).sin();
        radius * (1.0 - neck * t + bulge * wave) / (1.0 + bulge)
    };
    let side = |ring: u32| {
        let t = ring as f32 / rings as f32;
        let slope = (width(t + 1e-3) - width(t - 1e-3)) / (2e-3 * height);
        (Vec2::new(width(t), height * t), Vec2::new(1.0, -slope).normalize())
    };
    let foot = width(0.0);
    let rim = width(1.0);
    turned(
        &[
            vec![(Vec2::ZERO, Vec2::NEG_Y), (Vec2::new(foot, 0.0), Vec2::NEG_Y)],
            (0..=rings).map(side).collect(),
            vec![(Vec2::new(rim, height), Vec2::Y), (Vec2::new(0.0, height), Vec2::Y)],
        ],
        segments,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume inside a closed mesh whose front looks outwards.
    fn volume(mesh: &Mesh) -> f32 {
        let of = |index: usize| {
            let [a, b, c] = mesh.corners(index);
            a.dot(b.cross(c)) / 6.0
        };
        (0..mesh.triangles.len()).map(of).sum()
    }

    #[test]
    fn shapes_are_closed_and_look_outwards() {
        let size = Vec3::new(0.6, 0.4, 0.5);
        let (x, y, z, b) = (0.6f32, 0.4f32, 0.5f32, 0.05f32);
        // Each edge loses a prism; three of them meet in a corner.
        let cut = 2.0 * b * b * (x + y + z - 6.0 * b) + 8.0 * (b.powi(3) * 5.0 / 6.0);
        for (name, mesh, expected) in [
            ("box", cuboid(size, 0.0), x * y * z),
            ("bevelled box", cuboid(size, b), x * y * z - cut),
            ("ball", sphere(0.5, 96), PI / 6.0),
            ("cylinder", cylinder(0.3, 0.8, 96), PI * 0.09 * 0.8),
            ("ring", torus(0.4, 0.1, 96), 2.0 * PI * PI * 0.4 * 0.01),
        ] {
            let found = volume(&mesh);
            assert!((found / expected - 1.0).abs() < 0.005, "{name}: {found} for {expected}");
            assert_eq!(mesh.normals.len(), mesh.positions.len());
        }
        assert!(volume(&vase(0.2, 0.5, [0.3, 0.4], 48)) > 0.0);
    }

    #[test]
    fn normals_look_the_way_of_the_fronts() {
        for mesh in [sphere(1.0, 24), vase(0.2, 0.5, [0.3, 0.4], 24), torus(0.4, 0.1, 24)] {
            for index in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(index);
                let front = (b - a).cross(c - a);
                let shading = mesh.normals[mesh.triangles[index][0] as usize];
                assert!(front.dot(shading) >= 0.0, "triangle {index}");
            }
        }
    }
}
