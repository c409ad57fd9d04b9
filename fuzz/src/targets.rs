//! The readers, each with the structure of its files.

use crate::mutate::Kind;
use std::fs;
use std::path::Path;
use unrender::Project;
use unrender::cli::Global;
use unrender::commands::merge;
use unrender::edit::EditSheet;
use unrender::fit_brdf::{Form, fit};
use unrender::formats::cameras::{colmap, opencv};
use unrender::formats::{
    Input, Limits, assign_materials, axis_lines, fspy, ies, load_model, load_scene, material_file,
    materials, merl, picture, planes, points, response_curve,
};
use unrender::listener::Console;
use unrender::run::Run;
use unrender::scene::{BrdfModel, Group, Material, Rgb, Scene};

/// The memory limit for inputs, bytes; [`crate::worker`] allows the process more for itself.
pub(crate) const MEMORY: u64 = 256 << 20;

/// The flags of commands that are run here.
fn global() -> Global {
    Global {
        quiet: true,
        threads: None,
        allow_outside: false,
        allow_missing: false,
        input_memory: Some(0.25),
        console: Console::default(),
        scene: None,
    }
}

/// A reader.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    /// Its name on the command line, and the extension of its files.
    pub(crate) name: &'static str,
    /// How its files are changed.
    pub(crate) kind: Kind,
    /// Reads the file.
    pub(crate) read: fn(&Path),
}

/// All of them.
pub(crate) const ALL: [Target; 27] = [
    Target { name: "gltf", kind: Kind::Json, read: scene },
    Target { name: "glb", kind: Kind::Glb, read: scene },
    Target { name: "obj", kind: Kind::Words, read: scene },
    Target { name: "mtl", kind: Kind::Words, read: mtl },
    Target { name: "xml", kind: Kind::Words, read: scene },
    Target { name: "ply", kind: Kind::Words, read: ply },
    Target { name: "rad", kind: Kind::Words, read: scene },
    Target { name: "vf", kind: Kind::Words, read: view },
    Target { name: "png", kind: Kind::Bytes, read: image },
    Target { name: "jpg", kind: Kind::Bytes, read: image },
    Target { name: "tif", kind: Kind::Bytes, read: image },
    Target { name: "exr", kind: Kind::Bytes, read: image },
    Target { name: "hdr", kind: Kind::Bytes, read: image },
    Target { name: "part", kind: Kind::Bytes, read: part },
    Target { name: "materials", kind: Kind::Json, read: material_file },
    Target { name: "run", kind: Kind::Json, read: run },
    Target { name: "manifest", kind: Kind::Json, read: manifest },
    Target { name: "project", kind: Kind::Toml, read: project },
    Target { name: "edit", kind: Kind::Toml, read: edit },
    Target { name: "csv", kind: Kind::Words, read: tables },
    Target { name: "binary", kind: Kind::Bytes, read: measured },
    Target { name: "mtlx", kind: Kind::Words, read: materialx },
    Target { name: "fspy", kind: Kind::Bytes, read: fspy_project },
    Target { name: "ies", kind: Kind::Words, read: profile },
    Target { name: "opencv", kind: Kind::Words, read: calibration },
    Target { name: "colmap", kind: Kind::Words, read: reconstruction },
    Target { name: "colmap_bin", kind: Kind::Bytes, read: reconstruction },
];

fn input(path: &Path) -> Input<'_> {
    Input::new(path, Limits { memory: MEMORY, ..Limits::default() })
}

fn scene(path: &Path) {
    // The messages do not matter here, only that it returns.
    if let Ok((scene, _)) = load_scene(input(path)) {
        let _ = assign_materials(input(path), &scene, &[]);
    } else {
        let _ = load_model(input(path));
    }
}

