//! The shapes of a scene as flat arrays of vertices and triangles, and the surfaces at their points.

use crate::accel::{self, Hit, Ray};
use crate::surface::{Frame, NOTHING, Surface};
use glam::{Vec2, Vec3, Vec4};
use unrender_scene::{Detail, Glass, Mesh, Scene};

/// Normals of maps are raised to this cosine above the plane of the triangle: half a degree. Half and double of it change
/// normals that no light reaches.
const RAISED: f32 = 0.01;

/// All shapes: those of the scene's groups first, then the glass.
#[derive(Debug)]
pub(crate) struct Shapes {
    shapes: Vec<Shape>,
    faces: Vec<Face>,
    vertices: Vec<Vertex>,
    /// The number of faces that belong to groups.
    grouped: usize,
}

/// The attributes of one object, or of a shape of glass.
#[derive(Debug)]
struct Shape {
    /// [`NOTHING`] of glass.
    group: u32,
    /// The index of its first vertex in the scene.
    first_vertex: u32,
    /// Per vertex; empty if the object has none.
    uvs: Vec<Vec2>,
    tangents: Vec<Vec4>,
    detail: Detail,
    glass: Option<Glass>,
}

/// A triangle. Per-triangle hit data is contiguous.
#[derive(Clone, Copy, Debug)]
struct Face {
    /// Vertex indices in the scene.
    corners: [u32; 3],
    /// The index of its shape.
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

impl Shapes {
    /// Those of `scene`.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut all = Self {
            shapes: Vec::with_capacity(scene.objects.len()),
            faces: Vec::with_capacity(scene.triangle_count()),
            vertices: Vec::new(),
            grouped: scene.triangle_count(),
        };
        for object in &scene.objects {
            all.add(&object.mesh, object.group as u32, None);
            // Light samples do not know holes.
            if let Some(lamp) =
                all.shapes.last_mut().filter(|_| scene.groups[object.group].is_emitter())
            {
                lamp.detail.coverage = None;
            }
        }
        for shape in scene.ungrouped.iter().filter(|shape| shape.glass.is_some()) {
            all.add(&shape.mesh, NOTHING, shape.glass);
        }
        let Self { shapes, faces, vertices, .. } = &mut all;
        faces.iter_mut().for_each(|face| face.flatten(&shapes[face.object as usize], vertices));
        all
    }

    fn add(&mut self, mesh: &Mesh, group: u32, glass: Option<Glass>) {
        let first_vertex = self.vertices.len() as u32;
        self.faces.extend(Face::all(mesh, self.shapes.len() as u32, first_vertex));
        let pairs = mesh.positions.iter().zip(&mesh.normals);
        self.vertices.extend(pairs.map(|(&position, &normal)| Vertex { position, normal }));
        let detail = if mesh.uvs.is_empty() { Detail::default() } else { mesh.detail.clone() };
        let (uvs, tangents) = (mesh.uvs.clone(), mesh.tangents.clone());
        self.shapes.push(Shape { group, first_vertex, uvs, tangents, detail, glass });
    }

    /// The corners of all triangles.
    pub(crate) fn triangles(&self) -> Vec<[Vec3; 3]> {
        let corners = |face: &Face| face.corners.map(|i| self.vertices[i as usize].position);
        self.faces.iter().map(corners).collect()
    }

    /// The number of triangles that belong to groups; they come first.
    pub(crate) fn grouped(&self) -> usize {
        self.grouped
    }

    /// The indices of a triangle's object and group.
    pub(crate) fn object_and_group(&self, triangle: u32) -> (u32, u32) {
        let object = self.faces[triangle as usize].object;
        (object, self.shapes[object as usize].group)
    }

    /// The unit normal of the front of a triangle.
    pub(crate) fn front_normal(&self, triangle: u32) -> Vec3 {
        self.faces[triangle as usize].normal
    }

    /// The glass of a triangle.
    pub(crate) fn glass(&self, triangle: u32) -> Option<&Glass> {
        self.shapes[self.faces[triangle as usize].object as usize].glass.as_ref()
    }

    /// Whether rays may pass a triangle: it is of glass, or has holes.
    pub(crate) fn is_veiled(&self, triangle: u32) -> bool {
        let shape = &self.shapes[self.faces[triangle as usize].object as usize];
        shape.glass.is_some() || shape.detail.coverage.is_some()
    }

    /// Whether there is a hole where a ray hits.
    pub(crate) fn is_hole(&self, hit: &Hit) -> bool {
        let face = &self.faces[hit.triangle as usize];
        let shape = &self.shapes[face.object as usize];
        let [v, w] = hit.barycentric;
        let coverage = shape.detail.coverage.as_ref();
        coverage.is_some_and(|coverage| coverage.is_hole(shape.uv(face, [1.0 - v - w, v, w])))
    }

    /// Where `ray` goes on behind the triangle that it hits.
    pub(crate) fn behind(&self, ray: &Ray, hit: &Hit) -> Ray {
        let face = &self.faces[hit.triangle as usize];
        let [a, b, c] = face.corners.map(|i| self.vertices[i as usize].position);
        let [v, w] = hit.barycentric;
        let point = a * (1.0 - v - w) + b * v + c * w;
        let away = face.normal * face.clearance.copysign(ray.direction.dot(face.normal));
        Ray { origin: point + away, t_max: ray.t_max - hit.t, ..*ray }
    }

    /// The surface where `ray` hits.
    pub(crate) fn surface_at(&self, ray: &Ray, hit: Hit) -> Surface {
        let face = &self.faces[hit.triangle as usize];
        let shape = &self.shapes[face.object as usize];
        let corners = face.corners.map(|i| self.vertices[i as usize]);
        let [v, w] = hit.barycentric;
        let weights = [1.0 - v - w, v, w];
        let blend = |of: fn(&Vertex) -> Vec3| -> Vec3 {
            of(&corners[0]) * weights[0]
                + of(&corners[1]) * weights[1]
                + of(&corners[2]) * weights[2]
        };
        let front = ray.direction.dot(face.normal) < 0.0;
        let uv = shape.uv(face, weights);
        let map = shape.detail.normals.as_ref();
        let (frame, mesh_normal) = if face.is_flat && map.is_none() {
            let frame = Frame::orthonormal(corners[0].normal, face.tangent, front);
            (frame, frame.normal)
        } else {
            let mesh = blend(|vertex| vertex.normal).try_normalize().unwrap_or(face.normal);
            let mesh = if mesh.dot(face.normal) < 0.0 { -mesh } else { mesh };
            let mapped = map.and_then(|map| shape.mapped_normal(face, weights, mesh, map.at(uv)));
            let tangent = shape.tangent(face, weights, mesh);
            let frame = Frame::new(mapped.unwrap_or(mesh), tangent, front);
            (frame, if front { mesh } else { -mesh })
        };
        Surface {
            point: blend(|vertex| vertex.position),
            triangle: hit.triangle,
            object: face.object,
            group: shape.group,
            front,
            geometric_normal: if front { face.normal } else { -face.normal },
            clearance: face.clearance,
            frame,
            uv,
            to_viewer: -ray.direction,
            mesh_normal,
            shades_itself: map.is_some_and(|map| map.shades_itself),
        }
    }
}

