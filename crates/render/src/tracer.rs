//! A scene made ready for rays: flat arrays, the tree, and the lights.

use crate::accel::{Accel, Hit, Ray};
use crate::caustic::Caustics;
use crate::emitters::Emitters;
use crate::surface::{Frame, Surface};
use glam::{Vec2, Vec3};
use unrender_scene::{BrdfModel, Material, Mesh, Rgb, Scene};

/// Answers what light does in one scene, for any materials of its groups.
///
/// Geometry, lights and the form of Ward's lobe are fixed when it is built; materials come with
/// each question, since recovery tries many on the same geometry.
#[derive(Debug)]
pub struct Tracer {
    pub(crate) accel: Accel,
    pub(crate) emitters: Emitters,
    pub(crate) caustics: Caustics,
    pub(crate) model: BrdfModel,
    objects: Vec<TracedObject>,
    /// For each triangle of the scene: its object.
    object_of_triangle: Vec<u32>,
}

/// An object's mesh and where its triangles start in the scene's count.
#[derive(Debug)]
struct TracedObject {
    mesh: Mesh,
    group: u32,
    first_triangle: u32,
    /// For each triangle the unit vector in which u grows and v stays, zero where there is none;
    /// empty without texture coordinates.
    growing_u: Vec<Vec3>,
}

impl Tracer {
    /// Prepares `scene`, which has passed `Scene::validate`.
    pub fn new(scene: &Scene) -> Self {
        let mut objects = Vec::with_capacity(scene.objects.len());
        let mut object_of_triangle = Vec::new();
        let mut triangles = Vec::with_capacity(scene.triangle_count());
        for object in &scene.objects {
            let first_triangle = triangles.len() as u32;
            triangles.extend((0..object.mesh.triangles.len()).map(|i| object.mesh.corners(i)));
            object_of_triangle.resize(triangles.len(), objects.len() as u32);
            objects.push(TracedObject {
                mesh: object.mesh.clone(),
                group: object.group as u32,
                first_triangle,
                growing_u: growing_u(&object.mesh),
            });
        }
        let accel = Accel::build(&triangles);
        let group_of = |t: usize| objects[object_of_triangle[t] as usize].group as usize;
        let emission = |t: usize| scene.groups[group_of(t)].emission;
        let emitters = Emitters::new(
            &triangles,
            |t| (group_of(t) as u32, emission(t)),
            (&scene.lights, scene.groups.len() as u32),
            accel.bounds(),
            scene.environment.as_ref(),
        );
        let caustics = Caustics::new(scene);
        Self { accel, emitters, caustics, model: scene.brdf, objects, object_of_triangle }
    }

    /// The nearest surface along the ray.
    pub fn surface(&self, ray: &Ray) -> Option<Surface> {
        self.accel.closest(ray).map(|hit| self.surface_at(ray, hit))
    }

    /// The object's and the group's index of a triangle.
    pub fn object_and_group(&self, triangle: u32) -> (u32, u32) {
        let object = self.object_of_triangle[triangle as usize];
        (object, self.objects[object as usize].group)
    }

    fn surface_at(&self, ray: &Ray, hit: Hit) -> Surface {
        let object_index = self.object_of_triangle[hit.triangle as usize];
        let object = &self.objects[object_index as usize];
        let mesh = &object.mesh;
        let index = (hit.triangle - object.first_triangle) as usize;
        let corners = mesh.triangles[index];
        let [v, w] = hit.barycentric;
        let weights = [1.0 - v - w, v, w];
        let blend = |values: &[Vec3]| -> Vec3 {
            (0..3).map(|i| values[corners[i] as usize] * weights[i]).sum()
        };
        let front_normal = self.accel.front_normal(hit.triangle);
        let front = ray.direction.dot(front_normal) < 0.0;
        let mut shading = blend(&mesh.normals).try_normalize().unwrap_or(front_normal);
        if shading.dot(front_normal) < 0.0 {
            shading = -shading;
        }
        let uv = if mesh.uvs.is_empty() {
            Vec2::ZERO
        } else {
            (0..3).map(|i| mesh.uvs[corners[i] as usize] * weights[i]).sum()
        };
        Surface {
            point: blend(&mesh.positions),
            triangle: hit.triangle,
            object: object_index,
            group: object.group,
            front,
            geometric_normal: if front { front_normal } else { -front_normal },
            frame: Frame::new(shading, object.tangent(index, weights, shading), front),
            uv,
        }
    }
}

impl TracedObject {
    /// The zero of the brushed angle (design: `docs/conventions.md`): glTF's TANGENT, else the
    /// direction of growing u, else the projection of world +x, else of world +z.
    fn tangent(&self, triangle: usize, weights: [f32; 3], normal: Vec3) -> Vec3 {
        let usable = |t: Vec3| t.is_finite() && t.reject_from(normal).length_squared() > 1e-12;
        if !self.mesh.tangents.is_empty() {
            let corners = self.mesh.triangles[triangle];
            let tangent = |i: usize| self.mesh.tangents[corners[i] as usize].truncate();
            let given: Vec3 = (0..3).map(|i| tangent(i) * weights[i]).sum();
            if usable(given) {
                return given;
            }
        }
        match self.growing_u.get(triangle) {
            Some(growing_u) if usable(*growing_u) => *growing_u,
            _ if Vec3::X.reject_from(normal).length_squared() > 1e-4 => Vec3::X,
            _ => Vec3::Z,
        }
    }
}

/// For each triangle the unit vector in which u grows and v stays, if there are such.
fn growing_u(mesh: &Mesh) -> Vec<Vec3> {
    if mesh.uvs.is_empty() {
        return Vec::new();
    }
    let corners = mesh.triangles.iter().map(|corners| corners.map(|i| i as usize));
    corners.map(|corners| direction_of_u(mesh, corners).normalize_or_zero()).collect()
}

/// The direction on a triangle in which u grows and v stays; zero where the texture coordinates
/// span no area, and so no such direction.
fn direction_of_u(mesh: &Mesh, [a, b, c]: [usize; 3]) -> Vec3 {
    let (e1, e2) = (mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    let (d1, d2) = (mesh.uvs[b] - mesh.uvs[a], mesh.uvs[c] - mesh.uvs[a]);
    let area = d1.perp_dot(d2);
    if area.abs() <= f32::EPSILON * d1.length() * d2.length() {
        return Vec3::ZERO;
    }
    (e1 * d2.y - e2 * d1.y) * area.signum()
}

/// What a question assumes of the scene beyond its geometry: what recovery guesses.
#[derive(Clone, Copy, Debug)]
pub struct Appearance<'a> {
    /// The material of every group.
    pub materials: &'a [Material],
    /// How many times as bright as in the scene each source shines, per channel: first the groups
    /// (those that emit), then the lights without a surface, then the environment. Sources beyond
    /// the end shine as they are.
    pub lights: &'a [Rgb],
}

impl Appearance<'_> {
    /// How many times as bright as in the scene `source` shines.
    pub fn light(&self, source: u32) -> Rgb {
        self.lights.get(source as usize).copied().unwrap_or(Rgb::ONE)
    }
}

impl<'a> From<&'a [Material]> for Appearance<'a> {
    fn from(materials: &'a [Material]) -> Self {
        Self { materials, lights: &[] }
    }
}

impl<'a, const N: usize> From<&'a [Material; N]> for Appearance<'a> {
    fn from(materials: &'a [Material; N]) -> Self {
        materials.as_slice().into()
    }
}

impl<'a> From<&'a Vec<Material>> for Appearance<'a> {
    fn from(materials: &'a Vec<Material>) -> Self {
        materials.as_slice().into()
    }
}
