//! The photographs of a project, one at its top or several in `[[photos]]`, with the keys of each.

use super::raw::{RawProject, RawShot};
use super::values::triple;
use super::{CameraChoice, Frames, Project, ResponseChoice, VignettingChoice};
use super::{camera_choice, photograph};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use toml::Value;
use unrender_photo::Exposure;
use unrender_scene::{Rgb, Scene, UpAxis, Warnings};

/// One photograph and how it was taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Taken {
    /// As [`Project::photo`].
    pub photo: PathBuf,
    /// As [`Project::bracket`].
    pub bracket: Option<Frames>,
    /// As [`Project::mask`].
    pub mask: Option<PathBuf>,
    /// As [`Project::response`].
    pub response: Option<ResponseChoice>,
    /// As [`Project::black_level`].
    pub black_level: Rgb,
    /// As [`Project::white_level`].
    pub white_level: Option<Rgb>,
    /// As [`Project::vignetting`].
    pub vignetting: Option<VignettingChoice>,
    /// As [`Project::exposure`]; for a further photograph [`Exposure::Auto`] is relative to the
    /// first.
    pub exposure: Exposure,
    /// As [`Project::camera`].
    pub camera: CameraChoice,
    /// As [`Project::switched`].
    pub switched: Switched,
}

/// The lights that were switched for a photograph, by their names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Switched {
    /// These are off.
    Off(BTreeSet<String>),
    /// All others are off.
    On(BTreeSet<String>),
}

impl Default for Switched {
    fn default() -> Self {
        Self::Off(BTreeSet::new())
    }
}

impl Switched {
    /// The key in the project, and the names.
    pub(super) fn stated(&self) -> (&'static str, &BTreeSet<String>) {
        match self {
            Self::Off(names) => ("lights_off", names),
            Self::On(names) => ("lights_on", names),
        }
    }

    /// The sources of `scene` that are off, as [`unrender_scene::Source::index`] counts.
    pub(crate) fn off(&self, scene: &Scene) -> Vec<u32> {
        let is_off = |name: &str| match self {
            Self::Off(names) => names.contains(name),
            Self::On(names) => !names.contains(name),
        };
        let around = scene.environment_parts();
        let parts = |index: usize| match index == around.start {
            true => around.clone(),
            false => index..index + 1,
        };
        let off = scene.sources().filter(|source| is_off(source.name));
        off.flat_map(|source| parts(source.index)).map(|index| index as u32).collect()
    }
}

impl Project {
    /// How the first photograph was taken.
    fn first(&self) -> Taken {
        Taken {
            photo: self.photo.clone(),
            bracket: self.bracket.clone(),
            mask: self.mask.clone(),
            response: self.response.clone(),
            black_level: self.black_level,
            white_level: self.white_level,
            vignetting: self.vignetting,
            exposure: self.exposure,
            camera: self.camera.clone(),
            switched: self.switched.clone(),
        }
    }

    /// How each photograph was taken.
    pub fn photographs(&self) -> impl Iterator<Item = Taken> + '_ {
        std::iter::once(self.first()).chain(self.further.iter().cloned())
    }

    /// The same project with the further photograph `taken` alone.
    pub(crate) fn of_further(&self, taken: &Taken) -> Self {
        let Taken { photo, bracket, mask, response, black_level, .. } = taken.clone();
        let Taken { white_level, vignetting, exposure, camera, switched, .. } = taken.clone();
        Self {
            photo,
            bracket,
            mask,
            response,
            black_level,
            white_level,
            vignetting,
            exposure,
            camera,
            switched,
            further: Vec::new(),
            ..self.clone()
        }
    }
}

/// The most photographs of a project: this many of 12 megapixels take 20 GB before they are reduced to squares. Half
/// and double of it change nothing for projects with fewer.
const PHOTOGRAPHS_MAX: usize = 64;

