//! A photographed sphere as a scene: a mesh with smooth normals, one distant light, and an
//! orthographic camera.
//!
//! World frame: x to the right in the photograph, y upwards, z towards the camera. The sphere has
//! radius one and its centre at the origin.

use crate::Failure;
use crate::scenes::blown_up_cube;
use glam::Vec3;
use std::path::Path;
use unrender::formats::{atomic, gltf};
use unrender::scene::{Camera, Group, Light, LightKind, Material, Mesh, Object, Rgb, Scene};

/// The name of the only group.
pub(crate) const GROUP: &str = "ball";

/// The camera's distance in radii of the sphere. A pinhole this far away approximates an
/// orthographic camera: viewing directions differ by at most 1/200 rad = 0.3 degrees, well below
/// the width of the sharpest lobe found on these spheres (0.03, 1.7 degrees). At half the distance,
/// 0.6 degrees, still below it; at double, 0.15 degrees, and single precision of positions (one part
/// in 2^24 of the distance) is still 10^-5 radii.
const DISTANCE: f32 = 200.0;

/// Quadrilaterals along an edge of the cube that becomes the sphere: 49 152 triangles. The
/// silhouette is 2 10^-5 radii too small, 10^-3 pixels. At half it is four times that; double takes
/// four times the memory for no visible difference.
const CELLS: i32 = 64;

/// A sphere's image: a circle, in pixels from the photograph's top left corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Circle {
    pub(crate) x: f32,
    pub(crate) y: f32,
    pub(crate) radius: f32,
}

/// Light from infinitely far away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    /// Unit vector from the sphere to the light.
    pub(crate) towards: Vec3,
    /// Irradiance on a surface that faces it.
    pub(crate) irradiance: Rgb,
}

impl Circle {
    /// The unit normal of the sphere at this point of the photograph; none outside the circle.
    pub(crate) fn normal(&self, x: f32, y: f32) -> Option<Vec3> {
        let (x, y) = ((x - self.x) / self.radius, (self.y - y) / self.radius);
        let z2 = 1.0 - x * x - y * y;
        (z2 > 0.0).then(|| Vec3::new(x, y, z2.sqrt()))
    }

    /// The same circle in a crop of the photograph from pixel (`left`, `top`) on.
    pub(crate) fn within(self, left: usize, top: usize) -> Self {
        Self { x: self.x - left as f32, y: self.y - top as f32, ..self }
    }

    /// The scene whose picture of `side` x `side` pixels shows the sphere in this circle, under one `lamp`.
    pub(crate) fn scene(&self, side: usize, lamp: Lamp) -> Scene {
        self.scene_under(side, &[("lamp".to_owned(), lamp)])
    }

    /// The same under several lamps, by their names.
    pub(crate) fn scene_under(&self, side: usize, lamps: &[(String, Lamp)]) -> Scene {
        let mut scene = Scene::default();
        let material = Material::diffuse(Rgb::splat(0.5));
        scene.groups.push(Group { name: GROUP.to_owned(), material, emission: Rgb::ZERO });
        scene.objects.push(Object { name: GROUP.to_owned(), group: 0, mesh: unit_sphere(CELLS) });
        for (name, Lamp { towards, irradiance }) in lamps {
            let kind = LightKind::Directional { direction: -*towards, irradiance: *irradiance };
            scene.lights.push(Light { name: name.clone(), kind });
        }
        let middle = 0.5 * side as f32;
        let (right, up) = ((middle - self.x) / self.radius, (self.y - middle) / self.radius);
        let eye = Vec3::new(right, up, DISTANCE);
        let fov = 2.0 * (middle / self.radius / DISTANCE).atan();
        scene.cameras.push(Camera::look_at("camera", eye, Vec3::new(right, up, 0.0), Vec3::Y, fov));
        scene
    }

    /// Writes that scene to `path`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn write(&self, side: usize, lamp: Lamp, path: &Path) -> Result<(), Failure> {
        Ok(atomic::write(path, &gltf::to_glb(&self.scene(side, lamp))?)?)
    }
}

/// The unit sphere of `cells` x `cells` x 12 triangles, with exact normals.
fn unit_sphere(cells: i32) -> Mesh {
    let mut mesh = blown_up_cube(cells, |direction| direction);
    mesh.normals.clone_from(&mesh.positions);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sphere_appears_in_its_circle() {
        let circle = Circle { x: 80.37, y: 78.25, radius: 70.75 };
        let lamp = Lamp { towards: Vec3::Z, irradiance: Rgb::ONE };
        let scene = circle.scene(160, lamp);
        let (x, y) = scene.cameras[0].project(Vec3::ZERO, 160, 160).unwrap();
        assert!((x - circle.x).abs() < 0.01 && (y - circle.y).abs() < 0.01, "{x} {y}");
        let (x, y) = scene.cameras[0].project(Vec3::Y, 160, 160).unwrap();
        assert!((x - circle.x).abs() < 0.01, "{x}");
        assert!((y - (circle.y - circle.radius)).abs() < 0.01, "{y}");
    }

    #[test]
    fn normals_point_to_the_right_and_upwards_as_the_photograph_does() {
        let circle = Circle { x: 50.0, y: 50.0, radius: 40.0 };
        let normal = circle.normal(73.9, 18.1).unwrap();
        assert!((normal - Vec3::new(0.6, 0.8, 0.0)).length() < 0.1, "{normal}");
        assert!(circle.normal(91.0, 50.0).is_none());
    }
}
