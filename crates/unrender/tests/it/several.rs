//! Several photographs of one room: from two places, under switched lamps, at unknown exposures.

use crate::kit::coloured_room::{self, EXPOSURE, room};
use crate::kit::folder::Folder;
use crate::kit::meshes::{add, square};
use glam::Vec3;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use unrender::Project;
use unrender::formats::materials::MaterialsFile;
use unrender::formats::{gltf, materials, picture};
use unrender::render::{Integrator, Settings, Tracer};
use unrender::run::Run;
use unrender::scene::{Camera, Image, Material, Rgb, RgbImage, Scene};

const SIZE: (usize, usize) = (108, 90);
/// The photograph from the other place has other pixels.
const OTHER_SIZE: (usize, usize) = (120, 128);

/// The room of five colours with a second lamp and a second camera.
fn scene() -> Scene {
    let mut scene = room();
    add(&mut scene, "spare", Rgb::ZERO, square(Vec3::new(-0.97, 0.2, 0.3), Vec3::X, 0.25));
    scene.groups[6].emission = Rgb::new(5.0, 8.0, 12.0);
    let (eye, target) = (Vec3::new(-0.6, 0.3, 2.2), Vec3::new(0.3, -0.2, 0.0));
    scene.cameras.push(Camera::look_at("aside", eye, target, Vec3::Y, 0.95));
    scene.validate().unwrap();
    scene
}

