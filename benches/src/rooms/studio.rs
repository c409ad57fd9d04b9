//! Runs the scripts of `benches/rooms` with a Python that has Mitsuba.

use super::request::RoomsRequest;
use super::room::{Room, Rooms};
use super::score::{Forward, Score};
use crate::{Failure, peers, root};
use serde_json::Value;
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use unrender::formats::atomic;

/// Samples per pixel of a photograph: noise of 2 to 5 % a pixel in these rooms, as a camera has it. Half: no
/// texture of a dim surface is found any more; double: twice the minutes for each room.
const SPP: u32 = 512;
/// The same for a trial, which only tests the steps.
const QUICK_SPP: u32 = 64;

/// The version of `truth.py`: photographs of another one are taken anew.
const TRUTH: u32 = 2;

/// The scripts, and the folder of photographs and results.
pub(crate) struct Studio {
    python: PathBuf,
    kept: PathBuf,
    list: PathBuf,
    text: Value,
    spp: u32,
}

/// The folder of a room.
#[derive(Clone, Debug)]
pub(crate) struct Folder(PathBuf);

impl Folder {
    /// The scenes that `prepare.py` wrote.
    pub(crate) fn prepared(&self, file: &str) -> PathBuf {
        self.0.join("prepared").join(file)
    }

    /// The truth, as `truth.py` describes it.
    pub(crate) fn truth(&self, file: &str) -> PathBuf {
        self.0.join("truth").join(file)
    }

    /// The results.
    pub(crate) fn runs(&self, name: &str) -> PathBuf {
        self.0.join("runs").join(name)
    }
}

impl Studio {
    /// Finds or installs Mitsuba and tries it.
    ///
    /// # Errors
    /// If it is not to be had or does not run here.
    pub(crate) fn open(request: &RoomsRequest, rooms: &Rooms) -> Result<Self, Failure> {
        let python = peers::mitsuba::python().map_err(|problem| {
            format!("Mitsuba 3.9.1 is not installed and cannot be: {problem}")
        })?;
        let kept = std::path::absolute(request.kept())?;
        std::fs::create_dir_all(&kept)?;
        let list = kept.join("rooms.json");
        atomic::write(&list, serde_json::to_string_pretty(&rooms.text)?.as_bytes())?;
        let spp = if request.quick { QUICK_SPP } else { SPP };
        let studio = Self { python, kept, list, text: rooms.text.clone(), spp };
        studio.run("probe.py", &[]).map_err(|problem| {
            format!(
                "Mitsuba does not run here ({problem}). Its variant llvm_ad_rgb needs LLVM 16 or later, such as \
                 Debian's libllvm19; DRJIT_LIBLLVM_PATH names its libLLVM.so. The scripts also need numpy: remove {} \
                 to have both installed anew",
                studio.python.ancestors().nth(2).unwrap_or(&studio.python).display()
            )
        })?;
        Ok(studio)
    }

    /// Prepares and photographs a room, unless that was done.
    ///
    /// # Errors
    /// If a script fails.
    pub(crate) fn photograph(&self, room: &Room, trees: &Path) -> Result<Folder, Failure> {
        let folder = Folder(self.kept.join(&room.name));
        let record = folder.0.join("room.json");
        let wanted = self.recipe(room);
        let kept = std::fs::read_to_string(&record)
            .ok()
            .and_then(|text| serde_json::from_str::<Value>(&text).ok());
        if kept.as_ref() == Some(&wanted) && folder.truth("truth.json").is_file() {
            return Ok(folder);
        }
        if folder.0.exists() {
            std::fs::remove_dir_all(&folder.0)?;
        }
        let (prepared, truth) = (folder.prepared(""), folder.truth(""));
        let list: OsString = (&self.list).into();
        let name: OsString = (&room.name).into();
        self.run("prepare.py", &[list.clone(), name.clone(), trees.into(), (&prepared).into()])?;
        let spp = self.spp.to_string().into();
        self.run("photograph.py", &[list, name, prepared.into(), truth.into(), spp])?;
        atomic::write(&record, serde_json::to_string_pretty(&wanted)?.as_bytes())?;
        Ok(folder)
    }

    /// What determines the photographs of a room.
    fn recipe(&self, room: &Room) -> Value {
        let about = &self.text["rooms"][&room.name];
        let [file, size] = [&about["file"], &about["size"]];
        serde_json::json!({
            "file": file, "size": size, "new_view": about["new_view"], "new_light": about["new_light"],
            "spp": self.spp, "truth": TRUTH,
        })
    }

    /// Scores the result in `run` with re-renderings by name.
    ///
    /// # Errors
    /// If the script fails.
    pub(crate) fn score(
        &self,
        folder: &Folder,
        run: &Path,
        pictures: &[(&str, PathBuf)],
    ) -> Result<Score, Failure> {
        let mut words: Vec<OsString> = vec!["--result".into(), run.into()];
        words.extend(named("--picture", pictures));
        self.scored(folder, words, &run.join("score.json"))
    }

