//! Scenes of Mitsuba as others write them: files in files, references in any order, names of old versions, and
//! what is not read.

use crate::support::Folder;
use glam::Vec3;
use std::path::Path;
use unrender_formats::{load_model, load_scene};
use unrender_scene::{Group, LightKind, Rgb, Scene, Warnings};

/// A scene with `inside`, of version 3.
fn document(inside: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{inside}\n</scene>")
}

fn read(path: &Path) -> (Scene, Warnings) {
    load_model(path).unwrap_or_else(|error| panic!("{error}"))
}

fn scene(inside: &str) -> (Scene, Warnings) {
    let folder = Folder::new();
    read(&folder.file("scene.xml", document(inside)))
}

fn refusal(inside: &str) -> String {
    let folder = Folder::new();
    let path = folder.file("scene.xml", document(inside));
    load_model(&path).expect_err(inside).to_string()
}

fn group<'a>(scene: &'a Scene, name: &str) -> &'a Group {
    let found = scene.groups.iter().find(|group| group.name == name);
    found.unwrap_or_else(|| panic!("no group {name}"))
}

fn tells(warnings: &Warnings, words: &[&str]) {
    let told = |word: &&str| warnings.0.iter().any(|warning| warning.contains(*word));
    for word in words {
        assert!(told(word), "{word}: {warnings:?}");
    }
}

#[test]
fn files_in_files_are_read_with_their_own_lines() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("parts/deep")).unwrap();
    folder.file(
        "parts/materials.xml",
        document("<default name=\"grey\" value=\"0.9\"/><include filename=\"deep/red.xml\"/>\
                  <bsdf type=\"diffuse\" id=\"grey\"><rgb name=\"reflectance\" value=\"$grey\"/></bsdf>"),
    );
    folder.file(
        "parts/deep/red.xml",
        "<bsdf version=\"2.0.0\" type=\"diffuse\" id=\"red\">\n\
         <rgb name=\"reflectance\" value=\"0.7 0.1 0.1\"/>\n<float name=\"wet\" value=\"1\"/></bsdf>",
    );
    folder.file("parts/quad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let inside = "<path value=\"parts\"/><default name=\"grey\" value=\"0.3\"/>
        <shape type=\"obj\"><string name=\"filename\" value=\"quad.obj\"/><ref id=\"red\"/></shape>
        <shape type=\"obj\"><string name=\"filename\" value=\"quad.obj\"/><ref id=\"grey\"/></shape>
        <include filename=\"materials.xml\"/>";
    let (scene, warnings) = read(&folder.file("scene.xml", document(inside)));
    assert_eq!(group(&scene, "red").material.rho_d, Rgb::new(0.7, 0.1, 0.1));
    // The first <default> counts, so that a scene can set parameters of its files.
    assert_eq!(group(&scene, "grey").material.rho_d, Rgb::splat(0.3));
    tells(&warnings, &["line 3 of \"deep/red.xml\": \"wet\" of the bsdf \"diffuse\""]);
}

#[test]
fn files_that_include_themselves_are_refused() {
    let folder = Folder::new();
    folder.file("a.xml", document("<include filename=\"b.xml\"/>"));
    folder.file("b.xml", document("<include filename=\"a.xml\"/>"));
    let told = load_model(&folder.path("a.xml")).unwrap_err().to_string();
    assert!(told.contains("line 2 of \"b.xml\"") && told.contains("includes itself"), "{told}");
    for i in 0..20 {
        let next = format!("<include filename=\"{}.xml\"/>", i + 1);
        folder.file(&format!("{i}.xml"), document(&next));
    }
    let told = load_model(&folder.path("0.xml")).unwrap_err().to_string();
    assert!(told.contains("15 deep in one another"), "{told}");
    let twice = "<include filename=\"leaf.xml\"/>".repeat(1001);
    folder.file("leaf.xml", document(""));
    let told = load_model(&folder.file("many.xml", document(&twice))).unwrap_err().to_string();
    assert!(told.contains("1000 files"), "{told}");
    let told = refusal("<include filename=\"none.xml\"/>");
    assert!(told.contains("line 2: ") && told.contains("none.xml"), "{told}");
}

