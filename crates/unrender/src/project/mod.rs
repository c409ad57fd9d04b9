//! The project file: the scene, the photographs, and what is known already.
//!
//! `parse` turns the text into a [`Project`] and checks every number; names are checked against
//! the scene by [`Project::check_against`], once that is read.

mod calibrated;
mod camera;
mod camera_choice;
mod expected;
mod known;
mod lights;
mod like;
mod parse;
mod photograph;
mod raw;
mod rungs;
mod taken;
mod values;

pub(crate) use calibrated::{Found, Photographed};
pub use camera::{CameraTable, Stand};
pub use camera_choice::{CalibratedCamera, CameraChoice, CameraFile};
pub use known::{Known, KnownFile};
pub use lights::LightColor;
pub use like::LikeGroup;
pub(crate) use photograph::seconds;
pub use photograph::{Frames, ResponseChoice, VignettingChoice};
pub(crate) use rungs::up_to;
pub use taken::{Switched, Taken};

use crate::lighting::EnvironmentChoice;
use crate::text_file;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use unrender_formats::{FileError, Input, LightUnits, Limits};
use unrender_photo::Exposure;
use unrender_recover::{Expected, Thresholds};
use unrender_restage::light::LightEdit;
use unrender_scene::{BrdfModel, Hypothesis, Layering, Rgb, Scene, UpAxis, Warnings};

/// A project file with absolute paths and checked numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Project {
    /// The project file itself.
    pub path: PathBuf,
    /// The scene file.
    pub scene: PathBuf,
    /// The photograph; the first one of a bracket.
    pub photo: PathBuf,
    /// The bracket from which the photograph is merged, if any.
    pub bracket: Option<Frames>,
    /// The mask: pixels of the photograph that are black in it are left out.
    pub mask: Option<PathBuf>,
    /// The response of the photograph, if the project states it.
    pub response: Option<ResponseChoice>,
    /// The code of no light, 0 to 1, by channel.
    pub black_level: Rgb,
    /// The code from which on a channel is clipped, if the project states it.
    pub white_level: Option<Rgb>,
    /// The vignetting of the photograph, if the project states it.
    pub vignetting: Option<VignettingChoice>,
    /// Scene radiance per unit of linear pixel value.
    pub exposure: Exposure,
    /// What fixes the absolute scale; always present with [`Exposure::Auto`]. See
    /// [`Project::used_anchor`].
    pub anchor: Option<Anchor>,
    /// The groups that are not to be recovered.
    pub known: BTreeMap<String, Known>,
    /// The groups that are not recovered and whose pixels are left out; those that are not known
    /// keep the materials of the scene.
    pub ignored: BTreeSet<String>,
    /// The lights of unknown brightness: groups that emit, and lights without a surface.
    pub unknown_lights: BTreeSet<String>,
    /// The lights that the project calls known, as lights are by default.
    pub known_lights: BTreeSet<String>,
    /// The colours of unknown lights, if the project states them: only their brightness is recovered.
    pub light_colors: BTreeMap<String, LightColor>,
    /// The lights that are added, changed or removed.
    pub light_edits: Vec<LightEdit>,
    /// The IES files of these lights.
    pub light_profiles: Vec<PathBuf>,
    /// The environment, if the project states it.
    pub environment: Option<EnvironmentChoice>,
    /// The BRDF model to recover, if the project states it; else it is the scene's.
    pub brdf: Option<BrdfModel>,
    /// How bases lie under dielectrics, if the project states it; else as the scene's format has it.
    pub layering: Option<Layering>,
    /// The thresholds of model selection.
    pub thresholds: Thresholds,
    /// Those of the paper's method, as in [`unrender_paper::Paper::thresholds`].
    pub paper_thresholds: [f64; 6],
    /// The hypotheses that groups may have, if the project states them.
    pub rungs: Option<Vec<Hypothesis>>,
    /// The same for single groups.
    pub group_rungs: BTreeMap<String, Vec<Hypothesis>>,
    /// Bounds and initial values of the parameters of groups.
    pub expected: BTreeMap<String, Expected>,
    /// The groups that are like another.
    pub like: BTreeMap<String, LikeGroup>,
    /// The groups that share the material of another, and that other's name.
    pub same_as: BTreeMap<String, String>,
    /// The camera of the photograph.
    pub camera: CameraChoice,
    /// The lights that were off when the photograph was taken; all are on if there is only one photograph.
    pub switched: Switched,
    /// The further photographs, if there are several: the fields above describe the first.
    pub further: Vec<Taken>,
    /// The units of the scene's lights, if the project states them.
    pub light_units: Option<LightUnits>,
    /// Which axis of the scene points upwards: as stated, or as the camera says.
    pub up_axis: UpAxis,
    /// The limits of reading the files that it names; not a key of the file.
    pub limits: Limits,
}

