//! Glass: furnaces, closed forms of panes, slabs and balls, light samples through panes, and derivatives behind them.

use crate::common::{Estimate, Stage, assert_agree, camera, plate_corners, quad_mesh, settings};
use glam::Vec3;
use unrender_render::accel::Ray;
use unrender_render::path::Transport;
use unrender_render::{Integrator, Parameter, ProbeSettings, Query, Settings, Tracer};
use unrender_scene::reflectance::fresnel;
use unrender_scene::{
    Environment, Glass, Image, LightKind, Material, Mesh, Object, Rgb, Scene, Ungrouped,
};

const IOR: f32 = 1.5;

impl Stage {
    fn glass(&mut self, glass: Glass, mesh: Mesh) {
        self.scene.ungrouped.push(Ungrouped { material: "glass".into(), mesh, glass: Some(glass) });
    }

    fn pane(&mut self, glass: Glass, centre: Vec3, x: Vec3, y: Vec3) {
        self.glass(glass, quad_mesh(plate_corners(centre, x, y), &[]));
    }

    fn sky(&mut self, radiance: Rgb) {
        let panorama = Image::new(2, 1, vec![radiance; 2]);
        self.scene.environment = Some(Environment::new(panorama, 0.0).unwrap());
    }
}

/// A wide slab between z = 0 and z = `thickness`, its front outside.
fn slab(thickness: f32) -> Mesh {
    let mut box_of_glass = Stage::default();
    let group = box_of_glass.group(Material::diffuse(Rgb::ZERO), Rgb::ZERO);
    box_of_glass.room(group, Vec3::new(50.0, 50.0, 0.5 * thickness));
    let mut mesh = Mesh::default();
    for object in &box_of_glass.scene.objects {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(object.mesh.positions.iter().map(|p| *p + 0.5 * thickness * Vec3::Z));
        // Outwards.
        mesh.normals.extend(object.mesh.normals.iter().map(|n| -*n));
        let turned =
            object.mesh.triangles.iter().map(|[a, b, c]| [a + first, c + first, b + first]);
        mesh.triangles.extend(turned);
    }
    assert!(mesh.is_closed());
    mesh
}

/// A lamp of radiance one that a camera at z = 5 sees behind the origin, at an angle of the cosine `cos` to the z axis.
fn lamp_behind(stage: &mut Stage, cos: f32) -> (unrender_scene::Camera, Rgb) {
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::ONE);
    let towards = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, -cos);
    let [x, y] = [Vec3::Y, Vec3::Y.cross(towards)].map(|v| 20.0 * v);
    stage.plate(lamp, 60.0 * towards, x, y);
    let eye = -5.0 * towards;
    (camera(eye, eye + towards, 0.002), Rgb::ONE)
}

/// A ball that reflects and emits so that it is as bright as its surroundings, in glass of every kind: the picture is white.
#[test]
fn a_furnace_with_glass_is_white() {
    for seen in [Vec3::ZERO, Vec3::new(0.4, 0.1, 0.0)] {
        let mut stage = Stage::default();
        stage.sky(Rgb::ONE);
        let reflected = Rgb::new(0.3, 0.6, 0.8);
        let group = stage.group(Material::diffuse(reflected), Rgb::ONE - reflected);
        stage.sphere(group, Vec3::ZERO, 0.3, 12);
        let gloss = Material::plastic(Rgb::splat(0.5), IOR, unrender_scene::Layering::Coupled, 0.0);
        let gloss = stage.group(Material { rho_s: Rgb::ONE, ..gloss }, Rgb::ZERO);
        stage.sphere(gloss, Vec3::new(0.0, -0.65, 0.0), 0.2, 12);
        stage.glass(Glass::solid(IOR), Mesh::sphere(Vec3::ZERO, 0.5));
        stage.glass(Glass::solid(1.3), Mesh::sphere(Vec3::new(0.4, 0.1, 0.6), 0.3));
        stage.pane(Glass::pane(IOR), Vec3::new(0.0, 0.0, 1.2), Vec3::X, Vec3::Y);
        stage.pane(Glass::pane(2.0), Vec3::new(0.9, 0.0, 0.0), Vec3::Z, Vec3::Y);
        let film = stage.render(&camera(Vec3::new(0.2, 0.3, 3.0), seen, 0.6), 12, settings(256));
        // A smooth plastic over a base that absorbs is no furnace: it is left out by its brightness.
        let pixels: Vec<_> = film.mean.pixels().iter().zip(film.variance.pixels()).collect();
        let off = pixels.iter().filter(|(mean, variance)| {
            let sigma = variance.max_element().sqrt();
            (**mean - Rgb::ONE).abs().max_element() > 4.5 * sigma + 1e-4
        });
        let off = off.count();
        assert!(off * 4 < pixels.len(), "{off} of {}", pixels.len());
        let whole = Estimate::of_film(&film);
        assert!(whole.sigma.max_element() < 0.01, "{whole:?}");
    }
}

