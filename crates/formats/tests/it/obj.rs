//! What is read from OBJ and MTL.

use crate::support::Folder;
use glam::{Vec2, Vec3};
use unrender_formats::{assign_materials, load_scene};
use unrender_scene::{Material, Rgb};

const OBJ: &str = "mtllib room.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 2
o wall
usemtl paint
f 1/1/1 2/2/1 3/3/1 4/4/1
o lamp
usemtl glow
f 1 2 3
o ball
usemtl gloss
f 1 2 3
";
const MTL: &str = "newmtl paint
Kd 0.25 0.5 0.75
Ks 1 1 1
illum 1
newmtl glow
Kd 0
Ke 5 4 3
newmtl gloss
Kd 0.1 0.1 0.1
Ks 0.5 0.5 0.5
Ns 198
illum 2
";

#[test]
fn obj_and_mtl_become_a_scene() {
    let folder = Folder::new();
    folder.file("room.mtl", MTL);
    let path = folder.file("room.obj", OBJ);
    let (scene, warnings) = load_scene(&path).unwrap();
    assert_eq!(warnings.0, [""; 0]);
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["wall", "lamp", "ball"]);
    let groups: Vec<&str> = scene.groups.iter().map(|g| g.name.as_str()).collect();
    assert_eq!(groups, ["paint", "glow", "gloss"]);
    assert_eq!(scene.groups[0].material, Material::diffuse(Rgb::new(0.25, 0.5, 0.75)));
    assert_eq!(scene.groups[1].emission, Rgb::new(5.0, 4.0, 3.0));
    let gloss = Material::isotropic(Rgb::splat(0.1), Rgb::splat(0.5), 0.1);
    assert_eq!(scene.groups[2].material, gloss);
    let wall = &scene.objects[0].mesh;
    assert_eq!(wall.triangles.len(), 2);
    assert_eq!(wall.normals, [Vec3::Z; 4]);
    assert_eq!(wall.uvs[0], Vec2::new(0.0, 1.0), "v counts from the top");
    assert!(scene.cameras.is_empty());

    let assigned = folder.file("assigned.glb", assign_materials(&path, &scene).unwrap());
    assert_eq!(load_scene(&assigned).unwrap().0, scene);
}

#[test]
fn faces_without_a_material_are_the_group_default() {
    let folder = Folder::new();
    folder.file("room.mtl", MTL);
    let text = OBJ.replacen("o wall", "f 1 2 3\no wall", 1);
    let (scene, warnings) = load_scene(&folder.file("room.obj", text)).unwrap();
    assert_eq!(scene.groups[0].name, "default");
    assert_eq!(scene.objects[0].name, "object 0");
    assert_eq!(warnings.0.len(), 1, "{warnings:?}");
}
