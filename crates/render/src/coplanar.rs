//! Flat faces that overlap in one plane: the smaller one is moved in front.
//!
//! Rays would meet the one or the other by chance there, and those that start at the one would pass through the other.
//! A rug that lies at its floor's very height, a poster in the plane of its wall, a lamp in that of its ceiling are
//! meant to be seen, so the smaller face is moved along its normal, just so far that rays tell the two apart. Faces that
//! look in opposite directions, as a box on the floor, hide each other; of two of one size nobody knows which is meant.

use crate::virtual_lamps::{FlatFace, FlatFaces};
use glam::Vec3;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use unrender_scene::{Mesh, Scene};

/// How far a face is moved in front, in distances at which rays start off the two: rays from either start on its own
/// side of the other then. At half of it they may just touch; double of it is twice as visible.
pub const APART: f32 = 4.0;
/// The largest share of a face's area that a smaller one has. Faces nearer in size are copies, each rounded in its own
/// way; half and double the difference to one were not tried.
const SMALLER: f32 = 0.99;
/// Points nearer to the edge of a triangle than this share of its height belong to its neighbour, too: single precision,
/// and files of four decimals. Half and double were not tried.
const INSIDE: f32 = 1e-4;

/// A face that was moved in front of a larger one: the indices of their objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct InFront {
    /// The object with the smaller face.
    pub object: usize,
    /// The object with the larger one, in whose plane that lies.
    pub of: usize,
}

/// The scene with smaller faces in front of larger ones of other groups in their plane, and what was moved.
/// `faces` are those of the scene.
pub(crate) fn in_front<'a>(scene: &'a Scene, faces: &FlatFaces) -> (Cow<'a, Scene>, Vec<InFront>) {
    let planes = Planes::new(scene, faces);
    let pairs = planes.pairs();
    let mut moved = Cow::Borrowed(scene);
    for (place, by) in planes.moves(&pairs) {
        let Plane { object, triangles, front, .. } = &planes.all[place];
        let mesh = &mut moved.to_mut().objects[*object].mesh;
        // A corner that several triangles share moves once.
        let corners: BTreeSet<u32> =
            triangles.iter().flat_map(|triangle| mesh.triangles[*triangle]).collect();
        corners.into_iter().for_each(|corner| mesh.positions[corner as usize] += by * *front);
    }
    let object = |place: usize| planes.all[place].object;
    let found = pairs.iter().map(|[a, b]| InFront { object: object(*a), of: object(*b) });
    let found: BTreeSet<InFront> = found.collect();
    (moved, found.into_iter().collect())
}

/// A face of which all triangles look to one side.
struct Plane {
    object: usize,
    face: FlatFace,
    /// Unit normal of its front.
    front: Vec3,
    /// The distance of its plane from the origin, metres.
    distance: f32,
    /// The indices of its triangles in its mesh.
    triangles: Vec<usize>,
}

/// The faces of a scene that look to one side, by the distances of their planes from the origin.
struct Planes<'a> {
    scene: &'a Scene,
    all: Vec<Plane>,
}

impl<'a> Planes<'a> {
    fn new(scene: &'a Scene, faces: &FlatFaces) -> Self {
        let (mut all, mut first) = (Vec::new(), 0);
        for (object, mesh) in scene.objects.iter().map(|object| &object.mesh).enumerate() {
            let mut of_face: BTreeMap<u16, Vec<usize>> = BTreeMap::new();
            for triangle in 0..mesh.triangles.len() {
                if let Some(place) = faces.of((first + triangle) as u32) {
                    of_face.entry(place).or_default().push(triangle);
                }
            }
            first += mesh.triangles.len();
            all.extend(of_face.into_iter().filter_map(|(place, triangles)| {
                let face = faces.all()[place as usize];
                let front = front(mesh, &triangles, face.normal)?;
                let distance = face.height(Vec3::ZERO).abs();
                Some(Plane { object, face, front, distance, triangles })
            }));
        }
        all.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        Self { scene, all }
    }

