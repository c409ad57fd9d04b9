//! Normal maps, bump maps and holes of Mitsuba and of OBJ with MTL.

use crate::support::Folder;
use glam::{Vec2, Vec3};
use unrender_formats::{load_model, picture};
use unrender_scene::{Mesh, Rgb, RgbImage, Scene, Warnings};

/// A picture whose texels are `of` their column and row.
fn picture_of(folder: &Folder, name: &str, of: impl Fn(f32, f32) -> Rgb) {
    let image = RgbImage::from_fn(16, 16, |x, y| of(x as f32 / 16.0, y as f32 / 16.0));
    if name.ends_with("hdr") {
        picture::write_hdr(&folder.path(name), &image).unwrap();
    } else {
        picture::write_png_srgb(&folder.path(name), &image).unwrap();
    }
}

fn bitmap(file: &str, more: &str) -> String {
    let file = format!("<string name=\"filename\" value=\"{file}\"/>");
    format!("<texture type=\"bitmap\" name=\"opacity\">{file}{more}</texture>")
}

const RAW: &str = "<boolean name=\"raw\" value=\"true\"/>";
const DIFFUSE: &str = "<bsdf type=\"diffuse\"/>";

fn mitsuba(folder: &Folder, inside: &str) -> (Scene, Warnings) {
    let text = format!("<scene version=\"3.0.0\">{inside}</scene>");
    load_model(&folder.file("scene.xml", text)).unwrap_or_else(|error| panic!("{error}"))
}

/// The mesh of a shape of this kind, with `more` in it, of the BSDF `kind` with the texture `bitmap`.
fn mesh(folder: &Folder, shape: &str, more: &str, (kind, bitmap): (&str, &str)) -> Mesh {
    let bsdf = format!("<bsdf type=\"{kind}\">{bitmap}{DIFFUSE}</bsdf>");
    let (scene, warnings) =
        mitsuba(folder, &format!("<shape type=\"{shape}\">{more}{bsdf}</shape>"));
    assert_eq!(warnings.0, [""; 0]);
    scene.objects[0].mesh.clone()
}

/// The normal that the map of `mesh` has at `uv`, in the frame of the first vertex: as glTF has it.
fn mapped(mesh: &Mesh, uv: Vec2) -> Vec3 {
    let normal = mesh.detail.normals.as_ref().unwrap().at(uv);
    let (z, tangent) = (mesh.normals[0], mesh.tangents[0]);
    let x = tangent.truncate();
    let y = z.cross(x) * tangent.w;
    normal.x * x + normal.y * y + normal.z * z
}

#[track_caller]
fn assert_near(found: Vec3, wanted: [f32; 3]) {
    let wanted = Vec3::from_array(wanted).normalize();
    assert!((found - wanted).length() < 0.02, "{found} instead of {wanted}");
}

/// As an OBJ, a square of x and y whose picture is upright on it.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

/// In Mitsuba y of a normal map is the normal times the direction of growing u, whichever way v grows.
#[test]
fn normal_maps_of_mitsuba_are_in_the_shading_frame() {
    let folder = Folder::new();
    // Right, and more along y.
    picture_of(&folder, "n.hdr", |_, _| Rgb::new(0.6, 0.8, 0.9));
    let map = ("normalmap", &*bitmap("n.hdr", RAW));
    // v grows along y, downwards in the picture.
    assert_near(mapped(&mesh(&folder, "rectangle", "", map), Vec2::ZERO), [0.2, 0.6, 0.8]);
    let over = "<boolean name=\"flip_normals\" value=\"true\"/>";
    assert_near(mapped(&mesh(&folder, "rectangle", over, map), Vec2::ZERO), [0.2, -0.6, -0.8]);
    folder.file("q.obj", format!("{SQUARE}f 1/1 2/2 3/3 4/4\n"));
    let square = mesh(&folder, "obj", "<string name=\"filename\" value=\"q.obj\"/>", map);
    assert_near(mapped(&square, Vec2::ZERO), [0.2, 0.6, 0.8]);
    // A picture that is turned does not turn its normals.
    let turned = "<transform name=\"to_uv\"><rotate z=\"1\" angle=\"90\"/></transform>";
    let map = ("normalmap", &*bitmap("n.hdr", &format!("{RAW}{turned}")));
    assert_near(mapped(&mesh(&folder, "rectangle", "", map), Vec2::ZERO), [0.2, 0.6, 0.8]);
}

#[test]
fn codes_of_normals_are_no_colours() {
    let folder = Folder::new();
    picture_of(&folder, "n.png", |_, _| Rgb::new(0.5, 0.214, 1.0));
    let shape = |raw: &str| {
        let map = bitmap("n.png", raw);
        format!("<shape type=\"rectangle\"><bsdf type=\"normalmap\">{map}{DIFFUSE}</bsdf></shape>")
    };
    for (raw, count) in [(RAW, 0), ("", 1)] {
        let (scene, warnings) = mitsuba(&folder, &shape(raw));
        // The codes of 0.5 and 0.214 are 0.735 and 0.5.
        assert_near(mapped(&scene.objects[0].mesh, Vec2::ZERO), [0.47, 0.0, 1.0]);
        assert_eq!(warnings.0.iter().filter(|told| told.contains("taken as raw")).count(), count);
    }
}

