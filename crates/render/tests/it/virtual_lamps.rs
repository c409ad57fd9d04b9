//! Lamps in one and two planar mirrors light a wall like so many more lamps: closed forms for lights at a
//! point, in a direction and of an area; what occludes a part of the way; the derivative by the mirrors'
//! reflectance; path reuse and probes.

use crate::common::{Estimate, Stage, assert_agree, camera, plate_corners, settings};
use crate::guiding::irradiance_by_polygon;
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_PI, PI, TAU};
use unrender_render::{Integrator, Parameter, ProbeSettings, Query, Settings};
use unrender_scene::{Camera, Environment, LightKind, Material, Rgb, RgbImage};

/// Of the wall, the floor and the mirror on the right.
const RHO: Rgb = Rgb::new(0.2, 0.5, 0.8);
const FLOOR: Rgb = Rgb::new(0.9, 0.7, 0.5);
const SIDE: Rgb = Rgb::new(0.4, 0.6, 0.8);
const LIGHT: Rgb = Rgb::new(3.0, 2.0, 1.0);
/// Where the lights are.
const PLACE: Vec3 = Vec3::new(0.2, 0.7, 1.4);
/// The group of the floor.
const FLOOR_GROUP: u32 = 1;

/// A diffuse wall in the plane z = 0 above a mirror in the plane y = 0; with `side` another one in the
/// plane x = 1. Light that leaves the wall does not come back.
fn stage(side: bool) -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(RHO), Rgb::ZERO);
    stage.plate(wall, Vec3::Y, Vec3::X, Vec3::Y);
    let floor = stage.group(Material::mirror(FLOOR), Rgb::ZERO);
    stage.plate(floor, 2.0 * Vec3::Z - Vec3::X, 2.0 * Vec3::Z, 2.0 * Vec3::X);
    if side {
        let mirror = stage.group(Material::mirror(SIDE), Rgb::ZERO);
        let centre = Vec3::new(1.0, 2.0, 2.0);
        stage.plate(mirror, centre, 2.0 * Vec3::Z, 2.0 * Vec3::Y);
    }
    stage
}

/// The images of a point, with the share of each that the mirrors reflect.
fn images(point: Vec3, side: bool) -> Vec<(Vec3, Rgb)> {
    let in_floor = |p: Vec3| Vec3::new(p.x, -p.y, p.z);
    let in_side = |p: Vec3| Vec3::new(2.0 - p.x, p.y, p.z);
    let mut all = vec![(point, Rgb::ONE), (in_floor(point), FLOOR)];
    if side {
        all.extend([(in_side(point), SIDE), (in_floor(in_side(point)), FLOOR * SIDE)]);
    }
    all
}

/// What a light at a point sends to `point` of the wall, from one of its images.
fn irradiance(point: Vec3, (image, share): (Vec3, Rgb)) -> Rgb {
    let away = image - point;
    LIGHT * share * (away.z / away.length().powi(3))
}

/// Points of the wall: near the floor, and near both mirrors.
const POINTS: [Vec3; 2] = [Vec3::new(-0.4, 0.3, 0.0), Vec3::new(0.7, 0.2, 0.0)];

/// A camera that sees hardly more than `point`.
fn view(point: Vec3) -> Camera {
    camera(point + Vec3::new(-0.3, 0.2, 1.0), point, 2e-3)
}

#[test]
fn a_light_at_a_point_has_an_image_in_each_mirror_and_one_in_both() {
    for (side, point) in [false, true].into_iter().flat_map(|side| POINTS.map(|p| (side, p))) {
        let mut stage = stage(side);
        stage.light(LightKind::Point { position: PLACE, intensity: LIGHT });
        let light: Rgb =
            images(PLACE, side).into_iter().map(|image| irradiance(point, image)).sum();
        let expected = Estimate::exactly(RHO * FRAC_1_PI * light);
        let found = Estimate::of_film(&stage.render(&view(point), 16, settings(256)));
        assert_agree(&format!("side {side}, {point}"), found, expected, 4e-3);
    }
}