    /// The pairs of faces of two groups that overlap in one plane and look to one side, the smaller one first, by their
    /// places.
    fn pairs(&self) -> Vec<[usize; 2]> {
        let near = APART * self.all.iter().map(|plane| plane.face.clearance).fold(0.0, f32::max);
        let mut pairs = Vec::new();
        for (i, one) in self.all.iter().enumerate() {
            let others = self.all.iter().enumerate().skip(i + 1);
            for (j, other) in others.take_while(|(_, o)| o.distance - one.distance <= near) {
                let small_first = one.face.area < other.face.area;
                let pair = if small_first { [i, j] } else { [j, i] };
                let [small, large] = pair.map(|place| &self.all[place]);
                if small.may_lie_before(large) && self.overlap(small, large) {
                    pairs.push(pair);
                }
            }
        }
        pairs
    }

    /// The faces that move, by their places, and how far along their fronts, metres: each before all that lie below it.
    fn moves(&self, pairs: &[[usize; 2]]) -> BTreeMap<usize, f32> {
        let area = |place: usize| self.all[place].face.area;
        let mut pairs = pairs.to_vec();
        pairs.sort_by(|a, b| area(b[0]).total_cmp(&area(a[0])).then(a.cmp(b)));
        let mut moves = BTreeMap::new();
        for [small, large] in pairs {
            let below = moves.get(&large).copied().unwrap_or(0.0);
            let by = below + APART * self.all[small].clearance_with(&self.all[large]);
            let so_far = moves.entry(small).or_insert(0.0f32);
            *so_far = so_far.max(by);
        }
        moves
    }

    /// Whether all of `small` lies in the plane of `large`, and a point of it in `large` itself.
    fn overlap(&self, small: &Plane, large: &Plane) -> bool {
        let corners = |plane: &Plane, triangle: usize| {
            self.scene.objects[plane.object].mesh.corners(triangle)
        };
        let [low, high] = small.face.bounds;
        let near = small.clearance_with(large);
        let is_beside = |[a, b, c]: &[Vec3; 3]| {
            (a.max(*b).max(*c) + near).cmplt(low).any()
                || (a.min(*b).min(*c) - near).cmpgt(high).any()
        };
        let of_large = large.triangles.iter().map(|triangle| corners(large, *triangle));
        let below: Vec<[Vec3; 3]> = of_large.filter(|triangle| !is_beside(triangle)).collect();
        let of_small = || small.triangles.iter().map(|triangle| corners(small, *triangle));
        of_small().flatten().all(|corner| large.face.height(corner).abs() <= near)
            && of_small()
                .flat_map(points)
                .any(|point| below.iter().any(|triangle| lies_over(point, triangle)))
    }
}

impl Plane {
    /// How far off the two the rays start that leave them, metres: what is nearer is one with them.
    fn clearance_with(&self, other: &Self) -> f32 {
        self.face.clearance.max(other.face.clearance)
    }

    /// Whether it is smaller than `large`, of another group, looks to the same side, and lies near it, with one corner in
    /// its plane.
    fn may_lie_before(&self, large: &Self) -> bool {
        let near = self.clearance_with(large);
        let ([low, high], [from, to]) = (self.face.bounds, large.face.bounds);
        self.face.area < SMALLER * large.face.area
            && self.face.group != large.face.group
            && !((to + near).cmplt(low).any() || (from - near).cmpgt(high).any())
            && self.front.dot(large.front) > 0.0
            && self.face.is_parallel_to(&large.face)
            && large.face.height(self.face.point).abs() <= near
    }
}

/// The front of triangles of one plane with the unit normal `normal`; none if they look to both sides.
fn front(mesh: &Mesh, triangles: &[usize], normal: Vec3) -> Option<Vec3> {
    let mut sides = triangles.iter().map(|triangle| {
        let [a, b, c] = mesh.corners(*triangle);
        (b - a).cross(c - a).dot(normal) > 0.0
    });
    let first = sides.next()?;
    sides.all(|side| side == first).then_some(if first { normal } else { -normal })
}

/// Points of a triangle: its middle, and halfway from there to its corners.
fn points(corners: [Vec3; 3]) -> impl Iterator<Item = Vec3> {
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    std::iter::once(middle).chain(corners.map(|corner| 0.5 * (middle + corner)))
}

