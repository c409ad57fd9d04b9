//! Runs unrender on a prepared room.

use super::request::{Input, Photo};
use super::room::Room;
use super::studio::Folder;
use crate::Failure;
use crate::command::Unrender;
use crate::corpus::recover::{self, Outcome, Subject};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use unrender::formats::atomic;

/// Samples per pixel of our pictures. At a quarter of it their noise is a third of what is scored at the true materials; double
/// takes twice the seconds.
const SPP: u32 = 128;

/// What unrender is given of a room.
pub(crate) struct Given<'a> {
    room: &'a Room,
    folder: &'a Folder,
    input: Input,
    brdf: Option<&'a str>,
    /// The radiance of white in the PNG.
    exposure: f64,
    /// Cut-out groups, which are neither used nor scored.
    masks: Vec<String>,
}

impl<'a> Given<'a> {
    /// Reads what the project states of the photograph.
    ///
    /// # Errors
    /// If the truth cannot be read.
    pub(crate) fn new(
        room: &'a Room,
        folder: &'a Folder,
        input: Input,
        brdf: Option<&'a str>,
    ) -> Result<Self, Failure> {
        let about: Value =
            serde_json::from_str(&std::fs::read_to_string(folder.truth("truth.json"))?)?;
        let exposure = about["exposure"].as_f64().ok_or("truth.json states no exposure")?;
        let groups: Value =
            serde_json::from_str(&std::fs::read_to_string(folder.prepared("groups.json"))?)?;
        let groups = groups["groups"].as_object().ok_or("groups.json has no groups")?;
        let masks = groups.iter().filter(|(_, about)| about["left_out"] == "mask");
        let masks = masks.map(|(name, _)| name.clone()).collect();
        Ok(Self { room, folder, input, brdf, exposure, masks })
    }

    /// The folder of the room.
    pub(crate) fn folder(&self) -> &Folder {
        self.folder
    }

    /// The scene file of a purpose.
    fn scene(&self, name: &str) -> PathBuf {
        let file = match (self.input, name.strip_prefix("truth")) {
            (Input::Prepared, _) => format!("{name}.xml"),
            (Input::Published, Some(rest)) => format!("published{rest}.xml"),
            (Input::Published, None) => format!("published_{name}.xml"),
        };
        self.folder.prepared(&file)
    }

    /// The project for a photograph.
    fn project(&self, photo: Photo) -> String {
        let path = |path: PathBuf| toml_text(&path.display().to_string());
        let mut text = format!(
            "scene = {}\nphoto = {}\nmask = {}\ncamera = \"photo\"\n",
            path(self.scene("given")),
            path(self.folder.truth(&format!("photo.{}", photo.name()))),
            path(self.folder.truth("mask.png")),
        );
        text += &match photo {
            Photo::Exr => "response = \"linear\"\nexposure = 1.0\n".to_owned(),
            Photo::Png => format!("response = \"srgb\"\nexposure = {:?}\n", self.exposure),
        };
        if let Some(brdf) = self.brdf {
            let _ = write!(text, "\n[recover]\nbrdf = {}\n", toml_text(brdf));
        }
        for mask in &self.masks {
            let _ = write!(text, "\n[groups.{}]\nignore = true\n", toml_text(mask));
        }
        text
    }

    /// Recovers from a photograph, or reads the earlier result; its folder and outcome.
    ///
    /// # Errors
    /// If the command cannot be started.
    pub(crate) fn recover(
        &self,
        subject: &Subject,
        photo: Photo,
        again: bool,
    ) -> Result<(PathBuf, Outcome), Failure> {
        let text = self.project(photo);
        let name = format!("{}_{}_{:08x}", photo.name(), subject.key, fingerprint(&text));
        let project = self.folder.runs(&format!("{name}.toml"));
        let run = self.folder.runs(&name);
        std::fs::create_dir_all(self.folder.runs(""))?;
        atomic::write(&project, text.as_bytes())?;
        let outcome = recover::recover_at(&project, &run, subject, again)?;
        Ok((run, outcome))
    }

    /// The recovered materials from the new view and in the new light.
    ///
    /// # Errors
    /// If rendering fails.
    pub(crate) fn render_result(
        &self,
        command: &Unrender,
        run: &Path,
    ) -> Result<Vec<(&'static str, PathBuf)>, Failure> {
        let materials = run.display().to_string();
        let shots = [("new_view", "given", "new-view"), ("new_light", "given_new_light", "photo")];
        let mut pictures = Vec::new();
        for (name, scene, camera) in shots {
            // Beside the result: a folder of results holds nothing else.
            let out = run.with_extension(format!("{name}.exr"));
            if !newer(&out, &run.join("materials.json")) {
                self.render(command, scene, camera, &["--materials", &materials], &out)?;
            }
            pictures.push((name, out));
        }
        Ok(pictures)
    }

    /// The true materials as unrender reads them, in the three pictures of the room.
    ///
    /// # Errors
    /// If the scene is refused.
    pub(crate) fn render_truth(
        &self,
        command: &Unrender,
        subject: &Subject,
    ) -> Result<Vec<(&'static str, PathBuf)>, Failure> {
        let mut pictures = Vec::new();
        std::fs::create_dir_all(self.folder.runs(""))?;
        let shots = [
            ("photo", "truth", "photo"),
            ("new_view", "truth", "new-view"),
            ("new_light", "truth_new_light", "photo"),
        ];
        for (name, scene, camera) in shots {
            let out = self.folder.runs(&format!("{name}_{}.exr", subject.key));
            if !newer(&out, &self.scene(scene)) {
                self.render(command, scene, camera, &[], &out)?;
            }
            pictures.push((name, out));
        }
        Ok(pictures)
    }

    fn render(
        &self,
        command: &Unrender,
        scene: &str,
        camera: &str,
        further: &[&str],
        out: &Path,
    ) -> Result<(), Failure> {
        let mut flags = vec!["--camera", camera, "--allow-outside"];
        flags.extend(further);
        command.render(&self.scene(scene), self.room.size, SPP, out, &flags)?;
        Ok(())
    }
}

/// Whether `path` was written after `other`.
fn newer(path: &Path, other: &Path) -> bool {
    let time = |path: &Path| path.metadata().and_then(|about| about.modified()).ok();
    matches!((time(path), time(other)), (Some(a), Some(b)) if a >= b)
}

/// A key of a text.
fn fingerprint(text: &str) -> u64 {
    use std::hash::{DefaultHasher, Hash, Hasher};
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    hasher.finish() >> 32
}

/// A string of TOML.
fn toml_text(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_those_of_toml() {
        assert_eq!(toml_text(r#"a "b\c"#), r#""a \"b\\c""#);
        assert_ne!(fingerprint("a"), fingerprint("b"));
    }
}
