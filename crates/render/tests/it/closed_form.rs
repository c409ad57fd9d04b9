//! Proves whole pictures against light transport that has a closed form: Lambert's polygon formula,
//! lights without a surface, closed enclosures and furnaces.
//!
//! Comparisons are by the picture's own noise: see `common::assert_agree`.

use crate::common::{Estimate, Stage, assert_agree, camera, plate_corners, quad_mesh, settings};
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use unrender_render::Settings;
use unrender_scene::{Camera, LightKind, LightProfile, Material, Photometry, Rgb, WardModel};

const RHO: Rgb = Rgb::new(0.2, 0.5, 0.8);
const BLACK: Rgb = Rgb::ZERO;

/// A diffuse floor of reflectance `rho` in the plane y = 0, and nothing else.
fn floor(rho: Rgb) -> Stage {
    let mut stage = Stage::default();
    let floor = stage.group(Material::diffuse(rho), BLACK);
    stage.plate(floor, Vec3::ZERO, 5.0 * Vec3::Z, 5.0 * Vec3::X);
    stage
}

/// The radiance of the floor at `point`, seen by a camera so narrow that it sees one point.
fn seen_at(stage: &Stage, point: Vec3, settings: Settings) -> Estimate {
    let camera = camera(point + Vec3::new(0.8, 2.0, 1.5), point, 2e-3);
    Estimate::of_film(&stage.render(&camera, 16, settings))
}

