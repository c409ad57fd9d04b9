//! What a project says of the light: the environment and the lights that the scene lacks. A corner
//! of a room whose file has no light at all is photographed, recovered and rendered again.

use glam::Vec3;
use std::path::PathBuf;
use std::process::{Command, Output};
use unrender::formats::picture::{self, Depth};
use unrender::formats::{gltf, materials};
use unrender::render::{Settings, Tracer};
use unrender::scene::color::srgb_from_linear;
use unrender::scene::{
    Camera, Environment, Group, Hypothesis, LightKind, Material, Mesh, Object, Rgb, RgbImage, Scene,
};
use unrender::{Job, Project};

const SIZE: (usize, usize) = (48, 36);
const FLOOR: Rgb = Rgb::new(0.5, 0.4, 0.3);
const WALL: Rgb = Rgb::new(0.3, 0.5, 0.6);
const AMBIENT: Rgb = Rgb::new(0.2, 0.25, 0.3);
const BULB: (Vec3, f32) = (Vec3::new(-0.6, 1.2, 0.2), 0.15);
const HEAD: &str =
    "scene = \"scene.glb\"\nphoto = \"photo.png\"\nresponse = \"srgb\"\nexposure = 1\n";
const LIGHTS: &str = "[environment]\ncolor = [0.2, 0.25, 0.3]\n\
    [[lights]]\nname = \"bulb\"\nadd = \"sphere\"\nposition = [-0.6, 1.2, 0.2]\nradius = 0.15\n\
    strength = [4, 4, 4]\n";

