//! The key `camera` of a project file: a name, numbers, or the file of another program's calibration.

use super::raw::RawCamera;
use super::{CameraTable, Stand};
use glam::{DAffine3, DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::Value;
use unrender_formats::cameras::{self, Intrinsics, Pixels, colmap};
use unrender_scene::{Lens, UpAxis};

/// The name of a project's camera in messages.
pub(super) const NAME: &str = "project";

/// Which camera took the photograph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CameraChoice {
    /// The scene's first.
    First,
    /// The scene's camera of this name.
    Named(String),
    /// One that the project describes.
    Placed(CameraTable),
    /// The same in pixels of the photograph, whose size is not in the project.
    InPixels {
        /// Its pose.
        stand: Stand,
        /// Its focal lengths, axis and distortion.
        intrinsics: Intrinsics,
    },
    /// One that another program calibrated.
    Calibrated(CalibratedCamera),
}

/// A camera in the file of another program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibratedCamera {
    /// The file.
    pub file: CameraFile,
    /// From the world of the calibration to the scene: a similarity.
    pub scene_from_world: DAffine3,
    /// The pose, if the project states it instead of the file.
    pub stand: Option<Stand>,
    /// Where the upper left corner of the photograph lies in the picture of the calibration, pixels;
    /// none if the photograph is all of it, at any size.
    pub crop: Option<[f64; 2]>,
    /// The pixels of a turned photograph that it is for, if the project states them.
    pub pixels: Option<Pixels>,
}

/// The file of another program, and which of its cameras it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CameraFile {
    /// By OpenCV.
    Opencv {
        /// The file.
        path: PathBuf,
        /// Which of its poses, from zero.
        view: Option<usize>,
    },
    /// By COLMAP.
    Colmap {
        /// The file of cameras.
        cameras: PathBuf,
        /// The file of images.
        images: PathBuf,
        /// The image's name in it.
        image: String,
    },
}

impl CameraChoice {
    /// The axis of the scene that its pose says points upwards, if the project states the pose.
    pub(super) fn up_axis(&self) -> Option<UpAxis> {
        let (eye, target, up) = match self {
            Self::Placed(CameraTable { eye, target, up, .. }) => (eye, target, up),
            Self::InPixels { stand: Stand { eye, target, up, .. }, .. } => (eye, target, up),
            Self::First | Self::Named(_) | Self::Calibrated(_) => return None,
        };
        UpAxis::of_camera((*target - *eye).as_vec3().normalize_or_zero(), up.normalize_or_zero())
    }

    /// The files that it names, with their key.
    pub(super) fn files(&self) -> Vec<(&'static str, &Path)> {
        let Self::Calibrated(calibrated) = self else { return vec![] };
        match &calibrated.file {
            CameraFile::Opencv { path, .. } => vec![("camera.opencv", path)],
            CameraFile::Colmap { cameras, images, .. } => {
                vec![("camera.colmap", cameras), ("camera.colmap", images)]
            }
        }
    }
}

/// The key `camera`; files are relative to `folder`, and an image of COLMAP has the name of `photo`
/// by default; `up` is upwards in the picture if the table does not say it.
pub(super) fn parse(
    value: Value,
    (folder, photo): (&Path, &Path),
    up: UpAxis,
) -> Result<CameraChoice, String> {
    let table = match value {
        Value::String(name) => return Ok(CameraChoice::Named(name)),
        Value::Table(table) => table,
        _ => return Err("camera: give a name or a table with eye, target, up, fov_y_deg".into()),
    };
    let raw: RawCamera = table
        .try_into()
        .map_err(|error: toml::de::Error| format!("camera: {}", error.message()))?;
    match file(&raw, folder, photo)? {
        Some(file) => calibrated(&raw, file, up).map(CameraChoice::Calibrated),
        None => described(&raw, up),
    }
}

/// The file that the table names.
fn file(raw: &RawCamera, folder: &Path, photo: &Path) -> Result<Option<CameraFile>, String> {
    match (&raw.opencv, &raw.colmap) {
        (Some(_), Some(_)) => Err("camera: give opencv or colmap, not both".into()),
        (Some(path), None) if raw.image.is_none() => {
            Ok(Some(CameraFile::Opencv { path: folder.join(path), view: raw.view }))
        }
        (None, Some(path)) if raw.view.is_none() => {
            let [cameras, images] = colmap::files(&folder.join(path));
            let of_photo = || photo.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let image = raw.image.clone().unwrap_or_else(of_photo);
            Ok(Some(CameraFile::Colmap { cameras, images, image }))
        }
        (Some(_), None) => Err("camera.image: it is for colmap; view = 0 is for opencv".into()),
        (None, Some(_)) => {
            Err("camera.view: it is for opencv; image = \"name\" is for colmap".into())
        }
        (None, None) => Ok(None),
    }
}

