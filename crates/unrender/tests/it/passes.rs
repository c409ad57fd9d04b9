//! Passes of the command for compositing programs: the picture has the bits of `--layers`, its parts add up to it, the same
//! bytes come from any number of threads, and colour spaces and exposures are what they say.

use crate::kit::channels::Channels;
use crate::kit::floor_and_lamp;
use crate::kit::folder::{Folder, is_refused, stderr, succeeds};
use crate::relight::{ROUNDING, read, unrender};
use crate::restage::{INSERT, Stage};
use glam::Vec3;
use unrender::formats::gltf;
use unrender::formats::picture::{self, ColourSpace};
use unrender::scene::{Rgb, RgbImage};

/// The largest difference, relative to the brightest of `a`.
fn difference(a: &[Rgb], b: &[Rgb]) -> f32 {
    assert_eq!(a.len(), b.len());
    let brightest = a.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max) / brightest
}

fn sum(a: &[Rgb], b: &[Rgb]) -> Vec<Rgb> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}

#[test]
fn the_picture_is_that_of_layers_and_its_parts_add_up() {
    let folder = &Folder::new();
    let sky = RgbImage::from_fn(4, 2, |x, y| Rgb::new(0.1, 0.2, 0.3) * (1 + x + 4 * y) as f32);
    picture::write(&folder.path("sky.exr"), &sky).unwrap();
    let render = "render SCENE --environment sky.exr --height 24 --spp 8 --seed 3 --quiet";
    for flags in ["", " --adaptive"] {
        let render = format!("{render}{flags}");
        succeeds(&unrender(folder, &format!("{render} --layers --out layers.exr")));
        succeeds(&unrender(folder, &format!("{render} --aov --threads 1 --out one.exr")));
        succeeds(&unrender(folder, &format!("{render} --aov --threads 3 --out aov.exr")));
        assert!(folder.bytes("one.exr") == folder.bytes("aov.exr"), "threads");
        let whole = read(folder, "aov.exr");
        assert_eq!(whole, read(folder, "layers.exr"));
        let channels = Channels::read(&folder.path("aov.exr"));
        let whole = whole.pixels();
        assert_eq!(channels.colours("Combined"), whole);
        let parts = sum(&channels.colours("Direct"), &channels.colours("Indirect"));
        assert!(difference(whole, &parts) < ROUNDING);
        let lights = picture::read_layers(folder.path("aov.exr").as_path()).unwrap();
        let of_layers = picture::read_layers(folder.path("layers.exr").as_path()).unwrap();
        assert!(lights == of_layers && lights.len() == 2);
        let lights = sum(lights[0].radiance.pixels(), lights[1].radiance.pixels());
        assert!(difference(whole, &lights) < ROUNDING);
        // The room is closed: every sample shows a group.
        let ranks = ["00.g", "00.a", "01.g", "01.a", "02.g", "02.a"];
        let ranks = ranks.map(|rank| channels.of(&format!("ViewLayer.CryptoMaterial{rank}")));
        let covered = (0..whole.len()).map(|i| ranks.iter().map(|rank| rank[i]).sum::<f32>());
        assert!(covered.into_iter().all(|covered| (covered - 1.0).abs() < 1e-6));
    }
    // The lights of such a file are made brighter as those of --layers.
    succeeds(&unrender(folder, "relight aov.exr --only environment --out aov_sky.exr"));
    succeeds(&unrender(folder, "relight layers.exr --only environment --out sky_alone.exr"));
    assert_eq!(read(folder, "aov_sky.exr"), read(folder, "sky_alone.exr"));
}

#[test]
fn places_are_those_of_the_world_of_the_file() {
    let folder = &Folder::new();
    let mut scene = floor_and_lamp::scene();
    // So far away that positions of the scene count from elsewhere.
    scene.origin = glam::DVec3::new(4096.0, 0.0, -1024.0);
    folder.write("far.glb", &gltf::to_glb(&scene).unwrap());
    let render = "render far.glb --width 9 --height 9 --spp 4 --quiet";
    succeeds(&unrender(folder, &format!("{render} --aov --out far.exr")));
    let channels = Channels::read(&folder.path("far.exr"));
    let eye = Vec3::new(4096.0, 1.4, 2.0 - 1024.0);
    let ahead = (Vec3::new(4096.0, 0.0, -1024.0) - eye).normalize();
    let places = channels.three("ViewLayer.Position.", ["X", "Y", "Z"]);
    let depths = channels.of("ViewLayer.Depth.Z");
    // Row by row from the top, where the camera sees beyond the floor.
    let middle = 4 * 9 + 4;
    assert!(
        places[middle].abs_diff_eq(Vec3::new(4096.0, 0.0, -1024.0), 1e-3),
        "{}",
        places[middle]
    );
    let on_floor = |place: &&Rgb| **place != Rgb::ZERO;
    assert!(places.iter().filter(on_floor).count() > 20);
    for (place, depth) in places.iter().zip(depths) {
        if *place == Rgb::ZERO {
            assert_eq!(*depth, 1e10);
        } else {
            assert!(place.y.abs() < 1e-5, "{place}");
            assert!((depth - (*place - eye).dot(ahead)).abs() < 2e-3, "{depth} at {place}");
        }
    }
}