/// A photograph's file, the camera and the size of it, and the lamps that are off.
type Shot = (&'static str, (usize, (usize, usize)), &'static [&'static str]);

const SHOTS: [Shot; 3] = [
    ("front.exr", (0, SIZE), &[]),
    ("aside.exr", (1, OTHER_SIZE), &[]),
    ("evening.exr", (0, SIZE), &["lamp"]),
];

/// The photographs, rendered once for all tests.
static TAKEN: LazyLock<[RgbImage; 3]> =
    LazyLock::new(|| SHOTS.map(|shot| photograph(Integrator::PathReuse, shot)));

/// The photograph of a camera while some lamps are off, with the noise of `integrator`: paths that pixels share, or
/// independent ones.
fn photograph(integrator: Integrator, (_, (camera, size), off): Shot) -> RgbImage {
    let mut scene = scene();
    let is_off = |name: &String| off.contains(&name.as_str());
    scene.groups.iter_mut().filter(|g| is_off(&g.name)).for_each(|g| g.emission = Rgb::ZERO);
    let settings =
        Settings { spp: 64, seed: 77 + camera as u64, integrator, ..Settings::default() };
    let (materials, camera) = (scene.materials(), &scene.cameras[camera]);
    let radiance = Tracer::new(&scene).render(&materials, camera, size, &settings, &|_| {}).mean;
    radiance.map(|v| *v / EXPOSURE)
}

/// A folder with the room in grey, those of its photographs that the project names, and the project `text`.
fn folder(text: &str) -> Folder {
    let folder = Folder::new();
    for ((file, ..), taken) in SHOTS.iter().zip(TAKEN.iter()) {
        if text.contains(file) {
            picture::write_exr(&folder.path(file), taken).unwrap();
        }
    }
    let mut grey = scene();
    for group in grey.groups.iter_mut().filter(|group| !group.is_emitter()) {
        group.material = Material::diffuse(Rgb::splat(0.5));
    }
    folder.write("scene.glb", &gltf::to_glb(&grey).unwrap());
    folder.write("project.toml", text);
    folder
}

fn recover(folder: &Folder, out: &str, arguments: &[&str]) -> MaterialsFile {
    let out = folder.path(out);
    let mut recover = Command::new(env!("CARGO_BIN_EXE_unrender"));
    recover.arg("recover").arg(folder.path("project.toml")).arg("--out").arg(&out);
    recover.args(["--effort", "draft", "--spp", "8", "--max-rung", "diffuse"]).args(arguments);
    let output = recover.output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    println!("{}{}", text(&output.stderr), text(&output.stdout));
    materials::read(&out.join("materials.json")).unwrap()
}

/// The largest error of a reflectance.
fn worst(found: &MaterialsFile) -> f32 {
    coloured_room::worst(|name| Rgb::from_array(found.groups[name].rho_d.unwrap()))
}

const FROM_TWO_PLACES: &str = "scene = \"scene.glb\"\nresponse = \"linear\"\n\
    [[photos]]\nphoto = \"front.exr\"\ncamera = \"camera\"\nexposure = 2.4\n\
    [[photos]]\nphoto = \"aside.exr\"\ncamera = \"aside\"\nexposure = \"auto\"\n";

/// The recovery from two places on three threads, made once for all tests, in "out" of its folder.
static FROM_TWO: LazyLock<(Folder, MaterialsFile)> = LazyLock::new(|| {
    let folder = folder(FROM_TWO_PLACES);
    let found = recover(&folder, "out", &["--threads", "3"]);
    (folder, found)
});

#[test]
fn two_photographs_give_one_set_of_materials_and_each_its_pictures() {
    let (folder, found) = &*FROM_TWO;
    assert!(worst(found) < 0.004, "{}", worst(found));
    let [first, second] = &found.photographs[..] else { panic!("two photographs") };
    assert_eq!(first.exposure, Some([EXPOSURE; 3]));
    let std = second.std.as_ref().unwrap().exposure.unwrap();
    for (found, std) in second.exposure.unwrap().into_iter().zip(std) {
        assert!(std > 0.0 && std < 0.01 * EXPOSURE, "{std}");
        assert!((found - EXPOSURE).abs() < 3.0 * std + 1e-3 * EXPOSURE, "{found}, std {std}");
    }
    let out = folder.path("out");
    let run = Run::read(&out).unwrap();
    assert_eq!(run.photographs.len(), 2);
    for (k, (of, size)) in run.photographs.iter().zip([SIZE, OTHER_SIZE]).enumerate() {
        let number = k + 1;
        assert_eq!((of.width, of.height), size);
        assert_eq!(of.pictures.rerendered, format!("rerendered_{number}.png"));
        for file in [&of.pictures.photo, &of.pictures.trust, &format!("rerendered_{number}.exr")] {
            let shown = picture::read(&out.join(file)).unwrap().0.values;
            assert_eq!((shown.width(), shown.height()), size, "{file}");
        }
        assert!(out.join(format!("error_{number}.png")).is_file());
    }
    assert!(!out.join("photo.png").exists());
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    for heading in ["Photograph 1: front.exr", "Photograph 2: aside.exr"] {
        assert!(page.contains(heading), "{heading}");
    }
}

/// Makes squares of eight pixels of `file` alternately a quarter brighter and darker.
fn chequer(folder: &Folder, file: &str) {
    let (picture, _) = picture::read(&folder.path(file)).unwrap();
    let values = &picture.values;
    let square = |x: usize, y: usize| if (x / 8 + y / 8).is_multiple_of(2) { 1.25 } else { 0.75 };
    let chequered =
        Image::from_fn(values.width(), values.height(), |x, y| square(x, y) * *values.at(x, y));
    picture::write_exr(&folder.path(file), &chequered).unwrap();
}

#[test]
fn what_the_model_lacks_makes_no_exposure_smaller() {
    let folder = folder(FROM_TWO_PLACES);
    chequer(&folder, "aside.exr");
    let found = recover(&folder, "out", &[]);
    // Its standard deviation is 3 %. With the photograph's own values in the derivatives, the exposure is a quarter
    // too small.
    for found in found.photographs[1].exposure.unwrap() {
        assert!((found / EXPOSURE - 1.0).abs() < 0.04, "{found}");
    }
}

#[test]
fn the_bits_are_the_same_with_one_thread_and_with_three() {
    let read = |folder: &Folder| {
        let file = std::fs::read(folder.path("out/materials.json")).unwrap();
        let mut found: serde_json::Value = serde_json::from_slice(&file).unwrap();
        found["seconds"] = 0.into();
        found
    };
    let (three, one) = (&FROM_TWO.0, folder(FROM_TWO_PLACES));
    recover(&one, "out", &["--threads", "1"]);
    assert_eq!(read(&one), read(three));
    let bytes = |of: &Folder| std::fs::read(of.path("out/rerendered_2.exr")).unwrap();
    assert!(bytes(&one) == bytes(three));
}

#[test]
fn a_list_of_one_photograph_is_that_photograph_to_the_bit() {
    let alone = "scene = \"scene.glb\"\nphoto = \"front.exr\"\nresponse = \"linear\"\nexposure = 2.4\n\
                 camera = \"camera\"\n";
    let listed = "scene = \"scene.glb\"\nresponse = \"linear\"\n[[photos]]\nphoto = \"front.exr\"\nexposure = 2.4\n\
                  camera = \"camera\"\n";
    let found = [alone, listed].map(|text| recover(&folder(text), "out", &["--no-refine"]));
    assert_eq!(found[0].groups, found[1].groups);
    assert!(found[1].photographs.is_empty());
}

#[test]
fn switched_lamps_tell_what_each_of_them_brings() {
    let text = "scene = \"scene.glb\"\nresponse = \"linear\"\nexposure = 2.4\ncamera = \"camera\"\n\
                [[photos]]\nphoto = \"front.exr\"\n\
                [[photos]]\nphoto = \"evening.exr\"\nlights_on = [\"spare\"]\n\
                [lights.spare]\nunknown = true\n";
    let found = recover(&folder(text), "out", &[]);
    assert!(worst(&found) < 0.005, "{}", worst(&found));
    let light = &found.lights["spare"];
    let [found, std] = [light.intensity, light.std].map(Option::unwrap);
    for (c, truth) in [5.0, 8.0, 12.0].into_iter().enumerate() {
        assert!((found[c] - truth).abs() < 3.0 * std[c] + 0.002 * truth, "{found:?}, {std:?}");
    }
}

fn mean(picture: &Image<Rgb>) -> f32 {
    picture.pixels().iter().sum::<Rgb>().element_sum() / picture.pixels().len() as f32
}

#[test]
fn lamps_that_were_off_are_off_in_a_restaged_picture() {
    let folder = folder(
        "scene = \"scene.glb\"\nresponse = \"linear\"\nexposure = 2.4\ncamera = \"camera\"\n\
         [[photos]]\nphoto = \"evening.exr\"\nlights_off = [\"lamp\"]\n",
    );
    let text = std::fs::read_to_string(folder.path("project.toml")).unwrap();
    folder.write("lit.toml", &text.replace("lights_off = [\"lamp\"]\n", ""));
    let restaged = |(project, lights): (&str, &[&str])| {
        folder.write("edit.toml", &format!("project = \"{project}.toml\"\n"));
        let out = folder.path(&format!("{project}{}", lights.len()));
        let mut restage = Command::new(env!("CARGO_BIN_EXE_unrender"));
        restage.arg("restage").arg(folder.path("edit.toml"));
        lights.iter().for_each(|light| {
            restage.args(["--light", light]);
        });
        let status = restage.args(["--spp", "8", "--quiet", "--out"]).arg(&out).status().unwrap();
        assert!(status.success());
        mean(&picture::read(&out.join("synthetic.exr")).unwrap().0.values)
    };
    let [evening, lit] = [("project", &[][..]), ("lit", &[])].map(restaged);
    assert!(evening < 0.6 * lit, "{evening} of {lit}");
    // One that was off is as bright as in the scene when it is switched on; one that is on stays so.
    assert_eq!(restaged(("project", &["lamp: on", "spare: on"])), lit);
    assert_eq!(restaged(("lit", &["lamp: off"])), evening);
}

#[test]
fn a_photograph_is_rendered_again_by_its_number_and_under_its_lamps() {
    let text = "scene = \"scene.glb\"\nresponse = \"linear\"\nexposure = 2.4\n\
        [[photos]]\nphoto = \"aside.exr\"\ncamera = \"aside\"\n\
        [[photos]]\nphoto = \"evening.exr\"\ncamera = \"camera\"\nlights_off = [\"lamp\"]\n";
    let folder = folder(text);
    let render = |number: &str, more: &[&str]| {
        let out = folder.path(&format!("{number}.exr"));
        let mut render = Command::new(env!("CARGO_BIN_EXE_unrender"));
        render.args(["render", "--project"]).arg(folder.path("project.toml"));
        render.args(["--photo", number, "--spp", "8", "--quiet", "--out"]).arg(&out).args(more);
        let output = render.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        output.status.success().then(|| picture::read(&out).unwrap().0.values).ok_or(said)
    };
    let [aside, evening] = ["1", "2"].map(|number| render(number, &[]).unwrap());
    let with_all =
        render("1", &["--camera", "camera", "--width", "108", "--height", "90"]).unwrap();
    assert_eq!((aside.width(), aside.height()), OTHER_SIZE);
    assert_eq!((evening.width(), evening.height()), SIZE);
    let [evening, with_all] = [mean(&evening), mean(&with_all)];
    assert!(evening < 0.6 * with_all, "{evening} of {with_all}");
    let said = render("3", &[]).unwrap_err();
    assert!(said.contains("--photo 3") && said.contains("has 2 photograph"), "{said}");
}

#[test]
fn each_photograph_is_checked() {
    let folder = folder(FROM_TWO_PLACES);
    let mut check = Command::new(env!("CARGO_BIN_EXE_unrender"));
    check.arg("check").arg(folder.path("project.toml")).arg("--out").arg(folder.path("c.png"));
    let output = check.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("front.exr: \n") && text.contains("aside.exr: \n"), "{text}");
    assert!(folder.path("c.png").is_file() && folder.path("c_2.png").is_file());
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let refused = |text: &str, problem: &str| {
        let text = format!("scene = \"s.glb\"\n{text}");
        let error = Project::parse(Path::new("folder/a.toml"), &text).expect_err(&text).to_string();
        assert!(error.starts_with("folder/a.toml: ") && error.contains(problem), "{text}: {error}");
    };
    refused("", "give photo = \"FILE\", or several in a list [[photos]]");
    refused("[[photos]]\ncamera = \"a\"", "photos, number 1: give it a photo");
    refused(
        &"[[photos]]\nphoto = \"a.png\"\n".repeat(65),
        "photos: there are 65 of them; at most 64",
    );
    refused("[[photos]]\nphoto = \"a.png\"\nscene = \"b\"", "line 4: unknown field `scene`");
    refused(
        "[[photos]]\nphoto = \"a.png\"\nlights_on = []\nlights_off = []",
        "photos, number 1: give lights_off or lights_on, not both",
    );
    refused(
        "[anchor]\ngroup = \"w\"\nrho_d = 0.5\n[[photos]]\nphoto = \"a.png\"\n\
         [[photos]]\nphoto = \"b.png\"\nexposure = 2",
        "number 2 states its exposure and number 1 does not",
    );
    refused("[[photos]]\nphoto = \"a.png\"\nexposure = \"auto\"", "needs a table [anchor]");
    let text = "scene = \"s.glb\"\nlights_off = [\"lamp\"]\nphoto = \"a.png\"";
    let error = Project::parse(Path::new("a.toml"), text).unwrap_err().to_string();
    assert!(error.contains("line 2: unknown field `lights_off`"), "{error}");
    let text = format!("{FROM_TWO_PLACES}lights_off = [\"lmap\"]\n");
    let mut recover = Command::new(env!("CARGO_BIN_EXE_unrender"));
    let folder = folder(&text);
    let output = recover.arg("recover").arg(folder.path("project.toml")).arg("--out");
    let output = output.arg(folder.path("out")).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(text.contains("lights_off, in ") && text.contains("no light \"lmap\""), "{text}");
    assert!(!folder.path("out").exists());
    folder.write("points.csv", "");
    let mut calibrate = Command::new(env!("CARGO_BIN_EXE_unrender"));
    calibrate.arg("calibrate").arg("--points").arg(folder.path("points.csv"));
    let output = calibrate.arg("--out").arg(folder.path("project.toml")).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && text.contains("project of several photographs"), "{text}");
}

