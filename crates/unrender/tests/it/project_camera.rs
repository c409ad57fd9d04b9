//! The key `camera` of project files: numbers in pixels, and the cameras of other programs, against
//! the equations of OpenCV and against what `calibrate` finds.

use glam::Vec3;
use std::path::Path;
use unrender::formats::picture::{Depth, Picture};
use unrender::formats::points::Pair;
use unrender::job::InMemory;
use unrender::photo::calibrate::{Request, calibrate};
use unrender::scene::{Camera, Group, Image, Light, LightKind, Material, Mesh, Object, Rgb, Scene};
use unrender::{Job, Project};

const FILES: &str = "scene = \"s.glb\"\nphoto = \"p.png\"\n";

/// A scene of a triangle and a light.
fn lit() -> Scene {
    let kind = LightKind::Directional { direction: Vec3::NEG_Y, irradiance: Rgb::ONE };
    let group = Group {
        name: "floor".into(),
        material: Material::diffuse(Rgb::splat(0.5)),
        emission: Rgb::ZERO,
    };
    let mesh = Mesh::flat(&[Vec3::ZERO, Vec3::Z, Vec3::X], &[], &[[0, 1, 2]]);
    Scene {
        objects: vec![Object { name: "floor".into(), group: 0, mesh }],
        groups: vec![group],
        lights: vec![Light { name: "sun".into(), kind }],
        ..Scene::default()
    }
}

#[test]
fn faults_of_cameras_of_other_programs_name_their_key() {
    let placed = |rest: &str| format!("camera = {{ eye = [0,0,5], target = [0,0,0], {rest} }}");
    let file = |rest: &str| format!("camera = {{ {rest} }}");
    for (text, problem) in [
        (placed("fx = 5, fy = 5, cx = 3"), "all of fx, fy, cx, cy"),
        (placed("fov_y_deg = 40, fx = 5"), "all of fx, fy, cx, cy"),
        (placed("fx = 5, fy = -5, cx = 3, cy = 2"), "camera: fx, fy, cx, cy are 5, -5, 3, 2"),
        (placed("fx = 5, fy = 5, cx = 3, cy = 2, fx_over_fy = 1.1"), "leave these out"),
        (placed("fov_y_deg = 40, crop = [1, 2]"), "camera.crop: it goes with a file"),
        (placed("fov_y_deg = 40, view = 1"), "camera.view: it goes with a file"),
        (file("opencv = \"a.yml\", colmap = \"b\""), "not both"),
        (file("opencv = \"a.yml\", image = \"b\""), "camera.image: it is for colmap"),
        (file("colmap = \"b\", view = 1"), "camera.view: it is for opencv"),
        (file("opencv = \"a.yml\", view = -1"), "camera: invalid value: integer `-1`"),
        (file("opencv = \"a.yml\", fov_y_deg = 40"), "camera.fov_y_deg: the file says it"),
        (file("colmap = \"b\", k1 = 0.1"), "camera.k1: the file says it"),
        (file("colmap = \"b\", eye = [0,0,5], target = [0,0,0]"), "camera.eye: COLMAP's file"),
        (file("opencv = \"a.yml\", eye = [0,0,5]"), "eye and target are missing"),
        (file("opencv = \"a.yml\", crop = [-1, 2]"), "camera.crop is [-1, 2]"),
        (file("colmap = \"b\", scene_from_world = \"x-up\""), "give \"y-up\", \"z-up\""),
        (file("colmap = \"b\", scene_from_world = [[1,0,0,0],[0,2,0,0],[0,0,1,0]]"), "no rotation"),
    ] {
        let error = Project::parse(Path::new("folder/a.toml"), &format!("{FILES}{text}"));
        let error = error.expect_err(&text).to_string();
        assert!(error.starts_with("folder/a.toml: ") && error.contains(problem), "{text}: {error}");
    }
}

/// A photograph of `size` taken by the camera of `text` in the folder `place`; its camera.
fn camera_of(place: &Path, text: &str, size: (usize, usize)) -> Result<Camera, String> {
    let text = format!("{FILES}exposure = 1\n{text}");
    let (project, warnings) =
        Project::parse(&place.join("a.toml"), &text).map_err(|e| e.to_string())?;
    let photo = Image::new(size.0, size.1, vec![Rgb::splat(0.5); size.0 * size.1]);
    let given =
        InMemory { scene: Some(lit()), photo: Some(Picture::new(photo, Depth::Float)), mask: None };
    Job::assemble(project, warnings, given).map(|job| job.camera).map_err(|e| e.to_string())
}

