//! Exports, rendered by the programs that they are for, which make the same picture of them.

use crate::export_scene::{SIZE, camera, exported, scene};
use crate::programs::{Program, compare, compare_quadrants, need, our_picture};
use unrender::formats::export::Target;
use unrender::scene::{BrdfModel, Rgb, Scene};

/// What a quarter of a group may be off by, beside twice what the whole may: lobes that another
/// program lacks spread differently over a group. A texture that is flipped is off by ten times that.
const QUADRANT: f32 = 0.02;

/// Asserts that `program`'s picture of our scene has groups as bright as ours, up to `limit` of
/// the group.
fn renders_alike(scene: &Scene, target: Target, spp: u32, limit: impl Fn(&Scene, usize) -> f32) {
    let Some(program) = need(Program::installed(target)) else { return };
    let camera = camera();
    let (_folder, path) = exported(scene, target);
    let theirs = program.picture(&path, spp).unwrap();
    let ours = our_picture(scene, &camera, SIZE, 1024);
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

/// What Radiance's own sampling of glossy surfaces leaves (see `docs/guides/export.md`), and noise.
#[test]
#[ignore = "slow: needs Radiance, which .ci/programs installs"]
fn radiance_makes_the_same_picture() {
    let is_diffuse =
        |scene: &Scene, group: usize| !scene.groups[group].material.rho_s.cmpgt(Rgb::ZERO).any();
    let limit = |scene: &Scene, group| if is_diffuse(scene, group) { 0.01 } else { 0.025 };
    renders_alike(&scene(), Target::Radiance, 128, limit);
}

/// Glossy groups shine with converted lobes.
#[test]
#[ignore = "slow: needs Mitsuba 3, which .ci/programs installs"]
fn mitsuba_makes_the_same_picture() {
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.05 } else { 0.01 }
    };
    renders_alike(&scene(), Target::Mitsuba, 1024, limit);
}

/// The scene with the lobe of GGX, which Mitsuba has.
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
