//! Mitsuba's own shapes as meshes, with its texture coordinates, and meshes taken into the world.
//!
//! u grows along x on the rectangle, around z from +x on sphere and cylinder, and along the radius on the
//! disk, whose v goes around. v is 0 at the top of a picture.

use crate::import::shapes::turned_over;
use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use std::f32::consts::TAU;
use unrender_scene::Mesh;

/// Triangles around the axis of a round shape.
const AROUND: u32 = 64;
/// Rings of triangles on a disk: v within a triangle is off by at most 1/512 of the circle.
const RINGS: u32 = 8;

/// The square from -1 to 1 in x and y, its front towards +z.
pub(super) fn rectangle() -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(Vec2::from_array);
    Mesh {
        positions: corners.map(|c| c.extend(0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        uvs: corners.map(|c| 0.5 * c + 0.5).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// The cube from -1 to 1, its front outside. Each side has the whole picture: at its first corner u = 0,
/// v = 1, from there u grows to the second corner, where v is 1, too.
pub(super) fn cube() -> Mesh {
    let sides = [
        (Vec3::NEG_Y, [[1, -1, -1], [1, -1, 1], [-1, -1, 1], [-1, -1, -1]]),
        (Vec3::Y, [[1, 1, -1], [-1, 1, -1], [-1, 1, 1], [1, 1, 1]]),
        (Vec3::X, [[1, -1, -1], [1, 1, -1], [1, 1, 1], [1, -1, 1]]),
        (Vec3::Z, [[1, -1, 1], [1, 1, 1], [-1, 1, 1], [-1, -1, 1]]),
        (Vec3::NEG_X, [[-1, -1, 1], [-1, 1, 1], [-1, 1, -1], [-1, -1, -1]]),
        (Vec3::NEG_Z, [[1, 1, -1], [1, -1, -1], [-1, -1, -1], [-1, 1, -1]]),
    ];
    let mut cube = Mesh::default();
    for (normal, corners) in sides {
        let first = cube.positions.len() as u32;
        cube.positions.extend(corners.map(|corner| Vec3::from_array(corner.map(|c| c as f32))));
        cube.normals.extend([normal; 4]);
        cube.uvs.extend([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]].map(Vec2::from_array));
        cube.triangles.extend([[first, first + 1, first + 2], [first + 3, first, first + 2]]);
    }
    cube
}

/// The disk of radius one about the origin, its front towards +z.
pub(super) fn disk() -> Mesh {
    let mut disk = Mesh::default();
    for (ring, j) in (0..=RINGS).flat_map(|ring| (0..=AROUND).map(move |j| (ring, j))) {
        let (radius, v) = (ring as f32 / RINGS as f32, j as f32 / AROUND as f32);
        // Each triangle at the centre has a corner of its own there, at the middle of its v.
        let v = if ring == 0 { v + 0.5 / AROUND as f32 } else { v };
        let (sin, cos) = (TAU * v).sin_cos();
        disk.positions.push(radius * Vec3::new(cos, sin, 0.0));
        disk.normals.push(Vec3::Z);
        disk.uvs.push(Vec2::new(radius, v));
    }
    for (ring, j) in (0..RINGS).flat_map(|ring| (0..AROUND).map(move |j| (ring, j))) {
        let at = |ring: u32, j: u32| ring * (AROUND + 1) + j;
        disk.triangles.push([at(ring, j), at(ring + 1, j), at(ring + 1, j + 1)]);
        if ring > 0 {
            disk.triangles.push([at(ring, j), at(ring + 1, j + 1), at(ring, j + 1)]);
        }
    }
    disk
}

/// The side of the cylinder of radius one about z, from z = 0 to 1, its front outside.
pub(super) fn cylinder() -> Mesh {
    let mut side = Mesh::default();
    for (end, j) in (0..2).flat_map(|end| (0..=AROUND).map(move |j| (end as f32, j))) {
        let u = j as f32 / AROUND as f32;
        let (sin, cos) = (TAU * u).sin_cos();
        let outwards = Vec3::new(cos, sin, 0.0);
        side.positions.push(outwards + end * Vec3::Z);
        side.normals.push(outwards);
        side.uvs.push(Vec2::new(u, end));
    }
    for j in 0..AROUND {
        let above = j + AROUND + 1;
        side.triangles.extend([[j, j + 1, above + 1], [j, above + 1, above]]);
    }
    side
}

/// From a cylinder of radius one about z to that from `p0` to `p1`.
///
/// # Errors
/// If they are the same point.
pub(super) fn along(p0: Vec3, p1: Vec3, radius: f32) -> Result<DAffine3, String> {
    let [p0, p1] = [p0.as_dvec3(), p1.as_dvec3()];
    let axis = (p1 - p0).try_normalize().ok_or("a cylinder whose p0 and p1 are one point")?;
    let (x, y) = axis.any_orthonormal_pair();
    let radius = f64::from(radius);
    let axes = DMat3::from_cols(x * radius, y * radius, p1 - p0);
    Ok(DAffine3::from_mat3_translation(axes, p0))
}

/// `mesh` taken into the world, its front where its normals point.
pub(super) fn moved(mesh: Mesh, world: &DAffine3) -> Mesh {
    facing_outwards(placed(mesh, world))
}

/// `mesh` taken into the world with its normals, the order of the corners unchanged: a motion that mirrors turns
/// over meshes without normals.
pub(super) fn placed(mut mesh: Mesh, world: &DAffine3) -> Mesh {
    if *world == DAffine3::IDENTITY {
        return mesh;
    }
    let axes = world.matrix3;
    let [x, y, z] = [axes.x_axis, axes.y_axis, axes.z_axis];
    // The transposed inverse times the determinant: it exists even if the motion makes the mesh
    // flat.
    let sign = if axes.determinant() < 0.0 { -1.0 } else { 1.0 };
    let of_normals = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    for position in &mut mesh.positions {
        *position = world.transform_point3(position.as_dvec3()).as_vec3();
    }
    for normal in &mut mesh.normals {
        *normal = (of_normals * normal.as_dvec3()).normalize_or_zero().as_vec3();
    }
    mesh
}

/// `mesh` with the corners of each triangle in the order that fits its normals.
pub(super) fn facing_outwards(mut mesh: Mesh) -> Mesh {
    for triangle in &mut mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let normal: Vec3 = triangle.iter().map(|&i| mesh.normals[i as usize]).sum();
        if (b - a).cross(c - a).dot(normal) < 0.0 {
            triangle.swap(1, 2);
        }
    }
    mesh
}

/// The sphere of radius one about the origin, taken into the world; Mitsuba takes a motion that mirrors for a
/// radius below zero, which turns the front inside.
pub(super) fn sphere(world: &DAffine3) -> Mesh {
    let mesh = moved(Mesh::sphere(Vec3::ZERO, 1.0), world);
    if world.matrix3.determinant() < 0.0 { turned_over(mesh) } else { mesh }
}

/// `mesh` with the texture coordinates that Mitsuba gives meshes without any: (0, 0), (1, 0) and (0, 1) at the
/// corners of each triangle, in the order of the file.
pub(super) fn with_own_uvs(mesh: &Mesh) -> Mesh {
    let mut all = Mesh::default();
    for triangle in &mesh.triangles {
        let first = all.positions.len() as u32;
        all.positions.extend(triangle.map(|i| mesh.positions[i as usize]));
        all.normals.extend(triangle.map(|i| mesh.normals[i as usize]));
        all.uvs.extend([Vec2::ZERO, Vec2::X, Vec2::Y]);
        all.triangles.push([first, first + 1, first + 2]);
    }
    all
}

/// Whether `world` scales `axes` differently, which Mitsuba does not do with round shapes.
pub(super) fn stretches(world: &DAffine3, axes: [DVec3; 2]) -> bool {
    let [a, b] = axes.map(|axis| (world.matrix3 * axis).length());
    (a - b).abs() > 1e-4 * a.max(b)
}

/// `mesh` without normals made smooth: the mean of the triangles at a corner, by their angles there
/// [Thürmer and Wüthrich 1998]; normals that are there are kept.
pub(super) fn smooth(mut mesh: Mesh) -> Mesh {
    let count = mesh.positions.len();
    let mut sums = vec![DVec3::ZERO; count];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
        let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let Some(normal) = across.try_normalize() else { continue };
        for (i, &index) in triangle.iter().enumerate() {
            let [to_next, to_last] = [1, 2].map(|step| corners[(i + step) % 3] - corners[i]);
            sums[index as usize] += normal * to_next.angle_between(to_last);
        }
    }
    mesh.normals.resize(count, Vec3::ZERO);
    for (normal, sum) in mesh.normals.iter_mut().zip(sums) {
        if *normal == Vec3::ZERO {
            *normal = sum.normalize_or(DVec3::Y).as_vec3();
        }
    }
    mesh
}
