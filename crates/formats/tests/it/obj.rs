//! What is read from OBJ and MTL.

use crate::support::Folder;
use glam::{Vec2, Vec3};
use std::path::Path;
use unrender_formats::{Input, Limits, assign_materials, load_model, load_scene};
use unrender_scene::{Material, Mesh, Rgb, Scene};

const OBJ: &str = "mtllib room.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 2
o wall
usemtl paint
f 1/1/1 2/2/1 3/3/1 4/4/1
o lamp
usemtl glow
f 1 2 3
o ball
usemtl gloss
f 1 2 3
";
const MTL: &str = "newmtl paint
Kd 0.25 0.5 0.75
Ks 1 1 1
illum 1
newmtl glow
Kd 0
Ke 5 4 3
newmtl gloss
Kd 0.1 0.1 0.1
Ks 0.5 0.5 0.5
Ns 198
illum 2
";

#[test]
fn obj_and_mtl_become_a_scene() {
    let folder = Folder::new();
    folder.file("room.mtl", MTL);
    let path = folder.file("room.obj", OBJ);
    let (scene, warnings) = load_scene(&path).unwrap();
    assert_eq!(warnings.0, [""; 0]);
    let names: Vec<&str> = scene.objects.iter().map(|o| o.name.as_str()).collect();
    assert_eq!(names, ["wall", "lamp", "ball"]);
    let groups: Vec<&str> = scene.groups.iter().map(|g| g.name.as_str()).collect();
    assert_eq!(groups, ["paint", "glow", "gloss"]);
    assert_eq!(scene.groups[0].material, Material::diffuse(Rgb::new(0.25, 0.5, 0.75)));
    assert_eq!(scene.groups[1].emission, Rgb::new(5.0, 4.0, 3.0));
    let gloss = Material::isotropic(Rgb::splat(0.1), Rgb::splat(0.5), 0.1);
    assert_eq!(scene.groups[2].material, gloss);
    let wall = &scene.objects[0].mesh;
    assert_eq!(wall.triangles.len(), 2);
    assert_eq!(wall.normals, [Vec3::Z; 4]);
    assert_eq!(wall.uvs[0], Vec2::new(0.0, 1.0), "v counts from the top");
    assert!(scene.cameras.is_empty());

    let assigned = folder.file("assigned.glb", assign_materials(&path, &scene, &[]).unwrap());
    assert_eq!(load_scene(&assigned).unwrap().0, scene);
}

#[test]
fn faces_without_a_material_are_the_group_default() {
    let folder = Folder::new();
    folder.file("room.mtl", MTL);
    let text = OBJ.replacen("o wall", "f 1 2 3\no wall", 1);
    let (scene, warnings) = load_scene(&folder.file("room.obj", text)).unwrap();
    assert_eq!(scene.groups[0].name, "default");
    assert_eq!(scene.objects[0].name, "object 0");
    assert_eq!(warnings.0.len(), 1, "{warnings:?}");
}

/// The corners of a square, its texture coordinates, and a normal.
const SQUARE: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0.6 0.8\n";

/// The model of an OBJ, and the warnings, beside the files that a test has put into `folder`.
#[track_caller]
fn model(folder: &Folder, text: impl AsRef<[u8]>) -> (Scene, Vec<String>) {
    match load_model(&folder.file("a.obj", text)) {
        Ok((scene, warnings)) => (scene, warnings.0),
        Err(error) => panic!("{error}"),
    }
}

#[track_caller]
fn problem(text: impl AsRef<[u8]>) -> String {
    load_model(&Folder::new().file("a.obj", text)).expect_err("is read").to_string()
}

/// Asserts that exactly one of `warnings` says all of `words`.
#[track_caller]
fn tells(warnings: &[String], words: &[&str]) {
    let says = |warning: &&String| words.iter().all(|word| warning.contains(word));
    assert_eq!(warnings.iter().filter(says).count(), 1, "{words:?} in {warnings:#?}");
}

fn groups(scene: &Scene) -> Vec<&str> {
    scene.groups.iter().map(|group| group.name.as_str()).collect()
}