#[test]
fn references_may_stand_before_what_they_name_and_within_other_plugins() {
    let folder = Folder::new();
    std::fs::copy(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile/tex a.png"),
        folder.path("wood.png"),
    )
    .unwrap();
    let inside = "<shape type=\"cube\" id=\"a\"><ref id=\"both\"/></shape>
        <shape type=\"cube\" id=\"b\"><ref id=\"mix\"/></shape>
        <shape type=\"cube\" id=\"c\"><ref name=\"bsdf\" id=\"other\"/><ref id=\"light\"/></shape>
        <shape type=\"cube\" id=\"d\"><ref id=\"textured\"/></shape>
        <shape type=\"cube\" id=\"e\"><bsdf type=\"bumpmap\"><ref name=\"map\" id=\"wood\"/><ref id=\"red\"/></bsdf></shape>
        <bsdf type=\"twosided\" id=\"both\"><ref id=\"red\"/></bsdf>
        <bsdf type=\"blendbsdf\" id=\"mix\"><float name=\"weight\" value=\"0.25\"/><ref id=\"red\"/><ref id=\"blue\"/></bsdf>
        <bsdf type=\"diffuse\" id=\"red\"><rgb name=\"reflectance\" value=\"0.8 0 0\"/></bsdf>
        <alias id=\"red\" as=\"other\"/>
        <bsdf type=\"diffuse\" id=\"blue\"><rgb name=\"reflectance\" value=\"0 0 0.4\"/></bsdf>
        <bsdf type=\"diffuse\" id=\"textured\"><ref name=\"reflectance\" id=\"wood\"/></bsdf>
        <texture type=\"bitmap\" id=\"wood\"><string name=\"filename\" value=\"wood.png\"/></texture>
        <emitter type=\"area\" id=\"light\"><rgb name=\"radiance\" value=\"3\"/></emitter>";
    let (scene, warnings) = read(&folder.file("scene.xml", document(inside)));
    assert_eq!(group(&scene, "both").material.rho_d, Rgb::new(0.8, 0.0, 0.0));
    let mixed = group(&scene, "mix").material.rho_d;
    assert!((mixed - Rgb::new(0.6, 0.0, 0.1)).length() < 1e-6, "{mixed}");
    assert_eq!(group(&scene, "red").emission, Rgb::splat(3.0));
    assert!(group(&scene, "textured").material.texture.is_some());
    // A BSDF that is only a part of others is not a group.
    assert!(scene.groups.iter().all(|group| group.name != "blue"), "{:?}", scene.groups.len());
    assert_eq!(scene.objects.len(), 5);
    let bumpy = scene.objects.iter().find(|object| object.name == "e").unwrap();
    assert!(bumpy.mesh.detail.normals.is_some());
    assert_eq!(warnings.0, [""; 0]);
}

#[test]
fn circles_of_references_and_long_chains_are_refused() {
    let circle = "<bsdf type=\"twosided\" id=\"a\"><ref id=\"b\"/></bsdf>
        <bsdf type=\"twosided\" id=\"b\"><ref id=\"a\"/></bsdf>";
    assert!(refusal(circle).contains("a circle of references"), "{}", refusal(circle));
    let chain: String = (0..500)
        .map(|i| format!("<bsdf type=\"twosided\" id=\"{i}\"><ref id=\"{}\"/></bsdf>", i + 1))
        .collect();
    let chain = chain + "<bsdf type=\"diffuse\" id=\"500\"/>";
    assert!(refusal(&chain).contains("100 deep"), "{}", refusal(&chain));
    // Two references each, fifty times: 2^50 paths, if each was followed.
    let doubled: String = (0..50)
        .map(|i| {
            let next = i + 1;
            format!(
                "<bsdf type=\"blendbsdf\" id=\"{i}\"><ref id=\"{next}\"/><ref id=\"{next}\"/></bsdf>"
            )
        })
        .collect();
    let doubled =
        doubled + "<bsdf type=\"diffuse\" id=\"50\"/><shape type=\"cube\"><ref id=\"0\"/></shape>";
    let (scene, _) = scene(&doubled);
    assert!((group(&scene, "0").material.rho_d.x - 0.5).abs() < 1e-4);
    let merges: String = (0..50)
        .map(|i| {
            let next = i + 1;
            format!(
                "<shape type=\"merge\" id=\"{i}\"><ref id=\"{next}\"/><ref id=\"{next}\"/></shape>"
            )
        })
        .collect();
    let merges = merges + "<shape type=\"cube\" id=\"50\"/>";
    assert!(refusal(&merges).contains("--input-memory"), "{}", refusal(&merges));
}

