//! The pixels of a photograph that are used, and the hypotheses that groups may have.

use super::*;

/// Paints the right half of the photograph white, as if an object that the model lacks stood there.
fn spoil(folder: &Corner) {
    let photo = folder.read("photo.png");
    let spoiled = RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        if x < SIZE.0 / 2 { *photo.at(x, y) } else { Rgb::new(0.9, 0.1, 0.1) }
    });
    picture::write_png_codes(&folder.path("photo.png"), &spoiled, Depth::Sixteen).unwrap();
}

#[test]
fn what_the_mask_leaves_out_does_not_count() {
    let folder = Corner::new();
    spoil(&folder);
    let mask = |width: usize| {
        let white = |x: usize| Rgb::splat(f32::from(u8::from(x < SIZE.0 / 2)));
        let mask = RgbImage::from_fn(width, SIZE.1, |x, _| white(x));
        picture::write_png_codes(&folder.path("mask.png"), &mask, Depth::Eight).unwrap();
    };
    mask(SIZE.0 - 1);
    let ambient = "[environment]\ncolor = 1\n";
    folder.refuses(
        &format!("mask = \"mask.png\"\n{ambient}"),
        "mask.png: the mask has 47 x 36 pixels and the photo 48 x 36",
    );
    folder.refuses("mask = \"none.png\"\n", "bad.toml: mask: there is no file");
    mask(SIZE.0);
    folder.write("project.toml", &format!("{HEAD}mask = \"mask.png\"\n{LIGHTS}"));
    folder.drafts(&["--no-refine", "--keep-camera", "--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth) in [("floor", FLOOR), ("wall", WALL)] {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.02, "{name}: {rho_d}");
    }
    let trust = folder.read("out/trust.png");
    let left_out = *trust.at(40, 30);
    assert!(left_out.x > left_out.y && left_out.z > left_out.x, "violet: {left_out}");
}

/// Writes the photograph with an alpha channel that is zero, and black pixels, from the column `from` on.
fn cut_out(folder: &Corner, from: usize) {
    let photo = folder.read("photo.png");
    let (width, height) = (photo.width() as u32, photo.height() as u32);
    let code = |value: f32| (65_535.0 * value).round() as u16;
    let pixels = photo.pixels().iter().enumerate().flat_map(|(index, rgb)| {
        let is_there = index % SIZE.0 < from;
        let [r, g, b] = rgb.to_array().map(code);
        if is_there { [r, g, b, u16::MAX] } else { [0; 4] }
    });
    let bytes: Vec<u8> = pixels.flat_map(u16::to_ne_bytes).collect();
    let mut png = Vec::new();
    let kind = image::ExtendedColorType::Rgba16;
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    image::ImageEncoder::write_image(encoder, &bytes, width, height, kind).unwrap();
    folder.write("photo.png", &png);
}

#[test]
fn what_is_cut_out_of_the_photograph_is_not_taken_for_black() {
    let folder = Corner::new();
    cut_out(&folder, SIZE.0 / 2);
    let told = succeeds(&folder.run(&["check", "project.toml", "--json"]));
    let pixels = SIZE.0 * SIZE.1 / 2;
    assert!(told.contains(&format!("{pixels} pixel(s) are transparent (alpha is 0)")), "{told}");
    assert!(!told.contains("and cannot be used"), "{told}");
    folder.drafts(&["--no-refine", "--keep-camera", "--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth) in [("floor", FLOOR), ("wall", WALL)] {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.02, "{name}: {rho_d}");
    }
    cut_out(&folder, 0);
    folder.refuses(LIGHTS, "photo.png: has no pixel with a measurement");
}

#[test]
fn ignored_groups_are_not_asked_for_and_not_counted() {
    let folder = Corner::new();
    folder.refuses("[groups.door]\nignore = true\n[environment]\ncolor = 1\n", "no group \"door\"");
    let [r, g, b] = WALL.to_array();
    let ignored = format!("[groups.wall]\nignore = true\nknown = {{ rho_d = [{r}, {g}, {b}] }}\n");
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}{ignored}"));
    let checked = succeeds(&folder.run(&["check", "project.toml"]));
    let row = checked.lines().find(|line| line.starts_with("wall (ignored) ")).unwrap();
    assert!(row.contains("by the project") && !row.contains("cut off"), "{row}");
    folder.drafts(&["--no-refine", "--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    assert_eq!(found.groups["wall"].status, Some(StatusEntry::Ignored));
    assert_eq!(found.groups["floor"].status, Some(StatusEntry::Of(Status::Recovered)));
    let floor = Rgb::from_array(found.groups["floor"].rho_d.unwrap());
    assert!((floor - FLOOR).abs().max_element() < 0.02, "{floor}");
    let wall = Rgb::from_array(found.groups["wall"].rho_d.unwrap());
    assert!((wall - WALL).abs().max_element() < 1e-5, "as it is known: {wall}");
    let run = folder.text("out/run.json");
    let run: serde_json::Value = serde_json::from_str(&run).unwrap();
    let wall = &run["groups"]["wall"];
    assert_eq!((&wall["asked"], &wall["counted"]["valid"]), (&false.into(), &0.into()));
    assert!(run["groups"]["floor"]["counted"]["valid"].as_u64() > Some(100));
}

#[test]
fn groups_have_the_hypotheses_that_are_allowed() {
    let folder = Corner::new();
    let rungs = "[recover]\nrungs = [\"diffuse\"]\n[groups.floor]\nrungs = [\"isotropic\"]\n";
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}{rungs}"));
    folder.drafts(&["--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth, hypothesis) in
        [("floor", FLOOR, Hypothesis::Isotropic), ("wall", WALL, Hypothesis::Diffuse)]
    {
        let entry = &found.groups[name];
        assert_eq!(entry.hypothesis, Some(hypothesis), "{name}: {:?}", entry.note);
        let rho_d = Rgb::from_array(entry.rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.05, "{name}: {rho_d}");
    }
    folder.succeeds(&[
        "recover",
        "project.toml",
        "--max-rung",
        "diffuse",
        "--no-refine",
        "--spp",
        "1",
        "--out",
        "plain",
    ]);
    let found = materials::read(&folder.path("plain/materials.json")).unwrap();
    assert_eq!(found.groups["floor"].hypothesis, Some(Hypothesis::Diffuse));
}

#[test]
fn bounds_of_a_project_are_kept_by_its_results() {
    let folder = Corner::new();
    let bounds = "[groups.floor]\nalpha_x = { start = 0.4, min = 0.3 }\n[groups.wall]\n\
                  rho_d = { max = [1, 0.2, 1] }\nrho_s = { max = 0 }\n[recover]\nmax_rung = \"isotropic\"\n";
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}{bounds}"));
    folder.drafts(&["--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let [floor, wall] = ["floor", "wall"].map(|name| &found.groups[name]);
    let is_rough = floor.alpha_x.is_some_and(|alpha| alpha >= 0.3);
    assert!(is_rough || floor.hypothesis == Some(Hypothesis::Diffuse), "{floor:?}");
    assert_eq!((wall.hypothesis, wall.rho_d.unwrap()[1]), (Some(Hypothesis::Diffuse), 0.2));
    let note = wall.note.as_deref().unwrap_or_default();
    assert!(note.contains("rho_d lies on its bound max = [1, 0.2, 1] in green"), "{note}");
}

#[test]
fn groups_of_one_material_are_recovered_as_one() {
    let folder = Corner::new();
    let same = "[groups.wall]\nsame_as = \"floor\"\n[recover]\nmax_rung = \"diffuse\"\n";
    folder.write("project.toml", &format!("{HEAD}{LIGHTS}{same}"));
    let checked = succeeds(&folder.run(&["check", "project.toml"]));
    let row = checked.lines().find(|line| line.starts_with("wall (same as floor) ")).unwrap();
    let words: Vec<&str> = row.split_whitespace().skip(4).collect();
    assert_eq!(words[..3], ["-", "-", "-"], "its pixels are counted with the other's: {row}");
    folder.drafts(&["--spp", "4"]);
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    let scores = unrender::score::score(&found, &folder.path("out"), &found, &folder.path("out"));
    let counted = scores.unwrap().into_iter().filter(|score| score.counted);
    assert_eq!(counted.map(|score| score.group).collect::<Vec<_>>(), ["floor", "wall"]);
    assert_eq!(found.groups["wall"].status, Some(StatusEntry::SameAs("floor".into())));
    let [floor, wall] = ["floor", "wall"].map(|name| &found.groups[name]);
    assert_eq!((floor.rho_d, floor.hypothesis), (wall.rho_d, wall.hypothesis));
    assert_eq!(floor.std, wall.std);
    let red = floor.rho_d.unwrap()[0];
    assert!(red > WALL.x + 0.02 && red < FLOOR.x - 0.02, "between both: {red}");
    let note = wall.note.as_deref().unwrap();
    assert!(note.starts_with("one material with \"floor\", as the project states"), "{note}");
    // The scene keeps both groups, each with its own objects.
    let written = unrender::formats::load_model(&folder.path("out/scene.glb")).unwrap().0;
    let truth = corner();
    for (object, was) in written.objects.iter().zip(&truth.objects) {
        assert_eq!(written.groups[object.group].name, truth.groups[was.group].name);
    }
    let [a, b] = ["floor", "wall"].map(|name| &written.groups[written.group_index(name).unwrap()]);
    assert_eq!(a.material.rho_d, b.material.rho_d);
}

#[test]
fn from_the_white_level_on_a_photograph_is_clipped() {
    let folder = Corner::new();
    let clipped = |line: &str| {
        folder.write("project.toml", &format!("{HEAD}{line}{LIGHTS}"));
        let (project, warnings) = Project::read(&folder.path("project.toml")).unwrap();
        Job::load(project, warnings).unwrap().photo.clipped
    };
    let [all, some, none] = ["white_level = 0.001\n", "white_level = 0.4\n", ""].map(clipped);
    let over = folder.read("photo.png");
    let over = over.pixels().iter().filter(|code| code.max_element() >= 0.4).count();
    assert_eq!((all, some), (SIZE.0 * SIZE.1, over));
    // The bulb is clipped in any case.
    assert!(none < some && some < all, "{none} {some}");
    folder.refuses(
        "white_level = 250\n[environment]\ncolor = 1\n",
        "bad.toml: white_level is [250, 250, 250]; it is a code of at most 1",
    );
}