/// The group and the area of each object.
fn areas(scene: &Scene) -> Vec<(&str, f32)> {
    let area = |mesh: &Mesh| {
        let each = (0..mesh.triangles.len()).map(|index| mesh.corners(index));
        each.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    };
    scene.objects.iter().map(|o| (scene.groups[o.group].name.as_str(), area(&o.mesh))).collect()
}

fn wood(folder: &Folder) {
    let tex = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile/tex a.png");
    std::fs::copy(tex, folder.path("wood.png")).unwrap();
}

#[test]
fn a_face_without_texture_coordinates_leaves_the_others_theirs() {
    let folder = Folder::new();
    wood(&folder);
    folder.file("a.mtl", "newmtl wood\nmap_Kd wood.png\n");
    let whole = "f 1/1 2/2 3/3\n";
    // Faces without any, with some, with NaN at a corner, and with normals.
    for bare in ["f 1 3 4", "f 1/1 3/3 4", "f 1/1 3/3 4/5", "f 1//1 3//1 4//1"] {
        for text in [format!("{whole}{bare}\n{whole}"), format!("{bare}\n{whole}{whole}")] {
            let text = format!("mtllib a.mtl\n{SQUARE}vt nan 0\no all\nusemtl wood\n{text}");
            let (scene, warnings) = model(&folder, text);
            let mut objects: Vec<&Mesh> = scene.objects.iter().map(|o| &o.mesh).collect();
            objects.sort_by_key(|mesh| mesh.triangles.len());
            assert_eq!(objects.len(), 2, "{bare}");
            assert_eq!((objects[0].triangles.len(), objects[0].uvs.len()), (1, 0), "{bare}");
            assert_eq!(objects[1].triangles.len(), 2, "{bare}");
            let uvs = [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0)];
            assert_eq!(objects[1].uvs[..3], uvs, "{bare}");
            assert_eq!((groups(&scene), scene.objects[1].name.as_str()), (vec!["wood"], "all"));
            tells(
                &warnings,
                &["no texture coordinates at 1 of its triangles", "\"all\"", "\"wood\""],
            );
        }
    }
}

#[test]
fn a_face_without_normals_leaves_the_others_theirs() {
    let folder = Folder::new();
    let tilted = Vec3::new(0.0, 0.6, 0.8);
    let smooth = "f 1//1 2//1 3//1\n";
    // Faces without any, with two, and with one that has no length or is NaN.
    for bare in ["f 1 3 4", "f 1//1 3//-3 4", "f 1//1 3//2 4//1", "f 1//1 3//3 4//1"] {
        let text = format!("{SQUARE}vn 0 0 0\nvn -nan(ind) nan 1.#IND\n{smooth}{bare}\n{smooth}");
        let (scene, warnings) = model(&folder, text);
        let mesh = &scene.objects[0].mesh;
        let normals = mesh.triangles.iter().map(|t| t.map(|i| mesh.normals[i as usize]));
        let all: Vec<[Vec3; 3]> = normals.collect();
        assert_eq!(all, [[tilted; 3], [Vec3::Z; 3], [tilted; 3]], "{bare}");
        let told = warnings.iter().filter(|warning| warning.contains("line 13")).count();
        assert_eq!(told, usize::from(bare != "f 1 3 4"), "{warnings:?}");
    }
    let (_, warnings) = model(&folder, format!("{SQUARE}s 1\nf 1 2 3\nf 1 3 4\ns off\nf 1 2 4\n"));
    tells(&warnings, &["smoothing groups", "2 times, the first in line 11"]);
}

const TWO: &str = "usemtl red\nf 1 2 3\nusemtl green\nf 1 3 4\n";
const RED: &str = "newmtl red\nKd 0.7 0.1 0.1\n";
const GREEN: &str = "newmtl green\nKd 0.1 0.6 0.1\n";

