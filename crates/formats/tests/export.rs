//! What exports leave on the disk, and names in them.

use glam::Vec3;
use unrender_formats::export::{self, Shot, Target};
use unrender_scene::{Camera, Group, Material, Mesh, Object, Rgb, Scene};

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
    let shot = Shot { scene, materials: &materials, camera: &camera, size: (4, 3) };
    export::export(&shot, target).unwrap().0
}

#[test]
fn an_export_is_written_whole_or_not_at_all() {
    let root = std::env::temp_dir().join(format!("unrender-export-{}", std::process::id()));
    std::fs::create_dir_all(root.join("taken")).unwrap();
    std::fs::write(root.join("taken/note"), "mine").unwrap();
    std::fs::write(root.join("file"), "mine").unwrap();
    for target in Target::ALL {
        let files = export(&scene(&["lamp"]), target);
        for bad in ["taken", "file", "file/inside", "no/such/folder"] {
            assert!(export::write(&root.join(bad), target, &files).is_err(), "{target} {bad}");
        }
    }
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
