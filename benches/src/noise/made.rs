//! Four scenes that are hard for a path tracer that starts at the camera. Each is the smallest of its kind, with
//! nothing but the difficulty.

use super::stage::{Room, Side, Stage, at, panel};
use crate::corpus::generate::shapes::{cuboid, placed, vase};
use glam::{Vec2, Vec3};
use unrender::scene::{
    Environment, EnvironmentError, LightKind, Material, Mesh, Rgb, RgbImage, Scene,
};

/// Width and height of the pictures, pixels: the smallest in which every group has some hundred pixels.
pub(super) const SIZE: (usize, usize) = (160, 120);

/// A function that makes a scene.
pub(super) type Make = fn() -> Result<Scene, EnvironmentError>;

/// All scenes, by name.
pub(super) const ALL: [(&str, Make); 4] = [
    ("facing_mirrors", facing_mirrors),
    ("ball_and_vase", ball_and_vase),
    ("sharp_floor", sharp_floor),
    ("sun_on_mirror", sun_on_mirror),
];

/// A room of 3 x 3 x 2.5 m.
const ROOM: Room = Room { low: Vec3::new(-1.5, 0.0, -1.5), high: Vec3::new(1.5, 2.5, 1.5) };
/// The distance of a panel from its wall, metres: more than the offset of rays from surfaces, less
/// than is visible.
const BEFORE_WALL: f32 = 0.01;

/// A bulb between two mirrors: light reaches every wall from the bulb and from a row of its images, which rays
/// from a wall hit only by chance.
fn facing_mirrors() -> Result<Scene, EnvironmentError> {
    let mut stage = Stage::default();
    shell(&mut stage, ROOM.sides(&[Side::Left, Side::Right, Side::Back, Side::Front]));
    let (along, up) = (0.75 * Vec3::Z, 0.5 * Vec3::Y);
    let aside = (1.5 - BEFORE_WALL) * Vec3::X + 1.3 * Vec3::Y;
    let mirror = Material::mirror(Rgb::splat(0.9));
    stage.add("left_mirror", mirror.clone(), panel(aside * Vec3::new(-1.0, 1.0, 1.0), -along, up));
    stage.add("right_mirror", mirror, panel(aside, along, up));
    let block = placed(&cuboid(Vec3::new(0.5, 0.6, 0.5), 0.0), at(Vec3::new(-0.4, 0.0, -0.7), 0.4));
    stage.add("box", diffuse(0.3, 0.45, 0.6), block);
    // A ball of 2 cm that emits 100 W: the mean radiance of a room of 48 m2 that reflects 0.6 is then about one.
    let bulb = Mesh::sphere(Vec3::new(0.3, 2.0, -0.2), 0.01);
    stage.lamp("bulb", Rgb::new(27_000.0, 25_000.0, 22_000.0), bulb);
    Ok(stage.seen(Vec3::new(0.9, 1.6, 1.4), Vec3::new(-0.3, 1.0, -1.0), 1.3))
}

/// A ball and a vase that mirror a point light and a dim sky onto the table: curved mirrors have no images to
/// sample, and no ray can hit a point.
fn ball_and_vase() -> Result<Scene, EnvironmentError> {
    let mut stage = Stage::default();
    let table = panel(Vec3::ZERO, 0.8 * Vec3::Z, 0.8 * Vec3::X);
    stage.add("table", diffuse(0.55, 0.42, 0.3), table);
    let ball = Mesh::sphere(Vec3::new(-0.22, 0.16, 0.0), 0.16);
    stage.add("ball", Material::mirror(Rgb::splat(0.9)), ball);
    let glazed = Material { rho_s: Rgb::splat(0.3), ..diffuse(0.15, 0.25, 0.4) };
    let turned = vase(0.13, 0.38, [0.35, 0.3], 96);
    stage.add("vase", glazed, placed(&turned, at(Vec3::new(0.22, 0.0, -0.05), 0.0)));
    let position = Vec3::new(0.35, 1.2, 0.6);
    stage.light("bulb", LightKind::Point { position, intensity: Rgb::splat(10.0) });
    // A sky that is four times as bright on one side, like a window.
    let sky = |x: usize, _| Rgb::splat(if x < 2 { 0.4 } else { 0.1 });
    stage.scene.environment = Some(Environment::new(RgbImage::from_fn(8, 4, sky), 0.0)?);
    Ok(stage.seen(Vec3::new(0.1, 0.75, 1.2), Vec3::new(0.0, 0.1, 0.0), 0.75))
}