#[test]
fn mtllib_names_several_files_or_one_with_blanks() {
    let folder = Folder::new();
    folder.file("a.mtl", RED);
    folder.file("b.mtl", GREEN);
    folder.file("my two.mtl", format!("{RED}{GREEN}"));
    for names in [
        "mtllib a.mtl b.mtl",
        "mtllib a.mtl\nmtllib b.mtl",
        "mtllib b.mtl\t a.mtl  a.mtl # both",
        "mtllib my two.mtl",
        "mtllib \"my two.mtl\"",
        "mtllib a.mtl my two.mtl",
        "mtllib .\\my two.mtl",
    ] {
        for text in [format!("{names}\n{SQUARE}{TWO}"), format!("{SQUARE}{TWO}{names}\n")] {
            let (scene, warnings) = model(&folder, &text);
            assert_eq!(groups(&scene), ["red", "green"], "{names}");
            assert_eq!(scene.groups[1].material.rho_d, Rgb::new(0.1, 0.6, 0.1), "{names}");
            assert_eq!(warnings, [""; 0], "{names}");
        }
    }
    assert!(problem("mtllib a.mtl gone.mtl\n").contains("2 files that it names are missing"));
    // The same material in several files causes no warning.
    let (_, warnings) = model(&folder, format!("mtllib a.mtl my two.mtl b.mtl\n{SQUARE}{TWO}"));
    assert_eq!(warnings, [""; 0]);
    folder.file("b.mtl", format!("{GREEN}{RED}newmtl red\nKd 0.2\n"));
    let (scene, warnings) = model(&folder, format!("mtllib a.mtl b.mtl\n{SQUARE}{TWO}"));
    assert_eq!(scene.groups[0].material.rho_d, Rgb::splat(0.2));
    tells(&warnings, &["b.mtl", "\"red\"", "several times", "line 5"]);
}

#[test]
fn text_is_read_in_every_encoding_and_with_every_end_of_line() {
    let folder = Folder::new();
    let latin = |text: &str| text.chars().map(|c| c as u8).collect::<Vec<u8>>();
    let plain = format!("mtllib a.mtl\n{SQUARE}usemtl Weiße Wand #2\nf 1 2 3 4\n");
    let mtl = "# Größe\nnewmtl Weiße Wand #2\nKd 0.5\n".to_owned();
    let marked = |text: &str| ["\u{feff}", text].concat();
    let texts = |text: &str| {
        let crlf = text.replace('\n', "\r\n");
        let cr = text.replace('\n', "\r");
        let continued = text.replace("0.5", "\\\n0.5").replace(" 3 4", " \\\r\n 3\\ \n4");
        let comment = format!("# C:\\Wände\\\n{text}");
        let mut all = vec![latin(text), latin(&comment), marked(text).into_bytes()];
        all.extend([text.to_owned(), crlf, cr, continued, comment].map(String::into_bytes));
        all.push([b"\xEF\xBB\xBF".as_slice(), &latin(text)].concat());
        all
    };
    for mtl in texts(&mtl) {
        folder.file("a.mtl", mtl);
        for obj in texts(&plain) {
            let (scene, warnings) = model(&folder, &obj);
            let shown = String::from_utf8_lossy(&obj);
            assert_eq!(areas(&scene), [("Weiße Wand #2", 1.0)], "{shown}");
            assert_eq!(scene.groups[0].material.rho_d, Rgb::splat(0.5), "{shown}");
            assert_eq!(warnings, [""; 0], "{shown}");
        }
    }
    let wide: Vec<u8> = plain.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(problem(wide).contains("is not an OBJ: it is not text"));
    folder
        .file("a.mtl", "newmtl a\n".encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>());
    let error = load_model(&folder.file("a.obj", plain)).unwrap_err().to_string();
    assert!(error.contains("\"a.mtl\", which is not text"), "{error}");
}

