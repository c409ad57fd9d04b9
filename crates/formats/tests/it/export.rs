//! What exports leave on the disk, and names in them.

use glam::{Vec2, Vec3};
use std::sync::Arc;
use unrender_formats::LightUnits;
use unrender_formats::export::{self, SceneView, Target};
use unrender_scene::{Camera, Group, Image, Material, Mesh, Object, Rgb, Scene, Texture, Wrap};

fn scene(names: &[&str]) -> Scene {
    let mut scene = Scene::default();
    for (group, name) in names.iter().enumerate() {
        let up = Vec3::Y * group as f32;
        let mesh = Mesh::flat(&[up, up + Vec3::X, up + Vec3::Z], &[], &[[0, 1, 2]]);
        let material = Material::diffuse(Rgb::splat(0.5));
        let emission = if group == 0 { Rgb::ONE } else { Rgb::ZERO };
        scene.groups.push(Group { name: (*name).into(), material, emission });
        scene.objects.push(Object { name: (*name).into(), group, mesh });
    }
    scene
}

fn export(scene: &Scene, target: Target) -> export::Files {
    let camera = Camera::look_at("c", Vec3::ONE, Vec3::ZERO, Vec3::Y, 1.0);
    let materials = scene.materials();
    let shot = SceneView {
        scene,
        materials: &materials,
        camera: &camera,
        size: (4, 3),
        light_units: LightUnits::Radiometric,
    };
    export::export(&shot, target, target.usual_name().as_ref()).unwrap().0
}

#[test]
fn an_export_is_written_whole_or_not_at_all() {
    let root = std::env::temp_dir().join(format!("unrender-export-{}", std::process::id()));
    std::fs::create_dir_all(root.join("taken")).unwrap();
    std::fs::write(root.join("taken/note"), "mine").unwrap();
    std::fs::write(root.join("file"), "mine").unwrap();
    for target in Target::ALL {
        let files = export(&scene(&["lamp"]), target);
        let inside = &format!("file/{}", target.usual_name());
        for bad in ["taken", "no/such/folder", inside] {
            assert!(export::write(&root.join(bad), target, &files).is_err(), "{target} {bad}");
        }
    }
    assert!(export::check_path(&root.join("scene.png"), Target::Gltf).is_err());
    assert!(export::check_path(&root.join("file"), Target::Radiance).is_err());
    let files = export(&scene(&["lamp"]), Target::Radiance);
    // The last file cannot be written: its folder is a file.
    let mut broken = files.clone();
    broken.push(("scene.rad/inside".into(), Vec::new()));
    assert!(export::write(&root.join("broken"), Target::Radiance, &broken).is_err());
    let mut left: Vec<_> =
        std::fs::read_dir(&root).unwrap().map(|e| e.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["file", "taken"], "nothing else is left behind");
    export::write(&root.join("good"), Target::Radiance, &files).unwrap();
    for (name, bytes) in &files {
        assert_eq!(&std::fs::read(root.join("good").join(name)).unwrap(), bytes, "{name}");
    }
    std::fs::remove_dir_all(root).unwrap();
}

/// The names of the groups as `files` have them.
fn kept(target: Target, files: &export::Files) -> Vec<String> {
    let text = |name: &str| {
        let bytes = &files.iter().find(|file| file.0 == name).unwrap().1;
        String::from_utf8(bytes.clone()).unwrap()
    };
    // The text between `mark` and the end of its line, a JSON string.
    let after = |text: &str, mark: &str| -> Vec<String> {
        let lines = text.lines().filter_map(|line| line.split_once(mark));
        lines.map(|(_, rest)| serde_json::from_str(rest).unwrap()).collect()
    };
    match target {
        Target::Blender => {
            let json: serde_json::Value = serde_json::from_str(&text("scene.json")).unwrap();
            let groups = json["groups"].as_array().unwrap().iter();
            groups.map(|group| group["name"].as_str().unwrap().to_owned()).collect()
        }
        Target::Materialx => {
            let plain = |doc: &str| {
                let doc = doc.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
                serde_json::from_str(&doc.replace("&amp;", "&")).unwrap()
            };
            let text = text("materials.mtlx");
            let surfaces = text.lines().filter(|line| line.contains("<standard_surface"));
            surfaces
                .map(|l| plain(l.split_once("doc=\"").unwrap().1.trim_end_matches("\">")))
                .collect()
        }
        Target::Pbrt => after(&text("scene.pbrt"), "# group "),
        Target::Usd => {
            let text = String::from_utf8(files[0].1.clone()).unwrap();
            let materials = text.split("def Material ").skip(1);
            materials.flat_map(|m| after(m, "displayName = ").into_iter().take(1)).collect()
        }
        _ => {
            let root = std::env::temp_dir().join(format!("unrender-names-{}", std::process::id()));
            export::write(&root.with_extension("glb"), target, files).unwrap();
            let main = match target {
                Target::Gltf => root.with_extension("glb"),
                Target::Mitsuba => root.with_extension("glb").join("scene.xml"),
                _ => root.with_extension("glb").join("scene.rad"),
            };
            let (scene, _) = unrender_formats::load_scene(&main).unwrap();
            let whole = root.with_extension("glb");
            let _ = std::fs::remove_dir_all(&whole).or_else(|_| std::fs::remove_file(&whole));
            scene.groups.into_iter().map(|group| group.name).collect()
        }
    }
}

