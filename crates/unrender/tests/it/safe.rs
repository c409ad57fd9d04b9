//! Nothing is lost: inputs, earlier results, and work whose output nobody reads.
#![cfg(unix)]

use crate::kit::floor_and_lamp;
use crate::kit::folder::{Folder, ends_in_error, stderr, succeeds};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::ops::Deref;
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use unrender::formats::picture;
use unrender::scene::Rgb;

/// A floor under a lamp, its photograph, and the project of both.
struct Room(Folder);

impl Deref for Room {
    type Target = Folder;

    fn deref(&self) -> &Folder {
        &self.0
    }
}

impl Room {
    fn new() -> Self {
        Self(floor_and_lamp::project())
    }

    fn recover(&self, out: &str) -> Output {
        self.run(&["recover", "p.toml", "--no-refine", "--spp", "1", "--out", out])
    }

    /// A line of the shell, in which `$U` is the program.
    fn shell(&self, line: &str) -> Output {
        let program = ("U", env!("CARGO_BIN_EXE_unrender"));
        let mut shell = Command::new("sh");
        shell.current_dir(self.root()).envs([program]).args(["-c", line]).output().unwrap()
    }

    /// All files with their contents.
    fn files(&self, folder: &str) -> Vec<(PathBuf, Vec<u8>)> {
        let mut open = vec![self.path(folder)];
        let mut found = Vec::new();
        while let Some(folder) = open.pop() {
            for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                match path.is_dir() {
                    true => open.push(path),
                    false => found.push((path.clone(), fs::read(path).unwrap())),
                }
            }
        }
        found.sort();
        found
    }
}

/// Asserts that the command failed with an error that has all of `words`.
#[track_caller]
fn assert_refused(output: &Output, words: &[&str]) {
    words.iter().for_each(|word| ends_in_error(output, word));
}

#[test]
fn results_do_not_replace_inputs() {
    let room = Room::new();
    let before = room.files(".");
    assert_refused(&room.recover("."), &["photo.png", "scene.glb", "--out"]);
    let link = room.path("link");
    std::os::unix::fs::symlink(".", &link).unwrap();
    assert_refused(&room.recover("link"), &["photo.png"]);
    fs::remove_file(link).unwrap();
    assert_refused(
        &room.run(&["export", "--scene", "scene.glb", "--to", "gltf", "--out", "scene.glb"]),
        &["input"],
    );
    picture::write(&room.path("sky.exr"), &unrender::scene::Image::from_fn(4, 2, |_, _| Rgb::ONE))
        .unwrap();
    let sky = ["render", "scene.glb", "--environment", "sky.exr", "--out", "./sky.exr"];
    assert_refused(&room.run(&sky), &["sky.exr", "input"]);
    assert_refused(&room.run(&["merge", "sky.exr", "--out", "sky.exr"]), &["input"]);
    assert_refused(&room.run(&["check", "p.toml", "--out", "photo.png"]), &["input"]);
    fs::remove_file(room.path("sky.exr")).unwrap();
    assert!(room.files(".") == before, "something was changed or left behind");
}

#[test]
fn results_replace_only_results() {
    let room = Room::new();
    fs::create_dir(room.path("out")).unwrap();
    fs::write(room.path("out/photo.png"), "mine").unwrap();
    assert_refused(&room.recover("out"), &["photo.png", "move them away"]);
    fs::remove_file(room.path("out/photo.png")).unwrap();
    // A log that the shell has made, and what is hidden, are nobody's.
    fs::write(room.path("out/log.txt"), "").unwrap();
    fs::write(room.path("out/.DS_Store"), "x").unwrap();
    succeeds(&room.recover("out"));
    fs::write(room.path("out/notes.txt"), "mine").unwrap();
    succeeds(&room.recover("out"));
    assert_eq!(fs::read(room.path("out/notes.txt")).unwrap(), b"mine");
    // Each result is protected if it belongs to somebody else.
    let others = ["notes.txt", "log.txt", ".DS_Store"];
    for (path, _) in room.files("out") {
        let name = path.strip_prefix(room.path("out")).unwrap().to_owned();
        if others.iter().any(|other| name.ends_with(other)) {
            continue;
        }
        let fresh = room.path("fresh");
        fs::create_dir_all(fresh.join(&name).parent().unwrap()).unwrap();
        fs::write(fresh.join(&name), "mine").unwrap();
        assert_refused(&room.recover("fresh"), &[name.to_str().unwrap()]);
        fs::remove_dir_all(fresh).unwrap();
    }
    // A file that was changed by hand is no longer a result.
    fs::write(room.path("out/materials.json"), "{\"groups\": {}}").unwrap();
    assert_refused(&room.recover("out"), &["materials.json"]);
}

