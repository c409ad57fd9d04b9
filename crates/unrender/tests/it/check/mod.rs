//! The warnings of `unrender check`: one faulty input per test, on a small room made up here.

mod faults;
mod overlaps;
mod room;

use crate::kit::example::beside_crates;
use crate::kit::folder::Folder;
use glam::Vec3;
use room::*;
use std::path::Path;
use std::process::{Command, Output};
use unrender::check::{Checkup, EdgeKind, check, edge_picture};
use unrender::formats::picture::{self, Depth, Picture};
use unrender::photo::{Response, Transfer, develop};
use unrender::scene::color::{linear_from_srgb, srgb_from_linear};
use unrender::scene::{
    Camera, Group, Image, Light, LightKind, Material, Mesh, Object, Rgb, RgbImage, Scene, Warnings,
};
use unrender::{Job, Project};

/// `examples/room` with its camera's axis `pixels` to the right of its place.
fn room_beside(pixels: f64) -> Checkup {
    let path = beside_crates("examples/room/pixels.toml");
    let (project, warnings) = Project::read(&path).unwrap();
    let job = Job::load(project, warnings).unwrap();
    let (width, height) = (job.photo.radiance.width(), job.photo.radiance.height());
    assert_eq!((width, height), (480, 360));
    let mut camera = job.camera.clone();
    camera.lens.principal_point[0] += (pixels / height as f64) as f32;
    check(&Job { camera, ..job })
}

#[test]
#[ignore = "slow: two drafts of 480 x 360 pixels"]
fn a_camera_is_moved_for_a_fifth_of_a_pixel_and_left_where_it_is_right() {
    assert!(room_beside(0.2).edges.camera_is_off);
    assert!(!room_beside(0.0).edges.camera_is_off);
}

/// A project and all files that it names.
struct Input(Job);

impl Input {
    /// The photograph `codes` of `scene` by `camera`, with the project's lines `text`.
    fn new(scene: &Scene, camera: Camera, codes: Picture, response: Response, text: &str) -> Self {
        let text = format!("scene = \"s.glb\"\nphoto = \"p.png\"\n{text}");
        let (project, _) = Project::parse(Path::new("a.toml"), &text).unwrap();
        let transfer = Transfer::plain(response, project.exposure.or_one());
        let photo = develop(&codes, &transfer);
        let (scene, warnings) = (scene.clone(), Warnings::default());
        let unknown_lights = project.unknown_sources(&scene);
        let own_groups = scene.objects.iter().map(|object| object.group).collect();
        let picture = codes;
        let mask = None;
        Self(Job {
            scene,
            camera,
            picture,
            photo,
            side: 1,
            mask,
            transfer,
            project,
            off: Vec::new(),
            further: Vec::new(),
            unknown_lights,
            own_groups,
            warnings,
        })
    }

    /// A floating-point photograph that `camera()` took of `room()`, claimed to be one of `scene`.
    fn of_room(scene: &Scene) -> Self {
        let codes = Picture::new(photo_of_room(), Depth::Float);
        Self::new(scene, camera(), codes, Response::Linear, "exposure = 1\n")
    }

    fn check(&self) -> Checkup {
        check(&self.0)
    }

    /// Asserts that one of the warnings contains `problem` and `remedy`.
    fn warns(&self, problem: &str, remedy: &str) {
        let told = self.check().warnings.0;
        let found = told.iter().any(|told| told.contains(problem) && told.contains(remedy));
        assert!(found, "{problem:?} is not in {told:#?}");
    }
}

#[test]
fn a_good_project_passes_in_silence() {
    let checkup = Input::of_room(&room()).check();
    assert_eq!(checkup.warnings.0, [""; 0]);
    let [back_wall, floor, .., lamp] = checkup.groups.as_slice() else { panic!("five groups") };
    assert_eq!((back_wall.role.as_str(), lamp.role.as_str()), ("unknown", "emitter"));
    assert!(back_wall.valid > 1000 && back_wall.valid < back_wall.pixels);
    assert_eq!(back_wall.edge, back_wall.pixels - back_wall.valid);
    assert!(floor.lit.unwrap() > 0.7 && lamp.lit.is_none());
    assert!(!floor.texture_coordinates);
}