/// A camera of 640 x 480 pixels, two metres above z = 0 and three in front, half a turn about x from
/// ours: a room of OpenCV's.
const K: [f64; 4] = [700.0, 690.0, 331.0, 222.0];
const TERMS: [f64; 2] = [-0.12, 0.02];
const EYE: [f64; 3] = [0.3, 1.2, 3.0];

/// Where it shows a point, by the words of OpenCV: y downwards, z forwards; from the upper left
/// corner.
fn seen(point: [f64; 3]) -> [f64; 2] {
    let [x, y, z] = [point[0] - EYE[0], EYE[1] - point[1], EYE[2] - point[2]];
    let (x, y) = (x / z, y / z);
    let r2 = x * x + y * y;
    let radial = 1.0 + TERMS[0] * r2 + TERMS[1] * r2 * r2;
    [K[0] * radial * x + K[2], K[1] * radial * y + K[3]]
}

fn points() -> impl Iterator<Item = [f64; 3]> {
    let side = |n: usize| (n as f64 - 2.0) * 0.35;
    (0..75).map(move |n| [0.3 + side(n % 5), 1.2 + 0.8 * side(n / 5 % 5), 0.5 * side(n / 25)])
}

#[test]
fn opencv_colmap_and_calibrate_agree() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    let [fx, fy, cx, cy] = K;
    let [k1, k2] = TERMS;
    // R is half a turn about x, so t = -R eye.
    let [x, y, z] = [-EYE[0], EYE[1], EYE[2]];
    write(
        "camera.yml",
        &format!(
            "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n\
             camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {fx}, 0., \
             {}, 0., {fy}, {}, 0., 0., 1. ]\ndistortion_coefficients: [ {k1}, {k2}, 0, 0, 0 ]\n\
             R: [ [1, 0, 0], [0, -1, 0], [0, 0, -1] ]\ntvec: [ {x}, {y}, {z} ]\n",
            cx - 0.5,
            cy - 0.5
        ),
    );
    std::fs::create_dir(place.path().join("sparse")).unwrap();
    write("sparse/cameras.txt", &format!("1 OPENCV 640 480 {fx} {fy} {cx} {cy} {k1} {k2} 0 0\n"));
    write("sparse/images.txt", &format!("1 0 1 0 0 {x} {y} {z} 1 hall/p.png\n\n"));
    let numbers = format!(
        "eye = {EYE:?}\ntarget = [{}, {}, 0]\nfx = {fx}\nfy = {fy}\ncx = {cx}\ncy = {cy}\n\
         k1 = {k1}\nk2 = {k2}\n",
        EYE[0], EYE[1]
    );
    let forms = ["opencv = \"camera.yml\"\n", "colmap = \"sparse\"\n", &numbers];
    for form in forms {
        let camera = camera_of(place.path(), &format!("[camera]\n{form}"), (640, 480)).unwrap();
        for point in points() {
            let [x, y] = seen(point);
            let at = camera.project(Vec3::from_array(point.map(|c| c as f32)), 640, 480).unwrap();
            let off = (f64::from(at.0) - x).hypot(f64::from(at.1) - y);
            assert!(off < 2e-3, "{form}: {point:?} at {at:?}, not {x}, {y}");
        }
    }
    // Calibrated from the same points, with square pixels as it has them.
    let square = |[x, y]: [f64; 2]| [x, (y - cy) * fx / fy + cy];
    let pair = |(n, point): (usize, [f64; 3])| Pair {
        name: n.to_string(),
        pixel: square(seen(point)),
        point,
    };
    let pairs: Vec<Pair> = points().enumerate().map(pair).collect();
    let request = Request { principal_point: true, distortion: true, ..Request::default() };
    let found = calibrate(&pairs, (640, 480), &request).unwrap().camera("calibrated");
    write(
        "square.json",
        &format!(
            "{{\"K\": [[{fx}, 0, {}], [0, {fx}, {}], [0, 0, 1]], \"D\": [{k1}, {k2}, 0, 0], \
             \"rvec\": [3.141592653589793, 0, 0], \"tvec\": [{x}, {y}, {z}]}}",
            cx - 0.5,
            cy - 0.5
        ),
    );
    let camera =
        camera_of(place.path(), "camera = { opencv = \"square.json\" }", (640, 480)).unwrap();
    assert!(found.origin().distance(camera.origin()) < 1e-3, "{found:?} {camera:?}");
    for (x, y) in [(0.5, 0.5), (639.5, 479.5), (320.0, 240.0), (0.5, 479.5)] {
        let [a, b] = [&found, &camera].map(|camera| camera.direction(x, y, 640, 480));
        assert!(a.distance(b) < 2e-4, "{x} {y}: {a} {b}");
    }
}