/// A folder with the scene, which has no light, and the photograph, which was taken in some.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let name = format!("unrender-light-{}-{test}", std::process::id());
        let folder = Self(std::env::temp_dir().join(name));
        std::fs::create_dir_all(&folder.0).unwrap();
        let mut scene = corner();
        std::fs::write(folder.path("scene.glb"), gltf::to_glb(&scene).unwrap()).unwrap();
        let radiance = photograph(&mut scene);
        let codes = radiance.map(|rgb| rgb.map(srgb_from_linear));
        picture::write_png_codes(&folder.path("photo.png"), &codes, Depth::Sixteen).unwrap();
        folder.write("project.toml", &format!("{HEAD}{LIGHTS}"));
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn read(&self, name: &str) -> RgbImage {
        picture::read(&self.path(name)).unwrap().0.values
    }

    /// The command with `arguments`, in this folder.
    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_unrender"));
        command.current_dir(&self.0).arg("--quiet").args(arguments).output().unwrap()
    }

    /// What it says on stderr when it succeeds.
    #[track_caller]
    fn succeeds(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{stderr}");
        stderr
    }

    /// Recovers the project with little effort and these `flags`, into `out`.
    #[track_caller]
    fn drafts(&self, flags: &[&str]) {
        let recover = ["recover", "project.toml", "--effort", "draft", "--out", "out"];
        self.succeeds(&[&recover[..], flags].concat());
    }

    /// Asserts that `check` refuses a project with the lines `text` because of `problem`.
    #[track_caller]
    fn refuses(&self, text: &str, problem: &str) {
        self.write("bad.toml", &format!("{HEAD}{text}"));
        let output = self.run(&["check", "bad.toml"]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.starts_with("error: ") && stderr.contains(problem), "{stderr}");
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that is left behind in the temporary files does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn corner() -> Scene {
    let mut scene = Scene::default();
    let (x, y, z) = (3.0 * Vec3::X, 2.0 * Vec3::Y, 3.0 * Vec3::Z);
    let low = Vec3::new(-1.5, 0.0, -1.5);
    for (name, rho_d, a, b, c) in [("floor", FLOOR, low + z, x, -z), ("wall", WALL, low, x, y)] {
        let mesh = Mesh::flat(&[a, a + b, a + b + c, a + c], &[], &[[0, 1, 2], [0, 2, 3]]);
        let group = scene.groups.len();
        let (material, emission) = (Material::diffuse(rho_d), Rgb::ZERO);
        scene.groups.push(Group { name: name.into(), material, emission });
        scene.objects.push(Object { name: name.into(), group, mesh });
    }
    let (eye, target) = (Vec3::new(0.3, 1.3, 2.6), Vec3::new(0.0, 0.5, -0.5));
    let camera = Camera::look_at("photo", eye, target, Vec3::Y, 0.8);
    scene.cameras.push(Camera { aspect: Some(48.0 / 36.0), ..camera });
    scene
}

/// Lights `scene` as it was and takes a photograph of it.
fn photograph(scene: &mut Scene) -> RgbImage {
    scene.environment = Environment::new(RgbImage::new(1, 1, vec![AMBIENT]), 0.0).ok();
    let group = scene.groups.len();
    let (material, emission) = (Material::diffuse(Rgb::ZERO), Rgb::splat(4.0));
    scene.groups.push(Group { name: "bulb".into(), material, emission });
    let mesh = Mesh::sphere(BULB.0, BULB.1);
    scene.objects.push(Object { name: "bulb".into(), group, mesh });
    scene.validate().unwrap();
    let settings = Settings { spp: 256, seed: 5, ..Settings::default() };
    let tracer = Tracer::new(scene);
    tracer.render(&scene.materials(), &scene.cameras[0], SIZE, &settings, &|_| ()).mean
}

/// The mean over the pixels of the largest difference of a channel.
fn difference(a: &RgbImage, b: &RgbImage) -> f32 {
    let pairs = a.pixels().iter().zip(b.pixels());
    let sum: f32 = pairs.map(|(a, b)| (*a - *b).abs().max_element()).sum();
    sum / a.pixels().len() as f32
}

#[test]
fn a_room_is_recovered_in_the_light_of_its_project() {
    let folder = Folder::new("recover");
    folder.succeeds(&["check", "project.toml"]);
    folder.drafts(&["--no-refine", "--spp", "16"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth) in [("floor", FLOOR), ("wall", WALL)] {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.01, "{name}: {rho_d}");
    }
    // The scene of the results has the light that glTF can hold, and says what it has not.
    let scene = gltf::read(&folder.path("out/scene.glb")).unwrap().0;
    let bulb = scene.group_index("bulb").unwrap();
    assert_eq!(scene.groups[bulb].emission, Rgb::splat(4.0));
    let page = std::fs::read_to_string(folder.path("out/report.html")).unwrap();
    assert!(page.contains("[0.2, 0.25, 0.3] from everywhere"));
    let size = ["--spp", "64", "--width", "48", "--height", "36"];
    let around = ["--camera", "photo"];
    let told = folder.succeeds(
        &[&["restage", "--recovered", "out", "--out", "alone"], &around[..], &size[..]].concat(),
    );
    assert!(told.contains("which scene.glb does not hold"), "{told}");
    folder.succeeds(&[
        "restage",
        "--recovered",
        "out",
        "--project",
        "project.toml",
        "--spp",
        "64",
        "--out",
        "new",
    ]);
    let photo = folder.read("photo.png");
    let (with, without) = (folder.read("new/synthetic.png"), folder.read("alone/synthetic.png"));
    assert!(difference(&with, &photo) < 0.01, "{}", difference(&with, &photo));
    assert!(difference(&without, &photo) > 0.1, "{}", difference(&without, &photo));
    let told = folder.succeeds(&["export", "out", "--to", "mitsuba", "--out", "mitsuba"]);
    assert!(told.contains("which is not exported"), "{told}");
}

#[test]
fn lights_are_put_in_place_before_their_names_are_looked_for() {
    let folder = Folder::new("names");
    let ambient = "[environment]\ncolor = 0.2\n";
    let lamp = |keys: &str| format!("{ambient}[[lights]]\nname = \"lamp\"\n{keys}");
    folder.refuses(&lamp("scale = 2\n"), "bad.toml: lights.lamp: the scene has no light \"lamp\"");
    folder.refuses(
        &lamp("add = \"point\"\nposition = [0, 1, 0]\nstrength = 1\n[groups.lamp]\nmax_rung = \"diffuse\"\n"),
        "groups.lamp: the scene has no group \"lamp\"",
    );
    folder.refuses(
        &lamp(
            "add = \"area\"\nposition = [0, 1, 0]\nstrength = 1\ndirection = [0, -1, 0]\n\
               size = [1, 1]\n[anchor]\ngroup = \"lamp\"\nrho_d = 0.5\n",
        ),
        "anchor.group: the group emits light",
    );
    let floor = "[[lights]]\nname = \"floor\"\nadd = \"sphere\"\nposition = [0, 1, 0]\nradius = 0.1\n\
        strength = 1\n";
    folder.refuses(floor, "a light or a group \"floor\" already");
    folder.refuses(
        "[environment]\npanorama = \"no.hdr\"\n",
        "environment.panorama: there is no file",
    );
    folder.write("text.hdr", "no picture");
    folder.refuses("[environment]\npanorama = \"text.hdr\"\n", "text.hdr: ");
    folder.refuses("", "the scene has no light");
}

#[test]
fn lights_of_a_project_may_be_unknown() {
    let folder = Folder::new("unknown");
    let text = LIGHTS.replace("[4, 4, 4]", "[3, 3, 3]\nunknown = true");
    folder.write("project.toml", &format!("{HEAD}{text}"));
    folder.drafts(&["--spp", "16"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let bulb = found.lights["bulb"].intensity.unwrap();
    assert!(bulb.iter().all(|v| (v - 4.0).abs() < 0.2), "{bulb:?}");
}

#[test]
fn of_lights_of_known_colour_one_factor_is_unknown() {
    let folder = Folder::new("colour");
    let text = LIGHTS.replace("[4, 4, 4]", "[1, 2, 3]\nunknown = true\ncolor = [5, 5, 5]");
    folder.write("project.toml", &format!("{HEAD}{text}"));
    folder.succeeds(&["recover", "project.toml", "--spp", "16", "--out", "out"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let bulb = &found.lights["bulb"];
    let [r, g, b] = bulb.intensity.unwrap();
    assert!((r - 4.0).abs() < 0.2 && r == g && r == b, "{r} {g} {b}");
    let std = bulb.std.unwrap();
    assert!(std[0] > 0.0 && std[0] == std[1], "{std:?}");
    // The colour of another light, at its own brightness.
    let twin = "[[lights]]\nname = \"twin\"\nadd = \"point\"\nposition = [1, 1, 0]\n\
        strength = 6\nunknown = true\nsame_color_as = \"bulb\"\n";
    let red = LIGHTS.replace("[4, 4, 4]", "[4, 2, 0]");
    folder.write("project.toml", &format!("{HEAD}{red}{twin}"));
    let (project, warnings) = Project::read(&folder.path("project.toml")).unwrap();
    let job = Job::load(project, warnings).unwrap();
    assert_eq!(job.scene.lights[0].kind.strength(), Rgb::new(12.0, 6.0, 0.0));
    assert_eq!(job.project.coloured_sources(&job.scene), job.unknown_lights);
    folder.refuses(&twin.replace("\"bulb\"", "\"none\""), "the scene has no light \"none\"");
}

#[test]
fn edits_have_the_same_lights_and_environments() {
    let folder = Folder::new("edits");
    let lit = LIGHTS.replace("4, 4, 4", "1, 2, 4");
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}"));
    folder.write("lit.toml", &format!("{HEAD}{lit}"));
    let sphere = "[[lights]]\nname = \"bulb\"\nscale = [0.25, 0.5, 1]\n";
    folder.write("edit.toml", &format!("project = \"project.toml\"\n{sphere}"));
    folder.write("none.toml", "project = \"lit.toml\"\n");
    for name in ["edit", "none"] {
        let (file, out) = (format!("{name}.toml"), format!("{name}.out"));
        folder.succeeds(&["restage", &file, "--spp", "2", "--out", &out]);
    }
    let of = |name: &str| std::fs::read(folder.path(name).join("synthetic.exr")).unwrap();
    assert_eq!(of("edit.out"), of("none.out"));
    let edit = |text: &str| {
        folder.write("edit.toml", &format!("project = \"project.toml\"\n{text}"));
        let arguments = ["restage", "edit.toml", "--spp", "1", "--out", "new"];
        String::from_utf8(folder.run(&arguments).stderr).unwrap()
    };
    let told = edit("[[lights]]\nname = \"bulb\"\nunknown = true\n");
    assert!(told.contains("edit.toml: line 2: unknown is a key of project files"), "{told}");
    let told = edit("[[lights]]\nname = \"bulb\"\ncolor = 1\n");
    assert!(told.contains("line 2: color and same_color_as are keys of project files"), "{told}");
    let told = edit("[environment]\ncolor = 1\nrotation_deg = 3\n");
    assert!(told.contains("edit.toml: line 2: environment: rotation_deg and scale"), "{told}");
    let told = edit(
        "[environment]\ncolor = [1, 0, 0]\n[[lights]]\nname = \"ball\"\nadd = \"sphere\"\n\
         position = [0, 1, 0]\nradius = 0.1\nstrength = 1\n",
    );
    assert_eq!(told, "");
}

#[test]
fn panoramas_turn_and_scale_as_in_edits() {
    let folder = Folder::new("panorama");
    let sky = RgbImage::from_fn(16, 8, |x, y| Rgb::splat((x * y) as f32));
    picture::write_exr(&folder.path("sky.exr"), &sky).unwrap();
    let text = "[environment]\npanorama = \"sky.exr\"\nrotation_deg = 90\nscale = 0.5\n";
    let path = folder.path("a.toml");
    folder.write(
        "a.toml",
        &format!(
            "{HEAD}{text}[[lights]]\nname = \"sun\"\nadd = \"directional\"\n\
        direction = [0, -2, 0]\nstrength = [1, 2, 3]\nscale = 2\n"
        ),
    );
    let (project, warnings) = Project::read(&path).unwrap();
    let job = Job::load(project, warnings).unwrap();
    let environment = job.scene.environment.unwrap();
    assert_eq!(*environment.panorama().at(3, 2), Rgb::splat(3.0));
    assert!((environment.place(Vec3::NEG_X).0 - 0.5).abs() < 1e-6);
    let sun =
        LightKind::Directional { direction: Vec3::NEG_Y, irradiance: Rgb::new(2.0, 4.0, 6.0) };
    assert_eq!(job.scene.lights[0].kind, sun);
}

/// Paints the right half of the photograph white, as if something stood there that the model lacks.
fn spoil(folder: &Folder) {
    let photo = folder.read("photo.png");
    let spoiled = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        if x < SIZE.0 / 2 { *photo.at(x, y) } else { Rgb::new(0.9, 0.1, 0.1) }
    });
    picture::write_png_codes(&folder.path("photo.png"), &spoiled, Depth::Sixteen).unwrap();
}

#[test]
fn what_the_mask_leaves_out_does_not_count() {
    let folder = Folder::new("mask");
    spoil(&folder);
    let mask = |width: usize| {
        let white = |x: usize| Rgb::splat(f32::from(u8::from(x < SIZE.0 / 2)));
        let mask = RgbImage::from_fn(width, SIZE.1, |x, _| white(x));
        picture::write_png_codes(&folder.path("mask.png"), &mask, Depth::Eight).unwrap();
    };
    mask(SIZE.0 - 1);
    let ambient = "[environment]\ncolor = 1\n";
    folder.refuses(
        &format!("mask = \"mask.png\"\n{ambient}"),
        "mask.png: the mask has 47 x 36 pixels and the photo 48 x 36",
    );
    folder.refuses("mask = \"none.png\"\n", "bad.toml: mask: there is no file");
    mask(SIZE.0);
    folder.write("project.toml", &format!("{HEAD}mask = \"mask.png\"\n{LIGHTS}"));
    folder.succeeds(&[
        "recover",
        "project.toml",
        "--no-refine",
        "--keep-camera",
        "--spp",
        "4",
        "--out",
        "out",
    ]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth) in [("floor", FLOOR), ("wall", WALL)] {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.02, "{name}: {rho_d}");
    }
    let trust = folder.read("out/trust.png");
    let left_out = *trust.at(40, 30);
    assert!(left_out.x > left_out.y && left_out.z > left_out.x, "violet: {left_out}");
}

#[test]
fn ignored_groups_are_not_asked_for_and_not_counted() {
    let folder = Folder::new("ignore");
    folder.refuses("[groups.door]\nignore = true\n[environment]\ncolor = 1\n", "no group \"door\"");
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}[groups.wall]\nignore = true\n"));
    folder.succeeds(&["check", "project.toml"]);
    folder.drafts(&["--no-refine", "--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let floor = Rgb::from_array(found.groups["floor"].rho_d.unwrap());
    assert!((floor - FLOOR).abs().max_element() < 0.02, "{floor}");
    let wall = Rgb::from_array(found.groups["wall"].rho_d.unwrap());
    assert!((wall - WALL).abs().max_element() < 1e-5, "as in the scene: {wall}");
    let run = std::fs::read_to_string(folder.path("out/run.json")).unwrap();
    let run: serde_json::Value = serde_json::from_str(&run).unwrap();
    let wall = &run["groups"]["wall"];
    assert_eq!((&wall["asked"], &wall["counted"]["valid"]), (&false.into(), &0.into()));
    assert!(run["groups"]["floor"]["counted"]["valid"].as_u64() > Some(100));
}

#[test]
fn groups_have_the_hypotheses_that_are_allowed() {
    let folder = Folder::new("rungs");
    let rungs = "[recover]\nrungs = [\"diffuse\"]\n[groups.floor]\nrungs = [\"isotropic\"]\n";
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}{rungs}"));
    folder.drafts(&["--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth, hypothesis) in
        [("floor", FLOOR, Hypothesis::Isotropic), ("wall", WALL, Hypothesis::Diffuse)]
    {
        let entry = &found.groups[name];
        assert_eq!(entry.hypothesis, Some(hypothesis), "{name}: {:?}", entry.note);
        let rho_d = Rgb::from_array(entry.rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.05, "{name}: {rho_d}");
    }
    folder.succeeds(&[
        "recover",
        "project.toml",
        "--max-rung",
        "diffuse",
        "--no-refine",
        "--spp",
        "1",
        "--out",
        "plain",
    ]);
    let found = materials::read(&folder.path("plain/materials.json")).unwrap();
    assert_eq!(found.groups["floor"].hypothesis, Some(Hypothesis::Diffuse));
}

#[test]
fn bounds_of_a_project_are_kept_by_its_results() {
    let folder = Folder::new("bounds");
    let bounds = "[groups.floor]\nalpha_x = { start = 0.4, min = 0.3 }\n[groups.wall]\n\
                  rho_d = { max = [1, 0.2, 1] }\nrho_s = { max = 0 }\n[recover]\nmax_rung = \"isotropic\"\n";
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}{bounds}"));
    folder.drafts(&["--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let [floor, wall] = ["floor", "wall"].map(|name| &found.groups[name]);
    let is_rough = floor.alpha_x.is_some_and(|alpha| alpha >= 0.3);
    assert!(is_rough || floor.hypothesis == Some(Hypothesis::Diffuse), "{floor:?}");
    assert_eq!((wall.hypothesis, wall.rho_d.unwrap()[1]), (Some(Hypothesis::Diffuse), 0.2));
    let note = wall.note.as_deref().unwrap_or_default();
    assert!(note.contains("rho_d lies on its bound max = [1, 0.2, 1] in green"), "{note}");
}

#[test]
fn groups_of_one_material_are_recovered_as_one() {
    let folder = Folder::new("same");
    let same = "[groups.wall]\nsame_as = \"floor\"\n[recover]\nmax_rung = \"diffuse\"\n";
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}{same}"));
    folder.succeeds(&["check", "project.toml"]);
    folder.drafts(&["--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let [floor, wall] = ["floor", "wall"].map(|name| &found.groups[name]);
    assert_eq!((floor.rho_d, floor.hypothesis), (wall.rho_d, wall.hypothesis));
    assert_eq!(floor.std, wall.std);
    let red = floor.rho_d.unwrap()[0];
    assert!(red > WALL.x + 0.02 && red < FLOOR.x - 0.02, "between both: {red}");
    let note = wall.note.as_deref().unwrap();
    assert!(note.starts_with("one material with \"floor\", as the project says"), "{note}");
    // The scene keeps both groups, each with its own objects.
    let written = unrender::formats::load_model(&folder.path("out/scene.glb")).unwrap().0;
    let truth = corner();
    for (object, was) in written.objects.iter().zip(&truth.objects) {
        assert_eq!(written.groups[object.group].name, truth.groups[was.group].name);
    }
    let [a, b] = ["floor", "wall"].map(|name| &written.groups[written.group_index(name).unwrap()]);
    assert_eq!(a.material.rho_d, b.material.rho_d);
}

#[test]
fn a_project_is_rendered_as_its_photograph_was_taken() {
    let folder = Folder::new("render");
    let output =
        folder.run(&["render", "scene.glb", "--project", "project.toml", "--out", "a.exr"]);
    assert_eq!(output.status.code(), Some(2), "a scene or a project");
    folder.succeeds(&["render", "--project", "project.toml", "--spp", "64", "--out", "a.png"]);
    let (made, photo) = (folder.read("a.png"), folder.read("photo.png"));
    assert_eq!((made.width(), made.height()), SIZE);
    assert!(difference(&made, &photo) < 0.01, "{}", difference(&made, &photo));
    folder
        .write("project.toml", &format!("{HEAD}{LIGHTS}[groups.wall]\nknown = {{ rho_d = 0 }}\n"));
    folder.succeeds(&["render", "--project", "project.toml", "--height", "18", "--out", "b.png"]);
    let made = folder.read("b.png");
    assert_eq!((made.width(), made.height()), (24, 18));
    assert!(made.at(12, 1).max_element() < 0.01, "the wall is black: {}", made.at(12, 1));
    let output =
        folder.run(&["render", "--project", "project.toml", "--spp", "1", "--out", "photo.png"]);
    assert_eq!(output.status.code(), Some(1), "the photograph is kept");
}

#[test]
fn from_the_white_level_on_a_photograph_is_clipped() {
    let folder = Folder::new("white");
    let clipped = |line: &str| {
        folder.write("project.toml", &format!("{HEAD}{line}{LIGHTS}"));
        let (project, warnings) = Project::read(&folder.path("project.toml")).unwrap();
        Job::load(project, warnings).unwrap().photo.clipped
    };
    let [all, some, none] = ["white_level = 0.001\n", "white_level = 0.4\n", ""].map(clipped);
    let over = folder.read("photo.png");
    let over = over.pixels().iter().filter(|code| code.max_element() >= 0.4).count();
    assert_eq!((all, some), (SIZE.0 * SIZE.1, over));
    // The bulb is clipped in any case.
    assert!(none < some && some < all, "{none} {some}");
    folder.refuses(
        "white_level = 250\n[environment]\ncolor = 1\n",
        "bad.toml: white_level is [250, 250, 250]; it is a code of at most 1",
    );
}