#[test]
fn parameters_that_grow_or_are_not_defined_are_refused() {
    let told = refusal("<shape type=\"sphere\"><float name=\"radius\" value=\"$size\"/></shape>");
    assert!(told.contains("line 2: $size is not defined"), "{told}");
    let mut laugh = String::from("<default name=\"a0\" value=\"0123456789\"/>");
    for i in 1..20 {
        laugh +=
            &format!("<default name=\"a{i}\" value=\"{}\"/>", format!("$a{} ", i - 1).repeat(20));
    }
    assert!(refusal(&laugh).contains("makes a text of more than"), "{}", refusal(&laugh));
    // The longer name counts, and a dollar may be escaped.
    let (scene, _) = scene(
        "<default name=\"r\" value=\"9\"/><default name=\"radius\" value=\"2\"/>
         <shape type=\"sphere\" id=\"\\$5\"><float name=\"radius\" value=\"$radius\"/></shape>",
    );
    let top = scene.objects[0].mesh.positions.iter().map(|p| p.z).fold(0.0, f32::max);
    assert_eq!((top, scene.objects[0].name.as_str()), (2.0, "$5"));
}

#[test]
fn groups_of_shapes_are_where_their_instances_are() {
    let inside = "<shape type=\"shapegroup\" id=\"pair\">
          <shape type=\"cube\"><ref id=\"red\"/></shape>
          <shape type=\"sphere\"><ref id=\"red\"/><transform name=\"to_world\"><translate z=\"3\"/></transform></shape>
        </shape>
        <shape type=\"instance\"><ref id=\"pair\"/><transform name=\"to_world\"><scale value=\"2\"/></transform></shape>
        <shape type=\"instance\"><ref id=\"pair\"/><transform name=\"to_world\"><translate x=\"50\"/></transform></shape>
        <shape type=\"merge\"><shape type=\"rectangle\"><ref id=\"red\"/></shape></shape>
        <bsdf type=\"diffuse\" id=\"red\"/>";
    let (scene, warnings) = scene(inside);
    assert_eq!(scene.objects.len(), 5);
    let most = |i: usize, axis: usize| {
        scene.objects[i].mesh.positions.iter().map(|p| p[axis]).fold(f32::MIN, f32::max)
    };
    assert_eq!((most(0, 0), most(1, 2), most(2, 0), most(3, 2)), (2.0, 8.0, 51.0, 4.0));
    let names: std::collections::BTreeSet<&str> =
        scene.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names.len(), 5, "each can be removed alone: {names:?}");
    assert!(scene.objects[2].name.contains("(instance at line "), "{names:?}");
    assert!(warnings.0.is_empty(), "{warnings:?}");
    let told = refusal("<shape type=\"instance\"><shape type=\"cube\"/></shape>");
    assert!(told.contains("no shapegroup"), "{told}");
}

