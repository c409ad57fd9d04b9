//! Tests of `unrender restage`: the edit file, its errors, and the files in its folder.

use crate::kit::folder::{Folder, fails, is_refused, stderr, succeeds};
use crate::kit::meshes::{add, quad};
use glam::Vec3;
use std::ops::Deref;
use std::path::Path;
use std::process::Output;
use unrender::formats::picture::{self, Depth};
use unrender::formats::{gltf, materials};
use unrender::render::{Settings, Tracer};
use unrender::scene::{Camera, Image, Rgb, Scene};

/// Width and height of the photograph, pixels.
pub(crate) const SIZE: (usize, usize) = (48, 36);

/// A folder with a scene, its materials, a photograph, a project and a model to insert.
pub(crate) struct Stage(Folder);

impl Deref for Stage {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Stage {
    /// The folder, with all these files.
    pub(crate) fn new() -> Self {
        let folder = Folder::new();
        let mut scene = scene();
        scene.validate().unwrap();
        let settings = Settings { spp: 128, seed: 5, ..Settings::default() };
        let tracer = Tracer::new(&scene);
        let film = tracer.render(&scene.materials(), &scene.cameras[0], SIZE, &settings, &|_| ());
        for (name, depth) in [("8.png", Depth::Eight), ("16.png", Depth::Sixteen)] {
            let codes = film.mean.map(|rgb| rgb.map(unrender::scene::color::srgb_from_linear));
            picture::write_png_codes(&folder.path(name), &codes, depth).unwrap();
            let text = format!(
                "scene = \"scene.glb\"\nphoto = \"{name}\"\nresponse = \"srgb\"\nexposure = 1\n"
            );
            folder.write(&name.replace("png", "toml"), &text);
        }
        folder.write("scene.glb", &gltf::to_glb(&scene).unwrap());
        folder.write("box.glb", &gltf::to_glb(&red_box()).unwrap());
        materials::write(&folder.path("materials.json"), &Default::default()).unwrap();
        Self(folder)
    }

    /// `unrender restage` with `arguments`, in this folder.
    pub(crate) fn restage(&self, arguments: &[&str]) -> Output {
        self.run(&[&["restage", "--quiet"], arguments].concat())
    }

    /// Asserts that `unrender restage` succeeds with `arguments`.
    #[track_caller]
    pub(crate) fn succeeds(&self, arguments: &[&str]) {
        succeeds(&self.restage(arguments));
    }

