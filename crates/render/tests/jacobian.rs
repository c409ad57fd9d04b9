//! Proves the derivatives of pictures: against finite differences on the same paths, pixel by
//! pixel; against differences of ordinary renderings; and against closed forms.

mod common;

use common::{Stage, camera, settings};
use glam::{DVec3, Vec3};
use unrender_render::seen::Lookup;
use unrender_render::{Appearance, Jacobian, Parameter, Settings, Tracer};
use unrender_scene::{Camera, LightKind, Material, Rgb, WardModel};

const FLOOR: u32 = 0;
const WALLS: u32 = 1;
const MIRROR: u32 = 2;
const BALL: u32 = 3;
const LAMP: u32 = 4;
const POINT: u32 = 5;

/// A room with a brushed floor, diffuse walls, a mirror, a ball that is half a mirror, a lamp that
/// also reflects, and a point light.
struct Room {
    tracer: Tracer,
    materials: Vec<Material>,
    lights: Vec<Rgb>,
    camera: Camera,
}

const SIDE: usize = 12;

impl Room {
    fn new(model: WardModel) -> Self {
        let mut stage = Stage::default();
        stage.scene.brdf = model;
        let brushed = Material {
            rho_s: Rgb::new(0.3, 0.4, 0.5),
            alpha_x: 0.15,
            alpha_y: 0.35,
            theta_rad: 0.6,
            ..Material::diffuse(Rgb::new(0.4, 0.3, 0.2))
        };
        let floor = stage.group(brushed, Rgb::ZERO);
        stage.plate(floor, Vec3::NEG_Y, Vec3::Z, Vec3::X);
        let walls = stage.group(Material::diffuse(Rgb::new(0.6, 0.5, 0.7)), Rgb::ZERO);
        stage.room(walls, Vec3::new(1.0, 1.1, 1.0));
        let mirror = stage.group(Material::mirror(Rgb::new(0.9, 0.8, 0.7)), Rgb::ZERO);
        stage.plate(mirror, Vec3::new(0.0, 0.0, -0.95), 0.8 * Vec3::X, 0.8 * Vec3::Y);
        let half =
            Material { rho_s: Rgb::new(0.4, 0.3, 0.2), ..Material::diffuse(Rgb::splat(0.4)) };
        let ball = stage.group(half, Rgb::ZERO);
        stage.sphere(ball, Vec3::new(0.4, -0.6, -0.2), 0.35, 12);
        let lamp = stage.group(Material::diffuse(Rgb::splat(0.3)), Rgb::new(5.0, 4.0, 3.0));
        stage.plate(lamp, Vec3::new(-0.2, 0.98, -0.2), 0.3 * Vec3::X, 0.2 * Vec3::Z);
        let position = Vec3::new(-0.6, 0.3, 0.4);
        stage.light(LightKind::Point { position, intensity: Rgb::new(0.3, 0.4, 0.5) });
        Self {
            tracer: stage.tracer(),
            materials: stage.scene.materials(),
            lights: vec![Rgb::ONE; 6],
            camera: camera(Vec3::new(0.1, 0.2, 0.95), Vec3::new(0.0, -0.2, 0.0), 1.4),
        }
    }