fn calibrated(raw: &RawCamera, file: CameraFile, up: UpAxis) -> Result<CalibratedCamera, String> {
    let stated = [
        ("fov_y_deg", raw.fov_y_deg.is_some()),
        ("principal_point", raw.principal_point.is_some()),
        ("fx_over_fy", raw.fx_over_fy.is_some()),
    ];
    let pixels = raw.in_pixels().map(|(key, number)| (key, number.is_some()));
    let terms = raw.distortion().map(|(key, number)| (key, number.is_some()));
    let numbers = pixels.into_iter().chain(terms);
    if let Some((key, _)) = stated.into_iter().chain(numbers).find(|(_, is_there)| *is_there) {
        return Err(format!(
            "camera.{key}: the file states it; leave out {key}, or opencv and colmap"
        ));
    }
    let has_pose = raw.eye.is_some() || raw.target.is_some() || raw.up.is_some();
    if has_pose && matches!(file, CameraFile::Colmap { .. }) {
        return Err(
            "camera.eye: COLMAP's file states where the camera stood; leave out eye, target and \
             up, and transform its world to the scene by scene_from_world"
                .into(),
        );
    }
    if has_pose && raw.scene_from_world.is_some() {
        return Err(
            "camera.scene_from_world: it is for poses of a file; leave it out, or eye and \
                    target"
                .into(),
        );
    }
    if has_pose && raw.view.is_some() {
        return Err("camera.view: eye and target say where the camera stood; leave out view, or \
                    eye, target and up"
            .into());
    }
    let crop = raw.crop.filter(|crop| !crop.iter().all(|side| side.is_finite() && *side >= 0.0));
    if let Some([left, top]) = crop {
        return Err(format!(
            "camera.crop is [{left}, {top}]; it is the photo's upper left corner in the calibrated \
             picture, pixels from the corner of that"
        ));
    }
    Ok(CalibratedCamera {
        file,
        scene_from_world: scene_from_world(raw.scene_from_world.as_ref())?,
        stand: if has_pose { Some(stand(raw, up)?) } else { None },
        crop: raw.crop,
        pixels: raw.pixels.as_deref().map(which_pixels).transpose()?,
    })
}

fn which_pixels(word: &str) -> Result<Pixels, String> {
    match word {
        "stored" => Ok(Pixels::Stored),
        "upright" => Ok(Pixels::Upright),
        _ => Err(format!("camera.pixels is \"{word}\"; it is \"stored\" or \"upright\"")),
    }
}

fn scene_from_world(value: Option<&Value>) -> Result<DAffine3, String> {
    let fault = || {
        "camera.scene_from_world: give \"y-up\", \"z-up\", or a matrix as three or four rows of \
         four numbers"
            .to_owned()
    };
    let Some(value) = value else { return Ok(DAffine3::IDENTITY) };
    match value.as_str() {
        Some("y-up") => return Ok(DAffine3::IDENTITY),
        Some("z-up") => return Ok(cameras::Z_UP),
        Some(_) => return Err(fault()),
        None => (),
    }
    let double = |value: &Value| {
        value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
    };
    let row = |row: &Value| -> Option<[f64; 4]> {
        let numbers = row.as_array()?.iter().map(double).collect::<Option<Vec<f64>>>()?;
        numbers.try_into().ok()
    };
    let rows = value.as_array().map(|rows| rows.iter().map(row).collect::<Option<Vec<_>>>());
    let rows = rows.flatten().ok_or_else(fault)?;
    cameras::similarity(&rows).map_err(|problem| format!("camera.scene_from_world: {problem}"))
}

