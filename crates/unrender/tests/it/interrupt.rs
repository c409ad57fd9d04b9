//! Ctrl-C in the middle of a recovery gives exit code 130, and complete results, marked as
//! interrupted.
#![cfg(unix)]

use crate::kit::floor_and_lamp;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// An iteration and the last picture take some seconds on a quiet machine.
const PATIENCE: Duration = Duration::from_secs(240);

#[test]
fn an_interrupted_recovery_delivers_the_best_state_so_far() {
    let folder = floor_and_lamp::project();
    let (project, out) = (folder.path("p.toml"), folder.path("out"));
    let mut running = Command::new(env!("CARGO_BIN_EXE_unrender"))
        .arg("recover")
        .arg(project)
        .args(["--spp", "65536", "--out"])
        .arg(&out)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // More iterations follow the first, and then a picture of so many paths that it takes seconds.
    let said = BufReader::new(running.stderr.take().unwrap());
    let (tell, told) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        said.lines().map_while(Result::ok).for_each(|line| drop(tell.send(line)))
    });
    let started = Instant::now();
    while !told.recv_timeout(PATIENCE).unwrap().contains("iteration 1") {
        assert!(started.elapsed() < PATIENCE, "the recovery did not begin: {:?}", running.kill());
    }
    let pid = running.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let started = Instant::now();
    let status = loop {
        if let Some(status) = running.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > PATIENCE {
            running.kill().unwrap();
            panic!("the signal did not end it");
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    assert_eq!(status.code(), Some(130), "{status}");
    let run = std::fs::read_to_string(out.join("run.json")).unwrap();
    assert!(run.contains("\"termination\": \"interrupted after"), "{run}");
    for file in ["materials.json", "rerendered.exr", "report.html", "scene.glb", "manifest.json"] {
        assert!(out.join(file).is_file(), "{file} is missing");
    }
}