#[test]
fn numbers_and_indices_in_all_their_forms() {
    let folder = Folder::new();
    let text = "v -5e-1 -.5 0 1\nv +.5 -0.5 0\nv 5E-1 .5 0.\nf -3 -2 -1 4 # forward\nv -0.5 .5 0\n\
                \tvt 1\n vt 0.25 0.75 0\nvn 0 0 1\nf -4/-1/-1 -3/2/1 -2/1/1\nf 1/ 2// 3\n";
    let (scene, warnings) = model(&folder, text);
    assert_eq!(areas(&scene), [("default", 1.5), ("default", 0.5)]);
    let uvs = [Vec2::new(0.25, 0.25), Vec2::new(0.25, 0.25), Vec2::new(1.0, 1.0)];
    assert_eq!(scene.objects[1].mesh.uvs, uvs);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}

#[test]
fn groups_without_a_material_file_stay_apart() {
    let folder = Folder::new();
    folder.file("a.mtl", RED);
    // Without a file, with one that lacks a name, and with a byte order mark before its name.
    for (head, lacks) in [("", 2), ("mtllib a.mtl\n", 1), ("\u{feff}mtllib a.mtl\n", 1)] {
        for names in ["o all\n", "g one\n", ""] {
            let (scene, warnings) = model(&folder, format!("{head}{SQUARE}{names}{TWO}"));
            assert_eq!(areas(&scene), [("red", 0.5), ("green", 0.5)], "{head}{names}");
            assert_eq!(scene.groups[1].material, Material::diffuse(Rgb::splat(0.5)));
            assert_eq!(warnings.len(), 1, "{warnings:?}");
            tells(&warnings, &["no material file", "\"green\"", "rho_d = 0.5"]);
            assert_eq!(warnings[0].contains("\"red\""), lacks == 2);
        }
    }
    // A material applies until the next one, whatever objects and groups begin in between.
    let text = format!("{SQUARE}usemtl red\no a\nf 1 2 3\ng b\nf 1 3 4\nusemtl green\nf 1 2 4\n");
    let (scene, _) = model(&folder, text);
    let names: Vec<_> = scene.objects.iter().map(|o| (o.name.as_str(), o.group)).collect();
    assert_eq!(names, [("a", 0), ("b", 0), ("b", 1)]);
}

#[test]
fn where_no_material_is_named_objects_are_groups() {
    let folder = Folder::new();
    let text = format!("{SQUARE}g wall\nf 1 2 3\no box\ng\nf 1 3 4\ng wall\nf 1 2 4\n");
    let (scene, warnings) = model(&folder, text);
    assert_eq!(areas(&scene), [("wall", 1.0), ("box", 0.5)]);
    tells(&warnings, &["no face names a material", "\"wall\", \"box\""]);
    let (scene, warnings) = model(&folder, format!("{SQUARE}f 1 2 3\ng default\nf 1 2 4\n"));
    assert_eq!(groups(&scene), ["default (2)", "default"]);
    tells(&warnings, &["Some faces have no material", "\"default (2)\""]);
}

