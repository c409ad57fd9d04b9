//! Fuzzing by meaning: the same run twice, and faults that are planted.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A run that comes to the end of all commands.
const SEED: &str = "11";
const RUN: &str = "3";

/// Whether run `index` ends without a finding, and what it says; its folder goes into `keep`.
fn searched(keep: &Path, index: &str, more: &[&str]) -> (bool, String) {
    let mut fuzz = Command::new(env!("CARGO_BIN_EXE_unrender-fuzz"));
    fuzz.args(["--family", "meaning", "--seed", SEED, "--first", index, "--runs", "1", "--keep"]);
    let output = fuzz.arg(keep).args(more).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.success(), format!("{}{}", text(&output.stdout), text(&output.stderr)))
}

/// The files of run `index`, by name.
fn inputs(index: &str) -> BTreeMap<String, Vec<u8>> {
    let keep = tempfile::tempdir().unwrap();
    // The planted panic comes before the first command.
    searched(keep.path(), index, &["--plant", "panic"]);
    let folder = keep.path().join(format!("meaning-{SEED}-{index}"));
    let entries = fs::read_dir(folder).unwrap().map(Result::unwrap);
    let file = |entry: fs::DirEntry| {
        (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).unwrap())
    };
    entries.map(file).collect()
}

#[test]
fn a_run_has_the_same_files_each_time_and_others_than_the_next() {
    let (once, again, next) = (inputs(RUN), inputs(RUN), inputs("4"));
    for name in ["scene.glb", "shown.glb", "project.toml", "edit.toml", "commands.txt"] {
        assert!(once.contains_key(name), "{:?}", once.keys());
    }
    assert!(once == again, "the files of a run differ");
    assert!(once["project.toml"] != next["project.toml"] && once["scene.glb"] != next["scene.glb"]);
}

#[test]
fn planted_faults_are_found_and_told_with_the_command_that_finds_them_again() {
    let keep = tempfile::tempdir().unwrap();
    let (is_clean, said) = searched(keep.path(), RUN, &["--tell"]);
    assert!(is_clean && said.contains("restaged: "), "{said}");
    assert_eq!(fs::read_dir(keep.path()).unwrap().count(), 0, "only findings are kept");
    for (plant, told) in [
        ("panic", "panicked at"),
        ("nan", "rho_d of materials.json is no finite number"),
        ("error", "recovered, with an error of 0.500"),
        ("picture", "check says \"3 value(s) were not finite numbers and were written as zero\""),
    ] {
        let (is_clean, said) = searched(keep.path(), RUN, &["--plant", plant]);
        assert!(
            !is_clean && said.contains(told) && said.contains("1 finding(s)"),
            "{plant}: {said}"
        );
        let again = format!("--family meaning --seed {SEED} --first {RUN} --runs 1");
        assert!(said.contains(&again), "{said}");
        assert!(keep.path().join(format!("meaning-{SEED}-{RUN}/project.toml")).exists());
    }
}
