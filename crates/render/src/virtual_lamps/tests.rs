//! Flat faces, and what they see.

use super::*;
use crate::accel::Accel;
use crate::emitters::TriangleEmission;
use crate::test_meshes::{cuboid, merged, quad};
use unrender_scene::{Group, Light, LightKind, Material, Mesh, Object, Rgb, Scene};

/// Mirrors under a light at a point, a group a mesh.
fn scene(meshes: Vec<Mesh>, position: Vec3) -> Scene {
    let mut scene = Scene::default();
    for (group, mesh) in meshes.into_iter().enumerate() {
        let name = format!("{group}");
        let material = Material::mirror(Rgb::splat(0.5));
        scene.groups.push(Group { name: name.clone(), material, emission: Rgb::ZERO });
        scene.objects.push(Object { name, group, mesh });
    }
    let kind = LightKind::Point { position, intensity: Rgb::ONE };
    scene.lights.push(Light { name: "light".into(), kind });
    scene
}

fn faces(mesh: Mesh) -> FlatFaces {
    FlatFaces::new(&scene(vec![mesh], Vec3::ZERO))
}

#[test]
fn a_box_and_a_table_of_one_mesh_have_their_sides_as_faces() {
    let found = faces(cuboid(Vec3::ZERO, Vec3::ONE));
    assert_eq!(found.all().len(), 6);
    assert!(found.all().iter().all(|face| (face.area - 4.0).abs() < 1e-5));
    // The two triangles of a side have one face.
    for side in 0..6 {
        assert!(found.of(2 * side).is_some() && found.of(2 * side) == found.of(2 * side + 1));
    }
    let top = cuboid(Vec3::Y, Vec3::new(1.0, 0.1, 1.0));
    let leg = cuboid(Vec3::ZERO, Vec3::new(0.02, 0.9, 0.02));
    let table = faces(merged([top, leg]));
    let large = table.all().iter().filter(|face| face.area > 3.9).count();
    assert_eq!(large, 2, "above and below");
}

#[test]
fn rounded_and_small_faces_are_none() {
    let mut smooth = quad(Vec3::ZERO, [Vec3::X, Vec3::Y]);
    smooth.normals[0] = Vec3::new(3e-3, 0.0, 1.0).normalize();
    let found = faces(smooth);
    assert!(found.of(0).is_none(), "one corner of its normals is turned");
    let small = quad(Vec3::Z, [0.1 * Vec3::X, 0.1 * Vec3::Y]);
    let found = faces(merged([quad(Vec3::ZERO, [Vec3::X, Vec3::Y]), small]));
    assert_eq!((found.all().len(), found.of(2)), (1, None));
}

/// The virtual lamps of a scene: the number of those in one mirror, and in two.
fn counts(scene: &Scene) -> [usize; 2] {
    let meshes = scene.objects.iter().map(|object| &object.mesh);
    let triangles: Vec<_> =
        meshes.flat_map(|mesh| (0..mesh.triangles.len()).map(|i| mesh.corners(i))).collect();
    let accel = Accel::build(&triangles);
    let dark = |_| TriangleEmission { group: 0, radiance: Rgb::ZERO };
    let groups = scene.groups.len() as u32;
    let emitters = Emitters::new(&triangles, dark, groups, &scene.lights, accel.bounds(), None);
    let faces = FlatFaces::new(scene);
    let materials = scene.materials();
    let lamps = VirtualLamps::new(&faces, &accel, &emitters, &(&materials).into());
    let of = |count: usize| {
        let chain = |lamp: &&VirtualLamp| lamps.chains[lamp.chain].mirrors().len() == count;
        lamps.lamps.iter().filter(|lamp| lamp.strength > 0.0).filter(chain).count()
    };
    [of(1), of(2)]
}

#[test]
fn faces_that_no_lamp_sees_are_not_asked() {
    // Of a box the sides that face the light, and no side by way of another.
    let cube = || cuboid(Vec3::ZERO, Vec3::ONE);
    assert_eq!(counts(&scene(vec![cube()], 3.0 * Vec3::Y)), [1, 0]);
    assert_eq!(counts(&scene(vec![cube()], Vec3::new(3.0, 3.0, 0.0))), [2, 0]);
    // Two facing mirrors with a light between them: each alone, and each by way of the other.
    let facing =
        vec![quad(Vec3::ZERO, [Vec3::X, Vec3::Y]), quad(3.0 * Vec3::Z, [Vec3::Y, Vec3::X])];
    assert_eq!(counts(&scene(facing, Vec3::Z)), [2, 2]);
    // A lid hides the light.
    let lid = quad(2.0 * Vec3::Y, [9.0 * Vec3::X, 9.0 * Vec3::Z]);
    let mut hidden = scene(vec![cube(), lid], 3.0 * Vec3::Y);
    hidden.groups[1].material = Material::diffuse(Rgb::ONE);
    assert_eq!(counts(&hidden), [0, 0]);
}
