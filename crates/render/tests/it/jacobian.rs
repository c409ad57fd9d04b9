//! Proves that the derivatives of pictures are those of their own estimates: against differences on
//! the same paths, pixel by pixel. That the estimates themselves are right is proved in
//! `jacobian_independent.rs`.

use crate::common::{Stage, camera, plate_corners, quad_mesh, settings};
use glam::{DVec3, Vec2, Vec3};
use std::sync::Arc;
use unrender_render::radiance_cache::CacheLookup;
use unrender_render::{Appearance, Jacobian, Parameter, Query, RadianceCache, Settings, Tracer};
use unrender_scene::{
    BrdfModel, Camera, Image, LightKind, Material, Rgb, Texture, WardModel, Wrap,
};

const FLOOR: u32 = 0;
const WALLS: u32 = 1;
const MIRROR: u32 = 2;
const BALL: u32 = 3;
const LAMP: u32 = 4;
const PICTURE: u32 = 5;
const POINT: u32 = 6;

/// A room with a brushed floor, diffuse walls, a mirror, a ball that is half a mirror, a lamp that
/// also reflects, a textured plate and a point light. Some reflectances are zero in some channel.
struct Room {
    tracer: Tracer,
    materials: Vec<Material>,
    lights: Vec<Rgb>,
    camera: Camera,
}

const SIDE: usize = 12;
const SIZE: (usize, usize) = (SIDE, SIDE);