impl Shape {
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

    /// The unit normal of the front that `mapped`, a normal in tangent space, stands for, where the mesh has the normal
    /// `shading`; none where there is no tangent space.
    fn mapped_normal(
        &self,
        face: &Face,
        weights: [f32; 3],
        shading: Vec3,
        mapped: Vec3,
    ) -> Option<Vec3> {
        let corners = face.corners.map(|i| (i - self.first_vertex) as usize);
        let (tangent, handedness) = if self.tangents.is_empty() {
            // The picture's upward direction is that of decreasing v.
            let [a, b, c] = corners.map(|i| self.uvs[i]);
            (face.tangent, -(b - a).perp_dot(c - a).signum())
        } else {
            let tangent: Vec4 = (0..3).map(|i| self.tangents[corners[i]] * weights[i]).sum();
            (tangent.truncate(), tangent.w.signum())
        };
        let tangent = tangent.reject_from(shading).try_normalize()?;
        let bitangent = shading.cross(tangent) * handedness;
        let normal = tangent * mapped.x + bitangent * mapped.y + shading * mapped.z;
        let sunk = RAISED - normal.dot(face.normal);
        (normal + sunk.max(0.0) * face.normal).try_normalize()
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
    fn flatten(&mut self, shape: &Shape, vertices: &[Vertex]) {
        let [normal, b, c] = self.corners.map(|i| vertices[i as usize].normal);
        let is_unit = (normal.length_squared() - 1.0).abs() < 1e-6;
        let is_one = normal == b && normal == c && normal.dot(self.normal) > 0.0;
        if is_unit && is_one && shape.tangents.is_empty() {
            let tangent = shape.tangent(self, [1.0, 0.0, 0.0], normal);
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