#[test]
fn points_and_lines_are_no_triangles() {
    let folder = Folder::new();
    let text =
        format!("{SQUARE}l 1 2 3\nl 1/1 2/2 3/3 4/4\np 1 2 3\np 9\nl 9 9 9\nf 1 2\nf 1 2 3\n");
    let (scene, warnings) = model(&folder, text);
    assert_eq!(areas(&scene), [("default", 0.5)]);
    tells(&warnings, &["lines (l)", "3 times, the first in line 10"]);
    tells(&warnings, &["points (p)", "2 times, the first in line 12"]);
    tells(&warnings, &["fewer than three corners", "(line 15)"]);
    assert_eq!(warnings.len(), 4);
    let error = problem(format!("{SQUARE}l 1 2 3\ncstype bspline\ncurv 0 1 1 2 3 4\nend\n"));
    for words in ["no triangles", "lines (l)", "curves and free-form surfaces", "3 times"] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn what_an_obj_says_and_is_not_read_is_told() {
    let folder = Folder::new();
    for (more, words) in [
        ("v 0 0 0 0.1 0.2 0.9\nv 0 0 0 1 1 1 1\n", &["colours of vertices", "2 times"] as &[&str]),
        ("#MRGB ff00ff00\n", &["colours of vertices", "line 10"]),
        ("v 0 0 0 0.5\n", &["fourth number of a vertex", "line 10"]),
        ("call more.obj\n", &["other files", "line 10"]),
        ("vp 0.1 0.2\n", &["free-form"]),
        ("usemap wood\n", &["usemap"]),
        ("lod 5\nbevel on\n", &["display", "2 times"]),
        ("cam 1 2 3\ncam 4\n", &["\"cam\"", "2 times, the first in line 10"]),
    ] {
        let (_, warnings) = model(&folder, format!("{SQUARE}{more}f 1 2 3\n"));
        tells(&warnings, words);
        tells(&warnings, &["a.obj: "]);
    }
    let (_, warnings) = model(&folder, format!("{SQUARE}v 1 1 1 1\ns off\nmg 0\n# v\n\nf 1 2 3\n"));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
}

#[test]
fn what_a_material_says_and_is_not_read_is_told() {
    let folder = Folder::new();
    let green = "newmtl green\nKd 0.5\n";
    for (said, words) in [
        ("d 0.1", &["transparency"] as &[&str]),
        ("Tr 0.9", &["transparency"]),
        ("d -halo 0.5", &["transparency"]),
        ("illum 7", &["illum"]),
        ("map_Ke tex.png", &["map_Ke"]),
        ("map_ks -s 2 2 tex.png", &["map_Ks"]),
        ("bump b.png", &["heights"]),
        ("map_Bump -bm 0.3 b.png", &["heights"]),
        ("map_d -s 2 2 leaf.png", &["transparency"]),
        ("norm -s 2 2 n.png", &["normals"]),
        ("refl -type sphere sky.png", &["refl"]),
        ("Pm 1", &["Pm"]),
        ("aniso 0.5", &["aniso"]),
        ("colour 3", &["\"colour\""]),
        ("Kd 0.5 0.5 0.5 1", &["third"]),
    ] {
        folder.file("a.mtl", format!("{said}\n{RED}newmtl unused\n{said}\n{green}{said}\n"));
        let (scene, warnings) = model(&folder, format!("mtllib a.mtl\n{SQUARE}{TWO}"));
        assert_eq!(scene.groups[1].material, Material::diffuse(Rgb::splat(0.5)), "{said}");
        tells(&warnings, &[&["a.mtl: \"green\": ", "(line 8)"], words].concat());
        tells(&warnings, &["before the first newmtl", "(line 1)"]);
        assert_eq!(warnings.len(), 2, "{said}: {warnings:?}");
    }
    let neutral = "Ka 1 1 1\nd 1.0\nTr 0.0\nTf 1 1 1\nNi 1.5\nillum 2\nNs 10\nmap_Bump\nPm 0\n";
    folder.file("a.mtl", format!("{RED}{neutral}{GREEN}{neutral}"));
    let (_, warnings) = model(&folder, format!("mtllib a.mtl\n{SQUARE}{TWO}"));
    assert_eq!(warnings, [""; 0]);
}

#[test]
fn colours_that_cannot_be_meant_are_told_or_refused() {
    let folder = Folder::new();
    let said = |said: &str| {
        folder.file("a.mtl", format!("newmtl red\n{said}\n"));
        let path = folder.file("a.obj", format!("mtllib a.mtl\n{SQUARE}usemtl red\nf 1 2 3\n"));
        load_model(&path).map(|(scene, warnings)| (scene.groups[0].material.rho_d, warnings.0))
    };
    let (rho_d, warnings) = said("Kd 204 51 0").unwrap();
    assert_eq!(rho_d, Rgb::new(1.0, 1.0, 0.0));
    tells(&warnings, &["\"red\"", "Kd lies outside 0 to 1"]);
    let (rho_d, warnings) = said("Ns 10").unwrap();
    assert_eq!(rho_d, Rgb::splat(0.5));
    tells(&warnings, &["\"red\" states no reflectance"]);
    assert_eq!(said("Ke 1 2 3").unwrap(), (Rgb::ZERO, vec![]));
    for (text, words) in [
        ("Kd 1 2", "\"Kd 1 2\" in line 2"),
        ("Kd 0,5 0,5 0,5", "in line 2"),
        ("Kd spectral a.rfl 1", "spectral colours are not read"),
        ("Ke xyz 0.1 0.2 0.3", "xyz colours are not read"),
        ("Kd -1 0 0", "Kd that is no colour"),
        ("Ks nan", "Ks that is no colour"),
        ("Ns shiny", "\"Ns shiny\" in line 2"),
    ] {
        let error = said(text).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("a.mtl"), "{text}: {error}");
    }
    wood(&folder);
    assert!(said("map_Kd -s 2 2 2 wood.png").unwrap_err().to_string().contains("option -s"));
    assert!(said("map_Kd -s 1 1 1 -o 0 0 0 \"wood.png\" # oak").is_ok());
    tells(&said("Kd 0 0 0\nmap_Kd wood.png").unwrap().1, &["Kd is 0"]);
}