impl Room {
    fn new(model: impl Into<BrdfModel>) -> Self {
        let mut stage = Stage::default();
        stage.scene.brdf = model.into();
        let brushed = Material {
            rho_s: Rgb::new(0.0, 0.4, 0.5),
            alpha_x: 0.15,
            alpha_y: 0.35,
            theta_rad: 0.6,
            ..Material::diffuse(Rgb::new(0.4, 0.3, 0.0))
        };
        let floor = stage.group(brushed, Rgb::ZERO);
        stage.plate(floor, Vec3::NEG_Y, Vec3::Z, Vec3::X);
        let walls = stage.group(Material::diffuse(Rgb::new(0.6, 0.5, 0.7)), Rgb::ZERO);
        stage.room(walls, Vec3::new(1.0, 1.1, 1.0));
        let mirror = stage.group(Material::mirror(Rgb::new(0.9, 0.8, 0.0)), Rgb::ZERO);
        stage.plate(mirror, Vec3::new(0.0, 0.0, -0.95), 0.8 * Vec3::X, 0.8 * Vec3::Y);
        let half = Material {
            rho_s: Rgb::new(0.4, 0.0, 0.2),
            ..Material::diffuse(Rgb::new(0.0, 0.4, 0.5))
        };
        let ball = stage.group(half, Rgb::ZERO);
        stage.sphere(ball, Vec3::new(0.4, -0.6, -0.2), 0.35, 12);
        let lamp = stage.group(Material::diffuse(Rgb::splat(0.3)), Rgb::new(5.0, 4.0, 3.0));
        stage.plate(lamp, Vec3::new(-0.2, 0.98, -0.2), 0.3 * Vec3::X, 0.2 * Vec3::Z);
        let picture = stage.group(painted(), Rgb::ZERO);
        let corners = plate_corners(0.99 * Vec3::X, -0.6 * Vec3::Z, 0.5 * Vec3::Y);
        let uvs = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| Vec2::new(u, v));
        // Faces into the room: corners the other way round.
        stage.mesh(picture, quad_mesh([corners[1], corners[0], corners[3], corners[2]], &uvs));
        let position = Vec3::new(-0.6, 0.3, 0.4);
        stage.light(LightKind::Point { position, intensity: Rgb::new(0.3, 0.4, 0.5) });
        let mut lights = vec![Rgb::ONE; 7];
        lights[LAMP as usize] = Rgb::new(0.7, 1.2, 1.0);
        lights[POINT as usize] = Rgb::new(1.5, 0.0, 0.8);
        Self {
            tracer: stage.tracer(),
            materials: stage.scene.materials(),
            lights,
            camera: camera(Vec3::new(0.1, 0.2, 0.95), Vec3::new(0.0, 0.0, 0.0), 1.8),
        }
    }

    fn appearance(&self) -> Appearance<'_> {
        Appearance { materials: &self.materials, lights: &self.lights }
    }

    fn jacobian(
        &self,
        parameters: &[Parameter],
        settings: &Settings,
        seen: Option<CacheLookup<'_>>,
    ) -> Jacobian {
        let (appearance, pixels) = (self.appearance(), all_pixels());
        self.tracer.jacobian(
            &self.camera,
            SIZE,
            &Query { parameters, seen, ..Query::new(appearance, &pixels, settings) },
        )
    }

    /// The same scene with a parameter moved by `step`, in all channels.
    fn moved(&self, parameter: Parameter, step: f32) -> (Vec<Material>, Vec<Rgb>) {
        let (mut materials, mut lights) = (self.materials.clone(), self.lights.clone());
        match parameter {
            Parameter::RhoD(PICTURE) => {
                let texture = materials[PICTURE as usize].texture.as_mut().map(Arc::make_mut);
                texture.unwrap().image.pixels_mut().iter_mut().for_each(|p| *p *= 1.0 + step);
            }
            Parameter::RhoD(group) => materials[group as usize].rho_d += step,
            Parameter::RhoS(group) => materials[group as usize].rho_s += step,
            Parameter::AlphaX(group) => materials[group as usize].alpha_x += step,
            Parameter::AlphaY(group) => materials[group as usize].alpha_y += step,
            Parameter::Theta(group) => materials[group as usize].theta_rad += step,
            Parameter::Light(source) => lights[source as usize] += step,
            Parameter::Cache => {}
        }
        (materials, lights)
    }

    /// The radiance with a parameter moved, by the paths of the appearance as it is.
    fn reweighted(
        &self,
        (parameter, step): (Parameter, f32),
        settings: &Settings,
        seen: Option<&RadianceCache>,
    ) -> Vec<Rgb> {
        let geometry = self.tracer.geometry(&self.camera, SIDE, SIDE);
        let mut seen = seen.cloned();
        if let (Some(seen), Parameter::Cache) = (&mut seen, parameter) {
            seen.radiance.pixels_mut().iter_mut().for_each(|p| *p *= 1.0 + step);
        }
        let lookup = seen.as_ref().map(|seen| CacheLookup {
            cache: seen,
            camera: &self.camera,
            geometry: &geometry,
        });
        let (materials, lights) = self.moved(parameter, step);
        let moved = Appearance { materials: &materials, lights: &lights };
        let (drawn, camera, pixels) = (self.appearance(), &self.camera, all_pixels());
        self.tracer.radiance_reweighted(
            camera,
            SIZE,
            drawn,
            &Query { seen: lookup, ..Query::new(moved, &pixels, settings) },
        )
    }

    /// The radiance cache of a photograph of the room, valid on the walls.
    fn photograph(&self) -> RadianceCache {
        let film =
            self.tracer.render(self.appearance(), &self.camera, SIZE, &settings(64), &|_| ());
        let geometry = self.tracer.geometry(&self.camera, SIDE, SIDE);
        let known = Image::from_fn(SIDE, SIDE, |x, y| geometry.at(x, y).group == WALLS);
        RadianceCache { radiance: film.mean, valid: known }
    }
}

/// A material with a texture whose texels differ.
fn painted() -> Material {
    let texel = |x: usize, y: usize| Rgb::new(0.2 + 0.3 * x as f32, 0.1 + 0.2 * y as f32, 0.5);
    let image = Image::from_fn(3, 3, texel);
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    Material { texture: Some(Arc::new(texture)), ..Material::diffuse(Rgb::splat(0.4)) }
}

fn all_pixels() -> Vec<u32> {
    (0..(SIDE * SIDE) as u32).collect()
}

