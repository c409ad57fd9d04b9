//! Light transport has no scale: a scene of another size, with its point lights brighter by the square of that, is
//! the same picture. At powers of two no number rounds otherwise, so it is the same to the last bit, and no length
//! in the renderer is an absolute one.

use crate::common::{Stage, camera, settings};
use glam::Vec3;
use unrender_render::{Film, Integrator, Settings};
use unrender_scene::{LightKind, Material, Rgb};

const SIDE: usize = 40;

/// A room of `size` metres with everything that has a length: a lamp with an area, a point light, a mirror with images
/// of both, a curved and a glossy thing.
fn room(size: f32) -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::new(0.7, 0.5, 0.3)), Rgb::ZERO);
    stage.room(wall, Vec3::splat(size));
    let ball = stage.group(Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.5), 0.2), Rgb::ZERO);
    stage.sphere(ball, size * Vec3::new(0.2, -0.5, 0.0), 0.4 * size, 12);
    let mirror = stage.group(Material::mirror(Rgb::splat(0.9)), Rgb::ZERO);
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| size * axis);
    stage.plate(mirror, -0.95 * z, 0.5 * x, 0.5 * y);
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(5.0));
    stage.plate(lamp, 0.98 * y, 0.3 * z, 0.3 * x);
    let intensity = size * size * Rgb::splat(0.5);
    stage.light(LightKind::Point { position: 0.7 * x - 0.2 * y, intensity });
    stage
}

fn picture(size: f32, integrator: Integrator) -> Film {
    let view = camera(size * Vec3::new(0.0, 0.0, 0.95), Vec3::ZERO, 1.2);
    room(size).render(&view, SIDE, Settings { integrator, ..settings(8) })
}

/// Exponents of two: rooms of two kilometres, two metres, two millimetres and 60 micrometres.
const SIZES: [i32; 4] = [10, 0, -10, -15];

#[test]
fn a_room_of_any_size_is_the_same_picture() {
    for integrator in [Integrator::Path, Integrator::PathReuse] {
        let [of_kilometres, of_metres, of_millimetres, of_micrometres] =
            SIZES.map(|exponent| picture(2f32.powi(exponent), integrator));
        assert!(of_metres.mean.pixels().iter().all(|p| p.min_element() > 0.0));
        assert!(of_metres == of_kilometres, "{integrator:?}: kilometres");
        assert!(of_metres == of_millimetres, "{integrator:?}: millimetres");
        assert!(of_metres == of_micrometres, "{integrator:?}: micrometres");
    }
}
