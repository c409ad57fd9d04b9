//! Exports, opened by the programs that they are for, which make the same picture of them.

mod export_scene;
mod programs;

use export_scene::{SIZE, camera, scene};
use programs::{Program, compare, our_picture};
use unrender::formats::export::{self, Shot, Target};
use unrender::recover::convert::convert;
use unrender::scene::{Material, Rgb, Scene};

/// A folder of this test that is removed at the end.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("unrender-exports-{}-{name}", std::process::id()));
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that is left behind in the temporary files does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Asserts that `program`'s picture of our scene has groups as bright as ours, up to `limit` of
/// the group.
fn renders_alike(
    target: Target,
    program: Result<Program, String>,
    spp: u32,
    limit: impl Fn(&Scene, usize) -> f32,
) {
    let program = match program {
        Ok(program) => program,
        Err(problem) => {
            eprintln!("skipped: {target} cannot be installed here ({problem})");
            return;
        }
    };
    let (scene, camera) = (scene(), camera());
    let folder = Folder::new(target.name());
    let converted = |material: &Material| convert(material, scene.brdf, target.lobe()).material;
    let materials: Vec<Material> = scene.groups.iter().map(|g| converted(&g.material)).collect();
    let shot = Shot { scene: &scene, materials: &materials, camera: &camera, size: SIZE };
    let (files, warnings) = export::export(&shot, target).unwrap();
    assert!(warnings.0.is_empty(), "{warnings:?}");
    export::write(&folder.0, target, &files).unwrap();
    let theirs = program.picture(&folder.0, spp).unwrap();
    let ours = our_picture(&scene, &camera, SIZE, 1024);
    let rows = compare(&scene, &camera, &ours, &theirs, 20);
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
        let (name, limit) = (&scene.groups[row.group].name, limit(&scene, row.group));
        assert!(row.difference() < limit, "{name}: {} for {}", row.theirs, row.ours);
    }
}

/// What Radiance's own sampling of glossy surfaces leaves (see `docs/exports.md`), and noise.
#[test]
fn radiance_makes_the_same_picture() {
    let is_diffuse =
        |scene: &Scene, group: usize| !scene.groups[group].material.rho_s.cmpgt(Rgb::ZERO).any();
    let limit = |scene: &Scene, group| if is_diffuse(scene, group) { 0.01 } else { 0.015 };
    renders_alike(Target::Radiance, Program::radiance(), 64, limit);
}

/// Glossy groups shine with converted lobes.
#[test]
fn mitsuba_makes_the_same_picture() {
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.05 } else { 0.01 }
    };
    renders_alike(Target::Mitsuba, Program::mitsuba(), 1024, limit);
}
