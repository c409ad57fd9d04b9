//! Lights and environments of unknown brightness.

use super::stated::{apart, environment_of};
use super::*;

#[test]
fn lights_of_a_project_may_be_unknown() {
    let folder = Corner::new();
    let text = LIGHTS.replace("[4, 4, 4]", "[3, 3, 3]\nunknown = true");
    folder.write("project.toml", &format!("{HEAD}{text}"));
    folder.drafts(&["--spp", "16"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let bulb = found.lights["bulb"].intensity.unwrap();
    assert!(bulb.iter().all(|v| (v - 4.0).abs() < 0.2), "{bulb:?}");
}

#[test]
fn the_light_from_all_around_may_be_unknown() {
    let folder = Corner::new();
    let bulb = LIGHTS.replace("color = [0.2, 0.25, 0.3]", "unknown = \"uniform\"");
    folder.write("project.toml", &format!("{HEAD}{bulb}"));
    folder.drafts(&["--spp", "16"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let around = &found.lights["environment"];
    let (mean, std) = (around.intensity.unwrap(), around.std.unwrap());
    for c in 0..3 {
        assert!((mean[c] - AMBIENT[c]).abs() < 3.0 * std[c] && std[c] < 0.01, "{mean:?} {std:?}");
    }
    for (name, truth) in [("floor", FLOOR), ("wall", WALL)] {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.01, "{name}: {rho_d}");
    }
    // It is part of the results.
    folder.succeeds(&["export", "out", "--to", "mitsuba", "--out", "mitsuba"]);
    let exported = environment_of(&folder, "mitsuba/scene.xml").uniform().unwrap();
    assert!((exported - Rgb::from_array(mean)).abs().max_element() < 1e-6, "{exported}");
    let again = ["restage", "--recovered", "out", "--project", "project.toml", "--spp", "64"];
    folder.succeeds(&[&again[..], &["--out", "new"]].concat());
    let off = difference(&folder.read("new/synthetic.png"), &folder.read("photo.png"));
    assert!(off < 0.01, "{off}");
    let alone = bulb.split("[[lights]]").next().unwrap();
    folder.refuses(alone, "every light is unknown");
    folder.refuses(
        &alone.replace("[environment]\n", "[environment]\nremove = true\n"),
        "it is unknown or removed",
    );
    folder.write("edit.toml", &format!("project = \"project.toml\"\n{alone}"));
    let told = folder.run(&["restage", "edit.toml", "--spp", "1", "--out", "none"]).stderr;
    let told = String::from_utf8(told).unwrap();
    assert!(told.contains("unknown is a key of project files"), "{told}");
}

#[test]
fn of_lights_of_known_colour_one_factor_is_unknown() {
    let folder = Corner::new();
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
fn light_may_be_unknown_direction_by_direction() {
    // Four times as bright from above and one side as from the other.
    let sky = |x: usize, y: usize| {
        let heading = std::f32::consts::TAU * (x as f32 + 0.5) / 16.0;
        let height = (1.0 - y as f32 / 4.0).max(0.0);
        AMBIENT * (1.0 + 3.0 * height * (-heading.sin()).max(0.0))
    };
    let sky = Environment::new(RgbImage::from_fn(16, 8, sky), 0.0).unwrap();
    let folder = Corner::in_light(sky.clone());
    let project = LIGHTS.replace("color = [0.2, 0.25, 0.3]", "unknown = true");
    folder.write("project.toml", &format!("{HEAD}{project}"));
    folder.succeeds(&["recover", "project.toml", "--spp", "16", "--out", "out"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let around = &found.lights["environment"];
    let (mean, std) = (around.intensity.unwrap(), around.std.unwrap());
    for c in 0..3 {
        let off = (mean[c] - sky.mean()[c]).abs();
        assert!(off < 3.0 * std[c] && std[c] < 0.06, "{mean:?} {std:?}");
    }
    for (name, truth) in [("floor", FLOOR), ("wall", WALL)] {
        let [rho_d, std] = [found.groups[name].rho_d, found.groups[name].std.unwrap().rho_d]
            .map(|three| Rgb::from_array(three.unwrap()));
        let off = (rho_d - truth).abs();
        assert!(off.cmple(3.0 * std).all() && std.max_element() < 0.15, "{name}: {rho_d} {std}");
    }
    // The standard deviation of every direction is right. The part of the sky that the corner sees, in front of
    // the wall and above the floor, is determined.
    let panorama = around.panorama.as_ref().unwrap();
    let (mut found_by_place, mut true_by_place) = (Vec::new(), Vec::new());
    for (index, radiance) in panorama.radiance.iter().enumerate() {
        let (column, row) = (index % panorama.columns, index / panorama.columns);
        let u = (column as f32 + 0.5) / panorama.columns as f32;
        let v = (row as f32 + 0.5) / panorama.rows as f32;
        let direction = sky.direction(u, Environment::cos_polar(v));
        let truth = sky.radiance(direction);
        let off = (Rgb::from_array(*radiance) - truth).abs();
        let std = Rgb::from_array(panorama.std[index]);
        assert!(off.cmple(3.0 * std).all(), "{direction}: {off} off, std {std}");
        if direction.z > 0.1 && direction.y > 0.1 {
            found_by_place.push(radiance[1]);
            true_by_place.push(truth.y);
        }
    }
    let r = correlation(&found_by_place, &true_by_place);
    assert!(r > 0.7, "correlation {r}: {found_by_place:?} {true_by_place:?}");
    // It goes along in exports.
    let pixels = panorama.radiance.iter().map(|radiance| Rgb::from_array(*radiance)).collect();
    let recovered = RgbImage::new(panorama.columns, panorama.rows, pixels);
    let recovered = Environment::new(recovered, 0.0).unwrap();
    folder.succeeds(&["export", "out", "--to", "mitsuba", "--out", "mitsuba"]);
    let off = apart(&environment_of(&folder, "mitsuba/scene.xml"), &recovered);
    assert!(off < 0.01, "{off}");
    // It is part of the results, with and without the project. Surfaces are nearer to the photograph than pixels
    // that show the sky itself, which are not used to recover it.
    let scene = corner();
    let tracer = Tracer::new(&scene);
    let camera = &scene.cameras[0];
    let shows_surface = |x: usize, y: usize| {
        let towards = camera.direction(x as f32 + 0.5, y as f32 + 0.5, SIZE.0, SIZE.1);
        tracer.surface(&Ray::new(camera.origin(), towards)).is_some()
    };
    for project in [&["--project", "project.toml"][..], &["--camera", "photo", "--width", "48"][..]]
    {
        let again = ["restage", "--recovered", "out", "--spp", "64", "--out", "new"];
        folder.succeeds(&[&again[..], project].concat());
        // The EXR is used, not the PNG of 8 bits.
        let new = folder.read("new/synthetic.exr").map(|rgb| rgb.map(srgb_from_linear));
        let photo = folder.read("photo.png");
        let off = difference(&new, &photo);
        assert!(off < 0.015, "{off}");
        let [new, photo] = [new, photo].map(|picture| {
            let of_surfaces =
                |x, y| if shows_surface(x, y) { *picture.at(x, y) } else { Rgb::ZERO };
            RgbImage::from_fn(SIZE.0, SIZE.1, of_surfaces)
        });
        let off = difference(&new, &photo);
        assert!(off < 0.004, "surfaces: {off}");
        assert!(off < 0.004, "{off}");
    }
}

fn correlation(a: &[f32], b: &[f32]) -> f32 {
    let mean = |v: &[f32]| v.iter().sum::<f32>() / v.len() as f32;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let product = |v: &[f32], m: f32, w: &[f32], n: f32| -> f32 {
        v.iter().zip(w).map(|(x, y)| (x - m) * (y - n)).sum()
    };
    product(a, mean_a, b, mean_b)
        / (product(a, mean_a, a, mean_a) * product(b, mean_b, b, mean_b)).sqrt()
}