/// Whether the foot of a point on a triangle's plane lies inside the triangle.
fn lies_over(point: Vec3, [a, b, c]: &[Vec3; 3]) -> bool {
    let (u, v, way) = (*b - *a, *c - *a, point - *a);
    let across = u.cross(v);
    let area = across.length_squared();
    let second = way.cross(v).dot(across);
    let third = u.cross(way).dot(across);
    second > INSIDE * area && third > INSIDE * area && second + third < (1.0 - INSIDE) * area
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::{Group, Material, Object, Rgb};

    /// A square of a group of its own: `side` metres about `middle`,that looks up or down.
    fn add(scene: &mut Scene, side: f32, middle: Vec3, is_up: bool) {
        let (x, z) = (0.5 * side * Vec3::X, 0.5 * side * Vec3::Z);
        let z = if is_up { z } else { -z };
        let corners = [middle - x - z, middle - x + z, middle + x + z, middle + x - z];
        let mesh = Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]]);
        let group = scene.groups.len();
        let name = format!("square {group}");
        scene.groups.push(Group {
            name: name.clone(),
            material: Material::diffuse(Rgb::splat(0.5)),
            emission: Rgb::ZERO,
        });
        scene.objects.push(Object { name, group, mesh });
    }

    /// A floor of four metres.
    fn floor() -> Scene {
        let mut scene = Scene::default();
        add(&mut scene, 4.0, Vec3::ZERO, true);
        scene
    }

    /// How far the objects moved up, in the distances at which rays start off the floor.
    fn lifts(scene: &Scene) -> Vec<f32> {
        let (moved, _) = in_front(scene, &FlatFaces::new(scene));
        let unit = crate::accel::clearance(scene.objects[0].mesh.corners(0));
        let pairs = moved.objects.iter().zip(&scene.objects);
        pairs.map(|(a, b)| (a.mesh.positions[0] - b.mesh.positions[0]).y / unit).collect()
    }

    fn found(scene: &Scene) -> Vec<InFront> {
        in_front(scene, &FlatFaces::new(scene)).1
    }

    #[test]
    fn the_smaller_of_two_squares_lies_in_front_whatever_the_order() {
        let mut scene = floor();
        add(&mut scene, 1.0, Vec3::new(0.3, 0.0, 0.2), true);
        assert_eq!(lifts(&scene), [0.0, APART]);
        assert_eq!(found(&scene), [InFront { object: 1, of: 0 }]);
        scene.objects.swap(0, 1);
        assert_eq!(found(&scene), [InFront { object: 0, of: 1 }]);
        assert!(matches!(in_front(&floor(), &FlatFaces::new(&floor())).0, Cow::Borrowed(_)));
    }

    #[test]
    fn a_stack_lies_in_the_order_of_size_and_what_lies_beside_it_stays() {
        let mut scene = floor();
        add(&mut scene, 0.5, Vec3::ZERO, true);
        add(&mut scene, 2.0, Vec3::ZERO, true);
        add(&mut scene, 1.0, Vec3::ZERO, true);
        add(&mut scene, 1.0, 5.0 * Vec3::X, true);
        // Half as large, a square needs half as much.
        let steps = [0.0, 1.0 + 0.5 + 0.25, 1.0, 1.0 + 0.5, 0.0];
        assert_eq!(lifts(&scene), steps.map(|step| step * APART));
    }

    #[test]
    fn what_looks_away_lies_elsewhere_or_is_as_large_stays() {
        for (side, height, is_up) in [(1.0, 0.0, false), (1.0, 0.01, true), (4.0, 0.0, true)] {
            let mut scene = floor();
            add(&mut scene, side, height * Vec3::Y, is_up);
            assert_eq!(lifts(&scene), [0.0, 0.0], "{side} {height} {is_up}");
        }
        // Of one group nothing is random that one could see.
        let mut scene = floor();
        add(&mut scene, 1.0, Vec3::ZERO, true);
        scene.objects[1].group = 0;
        assert_eq!(lifts(&scene), [0.0, 0.0]);
        // Neighbours touch.
        let mut scene = floor();
        add(&mut scene, 1.0, 2.5 * Vec3::X, true);
        assert_eq!(lifts(&scene), [0.0, 0.0]);
    }
}
