//! Small scenes in the formats of Mitsuba and of Radiance, which use every element that is read: each group is as
//! bright in the other program's own picture as in ours.
//!
//! The comments of a scene state which warnings are expected (`told: WORDS`), and which groups are therefore
//! exempt from the limit (`approximated: GROUP`).

use crate::kit::folder::Folder;
use crate::kit::programs::{Program, Row, compare, need, our_picture};
use std::path::{Path, PathBuf};
use unrender::formats::export::Target;
use unrender::formats::{load_scene, picture};
use unrender::scene::{Image, Rgb};

const SIZE: (usize, usize) = (96, 72);
/// The largest allowed error of a group's mean in Mitsuba's scenes: a tent whose normals are smoothed over its edges
/// is off by 2.2 %, a ball under all emitters by 1.3 %, all else by less than 1 %; and in Radiance's, where the noise
/// of both pictures is up to 1.4 %.
const LIMITS: [f32; 2] = [0.03, 0.02];
/// The pixels that a group must have.
const LEAST: usize = 40;

/// The scene `name` of a program, copied as `scene` into its own folder, with all files that it may
/// name.
fn copied(program: &str, name: &str) -> (Folder, PathBuf) {
    let folder = Folder::new();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/external/scenes");
    for from in [from.join("mitsuba"), from.join(program)] {
        for entry in std::fs::read_dir(&from).unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, folder.path(path.file_name().unwrap())).unwrap();
        }
    }
    let from = folder.path(name);
    let path = folder.path("scene").with_extension(from.extension().unwrap());
    std::fs::copy(from, &path).unwrap();
    // Not symmetric under any reflection.
    let tiles = Image::from_fn(16, 16, |x, y| {
        let red = if (x / 4 + y / 4) % 2 == 0 { 0.8 } else { 0.1 };
        Rgb::new(red, 0.1 + 0.05 * x as f32, 0.1 + 0.05 * y as f32)
    });
    let sky = Image::from_fn(32, 16, |x, y| {
        let sun = if (3..5).contains(&y) && (20..22).contains(&x) { 20.0 } else { 0.0 };
        Rgb::new(0.2 + x as f32 / 40.0, 0.3, 0.9 - y as f32 / 30.0) + sun
    });
    picture::write(&folder.path("tiles.png"), &tiles).unwrap();
    picture::write(&folder.path("tiles.hdr"), &tiles).unwrap();
    picture::write(&folder.path("sky.exr"), &sky).unwrap();
    (folder, path)
}

/// The words after `key` in the comments of `text`.
fn said<'a>(text: &'a str, key: &str) -> Vec<&'a str> {
    let behind = |line: &'a str| line.split_once(key).map(|(_, words)| words);
    text.lines().filter_map(behind).map(|words| words.trim_end_matches("-->").trim()).collect()
}

fn is_as_bright(program: &Program, (from, name): (&str, &str), (spp, limit): (u32, f32)) {
    let (folder, path) = copied(from, name);
    let text = std::fs::read_to_string(&path).unwrap();
    let (scene, warnings) = load_scene(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
    let told = said(&text, "told: ");
    for words in &told {
        assert!(warnings.0.iter().any(|w| w.contains(words)), "{name}, {words}: {warnings:?}");
    }
    assert_eq!(warnings.0.len(), told.len(), "{name}: {warnings:?}");
    let camera = &scene.cameras[0];
    folder.write("render.sh", RENDER);
    let theirs = program.picture(folder.root(), SIZE, spp).unwrap();
    let ours = our_picture(&scene, camera, SIZE, spp);
    let rows = compare(&scene, camera, &ours, &theirs, LEAST);
    let approximated = said(&text, "approximated: ");
    for row in &rows {
        let (group, off) = (&scene.groups[row.group].name, row.difference());
        println!(
            "{name}, {group}: {} pixels, {} for {}, {:.2} %",
            row.pixels,
            row.ours,
            row.theirs,
            100.0 * off
        );
    }
    for (index, group) in scene.groups.iter().enumerate() {
        let is_used = scene.objects.iter().any(|object| object.group == index);
        let is_held = is_used && !approximated.contains(&group.name.as_str());
        let row = rows.iter().find(|row| row.group == index);
        let off = row.map(Row::difference);
        assert!(
            !is_held || group.is_emitter() || off.is_some(),
            "{name}: {} is hardly seen",
            group.name
        );
        assert!(!is_held || off.is_none_or(|off| off < limit), "{name}: {} is off", group.name);
    }
}

#[test]
#[ignore = "slow: needs Mitsuba 3, which .ci/programs installs"]
fn every_element_of_mitsuba_is_as_bright_as_mitsuba_has_it() {
    let Some(program) = need(Program::installed(Target::Mitsuba)) else { return };
    for name in ["shapes", "emitters", "reflectances", "textures", "names"] {
        is_as_bright(&program, ("mitsuba", &format!("{name}.xml")), (1024, LIMITS[0]));
    }
}

/// How Radiance makes its picture: 16 finer pixels for each, light reflected up to 24 times, nothing kept from one
/// pixel for the next, all lamps in small pieces.
const RENDER: &str = "set -e
cd \"$(dirname \"$0\")\"
export RAYPATH=.:$RAYPATH
picture=$1
shift
[ -e plate.rtm ] || obj2mesh plate.obj plate.rtm
oconv scene.rad > scene.oct
rpict -vf view.vf -x 384 -y 288 -pa 0 -ps 1 -pj 1 -ab 24 -aa 0 -as 0 -ss 2 -st 0 -lr -30 -lw 0.02 -dj 1 \
    -ds 0.03 -dt 0 -dc 1 -dr 2 -u+ -bv+ \"$@\" scene.oct > fine.hdr
pfilt -1 -e 1 -b -x /4 -y /4 fine.hdr > \"$picture\"
";

#[test]
#[ignore = "slow: needs Radiance, which .ci/programs installs"]
fn every_element_of_radiance_is_as_bright_as_radiance_has_it() {
    let Some(program) = need(Program::installed(Target::Radiance)) else { return };
    for name in ["surfaces", "lamps", "materials", "patterns", "sky", "commands"] {
        is_as_bright(&program, ("radiance", &format!("{name}.rad")), (512, LIMITS[1]));
    }
}
