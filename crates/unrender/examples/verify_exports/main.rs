//! Renders exports of the examples with their target programs, and writes how far those pictures
//! are from ours, group by group: the table of `docs/validation/exports.md`.
//!
//! `cargo run --release --example verify_exports -- [--spp N] [--height N] [--scene FOLDER] [PROGRAM
//! ...]`. Programs
//! that are not named keep their tables. The programs come from PyPI, including Blender's 350 MB.

// The tests use all of it.
#[allow(dead_code, unused_imports)]
#[path = "../../tests/kit/programs/mod.rs"]
mod programs;
mod table;

use programs::{Program, compare, our_picture};
use std::path::Path;
use unrender::converted::converted;
use unrender::formats::export::{self, SceneView, Target};
use unrender::formats::{LightUnits, materials};
use unrender::scene::{BrdfModel, Camera, Scene, WardModel};

type Failure = Box<dyn std::error::Error>;

/// Groups of fewer pixels are left out.
const LEAST_PIXELS: usize = 50;
/// Paths a pixel of our picture.
const OURS: u32 = 1024;

struct Request {
    spp: u32,
    height: usize,
    /// Only the scenes of this example.
    scene: Option<String>,
    targets: Vec<Target>,
}

fn request() -> Result<Request, Failure> {
    let mut request = Request { spp: 256, height: 192, scene: None, targets: Vec::new() };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--spp" => request.spp = words.next().ok_or("--spp N")?.parse()?,
            "--height" => request.height = words.next().ok_or("--height N")?.parse()?,
            "--scene" => request.scene = words.next(),
            name => request.targets.push(name.parse()?),
        }
    }
    if request.targets.is_empty() {
        request.targets = vec![Target::Radiance, Target::Mitsuba];
    }
    Ok(request)
}

fn main() -> Result<(), Failure> {
    let request = request()?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = root.join("docs/validation/exports.md");
    for target in &request.targets {
        let program = Program::for_target(*target)?;
        for (name, folder, model) in [
            ("Figure 8", "fig8", BrdfModel::Ward(WardModel::Ward1992)),
            ("Figure 8, read as ward-gmd", "fig8", BrdfModel::Ward(WardModel::WardGmd)),
            ("Figure 8, read as ggx", "fig8", BrdfModel::Ggx),
            ("The room", "room", BrdfModel::Ward(WardModel::WardGmd)),
        ] {
            if request.scene.as_ref().is_some_and(|only| only != folder) {
                continue;
            }
            let (scene, camera) = load(&root.join("examples").join(folder), model)?;
            let rows = rows(&scene, &camera, *target, &program, &request)?;
            let title = format!("{name}, {target}");
            println!("{title}\n{rows}");
            let text = std::fs::read_to_string(&page)?;
            std::fs::write(&page, table::replace(&text, &title, &rows))?;
        }
    }
    Ok(())
}

/// The example in `folder` with its true materials, as those of `model`.
fn load(folder: &Path, model: BrdfModel) -> Result<(Scene, Camera), Failure> {
    let (mut scene, _) = unrender::formats::load_scene(&folder.join("scene.glb"))?;
    materials::apply_from(&folder.join("truth.json"), &mut scene)?;
    scene.brdf = model;
    let camera = scene.cameras.first().ok_or("the example has no camera")?.clone();
    Ok((scene, camera))
}

/// The rows of one scene and one program as Markdown.
fn rows(
    scene: &Scene,
    camera: &Camera,
    target: Target,
    program: &Program,
    request: &Request,
) -> Result<String, Failure> {
    let width = (request.height as f32 * camera.aspect.unwrap_or(1.0)).round() as usize;
    let size = (width, request.height);
    let conversions = converted(scene, camera, size, target.lobe(scene.brdf));
    let materials: Vec<_> = conversions.iter().map(|c| c.material.clone()).collect();
    let folder = tempfile::tempdir()?;
    let shot = SceneView {
        scene,
        materials: &materials,
        camera,
        size,
        light_units: LightUnits::Radiometric,
    };
    let path = folder.path().join(target.usual_name());
    let (files, _) = export::export(&shot, target, &path)?;
    export::write(&path, target, &files)?;
    let theirs = program.picture(&path, size, request.spp)?;
    let ours = our_picture(scene, camera, size, OURS);
    Ok(table::rows(scene, &conversions, &compare(scene, camera, &ours, &theirs, LEAST_PIXELS)))
}