#[test]
fn a_plan_ranks_what_could_be_photographed_next() {
    let front = "scene = \"scene.glb\"\nphoto = \"front.exr\"\nresponse = \"linear\"\nexposure = 2.4\n\
                 camera = \"camera\"\n";
    let folder = folder(front);
    // Independent noise in each pixel, like a camera's: without it, only the noise of the renderings limits the
    // accuracy.
    let taken = photograph(Integrator::Path, SHOTS[0]);
    picture::write_exr(&folder.path("front.exr"), &taken).unwrap();
    recover(&folder, "out", &[]);
    let mut plan = Command::new(env!("CARGO_BIN_EXE_unrender"));
    plan.arg("plan").arg(folder.path("project.toml")).arg("--recovered").arg(folder.path("out"));
    let output = plan.args(["--json", "--quiet"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let plan: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let candidates = plan["candidates"].as_array().unwrap();
    let ratios: Vec<f64> = candidates.iter().map(|one| one["ratio"].as_f64().unwrap()).collect();
    assert!(ratios.is_sorted(), "{ratios:?}");
    // A second photograph of the same surfaces has about as much information as the first: 1 /
    // sqrt(2).
    assert!(ratios[0] > 0.3 && ratios[0] < 0.9, "{ratios:?}");
    let named = |name: &str| candidates.iter().find(|one| one["name"] == name);
    let aside = named("camera \"aside\"").unwrap();
    assert_eq!(aside["lights_off"].as_array().unwrap().len(), 0);
    assert!(aside["groups"]["floor"]["ratio"].as_f64().unwrap() < 1.0);
    let dark = named("from the same place, without \"lamp\"").unwrap();
    assert_eq!(dark["lights_off"], serde_json::json!(["lamp"]));
    // The camera of the photograph is not a candidate.
    assert!(named("camera \"camera\"").is_none());
}

#[test]
fn the_photograph_with_a_wrong_camera_is_named() {
    let wrong = FROM_TWO_PLACES
        .replace("camera = \"aside\"\nexposure = \"auto\"", "camera = \"camera\"\nexposure = 2.4");
    let folder = folder(&wrong);
    recover(&folder, "out", &["--keep-camera"]);
    let run = Run::read(&folder.path("out")).unwrap();
    let odd: Vec<&String> =
        run.warnings.iter().filter(|warning| warning.contains("re-rendering is off by")).collect();
    assert!(odd.len() == 1 && odd[0].starts_with("aside.exr: "), "{:?}", run.warnings);
}