/// A group whose diffuse reflectance fixes the scale of exposure and lights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// The group's name.
    pub group: String,
    /// Its diffuse reflectance.
    pub rho_d: Rgb,
}

impl Project {
    /// Reads the project file at `path` and checks it as far as possible without the scene.
    ///
    /// # Errors
    /// If the file is missing, is not TOML, has an unknown key or an invalid value, or names a file
    /// that does not exist.
    pub fn read(path: &Path) -> Result<(Self, Warnings), FileError> {
        let text = text_file::read(path, text_file::Expected::Project)?;
        let (project, warnings) = Self::parse(path, &text)?;
        for (key, file) in project.files() {
            if !file.is_file() {
                let problem = format!("{key}: there is no file {}", file.display());
                return Err(FileError::new(path, problem));
            }
        }
        Ok((project, warnings))
    }

    /// As [`Project::read`] from the file's text, without reading the files that it names.
    ///
    /// ```
    /// use std::path::Path;
    /// use unrender::Project;
    ///
    /// let text = "scene = \"room.glb\"\nphoto = \"room.png\"\nexposure = 1\n";
    /// let (project, warnings) = Project::parse(Path::new("here/room.toml"), text)?;
    /// assert_eq!(project.scene, Path::new("here/room.glb"));
    /// let fault = Project::parse(Path::new("room.toml"), "scene = 3\n").unwrap_err();
    /// assert!(fault.to_string().contains("line 1"), "{fault}");
    /// # Ok::<(), unrender::formats::FileError>(())
    /// ```
    ///
    /// # Errors
    /// If the text is not TOML, has an unknown key or an invalid value.
    pub fn parse(path: &Path, text: &str) -> Result<(Self, Warnings), FileError> {
        parse::parse(path, text).map_err(|problem| FileError::new(path, problem))
    }

    /// The hypotheses that `group` may have.
    pub fn rungs_of(&self, group: &str) -> Vec<Hypothesis> {
        let stated = self.group_rungs.get(group).or(self.rungs.as_ref());
        stated.cloned().unwrap_or_else(|| Hypothesis::ALL.to_vec())
    }