#[test]
fn names_of_old_versions_are_upgraded() {
    let old = "<scene version=\"0.6.0\">
      <sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/><string name=\"fovAxis\" value=\"y\"/>
        <transform name=\"toWorld\"><lookAt origin=\"0,0,5\" target=\"0,0,0\" up=\"0,1,0\"/></transform>
        <sampler type=\"independent\"><integer name=\"sampleCount\" value=\"4\"/></sampler></sensor>
      <shape type=\"rectangle\"><transform name=\"toWorld\"><translate x=\"7\"/></transform>
        <boolean name=\"flipNormals\" value=\"true\"/>
        <bsdf type=\"diffuse\" id=\"red\"><rgb name=\"diffuseReflectance\" value=\"0.7 0.1 0.1\"/></bsdf></shape>
      <shape type=\"cube\"><bsdf type=\"plastic\" id=\"toy\"><float name=\"intIOR\" value=\"1.9\"/></bsdf></shape>
      <shape type=\"cube\"><bsdf type=\"ward\" id=\"ward\"><float name=\"alphaU\" value=\"0.2\"/>
        <rgb name=\"specularReflectance\" value=\"0.3\"/><rgb name=\"diffuseReflectance\" value=\"0.4\"/></bsdf></shape>
      <shape type=\"rectangle\" id=\"board\"><bsdf type=\"diffuse\"><texture type=\"checkerboard\" name=\"reflectance\">
        <float name=\"uscale\" value=\"4\"/><float name=\"voffset\" value=\"0.5\"/></texture></bsdf></shape>
      </scene>";
    let folder = Folder::new();
    let (scene, warnings) = read(&folder.file("old.xml", old));
    assert!((scene.cameras[0].fov_y_rad.to_degrees() - 40.0).abs() < 1e-4);
    assert!((scene.cameras[0].origin() - 5.0 * Vec3::Z).length() < 1e-6);
    let mesh = &scene.objects.iter().find(|o| scene.groups[o.group].name == "red").unwrap().mesh;
    assert!(mesh.positions.iter().all(|p| p.x > 5.0) && mesh.normals[0] == Vec3::NEG_Z);
    assert_eq!(group(&scene, "red").material.rho_d, Rgb::new(0.7, 0.1, 0.1));
    let f0 = ((1.9f32 / 1.000_277 - 1.0) / (1.9 / 1.000_277 + 1.0)).powi(2);
    assert!((group(&scene, "toy").material.rho_s.x - f0).abs() < 1e-6);
    let ward = &group(&scene, "ward").material;
    assert_eq!((ward.rho_s.x, ward.alpha_x, ward.alpha_y), (0.3, 0.2, 0.1));
    let board = scene.objects.iter().find(|o| o.name == "board").unwrap();
    let corner = board.mesh.positions.iter().position(|p| p.x > 0.0 && p.y > 0.0).unwrap();
    // Scaled after it was moved.
    assert!((board.mesh.uvs[corner] - glam::Vec2::new(4.0, 1.5)).length() < 1e-6);
    assert_eq!(warnings.0.len(), 1, "{warnings:?}");
    // In a file of version 3 the same names mean nothing, with a warning.
    let new =
        "<shape type=\"cube\"><transform name=\"toWorld\"><translate x=\"7\"/></transform></shape>";
    let (_, warnings) = self::scene(new);
    tells(&warnings, &["line 2: \"toWorld\" of the shape \"cube\" is not read"]);
    for (version, said) in
        [("", "is no version"), ("three", "is no version"), ("3.x", "is no version")]
    {
        let text = format!("<scene version=\"{version}\"/>");
        let told = load_model(&folder.file("v.xml", text)).unwrap_err().to_string();
        assert!(told.contains(said), "{told}");
    }
    let told = load_model(&folder.file("v.xml", "<scene/>")).unwrap_err().to_string();
    assert!(told.contains("line 1: <scene> has no version"), "{told}");
}

#[test]
fn what_is_not_read_of_a_plugin_is_told_by_line_and_name() {
    let inside = "<integrator type=\"path\"><integer name=\"max_depth\" value=\"3\"/></integrator>
        <sensor type=\"perspective\"><spectrum name=\"srf\" value=\"1\"/>
          <film type=\"hdrfilm\"><float name=\"exposure\" value=\"2\"/><rfilter type=\"box\"/></film></sensor>
        <sensor type=\"orthographic\" id=\"plan\"/>
        <shape type=\"sphere\"><float name=\"raduis\" value=\"2\"/>
          <medium type=\"homogeneous\" name=\"interior\"/>
          <bsdf type=\"diffuse\"><rgb name=\"color\" value=\"0.2\"/></bsdf></shape>
        <emitter type=\"point\"><float name=\"power\" value=\"2\"/></emitter>
        <rgb name=\"background\" value=\"1\"/>";
    let (scene, warnings) = scene(inside);
    assert_eq!(scene.cameras.len(), 1);
    let told = [
        "line 3: \"srf\" of the sensor \"perspective\"",
        "line 4: \"exposure\" of the film \"hdrfilm\"",
        "line 5: a sensor of type \"orthographic\"",
        "line 6: \"raduis\" of the shape \"sphere\"",
        "line 7: \"interior\" of the shape \"sphere\"",
        "line 8: \"color\" of the bsdf \"diffuse\"",
        "line 9: \"power\" of the emitter \"point\"",
        "line 10: \"background\" of the scene",
        // The camera is inside of the sphere.
        "sees some of it from behind",
    ];
    tells(&warnings, &told);
    assert_eq!(warnings.0.len(), told.len(), "{warnings:?}");
}

