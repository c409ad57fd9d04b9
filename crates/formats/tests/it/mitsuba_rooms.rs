//! What published rooms of Mitsuba 0.5, 0.6 and 3 have: colours as pictures have them, old models, glass, the sky.

use crate::support::Folder;
use glam::Vec3;
use unrender_formats::load_model;
use unrender_scene::{Environment, Glass, Group, LightKind, Rgb, Scene, Warnings};

/// What is read of a scene with `inside`, of this version.
fn read(version: &str, inside: &str) -> Result<(Scene, Warnings), String> {
    let folder = Folder::new();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::create_dir_all(folder.path("models")).unwrap();
    folder.file("models/leg.obj", triangle);
    let text = format!("<scene version=\"{version}\">\n{inside}\n</scene>");
    load_model(&folder.file("scene.xml", text)).map_err(|error| error.to_string())
}

fn old(inside: &str) -> (Scene, Warnings) {
    read("0.6.0", inside).unwrap_or_else(|error| panic!("{error}"))
}

fn group<'a>(scene: &'a Scene, name: &str) -> &'a Group {
    let found = scene.groups.iter().find(|group| group.name == name);
    found.unwrap_or_else(|| panic!("no group {name}"))
}

fn told<'a>(warnings: &'a Warnings, word: &str) -> Vec<&'a String> {
    warnings.0.iter().filter(|warning| warning.contains(word)).collect()
}

/// A cube of the BSDF `bsdf` with the id `id`.
fn cube(id: &str, bsdf: &str) -> String {
    format!(
        "<shape type=\"cube\">{}</shape>",
        bsdf.replacen("<bsdf", &format!("<bsdf id=\"{id}\""), 1)
    )
}

fn close(found: Rgb, wanted: [f32; 3]) {
    let off = (found - Rgb::from_array(wanted)).abs().max_element();
    assert!(off < 2e-3, "{found} is not {wanted:?}");
}

#[test]
fn colours_as_pictures_have_them_become_linear() {
    let wall = |value: &str| {
        format!("<bsdf type=\"diffuse\"><srgb name=\"reflectance\" value=\"{value}\"/></bsdf>")
    };
    let inside = cube("hex", &wall("#ff8000"))
        + &cube("three", &wall("1, 0.5 0"))
        + &cube("one", &wall("0.5"));
    let (scene, warnings) = old(&inside);
    close(group(&scene, "hex").material.rho_d, [1.0, 0.2159, 0.0]);
    close(group(&scene, "three").material.rho_d, [1.0, 0.2140, 0.0]);
    close(group(&scene, "one").material.rho_d, [0.2140; 3]);
    assert_eq!(warnings.0, [""; 0]);
    for value in ["#ff80", "#ff80zz", "ff8000", "1 0.5", "", "1.5 0 0", "-0.1", "nan", "#ééé"] {
        let error = read("0.6.0", &cube("wall", &wall(value))).unwrap_err();
        assert!(error.contains("line 2: ") && error.contains("reflectance"), "{value}: {error}");
    }
}

#[test]
fn models_that_later_versions_lack_are_taken_as_the_nearest_ones() {
    let phong = "<bsdf type=\"phong\"><float name=\"exponent\" value=\"198\"/>
        <rgb name=\"diffuseReflectance\" value=\"0.3\"/><rgb name=\"specularReflectance\" value=\"0.4\"/></bsdf>";
    let rough = "<bsdf type=\"roughdiffuse\"><rgb name=\"reflectance\" value=\"0.6\"/>
        <float name=\"alpha\" value=\"0.5\"/></bsdf>";
    let (scene, warnings) = old(&(cube("gloss", phong) + &cube("cloth", rough)));
    let gloss = &group(&scene, "gloss").material;
    close(gloss.rho_s, [0.4; 3]);
    close(gloss.rho_d, [0.3; 3]);
    // cos^198 is as high in the middle as Ward's lobe of 0.05: 200 / (2 pi) = 1 / (4 pi 0.05^2).
    assert!((gloss.alpha_x - 0.05).abs() < 1e-6 && gloss.alpha_y == gloss.alpha_x);
    let cloth = &group(&scene, "cloth").material;
    assert!(
        cloth.rho_d.x < 0.59 && cloth.rho_d.x > 0.5 && cloth.rho_s == Rgb::ZERO,
        "{}",
        cloth.rho_d
    );
    assert_eq!(told(&warnings, "phong was taken").len(), 1, "{warnings:?}");
    assert_eq!(told(&warnings, "roughdiffuse was taken").len(), 1, "{warnings:?}");
    for wrong in
        ["<rgb name=\"exponent\" value=\"-1\"/>", "<string name=\"exponent\" value=\"high\"/>"]
    {
        let error =
            read("0.6.0", &cube("a", &format!("<bsdf type=\"phong\">{wrong}</bsdf>"))).unwrap_err();
        assert!(error.contains("line 2: ") && error.contains("exponent"), "{error}");
    }
}