#[test]
fn cameras_of_other_pictures_are_cut_or_refused() {
    let place = tempfile::tempdir().unwrap();
    let yaml =
        "image_width: 640\nimage_height: 480\nK: [[500, 0, 319.5], [0, 500, 239.5], [0, 0, 1]]\n";
    std::fs::write(place.path().join("k.yml"), yaml).unwrap();
    let pose = "eye = [0, 0, 5]\ntarget = [0, 0, 0]\n";
    let of = |rest: &str, size| {
        camera_of(place.path(), &format!("[camera]\nopencv = \"k.yml\"\n{rest}"), size)
    };
    let camera = of(pose, (320, 240)).unwrap();
    assert_eq!(camera.principal_point(320, 240), (160.0, 120.0));
    let crop = of(&format!("{pose}crop = [40, 30]\n"), (500, 400)).unwrap();
    assert_eq!(crop.principal_point(500, 400), (280.0, 210.0));
    for (rest, size, problem) in [
        ("", (640, 480), "k.yml: has no pose: write rvec and tvec"),
        (pose, (500, 400), "k.yml: it is of a picture of 640 x 480 pixels"),
        ("eye = [0, 0, 5]\ntarget = [0, 0, 0]\ncrop = [200, 0]\n", (500, 400), "begin at 200, 0"),
    ] {
        let told = of(rest, size).unwrap_err();
        assert!(told.contains(problem), "{rest}: {told}");
    }
    let told =
        camera_of(place.path(), "camera = { colmap = \"sparse/0\" }", (640, 480)).unwrap_err();
    assert!(told.contains("images.txt: cannot be read: it does not exist; a folder of"), "{told}");
    let project = place.path().join("a.toml");
    std::fs::write(&project, format!("{FILES}camera = {{ opencv = \"no.yml\" }}\n")).unwrap();
    std::fs::write(place.path().join("s.glb"), "").unwrap();
    std::fs::write(place.path().join("p.png"), "").unwrap();
    let told = Project::read(&project).unwrap_err().to_string();
    assert!(told.contains("a.toml: camera.opencv: there is no file"), "{told}");
}

/// The camera of the room's file, as other programs would have written it.
#[test]
fn the_examples_have_the_camera_of_their_scene() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/room");
    let camera = |name: &str| {
        let (project, warnings) = Project::read(&folder.join(name)).unwrap();
        Job::load(project, warnings).unwrap().camera
    };
    let truth = camera("room.toml");
    for name in ["opencv.toml", "colmap.toml", "pixels.toml"] {
        let found = camera(name);
        assert!(found.origin().distance(truth.origin()) < 1e-5, "{name}: {found:?}");
        for (x, y) in [(0.5, 0.5), (479.5, 0.5), (100.0, 300.0), (479.5, 359.5)] {
            let [a, b] = [&found, &truth].map(|camera| camera.direction(x, y, 480, 360));
            assert!(a.distance(b) < 1e-5, "{name}: {a} {b}");
        }
    }
    let (project, warnings) = Project::read(&folder.join("known.toml")).unwrap();
    let job = Job::load(project, warnings).unwrap();
    assert_eq!(job.project.coloured_sources(&job.scene), job.unknown_lights);
    assert_eq!(job.project.same_as["wardrobe"], "oak");
    assert_eq!(job.project.like["walls"].group, "ceiling");
    assert_eq!(job.project.expected["floor"].bounds.alpha_x, [0.05, 1.0]);
}