#[test]
fn a_spot_at_the_floor_and_the_sun_light_the_wall_from_below() {
    let [point, _] = POINTS;
    // The spot looks at the floor where the wall's point sees its image, and away from the point.
    let image = Vec3::new(PLACE.x, -PLACE.y, PLACE.z);
    let crossing = point + (image - point) * (point.y / (point.y - image.y));
    let direction = (crossing - PLACE).normalize();
    let spot = LightKind::Spot {
        position: PLACE,
        direction,
        intensity: LIGHT,
        inner_rad: 0.1,
        outer_rad: 0.2,
    };
    let by_spot = irradiance(point, (image, FLOOR));
    // The sun comes from above.
    let down = Vec3::new(0.1, -0.8, -0.4).normalize();
    let sun = LightKind::Directional { direction: down, irradiance: LIGHT };
    let by_sun = LIGHT * -down.z * (Rgb::ONE + FLOOR);
    for (what, kind, light) in [("spot", spot, by_spot), ("sun", sun, by_sun)] {
        let mut stage = stage(false);
        stage.light(kind);
        let expected = Estimate::exactly(RHO * FRAC_1_PI * light);
        let found = Estimate::of_film(&stage.render(&view(point), 8, settings(128)));
        assert_agree(what, found, expected, 4e-3);
    }
}

#[test]
fn the_sun_of_a_panorama_lights_the_wall_from_below() {
    let [point, _] = POINTS;
    // One pixel of the sky is as bright as the sun.
    let (width, height) = (64, 32);
    let sun = 6 * width + 3;
    let pixels = (0..width * height).map(|i| if i == sun { 2e3 * LIGHT } else { 0.1 * LIGHT });
    let around = RgbImage::new(width, height, pixels.collect());
    let around = Environment::new(around, 0.0).unwrap();
    // What arrives along `wi`: from the sky, or by way of the floor, whose edges are those of `stage`.
    let arriving = |wi: Vec3| {
        let crossing = point - wi * (point.y / wi.y);
        let floor = wi.y < 0.0 && (-3.0..1.0).contains(&crossing.x) && crossing.z < 4.0;
        if floor {
            FLOOR * around.radiance(wi * Vec3::new(1.0, -1.0, 1.0))
        } else {
            around.radiance(wi)
        }
    };
    // By the midpoint rule over directions by the cosine.
    let steps = 2000;
    let part = |i: usize| (i as f32 + 0.5) / steps as f32;
    let mut sum = DVec3::ZERO;
    for (u, v) in (0..steps * steps).map(|i| (part(i / steps), part(i % steps))) {
        let (y, x) = (TAU * v).sin_cos();
        sum += arriving(Vec3::new(x * u.sqrt(), y * u.sqrt(), (1.0 - u).sqrt())).as_dvec3();
    }
    let mean = (sum / (steps * steps) as f64).as_vec3();
    let mut stage = stage(false);
    stage.scene.environment = Some(around.clone());
    let film = stage.render(&view(point), 24, settings(256));
    assert_agree("panorama", Estimate::of_film(&film), Estimate::exactly(RHO * mean), 4e-3);
}

/// The corners of an area light of side 0.1 that looks down and at the wall.
fn lamp() -> [Vec3; 4] {
    plate_corners(PLACE, 0.05 * Vec3::new(0.0, 0.8, -0.6), 0.05 * Vec3::X)
}

#[test]
fn a_small_area_light_has_the_same_images() {
    for (side, point) in [false, true].into_iter().flat_map(|side| POINTS.map(|p| (side, p))) {
        let mut stage = stage(side);
        let group = stage.group(Material::diffuse(Rgb::ZERO), 100.0 * LIGHT);
        stage.quad(group, lamp());
        let mut light = Rgb::ZERO;
        let corners = lamp().map(|corner| images(corner, side));
        for index in 0..corners[0].len() {
            let image = corners.each_ref().map(|corner| corner[index].0);
            light += corners[0][index].1 * irradiance_by_polygon(point, Vec3::Z, &image);
        }
        let expected = Estimate::exactly(100.0 * LIGHT * RHO * FRAC_1_PI * light);
        let found = Estimate::of_film(&stage.render(&view(point), 16, settings(512)));
        assert_agree(&format!("side {side}, {point}"), found, expected, 4e-3);
    }
}

/// The point of the bulb that a sample draws lies off its surface by less than the ray lies off the mirror. A sphere of the radiance `L` sends `pi L sin^2` times the cosine, `sin` that of
/// its angular radius, to where it is above the horizon; one of triangles is hardly smaller.
#[test]
fn a_bulb_has_the_same_images() {
    let radius = 0.1;
    for (side, point) in [false, true].into_iter().flat_map(|side| POINTS.map(|p| (side, p))) {
        let mut stage = stage(side);
        let group = stage.group(Material::diffuse(Rgb::ZERO), 10.0 * LIGHT);
        stage.sphere(group, PLACE, radius, 48);
        let of_image = |image| 10.0 * PI * radius * radius * irradiance(point, image);
        let light: Rgb = images(PLACE, side).into_iter().map(of_image).sum();
        let expected = Estimate::exactly(RHO * FRAC_1_PI * light);
        let found = Estimate::of_film(&stage.render(&view(point), 16, settings(256)));
        assert_agree(&format!("side {side}, {point}"), found, expected, 4e-3);
    }
}