/// The photographs of a project, at least one, in its order. `is_anchored`: whether a group fixes the scale.
pub(super) fn all(
    raw: &RawProject,
    folder: &Path,
    is_anchored: bool,
    warnings: &mut Warnings,
) -> Result<Vec<Taken>, String> {
    let (top, up) = (raw.top(), raw.up_axis.unwrap_or_default());
    let is_list = !raw.photos.is_empty();
    if raw.photos.len() > PHOTOGRAPHS_MAX {
        return Err(format!(
            "photos: there are {} of them; at most {PHOTOGRAPHS_MAX} are held in memory together",
            raw.photos.len()
        ));
    }
    if !is_list && top.photo.is_none() {
        let problem = "there is no photo; give photo = \"FILE\", or several in a list [[photos]]";
        return Err(problem.to_owned());
    }
    if is_list && top.photo.is_some() && raw.photos.iter().all(|shot| shot.photo.is_some()) {
        warnings.push("photo was not used, as each of [[photos]] names its own");
    }
    let shots: Vec<RawShot> = match is_list {
        false => vec![top],
        true => raw.photos.iter().map(|shot| shot.clone().or(&top)).collect(),
    };
    let is_any_stated = shots.iter().any(|shot| shot.exposure.is_some());
    if !is_any_stated && !is_anchored {
        warnings.push("the project states no exposure; 1.0 was taken");
    }
    let read = |(k, shot): (usize, &RawShot)| {
        let taken = taken(shot, folder, is_anchored, (k > 0, up));
        taken.map_err(|problem| {
            if is_list { format!("photos, number {}: {problem}", k + 1) } else { problem }
        })
    };
    let taken = shots.iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?;
    let is_auto = |taken: &Taken| taken.exposure == Exposure::Auto;
    if let Some(stated) = taken.iter().position(|taken| !is_auto(taken)).filter(|k| *k > 0) {
        return Err(format!(
            "photos: number {} states its exposure and number 1 does not; put a photograph with a \
             stated exposure first; the others are estimated relative to it",
            stated + 1
        ));
    }
    Ok(taken)
}

fn taken(
    raw: &RawShot,
    folder: &Path,
    is_anchored: bool,
    (is_further, up): (bool, UpAxis),
) -> Result<Taken, String> {
    let Some(photo) = &raw.photo else { return Err("give it a photo = \"FILE\"".to_owned()) };
    let (photo, bracket) = photograph::photo(photo, folder)?;
    let black_level = raw.black_level.as_ref();
    let black_level = black_level.map_or(Ok(Rgb::ZERO), photograph::black_level)?;
    let white_level = raw.white_level.as_ref();
    let white_level = white_level.map(|value| photograph::white_level(value, black_level));
    let names = |names: &Option<Vec<String>>| {
        names.as_ref().map(|names| names.iter().cloned().collect::<BTreeSet<String>>())
    };
    let switched = match (names(&raw.lights_off), names(&raw.lights_on)) {
        (Some(_), Some(_)) => return Err("give lights_off or lights_on, not both".to_owned()),
        (None, Some(on)) => Switched::On(on),
        (off, None) => Switched::Off(off.unwrap_or_default()),
    };
    Ok(Taken {
        mask: raw.mask.as_ref().map(|file| folder.join(file)),
        response: raw.response.as_ref().map(|r| photograph::response(r, folder)).transpose()?,
        black_level,
        white_level: white_level.transpose()?,
        vignetting: raw.vignetting.as_ref().map(photograph::vignetting).transpose()?,
        exposure: exposure(raw.exposure.as_ref(), is_anchored, is_further)?,
        camera: match raw.camera.clone() {
            Some(value) => camera_choice::parse(value, (folder, &photo), up)?,
            None => CameraChoice::First,
        },
        switched,
        photo,
        bracket,
    })
}

fn exposure(
    value: Option<&Value>,
    is_anchored: bool,
    is_further: bool,
) -> Result<Exposure, String> {
    let Some(value) = value else {
        return Ok(if is_anchored { Exposure::Auto } else { Exposure::Fixed(Rgb::ONE) });
    };
    match value.as_str() {
        Some("auto") if is_anchored || is_further => Ok(Exposure::Auto),
        Some("auto") => {
            Err("exposure: \"auto\" needs a table [anchor] with a group and its rho_d; nothing \
            else fixes the scale"
                .into())
        }
        Some(other) => Err(format!("exposure: there is no \"{other}\"; give a number or \"auto\"")),
        None => {
            let rgb = triple("exposure", value)?;
            if !rgb.is_finite() || rgb.min_element() <= 0.0 {
                return Err(format!("exposure is {value}; it must be positive"));
            }
            Ok(Exposure::Fixed(rgb))
        }
    }
}
