//! Near clipping planes of cameras: which of them cut something away, and what is written for those that do not.

use glam::Vec3;
use unrender_scene::{Camera, Scene, Warnings};

/// The near clipping plane of a camera that cuts nothing away, for formats that require one, as a share of the scene's
/// diagonal: half a millimetre for a room of 5 m. Half and double cut as little.
const UNSEEN: f32 = 1e-4;
/// The aspect (width over height) of pictures of cameras without one: wider than most.
const WIDEST: f32 = 2.0;

/// Sets the near clipping planes of the scene's cameras that cut nothing away to zero, and those that would cut all of it
/// away, as defaults of other programs do in small scenes.
pub(crate) fn settle(scene: &mut Scene, warnings: &mut Warnings) {
    let mut cameras = std::mem::take(&mut scene.cameras);
    for camera in cameras.iter_mut().filter(|camera| camera.near > 0.0) {
        let points = || scene.objects.iter().flat_map(|object| &object.mesh.positions);
        if !cuts(scene, camera) {
            camera.near = 0.0;
        } else if points().all(|point| depth(camera, *point) <= camera.near) {
            warnings.push(format!(
                "camera \"{}\": all of the scene is nearer than its near clipping plane, {} m, which was not taken",
                camera.name, camera.near
            ));
            camera.near = 0.0;
        }
    }
    scene.cameras = cameras;
}

/// What is written for the near clipping plane of `camera`, metres, above zero.
pub(crate) fn written(scene: &Scene, camera: &Camera) -> f32 {
    let size = scene.bounds().map_or(1.0, |[low, high]| low.distance(high));
    if camera.near > 0.0 { camera.near } else { UNSEEN * size }
}

/// The distance of a point along the camera's axis.
fn depth(camera: &Camera, point: Vec3) -> f32 {
    -(point - camera.origin()).dot(camera.world_from_camera.matrix3.z_axis.into())
}

/// Whether a triangle may come into the pyramid between the camera and its near clipping plane: its bounding box is as near
/// as the corners of that.
fn cuts(scene: &Scene, camera: &Camera) -> bool {
    let (eye, tan) = (camera.origin(), (0.5 * camera.fov_y_rad).tan());
    let aspect = camera.aspect.unwrap_or(WIDEST);
    let reach = camera.near * (1.0 + tan * tan * (1.0 + aspect * aspect)).sqrt();
    scene.objects.iter().any(|object| {
        (0..object.mesh.triangles.len()).any(|index| {
            let [a, b, c] = object.mesh.corners(index);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let is_before = [a, b, c].iter().any(|point| depth(camera, *point) > 0.0);
            is_before && eye.distance(eye.clamp(low, high)) < reach
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender_scene::{Mesh, Object};

    /// A wall a metre before the camera, and one four metres before it, in millimetres if `scale` is a thousandth.
    fn scene(scale: f32, near: f32) -> Scene {
        let wall = |z: f32| {
            let at = |x: f32, y: f32| scale * Vec3::new(x, y, z);
            let corners = [at(-2.0, -2.0), at(2.0, -2.0), at(2.0, 2.0), at(-2.0, 2.0)];
            Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]])
        };
        let object = |z: f32| Object { name: "wall".into(), group: 0, mesh: wall(z) };
        let camera = Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.8);
        let cameras = vec![Camera { near, ..camera }];
        Scene { objects: vec![object(-1.0), object(-4.0)], cameras, ..Scene::default() }
    }

    fn settled(scale: f32, near: f32) -> (f32, usize) {
        let (mut scene, mut warnings) = (scene(scale, near), Warnings::default());
        settle(&mut scene, &mut warnings);
        (scene.cameras[0].near, warnings.0.len())
    }

    #[test]
    fn a_plane_stays_where_it_cuts_some_of_the_scene_away_and_not_all() {
        assert_eq!(settled(1.0, 2.0), (2.0, 0));
        assert_eq!(settled(1.0, 0.01), (0.0, 0), "before all of it");
        assert_eq!(settled(1e-3, 0.1), (0.0, 1), "behind all of it");
        assert_eq!(written(&scene(1.0, 2.0), &scene(1.0, 2.0).cameras[0]), 2.0);
        let small = scene(1e-3, 0.0);
        assert!(written(&small, &small.cameras[0]) < 1e-6);
    }
}