/// `(1 - r)/(1 + r)` of a slab or a pane, whatever the angle; with absorption the geometric series of what is left.
#[test]
fn slabs_and_panes_let_through_what_the_series_says() {
    for cos in [1.0f32, 0.8, 0.45] {
        let r = fresnel(cos, IOR);
        let expected = Rgb::splat((1.0 - r) / (1.0 + r));
        for glass in [Glass::pane(IOR), Glass::solid(IOR)] {
            let mut stage = Stage::default();
            let (camera, _) = lamp_behind(&mut stage, cos);
            match glass.is_thin {
                true => stage.pane(glass, Vec3::ZERO, 50.0 * Vec3::X, 50.0 * Vec3::Y),
                false => stage.glass(glass, slab(0.2)),
            }
            let found = Estimate::of_film(&stage.render(&camera, 4, settings(4096)));
            assert_agree("plain", found, Estimate::exactly(expected), 0.01);
        }
        let (absorption, thickness) = (Rgb::new(0.0, 1.0, 3.0), 0.2);
        let mut stage = Stage::default();
        let (camera, _) = lamp_behind(&mut stage, cos);
        stage.glass(Glass { absorption, ..Glass::solid(IOR) }, slab(thickness));
        let cos_inside = (1.0 - (1.0 - cos * cos) / (IOR * IOR)).sqrt();
        let left = (-absorption * thickness / cos_inside).exp();
        let expected = (1.0 - r).powi(2) * left / (Rgb::ONE - r * r * left * left);
        let found = Estimate::of_film(&stage.render(&camera, 4, settings(4096)));
        assert_agree("absorbing", found, Estimate::exactly(expected), 0.01);
    }
}

/// Two panes of the reflectance R reflect to and fro between them: `(1 - R)/(1 + R)`.
#[test]
fn light_goes_to_and_fro_between_two_panes() {
    let glass = Glass { tint: Rgb::new(1.0, 0.8, 0.5), ..Glass::pane(IOR) };
    let mut stage = Stage::default();
    let (camera, _) = lamp_behind(&mut stage, 1.0);
    for z in [0.0, 1.0] {
        stage.pane(glass, z * Vec3::Z, 50.0 * Vec3::X, 50.0 * Vec3::Y);
    }
    let reflected = glass.reflected(1.0);
    let passed = (1.0 - reflected) * glass.tint;
    let expected = passed * passed / (1.0 - reflected * reflected);
    let found = Estimate::of_film(&stage.render(&camera, 4, settings(4096)));
    assert_agree("two panes", found, Estimate::exactly(expected), 0.01);
}