#[test]
fn a_checkpoint_goes_on_with_its_passes() {
    let folder = &Folder::new();
    let render = "render SCENE --height 16 --aov --quiet";
    succeeds(&unrender(folder, &format!("{render} --spp 6 --out whole.exr")));
    succeeds(&unrender(folder, &format!("{render} --spp 2 --checkpoint c.exr --out half.exr")));
    succeeds(&unrender(folder, &format!("{render} --spp 6 --checkpoint c.exr --out done.exr")));
    assert!(folder.bytes("whole.exr") == folder.bytes("done.exr"));
    let told = unrender(folder, "merge c.exr --out merged.exr");
    assert!(stderr(&told).contains("without its light layers"));
    assert_eq!(read(folder, "merged.exr"), read(folder, "whole.exr"));
    let other = "render SCENE --height 16 --layers --spp 6 --checkpoint c.exr --out a.exr";
    is_refused(&unrender(folder, other), "checkpoint of another rendering");
}

#[test]
fn colours_and_exposures_are_as_asked_for() {
    let folder = &Folder::new();
    let render = |flags: &str| {
        let line = format!("render SCENE --height 12 --spp 4 --quiet {flags}");
        succeeds(&unrender(folder, &line));
    };
    render("--out plain.exr");
    render("--out studio.exr --color-space acescg --exposure -1.5");
    render("--out plain.png");
    render("--out studio.png --colour-space acescg");
    render("--out plain.hdr --colour-space lin-rec709");
    assert!(folder.bytes("plain.png") == folder.bytes("studio.png"));
    let plain = read(folder, "plain.exr");
    let stored = Channels::read(&folder.path("studio.exr")).three("", ["R", "G", "B"]);
    let factor = (-1.5f32).exp2();
    let matrix = ColourSpace::AcesCg.from_rec709().as_mat3();
    let expected: Vec<Rgb> = plain.pixels().iter().map(|v| factor * (matrix * *v)).collect();
    assert!(difference(&expected, &stored) < ROUNDING);
    // It reads back as it was rendered.
    let expected: Vec<Rgb> = plain.pixels().iter().map(|v| factor * *v).collect();
    assert!(difference(&expected, read(folder, "studio.exr").pixels()) < ROUNDING);
    // All light is exposed, and nothing else.
    render("--aov --out aov.exr");
    render("--aov --exposure 2 --out bright.exr");
    let [dark, bright] = ["aov.exr", "bright.exr"].map(|name| Channels::read(&folder.path(name)));
    for name in ["Combined", "Direct", "Indirect", "Combined_light"] {
        let four: Vec<Rgb> = dark.colours(name).iter().map(|v| 4.0 * *v).collect();
        assert_eq!(bright.colours(name), four, "{name}");
    }
    assert_eq!(bright.colours("Albedo"), dark.colours("Albedo"));
    assert_eq!(bright.of("ViewLayer.Depth.Z"), dark.of("ViewLayer.Depth.Z"));
    succeeds(&unrender(folder, "relight bright.exr --exposure -2 --out relit.exr"));
    assert!(difference(&dark.colours("Combined"), read(folder, "relit.exr").pixels()) < ROUNDING);
}