#[test]
fn names_survive_in_every_format() {
    let names = ["a lamp", "Wand \"ü\" 门", "wand \"ü\" 门", "<&> -- 'x' \\\\", "two\nlines"];
    let scene = scene(&names);
    for target in Target::ALL {
        let files = export(&scene, target);
        let mut paths: Vec<String> = files.iter().map(|f| f.0.to_ascii_lowercase()).collect();
        paths.sort();
        paths.dedup();
        assert_eq!(paths.len(), files.len(), "{target}: every file has a name of its own");
        assert!(paths.iter().all(|path| path.is_ascii() && !path.contains(' ')), "{paths:?}");
        assert_eq!(kept(target, &files), names.map(str::to_owned), "{target}");
    }
}

#[test]
fn a_texture_reaches_every_format() {
    let mut scene = scene(&["lamp", "wall"]);
    let image = Image::from_fn(4, 3, |x, y| Rgb::new(0.1 * x as f32, 0.2 * y as f32, 0.5));
    let (wrap_u, wrap_v) = (Wrap::Repeat, Wrap::MirroredRepeat);
    scene.groups[1].material.texture = Some(Arc::new(Texture { image, wrap_u, wrap_v }));
    scene.objects[1].mesh.uvs = vec![Vec2::ZERO, Vec2::X, Vec2::Y];
    for target in Target::ALL {
        let files = export(&scene, target);
        let is_picture = |name: &str| name.ends_with(".exr") || name.ends_with(".hdr");
        let has_picture = match target {
            // The PNG inside.
            Target::Gltf => files[0].1.windows(8).any(|w| w == b"\x89PNG\r\n\x1a\n"),
            _ => files.iter().any(|(name, bytes)| is_picture(name) && bytes.len() > 50),
        };
        assert!(has_picture, "{target}");
    }
}

/// The first v in the PLY files of an export.
fn first_v(files: &[(String, Vec<u8>)]) -> f32 {
    let has_uvs = |bytes: &[u8]| bytes.windows(7).any(|w| w == b"float u");
    let (_, bytes) =
        files.iter().find(|(name, bytes)| name.ends_with(".ply") && has_uvs(bytes)).unwrap();
    let start = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    // Position, normal, u, v.
    let place = start + 7 * 4;
    f32::from_le_bytes(bytes[place..place + 4].try_into().unwrap())
}

#[test]
fn textures_stand_upright_in_other_programs() {
    let mut scene = scene(&["lamp", "wall"]);
    let image = Image::from_fn(1, 2, |_, y| Rgb::new(1.0 - y as f32, 0.0, y as f32));
    let (wrap_u, wrap_v) = (Wrap::Repeat, Wrap::Repeat);
    scene.groups[1].material.texture = Some(Arc::new(Texture { image, wrap_u, wrap_v }));
    scene.objects[1].mesh.uvs = vec![Vec2::ZERO, Vec2::X, Vec2::Y];
    // v = 0 is the top of the picture here and in Mitsuba, and the bottom in PBRT and Blender.
    assert_eq!(first_v(&export(&scene, Target::Mitsuba)), 0.0);
    assert_eq!(first_v(&export(&scene, Target::Pbrt)), 1.0);
}