#[test]
fn what_has_no_measurement_is_left_out() {
    // As if the file contained only the left part of the picture.
    let whole = photo_of_room();
    let (width, held) = (whole.width(), whole.width() * 5 / 8);
    let is_held = |index: usize| index % width < held;
    let mut codes = Picture::new(whole, Depth::Float);
    codes.invalid = (0..codes.values.pixels().len()).filter(|i| !is_held(*i)).collect();
    for &index in &codes.invalid {
        codes.values.pixels_mut()[index] = Rgb::ZERO;
    }
    let checkup = Input::new(&room(), camera(), codes, Response::Linear, "exposure = 1\n").check();
    let full = Input::of_room(&room()).check();
    assert!(checkup.groups[1].valid < full.groups[1].valid && checkup.groups[1].valid > 100);
    // No warning mentions clipping or a dark photograph.
    let told = checkup.warnings.0;
    assert!(!told.iter().any(|w| w.contains("clipped") || w.contains("dark")), "{told:?}");
}

#[test]
fn highlights_and_what_is_mirrored_are_reported() {
    // The floor mirrors the lamp at z = 0.7 to 0.9.
    let eye = Vec3::new(0.0, 1.3, 1.4);
    let looking_down = Camera::look_at("c", eye, Vec3::new(0.0, 0.0, 0.6), Vec3::Y, 0.7);
    let of = |scene: &Scene, camera: &Camera| {
        let codes = Picture::new(photograph(scene, camera), Depth::Float);
        Input::new(scene, camera.clone(), codes, Response::Linear, "exposure = 1\n").check().groups
    };
    let floor = of(&room(), &looking_down).swap_remove(1);
    assert!(floor.roughness.unwrap().contains("highlight"), "{floor:?}");
    // A wall alone, in sunlight from the side, mirrors nothing.
    let mut scene = room();
    scene.objects.truncate(1);
    let kind = LightKind::Directional {
        direction: Vec3::new(2.0, 0.0, -1.0).normalize(),
        irradiance: Rgb::ONE,
    };
    scene.lights.push(Light { name: "sun".into(), kind });
    let sunny = Camera::look_at("c", Vec3::new(0.0, 1.0, 2.0), Vec3::Y, Vec3::Y, 0.4);
    let wall = of(&scene, &sunny).swap_remove(0);
    assert_eq!((wall.roughness, wall.lit), (Some("nothing"), Some(1.0)), "{wall:?}");
}

#[test]
fn edges_are_drawn_where_the_model_has_them() {
    let input = Input::of_room(&room());
    let checkup = input.check();
    let edges = &checkup.edges;
    assert!(edges.fit > 0.85 && edges.off < 0.03, "{} {}", edges.fit, edges.off);
    let drawn = edge_picture(&input.0.photo.radiance, &edges.points);
    let zoom = drawn.width() / SIZE.0;
    assert_eq!((drawn.width(), drawn.height()), (zoom * SIZE.0, zoom * SIZE.1));
    let is_green = |v: &Rgb| v.y > 0.5 && v.x < 0.2 && v.z < 0.2;
    // The edge between the back wall and the floor, left of the block.
    let at = input.0.camera.project(Vec3::new(-0.8, 0.0, -1.0), SIZE.0, SIZE.1).unwrap();
    let pixel = |dy: f32| {
        let (x, y) = (at.0 * zoom as f32, (at.1 + dy) * zoom as f32);
        *drawn.at(x as usize, y as usize)
    };
    let is_line = |v: &Rgb| v.max_element() - v.min_element() > 0.6;
    assert!(is_line(&pixel(0.0)), "{}", pixel(0.0));
    assert!(!is_line(&pixel(3.0)) && !is_line(&pixel(-3.0)));
    let green = drawn.pixels().iter().filter(|v| is_green(v)).count() as f32;
    assert!((0.005..0.1).contains(&(green / drawn.pixels().len() as f32)), "{green}");
}