/// All parameters of the room except the cache.
fn everything() -> Vec<Parameter> {
    let mut all: Vec<_> = [FLOOR, WALLS, BALL, LAMP, PICTURE].map(Parameter::RhoD).into();
    all.extend([FLOOR, MIRROR, BALL].map(Parameter::RhoS));
    all.extend([Parameter::AlphaX(FLOOR), Parameter::AlphaY(FLOOR), Parameter::Theta(FLOOR)]);
    all.extend([LAMP, POINT].map(Parameter::Light));
    all
}

/// The derivative by the parameter number `k`, pixel by pixel.
fn column(jacobian: &Jacobian, k: usize) -> Vec<DVec3> {
    let count = jacobian.derivatives.len() / jacobian.radiance.len();
    jacobian.derivatives.iter().skip(k).step_by(count).map(|d| d.as_dvec3()).collect()
}

/// The root of the mean square, channel by channel.
fn rms(image: &[DVec3]) -> DVec3 {
    (image.iter().map(|p| p * p).sum::<DVec3>() / image.len() as f64).map(f64::sqrt)
}

/// The largest distance of two pictures over pixels and channels, as a share of the channel's root
/// mean square in the second; a channel that is zero throughout has to be so in both.
fn distance(found: &[DVec3], expected: &[DVec3]) -> f64 {
    let scale = rms(expected).max(DVec3::splat(1e-12));
    let one = |(a, b): (&DVec3, &DVec3)| ((a - b) / scale).abs().max_element();
    found.iter().zip(expected).map(one).fold(0.0, f64::max)
}

/// Central differences.
fn differences(plus: &[Rgb], minus: &[Rgb], step: f32) -> Vec<DVec3> {
    let one = |(a, b): (&Rgb, &Rgb)| (a.as_dvec3() - b.as_dvec3()) / (2.0 * f64::from(step));
    plus.iter().zip(minus).map(one).collect()
}

/// The limit of differences, from those of one step and of two, without the third derivative
/// [Richardson 1911].
fn extrapolated(near: &[DVec3], far: &[DVec3]) -> Vec<DVec3> {
    near.iter().zip(far).map(|(near, far)| near + (near - far) / 3.0).collect()
}

/// Small enough for the fifth derivative, large enough for the rounding of radiance.
fn step(parameter: Parameter) -> f32 {
    match parameter {
        Parameter::AlphaX(_) | Parameter::AlphaY(_) | Parameter::Theta(_) => 6e-3,
        _ => 1e-2,
    }
}

/// Measured: 2.0e-3 at the worst pixel and channel, by rho_d of the lamp (the rounding of its
/// radiance); most are below 1e-3.
const ERROR_MAX: f64 = 4e-3;

/// Asserts that all derivatives are the differences on the same paths.
fn assert_exact(room: &Room, parameters: &[Parameter], seen: Option<&RadianceCache>) {
    // As the paths are the same, their number is of no consequence.
    let settings = settings(16);
    let geometry = room.tracer.geometry(&room.camera, SIDE, SIDE);
    let lookup =
        seen.map(|seen| CacheLookup { cache: seen, camera: &room.camera, geometry: &geometry });
    let jacobian = room.jacobian(parameters, &settings, lookup);
    for (k, &parameter) in parameters.iter().enumerate() {
        let step = step(parameter);
        let differences = |step: f32| {
            let [plus, minus] =
                [step, -step].map(|step| room.reweighted((parameter, step), &settings, seen));
            differences(&plus, &minus, step)
        };
        let found = column(&jacobian, k);
        let error = distance(&found, &extrapolated(&differences(step), &differences(2.0 * step)));
        assert!(error < ERROR_MAX, "{parameter:?}: {error} off");
        assert!(rms(&found).max_element() > 1e-2, "{parameter:?} has no effect");
    }
}

#[test]
fn derivatives_are_the_differences_of_the_same_paths() {
    for model in BrdfModel::ALL {
        assert_exact(&Room::new(model), &everything(), None);
    }
}

#[test]
fn they_are_so_too_where_paths_end_at_the_photograph() {
    let room = Room::new(WardModel::WardGmd);
    let mut all = everything();
    all.push(Parameter::Cache);
    assert_exact(&room, &all, Some(&room.photograph()));
}