/// A ray that meets a ball of glass at the height `b` leaves it turned by twice the difference of its two angles.
#[test]
fn a_ball_of_glass_bends_rays_as_snell_says() {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::ONE), Rgb::ONE);
    let far = 10.0;
    stage.plate(wall, far * Vec3::NEG_Z, 40.0 * Vec3::X, 40.0 * Vec3::Y);
    stage.glass(Glass::solid(IOR), Mesh::sphere(Vec3::ZERO, 1.0));
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let transport = Transport::new(&tracer, (&materials).into(), 4);
    for b in [0.0f32, 0.2, 0.4, 0.6] {
        let ray = Ray::new(Vec3::new(b, 0.0, 5.0), Vec3::NEG_Z);
        let shown = transport.shown(&ray).unwrap().point;
        let (outside, inside) = (b.asin(), (b / IOR).asin());
        let turned = 2.0 * (outside - inside);
        // Where it leaves the ball: at the angle `pi - 2 inside` around from where it entered.
        let around = outside - turned;
        let leaves = Vec3::new(around.sin(), 0.0, -around.cos());
        let expected = leaves.x - (far + leaves.z) * turned.tan();
        assert!((shown.x - expected).abs() < 0.05, "{b}: {} is not {expected}", shown.x);
    }
}

/// A floor under a pane: light samples pass it, and both ways to find a lamp add up to one.
fn floor_under(glass: Glass, light: Option<LightKind>, z: f32) -> Stage {
    let mut stage = Stage::default();
    let floor = stage.group(Material::diffuse(Rgb::splat(0.5)), Rgb::ZERO);
    stage.plate(floor, Vec3::ZERO, 3.0 * Vec3::X, 3.0 * Vec3::NEG_Z);
    match light {
        Some(kind) => stage.light(kind),
        None => {
            let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(2.0));
            stage.plate(lamp, z * Vec3::Y, Vec3::X, Vec3::Z);
        }
    }
    match glass.is_thin {
        true => stage.pane(glass, Vec3::Y, 40.0 * Vec3::X, 40.0 * Vec3::Z),
        false => {
            let mut body = slab(0.2);
            let lay = |v: &Vec3| Vec3::new(v.x, v.z, -v.y);
            body.positions = body.positions.iter().map(|p| lay(p) + Vec3::Y).collect();
            body.normals = body.normals.iter().map(lay).collect();
            stage.glass(glass, body);
        }
    }
    stage
}

#[test]
fn lamps_shine_through_panes_as_through_slabs() {
    let view = camera(Vec3::new(0.0, 0.8, 1.5), Vec3::ZERO, 0.3);
    let tint = Rgb::new(1.0, 0.6, 0.2);
    let pane = floor_under(Glass { tint, ..Glass::pane(IOR) }, None, 2.0);
    // Light passes two faces of a slab, which shifts it by less than its thickness.
    let slab = floor_under(Glass { tint: tint.map(f32::sqrt), ..Glass::solid(IOR) }, None, 2.067);
    let found = Estimate::of_film(&pane.render(&view, 12, settings(512)));
    let expected = Estimate::of_film(&slab.render(&view, 12, settings(4096)));
    // What is reflected to and fro inside a slab passes the colour more often.
    assert!(
        (found.mean / expected.mean - 1.0).abs().max_element() < 0.03,
        "{found:?} {expected:?}"
    );
    // The floor without the pane, times what passes it straight, is near.
    let open = floor_under(Glass::pane(1.0), None, 2.0);
    let open = Estimate::of_film(&open.render(&view, 12, settings(512)));
    let passed = found.mean / open.mean;
    assert!((passed.x - 0.92).abs() < 0.02 && passed.z < 0.25, "{passed}");
}

/// Lights without an extent pass solid glass as if it did not bend light.
#[test]
fn lights_without_an_extent_shine_through_solid_glass() {
    let sun = LightKind::Directional { direction: Vec3::NEG_Y, irradiance: Rgb::ONE };
    let view = camera(Vec3::new(0.0, 0.8, 1.5), Vec3::ZERO, 0.3);
    for glass in [Glass::solid(IOR), Glass::pane(IOR)] {
        let stage = floor_under(glass, Some(sun.clone()), 0.0);
        let found =
            Estimate::of_film(&stage.render(&view, 8, Settings { max_bounces: 1, ..settings(64) }));
        let r = fresnel(1.0, IOR);
        let passed = if glass.is_thin { (1.0 - r) / (1.0 + r) } else { (1.0 - r) * (1.0 - r) };
        let expected = 0.5 * std::f32::consts::FRAC_1_PI * passed;
        assert_agree("sun", found, Estimate::exactly(Rgb::splat(expected)), 0.01);
    }
}