#[test]
fn a_camera_and_an_object_that_are_off_are_told_and_drawn() {
    let photo = Picture::new(photo_of_room(), Depth::Float);
    let turned = Camera::look_at(
        "camera",
        camera().origin(),
        Vec3::new(0.05, 0.7, 0.0),
        Vec3::Y,
        camera().fov_y_rad,
    );
    let text = "exposure = 1\n";
    let input = Input::new(&room(), turned, photo.clone(), Response::Linear, text);
    input.warns("pixels from the photo's", "unrender calibrate");
    let edges = input.check().edges;
    assert!(edges.camera_is_off && edges.off > 0.5, "{}", edges.off);
    let apart = edges.points.iter().filter_map(|e| e.there.map(|there| there.distance(e.at)));
    let apart: Vec<f32> = apart.collect();
    let mean = apart.iter().sum::<f32>() / apart.len() as f32;
    assert!((edges.displacement_px.unwrap() - mean).abs() < 1.0, "{mean}");
    let drawn = edge_picture(&input.0.photo.radiance, &edges.points);
    let count = |is: fn(&&Rgb) -> bool| drawn.pixels().iter().filter(is).count();
    assert!(count(|v| v.x > 0.9 && v.y < 0.1) > 100, "red");
    assert!(count(|v| v.x > 0.9 && v.y > 0.7 && v.z < 0.1) > 100, "yellow");

    let even =
        Picture::new(RgbImage::new(SIZE.0, SIZE.1, vec![Rgb::splat(0.2); 120 * 90]), photo.depth);
    let input = Input::new(&room(), camera(), even, Response::Linear, text);
    input.warns("hardly any of the model's edges", "is it the photo of this model");
    let seen = |kind| input.check().edges.points.iter().filter(|e| e.kind == kind).count();
    assert_eq!((seen(EdgeKind::Fits), seen(EdgeKind::Off)), (0, 0));
}

#[test]
fn responses_that_look_wrong_are_reported() {
    let radiance = photo_of_room();
    let brightest = radiance.pixels().iter().fold(0.0f32, |most, v| most.max(v.max_element()));
    let linear = radiance.map(|v| (*v / brightest).clamp(Rgb::ZERO, Rgb::ONE));
    let text = format!("exposure = {brightest}\n");
    let of = |values: RgbImage, depth, response| {
        Input::new(&room(), camera(), Picture::new(values, depth), response, &text)
    };
    let encoded = linear.map(|v| v.map(srgb_from_linear));
    let decoded = linear.map(|v| v.map(linear_from_srgb));
    let deep = Depth::Sixteen;
    of(encoded.clone(), deep, Response::Linear)
        .warns("to the power of 0.", "is the response \"srgb\"?");
    of(linear.clone(), deep, Response::Srgb)
        .warns("to the power of 2", "is the response \"linear\"?");
    of(decoded, deep, Response::Linear).warns("to the power of 2", "decoded twice");
    assert_eq!(of(encoded.clone(), deep, Response::Srgb).check().warnings.0, [""; 0]);

    let steps = encoded.map(|v| (255.0 * *v).round() / 255.0);
    let float = of(steps.clone(), Depth::Float, Response::Linear);
    float.warns("all its values are steps of 8 bits", "it is \"srgb\"");
    of(steps, deep, Response::Srgb).warns("16-bit file", "Use the original");
}

#[test]
fn a_stretched_histogram_is_reported() {
    let code = |x: usize, stretch: f32| (stretch * (40.0 + (x % 100) as f32)).round() / 255.0;
    let ramp = |stretch| {
        let values = Image::from_fn(SIZE.0, SIZE.1, |x, y| Rgb::splat(code(x + y, stretch)));
        Input::new(&room(), camera(), Picture::new(values, Depth::Eight), Response::Srgb, "")
    };
    ramp(1.5).warns("histogram has", "as the camera wrote");
    let told = ramp(1.0).check().warnings.0;
    assert!(!told.iter().any(|told| told.contains("histogram")), "{told:?}");
}

#[test]
fn bright_dark_and_clipped_photos_are_reported() {
    let radiance = photo_of_room();
    let of = |scale: f32, text: &str| {
        let code = |v: f32| (255.0 * srgb_from_linear(v)).round() / 255.0;
        let codes = radiance.map(|v| (scale * *v).map(code));
        let codes = Picture::new(codes, Depth::Eight);
        Input::new(&room(), camera(), codes, Response::Srgb, text)
    };
    of(20.0, "exposure = 0.05\n").warns("cannot be used", "another exposure");
    of(20.0, "exposure = 0.05\n").warns("\"back_wall\" (", "clipped");
    of(0.01, "exposure = 100\n").warns("very dark", "take a longer exposure");
    of(0.5, "exposure = 100\n").warns("times as bright as", "exposure = \"auto\"");
    of(0.5, "exposure = 0.02\n").warns("times darker than", "strength of the lights");
    let auto = "exposure = \"auto\"\n[anchor]\ngroup = \"floor\"\nrho_d = 0.5\n";
    assert_eq!(of(0.5, auto).check().warnings.0, [""; 0]);
}