    /// A small picture for the page: the photograph, the new light, and `relit`, our picture in that light.
    ///
    /// # Errors
    /// If the script fails.
    pub(crate) fn show(&self, folder: &Folder, relit: &Path) -> Result<PathBuf, Failure> {
        let out = folder.runs("show.jpg");
        self.run("show.py", &[folder.truth("").into(), relit.into(), (&out).into()])?;
        Ok(out)
    }

    /// Compares our renderings of the true materials with Mitsuba's.
    ///
    /// # Errors
    /// If the script fails.
    pub(crate) fn forward(
        &self,
        folder: &Folder,
        pictures: &[(&str, PathBuf)],
    ) -> Result<BTreeMap<String, Forward>, Failure> {
        let out = folder.runs("forward.json");
        Ok(self.scored(folder, named("--forward", pictures), &out)?.forward)
    }

    /// Mitsuba's own inverse of so many seconds, scored like any other program.
    ///
    /// # Errors
    /// If a script fails.
    pub(crate) fn inverse(&self, folder: &Folder, seconds: f64) -> Result<Score, Failure> {
        let run = folder.runs(&format!("mitsuba_{seconds:.0}"));
        let map = |name: &str| -> OsString { run.join(name).into() };
        if !run.join("roughness.exr").is_file() {
            let words: [OsString; 4] = [
                folder.prepared("").into(),
                folder.truth("").into(),
                seconds.to_string().into(),
                (&run).into(),
            ];
            self.run("inverse.py", &words)?;
        }
        let words =
            vec!["--albedo".into(), map("albedo.exr"), "--roughness".into(), map("roughness.exr")];
        self.scored(folder, words, &run.join("score.json"))
    }

    /// Prepares and photographs a task with one unknown texture, unless that was done; its folder.
    ///
    /// # Errors
    /// If the script fails.
    pub(crate) fn one_texture(&self, task: &str, trees: &Path) -> Result<PathBuf, Failure> {
        let folder = self.kept.join("one_texture").join(task.replace(' ', "-"));
        if !folder.join("task.json").is_file() {
            self.run_task("make", task, &[trees.into(), (&folder).into()])?;
        }
        Ok(folder)
    }

    /// Mitsuba's own recovery of the texture in so many seconds.
    ///
    /// # Errors
    /// If the script fails.
    pub(crate) fn texture_by_mitsuba(
        &self,
        task: &str,
        folder: &Path,
        seconds: f64,
    ) -> Result<Value, Failure> {
        self.run_task("mitsuba", task, &[folder.into(), seconds.to_string().into()])?;
        json(&folder.join("mitsuba.json"))
    }

    /// The error of the texture in a result of unrender.
    ///
    /// # Errors
    /// If the script fails.
    pub(crate) fn texture_error(
        &self,
        task: &str,
        folder: &Path,
        run: &Path,
    ) -> Result<Value, Failure> {
        self.run_task("error", task, &[folder.into(), run.into()])?;
        json(&folder.join("error.json"))
    }

    fn run_task(&self, act: &str, task: &str, words: &[OsString]) -> Result<(), Failure> {
        let mut all: Vec<OsString> = vec![act.into(), (&self.list).into(), task.into()];
        all.extend_from_slice(words);
        self.run("one_texture.py", &all)
    }

    fn scored(&self, folder: &Folder, words: Vec<OsString>, out: &Path) -> Result<Score, Failure> {
        let mut all: Vec<OsString> = vec![folder.truth("").into()];
        all.extend(words);
        all.extend(["--out".into(), out.into()]);
        self.run("score.py", &all)?;
        Score::read(out)
    }

    /// Runs a script; its progress is shown.
    fn run(&self, script: &str, words: &[OsString]) -> Result<(), Failure> {
        let mut command = Command::new(&self.python);
        command.arg(root().join("benches/rooms").join(script)).args(words);
        // No compiled modules among the sources.
        command.env("PYTHONDONTWRITEBYTECODE", "1").stdin(Stdio::null());
        let ended =
            command.status().map_err(|error| format!("{}: {error}", self.python.display()))?;
        if ended.success() { Ok(()) } else { Err(format!("{script}: {ended}").into()) }
    }
}

/// `FLAG NAME=PATH` for each.
fn named(flag: &str, pictures: &[(&str, PathBuf)]) -> Vec<OsString> {
    let mut words = Vec::new();
    for (name, path) in pictures {
        let mut pair = OsString::from(format!("{name}="));
        pair.push(path);
        words.extend([flag.into(), pair]);
    }
    words
}

/// Reads a file of JSON.
pub(super) fn json(path: &Path) -> Result<Value, Failure> {
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(serde_json::from_str(&text)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "runs Mitsuba; .ci/programs installs it"]
    fn the_scripts_pass_their_own_tests() {
        let python = peers::mitsuba::python().unwrap();
        let script = root().join("benches/rooms/test_scripts.py");
        let mut command = Command::new(python);
        peers::said(command.arg(script).env("PYTHONDONTWRITEBYTECODE", "1")).unwrap();
    }

    #[test]
    fn pictures_are_named_on_the_command_line() {
        let words = named(
            "--picture",
            &[("new_view", PathBuf::from("a.exr")), ("new_light", "b.exr".into())],
        );
        assert_eq!(words, ["--picture", "new_view=a.exr", "--picture", "new_light=b.exr"]);
    }
}
