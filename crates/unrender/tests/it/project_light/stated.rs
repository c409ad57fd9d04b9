//! Lights and environments that a project states.

use super::*;

#[test]
fn a_room_is_recovered_in_the_light_of_its_project() {
    let folder = Corner::new();
    folder.succeeds(&["check", "project.toml"]);
    folder.drafts(&["--no-refine", "--spp", "16"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth) in [("floor", FLOOR), ("wall", WALL)] {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.01, "{name}: {rho_d}");
    }
    // The scene of the results has the light that glTF can hold, and run.json the rest.
    let scene = gltf::read(&folder.path("out/scene.glb")).unwrap().0;
    let bulb = scene.group_index("bulb").unwrap();
    assert_eq!(scene.groups[bulb].emission, Rgb::splat(4.0));
    let page = folder.text("out/report.html");
    assert!(page.contains("[0.2, 0.25, 0.3] from everywhere"));
    let size = ["--spp", "64", "--width", "48", "--height", "36"];
    let around = ["--camera", "photo"];
    let told = folder.succeeds(
        &[&["restage", "--recovered", "out", "--out", "alone"], &around[..], &size[..]].concat(),
    );
    assert!(!told.contains("environment"), "{told}");
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
    for with_and_without_project in ["new/synthetic.png", "alone/synthetic.exr"] {
        let picture = folder.read(with_and_without_project);
        let is_radiance = with_and_without_project.ends_with("exr");
        let picture =
            if is_radiance { picture.map(|rgb| rgb.map(srgb_from_linear)) } else { picture };
        let off = difference(&picture, &photo);
        assert!(off < 0.01, "{with_and_without_project}: {off}");
    }
    folder.succeeds(&["export", "out", "--to", "mitsuba", "--out", "mitsuba"]);
    assert_eq!(environment_of(&folder, "mitsuba/scene.xml").uniform(), Some(AMBIENT));
}

/// The environment of the exported scene `name`.
pub(super) fn environment_of(folder: &Corner, name: &str) -> Environment {
    unrender::formats::load_scene(&folder.path(name)).unwrap().0.environment.unwrap()
}

#[test]
fn lights_are_put_in_place_before_their_names_are_looked_for() {
    let folder = Corner::new();
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
fn edits_have_the_same_lights_and_environments() {
    let folder = Corner::new();
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
    assert_eq!(folder.bytes("edit.out/synthetic.exr"), folder.bytes("none.out/synthetic.exr"));
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
    let folder = Corner::new();
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

#[test]
fn a_project_is_rendered_as_its_photograph_was_taken() {
    let folder = Corner::new();
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

/// The largest difference of two environments over some directions.
pub(super) fn apart(one: &Environment, other: &Environment) -> f32 {
    let directions = (0..200).map(|k| {
        let (y, around) = (1.0 - (k as f32 + 0.5) / 100.0, 2.4 * k as f32);
        Vec3::new((1.0 - y * y).sqrt() * around.cos(), y, (1.0 - y * y).sqrt() * around.sin())
    });
    let off = directions.map(|d| (one.radiance(d) - other.radiance(d)).abs().max_element());
    off.fold(0.0, f32::max)
}

#[test]
fn a_panorama_of_the_project_goes_along_in_exports() {
    let sky = RgbImage::from_fn(16, 8, |x, y| {
        AMBIENT * (1.0 + y as f32 / 8.0 + (std::f32::consts::TAU * x as f32 / 16.0).sin())
    });
    let turned = |scale: f32, rotation_deg: f32| {
        Environment::new(sky.map(|rgb| *rgb * scale), rotation_deg.to_radians()).unwrap()
    };
    let folder = Corner::in_light(turned(0.5, -100.0));
    picture::write(&folder.path("sky.exr"), &sky).unwrap();
    let panorama = "panorama = \"sky.exr\"\nrotation_deg = -100\nscale = 0.5";
    let project = LIGHTS.replace("color = [0.2, 0.25, 0.3]", panorama);
    folder.write("project.toml", &format!("{HEAD}{project}"));
    folder.drafts(&["--no-refine", "--spp", "4"]);
    for (format, file) in [("mitsuba", "scene.xml"), ("radiance", "scene.rad")] {
        let told = folder.succeeds(&["export", "out", "--to", format, "--out", format]);
        assert!(!told.contains("environment"), "{format}: {told}");
        let off =
            apart(&environment_of(&folder, &format!("{format}/{file}")), &turned(0.5, -100.0));
        assert!(off < 0.01, "{format}: {off}");
    }
    let told = folder.succeeds(&["export", "out", "--to", "gltf", "--out", "room.glb"]);
    for words in ["turned about +y by -100.0 degrees", "environment is out/environment.exr"] {
        assert!(told.replace('\\', "/").contains(words), "{words}: {told}");
    }
    // Another one, of which the scale and the turn are stated; also for a scene that has none.
    let other = "sky.exr: rotation_deg = 30, scale = 2";
    for (of, name) in [(&["out"][..], "new"), (&["--scene", "scene.glb"], "scene")] {
        let words = ["--width", "48", "--height", "36", "--environment", other];
        let to = ["export", "--to", "mitsuba", "--out", name];
        folder.succeeds(&[&to[..], of, &words].concat());
        let off = apart(&environment_of(&folder, &format!("{name}/scene.xml")), &turned(2.0, 30.0));
        assert!(off < 0.02, "{name}: {off}");
    }
    let bad =
        folder.run(&["export", "out", "--to", "pbrt", "--out", "x", "--environment", "no.exr"]);
    fails(&bad, "no.exr");
}