#[test]
fn errors_name_the_line() {
    for (text, words) in [
        ("v 0 0\n", "line 1 (\"v 0 0\") has 2 numbers where 3"),
        ("\nv 0 0,5 0\n", "line 2 (\"v 0 0,5 0\") has a \"0,5\" that is no number"),
        ("v 0 0 0\nvn 1\n", "line 2"),
        ("v 0 0 0\nf 1 0 1\n", "line 2 has a face"),
        ("v 0 0 0\nf 1 -2 1\n", "out of range"),
        (
            "v 0 0 0\nf 1/1 1/1 1/1\n",
            "line 2 has a face with an index that is out of range: vt 1 of 0",
        ),
        ("v 0 0 0\nf 1//2 1//2 1//2\nvn 0 0 1\n", "vn 2 of 1"),
        ("v 0 0 0\nf 1/1/1/1 1 1\n", "line 2 has a face"),
        ("v 0 0 0\nf 1.0 1 1\n", "line 2 has a face"),
        ("v 0 0 1e39\nf 1 1 1\n", "line 2 has a face at v 1, whose position is not finite"),
    ] {
        let error = problem(text);
        assert!(error.contains("a.obj: ") && error.contains(words), "{error}");
    }
}

#[test]
fn models_of_other_scenes_need_no_material_file() {
    let folder = Folder::new();
    folder.file("m.obj", format!("mtllib gone.mtl\n{SQUARE}{TWO}f 1/1 2/2 3/3\n"));
    let name = "<string name=\"filename\" value=\"m.obj\"/>";
    let xml = format!("<scene version=\"3.0.0\"><shape type=\"obj\">{name}</shape></scene>");
    let (scene, _) = load_model(&folder.file("a.xml", xml)).unwrap();
    let mesh = &scene.objects[0].mesh;
    assert_eq!((scene.objects.len(), mesh.triangles.len()), (1, 3));
    // One triangle has texture coordinates, which the two others do not take from it.
    assert_eq!(mesh.uvs.len(), mesh.positions.len());
    let uvs = |t: &[u32; 3]| t.map(|i| mesh.uvs[i as usize]);
    let with = mesh.triangles.iter().filter(|t| uvs(t) != [Vec2::ZERO; 3]).count();
    assert_eq!(with, 1);
    let rad = "void light red 0 0 3 1 1 1\nvoid plastic green 0 0 5 .1 .6 .1 0 0\nvoid mesh m 1 m.rtm 0 0\n";
    let (scene, _) = load_model(&folder.file("a.rad", rad)).unwrap();
    let triangles: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
    assert_eq!(triangles, 3);
}

