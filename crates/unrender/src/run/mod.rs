//! The file `run.json`: how a recovery went, as plain numbers; its keys are in
//! `docs/reference/run-json.md`.
//!
//! Reports are made from this file and the pictures that it names alone: every number on a page is
//! a field here.

mod camera;
mod environment;
mod group;
mod iteration;
mod pictures;
mod verdict;

pub(crate) use camera::{recovered_camera, recovered_size, recovered_up};
pub use environment::EnvironmentEntry;
pub(crate) use environment::{PANORAMA, recovered_environment, write_panorama};
pub use group::{ArtistEntry, CandidateEntry, DecisionEntry, LeftOut, MissEntry, RunGroup};
pub use iteration::{GroupIterationEntry, IterationEntry};
pub use pictures::{DifferenceEntry, ErrorPicture, PhotographRun, Pictures, Stop, Unit};
pub use verdict::{Ended, Verdict};

use crate::Error;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use unrender_formats::materials::{LightEntry, PhotographEntry};
use unrender_formats::{FileError, atomic};
use unrender_scene::UpAxis;

/// The version of the format that this crate writes.
pub const VERSION: u32 = 1;

/// A whole `run.json`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Run {
    /// [`VERSION`].
    pub version: u32,
    /// What made it.
    pub program: Program,
    /// The command line, word by word.
    pub command: Vec<String>,
    /// Its input.
    pub input: Input,
    /// How it was made.
    pub settings: SettingsEntry,
    /// Wall-clock seconds from the scene to the last picture.
    pub seconds: f64,
    /// The same per stage.
    pub stages: Stages,
    /// The peak memory of the process, bytes; null if the system does not report it.
    pub peak_memory_bytes: Option<u64>,
    /// Why it ended, a sentence.
    pub termination: String,
    /// Why it ended, a word; left out in older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ended: Option<Ended>,
    /// How many groups have which status.
    #[serde(default)]
    pub verdict: Verdict,
    /// Its warnings, a sentence each.
    pub warnings: Vec<String>,
    /// Scene radiance per unit of linear pixel value, by channel.
    pub exposure: [f32; 3],
    /// Its standard deviation, if the exposure was unknown.
    pub exposure_std: Option<[f32; 3]>,
    /// The photometric parameters, if they were unknown, as in `materials.json`.
    pub photograph: Option<PhotographEntry>,
    /// Each of several photographs, in the order of the project; left out if there is only one. Everything else here
    /// about one photograph is about the first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub photographs: Vec<PhotographRun>,
    /// How the model was registered with the photograph.
    pub registration: RegistrationEntry,
    /// How many pixels of all photographs were used, and how many were not, by reason.
    pub pixels: LeftOut,
    /// The pictures beside the file.
    pub pictures: Pictures,
    /// The global re-renderings in order.
    #[serde(alias = "turns")]
    pub iterations: Vec<IterationEntry>,
    /// The groups by name, in the order of the scene.
    pub groups: IndexMap<String, RunGroup>,
    /// The lights whose brightness was recovered, by name, in the order of the scene.
    pub lights: IndexMap<String, LightEntry>,
    /// The light from all around, as it was stated or recovered; left out if there was none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentEntry>,
}

/// The program that made the run.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Program {
    /// Its version.
    pub unrender: String,
    /// The operating system.
    pub system: String,
    /// The processor's architecture.
    pub processor: String,
}

/// The input of a run.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Input {
    /// The project file, as it was named.
    #[serde(serialize_with = "as_text")]
    pub project: PathBuf,
    /// The scene file.
    #[serde(serialize_with = "as_text")]
    pub scene: PathBuf,
    /// The photograph.
    #[serde(serialize_with = "as_text")]
    pub photo: PathBuf,
    /// The photographs from which it was merged; left out if it is a single one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bracket: Vec<PathBuf>,
    /// The environment in the project, in words; left out if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<String>,
    /// Which axis of the scene points upwards; left out if it is y.
    #[serde(default, skip_serializing_if = "is_y")]
    pub up_axis: UpAxis,
    /// The photograph's width, pixels.
    pub width: usize,
    /// The photograph's height, pixels.
    pub height: usize,
    /// The pixels that are counted here, and those of the pictures, are means of squares with this many of its pixels
    /// per side.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub side: usize,
}

fn one() -> usize {
    1
}

fn is_y(up: &UpAxis) -> bool {
    *up == UpAxis::Y
}

fn is_one(side: &usize) -> bool {
    *side == 1
}

/// The settings of a run.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct SettingsEntry {
    /// The form of Ward's lobe.
    pub brdf: String,
    /// The ladder: `default` or `paper`.
    pub ladder: String,
    /// How much work was spent: `draft`, `normal` or `high`; of older files `normal`.
    #[serde(default = "normal")]
    pub effort: String,
    /// Whether all numbers were refined together.
    pub refine: bool,
    /// The seed of the renderings' noise.
    pub seed: u64,
    /// Paths per pixel of the final re-rendering.
    pub spp: u32,
    /// The most reflections along a path.
    pub max_bounces: u32,
    /// Threads.
    pub threads: usize,
    /// The thresholds of the project file, by their names there.
    pub thresholds: IndexMap<String, f64>,
}

/// Wall-clock seconds by stage.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Stages {
    /// Preparing the scene and registering the model with the photograph.
    pub registration: f64,
    /// Finding the photometric parameters, if they were unknown.
    pub camera: f64,
    /// The ladder.
    pub ladder: f64,
    /// The refinement of all parameters together.
    pub refinement: f64,
    /// The last textures and the final picture.
    pub picture: f64,
}

/// How the model was registered with the photograph, and the camera that was used.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct RegistrationEntry {
    /// The camera, as in a project's `[camera]`.
    pub camera: serde_json::Value,
    /// How far the model's edges were from the photograph's with the camera as given, pixels; null
    /// if too few were found.
    pub displacement_pixels: Option<f32>,
    /// The uncertainty of the place where they fit, pixels.
    pub uncertainty_pixels: Option<f32>,
    /// How far edges are off with the better camera, pixels.
    pub deviation_pixels: Option<f32>,
    /// Points of edges that the photograph shows.
    pub confirmed_edge_points: Option<usize>,
}

/// The effort of older files.
fn normal() -> String {
    unrender_recover::Effort::Normal.name().to_owned()
}

/// A path as text; bytes that are not text become replacement characters.
fn as_text<S: serde::Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

impl Run {
    /// The name of the file in a folder of results.
    pub const FILE: &str = "run.json";

    /// Reads the run of the results in `folder`.
    ///
    /// # Errors
    /// If there is no run.json, or it is invalid or of a later version.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(Self::FILE);
        let text = unrender_formats::input::text(&path).map_err(|problem| {
            let problem = format!("{problem}; name a folder that recover wrote");
            FileError::new(&path, problem)
        })?;
        let mut run: Self =
            serde_json::from_str(&text).map_err(|error| FileError::new(&path, error))?;
        run.fill_in();
        if run.version > VERSION {
            let problem = format!("is of a later version than {VERSION}; use a newer unrender");
            return Err(FileError::new(&path, problem).into());
        }
        Ok(run)
    }

    /// The file's text.
    ///
    /// # Errors
    /// If a value cannot be written as JSON.
    pub fn to_text(&self) -> Result<String, Error> {
        serde_json::to_string_pretty(self)
            .map(|text| text + "\n")
            .map_err(|error| Error::Request(format!("{} cannot be written: {error}", Self::FILE)))
    }

    /// Writes the file into `folder`.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        Ok(atomic::write(&folder.join(Self::FILE), self.to_text()?.as_bytes())?)
    }
}
