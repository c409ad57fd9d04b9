//! Normal maps and holes: against meshes that have the same shape in triangles.

use crate::common::{Estimate, Stage, assert_agree, camera, quad_mesh, settings};
use glam::{Quat, Vec2, Vec3, Vec4};
use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;
use unrender_render::{Integrator, Settings};
use unrender_scene::{Coverage, Image, LightKind, Mapped, Material, Mesh, NormalMap, Rgb, Wrap};

/// The corners of a square of side two in the plane z = 0 that faces +z, and the coordinates of a picture upon it.
const CORNERS: [Vec3; 4] = [
    Vec3::new(-1.0, -1.0, 0.0),
    Vec3::new(1.0, -1.0, 0.0),
    Vec3::new(1.0, 1.0, 0.0),
    Vec3::new(-1.0, 1.0, 0.0),
];
const UPRIGHT: [Vec2; 4] =
    [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)];

fn everywhere(normal: Vec3, shades_itself: bool) -> Option<Arc<NormalMap>> {
    let image = Image::new(1, 1, vec![normal]);
    let normals = Mapped { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    Some(Arc::new(NormalMap { normals, shades_itself }))
}

/// A square lit by the sun along `light`, of `mesh`.
fn lit(mesh: Mesh, light: Vec3, material: Material) -> Rgb {
    let mut stage = Stage::default();
    let group = stage.group(material, Rgb::ZERO);
    stage.mesh(group, mesh);
    stage.light(LightKind::Directional { direction: light, irradiance: Rgb::ONE });
    let view = camera(Vec3::new(0.3, 0.2, 3.0), Vec3::ZERO, 0.2);
    stage.render(&view, 1, settings(16)).mean.pixels()[0]
}

fn squares() -> [Mesh; 3] {
    let upright = quad_mesh(CORNERS, &UPRIGHT);
    // The picture's columns from right to left.
    let mirrored = quad_mesh(CORNERS, &UPRIGHT.map(|uv| Vec2::new(1.0 - uv.x, uv.y)));
    let mut stated = quad_mesh(CORNERS, &UPRIGHT);
    stated.tangents = vec![Vec4::new(0.0, 1.0, 0.0, -1.0); stated.positions.len()];
    [upright, mirrored, stated]
}

/// A map of one tilted normal is a mesh with that shading normal, whichever way its picture lies.
#[test]
fn a_normal_map_tilts_as_its_tangents_say() {
    let tilt = Vec3::new(0.3, 0.4, 1.0).normalize();
    let [upright, mirrored, stated] = squares();
    let world = [
        (upright, tilt),
        (mirrored, Vec3::new(-tilt.x, tilt.y, tilt.z)),
        // Along +y, and with the handedness -1 upwards along +x.
        (stated, Vec3::new(tilt.y, tilt.x, tilt.z)),
    ];
    let gloss = Material::isotropic(Rgb::splat(0.4), Rgb::splat(0.3), 0.4);
    for (mesh, expected) in world {
        for light in [Vec3::NEG_Z, Vec3::new(-0.6, 0.1, -1.0), Vec3::new(0.2, -0.7, -1.0)] {
            let mut mapped = mesh.clone();
            mapped.detail.normals = everywhere(tilt, false);
            let mut shaded = mesh.clone();
            shaded.normals.fill(expected);
            let [a, b] = [mapped, shaded].map(|mesh| lit(mesh, light.normalize(), gloss.clone()));
            assert!((a - b).abs().max_element() < 1e-5, "{expected} {light}: {a} {b}");
        }
    }
}

/// Edges of the model are those of its mesh: the buffers do not know the bumps.
#[test]
fn buffers_have_the_normals_of_the_mesh() {
    let mut stage = Stage::default();
    let group = stage.group(Material::diffuse(Rgb::ONE), Rgb::ZERO);
    let mut mesh = quad_mesh(CORNERS, &UPRIGHT);
    mesh.detail.normals = everywhere(Vec3::new(0.8, 0.0, 0.6), true);
    stage.mesh(group, mesh);
    stage.light(LightKind::Directional { direction: Vec3::NEG_Z, irradiance: Rgb::ONE });
    let seen = stage.tracer().geometry(&camera(3.0 * Vec3::Z, Vec3::ZERO, 0.2), 1, 1);
    assert_eq!(seen.pixels()[0].normal, Vec3::Z);
}

/// Light that grazes the mesh leaves bumps dark, as the published factor says.
#[test]
fn bumps_shade_themselves() {
    let tilt = Quat::from_rotation_y(0.6) * Vec3::Z;
    for angle in [-1.2f32, -0.3, 0.0, 0.5, 1.0, 1.3, 1.5] {
        let towards = Quat::from_rotation_y(angle) * Vec3::Z;
        let mut mesh = quad_mesh(CORNERS, &UPRIGHT);
        mesh.detail.normals = everywhere(tilt, true);
        let cos = tilt.dot(towards).max(0.0);
        let g = towards.z / (tilt.dot(towards) * tilt.z);
        let kept = if g < 1.0 { g + g * g - g * g * g } else { 1.0 };
        let found = lit(mesh, -towards, Material::diffuse(Rgb::ONE)).x;
        assert!((found - FRAC_1_PI * cos * kept).abs() < 1e-4, "{angle}: {found} {cos} {kept}");
    }
}

/// A leaf: its middle is there, what lies around it is not.
fn leaf(half: f32) -> Mesh {
    let (size, edge) = (16, 0.5 * (1.0 - half));
    let image = Image::from_fn(size, size, |x, y| {
        let inside = |at: usize| {
            let place = (at as f32 + 0.5) / size as f32;
            place > edge && place < 1.0 - edge
        };
        f32::from(u8::from(inside(x) && inside(y)))
    });
    let alpha = Mapped { image, wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::ClampToEdge };
    let mut mesh = quad_mesh(CORNERS, &UPRIGHT);
    mesh.detail.coverage = Some(Arc::new(Coverage { alpha, cutoff: 0.5 }));
    mesh
}

/// A floor below a leaf, or below a square of the size of what is there of it.
fn below(leaf_of: Mesh) -> Stage {
    let mut stage = Stage::default();
    let floor = stage.group(Material::isotropic(Rgb::splat(0.4), Rgb::splat(0.2), 0.2), Rgb::ZERO);
    stage.plate(floor, Vec3::NEG_Z, 3.0 * Vec3::X, 3.0 * Vec3::Y);
    let green = stage.group(Material::diffuse(Rgb::new(0.1, 0.5, 0.1)), Rgb::ZERO);
    stage.mesh(green, leaf_of);
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::splat(3.0));
    stage.plate(lamp, 2.0 * Vec3::Z, Vec3::Y, Vec3::X);
    stage
}

