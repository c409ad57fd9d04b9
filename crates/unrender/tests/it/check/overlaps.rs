//! Surfaces that overlap in one plane, and some that only seem to.

use super::Input;
use super::room::*;
use glam::{Quat, Vec3};
use unrender::scene::{Group, Material, Mesh, Object, Rgb, Scene};

/// The room with one more object, in a group of its own, both called `name`.
fn with(name: &str, mesh: Mesh, emission: Rgb) -> Scene {
    let mut scene = room();
    let group = scene.groups.len();
    let material = Material::diffuse(Rgb::splat(0.2));
    scene.groups.push(Group { name: name.into(), material, emission });
    scene.objects.push(Object { name: name.into(), group, mesh });
    scene.validate().unwrap();
    scene
}

/// The warnings that two surfaces lie in one plane.
fn told(scene: &Scene) -> Vec<String> {
    let told = Input::of_room(scene).check().warnings.0;
    told.into_iter().filter(|told| told.contains("in the plane of")).collect()
}

/// A rug on the floor, at this height.
fn rug(height: f32) -> Mesh {
    quad(Vec3::new(0.1, height, 0.0), 0.5 * Vec3::Z, 0.6 * Vec3::X)
}

#[test]
fn a_rug_at_the_height_of_the_floor_lies_in_front_of_it() {
    let told = told(&with("rug", rug(0.0), Rgb::ZERO));
    let expected = "\"rug\" lies in the plane of \"the floor\" and overlaps it: the smaller is taken to lie in front";
    assert_eq!(told, [expected]);
}

#[test]
fn a_floor_over_a_floor_of_its_size_is_told_with_the_distance_that_parts_them() {
    let mut scene = room();
    let double = Object { group: BLOCK, ..scene.objects[1].clone() };
    scene.objects.push(double);
    let told = told(&scene);
    assert_eq!(told.len(), 1, "{told:?}");
    // Four times 64 units in the last place of its largest coordinate.
    assert!(told[0].contains("Move it out by 0.03 mm or more"), "{}", told[0]);
}

#[test]
fn a_picture_in_the_plane_of_a_wall_that_is_turned_is_told() {
    let turn = Quat::from_rotation_y(0.7);
    let turned = |mut mesh: Mesh| {
        mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
        mesh.normals.iter_mut().for_each(|n| *n = turn * *n);
        mesh
    };
    let poster = quad(Vec3::new(-0.3, 1.1, -0.8), 0.5 * Vec3::X, 0.4 * Vec3::Y);
    let mut scene = with("poster", turned(poster), Rgb::ZERO);
    let wall = quad(Vec3::new(-0.6, 0.0, -0.8), 1.2 * Vec3::X, 1.8 * Vec3::Y);
    scene.objects[0].mesh = turned(wall);
    let told = told(&scene);
    assert!(told.len() == 1 && told[0].contains("\"the back_wall\""), "{told:?}");
}

#[test]
fn a_lamp_in_the_plane_of_the_ceiling_is_told_although_nobody_sees_it() {
    let ceiling = quad(Vec3::new(-1.0, 1.95, -1.0), 2.0 * Vec3::X, 2.0 * Vec3::Z);
    let told = told(&with("ceiling", ceiling, Rgb::ZERO));
    assert!(told.len() == 1 && told[0].contains("\"the lamp\" lies in the plane of"), "{told:?}");
}

#[test]
fn what_overlaps_a_wall_in_several_places_is_told_in_one_sentence() {
    let mut scene = with("first", rug(0.0), Rgb::ZERO);
    let mesh = quad(Vec3::new(-0.7, 0.0, 0.2), 0.4 * Vec3::Z, 0.5 * Vec3::X);
    scene.objects.push(Object { name: "second".into(), group: 5, mesh });
    let told = told(&scene);
    assert!(told.len() == 1 && told[0].starts_with("\"first\", \"second\" lie in"), "{told:?}");
}

#[test]
fn what_stands_on_a_floor_lies_above_it_or_beside_it_does_not_overlap_it() {
    let none: [String; 0] = [];
    // The lower side of the block lies on the floor.
    assert_eq!(told(&room()), none);
    assert_eq!(told(&with("rug", rug(0.003), Rgb::ZERO)), none);
    // A lamp whose upper side touches the ceiling.
    let ceiling = quad(Vec3::new(-1.0, 2.2, -1.0), 2.0 * Vec3::X, 2.0 * Vec3::Z);
    let mut scene = with("ceiling", ceiling, Rgb::ZERO);
    scene.objects[LAMP].mesh = cuboid(Vec3::new(-0.4, 2.1, -0.4), Vec3::new(0.4, 2.2, 0.4));
    assert_eq!(told(&scene), none);
    // Two halves of a floor, side by side.
    let half = |x: f32| quad(Vec3::new(x, 0.0, -1.0), 2.0 * Vec3::Z, Vec3::X);
    let mut scene = with("other half", half(0.0), Rgb::ZERO);
    scene.objects[1].mesh = half(-1.0);
    assert_eq!(told(&scene), none);
    // A ramp that crosses the floor.
    let ramp = quad(Vec3::new(0.0, -0.1, 0.0), 0.5 * Vec3::Z, Vec3::new(0.6, 0.2, 0.0));
    assert_eq!(told(&with("ramp", ramp, Rgb::ZERO)), none);
}
