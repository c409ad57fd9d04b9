//! `unrender calibrate --lines`: from marked lines, and from those of the photograph, to a camera without a model.

use crate::kit::folder::{Folder, ends_in_error, stderr, succeeds};
use glam::Vec3;
use unrender::formats::{axis_lines, gltf, load_model, picture};
use unrender::scene::color::linear_from_srgb;
use unrender::scene::{AxisLine, Camera, Image, Rgb};

const SIZE: (usize, usize) = (640, 480);

fn view() -> Camera {
    Camera::look_at("truth", Vec3::new(0.9, 1.5, 2.2), Vec3::new(-0.6, 1.1, -1.0), Vec3::Y, 0.9)
}

/// The middle of the wall, the floor or the ceiling behind a pixel has one colour, its frame another: a room from
/// (-2, 0, -2) to (2, 2.6, 3).
fn room() -> Image<Rgb> {
    let camera = view();
    let (low, high) = (Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 2.6, 3.0));
    Image::from_fn(SIZE.0, SIZE.1, |x, y| {
        let samples = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)];
        let grey = samples.map(|(right, down)| {
            let way = camera.direction(x as f32 + right, y as f32 + down, SIZE.0, SIZE.1);
            let eye = camera.origin();
            let to = Vec3::select(way.cmplt(Vec3::ZERO), low - eye, high - eye) / way;
            let axis = (0..3).min_by(|a, b| to[*a].total_cmp(&to[*b])).unwrap();
            let share = (eye + to[axis] * way - low) / (high - low);
            let is_frame = (0..3).any(|other| other != axis && (share[other] - 0.5).abs() > 0.3);
            0.2 + 0.15 * axis as f32 + if is_frame { 0.25 } else { 0.0 }
        });
        Rgb::splat(linear_from_srgb(grey.iter().sum::<f32>() / 4.0))
    })
}

/// A folder with a photograph of the room.
fn photographed() -> Folder {
    let folder = Folder::new();
    picture::write(&folder.path("p.png"), &room()).unwrap();
    folder
}

/// The camera in a file that has a square metre at the origin beside it.
fn camera(folder: &Folder, name: &str) -> Camera {
    let (scene, _) = load_model(&folder.path(name)).unwrap();
    assert_eq!(scene.bounds(), Some([Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0)]));
    scene.cameras[0].clone()
}

fn angle(camera: &Camera) -> f32 {
    let ahead = |camera: &Camera| camera.direction(320.0, 240.0, SIZE.0, SIZE.1);
    ahead(camera).angle_between(ahead(&view())).to_degrees()
}

#[test]
fn the_lines_of_a_photograph_give_its_camera() {
    let folder = photographed();
    let words = "calibrate p.png --lines auto --camera-height 1.5 --show-lines l.png --save-lines l.csv --out c.glb";
    let told = succeeds(&folder.run(&words.split(' ').collect::<Vec<_>>()));
    let found = camera(&folder, "c.glb");
    assert!((found.fov_y_rad / view().fov_y_rad - 1.0).abs() < 0.01, "{told}");
    assert!(angle(&found) < 0.3, "{} degrees off: {told}", angle(&found));
    assert!((found.origin().y - 1.5).abs() < 1e-4);
    let (drawn, _) = picture::read(&folder.path("l.png")).unwrap();
    assert_eq!((drawn.values.width(), drawn.values.height()), (1280, 960));
    let again = "calibrate p.png --lines l.csv --camera-height 1.5 --out d.glb";
    succeeds(&folder.run(&again.split(' ').collect::<Vec<_>>()));
    assert!((camera(&folder, "d.glb").fov_y_rad - found.fov_y_rad).abs() < 1e-3);
}

/// The edges of a box of 1 x 1 x 1 m from the origin, of which one has its length.
fn edges() -> Vec<AxisLine> {
    let seen = |point: Vec3| {
        let (x, y) = view().project(point, SIZE.0, SIZE.1).unwrap();
        [x.into(), y.into()]
    };
    let edge = |index: usize| {
        let (axis, a, b) = (index / 4, (index / 2 % 2) as f32, (index % 2) as f32);
        let mut begin = Vec3::new(-0.5, 0.5, -1.0);
        begin[(axis + 1) % 3] += a;
        begin[(axis + 2) % 3] += b;
        let ends = [seen(begin), seen(begin + Vec3::AXES[axis])];
        let length_m = (index == 0).then_some(1.0);
        AxisLine { name: format!("edge {index}"), axis, is_directed: true, ends, length_m }
    };
    (0..12).map(edge).collect()
}

#[test]
fn marked_lines_give_a_camera_in_metres() {
    let folder = photographed();
    folder.write("l.csv", &axis_lines::to_csv(&edges()));
    let told = succeeds(&folder.run(&["calibrate", "p.png", "--lines", "l.csv", "--out", "c.glb"]));
    assert!(told.contains("12 of 12 lines"), "{told}");
    let found = camera(&folder, "c.glb");
    let eye = found.origin() + Vec3::new(-0.5, 0.5, -1.0);
    assert!(eye.distance(view().origin()) < 0.01 && angle(&found) < 0.1, "{told}");
    // With a scene it is a project's camera as well.
    folder.write("s.glb", &gltf::to_glb(&unrender::scene::Scene::default()).unwrap());
    let words = "calibrate p.png --scene s.glb --lines l.csv --out p.toml";
    succeeds(&folder.run(&words.split(' ').collect::<Vec<_>>()));
    assert!(
        std::fs::read_to_string(folder.path("p.toml"))
            .unwrap()
            .contains("from l.csv: 12 of 12 lines")
    );
}

#[test]
fn faults_of_lines_say_which_file_and_what() {
    let folder = photographed();
    let run = |lines: &str, more: &[&str]| {
        let all = ["calibrate", "p.png", "--lines", lines, "--out", "c.glb"];
        folder.run(&[&all[..], more].concat())
    };
    let csv = axis_lines::to_csv(&edges());
    folder.write("l.csv", &csv);
    folder.write("two.csv", &csv.lines().take(3).collect::<Vec<_>>().join("\n"));
    ends_in_error(&run("two.csv", &[]), "two.csv: 2 axes need two lines each");
    folder.write("bad.csv", &csv.replace("+y", "up"));
    ends_in_error(&run("bad.csv", &[]), "bad.csv: line 6: axis is \"up\"");
    ends_in_error(&run("l.csv", &["--camera-height", "1.5"]), "l.csv: has a length_m");
    ends_in_error(&run("auto", &["--camera-height=-1"]), "--camera-height is -1");
    ends_in_error(&run("l.csv", &["--show-lines", "p.png"]), "p.png");
    ends_in_error(&run("l.csv", &["--save-lines", "l.csv"]), "l.csv");
    ends_in_error(&run("l.csv", &["--show-lines", "l.jpg"]), "l.jpg: end the name");
    picture::write(&folder.path("p.png"), &Image::from_fn(64, 48, |_, _| Rgb::splat(0.5))).unwrap();
    ends_in_error(&run("auto", &[]), "p.png: the 0 straight lines of the photo show no two");
    assert!(!folder.path("c.glb").exists());
    let told = stderr(&folder.run(&["calibrate", "p.png", "--lines", "l.csv", "--out", "c.toml"]));
    assert!(told.contains("give the scene"), "{told}");
}
