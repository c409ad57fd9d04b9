//! Flat faces: the coplanar triangles of an object taken together. A box has six of them, a table of
//! one mesh as many as it has sides.

use crate::accel;
use glam::Vec3;
use unrender_scene::{Mesh, Object, Scene};

/// Most faces of an object: its largest. With half of it a table of several parts loses some, with
/// double of it objects of many facets take longer to prepare and gain nothing.
const FACES_MAX: usize = 16;
/// Faces of an object that are smaller than this share of its largest one are left out: what they
/// reflect is little, and is found by chance. With half of it bevels count, with double of it the
/// narrow sides of boards do not.
const AREA_MIN: f32 = 0.02;
/// Unit vectors that differ by less than this (radians) are the same: single precision and files of
/// four decimals. With double of it the image of a lamp is off by 4 mm at a metre.
const SAME_NORMAL: f32 = 1e-3;
/// Corners lie in a plane if they are off it by less than this share of the object's extent. Half of
/// it is near single precision, double of it shifts images by as much.
const SAME_PLANE: f32 = 1e-5;
/// Most triangles of a face that rays start from to find out what the face sees. With half of it a face of many
/// triangles is judged by a part of it, double of it takes memory.
const SHOWN: usize = 64;
/// The face of a triangle that belongs to none.
const NONE: u16 = u16::MAX;

/// The flat faces of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct FlatFaces {
    faces: Vec<FlatFace>,
    /// The corners of triangles of each face, at most [`SHOWN`].
    triangles: Vec<Vec<[Vec3; 3]>>,
    /// By triangle: the index of its face, or [`NONE`].
    of_triangle: Vec<u16>,
}

/// Coplanar triangles of an object, whose shading normals are those of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlatFace {
    pub(crate) group: u32,
    /// A point of the plane.
    pub(crate) point: Vec3,
    /// Unit normal of the plane; which side it points to has no meaning.
    pub(crate) normal: Vec3,
    /// The bounding box.
    pub(crate) bounds: [Vec3; 2],
    /// Square metres; a face that is modelled from both sides counts twice.
    pub(crate) area: f32,
    /// How far off it rays that leave it start, metres.
    pub(crate) clearance: f32,
}

impl FlatFaces {
    /// Finds the flat faces of `scene`.
    pub(crate) fn new(scene: &Scene) -> Self {
        let mut all = Self::default();
        for object in &scene.objects {
            let first = all.faces.len();
            let (faces, places) = of_object(object);
            // The last index means that there is none.
            let room = (NONE as usize).saturating_sub(first).min(faces.len());
            all.faces.extend(&faces[..room]);
            all.triangles.resize(all.faces.len(), Vec::new());
            for (triangle, place) in places.iter().enumerate() {
                let Some(place) = place.filter(|place| *place < room) else { continue };
                let shown = &mut all.triangles[first + place];
                if shown.len() < SHOWN {
                    shown.push(object.mesh.corners(triangle));
                }
            }
            let index = |place: Option<usize>| match place {
                Some(place) if place < room => (first + place) as u16,
                _ => NONE,
            };
            all.of_triangle.extend(places.into_iter().map(index));
        }
        all
    }

    /// All faces; their places are the numbers that [`FlatFaces::of`] gives.
    pub(crate) fn all(&self) -> &[FlatFace] {
        &self.faces
    }

    /// The corners of triangles of the face at `place`.
    pub(super) fn triangles(&self, place: u16) -> &[[Vec3; 3]] {
        &self.triangles[place as usize]
    }

    /// The face that a triangle of the scene belongs to.
    #[inline]
    pub(crate) fn of(&self, triangle: u32) -> Option<u16> {
        self.of_triangle.get(triangle as usize).copied().filter(|face| *face != NONE)
    }
}

/// A triangle whose shading normals are its own.
struct FlatTriangle {
    index: usize,
    corners: [Vec3; 3],
    normal: Vec3,
    area: f32,
}

