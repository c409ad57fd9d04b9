//! Exports, rendered by the programs for which they are made: the pictures agree with ours.

use crate::kit::export_scene::{SIZE, camera, exported, scene};
use crate::kit::programs::{Program, compare, compare_quadrants, installed, need, our_picture};
use std::process::Command;
use unrender::formats::export::Target;
use unrender::scene::{BrdfModel, Camera, Rgb, Scene};

/// The largest allowed error of a quarter of a group, added to twice that of the whole: lobes that
/// another program lacks spread differently over a group. A flipped texture is off by ten times that.
const QUADRANT: f32 = 0.02;

/// Asserts that the groups in the program's picture of our scene are as bright as in ours, up to
/// `limit` of the group.
fn renders_alike(scene: &Scene, target: Target, spp: u32, limit: impl Fn(&Scene, usize) -> f32) {
    let Some(program) = need(Program::installed(target)) else { return };
    let camera = camera();
    let (_folder, path) = exported(scene, target);
    let theirs = program.picture(&path, SIZE, spp).unwrap();
    // With a quarter of the samples the mean of the mirror has noise of 0.2 %.
    let ours = our_picture(scene, &camera, SIZE, 4096);
    let rows = compare(scene, &camera, &ours, &theirs, 20);
    assert_eq!(rows.len(), scene.groups.len(), "all groups are seen");
    for row in &rows {
        let name = &scene.groups[row.group].name;
        println!(
            "{name}: {} {} {} {:.2} %",
            row.pixels,
            row.ours,
            row.theirs,
            100.0 * row.difference()
        );
    }
    for row in &rows {
        let (name, limit) = (&scene.groups[row.group].name, limit(scene, row.group));
        assert!(row.difference() < limit, "{name}: {} for {}", row.theirs, row.ours);
    }
    for row in compare_quadrants(scene, &camera, &ours, &theirs, 20) {
        let name = &scene.groups[row.group].name;
        let limit = QUADRANT + 2.0 * limit(scene, row.group);
        println!("{name}, a quarter: {} {:.2} %", row.pixels, 100.0 * row.difference());
        assert!(row.difference() < limit, "{name}, a quarter: {} for {}", row.theirs, row.ours);
    }
}

/// The error of Radiance's own sampling of glossy surfaces (see `docs/guides/export.md`), and
/// noise.
#[test]
#[ignore = "slow: needs Radiance, which .ci/programs installs"]
fn radiance_makes_the_same_picture() {
    let is_diffuse =
        |scene: &Scene, group: usize| !scene.groups[group].material.rho_s.cmpgt(Rgb::ZERO).any();
    let limit = |scene: &Scene, group| if is_diffuse(scene, group) { 0.01 } else { 0.025 };
    renders_alike(&scene(), Target::Radiance, 128, limit);
}

/// Glossy groups have converted lobes.
#[test]
#[ignore = "slow: needs Mitsuba 3, which .ci/programs installs"]
fn mitsuba_makes_the_same_picture() {
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.05 } else { 0.01 }
    };
    renders_alike(&scene(), Target::Mitsuba, 1024, limit);
}

/// The scene with the GGX lobe, which Mitsuba has.
#[test]
#[ignore = "slow: needs Mitsuba 3, which .ci/programs installs"]
fn mitsuba_makes_the_same_picture_of_ggx() {
    let scene = Scene { brdf: BrdfModel::Ggx, ..scene() };
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.02 } else { 0.01 }
    };
    renders_alike(&scene, Target::Mitsuba, 1024, limit);
}

#[test]
#[ignore = "slow: needs Blender, which .ci/programs installs"]
fn blender_makes_the_same_picture() {
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.05 } else { 0.015 }
    };
    renders_alike(&scene(), Target::Blender, 512, limit);
    let scene = Scene { brdf: BrdfModel::Ggx, ..scene() };
    renders_alike(&scene, Target::Blender, 512, limit);
}

/// USD, brought into Blender by Blender's own import, which knows `UsdPreviewSurface` alone: no anisotropy, no reflectance that
/// is the same at all angles, of a lobe over a base one colour for both or none.
#[test]
#[ignore = "slow: needs Blender, which .ci/programs installs"]
fn blender_makes_the_same_picture_of_usd() {
    let scene = Scene { brdf: BrdfModel::Ggx, ..scene() };
    let limit = |scene: &Scene, group: usize| {
        let material = &scene.groups[group].material;
        match (material.is_glossy(), material.alpha_x == material.alpha_y) {
            // A mirror, with what it shows; and by the light of the others.
            (false, _) => 0.06,
            (true, true) => 0.17,
            (true, false) => 0.3,
        }
    };
    renders_alike(&scene, Target::Usd, 512, limit);
}

/// A user's open file, to which the script adds its scene.
const OPEN_FILE: &str = "
import runpy, sys
import bpy
folder = sys.argv[1]
parent = bpy.data.objects.new('parent', None)
parent.location = (1, 2, 3)
mine = bpy.data.objects.new('ball', bpy.data.meshes.new('ball'))
mine.parent = parent
for thing in (parent, mine):
    bpy.context.scene.collection.objects.link(thing)
bpy.data.materials.new('ball').use_fake_user = True
bpy.context.view_layer.update()
before = {o.name for o in bpy.data.objects}, bpy.context.scene.name, bpy.context.scene.camera.name
sys.argv = [folder + '/scene.py']
runpy.run_path(folder + '/scene.py', run_name='__main__')
made = bpy.data.scenes['unrender']
assert before[0] <= {o.name for o in bpy.data.objects}
assert bpy.data.scenes[before[1]].camera.name == before[2]
named = {o['unrender_name']: o for o in made.objects if 'unrender_name' in o}
theirs = named['ball']
assert theirs.name == 'ball.001' and theirs.parent == parent and mine.parent == parent
bpy.data.scenes['unrender'].view_layers[0].update()
assert theirs.matrix_world.translation.length < 1e-5, theirs.matrix_world
assert made.camera['unrender_name'] == 'the \"camera\"'
cameras = [o for o in made.objects if o.type == 'CAMERA']
assert len(cameras) == 2 and cameras[1]['unrender_name'] == 'door', cameras
assert theirs.data.materials[0]['unrender_name'] == 'ball'
";

#[test]
#[ignore = "slow: needs Blender, which .ci/programs installs"]
fn the_script_for_blender_leaves_the_open_file_alone() {
    let Some(bpy) = need(installed("bpy")) else { return };
    let mut scene = scene();
    let door = Camera { name: "door".into(), ..scene.cameras[0].clone() };
    scene.cameras.push(door);
    let (_folder, path) = exported(&scene, Target::Blender);
    let mut python = Command::new(bpy.join("bin/python"));
    let output = python.args(["-c", OPEN_FILE]).arg(path).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
}
