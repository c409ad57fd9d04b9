//! Planes, lamps, pairs of them, and the lobes towards mirror images.

use super::four_pairs::ImageLobe;
use super::*;
use crate::test_meshes::{cuboid, merged, quad};
use unrender_scene::{Group, Light, Material, Object};

const UP: [Vec3; 2] = [Vec3::Z, Vec3::X];
const DOWN: [Vec3; 2] = [Vec3::X, Vec3::Z];

/// A group per mesh, with the given specular reflectance and emission.
fn scene(parts: Vec<(Mesh, f32, f32)>) -> Scene {
    let mut scene = Scene::default();
    for (group, (mesh, rho_s, emission)) in parts.into_iter().enumerate() {
        let material = Material::isotropic(Rgb::splat(0.1), Rgb::splat(rho_s), 0.1);
        let (name, emission) = (String::new(), Rgb::splat(emission));
        scene.groups.push(Group { name: name.clone(), material, emission });
        scene.objects.push(Object { name, group, mesh });
    }
    scene
}

fn guide(scene: &Scene) -> SpecularGuide {
    let (groups, punctual) = (scene.groups.len() as u32, scene.lights.len() as u32);
    SpecularGuide::new(scene, SourceLayout::new(groups, punctual, None))
}

fn pairs(scene: &Scene) -> Vec<GlossyPair> {
    guide(scene).pairs(&(&scene.materials()).into())
}

#[test]
fn flat_meshes_are_planes_and_no_others() {
    let floor = || quad(Vec3::ZERO, UP);
    let mut double_sided = floor();
    double_sided.triangles.extend([[2, 1, 0], [5, 4, 3]]);
    // Its first triangle has no area, so its flat normals point anywhere.
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, 2.0 * Vec3::X];
    let with_a_needle = Mesh::flat(&corners, &[], &[[0, 1, 3], [0, 1, 2]]);
    let unused = Mesh { triangles: Vec::new(), ..quad(7.0 * Vec3::Y, DOWN) };
    for (name, mesh) in [
        ("quad", floor()),
        ("turned", quad(Vec3::splat(7.0), [Vec3::new(1.0, 0.2, 0.3), Vec3::Y])),
        ("two quads", merged([floor(), quad(4.0 * Vec3::X, UP)])),
        ("double sided", double_sided),
        ("needle", with_a_needle),
        ("unused corners", merged([floor(), unused])),
    ] {
        let plane = Plane::of(&mesh).unwrap_or_else(|| panic!("{name} is a plane"));
        assert!((plane.normal.length() - 1.0).abs() < 1e-6, "{name}");
    }
    assert!((Plane::of(&floor()).map_or(0.0, |plane| plane.area) - 4.0).abs() < 1e-6);

    let mut bent = floor();
    bent.positions[2].y += 0.05;
    let mut smooth = floor();
    smooth.normals[0] = Vec3::new(0.3, 1.0, 0.0).normalize();
    let ball = {
        let mut mesh = cuboid(Vec3::ZERO, Vec3::ONE);
        mesh.normals = mesh.positions.iter().map(|p| p.normalize()).collect();
        mesh.positions.clone_from(&mesh.normals);
        mesh
    };
    for (name, mesh) in [
        ("bent", bent),
        ("shaded as if bent", smooth),
        ("ball", ball),
        ("box", cuboid(Vec3::ZERO, Vec3::ONE)),
        ("thin box", cuboid(Vec3::ZERO, Vec3::new(1.0, 1e-3, 1.0))),
        ("two floors", merged([floor(), quad(0.01 * Vec3::Y, UP)])),
        ("no triangles", Mesh::default()),
        ("no area", without_area()),
    ] {
        assert!(Plane::of(&mesh).is_none(), "{name} is no plane");
    }
}

fn without_area() -> Mesh {
    Mesh::flat(&[Vec3::ONE; 3], &[], &[[0, 1, 2]])
}