#[test]
fn codes_of_integers_in_a_floating_point_photo_are_told_as_that() {
    let radiance = photo_of_room();
    let of = |white: f32| {
        let codes = radiance.map(|v| v.map(|v| (white * srgb_from_linear(v)).round()));
        Input::new(
            &room(),
            camera(),
            Picture::new(codes, Depth::Float),
            Response::Linear,
            "exposure = 1\n",
        )
    };
    of(255.0).warns("codes of 0 to 255", "divide the values by 255");
    of(65535.0).warns("codes of 0 to 65535", "uint16");
    let told = of(255.0).check().warnings.0;
    assert!(!told.iter().any(|told| told.contains("times as bright")), "{told:#?}");
}

/// The room in the light of a bulb of `watts` alone, read with its light this many times as bright.
fn by_bulb(watts: f32, read: f32, text: &str) -> Input {
    let with = |factor: f32| {
        let mut scene = room();
        scene.groups.iter_mut().for_each(|group| group.emission = Rgb::ZERO);
        let intensity = Rgb::splat(factor * watts / (4.0 * std::f32::consts::PI));
        let kind = LightKind::Point { position: Vec3::new(0.3, 1.2, 0.3), intensity };
        scene.lights.push(Light { name: "bulb".into(), kind });
        scene
    };
    let codes = Picture::new(photograph(&with(1.0), &camera()), Depth::Float);
    Input::new(&with(read), camera(), codes, Response::Linear, text)
}

#[test]
fn the_lighting_mode_of_the_export_is_known_by_the_photograph() {
    let read = |read: f32, units: &str| {
        by_bulb(35.0, read, &format!("exposure = 1\nlight_units = \"{units}\"\n"))
    };
    let watts_a_steradian = 1.0 / (4.0 * std::f32::consts::PI);
    read(1.0 / 683.0, "blender-standard").warns(
        "read as \"unitless\", the lights fit the photo",
        "has 0.051 W, and would have 35 W",
    );
    read(watts_a_steradian, "blender-raw")
        .warns("read as \"unitless\", the lights fit", "say light_units = \"unitless\"");
    read(683.0, "unitless").warns("read as \"blender-standard\", the lights fit", "Lighting Mode");
    read(watts_a_steradian.recip(), "unitless")
        .warns("read as \"blender-raw\", the lights", "35 W");
    for units in ["blender-standard", "unitless", "blender-raw", "radiometric"] {
        says_nothing_of_units(&read(1.0, units));
    }
}

/// Asserts that no warning names the key of the lights' units.
fn says_nothing_of_units(input: &Input) {
    let told = input.check().warnings.0;
    assert!(told.iter().all(|told| !told.contains("light_units")), "{told:?}");
}

#[test]
fn the_lighting_mode_of_the_export_is_known_by_the_lamps() {
    let auto = "\nexposure = \"auto\"\n[anchor]\ngroup = \"floor\"\nrho_d = 0.5\n";
    let read =
        |read: f32, units: &str| by_bulb(35.0, read, &format!("light_units = \"{units}\"{auto}"));
    read(1.0 / 683.0, "blender-standard").warns(
        "too bright or too faint for a real lamp; as \"unitless\" all are",
        "light_units = \"unitless\"",
    );
    read(683.0, "unitless").warns("as \"blender-standard\" all are", "would have 35 W");
    says_nothing_of_units(&read(1.0, "unitless"));
}

#[test]
fn lights_in_the_wrong_place_are_reported() {
    let with = |kind: LightKind| {
        let mut scene = room();
        scene.lights.push(Light { name: "bulb".into(), kind });
        Input::of_room(&scene)
    };
    let point = |position| LightKind::Point { position, intensity: Rgb::splat(0.01) };
    assert_eq!(with(point(Vec3::new(0.3, 1.2, 0.3))).check().warnings.0, [""; 0]);
    let in_block = point(Vec3::new(-0.25, 0.35, -0.35));
    with(in_block)
        .warns("\"bulb\" is enclosed by object \"the block\"", "out of the wall or shade");
    with(point(Vec3::new(0.0, 1.0, -1.2))).warns("light \"bulb\" to anything", "behind a wall");
    with(point(Vec3::new(0.5, 0.001, 0.3)))
        .warns("stands at object \"the floor\"", "into the open");
    let up = LightKind::Directional { direction: Vec3::Y, irradiance: Rgb::ONE };
    with(up).warns("directional light \"bulb\"", "turned away");
}

