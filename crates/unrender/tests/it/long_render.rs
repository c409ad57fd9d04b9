//! Pictures made in parts, with interruptions, or on other numbers of threads equal those of one
//! run, to the bit.

use crate::kit::example::beside_crates;
use crate::kit::folder::{Folder, fails, is_refused, stderr, succeeds};
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Output, Stdio};
use unrender::formats::picture;
use unrender::scene::{Image, Rgb};

/// `unrender render` of the box of Figure 8, with `arguments` separated by spaces.
fn render(folder: &Folder, arguments: &str) -> Command {
    let mut command = folder.command(&["render", "--quiet"]);
    command.arg(beside_crates("examples/fig8/scene.glb")).args(arguments.split(' '));
    command
}

fn merge(folder: &Folder, arguments: &str) -> Output {
    folder.command(&["merge", "--quiet"]).args(arguments.split(' ')).output().unwrap()
}

/// The messages of `merge` when it makes the picture `out` from the checkpoint c.exr.
fn told_by_merge(folder: &Folder, out: &str) -> String {
    let output = folder.run(&["merge", "c.exr", "--out", out]);
    succeeds(&output);
    stderr(&output)
}

#[test]
fn parts_merge_to_the_bits_of_one_run() {
    let folder = Folder::new();
    let run = |arguments: &str| succeeds(&render(&folder, arguments).output().unwrap());
    run("--height 40 --spp 21 --out whole.exr");
    run("--height 40 --samples 0..5 --threads 1 --out a.exr");
    run("--height 40 --samples 5..6 --threads 3 --out b.exr");
    run("--height 40 --samples 6..21 --threads 2 --out c.exr");
    succeeds(&merge(&folder, "c.exr a.exr b.exr --out merged.exr"));
    assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"), "the bits differ");
    succeeds(&merge(&folder, "a.exr c.exr b.exr --out merged.png"));
    run("--height 40 --spp 21 --out whole.png");
    assert!(folder.bytes("merged.png") == folder.bytes("whole.png"), "the bits differ");
    // A part is a picture itself.
    run("--height 40 --spp 5 --out first.exr");
    let values = |name: &str| picture::read(&folder.path(name)).unwrap().0.values;
    assert!(values("a.exr") == values("first.exr"));

    fails(&merge(&folder, "c.exr a.exr --out x.exr"), "the samples 5..6 are in no part; render");
    fails(&merge(&folder, "b.exr c.exr --out x.exr"), "the samples 0..5 are in no part");
    let output = merge(&folder, "c.exr a.exr --allow-gaps --out gap.exr");
    succeeds(&output);
    assert!(stderr(&output).starts_with("warning: the samples 5..6 are"));
    run("--height 40 --samples 4..7 --out d.exr");
    let overlap = "has the samples 4..7, and a.exr has some of them too (0..5)";
    fails(&merge(&folder, "a.exr d.exr --out x.exr"), overlap);
    fails(&merge(&folder, "a.exr whole.exr --out x.exr"), "whole.exr: is an EXR file without");
    run("--height 40 --samples 5..6 --seed 4 --out b.exr");
    let belongs = "b.exr: does not belong to a.exr: it has another seed (4, not 0)";
    fails(&merge(&folder, "a.exr b.exr c.exr --out x.exr"), belongs);
    assert!(!folder.path("x.exr").exists());
}

#[test]
fn parts_of_other_renderings_are_told_apart() {
    let folder = Folder::new();
    let run = |arguments: &str| succeeds(&render(&folder, arguments).output().unwrap());
    run("--height 8 --samples 0..2 --out a.exr");
    let materials = r#"{"groups": {"floor": {"rho_d": [0.2, 0.2, 0.2]}}}"#;
    folder.write("m.json", materials);
    let sky = Image::from_fn(4, 2, |_, _| Rgb::ONE);
    picture::write(&folder.path("sky.exr"), &sky).unwrap();
    for (arguments, problem) in [
        ("--height 9", "another size (9 x 9, not 8 x 8)"),
        ("--height 8 --bounces 3", "another --bounces (3, not 500)"),
        ("--height 8 --materials m.json", "another scene, materials or lights ("),
        ("--height 8 --environment sky.exr", "another scene, materials or lights ("),
    ] {
        run(&format!("{arguments} --samples 2..4 --out b.exr"));
        fails(&merge(&folder, "a.exr b.exr --out x.exr"), problem);
    }
}

