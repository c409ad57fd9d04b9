//! Which surfaces a camera sees from behind: there Mitsuba's BSDFs are black unless they are in a `twosided`.

use glam::Vec3;
use unrender_scene::{Camera, Mesh, Scene};

/// Triangles of a group that are tested, spread over all that have their back to the camera. 16 find the inside of a
/// tube, 64 find a corner that is a fiftieth of them.
const LOOKS: usize = 64;
/// Intersection tests of lines of sight in all: a quarter of a second. In scenes of many millions of triangles
/// fewer places are tested.
const ASKED: usize = 1 << 26;
/// Nothing stops a line of sight within this share of its length from the end.
const NEAR_END: f32 = 1e-4;
/// The height of the picture in which places must lie, pixels.
const HEIGHT: f32 = 1000.0;

/// The groups of which `one_sided` is true, each with the name of the first camera that sees some of it from behind.
pub(super) fn seen<'s>(scene: &'s Scene, one_sided: &[bool]) -> Vec<(usize, &'s str)> {
    let groups: Vec<usize> = (0..one_sided.len()).filter(|group| one_sided[*group]).collect();
    let triangles: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
    let questions = triangles.max(1).saturating_mul(groups.len() * scene.cameras.len()).max(1);
    let looks = (ASKED / questions).min(LOOKS);
    let by = |group: usize| {
        let sees = |camera: &&Camera| sees_back(scene, group, camera, looks);
        scene.cameras.iter().find(sees).map(|camera| (group, camera.name.as_str()))
    };
    groups.into_iter().filter_map(by).collect()
}

fn sees_back(scene: &Scene, group: usize, camera: &Camera, looks: usize) -> bool {
    let eye = camera.origin();
    let size = [HEIGHT * camera.aspect.unwrap_or(1.0), HEIGHT].map(|side| side.round() as usize);
    let is_in_picture = |point: Vec3| camera.project(point, size[0], size[1]).is_some();
    let objects = || scene.objects.iter().filter(|object| object.group == group);
    // Each with its mesh, which is most often in the way itself.
    let backs: Vec<(&Mesh, Vec3)> = objects()
        .flat_map(|object| (0..object.mesh.triangles.len()).map(move |index| (&object.mesh, index)))
        .filter_map(|(mesh, index)| {
            let [a, b, c] = mesh.corners(index);
            let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a));
            // Edge-on is neither.
            let towards = normal.dot(eye - middle);
            let is_back = towards < -NEAR_END * normal.length() * eye.distance(middle);
            (is_back && is_in_picture(middle)).then_some((mesh, middle))
        })
        .collect();
    let step = backs.len().div_ceil(looks.max(1)).max(1);
    let is_free = |(own, middle): &(&Mesh, Vec3)| {
        !stops(own, eye, *middle)
            && !scene.objects.iter().any(|object| stops(&object.mesh, eye, *middle))
    };
    looks > 0 && backs.iter().step_by(step).any(is_free)
}

/// Whether `mesh` is in the way from `eye` to `end`.
fn stops(mesh: &Mesh, eye: Vec3, end: Vec3) -> bool {
    let way = end - eye;
    (0..mesh.triangles.len()).any(|index| {
        let [a, b, c] = mesh.corners(index);
        let [ab, ac] = [b - a, c - a];
        let across = way.cross(ac);
        let volume = ab.dot(across);
        if volume == 0.0 {
            return false;
        }
        let from = eye - a;
        let u = from.dot(across) / volume;
        let aside = from.cross(ab);
        let v = way.dot(aside) / volume;
        let at = ac.dot(aside) / volume;
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at > 0.0 && at < 1.0 - NEAR_END
    })
}