#[test]
fn area_lights_that_light_nothing_are_reported() {
    let with_lamp = |mesh: Mesh| {
        let mut scene = room();
        scene.objects.push(Object { name: "second".into(), ..object(LAMP, mesh) });
        Input::of_room(&scene)
    };
    let (x, z) = (0.4 * Vec3::X, 0.4 * Vec3::Z);
    let down = quad(Vec3::new(0.3, 1.9, 0.0), x, z);
    assert_eq!(with_lamp(down.clone()).check().warnings.0, [""; 0]);
    with_lamp(flipped(&down)).warns("area light \"second\" to anything", "turned away");
    let onto_floor = quad(Vec3::new(0.3, 0.005, 0.0), x, z);
    with_lamp(onto_floor)
        .warns("\"second\" shines right onto object \"the floor\"", "flip its faces");
    let low = Vec3::new(0.3, 0.9, 0.0);
    let inwards = flipped(&cuboid(low, low + 0.2));
    with_lamp(inwards.clone()).warns("\"second\" shines into itself", "flip its faces");
    with_lamp(inwards).warns("the picture shows \"second\" from behind", "area lights are black");
}

#[test]
fn objects_from_behind_and_doubled_ones_are_reported() {
    let mut scene = room();
    scene.objects[BLOCK].mesh = flipped(&scene.objects[BLOCK].mesh);
    Input::of_room(&scene).warns("the picture shows \"the block\" from behind", "flip the faces");
    let mut scene = room();
    scene.objects.push(Object { group: 1, ..scene.objects[BLOCK].clone() });
    Input::of_room(&scene)
        .warns("\"the block\" lies in the plane of \"the block\"", "cut the other");
    let mut scene = room();
    let normals = &mut scene.objects[BLOCK].mesh.normals;
    normals.iter_mut().for_each(|normal| *normal = -*normal);
    let warnings = scene.validate().unwrap();
    let mut input = Input::of_room(&scene);
    input.0.warnings = warnings;
    input.warns("normals of 12 triangle(s) point against", "winding was taken");
}

/// The room and its camera `scale` times as large.
fn scaled(scale: f32) -> Input {
    let mut scene = room();
    for object in &mut scene.objects {
        object.mesh.positions.iter_mut().for_each(|p| *p *= scale);
    }
    let mut camera = camera();
    camera.world_from_camera.translation *= scale;
    let codes = Picture::new(photo_of_room(), Depth::Float);
    Input::new(&scene, camera, codes, Response::Linear, "exposure = 1\n")
}

#[test]
fn rooms_of_no_human_size_are_reported() {
    scaled(100.0).warns("m across; scenes are in metres", "centimetres");
    scaled(0.001).warns("mm across", "export it scaled to metres");
    assert_eq!(scaled(0.1).check().warnings.0, [""; 0]);
}

#[test]
fn cameras_in_the_wrong_place_are_reported() {
    let scene = room();
    let codes = Picture::new(photograph(&scene, &camera()), Depth::Float);
    let from = |eye: Vec3, target: Vec3| {
        let camera = Camera::look_at("c", eye, target, Vec3::Y, 0.55);
        Input::new(&scene, camera, codes.clone(), Response::Linear, "exposure = 1\n")
    };
    from(Vec3::new(0.0, 1.0, 3.0), Vec3::new(0.0, 1.0, 9.0))
        .warns("100 % of the picture", "calibrate");
    let middle_of_block = Vec3::new(-0.25, 0.35, -0.35);
    from(middle_of_block, Vec3::new(0.0, 0.3, -0.8))
        .warns("\"the block\" from behind", "inside it?");
    let before_block = Vec3::new(-0.25, 0.35, -0.08);
    from(before_block, Vec3::new(-0.25, 0.35, -0.3))
        .warns("object \"the block\" fills", "in the camera's way");
}

