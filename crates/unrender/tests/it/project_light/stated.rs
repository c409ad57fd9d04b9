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
    // The scene of the results has the light that glTF can hold, and a message names what it lacks.
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