#[test]
fn three_numbers_of_a_spectrum_and_codes_of_a_colour_are_linear_in_old_files() {
    let wall = |value: &str| format!("<bsdf type=\"diffuse\"><{value}/></bsdf>");
    let three = wall("spectrum name=\"reflectance\" value=\"0.2, 0.5,0.7\"");
    let code = wall("rgb name=\"reflectance\" value=\"#336699\"");
    let (scene, _) = old(&(cube("three", &three) + &cube("code", &code)));
    close(group(&scene, "three").material.rho_d, [0.2, 0.5, 0.7]);
    close(group(&scene, "code").material.rho_d, [0.2, 0.4, 0.6]);
    for wall in [three, code] {
        assert!(
            read("3.0.0", &cube("wall", &wall)).unwrap_err().contains("line 2: in reflectance")
        );
    }
}

#[test]
fn a_coating_darkens_what_it_coats() {
    let coat = |inner: &str| {
        format!("<bsdf type=\"coating\">{inner}<string name=\"intIOR\" value=\"bromine\"/></bsdf>")
    };
    let wall = coat("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.5\"/></bsdf>");
    let metal = coat("<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/></bsdf>");
    let glass = coat("<bsdf type=\"dielectric\"/>");
    let (scene, warnings) =
        old(&(cube("wall", &wall) + &cube("metal", &metal) + &cube("glass", &glass)));
    let f0 = ((1.661f32 / 1.000_277 - 1.0) / (1.661 / 1.000_277 + 1.0)).powi(2);
    let wall = &group(&scene, "wall").material;
    close(wall.rho_s, [f0; 3]);
    assert!(wall.rho_d.x > 0.1 && wall.rho_d.x < 0.25, "{}", wall.rho_d);
    close(group(&scene, "metal").material.rho_s, [(1.0 - f0).powi(2); 3]);
    assert_eq!(scene.ungrouped_materials(), ["glass"]);
    assert!(!wall.reflectance.is_free());
    assert_eq!(told(&warnings, "coating").len(), 1, "{warnings:?}");
}

/// Measured indices lie below zero in red where the colour of their spectrum is out of gamut.
#[test]
fn a_metal_may_have_an_index_below_zero() {
    let metal = |eta: &str| {
        format!(
            "<bsdf type=\"conductor\"><rgb name=\"eta\" value=\"{eta}\"/><rgb name=\"k\" value=\"5.2, 4.2, 3.7\"/>
             <float name=\"extEta\" value=\"1\"/></bsdf>"
        )
    };
    let (scene, warnings) =
        old(&(cube("below", &metal("-0.05, 0.2, 0.3")) + &cube("above", &metal("0.05, 0.2, 0.3"))));
    let below = group(&scene, "below").material.rho_s;
    assert_eq!(below, group(&scene, "above").material.rho_s);
    assert!(below.max_element() <= 1.0 && below.x > 0.98, "{below}");
    assert!(told(&warnings, "not read").is_empty(), "{warnings:?}");
    // Without any number a conductor of Mitsuba 0.6 is copper, one of Mitsuba 3 a mirror.
    let plain = cube("plain", "<bsdf type=\"conductor\"/>");
    assert!(group(&old(&plain).0, "plain").material.rho_s.z < 0.6);
    let (scene, _) = read("3.0.0", &plain).unwrap();
    assert_eq!(group(&scene, "plain").material.rho_s, Rgb::ONE);
}