#[test]
fn what_cannot_be_read_is_refused_by_name_and_line() {
    let cases = [
        ("<shape type=\"bsplinecurve\"/>", "a shape of type \"bsplinecurve\" is not read"),
        (
            "<shape type=\"cube\"><bsdf type=\"hair\"/></shape>",
            "a bsdf of type \"hair\" is not read",
        ),
        ("<emitter type=\"timed_sunsky\"/>", "an emitter of type \"timed_sunsky\" is not read"),
        ("<emitter type=\"projector\"/>", "an emitter of type \"projector\" is not read"),
        ("<shape type=\"cube\"><emitter type=\"point\"/></shape>", "an emitter of type \"point\""),
        (
            "<shape type=\"cube\"><bsdf type=\"diffuse\"><texture type=\"mesh_attribute\" name=\"reflectance\"/></bsdf></shape>",
            "a texture of type \"mesh_attribute\" is not read",
        ),
        (
            "<shape type=\"cube\"><bsdf type=\"conductor\"><string name=\"material\" value=\"Unobtainium\"/></bsdf></shape>",
            "Unobtainium",
        ),
        ("<animation/>", "there is no element <animation>"),
        (
            "<shape type=\"cube\"><boolean name=\"flip_normals\" value=\"yes\"/></shape>",
            "in flip_normals, \"yes\" is neither",
        ),
        (
            "<shape type=\"cube\"><float name=\"flip_normals\" value=\"1\"/></shape>",
            "\"flip_normals\" is not a <boolean>",
        ),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"big\"/></shape>",
            "in radius, \"big\" is no",
        ),
        ("<shape type=\"cube\"><ref id=\"x\"/></shape>", "\"x\", which is not there"),
        (
            "<bsdf type=\"diffuse\" id=\"x\"/><bsdf type=\"diffuse\" id=\"x\"/>",
            "\"x\" is given twice",
        ),
        (
            "<bsdf type=\"diffuse\" id=\"x\"><rgb name=\"reflectance\" value=\"1.5\"/></bsdf><shape type=\"cube\"/>",
            "above one",
        ),
        ("<emitter type=\"constant\"/><emitter type=\"constant\"/>", "two environments"),
        ("<shape type=\"cube\" ident=\"x\"/>", "an attribute ident"),
        ("<shape/>", "<shape> has no type"),
        (
            "<shape type=\"sphere\"><float name=\"radius\" value=\"1\"/><float name=\"radius\" value=\"2\"/></shape>",
            "\"radius\" is given twice, with two values",
        ),
    ];
    for (inside, said) in cases {
        let folder = Folder::new();
        let path = folder.file("scene.xml", document(inside));
        match load_model(&path) {
            Err(error) => {
                let told = error.to_string();
                assert!(told.contains("scene.xml: line 2: ") && told.contains(said), "{told}");
            }
            // A BSDF that no shape has is left out, with a warning.
            Ok((_, warnings)) => tells(&warnings, &[said, "line 2: ", "no shape has it"]),
        }
    }
}

#[test]
fn lamps_without_a_reflectance_are_black_and_nothing_is_left_out() {
    let inside = "<shape type=\"rectangle\" id=\"lamp\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"5\"/></emitter></shape>
        <shape type=\"rectangle\" id=\"more\"><emitter type=\"area\"><rgb name=\"radiance\" value=\"5\"/></emitter></shape>
        <shape type=\"rectangle\" id=\"wall\"><boolean name=\"flip_normals\" value=\"false\"/><boolean name=\"flip_normals\" value=\"false\"/></shape>
        <shape type=\"sphere\" id=\"fog\"><bsdf type=\"null\"/></shape>
        <shape type=\"sphere\" id=\"gone\"><bsdf type=\"mask\"><float name=\"opacity\" value=\"0\"/><bsdf type=\"diffuse\"/></bsdf></shape>
        <shape type=\"sphere\" id=\"kept\"><bsdf type=\"mask\"><float name=\"opacity\" value=\"1\"/><bsdf type=\"diffuse\"/></bsdf></shape>";
    let (scene, warnings) = scene(inside);
    let lamp = group(&scene, "lamp");
    assert_eq!((lamp.material.rho_d, lamp.emission), (Rgb::ZERO, Rgb::splat(5.0)));
    assert_eq!(group(&scene, "default").material.rho_d, Rgb::splat(0.5));
    let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["lamp", "more", "wall", "kept"]);
    assert!(warnings.0.is_empty(), "{warnings:?}");
}

