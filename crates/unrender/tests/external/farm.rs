//! A job template, run by the reference program of Open Job Description.

use crate::kit::example::beside_crates;
use crate::kit::programs::{installed, need};
use std::path::Path;
use std::process::Command;

#[track_caller]
fn succeeds(command: &mut Command) {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said} {}", String::from_utf8_lossy(&output.stderr));
}

fn unrender(folder: &Path, words: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_unrender"));
    command.current_dir(folder).args(words).arg("--quiet");
    command
}

#[test]
#[ignore = "slow: needs the program of Open Job Description, which .ci/programs installs"]
fn openjd_makes_the_picture_of_one_run() {
    let Some(openjd) = need(installed("openjd")) else { return };
    let openjd = openjd.join("bin/openjd");
    let folder = tempfile::tempdir().unwrap();
    let fig8 = beside_crates("examples/fig8");
    std::fs::copy(fig8.join("scene.glb"), folder.path().join("the scene.glb")).unwrap();
    let truth = fig8.join("truth.json");
    let words = ["the scene.glb", "--materials", truth.to_str().unwrap(), "--height", "24"];
    let whole = ["render", "--spp", "11", "--out", "whole.exr"];
    succeeds(&mut unrender(folder.path(), &[&whole[..1], &words, &whole[1..]].concat()));
    let farm = ["farm", "--spp", "11", "--parts", "3", "--out", "picture.exr", "--to", "openjd"];
    succeeds(&mut unrender(folder.path(), &[&farm[..1], &words, &farm[1..]].concat()));
    let template = folder.path().join("picture_job/template.json");
    succeeds(Command::new(&openjd).arg("check").arg(&template));
    let mut run = Command::new(&openjd);
    run.arg("run").arg(&template);
    let given = folder.path().join("picture_job/parameters.json");
    run.arg("-p").arg(format!("file://{}", given.display()));
    run.arg("-p").arg(format!("Unrender={}", env!("CARGO_BIN_EXE_unrender")));
    succeeds(&mut run);
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("picture.exr") == bytes("whole.exr"), "the job's picture differs");
    assert!(folder.path().join("picture_job/part_0..3.exr").exists());
}