    /// Asserts that the edit file `text` is refused with `problem`, and that nothing is written.
    #[track_caller]
    fn refuses(&self, text: &str, problem: &str) {
        self.write("bad.toml", text);
        let output = self.restage(&["bad.toml", "--spp", "1", "--out", "none"]);
        fails(&output, problem);
        assert!(!self.path("none").exists(), "{}", stderr(&output));
    }
}

fn scene() -> Scene {
    let mut scene = Scene::default();
    let (x, y, z) = (3.0 * Vec3::X, 2.0 * Vec3::Y, 3.0 * Vec3::Z);
    let low = Vec3::new(-1.5, 0.0, -1.5);
    add(&mut scene, "floor", Rgb::new(0.5, 0.4, 0.3), quad(low + z, x, -z));
    add(&mut scene, "wall", Rgb::splat(0.6), quad(low, x, y));
    let lamp = quad(Vec3::new(-0.5, 1.9, -0.5), Vec3::X, Vec3::Z);
    add(&mut scene, "lamp", Rgb::ZERO, lamp);
    scene.groups[2].emission = Rgb::splat(3.0);
    let (eye, target) = (Vec3::new(0.3, 1.3, 2.6), Vec3::new(0.0, 0.6, -0.5));
    let camera = Camera::look_at("photo", eye, target, Vec3::Y, 0.8);
    scene.cameras.push(Camera { aspect: Some(48.0 / 36.0), ..camera });
    scene.cameras.push(Camera::look_at("side", Vec3::new(2.0, 1.0, 1.0), Vec3::ZERO, Vec3::Y, 0.9));
    scene
}

fn red_box() -> Scene {
    let mut scene = Scene::default();
    let (x, y, z) = (0.3 * Vec3::X, 0.4 * Vec3::Y, 0.3 * Vec3::Z);
    let front = quad(Vec3::new(-0.15, 0.0, 0.15), x, y);
    let top = quad(Vec3::new(-0.15, 0.4, 0.15), x, -z);
    add(&mut scene, "red", Rgb::new(0.7, 0.1, 0.1), front);
    add(&mut scene, "pink", Rgb::new(0.7, 0.4, 0.4), top);
    scene
}

/// An edit that puts the box before the wall.
pub(crate) const INSERT: &str = "[[insert]]\nfile = \"box.glb\"\non = \"floor\"\nat = [0.5, 0.4]\n";

fn read(path: &Path) -> picture::Picture {
    picture::read(path).unwrap().0
}

#[test]
fn a_composite_keeps_the_codes_and_the_depth_of_the_photograph() {
    let folder = Stage::new();
    for (name, depth) in [("8", Depth::Eight), ("16", Depth::Sixteen)] {
        folder.write("e.toml", &format!("project = \"{name}.toml\"\n{INSERT}"));
        folder.succeeds(&["e.toml", "--composite", "--spp", "64", "--out", name]);
        let photo = read(&folder.path(&format!("{name}.png")));
        let made = read(&folder.path(&format!("{name}/composite.png")));
        assert_eq!((made.depth, photo.depth), (depth, depth));
        let touched = read(&folder.path(&format!("{name}/touched.png")));
        let count = touched.values.pixels().iter().filter(|t| t.x > 0.0).count();
        assert!(count > 100 && count < SIZE.0 * SIZE.1, "{count} touched");
        let pairs = made.values.pixels().iter().zip(photo.values.pixels());
        let mut changed = 0;
        for ((made, photo), touched) in pairs.zip(touched.values.pixels()) {
            changed += usize::from(made != photo);
            assert!(touched.x > 0.0 || made == photo, "{made} for {photo}");
        }
        assert!(changed > 100, "{changed} changed");
        // An inserted object uncovers nothing.
        let invented = read(&folder.path(&format!("{name}/invented.png")));
        assert!(invented.values.pixels().iter().all(|i| *i == Rgb::ZERO));
        assert!(read(&folder.path(&format!("{name}/composite.exr"))).depth == Depth::Float);
    }
}

#[test]
fn flags_are_lines_of_the_file() {
    let folder = Stage::new();
    folder.write(
        "e.toml",
        &format!(
            "scene = \"scene.glb\"\nmaterials = \"materials.json\"\ncamera = \"side\"\n\
             [[remove]]\nname = \"wall\"\n[[repaint]]\ngroup = \"floor\"\nrho_d = 0.8\n\
             [[lights]]\nname = \"lamp\"\nscale = [1, 0.5, 2]\n{INSERT}"
        ),
    );
    let size = ["--width", "24", "--height", "18", "--spp", "8"];
    folder.succeeds(&[&["e.toml", "--out", "file"], &size[..]].concat());
    let flags = [
        "--scene",
        "scene.glb",
        "--camera",
        "side",
        "--remove",
        "wall",
        "--repaint",
        "floor: rho_d = 0.8",
        "--light",
        "lamp: scale = [1, 0.5, 2]",
        "--insert",
        "box.glb: on = \"floor\", at = [0.5, 0.4]",
        "--out",
        "flags",
    ];
    folder.succeeds(&[&flags[..], &size[..]].concat());
    assert_eq!(folder.bytes("file/synthetic.exr"), folder.bytes("flags/synthetic.exr"));
    assert_eq!(folder.bytes("file/synthetic.png"), folder.bytes("flags/synthetic.png"));
}

#[test]
fn parts_and_breaks_change_no_bit() {
    let folder = Stage::new();
    folder.write("e.toml", &format!("project = \"8.toml\"\n{INSERT}"));
    let run = |arguments: &[&str]| {
        folder.succeeds(&[&["e.toml", "--composite"], arguments].concat());
    };
    run(&["--spp", "12", "--out", "whole"]);
    run(&["--samples", "0..5", "--out", "farm", "--threads", "1"]);
    run(&["--samples", "5..12", "--out", "farm", "--threads", "3"]);
    run(&["--parts", "farm/part_5_12.exr", "farm/part_0_5.exr", "--out", "joined"]);
    run(&["--spp", "4", "--checkpoint", "c.exr", "--out", "short"]);
    run(&["--spp", "12", "--checkpoint", "c.exr", "--out", "resumed"]);
    for name in ["composite.exr", "composite.png", "synthetic.exr", "touched.png", "invented.png"] {
        let whole = folder.bytes(&format!("whole/{name}"));
        assert!(whole == folder.bytes(&format!("joined/{name}")), "{name} of the parts differs");
        assert!(whole == folder.bytes(&format!("resumed/{name}")), "{name} after a break differs");
    }
    // A part of another picture is not a part of this one.
    let other = ["e.toml", "--composite", "--remove", "wall", "--parts", "farm/part_0_5.exr"];
    let output = folder.restage(&[&other[..], &["--out", "no"]].concat());
    is_refused(&output, "part of another picture");
}

#[test]
fn a_sequence_is_numbered_and_goes_through_its_keys() {
    let folder = Stage::new();
    folder.write(
        "e.toml",
        "scene = \"scene.glb\"\n[camera]\nframes = 3\nfov_y_deg = 45\n\
         [[camera.keys]]\neye = [0, 1, 3]\ntarget = [0, 0.5, 0]\n\
         [[camera.keys]]\neye = [1, 1, 3]\ntarget = [0, 0.5, 0]\n",
    );
    folder.write(
        "last.toml",
        "scene = \"scene.glb\"\n\
         [camera]\nfov_y_deg = 45\neye = [1, 1, 3]\ntarget = [0, 0.5, 0]\n",
    );
    let size = ["--width", "20", "--height", "15", "--spp", "4"];
    folder.succeeds(&[&["e.toml", "--out", "all"], &size[..]].concat());
    folder.succeeds(&[&["e.toml", "--frames", "3..4", "--out", "one"], &size[..]].concat());
    folder.succeeds(&[&["last.toml", "--out", "last"], &size[..]].concat());
    let last = folder.bytes("all/synthetic_0003.exr");
    assert_ne!(last, folder.bytes("all/synthetic_0001.exr"));
    assert_eq!(last, folder.bytes("one/synthetic_0003.exr"));
    assert_eq!(last, folder.bytes("last/synthetic.exr"));
    assert!(!folder.path("one/synthetic_0001.exr").exists());
    // The gallery shows the pictures of all processes that wrote there.
    folder.succeeds(&[&["e.toml", "--frames", "1..2", "--out", "one"], &size[..]].concat());
    let gallery = folder.text("one/gallery.html");
    for (picture, is_there) in [("Picture 1", true), ("Picture 2", false), ("Picture 3", true)] {
        assert_eq!(gallery.contains(picture), is_there, "{picture}");
    }
}

#[test]
fn a_composite_says_how_its_pixels_were_made() {
    let folder = Stage::new();
    let told = |name: &str, edit: &str| {
        folder.write(&format!("{name}.toml"), &format!("project = \"8.toml\"\n{edit}"));
        let edits = format!("{name}.toml");
        folder.succeeds(&[&edits, "--composite", "--spp", "4", "--out", name]);
        folder.text(&format!("{name}/gallery.html"))
    };
    let lamp = "[[lights]]\nname = \"lamp\"\nscale = 0.05\n";
    let dark = told("dark", lamp);
    assert!(dark.contains("times the ratio of the light"), "{dark}");
    assert!(!told("same", "").contains("the light changes by more than half"));
}

#[test]
fn a_photograph_of_numbers_keeps_them() {
    let folder = Stage::new();
    let photo =
        Image::from_fn(SIZE.0, SIZE.1, |x, y| Rgb::new(0.3, 0.01 * x as f32, 0.02 * y as f32));
    picture::write_exr(&folder.path("p.exr"), &photo).unwrap();
    folder.write(
        "p.toml",
        "scene = \"scene.glb\"\nphoto = \"p.exr\"\nresponse = \"linear\"\nexposure = 0.7\n",
    );
    folder.write("e.toml", "project = \"p.toml\"\n");
    folder.succeeds(&["e.toml", "--composite", "--spp", "1", "--out", "out"]);
    assert_eq!(read(&folder.path("out/composite.exr")).values, photo);
}

#[test]
fn relit_is_as_if_the_lamp_had_been_so() {
    let folder = Stage::new();
    let mut other = scene();
    other.groups[2].emission *= Rgb::new(0.5, 1.0, 2.0);
    folder.write("other.glb", &gltf::to_glb(&other).unwrap());
    let size = ["--camera", "photo", "--width", "24", "--spp", "8"];
    let edit = ["--scene", "scene.glb", "--light", "lamp: scale = [0.5, 1, 2]", "--out", "relit"];
    folder.succeeds(&[&edit[..], &size[..]].concat());
    folder.succeeds(&[&["--scene", "other.glb", "--out", "other"][..], &size[..]].concat());
    assert_eq!(folder.bytes("relit/synthetic.exr"), folder.bytes("other/synthetic.exr"));
}

#[test]
fn the_camera_and_the_exposure_of_the_recovery_count() {
    let folder = Stage::new();
    std::fs::create_dir(folder.path("rec")).unwrap();
    folder.write("rec/materials.json", r#"{"version": 1, "exposure": [2, 2, 2], "groups": {}}"#);
    let camera = r#"{"eye": [0.5, 1.25, 2.5], "target": [0, 0.5, -0.5], "up": [0, 1, 0],
        "fov_y_deg": 45.0, "principal_point": [0, 0], "k1": 0, "k2": 0}"#;
    folder.write("rec/run.json", &format!(r#"{{"registration": {{"camera": {camera}}}}}"#));
    folder.write(
        "auto.toml",
        "scene = \"scene.glb\"\nphoto = \"8.png\"\nresponse = \"srgb\"\nexposure = \"auto\"\n\
         [anchor]\ngroup = \"wall\"\nrho_d = 0.6\n",
    );
    folder.write("moved.toml", "recovered = \"rec\"\nproject = \"auto.toml\"\n");
    folder.write(
        "stated.toml",
        "materials = \"rec/materials.json\"\nproject = \"auto.toml\"\n[camera]\n\
         eye = [0.5, 1.25, 2.5]\ntarget = [0, 0.5, -0.5]\nfov_y_deg = 45\n",
    );
    for name in ["moved", "stated"] {
        folder.succeeds(&[&format!("{name}.toml"), "--spp", "4", "--out", name]);
    }
    assert_eq!(folder.bytes("moved/synthetic.exr"), folder.bytes("stated/synthetic.exr"));
    // The PNG is at the exposure that was recovered.
    let radiance = read(&folder.path("moved/synthetic.exr")).values;
    let shown = read(&folder.path("moved/synthetic.png")).values;
    let code = |rgb: Rgb| (rgb / 2.0).map(unrender::scene::color::srgb_from_linear);
    for (radiance, shown) in radiance.pixels().iter().zip(shown.pixels()) {
        assert!((code(*radiance) - *shown).abs().max_element() < 0.003);
    }
    let output = folder.restage(&["--project", "auto.toml", "--out", "none"]);
    let said = stderr(&output);
    assert!(said.contains("name the recovery that found it"), "{said}");
}

#[test]
fn denoised_pictures_are_marked() {
    let folder = Stage::new();
    for (name, flags) in [("plain", &[][..]), ("denoised", &["--denoise"])] {
        folder.succeeds(&[&["--scene", "scene.glb", "--spp", "8", "--out", name], flags].concat());
        let is_denoised = !flags.is_empty();
        let (_, warnings) = picture::read(&folder.path(&format!("{name}/synthetic.exr"))).unwrap();
        let is_told = warnings.0.iter().any(|warning| warning.contains("was denoised by unrender"));
        assert_eq!(is_told, is_denoised, "{warnings:?}");
        let manifest: serde_json::Value =
            serde_json::from_str(&folder.text(&format!("{name}/manifest.json"))).unwrap();
        for (file, expected) in
            [("synthetic.exr", true), ("synthetic.png", true), ("gallery.html", false)]
        {
            let marked = manifest["files"][file]["denoised"].as_bool().unwrap_or(false);
            assert_eq!(marked, expected && is_denoised, "{name}/{file}");
        }
        let gallery = folder.text(&format!("{name}/gallery.html"));
        assert_eq!(gallery.contains("Denoised: neighbouring pixels"), is_denoised);
    }
}

#[test]
fn grain_goes_into_what_is_synthetic_alone() {
    let folder = Stage::new();
    folder.write("e.toml", &format!("project = \"8.toml\"\n{INSERT}"));
    folder.succeeds(&["e.toml", "--composite", "--spp", "64", "--out", "plain"]);
    folder.succeeds(&["e.toml", "--composite", "--spp", "64", "--grain", "--out", "grain"]);
    let [plain, grain] =
        ["plain", "grain"].map(|name| read(&folder.path(&format!("{name}/composite.png"))));
    let touched = read(&folder.path("plain/touched.png"));
    let pairs = plain.values.pixels().iter().zip(grain.values.pixels());
    for ((plain, grain), touched) in pairs.zip(touched.values.pixels()) {
        assert!(touched.x > 0.0 || plain == grain);
    }
}

#[test]
fn bad_edits_are_told_with_their_line() {
    let folder = Stage::new();
    let scene = "scene = \"scene.glb\"\n";
    let with = |edit: &str| format!("{scene}\n{edit}");
    for (edit, problem) in [
        ("[[remove]]\nname = \"sofa\"", "bad.toml: line 3: the scene has no \"sofa\" to remove"),
        ("\n[[repaint]]\ngroup = \"sofa\"\nrho_d = 0.5", "line 4: the scene has no group \"sofa\""),
        ("[[repaint]]\ngroup = \"floor\"\nrho_d = 1.5", "line 5, `rho_d = 1.5`: 1.5 cannot be"),
        ("[[repaint]]\ngroup = \"floor\"\nshiny = 1", "line 5, `shiny = 1`: unknown field"),
        ("[[repaint]]\ngroup = \"floor\"\ntexture = \"no.png\"", "line 3: no.png: cannot be read"),
        ("[[lights]]\nname = \"sun\"\nscale = 2", "line 3: the scene has no light \"sun\""),
        (
            "[[lights]]\nname = \"sun\"\nadd = \"laser\"",
            "line 5, `add = \"laser\"`: unknown variant",
        ),
        ("[[lights]]\nname = \"sun\"\nadd = \"spot\"", "line 3: a light that is added needs"),
        ("[[lights]]\nname = \"lamp\"\nremove = true", "nothing can be rendered after the edits"),
        ("[environment]\nfile = \"sky.hdr\"", "line 3: sky.hdr: cannot be read"),
        ("[environment]\nfile = \"scene.glb\"", "line 3: scene.glb: is not a PNG"),
        ("[[insert]]\nfile = \"no.glb\"\nposition = [0, 0, 0]", "line 3: no.glb: does not exist"),
        (
            "[[insert]]\nfile = \"box.glb\"\nposition = [0, 9, 0]",
            "line 3: \"box\" stands outside the scene",
        ),
        (
            "[[insert]]\nfile = \"box.glb\"\nname = \"wall\"\nposition = [0, 0, 0]",
            "line 3: something in the scene is called \"wall\" already",
        ),
        ("[[insert]]\nfile = \"box.glb\"\npixel = [3, 4]", "line 3: pixel needs the photograph"),
        ("[[insert]]\nfile = \"box.glb\"", "line 3: give one place"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]", "line 3: camera: in picture 1"),
        ("camera = \"door\"", "line 3: scene.glb: there is no camera \"door\""),
    ] {
        folder.refuses(&with(edit), problem);
    }
    let twice = format!("{scene}{INSERT}{INSERT}");
    folder.refuses(&twice, "line 6: something in the scene is called \"box\" already");
    folder.refuses("", "nothing to start from");
    folder.refuses("recovered = \"nowhere\"", "scene.glb: does not exist");
    let output = folder.restage(&["--scene", "scene.glb", "--remove", "sofa", "--out", "none"]);
    let said = stderr(&output);
    assert!(said.contains("--remove 'sofa': the scene has no \"sofa\""), "{said}");
    folder.write("c.toml", "project = \"8.toml\"\n[camera]\neye = [0, 1, 2]\ntarget = [0, 0, 0]\n");
    let output = folder.restage(&["c.toml", "--composite", "--out", "none"]);
    let said = stderr(&output);
    assert!(said.contains("c.toml: line 2: a composite is seen by"), "{said}");
}

/// An OBJ of a glossy tile, whose material states no BRDF model, as those of modelling programs.
fn glossy_tile(folder: &Folder) {
    folder.write("tile.mtl", "newmtl gloss\nKd 0.3 0.3 0.3\nKs 0.2 0.2 0.2\nNs 90\n");
    let tile = "mtllib tile.mtl\nv 0 0 0\nv 0.2 0 0\nv 0 0 -0.2\nusemtl gloss\nf 1 2 3\n";
    folder.write("tile.obj", tile);
}

#[test]
fn a_model_that_states_no_lobe_takes_the_lobe_of_the_scene_without_a_word() {
    let folder = Stage::new();
    glossy_tile(&folder);
    for lobe in ["ggx", "ward-gmd"] {
        folder.write("materials.json", &format!("{{\"brdf\": \"{lobe}\", \"groups\": {{}}}}"));
        let text = "scene = \"scene.glb\"\nmaterials = \"materials.json\"\n[[insert]]\nfile = \"tile.obj\"\n\
            on = \"floor\"\nat = [0.5, 0.4]\n";
        folder.write("e.toml", text);
        let output = folder.restage(&["e.toml", "--spp", "1", "--height", "8", "--out", lobe]);
        succeeds(&output);
        assert_eq!(stderr(&output), "");
    }
}