#[test]
fn pairs_are_glossy_planes_with_lamps_that_emit_towards_them() {
    let floor = |rho_s| (quad(Vec3::ZERO, UP), rho_s, 0.0);
    let lamp = |height: f32, facing| (quad(height * Vec3::Y, facing), 0.0, 5.0);
    for (count, parts) in [
        (1, vec![floor(0.5), lamp(1.0, DOWN)]),
        (2, vec![floor(0.5), lamp(1.0, DOWN), lamp(-1.0, UP)]),
        // Dull, facing away, in the plane, dark, without an area.
        (0, vec![floor(0.0), lamp(1.0, DOWN)]),
        (0, vec![floor(0.5), lamp(1.0, UP)]),
        (0, vec![floor(0.5), lamp(0.0, UP)]),
        (0, vec![floor(0.5), (quad(Vec3::Y, DOWN), 0.0, 0.0)]),
        (0, vec![floor(0.5), (without_area(), 0.0, 5.0)]),
        (0, vec![floor(0.5), (Mesh::default(), 0.0, 5.0)]),
        // A glossy lamp does not reflect itself, but other lamps.
        (0, vec![(quad(Vec3::ZERO, UP), 0.5, 5.0)]),
        (1, vec![(quad(Vec3::ZERO, UP), 0.5, 5.0), lamp(1.0, DOWN)]),
    ] {
        assert_eq!(pairs(&scene(parts)).len(), count);
    }
}

#[test]
fn point_lights_are_lamps_and_spots_within_their_cone() {
    let (position, intensity) = (Vec3::Y, Rgb::ONE);
    let spot = |direction| LightKind::Spot {
        position,
        direction,
        intensity,
        inner_rad: 0.1,
        outer_rad: 0.5,
    };
    for (count, kind) in [
        (1, LightKind::Point { position, intensity }),
        (0, LightKind::Point { position, intensity: Rgb::ZERO }),
        (1, spot(Vec3::NEG_Y)),
        (0, spot(Vec3::Y)),
        (0, LightKind::Directional { direction: Vec3::NEG_Y, irradiance: intensity }),
    ] {
        let mut scene = scene(vec![(quad(Vec3::ZERO, UP), 0.5, 0.0)]);
        scene.lights.push(Light { name: String::new(), kind: kind.clone() });
        assert_eq!(pairs(&scene).len(), count, "{kind:?}");
    }
}

#[test]
fn the_strongest_pairs_are_kept_and_dark_lamps_make_none() {
    let mut parts = Vec::new();
    for i in 0..40 {
        let aside = 5.0 * i as f32 * Vec3::X;
        parts.push((quad(aside, UP), 0.02 * i as f32, 0.0));
        parts.push((quad(aside + Vec3::Y, DOWN), 0.0, (i + 1) as f32));
    }
    let scene = scene(parts);
    let found = pairs(&scene);
    assert_eq!(found.len(), PAIRS_MAX);
    let strongest = (found[0].plane.group, found[0].lamp.source);
    assert_eq!(strongest, (78, LightSource::Group(79)));
    let materials = scene.materials();
    let lights = vec![Rgb::ZERO; scene.groups.len()];
    let appearance = Appearance { materials: &materials, lights: &lights };
    assert!(guide(&scene).pairs(&appearance).is_empty());
}

/// A point of a wall that faces +z.
fn wall(point: Vec3) -> Surface {
    let frame = Frame::new(Vec3::Z, Vec3::X, true);
    let (geometric_normal, uv) = (Vec3::Z, glam::Vec2::ZERO);
    let (triangle, object, group, front, clearance) = (0, 9, 9, true, 0.0);
    let (to_viewer, mesh_normal, shades_itself) = (geometric_normal, frame.normal, false);
    Surface {
        point,
        triangle,
        object,
        group,
        front,
        geometric_normal,
        clearance,
        frame,
        uv,
        to_viewer,
        mesh_normal,
        shades_itself,
    }
}

#[test]
fn lobes_point_to_the_mirror_image_of_the_lamp() {
    let lamp = (quad(Vec3::Y, [0.1 * Vec3::X, 0.1 * Vec3::Z]), 0.0, 5.0);
    let found = pairs(&scene(vec![(quad(Vec3::ZERO, UP), 0.5, 0.0), lamp]));
    let four = FourPairs::all(&found);
    let at = |point: Vec3| four[0].lobes(&wall(point)).next();
    let lobe = at(Vec3::new(0.0, 1.0, -0.9)).expect("the floor reflects the lamp");
    let ImageLobe { direction, deviation } = lobe;
    assert!((direction - Vec3::new(0.0, -2.0, 0.9).normalize()).length() < 1e-6);
    // sqrt 2 alpha / 2, and the radius of the lamp in quadrature.
    assert!(deviation > 0.0707 && deviation < 0.09, "{deviation}");
    // Below the floor, on it, too far for it, and with the back to it.
    assert_eq!(at(Vec3::new(0.0, -1.0, -0.9)), None);
    assert_eq!(at(Vec3::new(0.0, 0.0, -0.9)), None);
    assert_eq!(at(Vec3::new(0.0, 1.0, -9.0)), None);
    assert_eq!(at(Vec3::new(0.0, 1.0, 0.9)), None);
    // Extreme positions give finite lobes or none.
    for odd in [f32::NAN, f32::INFINITY, f32::MAX, 1e30, f32::MIN_POSITIVE] {
        for point in Vec3::AXES.map(|axis| odd * axis - 0.9 * Vec3::Z) {
            let lobe = at(point);
            let finite = |l: ImageLobe| l.direction.is_finite() && l.deviation.is_finite();
            assert!(lobe.is_none_or(finite), "{lobe:?}");
        }
    }
}