/// A room with a pane before its lamp, a ball of glass, a mirror and a glossy ball.
fn room() -> (Stage, unrender_scene::Camera) {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(Rgb::new(0.7, 0.6, 0.5)), Rgb::ZERO);
    stage.room(wall, Vec3::splat(1.0));
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(2.0));
    stage.plate(lamp, 0.9 * Vec3::Y, 0.8 * Vec3::X, 0.8 * Vec3::Z);
    let mirror = stage.group(Material::mirror(Rgb::splat(0.9)), Rgb::ZERO);
    stage.plate(mirror, Vec3::new(0.0, 0.0, -0.95), 0.5 * Vec3::X, 0.5 * Vec3::Y);
    let gloss = stage.group(Material::isotropic(Rgb::splat(0.3), Rgb::splat(0.3), 0.3), Rgb::ZERO);
    stage.sphere(gloss, Vec3::new(-0.4, -0.6, 0.0), 0.3, 12);
    let tint = Rgb::new(0.9, 0.6, 0.4);
    stage.pane(Glass { tint, ..Glass::pane(IOR) }, 0.7 * Vec3::Y, 0.6 * Vec3::X, 0.6 * Vec3::Z);
    stage.glass(Glass::solid(IOR), Mesh::sphere(Vec3::new(0.4, -0.6, 0.1), 0.3));
    (stage, camera(Vec3::new(0.0, 0.0, 0.9), Vec3::new(0.0, -0.3, 0.0), 1.2))
}

const PIXELS: [u32; 6] = [17, 40, 75, 100, 110, 130];

#[test]
fn stored_paths_through_glass_are_the_traced_ones_and_their_derivatives_the_differences() {
    let (stage, view) = room();
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let drawn = settings(256);
    let parameters = [Parameter::RhoD(0), Parameter::RhoS(3), Parameter::RhoS(2)];
    let query = Query { parameters: &parameters, ..Query::new(&materials, &PIXELS, &drawn) };
    let paths = tracer.store(&view, (12, 12), &query);
    let replayed = paths.replay(&tracer, &materials, &parameters, None);
    let traced = tracer.jacobian(&view, (12, 12), &query);
    for (a, b) in replayed.radiance.iter().zip(&traced.radiance) {
        assert!((*a - *b).abs().max_element() < 1e-4 * b.max_element(), "{a} {b}");
    }
    let step = 1e-2;
    for (place, (group, is_base)) in [(0, true), (3, false), (2, false)].into_iter().enumerate() {
        let at = |sign: f32| {
            let mut moved = materials.clone();
            let material = &mut moved[group];
            let value = if is_base { &mut material.rho_d } else { &mut material.rho_s };
            *value += sign * step;
            paths.replay(&tracer, &moved, &[], None).radiance
        };
        let (above, below) = (at(1.0), at(-1.0));
        for pixel in 0..PIXELS.len() {
            let difference = (above[pixel] - below[pixel]) / (2.0 * step);
            let derivative = replayed.derivatives[pixel * parameters.len() + place];
            let off = (difference - derivative).abs().max_element();
            assert!(
                off < 0.02 * derivative.abs().max_element() + 1e-4,
                "{place} {pixel}: {difference} {derivative}"
            );
        }
    }
}

