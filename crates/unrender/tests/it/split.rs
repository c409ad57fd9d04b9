//! Groups that contain two materials: a recovery names them, and `unrender split` writes a scene in
//! which they are split, from which both are recovered.

use crate::kit::folder::{Folder, is_refused, succeeds};
use crate::kit::meshes::quad;
use glam::Vec3;
use unrender::formats::picture::{self, Depth};
use unrender::formats::{gltf, load_model, materials};
use unrender::render::{Settings, Tracer};
use unrender::scene::color::srgb_from_linear;
use unrender::scene::{Camera, Group, Light, LightKind, Material, Object, Rgb, Scene};

const SIZE: (usize, usize) = (80, 60);
const FLOOR: Rgb = Rgb::new(0.5, 0.4, 0.3);
const LIGHT: Rgb = Rgb::new(0.6, 0.55, 0.5);
const DARK: Rgb = Rgb::new(0.35, 0.3, 0.3);

/// A floor and three panels of a wall; the middle one is darker, and in its own group if `apart`.
/// Two objects have one name.
fn room(apart: bool) -> Scene {
    let mut scene = Scene::default();
    let group = |name: &str, rho_d| Group {
        name: name.into(),
        material: Material::diffuse(rho_d),
        emission: Rgb::ZERO,
    };
    scene.groups = vec![group("floor", FLOOR), group("wall", LIGHT)];
    if apart {
        scene.groups.push(group("dark", DARK));
    }
    let low = Vec3::new(-1.5, 0.0, -1.5);
    let floor = quad(low + 3.0 * Vec3::Z, 3.0 * Vec3::X, -3.0 * Vec3::Z);
    scene.objects.push(Object { name: "floor".into(), group: 0, mesh: floor });
    for (n, name) in ["panel", "panel", "door"].into_iter().enumerate() {
        let mesh = quad(low + n as f32 * Vec3::X, Vec3::X, 2.0 * Vec3::Y);
        let group = if apart && n == 1 { 2 } else { 1 };
        scene.objects.push(Object { name: name.into(), group, mesh });
    }
    let kind = LightKind::Point { position: Vec3::new(0.2, 1.6, 1.0), intensity: Rgb::splat(5.0) };
    scene.lights.push(Light { name: "bulb".into(), kind });
    let (eye, target) = (Vec3::new(0.1, 1.2, 3.2), Vec3::new(0.0, 0.8, -0.5));
    scene.cameras.push(Camera::look_at("photo", eye, target, Vec3::Y, 0.8));
    scene
}

fn project(folder: &Folder, scene: &str) {
    let text = format!(
        "scene = \"{scene}\"\nphoto = \"photo.png\"\nresponse = \"srgb\"\nexposure = 1\n\
         [recover]\nmax_rung = \"diffuse\"\n"
    );
    folder.write("project.toml", &text);
}

#[test]
fn two_materials_in_one_group_are_named_and_written_apart() {
    let folder = Folder::new();
    let mut truth = room(true);
    truth.validate().unwrap();
    let settings = Settings { spp: 256, seed: 5, ..Settings::default() };
    let tracer = Tracer::new(&truth);
    let photo = tracer.render(&truth.materials(), &truth.cameras[0], SIZE, &settings, &|_| ()).mean;
    let codes = photo.map(|rgb| rgb.map(srgb_from_linear));
    picture::write_png_codes(&folder.path("photo.png"), &codes, Depth::Sixteen).unwrap();
    folder.write("scene.glb", &gltf::to_glb(&room(false)).unwrap());
    project(&folder, "scene.glb");
    let recover = ["recover", "project.toml", "--no-refine", "--spp", "16", "--out", "out"];
    let told = succeeds(&folder.run(&recover));
    let line = "wall: one material does not explain all its objects: ";
    let told = told.lines().find(|told| told.starts_with(line)).expect(&told).to_owned();
    assert!(told.contains("panel, door | panel (2)"), "{told}");
    let page = folder.text("out/report.html");
    assert!(page.contains("to have several materials"));

    let refuses = |arguments: &[&str], problem: &str| {
        is_refused(&folder.run(arguments), problem);
    };
    refuses(&["split", "out", "--out", "apart.obj"], "end --out in .glb");
    refuses(&["split", "out", "--group", "roof", "--out", "a.glb"], "no group \"roof\"");
    refuses(&["split", "out", "--group", "floor", "--out", "a.glb"], "all objects of \"floor\"");
    refuses(&["split", "none", "--out", "a.glb"], "name a folder that recover wrote");
    refuses(&["split", "out", "--out", "scene.glb"], "scene.glb");
    let told = succeeds(&folder.run(&["split", "out", "--out", "apart.glb"]));
    assert_eq!(told, "wall: \"wall\" of panel, door, \"wall 2\" of panel (2)\n");
    let (apart, _) = load_model(&folder.path("apart.glb")).unwrap();
    let groups: Vec<&str> =
        apart.objects.iter().map(|o| apart.groups[o.group].name.as_str()).collect();
    assert_eq!(groups, ["floor", "wall", "wall 2", "wall"]);
    assert_eq!((apart.lights.len(), apart.cameras.len()), (1, 1));

    project(&folder, "apart.glb");
    let told = succeeds(&folder.run(&recover));
    assert!(!told.contains("does not explain all"), "{told}");
    let found = materials::read(&folder.path("out/materials.json")).unwrap();
    for (name, truth) in [("floor", FLOOR), ("wall", LIGHT), ("wall 2", DARK)] {
        let rho_d = Rgb::from_array(found.groups[name].rho_d.unwrap());
        assert!((rho_d - truth).abs().max_element() < 0.01, "{name}: {rho_d}");
    }
    refuses(&["split", "out", "--out", "again.glb"], "explains all objects of every group");
}