#[test]
fn light_from_everywhere_comes_from_where_mitsuba_has_it() {
    let folder = Folder::new();
    // Four stripes: the left edge lies along -z in Mitsuba, a quarter of the picture on along +x.
    let pixels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
    let image = unrender_scene::Image::from_fn(64, 32, |x, _| Rgb::from_array(pixels[x / 16]));
    unrender_formats::picture::write_exr(&folder.path("sky.exr"), &image).unwrap();
    let around = |transform: &str| {
        let envmap = format!(
            "<emitter type=\"envmap\"><string name=\"filename\" value=\"sky.exr\"/><float name=\"scale\" value=\"2\"/>\
             <transform name=\"to_world\">{transform}</transform></emitter><shape type=\"cube\"/>"
        );
        read(&folder.file("scene.xml", document(&envmap))).0.environment.unwrap()
    };
    let close = |found: Rgb, wanted: [f32; 3]| {
        assert!((found - 2.0 * Rgb::from_array(wanted)).length() < 0.05, "{found} {wanted:?}");
    };
    // The middle of the second of four stripes is at 3/8 of the circle, between +x and +z.
    let diagonal = Vec3::new(1.0, 0.0, 1.0).normalize();
    close(around("").radiance(diagonal), pixels[1]);
    close(
        around("<rotate y=\"1\" angle=\"90\"/>").radiance(Vec3::new(1.0, 0.0, -1.0).normalize()),
        pixels[1],
    );
    // On its side: what was between +x and +z is between +y and +z.
    let side = around("<rotate z=\"1\" angle=\"90\"/>");
    close(side.radiance(Vec3::new(0.0, 1.0, 1.0).normalize()), pixels[1]);
    // Mirrored in x.
    let mirrored = around("<scale x=\"-1\"/>");
    close(mirrored.radiance(Vec3::new(-1.0, 0.0, 1.0).normalize()), pixels[1]);
    let (scene, _) = scene(
        "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"1 2 3\"/></emitter><shape type=\"cube\"/>",
    );
    assert_eq!(scene.environment.unwrap().radiance(Vec3::Y), Rgb::new(1.0, 2.0, 3.0));
}

#[test]
fn the_rows_of_a_panorama_reach_from_pole_to_pole() {
    let folder = Folder::new();
    // The radiance is the share of the way down, with rows where Mitsuba has them.
    let image = unrender_scene::Image::from_fn(8, 5, |_, y| Rgb::splat(y as f32 / 4.0));
    unrender_formats::picture::write_exr(&folder.path("sky.exr"), &image).unwrap();
    let inside = "<emitter type=\"envmap\"><string name=\"filename\" value=\"sky.exr\"/></emitter><shape type=\"cube\"/>";
    let sky = read(&folder.file("scene.xml", document(inside))).0.environment.unwrap();
    for way in [0.1f32, 0.3, 0.5, 0.8, 0.9] {
        let polar = way * std::f32::consts::PI;
        let found = sky.radiance(Vec3::new(polar.sin(), polar.cos(), 0.0));
        assert!((found - Rgb::splat(way)).length() < 1e-3, "{found} at {way}");
    }
}

