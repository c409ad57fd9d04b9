//! Surfaces as meshes.

use super::primitives::Primitive;
use crate::import::shapes;
use crate::polygon;
use glam::{DVec3, Vec3};
use unrender_scene::Mesh;

/// A round surface as a mesh. A radius below zero turns it inside out, as in Radiance.
pub(super) fn round(primitive: &Primitive) -> Result<Mesh, String> {
    let ends = |n: &[f32]| [Vec3::from_slice(&n[..3]), Vec3::from_slice(&n[3..6])];
    let kind = primitive.kind.as_str();
    let mut is_inside_out = matches!(kind, "bubble" | "tube" | "cup");
    let mut upright = |radii: [f32; 2]| {
        let [least, most] = [radii[0].min(radii[1]), radii[0].max(radii[1])];
        if least < 0.0 && most > 0.0 {
            return Err(format!("{} has one radius below zero", primitive.named()));
        }
        is_inside_out ^= least < 0.0;
        Ok(radii.map(f32::abs))
    };
    let mesh = match kind {
        "sphere" | "bubble" => {
            let [x, y, z, radius] = primitive.reals()?;
            Mesh::sphere(Vec3::new(x, y, z), upright([radius; 2])?[0])
        }
        "cylinder" | "tube" => {
            let reals: [f32; 7] = primitive.reals()?;
            shapes::frustum(ends(&reals), upright([reals[6]; 2])?)
        }
        "ring" => {
            let reals: [f32; 8] = primitive.reals()?;
            let [from, to] = ends(&reals);
            shapes::ring(from, to, [reals[6].max(0.0), reals[7].max(0.0)])
        }
        _ => {
            let reals: [f32; 8] = primitive.reals()?;
            shapes::frustum(ends(&reals), upright([reals[6], reals[7]])?)
        }
    };
    Ok(if is_inside_out { shapes::turned_over(mesh) } else { mesh })
}

/// A polygon, convex or not, as triangles.
pub(super) fn polygon(primitive: &Primitive) -> Result<Mesh, String> {
    let corners: Vec<Vec3> =
        primitive.reals.chunks_exact(3).map(|c| DVec3::from_slice(c).as_vec3()).collect();
    if corners.len() < 3 || !primitive.reals.len().is_multiple_of(3) {
        return Err(format!("the polygon \"{}\" has fewer than three corners", primitive.id));
    }
    let all: Vec<u32> = (0..corners.len() as u32).collect();
    let mut triangles = Vec::new();
    polygon::split(&all, |&i| corners[i as usize], &mut triangles)
        .map_err(|problem| format!("\"{}\" {problem}", primitive.id))?;
    Ok(Mesh::flat(&corners, &[], &triangles))
}

/// Gives `mesh` tangents along the direction `along` of the world.
pub(super) fn brush(mesh: &mut Mesh, along: DVec3) {
    let along = along.as_vec3();
    let tangent = |normal: &Vec3| {
        let flat = (along - *normal * normal.dot(along)).try_normalize();
        flat.unwrap_or_else(|| normal.any_orthogonal_vector().normalize_or(Vec3::X)).extend(1.0)
    };
    mesh.tangents = mesh.normals.iter().map(tangent).collect();
}