#[test]
fn what_models_of_other_scenes_do_not_say_right_is_told() {
    let folder = Folder::new();
    let read = |text: &str, scene: &str| {
        folder.file("m.obj", text);
        let shape = "<shape type=\"obj\"><string name=\"filename\" value=\"m.obj\"/></shape>";
        folder.file("a.xml", format!("<scene version=\"3.0.0\">{shape}{shape}</scene>"));
        folder.file(
            "a.rad",
            "void plastic red 0 0 5 .7 .1 .1 0 0\nvoid plastic g 0 0 5 .1 .7 .1 0 0\n\
                              void mesh m 1 m.rtm 0 0\nvoid mesh n 5 m.rtm -t 3 0 0 0 0\n",
        );
        load_model(&folder.path(scene))
    };
    let text = format!("{SQUARE}o g\nf 1 2 3\nusemtl red\nf 1 3 4\nl 1 2\nl 2 3\nwonder 1\n");
    for scene in ["a.xml", "a.rad"] {
        let (found, warnings) = read(&text, scene).unwrap();
        assert_eq!(found.objects.len(), 2, "{scene}");
        for words in
            ["m.obj: lines (l) were left out; only faces are surfaces (2 times", "\"wonder\""]
        {
            let told = warnings.0.iter().filter(|told| told.contains(words)).count();
            assert_eq!(told, 1, "{scene}: {words}: {warnings:?}");
        }
        // Names of objects are not materials.
        let groups: Vec<&str> = found.groups.iter().map(|group| group.name.as_str()).collect();
        assert_eq!(groups.contains(&"red"), scene == "a.rad", "{groups:?}");
        assert!(!groups.contains(&"g"), "{groups:?}");
    }
    // Mitsuba takes no materials from an OBJ, so there is no warning about them.
    let text = format!("{SQUARE}usemap a\nf 1 2 3\n");
    assert_eq!(read(&text, "a.xml").unwrap().1.0, [""; 0]);
    tells(&read(&text.replace("f 1", "usemtl red\nf 1"), "a.rad").unwrap().1.0, &["usemap"]);
    for (text, words) in [
        ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 4 has a face at v 1"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt inf 0\nf 1/1 2/1 3/1\n", "line 5 has a face at vt 1"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 nan 0\nf 1//1 2//1 3//1\n", "line 5 has a face at vn 1"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4 has a face with an index"),
    ] {
        let error = read(text, "a.xml").unwrap_err().to_string();
        assert!(
            error.contains("a.xml: ") && error.contains("\"m.obj\"") && error.contains(words),
            "{error}"
        );
    }
}

#[test]
fn hostile_files_end_soon() {
    let folder = Folder::new();
    folder.file("a.mtl", RED);
    let small = |text: String, memory: u64| {
        let path = folder.file("a.obj", text);
        load_model(Input::new(&path, Limits { memory, ..Limits::default() }))
            .map_or_else(|error| error.to_string(), |_| String::new())
    };
    let limit = 4 << 20;
    let names =
        |count: usize| (0..count).map(|k| format!("usemtl m{k}\nf 1 2 3\n")).collect::<String>();
    assert!(small(format!("{SQUARE}{}", names(5000)), limit).contains("--input-memory"));
    assert_eq!(small(format!("{SQUARE}{}", names(2000)), limit), "");
    let corners = "1 2 3 4 ".repeat(50_000);
    assert!(small(format!("{SQUARE}f {corners}\n"), limit).contains("--input-memory"));
    assert!(small("v 0 0 0\n".repeat(200_000), limit).contains("--input-memory"));
    let words: String = (0..50_000).map(|k| format!("w{k}\n")).collect();
    assert_eq!(small(format!("{SQUARE}f 1 2 3\n{words}"), limit), "");
    // The same file named over and over, as some programs write it, and many files.
    let over = "mtllib a.mtl\nusemtl red\nf 1 2 3\n".repeat(20_000);
    assert_eq!(small(format!("{SQUARE}{over}"), 16 << 20), "");
    let many = format!("mtllib {}\n", "a.mtl ".repeat(2000));
    assert!(small(many, limit).contains("more than 1000 material files"));
    folder.file("a.mtl", "newmtl a\nx\n".repeat(20_000));
    assert!(small("mtllib a.mtl\n".into(), limit).contains("--input-memory"));
    let words: String = (0..20_000).map(|k| format!("x{k} 1\n")).collect();
    folder.file("a.mtl", format!("newmtl red\n{words}"));
    assert_eq!(small(format!("mtllib a.mtl\n{SQUARE}usemtl red\nf 1 2 3\n"), 64 << 20), "");
}
