//! Glass, normal maps and holes in written files.

use crate::support::Folder;
use glam::{Vec2, Vec3};
use serde_json::Value;
use std::sync::Arc;
use unrender_formats::{assign_materials, gltf, load_scene};
use unrender_scene::color::linear_from_srgb;
use unrender_scene::{
    Coverage, Detail, Glass, Group, Image, Light, LightKind, Mapped, Material, Mesh, NormalMap,
    Object, Rgb, Scene, Texture, Ungrouped, Wrap,
};

/// A square of a metre, its texture upright; it covers `across` pictures.
fn square(at: Vec3, across: f32) -> Mesh {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y].map(|corner| at + corner);
    let uvs = [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO].map(|uv| across * uv);
    Mesh::flat(&corners, &uvs, &[[0, 1, 2], [0, 2, 3]])
}

fn holes(width: usize, height: usize) -> Coverage {
    let image = Image::from_fn(width, height, |x, y| ((x * 7 + y * 3) % 6) as f32 / 5.0);
    let alpha = Mapped { image, wrap_u: Wrap::MirroredRepeat, wrap_v: Wrap::Repeat };
    Coverage { alpha, cutoff: 0.4 }
}

fn bumps() -> NormalMap {
    let normal = |x: usize, y: usize| Vec3::new(x as f32 - 1.5, 0.3 * y as f32 - 0.6, 2.0);
    let image = Image::from_fn(4, 5, normal);
    let normals = Mapped { image, wrap_u: Wrap::MirroredRepeat, wrap_v: Wrap::Repeat };
    NormalMap { normals, shades_itself: true }
}

