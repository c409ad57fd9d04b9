//! Builds the code with another value, and recovers the tiny scenes with it.

use super::code::Constant;
use crate::{Failure, peers, root, statistics};
use serde_json::Value;
use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// A copy of the code, with its own target folder.
pub(super) struct Bench {
    tree: PathBuf,
    scenes: Vec<PathBuf>,
    seeds: u64,
}

/// The outcome of all scenes with all seeds.
#[derive(Debug)]
pub(super) struct Outcome {
    right: usize,
    counted: usize,
    /// The median error of rho_d over the right groups.
    rho_d: f64,
    seconds: f64,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { right, counted, rho_d, seconds } = self;
        write!(f, "{right} of {counted}, {rho_d:.4}, {seconds:.0} s")
    }
}

impl Bench {
    /// Copies the code's files that Git tracks.
    ///
    /// # Errors
    /// If that fails.
    pub(super) fn new(seeds: u64) -> Result<Self, Failure> {
        let tree = peers::work_folder("halves");
        let files = peers::said(Command::new("git").args(["ls-files"]).current_dir(root()))?;
        for file in files.lines() {
            let (from, to) = (root().join(file), tree.join(file));
            if !from.is_file() || is_alike(&from, &to) {
                continue;
            }
            std::fs::create_dir_all(to.parent().unwrap_or(&tree))?;
            std::fs::copy(&from, &to)?;
        }
        let scenes = std::fs::read_dir(root().join("examples/corpus"))?;
        let mut scenes: Vec<PathBuf> = scenes
            .filter_map(|entry| entry.ok().map(|entry| entry.path()))
            .filter(|path| path.join("truth.json").exists())
            .collect();
        scenes.sort();
        Ok(Self { tree, scenes, seeds })
    }

    /// The outcome with the value of a constant times a factor; afterwards the copy is as before.
    ///
    /// # Errors
    /// If the value cannot be set, or the code with it cannot be built. Scenes that cannot be recovered count as
    /// wrong.
    pub(super) fn measure(&self, change: Option<(&Constant, f64)>) -> Result<Outcome, Failure> {
        let Some((constant, factor)) = change else { return self.recovered(&self.built()?) };
        let path = self.tree.join(&constant.file);
        let text = std::fs::read_to_string(root().join(&constant.file))?;
        std::fs::write(&path, constant.changed(&text, factor)?)?;
        let outcome = self.built().and_then(|command| self.recovered(&command));
        std::fs::write(&path, text)?;
        outcome
    }

    /// The command of the copy.
    fn built(&self) -> Result<PathBuf, Failure> {
        let target = self.tree.join("target");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut build = Command::new(cargo);
        build.args(["build", "--release", "--package", "unrender"]);
        peers::said(build.current_dir(&self.tree).env("CARGO_TARGET_DIR", &target))?;
        Ok(target.join("release/unrender"))
    }

    fn recovered(&self, command: &Path) -> Result<Outcome, Failure> {
        let started = Instant::now();
        let out = self.tree.join("out");
        let (mut right, mut counted, mut rho_d) = (0, 0, Vec::new());
        for scene in &self.scenes {
            for seed in 0..self.seeds {
                let _ = std::fs::remove_dir_all(&out);
                let mut recover = Command::new(command);
                recover.arg("recover").arg(scene.join("project.toml")).arg("--out").arg(&out);
                recover.args(["--quiet", "--spp", "2", "--seed", &seed.to_string()]);
                // Scenes that are not recovered are wrong by the score.
                let _ = peers::said(&mut recover);
                let mut score = Command::new(command);
                score.arg("score").arg(&out).arg(scene.join("truth.json")).arg("--json");
                let score: Value = match peers::said(&mut score) {
                    Ok(text) => serde_json::from_str(&text)?,
                    Err(_) => Value::Null,
                };
                for group in score["groups"].as_array().into_iter().flatten() {
                    if group["counted"] != true {
                        continue;
                    }
                    counted += 1;
                    if group["hypothesis"] == group["true_hypothesis"] {
                        right += 1;
                        rho_d.extend(group["rho_d"].as_f64());
                    }
                }
            }
        }
        if counted == 0 {
            return Err("no scene was recovered".into());
        }
        let seconds = started.elapsed().as_secs_f64();
        Ok(Outcome { right, counted, rho_d: statistics::median(rho_d), seconds })
    }
}

/// Whether two files are equal: then the copy is kept, so that it is not built again.
fn is_alike(a: &Path, b: &Path) -> bool {
    match (std::fs::read(a), std::fs::read(b)) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}