#[test]
fn holes_let_light_and_sight_through() {
    let small = quad_mesh(CORNERS.map(|corner| 0.5 * corner), &[]);
    let [cut, cast] = [below(leaf(0.5)), below(small)];
    let view = camera(Vec3::new(1.0, 0.5, 1.5), Vec3::new(0.0, 0.0, -0.5), 1.0);
    let side = 24;
    let [a, b] = [&cut, &cast].map(|stage| stage.tracer().geometry(&view, side, side));
    assert_eq!(a.pixels().iter().map(|p| p.group).collect::<Vec<_>>(), b.map(|p| p.group).pixels());
    let expected = Estimate::of_film(&cast.render(&view, side, settings(512)));
    for integrator in [Integrator::Path, Integrator::PathReuse] {
        let settings = Settings { integrator, seed: 7, ..settings(512) };
        let found = Estimate::of_film(&cut.render(&view, side, settings));
        assert_agree("holes", found, expected, 0.01);
    }
}

/// A lamp has no holes: what lights and what is seen of it are the same.
#[test]
fn lamps_are_whole() {
    let mut stage = Stage::default();
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::ONE);
    stage.mesh(lamp, leaf(0.5));
    let film = stage.render(&camera(3.0 * Vec3::Z, Vec3::ZERO, 0.6), 9, settings(4));
    assert!(film.mean.pixels().iter().all(|pixel| *pixel == Rgb::ONE), "{:?}", film.mean.pixels());
}

/// A scene whose every triangle has holes has nothing opaque.
#[test]
fn a_leaf_alone_is_a_scene() {
    let mut stage = Stage::default();
    let green = stage.group(Material::diffuse(Rgb::ONE), Rgb::ZERO);
    stage.mesh(green, leaf(0.5));
    stage.light(LightKind::Directional { direction: Vec3::NEG_Z, irradiance: Rgb::ONE });
    let film = stage.render(&camera(3.0 * Vec3::Z, Vec3::ZERO, 0.6), 9, settings(4));
    assert!(film.mean.at(4, 4).x > 0.3 && film.mean.at(0, 4).x == 0.0, "{:?}", film.mean.pixels());
}
