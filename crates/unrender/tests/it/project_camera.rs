//! The key `camera` of project files: values in pixels and cameras of other programs, compared with
//! the equations of OpenCV and the results of `calibrate`.

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
        (placed("fov_y_deg = 40, pixels = \"stored\""), "camera.pixels: it goes with a file"),
        (file("opencv = \"a.yml\", pixels = \"turned\""), "it is \"stored\" or \"upright\""),
        (
            file("opencv = \"a.yml\", eye = [0,0,5], target = [0,0,0], view = 1"),
            "camera.view: eye and target say",
        ),
        (placed("fov_y_deg = 40, view = 1"), "camera.view: it goes with a file"),
        (file("opencv = \"a.yml\", colmap = \"b\""), "not both"),
        (file("opencv = \"a.yml\", image = \"b\""), "camera.image: it is for colmap"),
        (file("colmap = \"b\", view = 1"), "camera.view: it is for opencv"),
        (file("opencv = \"a.yml\", view = -1"), "camera: invalid value: integer `-1`"),
        (file("opencv = \"a.yml\", fov_y_deg = 40"), "camera.fov_y_deg: the file states it"),
        (file("colmap = \"b\", k1 = 0.1"), "camera.k1: the file states it"),
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

/// A camera of 640 x 480 pixels in a room with OpenCV's axes: two metres above z = 0 and three in
/// front, half a turn about x from ours.
const K: [f64; 4] = [700.0, 690.0, 331.0, 222.0];
const TERMS: [f64; 2] = [-0.12, 0.02];
const EYE: [f64; 3] = [0.3, 1.2, 3.0];

/// The pixel of a point by the convention of OpenCV: y downwards, z forwards; from the upper left
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
    // Calibrated from the same points, with square pixels, which `calibrate` assumes.
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

/// The files have the camera of the room, as other programs would write it.
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

/// A TIFF file of this EXIF orientation that stores rows of `pixels`.
fn tiff(orientation: u16, width: usize, pixels: &[[u8; 3]]) -> Vec<u8> {
    let (bytes, height) = (pixels.as_flattened(), (pixels.len() / width) as u32);
    let entries: [(u16, u16, u32, u32); 10] = [
        (256, 4, 1, width as u32),
        (257, 4, 1, height),
        // Three numbers of bits, after the pixels.
        (258, 3, 3, 8 + bytes.len() as u32),
        (259, 3, 1, 1),
        (262, 3, 1, 2),
        (273, 4, 1, 8),
        (274, 3, 1, orientation.into()),
        (277, 3, 1, 3),
        (278, 4, 1, height),
        (279, 4, 1, bytes.len() as u32),
    ];
    let mut file = b"II*\0".to_vec();
    file.extend((8 + bytes.len() as u32 + 6).to_le_bytes());
    file.extend(bytes);
    file.extend([8, 0, 8, 0, 8, 0]);
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        file.extend(tag.to_le_bytes());
        file.extend(kind.to_le_bytes());
        file.extend(count.to_le_bytes());
        file.extend(value.to_le_bytes());
    }
    file.extend([0; 4]);
    file
}

/// The photograph of another program's camera, of 64 x 48 or 48 x 48 pixels: the colour of each pixel
/// encodes where it is stored.
fn stored(width: usize) -> Vec<[u8; 3]> {
    (0..48 * width)
        .map(|index| [3 * (index % width) as u8 + 20, 4 * (index / width) as u8 + 20, 90])
        .collect()
}

/// The job of a folder whose photograph is a file, and whose camera is that of `text`.
fn job_of(place: &Path, text: &str) -> Result<Job, String> {
    let text = format!("{FILES}exposure = 1\nresponse = \"srgb\"\n{text}");
    let (project, warnings) =
        Project::parse(&place.join("a.toml"), &text).map_err(|e| e.to_string())?;
    let given = InMemory { scene: Some(lit()), ..InMemory::default() };
    Job::assemble(project, warnings, given).map_err(|e| e.to_string())
}

/// Writes `p.png` of this width and orientation, and the camera files for its pixels as they are stored.
fn turned_photograph(place: &Path, width: usize, orientation: u16) {
    std::fs::write(place.join("p.png"), tiff(orientation, width, &stored(width))).unwrap();
    let [x, y, z] = [-EYE[0], EYE[1], EYE[2]];
    let cameras = format!("1 OPENCV {width} 48 70 66 33 23 -0.12 0.02 0.01 -0.02\n");
    let images = format!("1 0 1 0 0 {x} {y} {z} 1 p.png\n\n");
    std::fs::create_dir_all(place.join("sparse")).unwrap();
    std::fs::write(place.join("sparse/cameras.txt"), cameras).unwrap();
    std::fs::write(place.join("sparse/images.txt"), images).unwrap();
    let yaml = format!(
        "image_width: {width}\nimage_height: 48\nK: [[70, 0, 32.5], [0, 66, 22.5], [0, 0, 1]]\n\
         D: [-0.12, 0.02, 0.01, -0.02]\nR: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]\ntvec: [{x}, {y}, {z}]\n"
    );
    std::fs::write(place.join("k.yml"), yaml).unwrap();
}