/// Light that a probe gathers is what a diffuse surface reflects, through panes and from balls of glass.
#[test]
fn probes_through_glass_gather_what_paths_bring() {
    let (stage, view) = room();
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    let gathering = ProbeSettings { probes_per_pixel: 64, cosine: 64, ..ProbeSettings::default() };
    // Pixels that show the walls alone, not through glass.
    let mut opaque = stage.scene.clone();
    for shape in std::mem::take(&mut opaque.ungrouped) {
        opaque.objects.push(Object { name: "glass".into(), group: 1, mesh: shape.mesh });
    }
    let all: Vec<u32> = (0..144).collect();
    let query = Query::new(&materials, &all, &gathering);
    let seen = Tracer::new(&opaque).probe(&view, (12, 12), &query).probes;
    let shows_walls = |pixel: &u32| {
        seen.iter().filter(|probe| probe.pixel == *pixel).all(|probe| probe.group == 0)
    };
    let walls: Vec<u32> = all.into_iter().filter(shows_walls).collect();
    assert!(walls.len() > 20, "{}", walls.len());
    let query = Query::new(&materials, &walls, &gathering);
    let probes = tracer.probe(&view, (12, 12), &query);
    let samples: Vec<_> = probes
        .probes
        .iter()
        .map(|probe| (probe.throughput * materials[0].rho_d * probe.diffuse).as_dvec3())
        .collect();
    let drawn = settings(1024);
    let estimates = tracer.render_pixels(&materials, &view, (12, 12), &walls, &drawn);
    let mean =
        estimates.iter().map(|(mean, _)| mean.as_dvec3()).sum::<glam::DVec3>() / walls.len() as f64;
    let variance = estimates.iter().map(|(_, v)| v.as_dvec3()).sum::<glam::DVec3>()
        / (walls.len() as f64).powi(2);
    let traced = Estimate { mean, sigma: variance.map(f64::sqrt) };
    assert_agree("walls", Estimate::of_samples(&samples), traced, 0.02);
}

/// A picture with glass is never one of connected paths, and mirrors that show the lamp through panes count it once.
#[test]
fn every_way_to_render_a_room_with_glass_agrees() {
    let (stage, view) = room();
    let alone = Estimate::of_film(&stage.render(&view, 12, settings(1024)));
    let connected = Settings { integrator: Integrator::PathReuse, seed: 5, ..settings(1024) };
    assert_agree("connected", Estimate::of_film(&stage.render(&view, 12, connected)), alone, 0.02);
    // Without virtual lamps: a mirror of the least roughness that is a lobe.
    let mut rough = room().0;
    rough.scene.groups[2].material = Material::isotropic(Rgb::ZERO, Rgb::splat(0.9), 1e-3);
    let rough = Estimate::of_film(&rough.render(&view, 12, Settings { seed: 9, ..settings(1024) }));
    let off = (rough.mean / alone.mean - 1.0).abs().max_element();
    let noise = (rough.sigma / rough.mean).max_element() + (alone.sigma / alone.mean).max_element();
    assert!(off < 4.5 * noise + 0.002, "{off} {noise}");
}

/// Without triangles of groups before it a ray still ends, and a scene of glass alone has no surface.
#[test]
fn glass_that_reflects_for_ever_ends() {
    let mut stage = Stage::default();
    stage.sky(Rgb::ONE);
    let group = stage.group(Material::diffuse(Rgb::ONE), Rgb::ZERO);
    stage.plate(group, 9.0 * Vec3::NEG_Z, Vec3::X, Vec3::Y);
    // Panes of a huge index reflect nearly everything.
    for z in 0..40 {
        stage.pane(Glass::pane(1e6), 0.1 * z as f32 * Vec3::Z, Vec3::X, Vec3::Y);
    }
    let film = stage.render(&camera(4.5 * Vec3::Z, Vec3::ZERO, 0.2), 4, settings(64));
    assert!(film.mean.pixels().iter().all(|p| p.is_finite()));
    let nothing = Scene { objects: Vec::new(), ..stage.scene };
    assert!(Tracer::try_new(&nothing).is_ok());
}
