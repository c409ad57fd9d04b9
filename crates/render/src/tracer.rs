//! A scene prepared for ray tracing: flat vertex and triangle arrays, the acceleration structure,
//! the light samplers.

use crate::accel::{self, Accel, Hit, Ray};
use crate::appearance::Appearance;
use crate::coplanar::{InFront, in_front};
use crate::emitters::{Emitters, TriangleEmission};
use crate::guiding::SpecularGuide;
use crate::surface::{Frame, Surface};
use crate::virtual_lamps::{FlatFaces, VirtualLamps};
use glam::{Vec2, Vec3, Vec4};
use std::borrow::Cow;
use unrender_scene::{BrdfModel, Mesh, Scene, SceneError};

/// A scene prepared for ray tracing.
///
/// Geometry, lights and the BRDF model are fixed when it is built. Materials and the brightness of
/// lights ([`crate::Appearance`]) are arguments of each rendering, since recovery tries many on the
/// same geometry.
#[derive(Debug)]
pub struct Tracer {
    pub(crate) accel: Accel,
    pub(crate) emitters: Emitters,
    pub(crate) guide: SpecularGuide,
    pub(crate) flat_faces: FlatFaces,
    in_front: Vec<InFront>,
    pub(crate) model: BrdfModel,
    objects: Vec<TracedObject>,
    /// All triangles and all vertices of the scene.
    faces: Vec<Face>,
    vertices: Vec<Vertex>,
}

/// The attributes of one object.
#[derive(Debug)]
struct TracedObject {
    group: u32,
    /// The index of its first vertex in the scene.
    first_vertex: u32,
    /// Per vertex; empty if the object has none.
    uvs: Vec<Vec2>,
    tangents: Vec<Vec4>,
}

/// A triangle. Per-triangle hit data is contiguous.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// Vertex indices in the scene.
    corners: [u32; 3],
    object: u32,
    /// Unit normal of the front.
    normal: Vec3,
    /// How far off it rays that leave it start, metres.
    clearance: f32,
    /// If `is_flat`, the tangent of its frame; else the unit vector `dp/du`, zero where there is none.
    tangent: Vec3,
    /// Whether all its points have one frame: that of the shading normal of its first corner and `tangent`.
    is_flat: bool,
}

/// A vertex.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    position: Vec3,
    /// Unit shading normal.
    normal: Vec3,
}

impl Tracer {
    /// Prepares `scene`, which a reader of files or `Scene::validate` has checked.
    ///
    /// # Panics
    /// If [`Scene::check`] finds a fault, with its message; [`Tracer::try_new`] returns it.
    pub fn new(scene: &Scene) -> Self {
        Self::try_new(scene).unwrap_or_else(|fault| panic!("{fault}"))
    }

    /// Prepares `scene`, checked or not.
    ///
    /// ```
    /// use unrender_render::Tracer;
    /// use unrender_scene::{Mesh, Object, Scene};
    ///
    /// let mut scene = Scene::default();
    /// scene.objects.push(Object { name: "box".into(), group: 3, mesh: Mesh::default() });
    /// let fault = Tracer::try_new(&scene).unwrap_err();
    /// assert!(fault.to_string().contains("group 3"));
    /// ```
    ///
    /// # Errors
    /// Those of [`Scene::check`].
    pub fn try_new(scene: &Scene) -> Result<Self, SceneError> {
        scene.check()?;
        let flat_faces = FlatFaces::new(scene);
        let (moved, in_front) = in_front(scene, &flat_faces);
        let (scene, flat_faces) = match &moved {
            Cow::Borrowed(_) => (scene, flat_faces),
            Cow::Owned(moved) => (moved, FlatFaces::new(moved)),
        };
        let mut objects = Vec::with_capacity(scene.objects.len());
        let mut faces = Vec::with_capacity(scene.triangle_count());
        let mut vertices: Vec<Vertex> = Vec::new();
        for (index, object) in scene.objects.iter().enumerate() {
            let first_vertex = vertices.len() as u32;
            faces.extend(Face::all(&object.mesh, index as u32, first_vertex));
            let pairs = object.mesh.positions.iter().zip(&object.mesh.normals);
            vertices.extend(pairs.map(|(&position, &normal)| Vertex { position, normal }));
            objects.push(TracedObject {
                group: object.group as u32,
                first_vertex,
                uvs: object.mesh.uvs.clone(),
                tangents: object.mesh.tangents.clone(),
            });
        }
        faces.iter_mut().for_each(|face: &mut Face| {
            face.flatten(&objects[face.object as usize], &vertices);
        });
        let corners = |face: &Face| face.corners.map(|i| vertices[i as usize].position);
        let triangles: Vec<_> = faces.iter().map(corners).collect();
        let accel = Accel::build(&triangles);
        let group_of = |t: usize| objects[faces[t].object as usize].group as usize;
        let emission = |t: usize| TriangleEmission {
            group: group_of(t) as u32,
            radiance: scene.groups[group_of(t)].emission,
        };
        let emitters = Emitters::new(
            &triangles,
            emission,
            scene.groups.len() as u32,
            &scene.lights,
            accel.bounds(),
            scene.environment.as_ref(),
        );
        let guide = SpecularGuide::new(scene, emitters.layout().clone());
        let model = scene.brdf;
        Ok(Self { accel, emitters, guide, flat_faces, in_front, model, objects, faces, vertices })
    }

    /// The nearest surface along the ray.
    pub fn surface(&self, ray: &Ray) -> Option<Surface> {
        self.accel.closest(ray).map(|hit| self.surface_at(ray, hit))
    }