#[test]
fn results_do_not_mix_with_the_files_of_others() {
    let room = Room::new();
    for (file, text) in [("mixed/notes.txt", "mine"), ("with/folder/inside.txt", "mine")] {
        let folder = file.split('/').next().unwrap();
        fs::create_dir_all(room.path(file).parent().unwrap()).unwrap();
        fs::write(room.path(file), text).unwrap();
        let before = room.files(".");
        assert_refused(&room.recover(folder), &[folder, "holds other files", "--out"]);
        let restage = ["restage", "--scene", "scene.glb", "--height", "8", "--spp", "1", "--out"];
        assert_refused(&room.run(&[&restage[..], &[folder]].concat()), &["holds other files"]);
        assert!(room.files(".") == before, "something was changed or left behind");
    }
}

#[test]
fn a_reader_that_has_gone_away_loses_no_work() {
    let room = Room::new();
    let recover = "$U recover p.toml --no-refine --spp 1 --out";
    for (name, line) in [
        ("a", "2>&1 | head -1"),
        ("b", "2>&1 | true"),
        ("c", ">/dev/full 2>/dev/full"),
        ("d", "--json >/dev/full"),
        ("e", ">&- 2>&-"),
    ] {
        let told = room.shell(&format!("{recover} {name} {line}"));
        // The program may still run if its output goes into a pipe.
        let started = Instant::now();
        while !room.path(name).join("materials.json").exists() {
            assert!(started.elapsed() < Duration::from_secs(60), "{line}: {told:?}");
            std::thread::sleep(Duration::from_millis(50));
        }
        assert!(room.path(name).join("report.html").exists(), "{line}");
    }
    for line in ["| true", ">/dev/full", ">&- 2>&-"] {
        let out = format!("room{}.glb", line.len());
        let export = format!("$U export --scene scene.glb --to gltf --out {out} {line}");
        let told = room.shell(&export);
        assert!(!stderr(&told).contains("panicked"), "{told:?}");
        assert!(room.path(&out).exists(), "{line}");
    }
}

#[test]
fn results_of_two_runs_are_not_taken_for_one() {
    let room = Room::new();
    succeeds(&room.recover("out"));
    succeeds(&room.run(&["report", "out"]));
    succeeds(&room.run(&["report", "out"]));
    // The state after kill -9 between two files: the manifest is that of the new run.
    let manifest = room.path("out/manifest.json");
    let whole = fs::read_to_string(&manifest).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&whole).unwrap();
    let old = json["files"]["run.json"]["sha256"].clone();
    json["before"] = serde_json::json!({"run.json": [old]});
    json["files"]["run.json"]["sha256"] = "0".repeat(64).into();
    fs::write(&manifest, json.to_string()).unwrap();
    let commands = [
        &["report", "out"][..],
        &["export", "out", "--to", "gltf", "--out", "room.glb"],
        &["restage", "--recovered", "out", "--height", "8", "--spp", "1", "--out", "new"],
    ];
    for command in commands {
        assert_refused(&room.run(command), &["two runs"]);
    }
    // The next run repairs it.
    succeeds(&room.recover("out"));
    for command in commands {
        succeeds(&room.run(command));
    }
    // A file of another run, copied over.
    fs::write(room.path("out/run.json"), fs::read(room.path("p.toml")).unwrap()).unwrap();
    assert_refused(&room.run(&["report", "out"]), &["run.json", "changed"]);
}

#[test]
fn the_second_process_is_reported() {
    let room = Room::new();
    fs::create_dir(room.path("out")).unwrap();
    let folder = File::open(room.path("out")).unwrap();
    folder.lock().unwrap();
    assert_refused(&room.recover("out"), &["another unrender"]);
    drop(folder);
    succeeds(&room.recover("out"));
}

#[test]
fn threads_that_cannot_help_are_reported() {
    let room = Room::new();
    let render = ["render", "scene.glb", "--height", "8", "--spp", "1", "--out", "a.exr"];
    let told = room.run(&[&render[..], &["--threads", "100000"]].concat());
    succeeds(&told);
    assert!(stderr(&told).contains("more than can help"), "{told:?}");
}

#[test]
fn names_that_are_no_text_are_good_or_told_before_the_work() {
    let room = Room::new();
    let name = OsStr::from_bytes(b"out\xff");
    let arguments = ["recover", "p.toml", "--no-refine", "--spp", "1", "--out"];
    let told = room.command(&arguments).arg(name).output().unwrap();
    succeeds(&told);
    assert!(room.path(name).join("report.html").exists());
    let project = OsStr::from_bytes(b"p\xff.toml");
    fs::rename(room.path("p.toml"), room.path(project)).unwrap();
    let told = room
        .command(&["recover", "--no-refine", "--spp", "1", "--out", "o"])
        .arg(project)
        .output()
        .unwrap();
    succeeds(&told);
}