#[test]
fn what_occludes_either_part_of_the_way_takes_the_image_away() {
    let [point, _] = POINTS;
    let image = Vec3::new(PLACE.x, -PLACE.y, PLACE.z);
    let crossing = point + (image - point) * (point.y / (point.y - image.y));
    let expected = Estimate::exactly(RHO * FRAC_1_PI * irradiance(point, (PLACE, Rgb::ONE)));
    for end in [point, PLACE] {
        let mut stage = stage(false);
        stage.light(LightKind::Point { position: PLACE, intensity: LIGHT });
        let black = stage.group(Material::diffuse(Rgb::ZERO), Rgb::ZERO);
        stage.plate(black, crossing.lerp(end, 0.4), 0.05 * Vec3::X, 0.05 * Vec3::Z);
        let found = Estimate::of_film(&stage.render(&view(point), 8, settings(64)));
        assert_agree(&format!("before {end}"), found, expected, 4e-3);
    }
}

#[test]
fn mirrors_count_as_reflections_of_a_path() {
    // With two reflections, the wall and one mirror, light by way of both mirrors is missing.
    let [_, point] = POINTS;
    let mut stage = stage(true);
    stage.light(LightKind::Point { position: PLACE, intensity: LIGHT });
    for (bounces, count) in [(1, 1), (2, 3), (3, 4)] {
        let light: Rgb =
            images(PLACE, true).into_iter().take(count).map(|image| irradiance(point, image)).sum();
        let settings = Settings { max_bounces: bounces, ..settings(256) };
        let found = Estimate::of_film(&stage.render(&view(point), 16, settings));
        let expected = Estimate::exactly(RHO * FRAC_1_PI * light);
        assert_agree(&format!("{bounces} reflections"), found, expected, 4e-3);
    }
}

#[test]
fn path_reuse_and_probes_see_the_same_images() {
    let camera = camera(Vec3::new(-0.3, 0.9, 2.5), Vec3::new(0.0, 0.5, 0.0), 0.35);
    let mut stage = stage(true);
    stage.light(LightKind::Point { position: PLACE, intensity: LIGHT });
    let group = stage.group(Material::diffuse(Rgb::ZERO), 100.0 * LIGHT);
    stage.quad(group, lamp().map(|corner| corner - 0.3 * Vec3::X));
    let expected = Estimate::of_film(&stage.render(&camera, 24, settings(512)));
    let reuse = Settings { integrator: Integrator::PathReuse, seed: 2, ..settings(512) };
    // Its noise is correlated in neighbouring pixels; that of the mean is at most that of 8 x 8 together.
    let mut found = Estimate::of_film(&stage.render(&camera, 24, reuse));
    found.sigma *= 8.0;
    assert_agree("path reuse", found, expected, 4e-3);
    let pixels: Vec<u32> = (0..24 * 24).collect();
    let settings = ProbeSettings { probes_per_pixel: 4, seed: 3, ..ProbeSettings::default() };
    let probes = stage.tracer().probe(
        &camera,
        (24, 24),
        &Query::new(&stage.scene.materials(), &pixels, &settings),
    );
    let radiance = |probe: &unrender_render::Probe| (RHO * probe.diffuse).as_dvec3();
    let samples: Vec<DVec3> = probes.probes.iter().map(radiance).collect();
    assert_agree("probes", Estimate::of_samples(&samples), expected, 1e-2);
}

#[test]
fn the_derivative_by_a_mirror_is_the_light_of_its_images() {
    let [_, point] = POINTS;
    let mut stage = stage(true);
    stage.light(LightKind::Point { position: PLACE, intensity: LIGHT });
    let images = images(PLACE, true);
    let light = irradiance(point, images[1]) + irradiance(point, images[3]);
    let pixels: Vec<u32> = (0..256).collect();
    let jacobian = stage.tracer().jacobian(
        &view(point),
        (16, 16),
        &Query {
            parameters: &[Parameter::RhoS(FLOOR_GROUP)],
            ..Query::new(&stage.scene.materials(), &pixels, &settings(256))
        },
    );
    let samples: Vec<DVec3> = jacobian.derivatives.iter().map(|d| d.as_dvec3()).collect();
    let expected = Estimate::exactly(RHO * FRAC_1_PI * light / FLOOR);
    assert_agree("derivative", Estimate::of_samples(&samples), expected, 4e-3);
}
