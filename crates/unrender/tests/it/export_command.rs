//! Tests of `unrender export` on the command line: its message and its folder if it cannot write,
//! and scenes of Mitsuba 3 and Radiance as users write them, rendered and exported.

use crate::kit::folder::{Folder, command, stderr};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The names of all files in the folder, in order.
fn list(folder: &Folder) -> Vec<String> {
    let entries = std::fs::read_dir(folder.root()).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn unrender(words: &[&str], paths: &[(&str, &Path)]) -> Output {
    let mut command = command(words);
    for (flag, path) in paths {
        command.args([flag.as_ref(), path.as_os_str()].into_iter().filter(|word| !word.is_empty()));
    }
    command.output().unwrap()
}

fn export(scene: &Path, format: &str, out: &Path) -> Output {
    unrender(&["export", "--to", format], &[("--scene", scene), ("--out", out)])
}

const MITSUBA: &str = r#"<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="50"/>
        <transform name="to_world"><lookat origin="0, 1, 5" target="0, 1, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
    </sensor>
    <bsdf type="twosided" id="white"><bsdf type="diffuse"><rgb name="reflectance" value="0.7"/></bsdf></bsdf>
    <bsdf type="roughconductor" id="steel"><string name="material" value="none"/>
        <string name="distribution" value="ggx"/><float name="alpha" value="0.2"/></bsdf>
    <bsdf type="plastic" id="toy"><rgb name="diffuse_reflectance" value="0.1 0.2 0.5"/></bsdf>
    <shape type="rectangle"><ref id="white"/>
        <transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform></shape>
    <shape type="sphere"><point name="center" x="-0.8" y="0.6" z="0"/><float name="radius" value="0.6"/><ref id="steel"/></shape>
    <shape type="cube"><ref id="toy"/>
        <transform name="to_world"><scale value="0.4"/><translate x="0.8" y="0.4"/></transform></shape>
    <emitter type="spot"><rgb name="intensity" value="20"/>
        <transform name="to_world"><lookat origin="0, 4, 2" target="0, 0, 0" up="0, 0, 1"/></transform></emitter>
    <emitter type="constant"/>
</scene>"#;

const RADIANCE: &str = "void plastic white 0 0 5 .7 .7 .7 0 0
void metal steel 0 0 5 .8 .7 .6 .9 .2
void light bulb 0 0 3 30 30 30
white ring floor 0 0 8  0 0 0  0 0 1  0 3
steel cylinder pillar 0 0 7  0 0 0  0 0 1.5  .4
bulb sphere lamp 0 0 4  1 -1 3  .2
!genbox white box 1 1 1
void glass pane 0 0 3 .9 .9 .9
pane ring window 0 0 8  0 -1 1  0 1 0  0 .5
";

fn scenes(folder: &Folder) -> [PathBuf; 2] {
    let radiance = folder.write("by hand.rad", RADIANCE);
    folder.write("view.vf", "rvu -vtv -vp 0 -5 2 -vd 0 1 -.25 -vu 0 0 1 -vh 50 -vv 40\n");
    [folder.write("by hand.xml", MITSUBA), radiance]
}

#[test]
fn scenes_written_by_hand_are_rendered_and_exported() {
    let folder = Folder::new();
    for (scene, said) in scenes(&folder).iter().zip(["spots fade linearly", "\"pane\" is glass"]) {
        let photo = folder.path("picture.exr");
        let words = ["render", "--height", "30", "--spp", "4"];
        let rendered = unrender(&words, &[("", scene), ("--out", &photo)]);
        let told = stderr(&rendered);
        assert!(rendered.status.success() && told.contains(said), "{told}");
        let (picture, _) = unrender::formats::picture::read(&photo).unwrap();
        let bright = picture.values.pixels().iter().filter(|p| p.min_element() > 0.0).count();
        assert!(8 * bright > picture.values.pixels().len(), "{bright} pixels are lit");
        let name = scene.file_name().unwrap().to_string_lossy();
        let project = format!("scene = \"{name}\"\nphoto = \"picture.exr\"\nexposure = 1.0\n");
        let project = folder.write("project.toml", &project);
        let checked = unrender(&["check"], &[("", &project), ("--out", &folder.path("check.png"))]);
        let told = stderr(&checked);
        assert!(checked.status.success(), "{told}");
        for format in ["blender", "gltf", "materialx", "mitsuba", "pbrt", "radiance", "usd"] {
            let out =
                folder.path(format).with_extension(if format == "usd" { "usdz" } else { "glb" });
            let exported = export(scene, format, &out);
            let told = stderr(&exported);
            assert!(exported.status.success() && out.exists(), "{format}: {told}");
            let _ = std::fs::remove_dir_all(&out).or_else(|_| std::fs::remove_file(&out));
        }
    }
}

#[test]
fn what_cannot_be_written_is_told_and_leaves_nothing_behind() {
    let folder = Folder::new();
    let [scene, _] = scenes(&folder);
    folder.write("file", "mine");
    std::fs::create_dir_all(folder.path("taken.glb/inside")).unwrap();
    let before = list(&folder);
    for format in ["blender", "gltf", "materialx", "mitsuba", "pbrt", "radiance", "usd"] {
        let mut bad = vec!["missing/scene.glb", "file/scene.glb", "taken.glb"];
        // A file in place of a folder is refused, and one without the right ending; one .glb replaces another.
        bad.extend(if format == "gltf" { None } else { Some("file") });
        for name in bad {
            let output = export(&scene, format, &folder.path(name));
            let told = stderr(&output);
            assert_eq!(output.status.code(), Some(1), "{format} {name}: {told}");
            assert!(told.contains("error") && told.contains(name), "{format} {name}: {told}");
            assert!(output.stdout.is_empty(), "{format} {name}");
            assert_eq!(list(&folder), before, "{format} {name}");
            assert_eq!(folder.text("file"), "mine");
        }
    }
}

/// Runs `command` as a user whom write protection stops: as nobody, if we, the owner of `ours`, are root.
#[cfg(unix)]
fn without_roots_rights(command: &mut Command, ours: &Path) {
    use std::os::unix::{fs::MetadataExt, process::CommandExt};
    const NOBODY: u32 = 65534;
    if std::fs::metadata(ours).unwrap().uid() == 0 {
        command.uid(NOBODY).gid(NOBODY);
    }
}

#[cfg(unix)]
#[test]
fn a_folder_without_permission_stays_as_it_is() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let [scene, _] = scenes(&folder);
    let locked = folder.path("locked");
    std::fs::create_dir(&locked).unwrap();
    let permit = |path: &Path, mode| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    // Others may read the scene, and reach the locked folder.
    permit(folder.root(), 0o755);
    permit(&locked, 0o555);
    for format in ["gltf", "mitsuba"] {
        let mut command = command(&["export", "--to", format, "--scene"]);
        command.arg(&scene);
        command.arg("--out").arg(locked.join("scene.glb"));
        without_roots_rights(&mut command, &locked);
        let output = command.output().unwrap();
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.contains("scene.glb") && told.contains("ermission"), "{told}");
        assert_eq!(std::fs::read_dir(&locked).unwrap().count(), 0, "{format}");
    }
    permit(&locked, 0o755);
}
