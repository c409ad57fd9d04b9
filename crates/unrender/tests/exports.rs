//! Exports, opened by the programs that they are for, which make the same picture of them.

mod export_scene;
mod programs;

use export_scene::{SIZE, camera, scene};
use programs::{Program, compare, our_picture};
use std::sync::atomic::{AtomicUsize, Ordering};
use unrender::converted::converted;
use unrender::formats::LightUnits;
use unrender::formats::export::{self, Shot, Target};
use unrender::scene::{BrdfModel, Material, Rgb, Scene};

/// A folder of this test that is removed at the end.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let (process, number) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(format!("unrender-exports-{process}-{number}-{name}"));
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
    scene: &Scene,
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
    let camera = camera();
    let folder = Folder::new(target.name());
    let converted = converted(scene, &camera, SIZE, target.lobe(scene.brdf));
    let materials: Vec<Material> = converted.into_iter().map(|c| c.material).collect();
    let shot = Shot {
        scene,
        materials: &materials,
        camera: &camera,
        size: SIZE,
        light_units: LightUnits::Radiometric,
    };
    let (files, warnings) = export::export(&shot, target).unwrap();
    assert!(warnings.0.is_empty(), "{warnings:?}");
    export::write(&folder.0, target, &files).unwrap();
    let theirs = program.picture(&folder.0, spp).unwrap();
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
}

/// What Radiance's own sampling of glossy surfaces leaves (see `docs/guides/export.md`), and noise.
#[test]
fn radiance_makes_the_same_picture() {
    let is_diffuse =
        |scene: &Scene, group: usize| !scene.groups[group].material.rho_s.cmpgt(Rgb::ZERO).any();
    let limit = |scene: &Scene, group| if is_diffuse(scene, group) { 0.01 } else { 0.025 };
    renders_alike(&scene(), Target::Radiance, Program::radiance(), 128, limit);
}

/// Glossy groups shine with converted lobes.
#[test]
fn mitsuba_makes_the_same_picture() {
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.05 } else { 0.01 }
    };
    renders_alike(&scene(), Target::Mitsuba, Program::mitsuba(), 1024, limit);
}

/// The scene with the lobe of GGX, which Mitsuba has.
#[test]
fn mitsuba_makes_the_same_picture_of_ggx() {
    let scene = Scene { brdf: BrdfModel::Ggx, ..scene() };
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.02 } else { 0.01 }
    };
    renders_alike(&scene, Target::Mitsuba, Program::mitsuba(), 1024, limit);
}

/// Blender is 350 MB and is not installed by a test; it is asked for with
/// `cargo test -p unrender --test exports -- --ignored`.
#[test]
#[ignore = "installs Blender"]
fn blender_makes_the_same_picture() {
    let limit = |scene: &Scene, group: usize| {
        if scene.groups[group].material.is_glossy() { 0.05 } else { 0.015 }
    };
    renders_alike(&scene(), Target::Blender, Program::blender(), 512, limit);
    let scene = Scene { brdf: BrdfModel::Ggx, ..scene() };
    renders_alike(&scene, Target::Blender, Program::blender(), 512, limit);
}

#[test]
fn ggx_needs_no_conversion_where_it_is_known() {
    let scene = Scene { brdf: BrdfModel::Ggx, ..scene() };
    for target in Target::ALL.into_iter().filter(|&t| t != Target::Radiance) {
        let converted = converted(&scene, &camera(), SIZE, target.lobe(scene.brdf));
        for (conversion, group) in converted.iter().zip(&scene.groups) {
            assert_eq!((&conversion.material, conversion.difference), (&group.material, 0.0));
        }
    }
}

/// Exports the scene as `target` and says where; the folder goes with the first value.
fn exported(target: Target) -> (Folder, std::path::PathBuf) {
    let folder = Folder::new(&format!("{target}-file"));
    std::fs::create_dir_all(&folder.0).unwrap();
    let path = folder.0.join(if target == Target::Gltf { "scene.glb" } else { "scene" });
    let (scene, camera) = (scene(), camera());
    let converted = converted(&scene, &camera, SIZE, target.lobe(scene.brdf));
    let materials: Vec<Material> = converted.into_iter().map(|c| c.material).collect();
    let shot = Shot {
        scene: &scene,
        materials: &materials,
        camera: &camera,
        size: SIZE,
        light_units: LightUnits::Radiometric,
    };
    let (files, _) = export::export(&shot, target).unwrap();
    export::write(&path, target, &files).unwrap();
    (folder, path)
}

const VALIDATE_GLTF: &str = "
const validator = require(process.argv[1] + '/node_modules/gltf-validator');
const bytes = new Uint8Array(require('fs').readFileSync(process.argv[2]));
validator.validateBytes(bytes).then(report => {
    console.log(JSON.stringify(report.issues));
    process.exitCode = report.issues.numErrors + report.issues.numWarnings > 0 ? 1 : 0;
});
";