#[test]
fn bump_maps_of_mitsuba_lift_by_metres() {
    let folder = Folder::new();
    // On the rectangle of two metres, it grows by 0.25 a metre along x, and by 0.125 along y.
    picture_of(&folder, "h.hdr", |x, y| Rgb::splat(0.5 * x + 0.25 * y));
    let map = ("bumpmap", &*bitmap("h.hdr", RAW));
    let square = mesh(&folder, "rectangle", "", map);
    assert_near(mapped(&square, Vec2::splat(0.5)), [-0.25, -0.125, 1.0]);
    let larger = "<transform name=\"to_world\"><scale x=\"2\" y=\"1\" z=\"1\"/></transform>";
    let square = mesh(&folder, "rectangle", larger, map);
    assert_near(mapped(&square, Vec2::splat(0.5)), [-0.125, -0.125, 1.0]);
    let scaled = bitmap("h.hdr", RAW) + "<float name=\"scale\" value=\"-2\"/>";
    let square = mesh(&folder, "rectangle", "", ("bumpmap", &scaled));
    assert_near(mapped(&square, Vec2::splat(0.5)), [0.5, 0.25, 1.0]);
    // Twice as often is twice as steep.
    let often = "<transform name=\"to_uv\"><scale x=\"2\" y=\"2\" z=\"1\"/></transform>";
    let often = bitmap("h.hdr", &format!("{RAW}{often}"));
    let square = mesh(&folder, "rectangle", "", ("bumpmap", &often));
    assert_near(mapped(&square, Vec2::splat(0.5)), [-0.5, -0.25, 1.0]);
}

#[test]
fn masks_of_mitsuba_are_holes() {
    let folder = Folder::new();
    picture_of(&folder, "m.png", |x, _| Rgb::splat(if x < 0.5 { 1.0 } else { 0.0 }));
    let cut = |bitmap: &str, inside: &str| {
        let bsdf = format!("<bsdf type=\"mask\" id=\"leaf\">{bitmap}{inside}</bsdf>");
        let wall = format!("<shape type=\"cube\">{DIFFUSE}</shape>");
        mitsuba(&folder, &format!("<shape type=\"rectangle\">{bsdf}</shape>{wall}"))
    };
    let (scene, warnings) = cut(&bitmap("m.png", ""), DIFFUSE);
    assert_eq!(warnings.0, [""; 0]);
    let mesh = &scene.objects[0].mesh;
    let holes = mesh.detail.coverage.as_ref().unwrap();
    assert!(!holes.is_hole(Vec2::new(0.25, 0.5)) && holes.is_hole(Vec2::new(0.75, 0.5)));
    assert_eq!(mesh.uvs.len(), 4);
    // Glass with holes.
    let (scene, warnings) = cut(&bitmap("m.png", ""), "<bsdf type=\"dielectric\"/>");
    assert!(scene.ungrouped[0].mesh.detail.coverage.is_some());
    assert_eq!(warnings.0.len(), 1, "{warnings:?}");
    // The mask of a texture lies as that does, or is left out.
    let to_uv = "<transform name=\"to_uv\"><scale x=\"3\" y=\"3\" z=\"1\"/></transform>";
    let painted = |to_uv: &str| {
        let texture = bitmap("m.png", to_uv).replace("opacity", "reflectance");
        format!("<bsdf type=\"diffuse\">{texture}</bsdf>")
    };
    let (scene, warnings) = cut(&bitmap("m.png", to_uv), &painted(to_uv));
    let mesh = &scene.objects[0].mesh;
    assert!(mesh.detail.coverage.is_some() && warnings.0.is_empty(), "{warnings:?}");
    assert_eq!(mesh.uvs[2], Vec2::splat(3.0));
    let (scene, warnings) = cut(&bitmap("m.png", to_uv), &painted(""));
    assert!(scene.objects[0].mesh.detail.is_none());
    assert!(
        warnings.0.len() == 1 && warnings.0[0].contains("its mask was left out"),
        "{warnings:?}"
    );
    // A veil.
    picture_of(&folder, "v.png", |x, _| Rgb::splat(x));
    let (scene, warnings) = cut(&bitmap("v.png", ""), DIFFUSE);
    assert!(scene.objects[0].mesh.detail.coverage.is_some());
    assert!(warnings.0.len() == 1 && warnings.0[0].contains("half-transparent"), "{warnings:?}");
    // Lamps have none.
    let bsdf = format!("<bsdf type=\"mask\">{}{DIFFUSE}</bsdf>", bitmap("m.png", ""));
    let lamp = format!("<shape type=\"rectangle\">{bsdf}<emitter type=\"area\"/></shape>");
    let (scene, warnings) = mitsuba(&folder, &lamp);
    assert!(scene.objects[0].mesh.detail.is_none());
    assert!(warnings.0.iter().any(|told| told.contains("lamp with holes")), "{warnings:?}");
}