    /// The scene file with its limits and units.
    pub(crate) fn scene_input(&self) -> Input<'_> {
        let input = Input::new(&self.scene, self.limits).in_light_units(self.light_units);
        self.brdf.map_or(input, |brdf| input.with_brdf(brdf))
    }

    /// The files that a recovery of it reads, as far as the project names them.
    pub fn inputs(&self) -> Vec<&Path> {
        let files = self.files().into_iter().map(|(_, file)| file);
        std::iter::once(self.path.as_path()).chain(files).collect()
    }

    /// The files that it names, each with its key.
    fn files(&self) -> Vec<(&'static str, &Path)> {
        let panorama = self.environment.as_ref().and_then(EnvironmentChoice::file);
        let panorama = panorama.map(|file| ("environment.panorama", file));
        let of = |photo| (photo, &self.bracket, &self.mask);
        let first = files_of(of(self.photo.as_path()), &self.response, &self.camera);
        let further = self.further.iter().flat_map(|taken| {
            let of = (taken.photo.as_path(), &taken.bracket, &taken.mask);
            files_of(of, &taken.response, &taken.camera)
        });
        let known = self.known.values().filter_map(|known| known.file.as_ref());
        let known = known.map(|file| ("known", file.path()));
        let always = std::iter::once(("scene", self.scene.as_path()));
        let profiles = self.light_profiles.iter().map(|file| ("lights.profile", file.as_path()));
        let further_of = panorama.into_iter().chain(profiles).chain(known);
        let mut files: Vec<_> = always.chain(first).chain(further_of).collect();
        for file in further {
            // A file may be named for several photographs.
            if !files.contains(&file) {
                files.push(file);
            }
        }
        files
    }

    /// Checks that the names in the project are names in `scene`.
    ///
    /// # Errors
    /// If a group, a light or a camera does not exist, or the anchor is a light.
    pub fn check_against(&self, scene: &Scene) -> Result<(), FileError> {
        let fault = |problem: String| Err(FileError::new(&self.path, problem));
        let known = self.known.keys().map(|name| (format!("groups.{name}"), name));
        let anchor = self.anchor.iter().map(|a| ("anchor.group".to_owned(), &a.group));
        let rungs = self.group_rungs.keys().map(|name| (format!("groups.{name}"), name));
        let same = self.same_as.iter().flat_map(|(name, other)| {
            [(format!("groups.{name}"), name), (format!("groups.{name}.same_as"), other)]
        });
        let ignored = self.ignored.iter().map(|name| (format!("groups.{name}"), name));
        let expected = self.expected.keys().map(|name| (format!("groups.{name}"), name));
        let like = self.like.iter().flat_map(|(name, like)| {
            [(format!("groups.{name}"), name), (format!("groups.{name}.like"), &like.group)]
        });
        let named = known.chain(anchor).chain(rungs).chain(ignored).chain(same);
        for (key, name) in named.chain(expected).chain(like) {
            if scene.ungrouped.iter().any(|shape| shape.material == *name)
                && scene.group_index(name).is_none()
            {
                return fault(format!(
                    "{key}: \"{name}\" is glass, which is rendered as the scene's file says and not recovered; leave it out \
                     here"
                ));
            }
            if scene.group_index(name).is_none() {
                let names = scene.groups.iter().map(|g| g.name.as_str());
                let there = some_names(names);
                return fault(format!("{key}: the scene has no group \"{name}\"; it has {there}"));
            }
        }
        let anchor = self.anchor.as_ref().and_then(|a| scene.group_index(&a.group));
        if anchor.is_some_and(|index| scene.groups[index].is_emitter()) {
            return fault(
                "anchor.group: the group emits light; take one that only reflects".into(),
            );
        }
        let emits = |name: &String| {
            scene.group_index(name).is_some_and(|index| scene.groups[index].is_emitter())
        };
        if let Some((name, _)) = self.same_as.iter().find(|(a, b)| emits(a) || emits(b)) {
            return fault(format!(
                "groups.{name}.same_as: one of the two emits light; only groups that reflect can \
                 share a material"
            ));
        }
        if let Some(name) = self.expected.keys().find(|name| emits(name)) {
            return fault(format!(
                "groups.{name}: the group emits light, and its reflectance is not recovered; leave \
                 out its bounds and starts"
            ));
        }
        if let Some((name, _)) = self.like.iter().find(|(a, b)| emits(a) || emits(&b.group)) {
            return fault(format!(
                "groups.{name}.like: one of the two emits light; only groups that reflect can be alike"
            ));
        }
        lights::check(self, scene).or_else(fault)?;
        let cameras = std::iter::once(&self.camera);
        for camera in cameras.chain(self.further.iter().map(|taken| &taken.camera)) {
            if let CameraChoice::Named(name) = camera
                && !scene.cameras.iter().any(|c| c.name == *name)
            {
                let there = some_names(scene.cameras.iter().map(|c| c.name.as_str()));
                return fault(format!("camera: the scene has no \"{name}\"; it has {there}"));
            }
        }
        Ok(())
    }
}

/// The files that are named for one photograph, each with its key.
fn files_of<'a>(
    (photo, bracket, mask): (&'a Path, &'a Option<Frames>, &'a Option<PathBuf>),
    response: &'a Option<ResponseChoice>,
    camera: &'a CameraChoice,
) -> impl Iterator<Item = (&'static str, &'a Path)> {
    let response = match response {
        Some(ResponseChoice::Measured(file)) => Some(("response", file.as_path())),
        _ => None,
    };
    let mask = mask.as_deref().map(|file| ("mask", file));
    let photos = match bracket {
        Some(frames) => frames.files.iter().map(|f| ("photo.bracket", f.as_path())).collect(),
        None => vec![("photo", photo)],
    };
    photos.into_iter().chain(mask).chain(response).chain(camera.files())
}

/// Up to a dozen names for a message.
pub(crate) fn some_names<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<&str> = names.collect();
    match names.len() {
        0 => "none".to_owned(),
        count if count > SHOWN => {
            format!("{} and {} more", names[..SHOWN].join(", "), count - SHOWN)
        }
        _ => names.join(", "),
    }
}
