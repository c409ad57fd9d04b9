//! Glass, normal maps and holes in exports.

use crate::glass_and_detail::{places, scene};
use crate::support::Folder;
use glam::Vec3;
use serde_json::Value;
use unrender_formats::export::{self, Files, SceneView, Target};
use unrender_formats::{LightUnits, load_scene};
use unrender_scene::{Camera, Scene, Warnings};

fn export(scene: &Scene, target: Target) -> (Files, Warnings) {
    let camera = Camera::look_at("c", Vec3::splat(5.0), Vec3::ZERO, Vec3::Y, 1.0);
    let materials = scene.materials();
    let shot = SceneView {
        scene,
        materials: &materials,
        camera: &camera,
        size: (64, 48),
        light_units: LightUnits::Radiometric,
    };
    export::export(&shot, target, target.usual_name().as_ref()).unwrap()
}

fn bytes<'a>(files: &'a Files, name: &str) -> &'a [u8] {
    &files.iter().find(|file| file.0 == name).unwrap_or_else(|| panic!("no {name}")).1
}

fn text(files: &Files, name: &str) -> String {
    String::from_utf8(bytes(files, name).to_vec()).unwrap()
}

/// How many warnings speak of `what`.
fn told(warnings: &Warnings, what: &str) -> usize {
    warnings.0.iter().filter(|warning| warning.contains(what)).count()
}

#[test]
fn every_format_has_all_shapes_of_glass_by_names_of_their_own() {
    let mut scene = scene();
    // Both are called as an object is.
    for shape in &mut scene.ungrouped[..2] {
        shape.material = "plain".into();
    }
    for target in [Target::Blender, Target::Mitsuba, Target::Pbrt, Target::Radiance] {
        let (files, _) = export(&scene, target);
        let mut paths: Vec<String> = files.iter().map(|f| f.0.to_ascii_lowercase()).collect();
        paths.sort();
        paths.dedup();
        assert_eq!(paths.len(), files.len(), "{target}");
        assert!(!paths.iter().any(|path| path.contains("nothing")), "{target}");
        if target != Target::Radiance {
            let meshes = paths.iter().filter(|path| path.starts_with("mesh/")).count();
            assert_eq!(meshes, scene.objects.len() + 4, "{target}");
        }
    }
    let (files, _) = export(&scene, Target::Radiance);
    let shapes = text(&files, "scene.rad");
    assert!(["o_plain_2.0", "o_plain_3.0", "o_bubble.3"].iter().all(|id| shapes.contains(id)));
}

#[test]
fn mitsuba_has_words_for_all_but_absorption() {
    let (files, warnings) = export(&scene(), Target::Mitsuba);
    assert_eq!((warnings.0.len(), told(&warnings, "absorbs")), (1, 1), "{warnings:?}");
    let xml = text(&files, "scene.xml");
    let window =
        "<bsdf type=\"thindielectric\" id=\"m_window\"><float name=\"int_ior\" value=\"1.45\"/>";
    assert!(xml.contains(window) && xml.contains("<bsdf type=\"dielectric\" id=\"m_water\">"));
    assert!(xml.contains("name=\"specular_transmittance\" value=\"0.9 0.33333334 0.12345679\""));
    assert!(
        xml.contains(
            "<bsdf type=\"mask\" id=\"m_leaf\"><texture type=\"bitmap\" name=\"opacity\">"
        )
    );
    assert!(xml.contains("<bsdf type=\"twosided\" id=\"m_plaster\"><bsdf type=\"normalmap\">"));
    let folder = Folder::new();
    let root = folder.path("exported");
    export::write(&root, Target::Mitsuba, &files).unwrap();
    let (back, _) = load_scene(&root.join("scene.xml")).unwrap();
    let names = |scene: &Scene| -> Vec<String> {
        scene.groups.iter().map(|group| group.name.clone()).collect()
    };
    assert_eq!(names(&back), names(&scene()));
}

#[test]
fn stencils_have_the_holes_where_they_are() {
    let scene = scene();
    for target in [Target::Mitsuba, Target::Pbrt] {
        let (files, _) = export(&scene, target);
        let png = image::load_from_memory(bytes(&files, "textures/m_leaf-holes.png")).unwrap();
        let png = png.into_luma8();
        assert_eq!(png.dimensions(), (2 * 4 * 6, 4 * 4), "mirrored copies, four texels for one");
        let coverage = scene.objects[0].mesh.detail.coverage.clone().unwrap();
        let same = places().filter(|uv| {
            let x = (uv.x / 2.0).rem_euclid(1.0) * png.width() as f32;
            let y = uv.y.rem_euclid(1.0) * png.height() as f32;
            let [code] = png.get_pixel((x as u32).min(47), (y as u32).min(15)).0;
            assert!(code == 0 || code == 255);
            (code == 0) == coverage.is_hole(*uv)
        });
        let same = same.count();
        assert!(same > 3600, "{target}: {same} of 4000");
    }
}