#[test]
fn what_does_not_go_is_refused_before_anything_is_written() {
    let folder = &Folder::new();
    for (arguments, problem) in [
        ("render SCENE --aov --out a.png", "light layers are kept in .exr files"),
        ("render SCENE --aov --denoise --out a.exr", "cannot be used with"),
        ("render SCENE --aov --samples 0..4 --out a.exr", "cannot be used with"),
        ("render SCENE --exposure 1 --samples 0..4 --out a.exr", "--exposure is for pictures"),
        ("render SCENE --colour-space acescg --out a.hdr", "cannot say its colour space"),
        ("render SCENE --colour-space rec709 --out a.exr", "there are lin-rec709, acescg"),
        ("render SCENE --exposure inf --out a.exr", "must be a number from -126 to 127"),
        ("render SCENE --exposure bright --out a.exr", "is no number"),
        ("farm SCENE --aov --spp 9 --out a.exr --to slurm", "leave out --aov"),
        ("farm SCENE --exposure 1 --spp 9 --out a.exr --to slurm", "leave out --exposure"),
        ("restage --scene SCENE --aov --denoise --out a", "cannot be used with"),
        ("restage --scene SCENE --aov --samples 0..4 --out a", "cannot be used with"),
    ] {
        is_refused(&unrender(folder, arguments), problem);
    }
    let left: Vec<_> = std::fs::read_dir(folder.root()).unwrap().collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn a_composite_has_its_shadows_and_reflections() {
    let folder = &Stage::new();
    folder.write("e.toml", &format!("project = \"8.toml\"\n{INSERT}"));
    let composite = ["e.toml", "--composite", "--spp", "16"];
    folder.succeeds(&[&composite[..], &["--out", "plain"]].concat());
    for (threads, out) in [("1", "one"), ("2", "out")] {
        let more = ["--aov", "--colour-space", "acescg", "--threads", threads, "--out", out];
        folder.succeeds(&[&composite[..], &more].concat());
    }
    assert!(folder.bytes("one/passes.exr") == folder.bytes("out/passes.exr"));
    assert!(folder.bytes("plain/composite.png") == folder.bytes("out/composite.png"));
    folder.succeeds(&[&composite[..], &["--aov", "--out", "rec709"]].concat());
    assert!(folder.bytes("plain/composite.exr") == folder.bytes("rec709/composite.exr"));
    let [plain, studio] =
        ["plain", "out"].map(|name| read(folder, &format!("{name}/composite.exr")));
    assert!(difference(plain.pixels(), studio.pixels()) < ROUNDING);
    let channels = Channels::read(&folder.path("rec709/passes.exr"));
    let whole = read(folder, "plain/synthetic.exr");
    assert_eq!(channels.three("", ["R", "G", "B"]), whole.pixels(), "the bits of synthetic.exr");
    let parts = sum(&channels.colours("Direct"), &channels.colours("Indirect"));
    assert!(difference(whole.pixels(), &parts) < ROUNDING);
    let [shadow, reflection] = ["Shadow", "Reflection"].map(|name| channels.colours(name));
    let total = |light: &[Rgb]| light.iter().map(|v| v.element_sum()).sum::<f32>();
    assert!(total(&shadow) > total(&reflection) && total(&reflection) > 0.0);
    // A channel of a pixel is darker or lighter, and neither where all of it shows the box.
    assert!(shadow.iter().zip(&reflection).all(|(s, r)| (*s * *r).max_element() == 0.0));
    let [id, share] = ["r", "g"].map(|c| channels.of(&format!("ViewLayer.CryptoMaterial00.{c}")));
    let floor = id[id.len() - 1];
    let albedo = channels.colours("Albedo");
    let is_box = |&index: &usize| share[index] == 1.0 && albedo[index].y < 0.2;
    let of_box: Vec<usize> = (0..id.len()).filter(is_box).collect();
    assert!(of_box.len() > 5 && of_box.iter().all(|&index| id[index] != floor));
    assert!(of_box.iter().all(|&index| shadow[index] + reflection[index] == Rgb::ZERO));
}

#[test]
fn a_synthetic_picture_has_passes_too() {
    let folder = &Stage::new();
    let restage = ["--scene", "scene.glb", "--spp", "4", "--width", "20", "--aov", "--out", "out"];
    folder.succeeds(&restage);
    let channels = Channels::read(&folder.path("out/passes.exr"));
    let whole = read(folder, "out/synthetic.exr");
    assert_eq!(channels.three("", ["R", "G", "B"]), whole.pixels());
    assert!(difference(whole.pixels(), &channels.colours("Combined_lamp")) < ROUNDING);
    assert!(channels.of("ViewLayer.Normal.Z").iter().all(|v| v.abs() < 1.0 + 1e-6));
}

#[test]
fn lights_of_any_script_have_layers_and_checkpoints() {
    let folder = &Folder::new();
    let mut scene = floor_and_lamp::scene();
    scene.groups[1].name = "Лампа 照明".into();
    folder.write("s.glb", &gltf::to_glb(&scene).unwrap());
    for flag in ["--layers", "--aov"] {
        let render =
            format!("render s.glb --height 8 --quiet {flag} --checkpoint {}.exr", &flag[2..]);
        succeeds(&unrender(folder, &format!("{render} --spp 2 --out half.exr")));
        succeeds(&unrender(folder, &format!("{render} --spp 4 --out whole.exr")));
        let layers = picture::read_layers(folder.path("whole.exr").as_path()).unwrap();
        assert_eq!(layers[0].name, scene.groups[1].name);
        assert_eq!(layers[0].radiance, read(folder, "whole.exr"));
    }
}