#[test]
fn khronos_validator_finds_nothing_wrong_with_gltf() {
    let validator = match programs::npm("gltf-validator") {
        Ok(validator) => validator,
        Err(problem) => {
            eprintln!("skipped: the glTF validator cannot be installed here ({problem})");
            return;
        }
    };
    let (_folder, path) = exported(Target::Gltf);
    let mut node = std::process::Command::new("node");
    let report = node.args(["-e", VALIDATE_GLTF]).arg(validator).arg(path).output().unwrap();
    let said = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(report.status.success(), "{said} {}", String::from_utf8_lossy(&report.stderr));
}

#[test]
fn gltf_comes_back_to_the_same_numbers() {
    let (_folder, path) = exported(Target::Gltf);
    let (back, _) = unrender::formats::load_scene(&path).unwrap();
    for (found, group) in back.groups.iter().zip(&scene().groups) {
        let expected =
            Material { texture: found.material.texture.clone(), ..group.material.clone() };
        assert_eq!((&found.name, &found.material), (&group.name, &expected));
        assert_eq!(found.emission, group.emission);
    }
}

const VALIDATE_MATERIALX: &str = "
import sys, MaterialX
document = MaterialX.createDocument()
libraries = MaterialX.createDocument()
MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), MaterialX.getDefaultDataSearchPath(), libraries)
MaterialX.readFromXmlFile(document, sys.argv[1])
document.setDataLibrary(libraries)
valid, message = document.validate()
names = [m.getAttribute('doc') for m in document.getNodes('standard_surface')]
print(message, names)
sys.exit(0 if valid and len(names) == int(sys.argv[2]) else 1)
";

#[test]
fn materialx_is_valid() {
    let python = match programs::python("materialx", &["MaterialX==1.39.5"]) {
        Ok(python) => python,
        Err(problem) => {
            eprintln!("skipped: MaterialX cannot be installed here ({problem})");
            return;
        }
    };
    let (_folder, path) = exported(Target::Materialx);
    let mut command = std::process::Command::new(python);
    command.args(["-c", VALIDATE_MATERIALX]).arg(path.join("materials.mtlx"));
    let report = command.arg(scene().groups.len().to_string()).output().unwrap();
    let said = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(report.status.success(), "{said} {}", String::from_utf8_lossy(&report.stderr));
}

/// The scene that is read back from an export to `target`, whose main file is `file`.
fn back(target: Target, file: &str) -> Scene {
    let folder = Folder::new(&format!("{target}-back"));
    let (scene, camera) = (scene(), camera());
    let materials = scene.materials();
    let shot = Shot {
        scene: &scene,
        materials: &materials,
        camera: &camera,
        size: SIZE,
        light_units: LightUnits::Radiometric,
    };
    let (files, _) = export::export(&shot, target).unwrap();
    export::write(&folder.0, target, &files).unwrap();
    let (back, warnings) = unrender::formats::load_scene(&folder.0.join(file)).unwrap();
    assert!(warnings.0.is_empty(), "{warnings:?}");
    back
}

/// Asserts that `back` has all that the scene has: names, numbers, and the same picture.
fn assert_same(back: &Scene) {
    let (scene, camera) = (scene(), camera());
    assert_eq!(back.brdf, scene.brdf);
    assert_eq!(back.groups.len(), scene.groups.len());
    for (found, group) in back.groups.iter().zip(&scene.groups) {
        assert_eq!((&found.name, found.emission), (&group.name, group.emission));
        let numbers = |m: &Material| (m.rho_d, m.rho_s, m.alpha_x, m.alpha_y, m.texture.is_some());
        assert_eq!(numbers(&found.material), numbers(&group.material), "{}", group.name);
    }
    assert_eq!(back.triangle_count(), scene.triangle_count());
    let lights = |scene: &Scene| scene.lights.iter().map(|l| l.name.clone()).collect::<Vec<_>>();
    assert_eq!(lights(back), lights(&scene));
    let objects = |scene: &Scene| scene.objects.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    assert_eq!(objects(back), objects(&scene));
    let theirs = our_picture(back, &back.cameras[0], SIZE, 1024);
    let ours = our_picture(&scene, &camera, SIZE, 1024);
    for row in compare(&scene, &camera, &ours, &theirs, 20) {
        let name = &scene.groups[row.group].name;
        assert!(row.difference() < 0.005, "{name}: {} for {}", row.theirs, row.ours);
    }
}

#[test]
fn mitsuba_scenes_come_back() {
    assert_same(&back(Target::Mitsuba, "scene.xml"));
}

#[test]
fn radiance_scenes_come_back() {
    assert_same(&back(Target::Radiance, "scene.rad"));
}