#[test]
fn what_the_camera_looks_at_is_not_taken_from_the_photograph() {
    let room = Room::new(WardModel::WardGmd);
    let photograph = room.photograph();
    let geometry = room.tracer.geometry(&room.camera, SIDE, SIDE);
    let lookup = CacheLookup { cache: &photograph, camera: &room.camera, geometry: &geometry };
    for (max_bounces, same) in [(1, true), (2, false)] {
        let settings = Settings { max_bounces, ..settings(4) };
        let [with, without] =
            [Some(lookup), None].map(|seen| room.jacobian(&everything(), &settings, seen));
        assert_eq!(with == without, same, "{max_bounces} bounces");
    }
}

#[test]
fn the_radiance_is_that_of_the_rendering() {
    let room = Room::new(WardModel::WardGmd);
    for max_bounces in [0, 1, 2, 500] {
        let settings = Settings { max_bounces, ..settings(16) };
        let (pixels, camera) = (all_pixels(), &room.camera);
        let rendered =
            room.tracer.render_pixels(room.appearance(), camera, SIZE, &pixels, &settings);
        for parameters in [everything(), Vec::new()] {
            let jacobian = room.jacobian(&parameters, &settings, None);
            for (found, (expected, _)) in jacobian.radiance.into_iter().zip(&rendered) {
                assert!((found - expected).abs().max_element() <= 1e-5 * expected.max_element());
            }
        }
    }
}

#[test]
fn stored_paths_give_the_same_as_traced_ones() {
    for (model, with_photograph) in [(BrdfModel::Ggx, false), (WardModel::WardGmd.into(), true)] {
        let room = Room::new(model);
        let photograph = room.photograph();
        let geometry = room.tracer.geometry(&room.camera, SIDE, SIDE);
        let lookup = CacheLookup { cache: &photograph, camera: &room.camera, geometry: &geometry };
        let seen = Some(lookup).filter(|_| with_photograph);
        let cache = seen.map(|_| &photograph);
        let (mut all, settings, pixels) = (everything(), settings(16), all_pixels());
        all.push(Parameter::Cache);
        let (camera, drawn) = (&room.camera, room.appearance());
        let stored = room.tracer.store(
            camera,
            SIZE,
            &Query { parameters: &all, seen, ..Query::new(drawn, &pixels, &settings) },
        );
        let bytes = stored.bytes() as f64 / (pixels.len() * 16) as f64;
        assert!((40.0..1000.0).contains(&bytes), "{bytes} bytes a path");

        // Under the appearance that they were drawn from, with all derivatives.
        let traced = room.jacobian(&all, &settings, seen);
        let replayed = stored.replay(&room.tracer, drawn, &all, cache);
        for k in 0..all.len() {
            let error = distance(&column(&replayed, k), &column(&traced, k));
            assert!(error < 1e-4, "{:?}: {error} off", all[k]);
        }
        assert_same(&replayed.radiance, &traced.radiance);

        // Under others, each of which moves one parameter far.
        for parameter in everything() {
            let (materials, lights) = room.moved(parameter, 0.15);
            let moved = Appearance { materials: &materials, lights: &lights };
            let tracer = &room.tracer;
            let traced = tracer.radiance_reweighted(
                camera,
                SIZE,
                drawn,
                &Query { seen, ..Query::new(moved, &pixels, &settings) },
            );
            assert_same(&stored.replay(tracer, moved, &[], cache).radiance, &traced);
        }
    }
}

/// Asserts that two radiances are the same but for rounding: at most 2.1e-6 was measured.
fn assert_same(found: &[Rgb], expected: &[Rgb]) {
    assert!(found.iter().all(|radiance| radiance.is_finite()));
    let in_double = |radiance: &[Rgb]| radiance.iter().map(|r| r.as_dvec3()).collect::<Vec<_>>();
    let error = distance(&in_double(found), &in_double(expected));
    assert!(error < 1e-5, "{error} off");
}