fn mtl(path: &Path) {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let obj = path.with_extension("obj");
    let text = format!("mtllib {name}\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let _ = fs::write(&obj, text);
    let _ = load_model(input(&obj));
}

fn ply(path: &Path) {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let xml = path.with_extension("xml");
    let shape = format!("<shape type=\"ply\"><string name=\"filename\" value=\"{name}\"/></shape>");
    let _ = fs::write(&xml, format!("<scene version=\"3.0.0\">{shape}</scene>"));
    let _ = load_model(input(&xml));
}

fn view(path: &Path) {
    let rad = path.with_extension("rad");
    let _ = fs::write(&rad, "void light l 0 0 3 1 1 1\nl sphere s 0 0 4 0 0 0 1\n");
    let _ = load_model(input(&rad));
}

fn image(path: &Path) {
    let _ = picture::read(input(path));
    let _ = picture::read_environment(input(path), 0.5, 1.0);
    if let Ok(bytes) = fs::read(path) {
        let _ = picture::exif_focal_px(&bytes, 640, 480);
    }
}

fn part(path: &Path) {
    let _ = planes::read(input(path));
    let (parts, out) = (vec![path.to_owned()], path.with_file_name("merged.exr"));
    let _ = merge::run(&merge::Args { parts, allow_gaps: true, out }, &global());
}

fn material_file(path: &Path) {
    // A scene with the groups of the file, if it can be read.
    let mut scene = Scene::default();
    for name in materials::read(input(path)).iter().flat_map(|file| file.groups.keys()) {
        let material = Material::diffuse(Rgb::ONE);
        scene.groups.push(Group { name: name.clone(), material, emission: Rgb::ONE });
    }
    let _ = materials::apply_from(input(path), &mut scene);
}

fn measured(path: &Path) {
    let Ok(table) = merl::read(input(path)) else { return };
    // Of large tables the reading is what matters.
    if table.len() < 4096 {
        let _ = fit(&table, &Form::of(Some(BrdfModel::Ggx)));
    }
}

fn materialx(path: &Path) {
    let mut scene = Scene::default();
    for name in ["m", "a", "Gold"] {
        let material = Material::diffuse(Rgb::ONE);
        scene.groups.push(Group { name: name.into(), material, emission: Rgb::ZERO });
    }
    let _ = material_file::apply(input(path), &mut scene);
}

fn run(path: &Path) {
    let folder = path.with_extension("folder");
    let _ = fs::create_dir_all(&folder);
    let _ = fs::copy(path.with_file_name("seed.png"), folder.join("seed.png"));
    if fs::copy(path, folder.join(Run::FILE)).is_ok() {
        let _ = Run::read(&folder);
        let _ = unrender::report::page(&folder);
    }
}

fn manifest(path: &Path) {
    let folder = path.with_extension("folder");
    let _ = fs::create_dir_all(&folder);
    let _ = fs::copy(path.with_file_name("seed.png"), folder.join("seed.png"));
    if fs::copy(path, folder.join("manifest.json")).is_ok() {
        let _ = unrender::result_folder::check(&folder);
    }
}

fn project(path: &Path) {
    if let Ok(text) = fs::read_to_string(path) {
        let _ = Project::parse(path, &text);
    }
}

fn edit(path: &Path) {
    if let Ok(sheet) = EditSheet::read(path) {
        let _ = unrender::edit::Restaging::load(vec![sheet]);
    }
}

fn tables(path: &Path) {
    if let Ok(bytes) = fs::read(path) {
        let _ = points::parse(&bytes);
        let _ = axis_lines::parse(&bytes);
        let _ = response_curve::parse(&bytes);
    }
}

fn fspy_project(path: &Path) {
    if let Ok(bytes) = fs::read(path) {
        let _ = fspy::parse(&bytes, None);
    }
}

fn profile(path: &Path) {
    let _ = ies::read(input(path));
}

fn calibration(path: &Path) {
    if let Ok(text) = fs::read_to_string(path) {
        for extension in ["yml", "json", "xml"] {
            let _ = opencv::parse(&text, extension, Some(0));
        }
    }
}

/// Reads the same bytes as the file of cameras and as that of images.
fn reconstruction(path: &Path) {
    for extension in ["txt", "bin"] {
        let file = path.with_extension(extension);
        if fs::copy(path, &file).is_ok() {
            let limits = Limits { memory: MEMORY, ..Limits::default() };
            let _ = colmap::read(&file, &file, "a.jpg", limits);
        }
    }
}
