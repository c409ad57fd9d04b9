//! Tests of `recover --resume`: a recovery that is killed again and again continues each time, and
//! its result equals that of an uninterrupted one to the bit.
#![cfg(unix)]

use crate::kit::example::beside_crates;
use crate::kit::floor_and_lamp;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A step takes seconds on a busy machine.
const PATIENCE: Duration = Duration::from_secs(300);

/// A project that is recovered into a folder.
struct Recovery {
    project: PathBuf,
    out: PathBuf,
    flags: &'static [&'static str],
}

impl Recovery {
    fn command(&self, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_unrender"));
        command.arg("recover").arg(&self.project);
        command.args(self.flags).args(more).arg("--out").arg(&self.out);
        command.stdout(Stdio::null());
        command
    }

    fn journal(&self) -> u64 {
        let path = self.out.join(".unrender-recover.journal");
        fs::metadata(path).map_or(0, |meta| meta.len())
    }

    /// Starts or continues the recovery, and returns the process as soon as `steps` further steps are on
    /// the disk; none if it ended before.
    fn until(&self, steps: usize) -> Option<Child> {
        let mut running = self.command(&["--resume"]).stderr(Stdio::null()).spawn().unwrap();
        let (started, mut length, mut left) = (Instant::now(), self.journal(), steps);
        while left > 0 {
            if running.try_wait().unwrap().is_some() {
                return None;
            }
            assert!(started.elapsed() < PATIENCE, "no step ends");
            // Removing an incomplete record makes it shorter for a moment.
            if self.journal() > length {
                left -= 1;
            }
            length = self.journal();
            std::thread::sleep(Duration::from_millis(2));
        }
        Some(running)
    }

    /// The bytes of the results by their names, except times, memory and the command line.
    fn results(&self) -> BTreeMap<String, Vec<u8>> {
        let (mut open, mut found) = (vec![self.out.clone()], BTreeMap::new());
        while let Some(folder) = open.pop() {
            for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                if path.is_dir() {
                    open.push(path);
                } else if !["report.html", "manifest.json"].contains(&&*name) {
                    let mut bytes = fs::read(&path).unwrap();
                    if name.ends_with(".json") {
                        let mut value: Value = serde_json::from_slice(&bytes).unwrap();
                        without_times(&mut value);
                        bytes = value.to_string().into_bytes();
                    }
                    found.insert(name, bytes);
                }
            }
        }
        found
    }
}

fn without_times(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(without_times),
        Value::Object(map) => {
            for key in ["seconds", "stages", "peak_memory_bytes", "command"] {
                map.shift_remove(key);
            }
            map.values_mut().for_each(without_times);
        }
        _ => {}
    }
}

/// Kills a recovery of `project` with `flags` after each number of `steps`, continues it, and compares; once it
/// is ended by SIGTERM in between.
fn killed(project: &Path, flags: &'static [&'static str], steps: &[usize]) {
    let folder = tempfile::tempdir().unwrap();
    let into =
        |name: &str| Recovery { project: project.to_owned(), out: folder.path().join(name), flags };
    let alone = into("alone");
    assert!(alone.command(&["--quiet"]).stderr(Stdio::null()).status().unwrap().success());
    assert_eq!(alone.journal(), 0, "the journal of a recovery that is done is removed");
    let often = into("often");
    let mut kills = 0;
    for steps in steps {
        let Some(mut running) = often.until(*steps) else { break };
        running.kill().unwrap();
        running.wait().unwrap();
        kills += 1;
        // Nothing is done yet, but for the picture that grows.
        let is_early = |name: &String| {
            name.starts_with('.') || ["rerendered.png", "manifest.json"].contains(&name.as_str())
        };
        assert!(often.results().keys().all(is_early), "{:?}", often.results().keys());
        if kills == 2 {
            let other = often.command(&["--resume", "--seed", "9"]).output().unwrap();
            let said = String::from_utf8_lossy(&other.stderr).into_owned();
            assert_eq!(other.status.code(), Some(1), "{said}");
            assert!(said.contains("with other options: --seed 0 and not 9;"), "{said}");
        }
    }
    assert!(kills >= 2, "it was killed {kills} times: too fast for this test");
    if let Some(mut running) = often.until(1) {
        let pid = running.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &pid]).status().unwrap().success());
        // It may just have ended.
        if running.wait().unwrap().code() == Some(143) {
            let run = fs::read_to_string(often.out.join("run.json")).unwrap();
            assert!(run.contains("\"termination\": \"interrupted after"), "{run}");
            assert!(often.journal() > 0, "there is something to resume");
        }
    }
    let last = often.command(&["--resume"]).output().unwrap();
    assert!(last.status.success(), "{}", String::from_utf8_lossy(&last.stderr));
    let (alone, often) = (alone.results(), often.results());
    assert!(alone.keys().eq(often.keys()), "{:?} {:?}", alone.keys(), often.keys());
    for (name, bytes) in &alone {
        assert!(often[name] == *bytes, "{name} has other bits");
    }
}

#[test]
fn a_killed_recovery_goes_on_to_the_same_bits() {
    let folder = floor_and_lamp::project();
    killed(&folder.path("p.toml"), &["--effort", "draft", "--spp", "8"], &[1, 3, 2]);
}

#[test]
#[ignore = "slow: eight recoveries that are killed"]
fn so_does_one_with_all_hypotheses_and_the_refinement() {
    let project = beside_crates("examples/corpus/isotropic/project.toml");
    killed(&project, &["--spp", "4"], &[2, 9, 1, 14, 5, 11, 3, 8]);
}

#[test]
fn resuming_where_nothing_was_interrupted_says_so() {
    let folder = floor_and_lamp::project();
    let flags = &["--effort", "draft", "--max-rung", "diffuse", "--no-refine", "--spp", "1"];
    let recovery = Recovery { project: folder.path("p.toml"), out: folder.path("out"), flags };
    let resumed = || {
        let told =
            recovery.command(&["--resume", "--quiet"]).stdout(Stdio::piped()).output().unwrap();
        assert!(told.status.success(), "{told:?}");
        [told.stderr, told.stdout].map(|text| String::from_utf8_lossy(&text).into_owned())
    };
    let [said, table] = resumed();
    assert!(said.contains("no interrupted recovery is in"), "{said}");
    // The results are not progress, so they are printed.
    assert!(table.starts_with("group ") && table.contains("floor"), "{table}");
    // What is complete stays as it is: an interruption would leave less.
    let before = folder.bytes("out/run.json");
    let [said, table] = resumed();
    assert!(said.contains("has ended: there is nothing to resume, and nothing was done"), "{said}");
    assert!(table.is_empty() && folder.bytes("out/run.json") == before, "{table}");
}