#[test]
fn outputs_are_asked_before_the_work_and_stay_what_they_are() {
    let room = Room::new();
    fs::create_dir(room.path("elsewhere")).unwrap();
    fs::write(room.path("elsewhere/a.exr"), "old").unwrap();
    std::os::unix::fs::symlink("elsewhere/a.exr", room.path("a.exr")).unwrap();
    let render = ["render", "scene.glb", "--height", "8", "--spp", "1", "--out", "a.exr"];
    succeeds(&room.run(&render));
    assert!(fs::symlink_metadata(room.path("a.exr")).unwrap().is_symlink());
    assert_ne!(fs::read(room.path("elsewhere/a.exr")).unwrap(), b"old");
    let mut mode = fs::metadata(room.path("elsewhere/a.exr")).unwrap().permissions();
    mode.set_readonly(true);
    fs::set_permissions(room.path("elsewhere/a.exr"), mode).unwrap();
    assert_refused(&room.run(&render), &["write-protected"]);
}

#[test]
fn a_file_that_may_not_grow_leaves_nothing_behind() {
    let room = Room::new();
    let before = room.files(".").len();
    // 512 bytes, which the header alone almost has.
    let told = room.shell("ulimit -f 1; $U render scene.glb --height 256 --spp 1 --out a.exr");
    assert_refused(&told, &["a.exr", "cannot be written"]);
    assert_eq!(room.files(".").len(), before);
}

#[test]
fn sigterm_keeps_the_checkpoint() {
    let room = Room::new();
    let arguments = ["--spp", "1000000", "--checkpoint", "c.exr", "--out", "a.exr"];
    let mut running = room
        .command(&[&["render", "scene.glb", "--height", "64"], &arguments[..]].concat())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_secs(2));
    let pid = running.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
    let started = Instant::now();
    let status = loop {
        if let Some(status) = running.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > Duration::from_secs(60) {
            running.kill().unwrap();
            panic!("SIGTERM did not end it");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(status.code(), Some(143), "{status}");
    assert!(room.path("c.exr").exists() && !room.path("a.exr").exists());
}

/// Faults at random moments. The files on the disk afterwards are one complete result, or are refused;
/// inputs are untouched; the next run repairs them.
#[test]
#[ignore = "slow: sixty recoveries"]
fn what_faults_leave_is_whole_or_refused() {
    const FAULTS: u32 = 60;
    let room = Room::new();
    let inputs = room.files(".");
    let started = Instant::now();
    succeeds(&room.recover("out"));
    let length = started.elapsed();
    let (mut whole, mut refused) = (0, 0);
    for fault in 0..FAULTS {
        let arguments =
            ["recover", "p.toml", "--no-refine", "--spp", "1", "--out", "out", "--seed"];
        let mut command = room.command(&[&arguments[..], &[&fault.to_string()]].concat());
        let mut running = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // More of them at the end, where results are written.
        std::thread::sleep(length.mul_f64(1.1 - f64::from(fault * 37 % FAULTS).sqrt() / 20.0));
        let signal = if fault % 4 == 0 { "-TERM" } else { "-KILL" };
        // It may have ended by itself.
        let pid = running.id().to_string();
        let _ = Command::new("kill").args([signal, &pid]).stderr(Stdio::null()).status();
        running.wait().unwrap();
        let report = room.run(&["report", "out", "--quiet"]);
        let said = stderr(&report);
        match report.status.code() {
            Some(0) => whole += 1,
            Some(1) if said.contains("two runs") => refused += 1,
            _ => panic!("fault {fault}: {said}"),
        }
    }
    println!("{FAULTS} faults: {whole} whole results, {refused} refused");
    succeeds(&room.recover("out"));
    succeeds(&room.run(&["report", "out"]));
    let hidden = |(path, _): &&(PathBuf, Vec<u8>)| path.to_string_lossy().contains(".unrender-");
    assert_eq!(room.files("out").iter().filter(hidden).count(), 0);
    fs::remove_dir_all(room.path("out")).unwrap();
    assert!(room.files(".") == inputs, "inputs were changed");
}

#[test]
fn what_is_refused_leaves_no_folder_behind() {
    let room = Room::new();
    // A scene whose fault is detected after the folder was made.
    room.write("scene.glb", "no scene");
    ends_in_error(&room.recover("deep/er/out"), "scene.glb");
    assert!(!room.path("deep").exists());
    // A folder that existed before stays.
    fs::create_dir_all(room.path("there")).unwrap();
    ends_in_error(&room.recover("there"), "scene.glb");
    ends_in_error(&room.recover("there/new"), "scene.glb");
    assert!(room.path("there").exists() && !room.path("there/new").exists());
}