#[test]
fn a_rendering_goes_on_from_its_checkpoint() {
    let folder = Folder::new();
    let run = |arguments: &str| succeeds(&render(&folder, arguments).output().unwrap());
    run("--height 30 --spp 23 --out whole.exr");
    run("--height 30 --spp 9 --checkpoint c.exr --out early.exr");
    run("--height 30 --spp 23 --checkpoint c.exr --threads 1 --out late.exr");
    assert!(folder.bytes("late.exr") == folder.bytes("whole.exr"), "the bits differ");
    // A checkpoint is a part.
    succeeds(&merge(&folder, "c.exr --out merged.exr"));
    assert!(folder.bytes("merged.exr") == folder.bytes("whole.exr"), "the bits differ");

    let run = |arguments| render(&folder, arguments).output().unwrap();
    let output = run("--height 30 --spp 9 --checkpoint c.exr --out x.exr");
    fails(&output, "c.exr: has the samples up to 23 already, more than the 9 asked for");
    let output = run("--height 31 --spp 99 --checkpoint c.exr --out x.exr");
    fails(&output, "another rendering: this one has another size (31 x 31, not 30 x 30)");
    fails(&run("--checkpoint c.png --out x.exr"), "c.png: the samples of a picture are kept in");
    fails(&run("--samples 0..2 --out x.png"), "x.png: the samples of a picture are kept in .exr");
}

#[test]
fn noise_ends_a_rendering_alike_with_and_without_breaks() {
    let folder = Folder::new();
    let run = |arguments: &str| succeeds(&render(&folder, arguments).output().unwrap());
    run("--height 24 --noise 0.02 --adaptive --out whole.exr");
    // Interrupted at a number of samples at which the noise is not checked.
    run("--height 24 --noise 0.02 --adaptive --spp 18 --checkpoint c.exr --threads 1 --out x.exr");
    run("--height 24 --noise 0.02 --adaptive --checkpoint c.exr --threads 3 --out late.exr");
    assert!(folder.bytes("late.exr") == folder.bytes("whole.exr"), "the bits differ");
    let text = told_by_merge(&folder, "y.exr");
    let noise: f64 = text.split([' ', '%']).rev().find_map(|word| word.parse().ok()).unwrap();
    assert!(noise <= 2.0 && noise > 1.5, "{text}");
    fails(&merge(&folder, "c.exr c.exr --out x.exr"), "was sampled adaptively");
    let timed = render(&folder, "--height 24 --time 0.001 --out timed.exr").output().unwrap();
    succeeds(&timed);
    assert!(folder.path("timed.exr").exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_there_is() {
    let folder = Folder::new();
    let arguments = "--height 200 --spp 1000000 --checkpoint c.exr --out x.exr";
    let mut running = folder
        .command(&["render"])
        .arg(beside_crates("examples/fig8/scene.glb"))
        .args(arguments.split(' '))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(running.stderr.take().unwrap());
    // With the first line of progress it is rendering.
    let mut told = String::new();
    said.read_line(&mut told).unwrap();
    assert!(told.starts_with("render: "), "{told}");
    let pid = running.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    said.read_to_string(&mut told).unwrap();
    assert_eq!(running.wait().unwrap().code(), Some(130), "{told}");
    assert!(told.contains("the same command continues from there"), "{told}");
    assert!(!folder.path("x.exr").exists());
    // The checkpoint is a complete picture of fewer samples.
    let text = told_by_merge(&folder, "so_far.exr");
    let samples = text.split(' ').find_map(|word| word.parse::<u32>().ok()).unwrap();
    let again = format!("--height 200 --spp {samples} --out whole.exr");
    succeeds(&render(&folder, &again).output().unwrap());
    assert!(folder.bytes("so_far.exr") == folder.bytes("whole.exr"), "the bits differ");
}

#[test]
fn a_denoised_picture_goes_on_from_its_checkpoint_to_the_same_bits() {
    let folder = Folder::new();
    for (kind, checkpoint) in [("", "u.exr"), (" --adaptive", "c.exr")] {
        let common = format!("--height 32 --denoise{kind}");
        succeeds(&render(&folder, &format!("{common} --spp 16 --out whole.exr")).output().unwrap());
        // The third run has nothing left to render, and denoises the existing samples.
        for (spp, threads) in [(9, 1), (16, 2), (16, 1)] {
            let arguments = format!(
                "{common} --spp {spp} --threads {threads} --checkpoint {checkpoint} --out b.exr"
            );
            succeeds(&render(&folder, &arguments).output().unwrap());
            let (_, warnings) = picture::read(&folder.path("b.exr")).unwrap();
            assert!(warnings.0.iter().any(|w| w.contains("was denoised")), "{warnings:?}");
        }
        assert_eq!(folder.bytes("b.exr"), folder.bytes("whole.exr"), "{common}");
    }

    // Merged pictures are not denoised, and a message states this.
    assert!(told_by_merge(&folder, "m.exr").contains("written as it is"));

    // A picture that is not denoised has other samples.
    let other = "--height 32 --adaptive --spp 32 --independent --checkpoint c.exr --out c2.exr";
    let output = render(&folder, other).output().unwrap();
    is_refused(&output, "second half");
    for refused in ["--spp 4", "--samples 0..64"] {
        let arguments = format!("--denoise {refused} --out no.exr");
        assert!(!render(&folder, &arguments).output().unwrap().status.success(), "{refused}");
        assert!(!folder.path("no.exr").exists());
    }
}
