//! Light samples against analytic sums and solid angles.

use super::*;
use crate::accel;
use crate::sampler::mix;
use glam::DVec3;

const BOUNDS: [Vec3; 2] = [Vec3::splat(-3.0), Vec3::splat(3.0)];
const POINT: Vec3 = Vec3::new(0.2, -0.4, 0.1);
const SAMPLES: u64 = 200_000;

fn uniform(index: u64) -> f32 {
    (mix(index) >> 40) as f32 / (1u32 << 24) as f32
}

fn unit(index: u64) -> Vec3 {
    let v = Vec3::new(uniform(3 * index), uniform(3 * index + 1), uniform(3 * index + 2)) - 0.5;
    v.normalize()
}

/// Forty points, twenty spots and three suns.
fn punctual() -> Vec<Light> {
    let light = |kind| Light { name: String::new(), kind };
    let place = |i: u64| unit(i) * (0.5 + 2.0 * uniform(i + 1000));
    let strength = |i: u64| Rgb::new(uniform(i + 2000), uniform(i + 3000), uniform(i + 4000));
    let mut lights = Vec::new();
    for i in 0..40 {
        let (position, intensity) = (place(i), strength(i));
        lights.push(light(LightKind::Point { position, intensity }));
        if i % 2 == 0 {
            let (direction, outer_rad) = (unit(i + 500), 0.4 + uniform(i + 600));
            let (inner_rad, position) = (0.5 * outer_rad, place(i + 700));
            let kind = LightKind::Spot { position, direction, intensity, inner_rad, outer_rad };
            lights.push(light(kind));
        }
    }
    for i in 0..3 {
        let (direction, irradiance) = (unit(i + 800), 0.2 * strength(i + 800));
        lights.push(light(LightKind::Directional { direction, irradiance }));
    }
    lights
}

/// A hundred triangles around the point, of random orientation.
fn triangles() -> Vec<[Vec3; 3]> {
    let triangle = |i: u64| {
        let centre = POINT + unit(i) * (0.6 + 2.0 * uniform(i + 100));
        [0, 1, 2].map(|corner| centre + 0.3 * unit(7 * i + corner + 9000))
    };
    (0..100).map(triangle).collect()
}

fn emission(triangle: usize) -> TriangleEmission {
    let radiance = Rgb::splat(0.1 + uniform(triangle as u64 + 50));
    TriangleEmission { group: triangle as u32 / 10, radiance }
}

/// Fails unless the mean of `of` over light samples is `expected`.
fn assert_mean(emitters: &Emitters, of: impl Fn(&LightSample) -> Rgb, expected: DVec3) {
    let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
    for i in 0..SAMPLES {
        let u = [0, 1, 2].map(|k| uniform(77 + 3 * i + k));
        let value = emitters.sample(POINT, u).map_or(DVec3::ZERO, |light| of(&light).as_dvec3());
        sum += value;
        squares += value * value;
    }
    let mean = sum / SAMPLES as f64;
    let sigma = ((squares / SAMPLES as f64 - mean * mean) / SAMPLES as f64).map(f64::sqrt);
    assert!(sigma.max_element() < 0.01 * expected.max_element(), "{sigma} in {expected} is much");
    assert!(((mean - expected).abs() - 4.5 * sigma).max_element() < 0.0, "{mean} not {expected}");
}

#[test]
fn punctual_lights_contribute_the_sum_of_all() {
    let lights = punctual();
    let emitters = Emitters::new(&[], emission, 0, &lights, BOUNDS, None);
    let expected = lights.iter().map(|light| light.kind.illuminate(POINT).2.as_dvec3()).sum();
    assert_mean(&emitters, |light| light.weight, expected);
}

#[test]
fn emitting_triangles_contribute_radiance_times_solid_angle() {
    let triangles = triangles();
    let emitters = Emitters::new(&triangles, emission, 10, &[], BOUNDS, None);
    let contribution = |(index, corners): (usize, &[Vec3; 3])| {
        let faces = (POINT - corners[0]).dot(accel::front_normal(*corners)) > 0.0;
        let radiance = emission(index).radiance.as_dvec3();
        if faces { radiance * solid_angle(corners) } else { DVec3::ZERO }
    };
    assert_mean(
        &emitters,
        |light| light.weight,
        triangles.iter().enumerate().map(contribution).sum(),
    );
}

/// The solid angle of a triangle from [`POINT`] [Van Oosterom and Strackee 1983].
fn solid_angle(corners: &[Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| (corner - POINT).as_dvec3().normalize());
    2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

#[test]
fn densities_agree_with_those_of_the_samples() {
    let (triangles, lights) = (triangles(), punctual());
    let emitters = Emitters::new(&triangles, emission, 10, &lights, BOUNDS, None);
    let mut compared = 0;
    for i in 0..20_000 {
        let u = [0, 1, 2].map(|k| uniform(3 * i + k));
        let Some(light) = emitters.sample(POINT, u) else { continue };
        let LightSource::Group(group) = light.source else { continue };
        // Which of the group's triangles it is: the one that the ray hits at that distance.
        let on_light = POINT + light.distance * light.wi;
        let first = group as usize * 10;
        let is_on = |t: &usize| {
            let normal = accel::front_normal(triangles[*t]);
            let inside = (0..3).all(|k| {
                let (from, to) = (triangles[*t][k], triangles[*t][(k + 1) % 3]);
                normal.dot((to - from).cross(on_light - from)) > -1e-4
            });
            inside && (on_light - triangles[*t][0]).dot(normal).abs() < 1e-3
        };
        let Some(triangle) = (first..first + 10).find(is_on) else { continue };
        let cos = -light.wi.dot(accel::front_normal(triangles[triangle]));
        let pdf = emitters.pdf(POINT, triangle as u32, light.distance, cos);
        assert!((light.pdf.unwrap_or(0.0) / pdf - 1.0).abs() < 1e-3, "{light:?} {pdf}");
        compared += 1;
    }
    assert!(compared > 500, "{compared} samples");
}