/// The irradiance by a polygon of radiance one at the point and normal given, the polygon being
/// wholly above the plane [Lambert 1760]: half the sum over the edges of the angle they subtend
/// times the cosine between the normal and the normal of the plane through edge and point.
fn irradiance_by_polygon(point: Vec3, normal: Vec3, corners: &[Vec3]) -> f64 {
    let at = |i: usize| (corners[i % corners.len()] - point).as_dvec3().normalize();
    let edge = |i: usize| -> f64 {
        let (a, b) = (at(i), at(i + 1));
        let across: DVec3 = a.cross(b).normalize();
        a.angle_between(b) * across.dot(normal.as_dvec3())
    };
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

#[test]
fn a_polygon_lights_the_floor_by_lamberts_formula() {
    let polygons = [
        // Straight above, facing down.
        [(-0.5, 1.0, -0.5), (0.5, 1.0, -0.5), (0.5, 1.0, 0.5), (-0.5, 1.0, 0.5)],
        // A wall beside the point, facing +x, down to the floor.
        [(-1.0, 1e-3, 1.0), (-1.0, 1e-3, -1.0), (-1.0, 2.0, -1.0), (-1.0, 2.0, 1.0)],
        // Tilted, not a rectangle, small and near.
        [(0.1, 0.30, -0.2), (0.5, 0.45, -0.2), (0.6, 0.6, 0.3), (0.15, 0.35, 0.1)],
    ];
    for (index, polygon) in polygons.into_iter().enumerate() {
        let corners = polygon.map(|(x, y, z)| Vec3::new(x, y, z));
        let radiance = Rgb::new(3.0, 2.0, 1.0);
        let mut stage = floor(RHO);
        let lamp = stage.group(Material::diffuse(BLACK), radiance);
        stage.quad(lamp, corners);
        // The last quad is not flat: it is two triangles, and so is the formula's input.
        let [a, b, c, d] = corners;
        for point in [Vec3::ZERO, Vec3::new(0.3, 0.0, 0.4)] {
            let irradiance = irradiance_by_polygon(point, Vec3::Y, &[a, b, c])
                + irradiance_by_polygon(point, Vec3::Y, &[a, c, d]);
            let expected = RHO * radiance * (irradiance as f32 * FRAC_1_PI);
            let found = seen_at(&stage, point, settings(1024));
            let what = format!("polygon {index} at {point}");
            assert_agree(&what, found, Estimate::exactly(expected), 2e-3);
        }
    }
}

#[test]
fn a_surface_whose_shading_normal_faces_away_is_as_bright_as_from_its_other_side() {
    let normal = Vec3::new(0.8, 0.6, 0.0);
    let mut stage = Stage::default();
    let group = stage.group(Material::diffuse(RHO), BLACK);
    let mut mesh = quad_mesh(plate_corners(Vec3::ZERO, 5.0 * Vec3::Z, 5.0 * Vec3::X), &[]);
    mesh.normals.fill(normal);
    stage.mesh(group, mesh);
    let direction = Vec3::new(-0.6, -0.8, 0.0);
    stage.light(LightKind::Directional { direction, irradiance: Rgb::splat(3.0) });
    let expected = RHO * (3.0 * FRAC_1_PI * normal.dot(-direction));
    for eye in [Vec3::new(2.0, 0.7, 0.1), Vec3::new(-2.0, 0.7, 0.1)] {
        let film = stage.render(&camera(eye, Vec3::ZERO, 2e-3), 4, settings(4));
        let what = format!("from {eye}");
        assert_agree(&what, Estimate::of_film(&film), Estimate::exactly(expected), 1e-6);
    }
}

/// A profile whose intensity is a line in the vertical angle times a line in the horizontal one, which halves it.
fn quarter_profile() -> LightProfile {
    let (vertical, horizontal) = (vec![0.0, 90.0], vec![0.0, 180.0]);
    LightProfile::new(Photometry::C, vertical, horizontal, &[100.0, 0.0, 50.0, 0.0]).unwrap()
}

#[test]
fn lights_without_a_surface_bring_their_irradiance() {
    let position = Vec3::new(0.5, 2.0, -1.0);
    let intensity = Rgb::new(9.0, 5.0, 2.0);
    let down = Vec3::new(-0.1, -1.0, 0.3).normalize();
    let kinds = [
        LightKind::Point { position, intensity },
        LightKind::Spot { position, direction: down, intensity, inner_rad: 0.1, outer_rad: 0.6 },
        LightKind::Directional { direction: down, irradiance: intensity },
        LightKind::Profiled {
            position,
            direction: Vec3::NEG_Y,
            upright: Vec3::X,
            intensity,
            profile: quarter_profile(),
        },
    ];
    let point = Vec3::new(0.3, 0.0, 0.2);
    let to_light = position - point;
    let cos_spot = to_light.normalize().dot(-down);
    let fade = (cos_spot - 0.6f32.cos()) / (0.1f32.cos() - 0.6f32.cos());
    assert!(fade > 0.2 && fade < 0.9, "the test wants a point in the penumbra");
    let from_point = intensity * to_light.normalize().y / to_light.length_squared();
    // The profile falls off with the vertical angle, and more so towards a horizontal angle of 180 degrees.
    let away = -to_light.normalize();
    let (vertical, horizontal) = ((-away.y).acos(), away.z.atan2(away.x).abs());
    let shape = (1.0 - vertical / FRAC_PI_2) * (1.0 - 0.5 * horizontal / PI);
    let profiled = from_point * shape;
    let irradiances = [from_point, from_point * fade * fade, intensity * -down.y, profiled];
    let mut all = floor(RHO);
    for (kind, irradiance) in kinds.into_iter().zip(irradiances) {
        let mut stage = floor(RHO);
        stage.light(kind.clone());
        all.light(kind.clone());
        let found = seen_at(&stage, point, settings(16));
        assert_agree(
            &format!("{kind:?}"),
            found,
            Estimate::exactly(RHO * FRAC_1_PI * irradiance),
            1e-3,
        );
    }
    let sum: Rgb = irradiances.into_iter().sum();
    let found = seen_at(&all, point, settings(4096));
    assert_agree("all of them", found, Estimate::exactly(RHO * FRAC_1_PI * sum), 2e-3);
}

#[test]
fn things_before_a_light_cast_shadows() {
    for (height, lit) in [(1.0, false), (3.0, true)] {
        let mut stage = floor(RHO);
        let shade = stage.group(Material::diffuse(BLACK), BLACK);
        stage.plate(shade, Vec3::Y * height, 0.2 * Vec3::X, 0.2 * Vec3::Z);
        stage.light(LightKind::Point { position: 2.0 * Vec3::Y, intensity: Rgb::ONE });
        let found = seen_at(&stage, Vec3::ZERO, settings(16));
        assert_eq!(found.mean.min_element() > 0.0, lit);
    }
}

/// A closed room whose walls all emit and reflect alike.
fn enclosure(emission: Rgb, rho: Rgb) -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(rho), emission);
    stage.room(wall, Vec3::new(1.0, 0.7, 1.5));
    stage
}