#[test]
fn the_weights_of_all_bounces_together_are_bounded() {
    // The weight of a path whose directions are all drawn by the cosine, longer than any real path.
    let weight: f32 = (0..1000).map(|bounce| 1.0 / (1.0 - share(bounce))).product();
    assert!((1.9..3.1).contains(&weight), "{weight}");
}

/// The lobe of one pair at `surface`, as the module's description has it.
fn lobe(pair: &GlossyPair, surface: &Surface) -> Option<ImageLobe> {
    let GlossyPair { plane, alpha, lamp } = pair;
    let height = |point: Vec3| (point - plane.point).dot(plane.normal);
    let (here, there) = (height(surface.point), height(lamp.centre));
    if surface.object == plane.object || here * there <= 0.0 {
        return None;
    }
    let to_image = lamp.centre - 2.0 * there * plane.normal - surface.point;
    let (distance, direction) = (to_image.length(), to_image.normalize());
    let (to_plane, to_lamp) = (distance * here / (here + there), distance * there / (here + there));
    let hit = surface.point + to_plane * direction;
    let of_gloss = std::f32::consts::SQRT_2 * alpha / (1.0 + to_plane / to_lamp);
    let deviation = of_gloss.hypot(0.5 * lamp.radius / distance);
    let outside = hit.distance(hit.clamp(plane.bounds[0], plane.bounds[1]));
    let is_there = surface.is_above(direction)
        && (DEVIATION_MIN..DEVIATION_MAX).contains(&deviation)
        && outside <= REACH * deviation * to_plane
        && (hit - lamp.centre).dot(lamp.cone.axis) >= lamp.cone.cos * hit.distance(lamp.centre);
    is_there.then_some(ImageLobe { direction, deviation })
}

#[test]
fn four_pairs_at_once_have_the_lobes_of_each() {
    let parts = [0.0, 2.5, 5.0].into_iter().flat_map(|aside| {
        let (aside, half) = (aside * Vec3::X, [0.3 * Vec3::X, 0.3 * Vec3::Z]);
        [(quad(aside, UP), 0.5, 0.0), (quad(aside + 1.5 * Vec3::Y, half), 0.0, 5.0)]
    });
    let mut scene = scene(parts.collect());
    let (intensity, direction) = (Rgb::ONE, Vec3::new(0.3, -1.0, 0.0).normalize());
    for position in [Vec3::new(1.0, 2.0, 0.5), Vec3::new(4.0, 1.0, -0.5)] {
        let kind =
            LightKind::Spot { position, direction, intensity, inner_rad: 0.1, outer_rad: 0.6 };
        scene.lights.push(Light { name: String::new(), kind });
    }
    let found = pairs(&scene);
    assert!(!found.len().is_multiple_of(4), "all lanes are full: {}", found.len());
    let four = FourPairs::all(&found);
    let mut count = 0;
    for k in 0..2000 {
        let [x, y, z, object] = sobol_burley::sample_4d(k, 0, 5);
        let point = Vec3::new(8.0 * x - 2.0, 3.0 * y - 0.5, 4.0 * z - 2.0);
        let surface = Surface { object: (6.0 * object) as u32, ..wall(point) };
        let expected: Vec<ImageLobe> =
            found.iter().filter_map(|pair| lobe(pair, &surface)).collect();
        let lobes: Vec<ImageLobe> = four.iter().flat_map(|four| four.lobes(&surface)).collect();
        assert_eq!(lobes.len(), expected.len(), "at {point}");
        for (a, b) in lobes.iter().zip(&expected) {
            assert!((a.direction - b.direction).length() < 1e-5, "{a:?} {b:?}");
            assert!((a.deviation - b.deviation).abs() < 1e-5, "{a:?} {b:?}");
        }
        count += lobes.len();
    }
    assert!(count > 1000, "{count}");
}
