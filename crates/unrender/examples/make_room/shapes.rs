//! Meshes of simple shapes in world space.

use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use unrender::scene::Mesh;

/// A parallelogram with its texture coordinates: u grows along `across`, v against `up`; its front
/// is where `across` turns to `up` counter-clockwise.
pub(crate) fn quad(corner: Vec3, across: Vec3, up: Vec3) -> Mesh {
    let positions = [corner, corner + across, corner + across + up, corner + up];
    let uvs = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO];
    Mesh::flat(&positions, &uvs, &[[0, 1, 2], [0, 2, 3]])
}

/// A box between two opposite corners, without texture coordinates.
pub(crate) fn cuboid(low: Vec3, high: Vec3) -> Mesh {
    let size = high - low;
    let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
    let faces = [
        quad(low + z, x, y),
        quad(high - y - z, -x, y),
        quad(high - y, -z, y),
        quad(low, z, y),
        quad(high - x, x, -z),
        quad(low, x, z),
    ];
    let mut mesh = merged(&faces);
    mesh.uvs.clear();
    mesh
}

/// Several meshes as one.
pub(crate) fn merged(parts: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    for part in parts {
        let first = all.positions.len() as u32;
        all.positions.extend(&part.positions);
        all.normals.extend(&part.normals);
        all.uvs.extend(&part.uvs);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    all
}

/// A surface of revolution about the vertical through `foot`, with smooth normals. `profile` holds
/// radius and height above the foot, from below to above.
pub(crate) fn revolved(foot: Vec3, profile: &[Vec2], segments: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let last = profile.len() - 1;
    for (ring, at) in profile.iter().enumerate() {
        let slope = profile[(ring + 1).min(last)] - profile[ring.saturating_sub(1)];
        let tilt = Vec2::new(slope.y, -slope.x).normalize();
        for segment in 0..=segments {
            let (sin, cos) = (TAU * segment as f32 / segments as f32).sin_cos();
            mesh.positions.push(foot + Vec3::new(at.x * cos, at.y, at.x * sin));
            mesh.normals.push(Vec3::new(tilt.x * cos, tilt.y, tilt.x * sin));
        }
    }
    for ring in 0..last as u32 {
        for segment in 0..segments {
            let below = ring * (segments + 1) + segment;
            let above = below + segments + 1;
            if profile[ring as usize].x > 0.0 {
                mesh.triangles.push([below, above, below + 1]);
            }
            if profile[ring as usize + 1].x > 0.0 {
                mesh.triangles.push([above, above + 1, below + 1]);
            }
        }
    }
    mesh
}

/// An ellipsoid of the given half width and half height that stands on `foot`.
pub(crate) fn ellipsoid(foot: Vec3, half_width: f32, half_height: f32, rings: u32) -> Mesh {
    let point = |ring: u32| {
        let angle = 0.5 * TAU * ring as f32 / rings as f32;
        let radius = if ring == 0 || ring == rings { 0.0 } else { half_width * angle.sin() };
        Vec2::new(radius, half_height * (1.0 - angle.cos()))
    };
    let profile: Vec<Vec2> = (0..=rings).map(point).collect();
    revolved(foot, &profile, 2 * rings)
}