/// A closed body with the corners of a tetrahedron.
fn body(at: Vec3) -> Mesh {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|corner| at + corner);
    Mesh::flat(&corners, &[], &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

/// The kinds of glass: of each a material, what is made of it, and whether that is closed.
fn glasses() -> Vec<(&'static str, Glass, bool)> {
    let tint = Rgb::new(0.9, 1.0 / 3.0, 0.123_456_79);
    let absorption = Rgb::new(0.25, 3.3, 0.0);
    vec![
        ("window", Glass { tint, ..Glass::pane(1.45) }, false),
        ("bottle", Glass { tint, absorption, ..Glass::solid(1.52) }, true),
        ("bubble", Glass::pane(1.33), true),
        ("water", Glass::solid(1.33), false),
    ]
}

/// A scene with all of it.
pub(crate) fn scene() -> Scene {
    let mut scene = Scene::default();
    let kind = LightKind::Point { position: Vec3::splat(9.0), intensity: Rgb::ONE };
    scene.lights.push(Light { name: "light".into(), kind });
    let level = |code: usize| linear_from_srgb(code as f32 / 255.0);
    let image = Image::from_fn(6, 4, |x, y| Rgb::new(level(30 * x), level(50 * y), level(99)));
    let texture = Texture { image, wrap_u: Wrap::MirroredRepeat, wrap_v: Wrap::Repeat };
    let mut textured = Material::isotropic(Rgb::splat(0.25), Rgb::splat(0.04), 0.3);
    textured.texture = Some(Arc::new(texture));
    let materials = [
        ("leaf", textured, Some(holes(6, 4)), None),
        ("mesh", Material::isotropic(Rgb::ZERO, Rgb::splat(0.8), 0.2), Some(holes(3, 5)), None),
        ("cloth", Material::diffuse(Rgb::new(0.3, 0.2, 0.1)), Some(holes(2, 2)), Some(bumps())),
        ("plaster", Material::diffuse(Rgb::splat(0.7)), None, Some(bumps())),
        ("plain", Material::diffuse(Rgb::splat(0.5)), None, None),
    ];
    for (group, (name, material, coverage, normals)) in materials.into_iter().enumerate() {
        let mut mesh = square(Vec3::Z * group as f32, 1.7);
        mesh.detail = Detail { normals: normals.map(Arc::new), coverage: coverage.map(Arc::new) };
        scene.groups.push(Group { name: name.into(), material, emission: Rgb::ZERO });
        scene.objects.push(Object { name: name.into(), group, mesh });
    }
    for (index, (material, glass, is_closed)) in glasses().into_iter().enumerate() {
        let at = Vec3::new(0.1, 0.2, -2.0 * index as f32);
        let mesh = if is_closed { body(at) } else { square(at, 1.0) };
        scene.ungrouped.push(Ungrouped { material: material.into(), mesh, glass: Some(glass) });
    }
    let mesh = body(Vec3::ONE);
    scene.ungrouped.push(Ungrouped { material: "nothing".into(), mesh, glass: None });
    scene
}

/// Places over several pictures.
pub(crate) fn places() -> impl Iterator<Item = Vec2> {
    (0..4000).map(|i| Vec2::new((i % 63) as f32 / 31.3, (i / 63) as f32 / 29.7) - 0.4)
}

fn json_of(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

#[test]
fn glass_written_as_gltf_reads_back_the_same() {
    let folder = Folder::new();
    let scene = scene();
    let bytes = gltf::to_glb(&scene).unwrap();
    let (back, warnings) = load_scene(&folder.file("a.glb", &bytes)).unwrap();
    assert_eq!(warnings.0.len(), 1, "that there is glass: {warnings:?}");
    assert_eq!(back.ungrouped.len(), 4, "what takes no part in light is not written");
    for (shape, own) in back.ungrouped.iter().zip(&scene.ungrouped) {
        assert_eq!((&shape.material, &shape.mesh), (&own.material, &own.mesh));
        let (found, wanted) = (shape.glass.unwrap(), own.glass.unwrap());
        let difference = (found.absorption - wanted.absorption).abs().max_element();
        assert!(difference <= 1e-6 * wanted.absorption.max_element(), "{}", shape.material);
        assert_eq!(Glass { absorption: wanted.absorption, ..found }, wanted);
    }
    let json = json_of(&bytes);
    let window = json["materials"].as_array().unwrap().iter().find(|m| m["name"] == "window");
    assert_eq!(window.unwrap()["pbrMetallicRoughness"]["roughnessFactor"], 0.0);
    let used = json["extensionsUsed"].to_string();
    assert!(used.contains("transmission") && used.contains("volume"), "{used}");
}

#[test]
fn normals_and_holes_written_as_gltf_read_back_the_same() {
    let folder = Folder::new();
    let scene = scene();
    let bytes = gltf::to_glb(&scene).unwrap();
    let (back, _) = load_scene(&folder.file("a.glb", &bytes)).unwrap();
    for (object, own) in back.objects.iter().zip(&scene.objects) {
        let name = &object.name;
        let (found, wanted) = (&object.mesh.detail, &own.mesh.detail);
        assert_eq!(found.normals.is_some(), wanted.normals.is_some(), "{name}");
        for (a, b) in found.normals.iter().zip(&wanted.normals) {
            let (a, b) = (a.normals.image.pixels(), b.normals.image.pixels());
            assert!(a.iter().zip(b).all(|(a, b)| (*a - b.normalize()).length() < 1.0 / 127.0));
        }
        assert_eq!(found.coverage.is_some(), wanted.coverage.is_some(), "{name}");
        for (a, b) in found.coverage.iter().zip(&wanted.coverage) {
            // The grid of fifths is one of 8 bits, too; rounding leaves doubt on the edges.
            assert!(places().all(|uv| {
                let edge = (b.alpha.sample(uv) - b.cutoff).abs();
                edge < 1e-5 || a.is_hole(uv) == b.is_hole(uv)
            }));
        }
        let material = &back.groups[object.group].material;
        let exact = &scene.groups[own.group].material;
        assert_eq!(material.texture.is_some(), exact.texture.is_some(), "{name}");
        let same = Material { texture: exact.texture.clone(), ..material.clone() };
        assert_eq!(same, *exact, "{name}");
    }
}

#[test]
fn holes_of_another_size_than_the_texture_stay_where_they_are() {
    let folder = Folder::new();
    let mut scene = scene();
    scene.objects[0].mesh.detail.coverage = Some(Arc::new(holes(9, 3)));
    let path = folder.file("a.glb", gltf::to_glb(&scene).unwrap());
    let (back, _) = load_scene(&path).unwrap();
    let found = back.objects[0].mesh.detail.coverage.clone().unwrap();
    assert_eq!((found.alpha.image.width(), found.alpha.image.height()), (9, 4));
    let wanted = holes(9, 3);
    let same = places().filter(|uv| found.is_hole(*uv) == wanted.is_hole(*uv)).count();
    assert!(same > 3600, "{same} of 4000");
}

#[test]
fn a_dressed_file_keeps_its_holes() {
    let folder = Folder::new();
    let path = folder.file("a.glb", gltf::to_glb(&scene()).unwrap());
    let (mut scene, _) = load_scene(&path).unwrap();
    let image = Image::new(1, 1, vec![Rgb::splat(0.2)]);
    let texture = Texture { image, wrap_u: Wrap::MirroredRepeat, wrap_v: Wrap::Repeat };
    // One loses its texture, another one gets one.
    scene.groups[0].material.texture = None;
    scene.groups[2].material.texture = Some(Arc::new(texture));
    let bytes = assign_materials(&path, &scene, &[]).unwrap();
    let (back, _) = load_scene(&folder.file("b.glb", bytes)).unwrap();
    assert_eq!(back.ungrouped, scene.ungrouped);
    assert_eq!(back.groups[0], scene.groups[0]);
    assert!(back.groups[2].material.texture.is_some());
    for (object, own) in back.objects.iter().zip(&scene.objects) {
        let (found, wanted) = (&object.mesh.detail, &own.mesh.detail);
        assert_eq!(found, wanted, "{}", object.name);
    }
}