#[test]
fn pictures_that_lie_mirrored_have_normals_of_their_own() {
    let mut scene = scene();
    for uv in &mut scene.objects[3].mesh.uvs {
        uv.x = 1.0 - uv.x;
    }
    let (files, _) = export(&scene, Target::Mitsuba);
    let xml = text(&files, "scene.xml");
    assert!(xml.contains("<ref id=\"m_plaster-mirrored\"/>"));
    assert!(!xml.contains("m_cloth-mirrored"));
    let (plain, turned) = (
        bytes(&files, "textures/m_plaster-normals.exr"),
        bytes(&files, "textures/m_plaster-mirrored-normals.exr"),
    );
    assert!(plain.len() == turned.len() && plain != turned);
    let (files, _) = export(&scene, Target::Pbrt);
    let pbrt = text(&files, "scene.pbrt");
    assert!(pbrt.contains("NamedMaterial \"m_plaster-mirrored\""));
    assert!(!export(&scene, Target::Blender).0.iter().any(|file| file.0.contains("mirrored")));
}

#[test]
fn blender_has_words_for_all() {
    let (files, warnings) = export(&scene(), Target::Blender);
    assert_eq!(warnings.0, [""; 0]);
    let json: Value = serde_json::from_str(&text(&files, "scene.json")).unwrap();
    let kinds = json["glasses"].as_array().unwrap();
    assert_eq!(kinds.len(), 4);
    assert_eq!((&kinds[0]["is_thin"], &kinds[0]["color"][0]), (&true.into(), &0.9.into()));
    assert!((kinds[1]["color"][0].as_f64().unwrap() - 0.81).abs() < 1e-6);
    assert_eq!(kinds[1]["absorption"][1], 3.3);
    assert_eq!(json["groups"][0]["holes"]["cutoff"], 0.4);
    assert!(json["groups"][3]["holes"].is_null());
    let normals = json["groups"][3]["normals"]["file"].as_str().unwrap();
    assert!(files.iter().any(|file| file.0 == normals));
}

#[test]
fn pbrt_is_told_of_holes_by_shape_and_of_normals_by_material() {
    let (files, warnings) = export(&scene(), Target::Pbrt);
    assert_eq!((told(&warnings, "tint"), told(&warnings, "absorbs")), (1, 1), "{warnings:?}");
    let pbrt = text(&files, "scene.pbrt");
    assert!(pbrt.contains("\"string type\" \"thindielectric\" \"float eta\" 1.45\n"));
    assert_eq!(pbrt.matches("\"texture alpha\"").count(), 3);
    assert_eq!(pbrt.matches("\"string normalmap\"").count(), 2);
    assert_eq!(pbrt.matches("\"string filter\" \"point\"").count(), 3);
}

#[test]
fn radiance_mixes_holes_with_nothing() {
    let (files, warnings) = export(&scene(), Target::Radiance);
    assert_eq!((told(&warnings, "tint"), told(&warnings, "normal maps")), (1, 1), "{warnings:?}");
    let rad = text(&files, "materials.rad");
    assert!(
        rad.contains("void mixpict m_leaf\n7 m_leaf.there void grey ./textures/m_leaf-holes.hdr")
    );
    assert!(rad.contains("void glass m_window\n0\n0\n4 ") && rad.contains(" 1.45\n"));
    assert!(rad.contains("void dielectric m_water\n0\n0\n5 1 1 1 1.33 0\n"));
    assert!(text(&files, "render.sh").contains("o_leaf.obj"), "holes need texture coordinates");
}

#[test]
fn materialx_has_surfaces_of_glass() {
    let (files, warnings) = export(&scene(), Target::Materialx);
    assert_eq!(told(&warnings, "tint"), 1, "{warnings:?}");
    let xml = text(&files, "materials.mtlx");
    assert_eq!(xml.matches("name=\"transmission\" type=\"float\" value=\"1\"").count(), 4);
    assert_eq!(xml.matches("name=\"thin_walled\" type=\"boolean\" value=\"true\"").count(), 2);
    assert_eq!(xml.matches("<normalmap ").count(), 2);
    assert_eq!(xml.matches("<input name=\"opacity\"").count(), 3);
    assert!(xml.contains("material=\"m_window\" geom=\"/o_window\""));
}

#[test]
fn objects_of_a_group_that_differ_are_told_of() {
    let mut scene = scene();
    let mut other = scene.objects[0].clone();
    other.mesh.detail.coverage = None;
    scene.objects.push(other);
    let (_, warnings) = export(&scene, Target::Gltf);
    assert_eq!(told(&warnings, "\"leaf\""), 1, "{warnings:?}");
    scene.objects.last_mut().unwrap().mesh.uvs.clear();
    let (_, warnings) = export(&scene, Target::Gltf);
    assert_eq!(told(&warnings, "without texture coordinates"), 1, "{warnings:?}");
}