#[test]
fn normals_of_a_mask_and_holes_of_a_normalmap_are_of_one_surface() {
    let folder = Folder::new();
    picture_of(&folder, "m.png", |x, _| Rgb::splat(if x < 0.5 { 1.0 } else { 0.0 }));
    picture_of(&folder, "n.hdr", |_, _| Rgb::new(0.6, 0.8, 0.9));
    let (holes, normals) = (bitmap("m.png", ""), bitmap("n.hdr", RAW));
    for (outer, inner) in
        [(("mask", &holes), ("normalmap", &normals)), (("normalmap", &normals), ("mask", &holes))]
    {
        let inside = format!("{}<bsdf type=\"{}\">{}{DIFFUSE}</bsdf>", outer.1, inner.0, inner.1);
        let shape =
            format!("<shape type=\"sphere\"><bsdf type=\"{}\">{inside}</bsdf></shape>", outer.0);
        let (scene, warnings) = mitsuba(&folder, &shape);
        let detail = &scene.objects[0].mesh.detail;
        assert!(detail.normals.is_some() && detail.coverage.is_some(), "{warnings:?}");
        assert_eq!(warnings.0, [""; 0]);
    }
}

/// The mesh of a square with this material, and the warnings.
fn obj(folder: &Folder, words: &str) -> (Mesh, Vec<String>) {
    folder.file("a.mtl", format!("newmtl m\nKd 0.5 0.5 0.5\n{words}\n"));
    let text = format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1/1 2/2 3/3 4/4\n");
    let (scene, warnings) = load_model(&folder.file("a.obj", text)).unwrap();
    (scene.objects[0].mesh.clone(), warnings.0)
}

#[test]
fn obj_has_normal_maps_under_several_names() {
    let folder = Folder::new();
    // As codes: 0.735, 0.735, 1.
    picture_of(&folder, "my n.png", |_, _| Rgb::new(0.5, 0.35, 1.0));
    let [x, y] = [0.735, 0.627].map(|code| 2.0 * code - 1.0);
    for word in ["norm", "map_Kn", "map_norm -clamp off", "norm -s 1 1 1"] {
        let (mesh, told) = obj(&folder, &format!("{word} my n.png"));
        assert_eq!(told, [""; 0], "{word}");
        assert_near(mapped(&mesh, Vec2::ZERO), [x, y, 1.0]);
    }
    // Its mean is too far from flat normals to be those, if it may be of heights.
    let (mesh, told) = obj(&folder, "bump my n.png");
    assert!(mesh.detail.is_none());
    assert!(told.len() == 1 && told[0].contains("map of heights"), "{told:?}");
    picture_of(&folder, "my n.png", |x, _| Rgb::new(if x < 0.5 { 0.5 } else { 0.04 }, 0.214, 1.0));
    for word in ["bump", "map_Bump -bm 1", "disp"] {
        let (mesh, told) = obj(&folder, &format!("{word} my n.png"));
        assert_eq!(told, [""; 0], "{word}");
        assert_near(mapped(&mesh, Vec2::new(0.25, 0.5)), [0.47, 0.0, 1.0]);
    }
    let (mesh, _) = obj(&folder, "map_Bump -bm 0.5 my n.png");
    assert_near(mapped(&mesh, Vec2::new(0.25, 0.5)), [0.235, 0.0, 1.0]);
    let (mesh, told) = obj(&folder, "norm -s 2 2 my n.png");
    assert!(mesh.detail.is_none() && told.len() == 1 && told[0].contains("options"), "{told:?}");
}

#[test]
fn obj_has_holes_by_alpha_or_else_by_luminance() {
    let folder = Folder::new();
    picture_of(&folder, "d.png", |x, _| Rgb::splat(if x < 0.5 { 1.0 } else { 0.0 }));
    let is_cut = |mesh: &Mesh| {
        let holes = mesh.detail.coverage.as_ref().unwrap();
        !holes.is_hole(Vec2::new(0.25, 0.5)) && holes.is_hole(Vec2::new(0.75, 0.5))
    };
    for word in ["map_d", "map_opacity"] {
        let (mesh, told) = obj(&folder, &format!("{word} d.png"));
        assert!(is_cut(&mesh) && told.is_empty(), "{told:?}");
    }
    let pixels = (0..16u8).flat_map(|x| [255, 0, 0, if x < 8 { 255 } else { 0 }]).collect();
    let leaf = image::RgbaImage::from_raw(16, 1, pixels).unwrap();
    leaf.save(folder.path("leaf.png")).unwrap();
    let (mesh, told) = obj(&folder, "map_Kd leaf.png\nmap_d leaf.png");
    assert!(is_cut(&mesh) && told.is_empty(), "{told:?}");
    let (mesh, told) = obj(&folder, "Ke 1 1 1\nmap_d leaf.png");
    assert!(mesh.detail.is_none() && told.len() == 1 && told[0].contains("lamp"), "{told:?}");
    picture_of(&folder, "d.png", |x, _| Rgb::splat(x));
    let (_, told) = obj(&folder, "map_d d.png");
    assert!(told.len() == 1 && told[0].contains("half-transparent"), "{told:?}");
}