/// A polished floor under a spot light: its lobe is so narrow that rays from walls find the light in it only by
/// chance, but too wide for a mirror.
fn sharp_floor() -> Result<Scene, EnvironmentError> {
    let mut stage = Stage::default();
    let polished = Material::isotropic(Rgb::splat(0.3), Rgb::splat(0.3), 0.02);
    stage.add("floor", polished, ROOM.sides(&[Side::Floor]));
    stage.add("wall", diffuse(0.6, 0.55, 0.5), ROOM.sides(&[Side::Back]));
    let sides = ROOM.sides(&[Side::Left, Side::Right, Side::Front]);
    stage.add("other_walls", diffuse(0.5, 0.55, 0.6), sides);
    let block = placed(&cuboid(Vec3::new(0.5, 0.5, 0.5), 0.0), at(Vec3::new(-0.5, 0.0, -0.6), 0.5));
    stage.add("box", diffuse(0.6, 0.3, 0.2), block);
    let (position, target) = (Vec3::new(0.6, 2.4, 0.8), Vec3::new(0.1, 0.0, -0.5));
    stage.light(
        "spot",
        LightKind::Spot {
            position,
            direction: (target - position).normalize(),
            intensity: Rgb::splat(60.0),
            inner_rad: 0.3,
            outer_rad: 0.6,
        },
    );
    Ok(stage.seen(Vec3::new(0.9, 1.5, 1.4), Vec3::new(-0.2, 0.5, -0.8), 1.2))
}

/// Sun through a window, onto the floor and onto a mirror there, which reflects it to a wall: no ray from the wall
/// can hit the sun, and no light sample finds it in the mirror.
fn sun_on_mirror() -> Result<Scene, EnvironmentError> {
    let mut stage = Stage::default();
    // The wall opens from z = -0.6 to 0.4 and from y = 0.9 to 2.
    let opened = ROOM.opened(Side::Right, Vec2::new(0.3, 0.36), Vec2::new(0.633, 0.8));
    let others = ROOM.sides(&[Side::Left, Side::Back, Side::Front]);
    shell(&mut stage, others);
    stage.add("window_wall", diffuse(0.6, 0.6, 0.6), opened);
    let mirror = panel(Vec3::new(-0.2, BEFORE_WALL, -0.35), 0.3 * Vec3::Z, 0.3 * Vec3::X);
    stage.add("mirror", Material::mirror(Rgb::splat(0.9)), mirror);
    let direction = Vec3::new(-0.7, -0.6, -0.1).normalize();
    stage.light("sun", LightKind::Directional { direction, irradiance: Rgb::splat(60.0) });
    let sky = RgbImage::new(1, 1, vec![Rgb::new(0.6, 0.8, 1.0)]);
    stage.scene.environment = Some(Environment::new(sky, 0.0)?);
    Ok(stage.seen(Vec3::new(1.2, 1.7, 1.4), Vec3::new(-0.5, 0.7, -0.7), 1.2))
}

/// Floor, ceiling and `walls`, all diffuse.
fn shell(stage: &mut Stage, walls: Mesh) {
    stage.add("floor", diffuse(0.5, 0.45, 0.4), ROOM.sides(&[Side::Floor]));
    stage.add("ceiling", diffuse(0.75, 0.75, 0.75), ROOM.sides(&[Side::Ceiling]));
    stage.add("walls", diffuse(0.6, 0.58, 0.55), walls);
}

fn diffuse(red: f32, green: f32, blue: f32) -> Material {
    Material::diffuse(Rgb::new(red, green, blue))
}

#[cfg(test)]
mod tests {
    use super::*;
    use unrender::render::{Settings, Tracer};

    #[test]
    fn scenes_are_sound_seen_and_of_about_one() {
        for (name, make) in ALL {
            let mut scene = make().unwrap();
            assert_eq!(scene.validate().unwrap().0, Vec::<String>::new(), "{name}");
            let tracer = Tracer::new(&scene);
            let (width, height) = SIZE;
            let seen = tracer.geometry(&scene.cameras[0], width, height);
            for (index, group) in scene.groups.iter().enumerate() {
                let pixels = seen.pixels().iter().filter(|p| p.group as usize == index).count();
                assert!(pixels >= 100 || group.is_emitter(), "{name}: {pixels} of {}", group.name);
            }
            let settings = Settings { spp: 4, ..Settings::default() };
            let materials = scene.materials();
            let film = tracer.render(&materials, &scene.cameras[0], SIZE, &settings, &|_| {});
            let sum: Rgb = film.mean.pixels().iter().sum();
            let mean = sum.element_sum() / (3 * width * height) as f32;
            assert!((0.2..5.0).contains(&mean), "{name}: {mean}");
        }
    }
}