/// A camera in the project's own numbers.
fn described(raw: &RawCamera, up: UpAxis) -> Result<CameraChoice, String> {
    let of_files = [
        ("scene_from_world", raw.scene_from_world.is_some()),
        ("crop", raw.crop.is_some()),
        ("pixels", raw.pixels.is_some()),
        ("view", raw.view.is_some()),
        ("image", raw.image.is_some()),
    ];
    if let Some((key, _)) = of_files.into_iter().find(|(_, is_there)| *is_there) {
        return Err(format!("camera.{key}: it goes with a file; give opencv or colmap too"));
    }
    let lens = lens(raw)?;
    let pixels = raw.in_pixels().map(|(_, number)| number);
    match (raw.fov_y_deg, pixels) {
        (Some(fov_y_deg), [None, None, None, None]) => {
            if !(fov_y_deg > 0.0 && fov_y_deg < 180.0) {
                return Err(format!("camera.fov_y_deg is {fov_y_deg}; it is between 0 and 180"));
            }
            let Stand { eye, target, up, near } = stand(raw, up)?;
            Ok(CameraChoice::Placed(CameraTable { eye, target, up, fov_y_deg, lens, near }))
        }
        (None, [Some(fx), Some(fy), Some(cx), Some(cy)]) => {
            if raw.principal_point.is_some() || raw.fx_over_fy.is_some() {
                return Err(
                    "camera: fx, fy, cx and cy state principal_point and fx_over_fy already; leave \
                     these out"
                        .into(),
                );
            }
            if !(fx > 0.0 && fy > 0.0 && [fx, fy, cx, cy].iter().all(|side| side.is_finite())) {
                return Err(format!(
                    "camera: fx, fy, cx, cy are {fx}, {fy}, {cx}, {cy}; focal lengths are positive, \
                     and all are finite numbers of pixels"
                ));
            }
            let distortion = [lens.k1, lens.k2, lens.p1, lens.p2, lens.k3].map(f64::from);
            let intrinsics = Intrinsics { fx, fy, cx, cy, distortion, size: None };
            Ok(CameraChoice::InPixels { stand: stand(raw, up)?, intrinsics })
        }
        _ => Err("camera: give eye and target with fov_y_deg or with all of fx, fy, cx, cy; or a \
                  file, by opencv or colmap"
            .into()),
    }
}

/// The camera's centre, its target and upwards.
fn stand(raw: &RawCamera, usual: UpAxis) -> Result<Stand, String> {
    let (Some(eye), Some(target)) = (raw.eye, raw.target) else {
        return Err(
            "camera: eye and target are missing: give where it stood, and a point ahead".into()
        );
    };
    let [eye, target] = [eye, target].map(DVec3::from_array);
    let up = raw.up.map_or(usual.unit(), Vec3::from_array);
    let are_finite = [eye, target].iter().all(|place| place.as_vec3().is_finite());
    if !(are_finite && up.is_finite()) || eye == target {
        return Err("camera: eye and target must be two points".into());
    }
    let back = (eye - target).normalize_or_zero().as_vec3();
    let sideways = up.normalize_or_zero().cross(back);
    if sideways.length() < 1e-4 {
        return Err("camera.up: it must not point along the line of sight".into());
    }
    let near = raw.near.unwrap_or_default();
    if !(near.is_finite() && near >= 0.0) {
        return Err(format!("camera.near is {near}; it is a depth in metres, zero or more"));
    }
    Ok(Stand { eye, target, up, near })
}

fn lens(raw: &RawCamera) -> Result<Lens, String> {
    let principal_point = raw.principal_point.unwrap_or_default();
    if !principal_point.iter().all(|shift| shift.abs() <= 2.0) {
        return Err(format!(
            "camera.principal_point is {principal_point:?}; it is the offset from the picture's \
             centre, right and down, in heights of the picture"
        ));
    }
    for (name, k) in raw.distortion() {
        if k.is_some_and(|k| !k.is_finite()) {
            let k = k.unwrap_or_default();
            return Err(format!("camera.{name} is {k}; it is a finite number, mostly below one"));
        }
    }
    let fx_over_fy = raw.fx_over_fy.unwrap_or(1.0);
    if !(fx_over_fy.is_finite() && fx_over_fy > 0.0) {
        return Err(format!("camera.fx_over_fy is {fx_over_fy}; it is positive, and 1 is square"));
    }
    let [k1, k2, k3, p1, p2] = raw.distortion().map(|(_, k)| k.unwrap_or_default());
    Ok(Lens { principal_point, fx_over_fy, k1, k2, k3, p1, p2 })
}