#[test]
fn light_is_the_sum_over_its_sources() {
    let room = Room::new(WardModel::WardGmd);
    let photograph = room.photograph();
    let geometry = room.tracer.geometry(&room.camera, SIDE, SIDE);
    let lookup = CacheLookup { cache: &photograph, camera: &room.camera, geometry: &geometry };
    let sources = [Parameter::Light(LAMP), Parameter::Light(POINT), Parameter::Cache];
    for seen in [None, Some(lookup)] {
        let jacobian = room.jacobian(&sources, &settings(16), seen);
        assert_eq!(rms(&column(&jacobian, 2)) != DVec3::ZERO, seen.is_some());
        for (row, radiance) in jacobian.derivatives.chunks(3).zip(&jacobian.radiance) {
            let [lamp, point] = [LAMP, POINT].map(|s| room.lights[s as usize]);
            let sum = row[0] * lamp + row[1] * point + row[2];
            assert!((sum - radiance).abs().max_element() <= 1e-5 * radiance.max_element());
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let room = Room::new(WardModel::Ward1992);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        // Many times the picture, so that there is something to share out.
        let pixels: Vec<u32> = (0..16).flat_map(|_| all_pixels()).collect();
        let (all, settings) = (everything(), settings(2));
        let (materials, camera) = (&room.materials, &room.camera);
        pool.install(|| {
            room.tracer.jacobian(
                camera,
                SIZE,
                &Query { parameters: &all, ..Query::new(materials, &pixels, &settings) },
            )
        })
    };
    let one = with(1);
    for threads in [2, 7] {
        assert!(one == with(threads), "{threads} threads give other derivatives");
    }
}

#[test]
fn what_is_asked_is_what_comes_back() {
    let room = Room::new(WardModel::WardGmd);
    let settings = settings(4);
    let all = everything();
    let whole = room.jacobian(&all, &settings, None);
    // Twice the same, in another order, and what does not exist.
    let nothing = [Parameter::RhoD(99), Parameter::Light(u32::MAX), Parameter::Light(WALLS)];
    let asked = [all[10], nothing[0], all[0], all[10], nothing[1], nothing[2], all[11]];
    let some = room.jacobian(&asked, &settings, None);
    assert!(some.radiance == whole.radiance);
    for (k, parameter) in asked.iter().enumerate() {
        let expected = match all.iter().position(|p| p == parameter) {
            Some(index) => column(&whole, index),
            None => vec![DVec3::ZERO; SIDE * SIDE],
        };
        assert!(column(&some, k) == expected, "{parameter:?}");
    }
    // Chosen pixels are those of the whole picture.
    let pixels = [7, 99, 3];
    let (appearance, camera) = (room.appearance(), &room.camera);
    let chosen = room.tracer.jacobian(
        camera,
        SIZE,
        &Query { parameters: &all, ..Query::new(appearance, &pixels, &settings) },
    );
    for (row, pixel) in chosen.derivatives.chunks(all.len()).zip(pixels) {
        assert_eq!(row, &whole.derivatives[pixel as usize * all.len()..][..all.len()]);
    }
}

#[test]
fn each_pixel_has_paths_of_its_own() {
    let room = Room::new(WardModel::WardGmd);
    let all = everything();
    let of = |first: u32, spp: u32| {
        let settings = Settings { first, ..settings(spp) };
        room.jacobian(&all, &settings, None)
    };
    let ranges = [0..4, 4..16, 0..0];
    let [few, more] = [of(0, 4), of(4, 12)];
    let pixels = all_pixels().into_iter();
    let asked: Vec<_> = pixels.map(|p| (p, ranges[p as usize % 3].clone())).collect();
    let found = room.tracer.jacobian_of_samples(
        &room.camera,
        SIZE,
        &Query { parameters: &all, ..Query::new(room.appearance(), &asked, &settings(1)) },
    );
    for pixel in 0..asked.len() {
        let row = |jacobian: &Jacobian| {
            let derivatives = &jacobian.derivatives[pixel * all.len()..][..all.len()];
            (jacobian.radiance[pixel], derivatives.to_vec())
        };
        let none = (Rgb::ZERO, vec![Rgb::ZERO; all.len()]);
        let expected = [row(&few), row(&more), none][pixel % 3].clone();
        assert_eq!(row(&found), expected, "pixel {pixel}");
    }
}