#[test]
fn glass_is_told_with_one_line_wherever_it_stands() {
    let glass = "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/></bsdf>";
    let thin =
        format!("<bsdf type=\"twosided\">{}</bsdf>", glass.replace("dielectric", "thindielectric"));
    let rough = glass.replace("dielectric", "roughdielectric");
    let inner = [
        cube("a", glass),
        cube("b", &thin),
        cube("c", &format!("<bsdf type=\"bumpmap\">{rough}</bsdf>")),
        cube(
            "d",
            &format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.5\"/>{glass}</bsdf>"),
        ),
        cube("e", "<bsdf type=\"principled\"><float name=\"spec_trans\" value=\"0.9\"/></bsdf>"),
        cube("f", &format!("<bsdf type=\"blendbsdf\">{glass}<bsdf type=\"diffuse\"/></bsdf>")),
        cube("wall", "<bsdf type=\"diffuse\"/>"),
    ];
    let inside = inner.concat()
        + "<shape type=\"obj\"><string name=\"filename\" value=\"models/leg.obj\"/><ref id=\"a\"/></shape>";
    let (scene, warnings) = read("3.0.0", &inside).unwrap();
    assert_eq!(scene.ungrouped_materials(), ["a", "b", "c", "d", "e", "f"]);
    assert_eq!(scene.ungrouped.len(), 7);
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(scene.groups.iter().map(|group| group.name.as_str()).collect::<Vec<_>>(), ["wall"]);
    let all = "\"a\", \"b\", \"c\", \"d\", \"e\", \"f\" are glass: they are rendered as the file says, smooth, and not recovered";
    for (words, count) in [
        (all, 1),
        ("material \"c\": its bumpmap was left out", 1),
        ("materials \"c\", \"e\": it is rough, but was taken as smooth", 1),
        ("material \"d\": its mask was left out", 1),
        ("material \"e\": its spec_trans is below one", 1),
        ("material \"f\": it is blended with another BSDF", 1),
        ("", 6),
    ] {
        assert_eq!(told(&warnings, words).len(), count, "{words}: {warnings:?}");
    }
    let glasses: Vec<Glass> = scene.ungrouped.iter().map(|shape| shape.glass.unwrap()).collect();
    let bodies: Vec<bool> = glasses.iter().map(|glass| !glass.is_thin).collect();
    assert_eq!(bodies, [true, false, true, true, true, true, false], "only the last one is open");
    for (glass, ior) in glasses.iter().zip([1.5f32; 4]) {
        assert!((glass.ior - ior / 1.000_277).abs() < 1e-6 && glass.tint == Rgb::ONE, "{glass:?}");
    }
    assert!((glasses[4].ior - 1.5).abs() < 1e-5, "{:?}", glasses[4]);
    close(glasses[4].tint, [0.5f32.sqrt(); 3]);
    // A lamp of glass still shines.
    let lamp = format!("<shape type=\"sphere\">{glass}<emitter type=\"area\"/></shape>");
    let (scene, _) = read("3.0.0", &lamp).unwrap();
    assert!(scene.ungrouped.is_empty() && scene.groups[0].is_emitter());
}

#[test]
fn what_is_not_modelled_of_a_surface_is_told_and_does_not_refuse_the_file() {
    let wall = "<bsdf type=\"diffuse\"/>";
    let inside = [("bumpmap", "bumps"), ("normalmap", "normals")]
        .map(|(kind, id)| cube(id, &format!("<bsdf type=\"{kind}\">{wall}</bsdf>")));
    let mask = format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.5\"/>{wall}</bsdf>");
    let (scene, warnings) = old(&(inside.concat() + &cube("leaf", &mask) + &cube("leaf2", &mask)));
    assert_eq!(scene.objects.len(), 4);
    assert_eq!(told(&warnings, "its bumpmap was left out").len(), 1, "{warnings:?}");
    assert_eq!(told(&warnings, "its normalmap was left out").len(), 1, "{warnings:?}");
    assert_eq!(
        told(&warnings, "groups \"leaf\", \"leaf2\": its mask was left out").len(),
        1,
        "{warnings:?}"
    );
}

#[test]
fn trilinear_textures_are_bilinear_here() {
    let folder = Folder::new();
    let image = unrender_scene::RgbImage::new(2, 1, vec![Rgb::splat(0.5); 2]);
    unrender_formats::picture::write_png_srgb(&folder.path("p.png"), &image).unwrap();
    let scene = |filter: &str| {
        let text = format!(
            "<scene version=\"0.6.0\"><shape type=\"cube\"><bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">
             <string name=\"filename\" value=\"p.png\"/><string name=\"filterType\" value=\"{filter}\"/>
             </texture></bsdf></shape></scene>"
        );
        load_model(&folder.file("scene.xml", text))
    };
    for filter in ["trilinear", "ewa", "bilinear"] {
        assert_eq!(scene(filter).unwrap().1.0, [""; 0], "{filter}");
    }
    assert!(scene("cubic").unwrap_err().to_string().contains("\"trilinear\""));
}