#[test]
fn lights_are_where_their_transforms_take_them() {
    let inside = "<emitter type=\"point\" id=\"p\"><transform name=\"to_world\"><translate x=\"1\" y=\"2\" z=\"3\"/></transform>
          <spectrum name=\"intensity\" value=\"10\"/></emitter>
        <emitter type=\"directional\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"90\"/></transform></emitter>
        <emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"30\"/></emitter><shape type=\"cube\"/>";
    let folder = Folder::new();
    let (scene, _) = load_scene(&folder.file("scene.xml", document(inside))).unwrap();
    let LightKind::Point { position, intensity } = scene.lights[0].kind else { panic!() };
    assert_eq!(position, Vec3::new(1.0, 2.0, 3.0));
    assert!((intensity - Rgb::new(12.048, 9.483, 9.089)).length() < 0.01, "{intensity}");
    let LightKind::Directional { direction, .. } = scene.lights[1].kind else { panic!() };
    assert!((direction - Vec3::NEG_Y).length() < 1e-6, "{direction}");
    assert!(matches!(scene.lights[2].kind, LightKind::Spot { .. }));
}

#[test]
fn what_a_camera_sees_from_behind_is_told_unless_it_is_two_sided() {
    const CAMERA: &str = "<sensor type=\"perspective\" id=\"eye\"><transform name=\"to_world\">\
        <lookat origin=\"0, 0, 5\" target=\"0, 0, 0\" up=\"0, 1, 0\"/></transform></sensor>";
    const GREY: &str = "<bsdf type=\"diffuse\" id=\"grey\"/>";
    const BOTH: &str = "<bsdf type=\"twosided\" id=\"grey\"><bsdf type=\"diffuse\"/></bsdf>";
    const WALL: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><translate z=\"1\"/></transform></shape>";
    let square = |angle: f32, bsdf: &str| {
        let turn = format!("<rotate y=\"1\" angle=\"{angle}\"/>");
        format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\">{turn}</transform>{bsdf}</shape>"
        )
    };
    let shape = |kind: &str| format!("<shape type=\"{kind}\">{GREY}</shape>");
    for (shapes, is_seen) in [
        (square(0.0, GREY), false),
        (square(180.0, GREY), true),
        (square(180.0, BOTH), false),
        (square(180.0, GREY) + WALL, false),
        // Open towards the camera.
        (shape("cylinder"), true),
        (shape("sphere"), false),
        (shape("cube"), false),
    ] {
        let (_, warnings) = scene(&format!("{CAMERA}{shapes}"));
        assert_eq!(warnings.0.len(), usize::from(is_seen), "{shapes}: {warnings:?}");
        if is_seen {
            tells(&warnings, &["group \"grey\": camera \"eye\" sees some of it from behind"]);
        }
    }
}

/// What Mitsuba's spot of intensity one sends at an angle, degrees.
fn fading(angle: f32, beam: f32, cutoff: f32) -> f32 {
    if angle <= beam { 1.0 } else { ((cutoff - angle) / (cutoff - beam)).max(0.0) }
}

#[test]
fn spots_send_what_mitsubas_send() {
    for (beam, cutoff) in
        [(15.0, 20.0), (30.0, 40.0), (10.0, 40.0), (0.0, 30.0), (40.0, 70.0), (25.0, 25.0)]
    {
        let inside = format!(
            "<emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"{cutoff}\"/>\
             <float name=\"beam_width\" value=\"{beam}\"/></emitter><shape type=\"cube\"/>"
        );
        let (scene, warnings) = scene(&inside);
        assert_eq!(warnings.0.len(), usize::from(beam < cutoff), "{warnings:?}");
        let (mut sent, mut wanted, mut off) = (0.0, 0.0, 0.0f32);
        for angle in (0..900).map(|k| 0.1 * (k as f32 + 0.5)) {
            let (sin, cos) = angle.to_radians().sin_cos();
            // From a distance of one.
            let ours = scene.lights[0].kind.illuminate(Vec3::new(sin, 0.0, cos)).2.x;
            let theirs = fading(angle, beam, cutoff);
            (sent, wanted) = (sent + sin * ours, wanted + sin * theirs);
            off = off.max((ours - theirs).abs());
        }
        assert!((sent / wanted - 1.0).abs() < 0.01, "{beam} to {cutoff}: {sent} for {wanted}");
        if beam < cutoff {
            // The warning states the true difference.
            assert!(off < 0.15, "{beam} to {cutoff}: {off}");
            let percent = (100.0 * off).ceil() as i32;
            let is_told = |percent| warnings.0[0].contains(&format!("up to {percent} %"));
            assert!((percent - 1..=percent + 1).any(is_told), "{percent}: {warnings:?}");
        }
    }
}