#[test]
fn groups_that_are_unseen_small_or_dark_are_reported() {
    let block = |low: Vec3, side: f32| {
        let mut scene = room();
        scene.objects[BLOCK].mesh = cuboid(low, low + side);
        let codes = Picture::new(photograph(&scene, &camera()), Depth::Float);
        Input::new(&scene, camera(), codes, Response::Linear, "exposure = 1\n")
    };
    block(Vec3::new(0.0, 0.5, -3.0), 0.5)
        .warns("no pixel shows \"block\"", "state it as known in [groups.NAME]");
    block(Vec3::new(0.0, 0.1, 0.0), 0.06)
        .warns("fewer than 40 valid pixels show \"block\"", "state it as known");
    // The camera is in a closed box, whose walls keep out the light of the lamp.
    let mut scene = room();
    let dark = cuboid(Vec3::new(-0.9, 0.0, -0.9), Vec3::new(0.9, 1.9, 0.9));
    let known = Group { name: "shut".into(), ..scene.groups[0].clone() };
    scene.groups.push(Group { material: Material::diffuse(Rgb::ZERO), ..known });
    scene.objects.push(Object { name: "box".into(), group: 5, mesh: dark });
    let inside =
        Camera::look_at("c", Vec3::new(0.5, 1.0, 0.8), Vec3::new(-0.3, 0.4, -0.4), Vec3::Y, 1.0);
    let codes = Picture::new(photo_of_room(), Depth::Float);
    let text = "exposure = 1\n";
    Input::new(&scene, inside, codes, Response::Linear, text)
        .warns("light reaches", "lamp missing");
}

fn unrender(arguments: &[&dyn AsRef<std::ffi::OsStr>]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_unrender"));
    arguments.iter().for_each(|argument| {
        command.arg(argument);
    });
    command.output().unwrap()
}

#[test]
fn the_command_finds_nothing_wrong_with_the_example_and_draws_it() {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/fig8/fig8.toml");
    let folder = Folder::new();
    let out = folder.path("drawn.png");
    let output = unrender(&[&"check", &project, &"--out", &out]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && output.stderr.is_empty(), "{text}");
    assert!(text.ends_with("\nnothing looks wrong\n"), "{text}");
    assert!(text.contains("\nceil (known)     0 "), "{text}");
    let drawn = picture::read(&out).unwrap().0.values;
    assert_eq!((drawn.width(), drawn.height()), (1024, 1024));
}

#[test]
fn json_help_and_bad_input() {
    let folder = Folder::new();
    let scene = room();
    folder.write("s.glb", &unrender::formats::gltf::to_glb(&scene).unwrap());
    picture::write(&folder.path("p.exr"), &photograph(&scene, &camera())).unwrap();
    let text = "scene = \"s.glb\"\nphoto = \"p.exr\"\nresponse = \"linear\"\nexposure = 90\n\
        camera = { eye = [0.1, 1, 3.2], target = [0, 0.7, 0], fov_y_deg = 31.5 }\n";
    let project = folder.write("a.toml", text);
    let out = folder.path("drawn.png");
    let output = unrender(&[&"check", &project, &"--out", &out, &"--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&json["groups"][1]["name"], &json["groups"][1]["role"]),
        (&"floor".into(), &"unknown".into())
    );
    assert!(json["edges"]["fit"].as_f64().unwrap() > 0.8);
    let warnings = json["warnings"].as_array().unwrap();
    assert!(
        warnings.len() == 1 && warnings[0].as_str().unwrap().contains("times as bright"),
        "{warnings:?}"
    );

    let fails = |arguments: &[&dyn AsRef<std::ffi::OsStr>], problem: &str| {
        let output = unrender(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{stderr}");
        assert!(stderr.starts_with("error: ") && stderr.contains(problem), "{stderr}");
    };
    let missing = folder.path("no.toml");
    fails(&[&"check", &missing, &"--out", &out], "no.toml: cannot be read");
    fails(
        &[&"check", &project, &"--out", &folder.path("a.jpg")],
        "end the name of the picture in .png",
    );
    folder.write("s.glb", "no scene");
    std::fs::remove_file(&out).unwrap();
    fails(&[&"check", &project, &"--out", &out], "s.glb");
    assert!(!out.exists());
    let help = unrender(&[&"check", &"--help"]);
    let help = String::from_utf8_lossy(&help.stdout);
    assert!(help.contains("Examples:") && help.contains("--json"), "{help}");
}
