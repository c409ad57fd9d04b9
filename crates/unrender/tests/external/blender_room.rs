//! A furnished room from Blender, exported by its own exporter with default settings: our rendering
//! agrees with that of Cycles, and so does the room brought back to Blender in both ways.

use crate::kit::example::beside_crates;
use crate::kit::programs::{compare, installed, need, our_picture};
use std::path::{Path, PathBuf};
use std::process::Command;
use unrender::formats::{load_scene, picture};
use unrender::scene::{BrdfModel, LightKind, Rgb, RgbImage, Scene};

/// Columns of the pictures; with these the smallest object has 40 pixels.
const WIDTH: usize = 320;
const SIZE: (usize, usize) = (WIDTH, WIDTH * 3 / 4);
/// Samples per pixel, of Cycles and of ours.
const SPP: u32 = 256;
const LAMPS: [&str; 4] = ["panel", "bulb", "spot", "sun"];
/// Pixels of a group that is compared. The means of 77 pixels differ by 1.3 % for noise alone; those of so many by 0.8 %.
const LEAST: usize = 200;
/// The largest allowed error of a group's mean, relative to its brightest channel, and of the mean of the picture by one
/// light alone.
const GROUP: f32 = 0.03;
const LIGHT: f64 = 0.01;

#[test]
#[ignore = "slow: needs Blender, which .ci/programs installs"]
fn a_room_from_blender_is_read_as_it_is_meant_and_goes_back() {
    let Some(bpy) = need(installed("bpy")) else { return };
    let room = Room { python: bpy.join("bin/python"), folder: tempfile::tempdir().unwrap() };
    let script = beside_crates("examples/blender/room.py");
    let at = |name: &str| room.folder.path().join(name);
    room.python(&[
        &script,
        &at(""),
        Path::new("--size"),
        &text(WIDTH),
        Path::new("--spp"),
        &text(SPP),
    ]);
    room.check_is_clean();

    let scene = room.scene();
    let groups = scene.groups.len();
    assert!(groups >= 20, "{groups} groups");
    let of_cycles = Photographs::read(room.folder.path());
    of_cycles.agree(&scene, &Photographs::of(&scene), "ours");

    let glb = at("room.glb");
    for (way, exported, source) in
        [("blender", at("back"), at("back/scene.py")), ("gltf", at("back.glb"), at("back.glb"))]
    {
        let mut export = Command::new(env!("CARGO_BIN_EXE_unrender"));
        export
            .arg("export")
            .arg("--scene")
            .arg(&glb)
            .args(["--to", way])
            .arg("--out")
            .arg(exported);
        assert!(export.arg("--quiet").status().unwrap().success(), "export --to {way}");
        let again = beside_crates("crates/unrender/tests/external/blender_again.py");
        let out = at(&format!("again_{way}"));
        room.python(&[&again, &script, &source, &out, &text(SPP), &text(WIDTH)]);
        of_cycles.agree(&scene, &Photographs::read(&out), way);
    }
}

fn text(number: impl ToString) -> PathBuf {
    number.to_string().into()
}

/// The folder in which the room is made.
struct Room {
    python: PathBuf,
    folder: tempfile::TempDir,
}

impl Room {
    fn python(&self, words: &[&Path]) {
        let output = Command::new(&self.python).args(words).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{words:?}: {said}");
    }

    fn scene(&self) -> Scene {
        let (scene, _) = load_scene(&self.folder.path().join("room.glb")).unwrap();
        Scene { brdf: BrdfModel::Ggx, ..scene }
    }

    /// Nothing has to be mended; a warning states how the lights were read.
    fn check_is_clean(&self) {
        let project = self.folder.path().join("room.toml");
        let says = "scene = \"room.glb\"\nphoto = \"room.exr\"\nresponse = \"linear\"\n\
                    exposure = 1.0\n[recover]\nbrdf = \"ggx\"\n";
        std::fs::write(&project, says).unwrap();
        let mut check = Command::new(env!("CARGO_BIN_EXE_unrender"));
        check.arg("check").arg(&project).arg("--out").arg(self.folder.path().join("check.png"));
        let output = check.output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && said.contains("1 thing(s) to look at"), "{said}");
        assert!(said.contains("Blender's Standard units"), "{said}");
    }
}

/// The room by all lights, and by each alone.
struct Photographs {
    all: RgbImage,
    alone: Vec<RgbImage>,
}

impl Photographs {
    fn read(folder: &Path) -> Self {
        let read = |name: String| picture::read(&folder.join(name)).unwrap().0.to_linear();
        let alone = LAMPS.map(|lamp| read(format!("light_{lamp}.exr")));
        Self { all: read("room.exr".into()), alone: alone.to_vec() }
    }

    /// Ours.
    fn of(scene: &Scene) -> Self {
        let picture = |scene: &Scene| our_picture(scene, &scene.cameras[0], SIZE, SPP);
        let alone = LAMPS.map(|lamp| picture(&by(scene, lamp)));
        Self { all: picture(scene), alone: alone.to_vec() }
    }

    /// Asserts that groups and lights are as bright in `other`.
    fn agree(&self, scene: &Scene, other: &Self, name: &str) {
        for row in compare(scene, &scene.cameras[0], &self.all, &other.all, LEAST) {
            let group = &scene.groups[row.group].name;
            let off = (row.theirs - row.ours).abs().max_element() / row.ours.max_element();
            println!("{name}, {group}: {} {} {:.2} %", row.ours, row.theirs, 100.0 * off);
            assert!(off < GROUP, "{name}: {group} is {:.2} % off", 100.0 * off);
        }
        for (lamp, (mine, theirs)) in LAMPS.iter().zip(self.alone.iter().zip(&other.alone)) {
            let off = mean(theirs) / mean(mine) - 1.0;
            println!("{name}, {lamp}: {:+.2} %", 100.0 * off);
            assert!(off.abs() < LIGHT, "{name}: {lamp} is {:+.2} % off", 100.0 * off);
        }
    }
}

/// The scene by one lamp alone.
fn by(scene: &Scene, lamp: &str) -> Scene {
    let mut scene = scene.clone();
    for group in scene.groups.iter_mut().filter(|group| group.name != lamp) {
        group.emission = Rgb::ZERO;
    }
    scene.lights.retain(|light| light.name == lamp);
    let kinds = scene.lights.iter().map(|light| &light.kind);
    let suns = kinds.filter(|kind| matches!(kind, LightKind::Directional { .. })).count();
    assert!(
        scene.lights.len() == usize::from(lamp != "panel") && suns == usize::from(lamp == "sun")
    );
    scene
}

fn mean(picture: &RgbImage) -> f64 {
    let sum: f64 = picture.pixels().iter().map(|rgb| f64::from(rgb.element_sum())).sum();
    sum / (3 * picture.pixels().len()) as f64
}