    /// The faces that lay in the plane of a larger one and were moved in front of it.
    pub fn in_front(&self) -> &[InFront] {
        &self.in_front
    }

    /// The indices of a triangle's object and group.
    pub fn object_and_group(&self, triangle: u32) -> (u32, u32) {
        let object = self.faces[triangle as usize].object;
        (object, self.objects[object as usize].group)
    }

    /// The lamps as planar mirrors show them under `appearance`.
    pub(crate) fn virtual_lamps(&self, appearance: &Appearance<'_>) -> VirtualLamps {
        VirtualLamps::new(&self.flat_faces, &self.accel, &self.emitters, appearance)
    }

    /// The unit normal of the front of a triangle.
    pub(crate) fn front_normal(&self, triangle: u32) -> Vec3 {
        self.faces[triangle as usize].normal
    }

    pub(crate) fn surface_at(&self, ray: &Ray, hit: Hit) -> Surface {
        let face = &self.faces[hit.triangle as usize];
        let object = &self.objects[face.object as usize];
        let corners = face.corners.map(|i| self.vertices[i as usize]);
        let [v, w] = hit.barycentric;
        let weights = [1.0 - v - w, v, w];
        let blend = |of: fn(&Vertex) -> Vec3| -> Vec3 {
            of(&corners[0]) * weights[0]
                + of(&corners[1]) * weights[1]
                + of(&corners[2]) * weights[2]
        };
        let front = ray.direction.dot(face.normal) < 0.0;
        let frame = if face.is_flat {
            Frame::orthonormal(corners[0].normal, face.tangent, front)
        } else {
            let shading = blend(|vertex| vertex.normal).try_normalize().unwrap_or(face.normal);
            let shading = if shading.dot(face.normal) < 0.0 { -shading } else { shading };
            Frame::new(shading, object.tangent(face, weights, shading), front)
        };
        Surface {
            point: blend(|vertex| vertex.position),
            triangle: hit.triangle,
            object: face.object,
            group: object.group,
            front,
            geometric_normal: if front { face.normal } else { -face.normal },
            clearance: face.clearance,
            frame,
            uv: object.uv(face, weights),
        }
    }
}

impl TracedObject {
    /// `TEXCOORD_0` at the barycentric `weights`; zero without any.
    fn uv(&self, face: &Face, weights: [f32; 3]) -> Vec2 {
        if self.uvs.is_empty() {
            return Vec2::ZERO;
        }
        (0..3).map(|i| self.uvs[(face.corners[i] - self.first_vertex) as usize] * weights[i]).sum()
    }

    /// The tangent from which the anisotropy direction is measured (`docs/reference/conventions.md`): glTF's
    /// TANGENT, else `dp/du`, else world +x, else world +z; not yet orthogonal to `normal`.
    fn tangent(&self, face: &Face, weights: [f32; 3], normal: Vec3) -> Vec3 {
        let usable = |t: Vec3| t.is_finite() && t.reject_from(normal).length_squared() > 1e-12;
        if !self.tangents.is_empty() {
            let tangent = |corner: u32| self.tangents[(corner - self.first_vertex) as usize];
            let given: Vec3 =
                (0..3).map(|i| tangent(face.corners[i]).truncate() * weights[i]).sum();
            if usable(given) {
                return given;
            }
        }
        if usable(face.tangent) {
            return face.tangent;
        }
        if Vec3::X.reject_from(normal).length_squared() > 1e-4 { Vec3::X } else { Vec3::Z }
    }
}

impl Face {
    /// The triangles of the object with the index `object`, whose first vertex has the index
    /// `first_vertex`.
    fn all(mesh: &Mesh, object: u32, first_vertex: u32) -> impl Iterator<Item = Self> {
        (0..mesh.triangles.len()).map(move |index| {
            let corners = mesh.triangles[index];
            let dp_du = if mesh.uvs.is_empty() {
                Vec3::ZERO
            } else {
                dp_du(mesh, corners.map(|i| i as usize)).normalize_or_zero()
            };
            let places = mesh.corners(index);
            let (normal, clearance) = (accel::front_normal(places), accel::clearance(places));
            let corners = corners.map(|i| i + first_vertex);
            Self { corners, object, normal, clearance, tangent: dp_du, is_flat: false }
        })
    }

    /// Notices whether all points have one frame, and prepares it.
    fn flatten(&mut self, object: &TracedObject, vertices: &[Vertex]) {
        let [normal, b, c] = self.corners.map(|i| vertices[i as usize].normal);
        let is_unit = (normal.length_squared() - 1.0).abs() < 1e-6;
        let is_one = normal == b && normal == c && normal.dot(self.normal) > 0.0;
        if is_unit && is_one && object.tangents.is_empty() {
            let tangent = object.tangent(self, [1.0, 0.0, 0.0], normal);
            (self.tangent, self.is_flat) = (Frame::new(normal, tangent, true).tangent, true);
        }
    }
}

/// The direction of `dp/du` of a triangle [Pharr et al. 2023, section 6.5]; zero where the texture
/// coordinates span no area.
fn dp_du(mesh: &Mesh, [a, b, c]: [usize; 3]) -> Vec3 {
    let (e1, e2) = (mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    let (d1, d2) = (mesh.uvs[b] - mesh.uvs[a], mesh.uvs[c] - mesh.uvs[a]);
    let area = d1.perp_dot(d2);
    if area.abs() <= f32::EPSILON * d1.length() * d2.length() {
        return Vec3::ZERO;
    }
    (e1 * d2.y - e2 * d1.y) * area.signum()
}