    fn appearance(&self) -> Appearance<'_> {
        Appearance { materials: &self.materials, lights: &self.lights }
    }

    fn jacobian(
        &self,
        parameters: &[Parameter],
        settings: &Settings,
        seen: Option<Lookup<'_>>,
    ) -> Jacobian {
        let (size, pixels) = ((SIDE, SIDE), all_pixels());
        let appearance = self.appearance();
        self.tracer.jacobian(appearance, &self.camera, size, &pixels, parameters, settings, seen)
    }

    /// The same scene with a parameter moved by `step`, in all channels.
    fn moved(&self, parameter: Parameter, step: f32) -> (Vec<Material>, Vec<Rgb>) {
        let (mut materials, mut lights) = (self.materials.clone(), self.lights.clone());
        match parameter {
            Parameter::RhoD(group) => materials[group as usize].rho_d += step,
            Parameter::RhoS(group) => materials[group as usize].rho_s += step,
            Parameter::AlphaX(group) => materials[group as usize].alpha_x += step,
            Parameter::AlphaY(group) => materials[group as usize].alpha_y += step,
            Parameter::Theta(group) => materials[group as usize].theta_rad += step,
            Parameter::Light(source) => lights[source as usize] += step,
            Parameter::Seen => {}
        }
        (materials, lights)
    }

    /// The radiance with a parameter moved, by the paths of the appearance as it is.
    fn reweighted(
        &self,
        parameter: Parameter,
        step: f32,
        settings: &Settings,
        seen: Option<Lookup<'_>>,
    ) -> Vec<Rgb> {
        let (materials, lights) = self.moved(parameter, step);
        let moved = Appearance { materials: &materials, lights: &lights };
        let (size, pixels, drawn) = ((SIDE, SIDE), all_pixels(), self.appearance());
        self.tracer.radiance_reweighted(moved, drawn, &self.camera, size, &pixels, settings, seen)
    }
}

fn all_pixels() -> Vec<u32> {
    (0..(SIDE * SIDE) as u32).collect()
}

/// Everything that can be asked of the room, the cache aside.
fn everything() -> Vec<Parameter> {
    let mut all = Vec::new();
    for group in [FLOOR, WALLS, BALL, LAMP] {
        all.push(Parameter::RhoD(group));
    }
    for group in [FLOOR, MIRROR, BALL] {
        all.push(Parameter::RhoS(group));
    }
    all.extend([Parameter::AlphaX(FLOOR), Parameter::AlphaY(FLOOR), Parameter::Theta(FLOOR)]);
    all.extend([Parameter::Light(LAMP), Parameter::Light(POINT)]);
    all
}

/// The derivative by the parameter number `k`, pixel by pixel.
fn column(jacobian: &Jacobian, k: usize) -> Vec<DVec3> {
    let count = jacobian.derivatives.len() / jacobian.radiance.len();
    jacobian.derivatives.iter().skip(k).step_by(count).map(|d| d.as_dvec3()).collect()
}

fn norm(image: &[DVec3]) -> f64 {
    image.iter().map(|p| p.length_squared()).sum::<f64>().sqrt()
}

/// The distance of two pictures as a share of the second.
fn distance(found: &[DVec3], expected: &[DVec3]) -> f64 {
    let difference: Vec<DVec3> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    norm(&difference) / norm(expected)
}

fn central(plus: &[Rgb], minus: &[Rgb], step: f32) -> Vec<DVec3> {
    let one = |(a, b): (&Rgb, &Rgb)| (a.as_dvec3() - b.as_dvec3()) / (2.0 * f64::from(step));
    plus.iter().zip(minus).map(one).collect()
}

#[test]
fn derivatives_are_the_differences_of_the_same_paths() {
    for model in WardModel::ALL {
        let room = Room::new(model);
        let settings = settings(64);
        let all = everything();
        let jacobian = room.jacobian(&all, &settings, None);
        for (k, parameter) in all.into_iter().enumerate() {
            let step = 2e-3;
            let [plus, minus] =
                [step, -step].map(|s| room.reweighted(parameter, s, &settings, None));
            let error = distance(&column(&jacobian, k), &central(&plus, &minus, step));
            eprintln!("{model} {parameter:?}: {error:e}");
            assert!(error < 1e-2, "{model}, {parameter:?}: {error} off");
        }
    }
}

#[test]
fn the_radiance_is_that_of_the_rendering() {
    let room = Room::new(WardModel::WardGmd);
    let settings = settings(16);
    let (size, pixels) = ((SIDE, SIDE), all_pixels());
    let rendered =
        room.tracer.render_pixels(room.appearance(), &room.camera, size, &pixels, &settings);
    let jacobian = room.jacobian(&everything(), &settings, None);
    for (found, (expected, _)) in jacobian.radiance.into_iter().zip(rendered) {
        assert!((found - expected).abs().max_element() <= 1e-5 * expected.max_element());
    }
}