impl FlatTriangle {
    fn of(mesh: &Mesh, index: usize) -> Option<Self> {
        let corners = mesh.corners(index);
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        let normal = cross.try_normalize()?;
        let flat = |vertex: &u32| is_parallel(mesh.normals[*vertex as usize], normal);
        let triangle = Self { index, corners, normal, area: 0.5 * cross.length() };
        mesh.triangles[index].iter().all(flat).then_some(triangle)
    }
}

/// Whether two unit vectors are the same or opposite.
fn is_parallel(a: Vec3, b: Vec3) -> bool {
    let off = (a - b).length_squared().min((a + b).length_squared());
    off <= SAME_NORMAL * SAME_NORMAL
}

/// The flat faces of an object, and for each of its triangles the place of its face among them.
fn of_object(object: &Object) -> (Vec<FlatFace>, Vec<Option<usize>>) {
    let mesh = &object.mesh;
    let count = mesh.triangles.len();
    if !mesh.detail.is_none() {
        return (Vec::new(), vec![None; count]);
    }
    let mut triangles: Vec<_> = (0..count).filter_map(|i| FlatTriangle::of(mesh, i)).collect();
    // The largest triangles define the planes.
    triangles.sort_by(|a, b| b.area.total_cmp(&a.area));
    let [low, high] = bounds(mesh.positions.iter().copied());
    let thickness = SAME_PLANE * (high - low).length();
    let mut faces: Vec<FlatFace> = Vec::new();
    let mut places = vec![None; count];
    for triangle in triangles {
        let place = faces.iter().position(|face| face.holds(&triangle, thickness));
        let place = place.or_else(|| {
            let FlatTriangle { corners, normal, .. } = triangle;
            let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
            let group = object.group as u32;
            let (point, area, clearance) = (corners[0], 0.0, 0.0);
            let face = FlatFace { group, point, normal, bounds: nothing, area, clearance };
            (faces.len() < FACES_MAX).then(|| faces.push(face)).map(|()| faces.len() - 1)
        });
        let Some(place) = place else { continue };
        places[triangle.index] = Some(place);
        let face = &mut faces[place];
        face.area += triangle.area;
        face.clearance = face.clearance.max(accel::clearance(triangle.corners));
        let [low, high] = bounds(triangle.corners);
        face.bounds = [face.bounds[0].min(low), face.bounds[1].max(high)];
    }
    keep_large(faces, places)
}

/// Leaves small faces out.
fn keep_large(
    faces: Vec<FlatFace>,
    places: Vec<Option<usize>>,
) -> (Vec<FlatFace>, Vec<Option<usize>>) {
    let largest = faces.iter().map(|face| face.area).fold(0.0, f32::max);
    let mut kept = Vec::new();
    let place_of = |face: &FlatFace| {
        (face.area >= AREA_MIN * largest).then(|| kept.push(*face)).map(|()| kept.len() - 1)
    };
    let moved: Vec<_> = faces.iter().map(place_of).collect();
    (kept, places.into_iter().map(|place| place.and_then(|place| moved[place])).collect())
}

impl FlatFace {
    /// The distance of `point` from the plane, positive on the side that the normal points to.
    #[inline]
    pub(crate) fn height(&self, point: Vec3) -> f32 {
        (point - self.point).dot(self.normal)
    }

    /// The extent of the face, metres.
    pub(crate) fn extent(&self) -> f32 {
        (self.bounds[1] - self.bounds[0]).length()
    }

    /// Whether the two normals are the same or opposite.
    pub(crate) fn is_parallel_to(&self, other: &Self) -> bool {
        is_parallel(self.normal, other.normal)
    }

    fn holds(&self, triangle: &FlatTriangle, thickness: f32) -> bool {
        is_parallel(self.normal, triangle.normal)
            && triangle.corners.iter().all(|corner| self.height(*corner).abs() <= thickness)
    }
}

fn bounds(points: impl IntoIterator<Item = Vec3>) -> [Vec3; 2] {
    let nothing = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    points.into_iter().fold(nothing, |[low, high], p| [low.min(p), high.max(p)])
}