/// The pixels at which the camera of `job` shows the points.
fn shown(job: &Job) -> Vec<[i32; 3]> {
    let picture = &job.picture.values;
    let (width, height) = (picture.width(), picture.height());
    let at = |point: [f64; 3]| {
        let (x, y) =
            job.camera.project(Vec3::from_array(point.map(|c| c as f32)), width, height)?;
        Some(
            picture.at(x as usize, y as usize).to_array().map(|code| (255.0 * code).round() as i32),
        )
    };
    points().filter_map(at).collect()
}

#[test]
fn a_pose_of_stored_pixels_turns_with_the_photograph() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let colmap = "camera = { colmap = \"sparse\" }";
    let opencv = "camera = { opencv = \"k.yml\", pixels = \"stored\" }";
    for width in [64, 48] {
        turned_photograph(place, width, 1);
        let as_stored = job_of(place, colmap).unwrap();
        let expected = shown(&as_stored);
        assert!(expected.len() > 20 && as_stored.warnings.0.is_empty(), "{:?}", as_stored.warnings);
        for orientation in 2..=8 {
            turned_photograph(place, width, orientation);
            for camera in [colmap, opencv] {
                let job = job_of(place, camera).unwrap();
                let sides = (job.picture.values.width(), job.picture.values.height());
                assert_eq!(sides, if orientation < 5 { (width, 48) } else { (48, width) });
                let found = shown(&job);
                // A point on the border of two pixels may fall into either.
                let same = found
                    .iter()
                    .zip(&expected)
                    .all(|(a, b)| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 5));
                assert!(same && found.len() == expected.len(), "{width}, {orientation}: {camera}");
                let told = job.warnings.0.join("\n");
                let is_mirrored = [2, 4, 5, 7].contains(&orientation);
                assert_eq!(told.contains("shows it mirrored"), is_mirrored, "{told}");
                let is_open = camera == colmap && (width == 48 || orientation < 5);
                assert_eq!(told.contains("pixels = \"upright\""), is_open, "{told}");
            }
        }
    }
}

#[test]
fn where_nothing_tells_which_pixels_a_calibration_is_of_it_is_asked() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    let of = |rest: &str| job_of(place, &format!("camera = {{ opencv = \"k.yml\"{rest} }}"));
    for (width, orientation) in [(64, 2), (64, 3), (48, 6)] {
        turned_photograph(place, width, orientation);
        let told = of("").unwrap_err();
        assert!(told.contains("k.yml") && told.contains("give pixels = \"upright\""), "{told}");
        assert!(of(", pixels = \"stored\"").is_ok());
        let upright = of(", pixels = \"upright\"").unwrap();
        assert!(upright.camera.origin().distance(Vec3::new(0.3, 1.2, 3.0)) < 1e-6);
        assert!((upright.camera.lens.p1 - 0.01).abs() < 1e-6, "as the file says");
    }
    // The sizes decide.
    turned_photograph(place, 64, 6);
    let by_size = of("").unwrap();
    assert_eq!(by_size.camera, of(", pixels = \"stored\"").unwrap().camera);
    assert!((by_size.camera.lens.p1 + 0.02).abs() < 1e-6, "tilted the other way");
    // A centred pinhole whose pose the project states for the upright picture is the same in both
    // cases.
    turned_photograph(place, 64, 3);
    let yaml = "image_width: 64\nimage_height: 48\nK: [[70, 0, 31.5], [0, 70, 23.5], [0, 0, 1]]\n";
    std::fs::write(place.join("k.yml"), yaml).unwrap();
    assert!(of(", eye = [0, 0, 5], target = [0, 0, 0]").unwrap().warnings.0.is_empty());
    // A camera without a file always belongs to the upright pixels.
    let named = "camera = { eye = [0, 0, 5], target = [0, 0, 0], fov_y_deg = 40 }";
    assert!(job_of(place, named).unwrap().warnings.0.is_empty());
}

#[test]
fn a_mask_is_mirrored_back_with_its_photograph() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    turned_photograph(place, 64, 2);
    // White on the right of the upright picture, which shows the first columns that are stored.
    let mask: Vec<[u8; 3]> =
        (0..48 * 64).map(|i| [if i % 64 >= 60 { 255 } else { 0 }; 3]).collect();
    std::fs::write(place.join("m.png"), tiff(1, 64, &mask)).unwrap();
    let job = job_of(place, "mask = \"m.png\"\ncamera = { colmap = \"sparse\" }").unwrap();
    let mask = job.mask.unwrap();
    assert!(*mask.at(0, 7) && *mask.at(3, 7) && !*mask.at(4, 7) && !*mask.at(63, 7));
    assert_eq!(job.picture.values.at(3, 0).x, 29.0 / 255.0);
}