#[test]
fn shapes_without_an_id_are_called_by_their_file_or_line() {
    let inside = "<shape type=\"obj\"><string name=\"filename\" value=\"models/leg.obj\"/></shape>
        <shape type=\"rectangle\"><bsdf type=\"diffuse\"/></shape>
        <shape type=\"cube\" id=\"box\"><bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf></shape>
        <shape type=\"disk\"><bsdf type=\"twosided\"><bsdf type=\"diffuse\" id=\"plate\"/></bsdf></shape>";
    let (scene, _) = old(inside);
    let objects: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    let mut sorted = objects.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, ["box", "disk at line 5", "leg.obj", "rectangle at line 3"]);
    let groups: Vec<&str> = scene.groups.iter().map(|group| group.name.as_str()).collect();
    for name in ["rectangle at line 3", "box", "plate"] {
        assert!(groups.contains(&name), "{groups:?}");
    }
}

#[test]
fn a_camera_has_the_size_of_its_film() {
    let camera = |film: &str| {
        let inside = format!(
            "<shape type=\"cube\"/><sensor type=\"perspective\"><film type=\"hdrfilm\">{film}</film></sensor>"
        );
        read("0.5.0", &inside).map(|(scene, _)| scene.cameras[0].size)
    };
    let side = |name: &str, value: &str| format!("<integer name=\"{name}\" value=\"{value}\"/>");
    let film = side("width", "1280") + &side("height", "720");
    assert_eq!(camera(&film), Ok(Some([1280, 720])));
    let part = film + &side("cropWidth", "100") + &side("cropHeight", "50");
    assert_eq!(camera(&part), Ok(Some([100, 50])));
    assert_eq!(camera(""), Ok(Some([768, 576])));
    for value in ["0", "-3", "wide"] {
        let error = camera(&side("width", value)).unwrap_err();
        assert!(error.contains("line 2: ") && error.contains("width"), "{error}");
    }
    // It is not rendered unasked.
    assert!(camera(&side("width", "4000000000")).is_ok());
}

/// The environment of a `sunsky` with these properties.
fn sky(version: &str, kind: &str, inside: &str) -> Environment {
    let text = format!("<shape type=\"cube\"/><emitter type=\"{kind}\">{inside}</emitter>");
    let (scene, warnings) = read(version, &text).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(warnings.0, [""; 0]);
    scene.environment.unwrap()
}

/// The direction that shines most, and the irradiance across it from all around, which is hardly more than the sun's.
fn brightest(sky: &Environment) -> (Vec3, Rgb) {
    let panorama = sky.panorama();
    let (width, height) = (panorama.width(), panorama.height());
    let mut best = (0.0, Vec3::ZERO);
    let mut sum = Rgb::ZERO;
    for row in 0..height {
        for column in 0..width {
            let [u, v] = [(column as f32 + 0.5) / width as f32, (row as f32 + 0.5) / height as f32];
            let radiance = *panorama.at(column, row);
            let sin = (std::f32::consts::PI * v).sin();
            sum += radiance * sin;
            if radiance.y > best.0 {
                best = (radiance.y, sky.direction(u, Environment::cos_polar(v)));
            }
        }
    }
    let pixel = std::f32::consts::TAU / width as f32 * std::f32::consts::PI / height as f32;
    (best.1, sum * pixel)
}

#[test]
fn the_sun_stands_where_it_is_stated_and_shines_alike_at_any_size() {
    let towards = Vec3::new(-0.865_804, 0.416_766, -0.276_929).normalize();
    let stated = "<vector name=\"sunDirection\" x=\"-0.865804\" y=\"0.416766\" z=\"-0.276929\"/>";
    let sun = |more: &str| brightest(&sky("0.6.0", "sun", &format!("{stated}{more}")));
    let (found, power) = sun("");
    assert!(found.dot(towards) > 0.99998, "{found} {towards}");
    assert!(power.y > 0.6 && power.y < 1.0 && power.x > power.z, "{power}");
    let (_, wide) = sun("<float name=\"sunRadiusScale\" value=\"20\"/>");
    assert!((wide / power - 1.0).abs().max_element() < 0.01, "{wide} {power}");
    let (_, tiny) = sun("<float name=\"sunRadiusScale\" value=\"0.001\"/>");
    assert!((tiny / power - 1.0).abs().max_element() < 0.01, "{tiny} {power}");
    // With no size it is a light of its own.
    let zero = "<float name=\"sunRadiusScale\" value=\"0\"/>";
    let (scene, _) =
        old(&format!("<shape type=\"cube\"/><emitter type=\"sun\">{stated}{zero}</emitter>"));
    let LightKind::Directional { direction, irradiance } = scene.lights[0].kind else { panic!() };
    assert!((direction + towards).length() < 1e-4);
    assert!((irradiance / power - 1.0).abs().max_element() < 0.01, "{irradiance} {power}");
    assert!(scene.environment.is_none());
}

