//! `unrender calibrate`: from files to files that `recover` and `render` read, and its messages.

use crate::kit::folder::{Folder, ends_in_error, stderr, succeeds};
use crate::kit::meshes::square;
use glam::{Affine3A, Mat4, Vec3};
use std::fmt::Write as _;
use std::ops::Deref;
use std::path::Path;
use std::process::Output;
use unrender::formats::{gltf, load_scene, picture};
use unrender::render::Tracer;
use unrender::scene::{Camera, Group, Image, Lens, Material, Object, Rgb, Scene};
use unrender::{Job, Project};

const SIZE: (usize, usize) = (800, 600);

/// A folder with a scene of small tiles in a room and a photograph of the right size.
struct Tiles(Folder);

impl Deref for Tiles {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Tiles {
    /// The folder, with both.
    fn new() -> Self {
        let folder = Folder::new();
        folder.write("s.glb", &gltf::to_glb(&scene()).unwrap());
        let grey = Image::from_fn(SIZE.0, SIZE.1, |_, _| Rgb::splat(0.5));
        picture::write(&folder.path("p.png"), &grey).unwrap();
        Self(folder)
    }

    /// Runs `unrender calibrate` in the folder.
    fn calibrate(&self, arguments: &[&str]) -> Output {
        self.run(&[&["calibrate"], arguments].concat())
    }
}

/// The middles of the tiles.
fn places() -> Vec<Vec3> {
    let place = |n: usize| {
        let (column, row, depth) = (n % 4, n / 4 % 3, n / 12);
        let wave = 0.17 * (n * n % 7) as f32;
        let (column, row, depth) = (column as f32, row as f32, depth as f32);
        Vec3::new(0.5 * column - 0.8 + 0.1 * wave, 0.5 * row + 0.2, -1.1 * depth - wave)
    };
    (0..24).map(place).collect()
}

fn scene() -> Scene {
    let object = |(index, middle): (usize, &Vec3)| Object {
        name: format!("tile{index}"),
        group: 0,
        mesh: square(*middle, Vec3::Z, 0.02),
    };
    let material = Material::diffuse(Rgb::splat(0.5));
    let groups = vec![Group { name: "tiles".into(), material, emission: Rgb::ONE }];
    Scene { objects: places().iter().enumerate().map(object).collect(), groups, ..Scene::default() }
}

fn view() -> Camera {
    let eye = Vec3::new(0.6, 1.3, 2.2);
    Camera::look_at("photo", eye, Vec3::new(0.0, 0.7, -0.8), Vec3::new(0.05, 1.0, 0.0), 0.8)
}

fn bent() -> Camera {
    let lens = Lens { principal_point: [0.02, -0.015], k1: -0.2, k2: 0.05, ..Lens::default() };
    Camera { lens, ..view() }
}

/// The file of points as `camera` sees them.
fn points(camera: &Camera) -> String {
    let mut text = "# seen by hand\nx_px,y_px,x_m,y_m,z_m,name\n".to_owned();
    for (index, place) in places().iter().enumerate() {
        let (x, y) = camera.project(*place, SIZE.0, SIZE.1).expect("the tile is in the picture");
        let Vec3 { x: px, y: py, z: pz } = place;
        writeln!(text, "{x:.3},{y:.3},{px},{py},{pz},tile {index}").unwrap();
    }
    text
}

/// Asserts that `camera` shows the tiles where `truth` does.
fn assert_alike(camera: &Camera, truth: &Camera, limit: f32) {
    assert!((camera.origin() - truth.origin()).length() < 0.01, "{camera:?}");
    for place in places() {
        let (a, b) = (camera.project(place, SIZE.0, SIZE.1), truth.project(place, SIZE.0, SIZE.1));
        let (a, b) = (a.unwrap(), b.unwrap());
        assert!((a.0 - b.0).hypot(a.1 - b.1) < limit, "{a:?} is not {b:?}");
    }
}

fn job(path: &Path) -> Job {
    let (project, warnings) = Project::read(path).unwrap();
    Job::load(project, warnings).unwrap()
}

#[test]
fn a_new_project_has_the_camera_of_the_photograph() {
    let folder = Tiles::new();
    folder.write("points.csv", &points(&bent()));
    std::fs::create_dir(folder.path("sub")).unwrap();
    let told = succeeds(&folder.calibrate(&[
        "p.png",
        "--scene",
        "s.glb",
        "--points",
        "points.csv",
        "--principal-point",
        "--distortion",
        "--out",
        "sub/room.toml",
    ]));
    assert!(told.starts_with("number") && told.contains("24 of 24 pairs, 0.00 px rms"), "{told}");
    for number in ["eye x", "heading", "focal length", "principal point y", "k2"] {
        assert!(told.contains(number), "{told}");
    }
    let job = job(&folder.path("sub/room.toml"));
    assert_alike(&job.camera, &bent(), 0.02);
    assert!((job.camera.lens.k1 + 0.2).abs() < 0.01, "{:?}", job.camera.lens);
    assert!((job.camera.lens.principal_point[0] - 0.02).abs() < 0.001, "{:?}", job.camera.lens);
}

#[test]
fn rays_go_through_the_lens() {
    let scene = scene();
    let geometry = Tracer::new(&scene).geometry(&bent(), SIZE.0, SIZE.1);
    for (index, place) in places().iter().enumerate() {
        let (x, y) = bent().project(*place, SIZE.0, SIZE.1).unwrap();
        let shown = geometry.at(x as usize, y as usize).object;
        // A nearer tile may stand before it.
        let nearer = |object: u32| {
            let other = places()[object as usize];
            (other - bent().origin()).length() < (*place - bent().origin()).length()
        };
        assert!(shown == index as u32 || nearer(shown), "tile {index}: {shown}");
    }
}

#[test]
fn a_project_keeps_all_but_its_camera_and_wrong_pairs_are_named() {
    let folder = Tiles::new();
    let mut lines: Vec<String> = points(&view()).lines().map(str::to_owned).collect();
    for (line, pixel) in [(3, "700.5,20.5"), (8, "12.5,580.5"), (9, "400.5,300.5")] {
        let rest: Vec<&str> = lines[line].split(',').skip(2).collect();
        lines[line] = format!("{pixel},{}", rest.join(","));
    }
    folder.write("points.csv", &lines.join("\n"));
    let head = "# the room\nscene = \"s.glb\" # as measured\nphoto = \"p.png\"\nexposure = 1.0\n";
    folder
        .write("a.toml", &format!("{head}camera = \"door\"\n\n[recover]\nbrdf = \"ward-1992\"\n"));
    let told = succeeds(&folder.calibrate(&["--points", "points.csv", "--out", "a.toml"]));
    assert!(told.contains("21 of 24 pairs"), "{told}");
    for name in ["tile 1,", "tile 6,", "tile 7,"] {
        assert!(told.contains(&format!("thrown out: {name}")), "{told}");
    }
    assert!(told.contains("k1                 0.00000") && told.contains("held"), "{told}");
    let text = folder.text("a.toml");
    assert!(text.starts_with(&format!("{head}\n[recover]\nbrdf = \"ward-1992\"\n")), "{text}");
    assert!(text.contains("# Calibrated from points.csv: 21 of 24 pairs,"), "{text}");
    assert_alike(&job(&folder.path("a.toml")).camera, &view(), 0.02);
    let again = succeeds(&folder.calibrate(&["--points", "points.csv", "--out", "a.toml"]));
    assert_eq!(told, again);
    assert_eq!(folder.text("a.toml"), text);
}

#[test]
fn a_scene_gets_the_camera() {
    let folder = Tiles::new();
    folder.write("points.csv", &points(&view()));
    let arguments =
        ["p.png", "--scene", "s.glb", "--points", "points.csv", "--out", "seen.glb", "--quiet"];
    let told = succeeds(&folder.calibrate(&arguments));
    assert!(told.contains("pairs"), "quiet hides progress, and this is what was found: {told}");
    let (seen, _) = load_scene(&folder.path("seen.glb")).unwrap();
    let (before, _) = load_scene(&folder.path("s.glb")).unwrap();
    assert_eq!((&seen.objects, &seen.groups), (&before.objects, &before.groups));
    assert_eq!(seen.cameras.len(), 1);
    assert_eq!(seen.cameras[0].name, "calibrated");
    assert_alike(&seen.cameras[0], &view(), 0.02);
    // A second time, into the file itself, replaces the camera.
    let again = ["p.png", "--scene", "seen.glb", "--points", "points.csv", "--out", "seen.glb"];
    succeeds(&folder.calibrate(&again));
    assert_eq!(load_scene(&folder.path("seen.glb")).unwrap().0, seen);
    let bending = [&arguments[..7], &["--distortion"]].concat();
    ends_in_error(&folder.calibrate(&bending), "seen.glb: glTF has no words for");
}

/// An fSpy project whose world has z upwards, and lengths in feet.
fn fspy(camera: &Camera) -> Vec<u8> {
    let z_up_from_y_up = Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let mut placed = z_up_from_y_up * camera.world_from_camera;
    placed.translation /= 0.3048;
    let rows = Mat4::from(placed).transpose().to_cols_array_2d();
    let tan_x = (0.5 * camera.fov_y_rad).tan() * SIZE.0 as f32 / SIZE.1 as f32;
    let [right, down] = camera.lens.principal_point.map(|shift| shift * 2.0 * 600.0 / 800.0);
    let state = serde_json::json!({
        "cameraParameters": {
            "principalPoint": { "x": right, "y": -down },
            "cameraTransform": { "rows": rows },
            "horizontalFieldOfView": 2.0 * tan_x.atan(),
            "imageWidth": SIZE.0, "imageHeight": SIZE.1,
        },
        "calibrationSettingsBase": {
            "referenceDistanceUnit": "Feet", "referenceDistanceAxis": "xPositive",
        },
    });
    let json = serde_json::to_vec(&state).unwrap();
    let mut bytes = b"fspy".to_vec();
    for word in [1, json.len() as u32, 0] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    bytes.extend_from_slice(&json);
    bytes
}

#[test]
fn a_camera_comes_from_fspy() {
    let folder = Tiles::new();
    let lens = Lens { principal_point: [0.02, -0.015], ..Lens::default() };
    let shifted = Camera { lens, ..view() };
    folder.write("m.fspy", &fspy(&shifted));
    let arguments = ["p.png", "--scene", "s.glb", "--fspy", "m.fspy", "--out"];
    let told = succeeds(&folder.calibrate(&[&arguments[..], &["a.toml"]].concat()));
    assert!(told.contains("fSpy's z points upwards"), "{told}");
    assert_alike(&job(&folder.path("a.toml")).camera, &shifted, 0.02);
    let output = folder.calibrate(&[&arguments[..], &["a.glb"]].concat());
    ends_in_error(&output, "a.glb: glTF has no words for");
    folder.write("m.fspy", &fspy(&view()));
    succeeds(&folder.calibrate(&[&arguments[..], &["a.glb"]].concat()));
    assert_alike(&load_scene(&folder.path("a.glb")).unwrap().0.cameras[0], &view(), 0.02);
    folder.write("m.fspy", "fspx");
    let output = folder.calibrate(&[&arguments[..], &["a.toml"]].concat());
    ends_in_error(&output, "m.fspy: is not an fSpy project");
}

#[test]
fn faults_say_which_file_and_what() {
    let folder = Tiles::new();
    let good = points(&view());
    let lines: Vec<&str> = good.lines().collect();
    folder.write("good.csv", &good);
    let run = |points: &str, more: &[&str]| {
        let all = ["p.png", "--scene", "s.glb", "--points", points, "--out", "a.toml"];
        folder.calibrate(&[&all[..], more].concat())
    };
    folder.write("three.csv", &lines[..5].join("\n"));
    ends_in_error(
        &run("three.csv", &[]),
        "three.csv: 3 pairs are too few for pose and focal length",
    );
    ends_in_error(&run("three.csv", &["--fov-y-deg", "45.8"]), "need 4; measure more");
    folder.write("bad.csv", &format!("{}\n1,2,three,4,5,x\n", lines[..9].join("\n")));
    ends_in_error(&run("bad.csv", &[]), "bad.csv: line 10: x_m is \"three\"");
    let mirrored: Vec<String> = places()
        .iter()
        .filter_map(|place| {
            let (x, y) = view().project(*place, SIZE.0, SIZE.1)?;
            Some(format!("{x},{y},{},{},{}", place.x, place.y, -place.z))
        })
        .collect();
    folder.write("mirrored.csv", &format!("x_px,y_px,x_m,y_m,z_m\n{}\n", mirrored.join("\n")));
    ends_in_error(&run("mirrored.csv", &[]), "only as seen in a mirror");
    ends_in_error(&run("good.csv", &["--fov-y-deg", "180"]), "--fov-y-deg is 180");
    let no_scene = ["p.png", "--points", "good.csv", "--out", "new.toml"];
    ends_in_error(&folder.calibrate(&no_scene), "--scene");
    let no_photo = ["--scene", "s.glb", "--points", "good.csv", "--out", "new.toml"];
    ends_in_error(&folder.calibrate(&no_photo), "give the photo");
    let missing = ["p.png", "--scene", "no.glb", "--points", "good.csv", "--out", "a.toml"];
    ends_in_error(&folder.calibrate(&missing), "no.glb: there is no such scene file");
    let odd = ["p.png", "--scene", "s.glb", "--points", "good.csv", "--out", "a.gltf"];
    ends_in_error(&folder.calibrate(&odd), "a.gltf: end --out in .toml");
    assert!(!folder.path("a.toml").exists() && !folder.path("new.toml").exists());
    assert_eq!(folder.calibrate(&["p.png", "--out", "a.toml"]).status.code(), Some(2));
}

#[test]
fn points_far_from_photo_and_scene_are_reported() {
    let folder = Tiles::new();
    let far = "900.5,100.5,1,1,-50,tower\n";
    folder.write("points.csv", &(points(&view()) + far));
    let output = folder.calibrate(&[
        "p.png",
        "--scene",
        "s.glb",
        "--points",
        "points.csv",
        "--out",
        "a.toml",
    ]);
    succeeds(&output);
    let warnings = stderr(&output);
    assert!(warnings.contains("not in the photo of 800 x 600 pixels: tower"), "{warnings}");
    assert!(warnings.contains("points outside the scene"), "{warnings}");
    folder.write("s.glb", &gltf::to_glb(&Scene::default()).unwrap());
    let output = folder.calibrate(&["--points", "points.csv", "--out", "a.toml"]);
    succeeds(&output);
    let warnings = stderr(&output);
    assert!(warnings.contains("were not compared with the scene"), "{warnings}");
}

#[test]
fn a_known_field_of_view_is_held() {
    let folder = Tiles::new();
    folder.write("points.csv", &points(&view()));
    let degrees = 0.8f64.to_degrees().to_string();
    let told = succeeds(&folder.calibrate(&[
        "p.png",
        "--scene",
        "s.glb",
        "--points",
        "points.csv",
        "--fov-y-deg",
        &degrees,
        "--out",
        "a.toml",
    ]));
    let line = told.lines().find(|line| line.starts_with("field of view")).unwrap();
    assert!(line.contains("45.837") && line.contains("held"), "{line}");
    assert_alike(&job(&folder.path("a.toml")).camera, &view(), 0.02);
}

#[test]
fn help_has_examples() {
    let help = succeeds(&Tiles::new().calibrate(&["--help"]));
    assert!(help.contains("Examples:") && help.contains("x_px,y_px,x_m,y_m,z_m"), "{help}");
}