#[test]
fn a_closed_enclosure_glows_by_the_geometric_series() {
    let (emission, rho) = (Rgb::new(1.0, 0.5, 0.1), Rgb::new(0.3, 0.6, 0.9));
    let stage = enclosure(emission, rho);
    let view = camera(Vec3::new(0.3, 0.1, 0.2), Vec3::new(-1.0, -0.5, -1.5), 1.2);
    let found = Estimate::of_film(&stage.render(&view, 16, settings(512)));
    assert_agree("enclosure", found, Estimate::exactly(emission / (Rgb::ONE - rho)), 3e-3);
    let mut expected = Rgb::ZERO;
    let mut power = emission;
    for max_bounces in 0..4 {
        expected += power;
        power *= rho;
        let settings = Settings { max_bounces, ..settings(256) };
        let found = Estimate::of_film(&stage.render(&view, 8, settings));
        assert_agree(&format!("{max_bounces} bounces"), found, Estimate::exactly(expected), 5e-3);
    }
}

#[test]
fn a_furnace_of_mirrors_and_diffuse_walls_glows_alike() {
    let (emission, rho) = (Rgb::ONE, Rgb::new(0.3, 0.5, 0.7));
    let mut stage = enclosure(emission, rho);
    let mixed = Material { rho_s: 0.5 * rho, ..Material::diffuse(0.5 * rho) };
    let ball = stage.group(mixed, emission);
    stage.sphere(ball, Vec3::ZERO, 0.4, 16);
    let view = camera(Vec3::new(0.2, 0.1, 1.2), Vec3::ZERO, 0.5);
    let found = Estimate::of_film(&stage.render(&view, 16, settings(1024)));
    assert_agree("half a mirror", found, Estimate::exactly(emission / (Rgb::ONE - rho)), 3e-3);
}

/// A ball of `material` in a black room that emits `radiance` all around; the mean of its picture.
fn in_the_furnace(material: Material, model: WardModel, radiance: Rgb) -> Estimate {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(BLACK), radiance);
    stage.room(wall, Vec3::splat(2.0));
    let ball = stage.group(material, BLACK);
    stage.sphere(ball, Vec3::ZERO, 0.5, 24);
    stage.scene.brdf = model.into();
    // The narrow view stays on the ball and away from its limb, where the shading normals of a
    // mesh are no longer those of its triangles.
    let view = camera(Vec3::new(0.3, 0.4, 1.8), Vec3::new(0.03, 0.02, 0.0), 0.3);
    Estimate::of_film(&stage.render(&view, 16, settings(1024)))
}

#[test]
fn white_things_vanish_in_the_furnace() {
    let radiance = Rgb::new(2.0, 1.0, 0.5);
    for material in [Material::diffuse(Rgb::ONE), Material::mirror(Rgb::ONE)] {
        let found = in_the_furnace(material, WardModel::WardGmd, radiance);
        assert_agree("white", found, Estimate::exactly(radiance), 1e-3);
    }
}

#[test]
fn the_bounded_lobe_never_outshines_the_furnace() {
    let radiance = Rgb::new(2.0, 1.0, 0.5);
    for alpha in [0.02, 0.1, 0.3, 0.8] {
        let material = Material::isotropic(BLACK, Rgb::ONE, alpha);
        let found = in_the_furnace(material, WardModel::WardGmd, radiance);
        let share = found.mean / radiance.as_dvec3();
        assert!(share.max_element() <= 1.0 + 3e-5, "alpha {alpha}: {share}");
        assert!(share.min_element() > 0.5, "alpha {alpha}: {share}");
    }
}

/// A lamp over a small diffuse plate; `turn` turns the plate's winding and with it its front.
fn lamp_and_plate(turn: bool, lamp_faces_down: bool) -> Stage {
    let mut stage = Stage::default();
    let plate = stage.group(
        Material { rho_s: 0.4 * RHO, alpha_x: 0.2, alpha_y: 0.1, ..Material::diffuse(RHO) },
        BLACK,
    );
    let (x, y) = if turn { (Vec3::X, Vec3::Z) } else { (Vec3::Z, Vec3::X) };
    stage.plate(plate, Vec3::ZERO, x, y);
    let lamp = stage.group(Material::diffuse(BLACK), Rgb::new(1.0, 2.0, 3.0));
    let (x, y) = if lamp_faces_down { (Vec3::X, Vec3::Z) } else { (Vec3::Z, Vec3::X) };
    stage.plate(lamp, Vec3::new(0.2, 1.0, 0.1), 0.3 * x, 0.3 * y);
    stage
}

#[test]
fn area_lights_shine_from_their_front_and_are_black_behind() {
    let from_below = camera(Vec3::new(0.0, 0.2, 0.6), Vec3::new(0.2, 1.0, 0.1), 0.05);
    let front = lamp_and_plate(false, true);
    let seen = Estimate::of_film(&front.render(&from_below, 8, settings(4)));
    assert_agree("front", seen, Estimate::exactly(Rgb::new(1.0, 2.0, 3.0)), 1e-6);
    let back = lamp_and_plate(false, false);
    assert_eq!(Estimate::of_film(&back.render(&from_below, 8, settings(4))).mean, DVec3::ZERO);
    // Nor does the back light the plate.
    assert_eq!(seen_at(&back, Vec3::ZERO, settings(64)).mean, DVec3::ZERO);
}