/// Mitsuba 3.9.1's `sunsky` of turbidity 3, albedo 0.2 and a sun 30 degrees high, evaluated at the zenith and at
/// (0.3, 0.4, 0.6), with z up.
#[test]
fn the_sky_is_that_of_mitsuba_3() {
    let inside = "<float name=\"turbidity\" value=\"3\"/><rgb name=\"albedo\" value=\"0.2\"/>
        <vector name=\"sun_direction\" x=\"0.8660254\" y=\"0\" z=\"0.5\"/><float name=\"sun_scale\" value=\"0\"/>";
    let sky = sky("3.0.0", "sunsky", inside);
    for (towards, wanted) in [
        (Vec3::Z, [0.015_734, 0.029_892, 0.059_749]),
        (Vec3::new(0.3, 0.4, 0.6).normalize(), [0.030_235, 0.050_42, 0.087_258]),
    ] {
        let off = sky.radiance(towards) / Rgb::from_array(wanted) - 1.0;
        assert!(off.abs().max_element() < 5e-3, "{towards}: {off}");
    }
    assert_eq!(sky.radiance(Vec3::new(0.3, 0.1, -0.9).normalize()), Rgb::ZERO);
}

#[test]
fn up_is_y_in_old_files_and_turns_with_them() {
    let stated = |direction: &str| format!("<vector name=\"sunDirection\" value=\"{direction}\"/>");
    let upright = sky("0.6.0", "sky", &stated("1 1 0"));
    let turn = "<transform name=\"toWorld\"><rotate x=\"1\" angle=\"90\"/></transform>";
    let turned = sky("0.6.0", "sky", &(stated("1 0 1") + turn));
    for towards in [Vec3::new(0.2, 0.9, 0.1), Vec3::new(-0.5, 0.4, 0.7)] {
        let towards = towards.normalize();
        let there = Vec3::new(towards.x, -towards.z, towards.y);
        let off = (upright.radiance(towards) / turned.radiance(there) - 1.0).abs().max_element();
        assert!(off < 0.01, "{towards}: {off}");
    }
    // Below the horizon there is nothing, unless it is stretched or goes on.
    let below = Vec3::new(0.5, -0.2, 0.3).normalize();
    assert_eq!(upright.radiance(below), Rgb::ZERO);
    for more in
        ["<float name=\"stretch\" value=\"2\"/>", "<boolean name=\"extend\" value=\"true\"/>"]
    {
        assert!(
            sky("0.6.0", "sky", &(stated("1 1 0") + more)).radiance(below).min_element() > 0.0,
            "{more}"
        );
    }
}

#[test]
fn what_is_no_sky_is_refused_with_its_line() {
    let number = |name: &str, value: &str| format!("<float name=\"{name}\" value=\"{value}\"/>");
    let east = "<vector name=\"sunDirection\" value=\"1 1 0\"/>";
    let cases = [
        (number("turbidity", "0.5"), "\"turbidity\" is not a number from 1 to 10"),
        (number("turbidity", "nan"), "turbidity"),
        (number("stretch", "3"), "\"stretch\" is not"),
        (number("skyScale", "-1"), "\"sky_scale\" is not"),
        (number("sunRadiusScale", "1000"), "\"sun_radius_scale\" is not"),
        ("<rgb name=\"albedo\" value=\"1.2\"/>".into(), "albedo"),
        (number("hour", "2"), "below the horizon"),
        (number("month", "13"), "\"month\" is not"),
        (number("day", "1.5"), "\"day\" is not a whole number"),
        (number("latitude", "100"), "\"latitude\" is not"),
        ("<vector name=\"sunDirection\" value=\"0 0 0\"/>".into(), "no length"),
        ("<vector name=\"sunDirection\" value=\"0 -1 0.1\"/>".into(), "below the horizon"),
        (east.to_owned() + &number("hour", "9"), "beside sun_direction"),
        ("<transform name=\"toWorld\"><scale x=\"0\"/></transform>".into(), "makes the sky flat"),
    ];
    for (inside, said) in cases {
        let text = format!("<shape type=\"cube\"/><emitter type=\"sunsky\">{inside}</emitter>");
        let error = read("0.6.0", &text).unwrap_err();
        assert!(error.contains("line 2: ") && error.contains(said), "{inside}: {error}");
    }
    let two = "<shape type=\"cube\"/><emitter type=\"sky\"/><emitter type=\"constant\"/>";
    assert!(read("0.6.0", two).unwrap_err().contains("two environments"));
}