#[test]
fn both_sides_of_a_surface_reflect_alike() {
    let front = seen_at(&lamp_and_plate(false, true), Vec3::ZERO, settings(1024));
    let back = seen_at(&lamp_and_plate(true, true), Vec3::ZERO, settings(1024));
    // The tangent is world +x for both, so that the lobe is the same line.
    assert_agree("front and back", back, front, 2e-3);
}

/// Coloured lamps of odd shape before the plane z = 0.
fn patches() -> Stage {
    let mut stage = Stage::default();
    for (i, (x, y, z)) in [(-0.6, 0.3, 1.2), (0.5, 0.5, 2.0), (0.2, -0.5, 1.6)].iter().enumerate() {
        let lamp = stage.group(Material::diffuse(BLACK), Vec3::AXES[i] * (i as f32 + 1.0));
        let (across, up) = (Vec3::new(-0.3, 0.05, 0.1), Vec3::new(0.1, 0.2 + 0.1 * i as f32, 0.0));
        stage.plate(lamp, Vec3::new(*x, *y, *z), across, up);
    }
    stage
}

#[test]
fn a_mirror_shows_the_mirror_image() {
    let side = 24;
    let (eye, target) = (Vec3::new(0.1, 0.1, 0.9), Vec3::new(0.0, 0.05, 0.0));
    let mut with_mirror = patches();
    let tint = Rgb::new(0.9, 0.6, 0.3);
    let mirror = with_mirror.group(Material::mirror(tint), BLACK);
    with_mirror.plate(mirror, Vec3::ZERO, 3.0 * Vec3::X, 3.0 * Vec3::Y);
    let behind = |v: Vec3| Vec3::new(v.x, v.y, -v.z);
    let direct =
        patches().render(&camera(behind(eye), behind(target), PI / 4.0), side, settings(64));
    let mirrored = with_mirror.render(&camera(eye, target, PI / 4.0), side, settings(64));
    let mut certain = 0;
    for (x, y) in (0..side).flat_map(|x| (0..side).map(move |y| (x, y))) {
        // The mirrored camera is left-handed: its picture is flipped.
        let there = side - 1 - x;
        let (a, b) = (*mirrored.mean.at(x, y), tint * *direct.mean.at(there, y));
        let variance = *mirrored.variance.at(x, y) + tint * tint * *direct.variance.at(there, y);
        if variance == Rgb::ZERO {
            certain += u32::from(b != Rgb::ZERO);
            assert!((a - b).abs().max_element() < 1e-5, "{a} is not {b} at ({x}, {y})");
        } else {
            let limit = 5.0 * variance.map(f32::sqrt) + 1e-5;
            assert!((a - b).abs().cmple(limit).all(), "{a} is not {b} at ({x}, {y})");
        }
    }
    assert!(certain > 20, "{certain} pixels wholly inside the patches");
}

#[test]
fn what_is_nearer_than_the_near_clipping_plane_is_not_seen() {
    let mut stage = Stage::default();
    let [near, far] =
        [2.0, 3.0].map(|radiance| stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(radiance)));
    stage.plate(near, Vec3::NEG_Z, 3.0 * Vec3::X, 3.0 * Vec3::Y);
    stage.plate(far, -2.0 * Vec3::Z, 6.0 * Vec3::X, 6.0 * Vec3::Y);
    let view = camera(Vec3::ZERO, Vec3::NEG_Z, 1.6);
    for (cut, radiance, depth) in
        [(0.0, 2.0, 1.0), (0.99, 2.0, 1.0), (1.01, 3.0, 2.0), (2.5, 0.0, f32::INFINITY)]
    {
        let view = Camera { near: cut, ..view.clone() };
        let film = stage.render(&view, 9, settings(4));
        let even = |p: &Rgb| (*p - Rgb::splat(radiance)).abs().max_element() < 1e-5;
        assert!(film.mean.pixels().iter().all(even), "{cut}");
        // Depths count from the camera's centre all the same.
        let middle = stage.tracer().geometry(&view, 9, 9).pixels()[40].depth;
        assert!(middle == depth || (middle - depth).abs() < 1e-5, "{cut}: {middle}");
    }
}
