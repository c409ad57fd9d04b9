//! fSpy's project files (fspy.io): the camera that somebody matched to a photograph by hand.
//!
//! The file is `fspy`, the version 1, the sizes of the JSON and of the photograph (both as 32-bit
//! little-endian numbers), the JSON, the photograph. Of the JSON this is read:
//!
//! - `cameraParameters`: `cameraTransform`, camera to world by rows, a camera that looks along its
//!   own -z with +y upwards, as glTF's does; `horizontalFieldOfView`, radians, of a centred pinhole;
//!   `principalPoint`, from the picture's centre to the right and upwards, where half of the longer
//!   side is one;
//! - `calibrationSettingsBase`: `referenceDistanceUnit`, the unit of its lengths, and
//!   `referenceDistanceAxis`, without which they mean nothing.
//!
//! Which of fSpy's axes points upwards is up to whoever labelled the vanishing points; see [`Up`].
//! Sources: fSpy's `project_file_format.md`, and what its own importer for Blender makes of it.

use crate::{FileError, input};
use glam::{Affine3A, DMat3, DVec3, Mat3};
use serde::Deserialize;
use std::path::Path;
use unrender_scene::{Camera, Lens, Warnings};

const MAGIC: &[u8; 4] = b"fspy";
const VERSION: u32 = 1;
const HEADER: usize = 16;
/// The camera's axes are perpendicular unit vectors up to this.
const RIGID: f64 = 1e-3;

/// Which of fSpy's axes points upwards in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// Its y: its axes are ours.
    Y,
    /// Its z, as in Blender: its (x, y, z) is our (x, z, -y), as Blender's glTF exporter has it.
    Z,
}

/// What an fSpy project says.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Matched {
    /// The camera, in our axes, in metres.
    pub camera: Camera,
    /// The photograph's size, pixels.
    pub size: (usize, usize),
    /// The axis that was taken to point upwards.
    pub up: Up,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct State {
    camera_parameters: Option<Parameters>,
    calibration_settings_base: Option<Settings>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Parameters {
    principal_point: Point,
    camera_transform: Transform,
    horizontal_field_of_view: f64,
    image_width: usize,
    image_height: usize,
}

#[derive(Deserialize)]
struct Point {
    x: f64,
    y: f64,
}

#[derive(Deserialize)]
struct Transform {
    rows: [[f64; 4]; 4],
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Settings {
    reference_distance_unit: Option<String>,
    reference_distance_axis: Option<String>,
}

/// Reads the fSpy project at `path`. Without `up`, that of fSpy's y and z is taken that is nearer
/// to the picture's upwards.
///
/// # Errors
/// If the file cannot be read, is no fSpy project of version 1, or has no valid camera.
pub fn read(path: &Path, up: Option<Up>) -> Result<(Matched, Warnings), FileError> {
    let bytes = input::read(path).map_err(|error| FileError::because(path, "", error))?;
    parse(&bytes, up).map_err(|problem| FileError::new(path, problem))
}

/// As [`read`], from the bytes of the file.
///
/// # Errors
/// As [`read`], in words without the file's name.
pub fn parse(bytes: &[u8], up: Option<Up>) -> Result<(Matched, Warnings), String> {
    let state = state(bytes)?;
    let parameters = state.camera_parameters.ok_or(
        "has no camera, as the vanishing points were not valid; mend them in fSpy and save again",
    )?;
    let (width, height) = (parameters.image_width, parameters.image_height);
    let fov_x = parameters.horizontal_field_of_view;
    if width == 0 || height == 0 || !(fov_x > 0.0 && fov_x < std::f64::consts::PI) {
        return Err("has a camera without a picture or a field of view; save it again".into());
    }
    let (axes, eye) = rigid(&parameters.camera_transform.rows)?;
    let mut warnings = Warnings::default();
    let metres = metres(state.calibration_settings_base.as_ref(), &mut warnings);
    let upwards = axes.y_axis;
    let up = up.unwrap_or(if upwards.z.abs() > upwards.y.abs() { Up::Z } else { Up::Y });
    let ours_from_fspy = match up {
        Up::Y => DMat3::IDENTITY,
        Up::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    };
    let axes: Mat3 = (ours_from_fspy * axes).as_mat3();
    let eye = (ours_from_fspy * eye * metres).as_vec3();
    let (width_px, height_px) = (width as f64, height as f64);
    let focal_px = 0.5 * width_px / (0.5 * fov_x).tan();
    let unit_px = 0.5 * width_px.max(height_px);
    let Point { x: right, y: above } = parameters.principal_point;
    let principal_point = [right, -above].map(|shift| (shift * unit_px / height_px) as f32);
    let camera = Camera {
        name: "fspy".into(),
        world_from_camera: Affine3A::from_mat3_translation(axes, eye),
        fov_y_rad: (2.0 * (0.5 * height_px / focal_px).atan()) as f32,
        aspect: Some((width_px / height_px) as f32),
        lens: Lens { principal_point, ..Lens::default() },
    };
    Ok((Matched { camera, size: (width, height), up }, warnings))
}

/// The JSON, read.
fn state(bytes: &[u8]) -> Result<State, String> {
    let word = |at: usize| {
        let four = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(four.try_into().ok()?))
    };
    if !bytes.starts_with(MAGIC) {
        return Err("is not an fSpy project: it does not start with \"fspy\"".into());
    }
    let cut_short = || "is cut short; save it again in fSpy".to_owned();
    let version = word(4).ok_or_else(cut_short)?;
    if version != VERSION {
        return Err(format!("is an fSpy project of version {version}; only version 1 is read"));
    }
    let size = word(8).ok_or_else(cut_short)? as usize;
    let json = bytes.get(HEADER..).and_then(|rest| rest.get(..size)).ok_or_else(cut_short)?;
    serde_json::from_slice(json)
        .map_err(|error| format!("has no valid project data ({error}); save it again in fSpy"))
}

/// The camera's axes and its place, from the rows of camera to world.
fn rigid(rows: &[[f64; 4]; 4]) -> Result<(DMat3, DVec3), String> {
    let row = |n: usize| DVec3::from_slice(&rows[n]);
    let axes = DMat3::from_cols(row(0), row(1), row(2)).transpose();
    let eye = DVec3::new(rows[0][3], rows[1][3], rows[2][3]);
    let off = axes.transpose() * axes - DMat3::IDENTITY;
    let is_rigid = off.to_cols_array().iter().all(|e| e.abs() < RIGID) && axes.determinant() > 0.0;
    if !(is_rigid && eye.is_finite()) {
        return Err("has a camera that is mirrored, scaled or nowhere; mend the vanishing points \
                    in fSpy and save again"
            .into());
    }
    Ok((axes, eye))
}

/// How many metres fSpy's unit of length has.
fn metres(settings: Option<&Settings>, warnings: &mut Warnings) -> f64 {
    if settings.is_some_and(|settings| settings.reference_distance_axis.is_none()) {
        warnings.push(
            "the fSpy project has no reference distance, so the camera's distance from its origin \
             means nothing; set one in fSpy",
        );
        return 1.0;
    }
    let unit = settings.and_then(|settings| settings.reference_distance_unit.as_deref());
    match unit {
        Some("Millimeters") => 1e-3,
        Some("Centimeters") => 1e-2,
        Some("Meters") => 1.0,
        Some("Kilometers") => 1e3,
        Some("Inches") => 0.0254,
        Some("Feet") => 0.3048,
        Some("Yards") => 0.9144,
        Some("Miles") => 1609.344,
        _ => {
            warnings.push("the lengths in the fSpy project have no unit; metres were taken");
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use serde_json::{Value, json};

    /// The bytes of a project file.
    fn file(state: &Value) -> Vec<u8> {
        let json = serde_json::to_vec(state).unwrap();
        let picture = b"a picture";
        let mut bytes = b"fspy".to_vec();
        for word in [1, json.len() as u32, picture.len() as u32] {
            bytes.extend_from_slice(&word.to_le_bytes());
        }
        bytes.extend_from_slice(&json);
        bytes.extend_from_slice(picture);
        bytes
    }

    /// A camera two units above fSpy's z = 0 that looks along its +y.
    fn project() -> Value {
        json!({
            "cameraParameters": {
                "principalPoint": { "x": 0.1, "y": 0.05 },
                "cameraTransform": { "rows": [
                    [1.0, 0.0, 0.0, 3.0], [0.0, 0.0, -1.0, -5.0], [0.0, 1.0, 0.0, 2.0],
                    [0.0, 0.0, 0.0, 1.0]] },
                "horizontalFieldOfView": 2.0 * (0.5f64).atan(),
                "imageWidth": 800, "imageHeight": 600,
            },
            "calibrationSettingsBase": {
                "referenceDistanceUnit": "Centimeters", "referenceDistanceAxis": "zPositive",
            },
        })
    }

    #[test]
    fn a_camera_of_z_up_becomes_one_of_y_up_in_metres() {
        let (matched, warnings) = parse(&file(&project()), None).unwrap();
        assert_eq!((matched.up, matched.size, warnings.0.len()), (Up::Z, (800, 600), 0));
        let camera = &matched.camera;
        assert!((camera.origin() - Vec3::new(0.03, 0.02, 0.05)).length() < 1e-6);
        let axis = camera.principal_point(800, 600);
        assert!((axis.0 - 440.0).abs() < 1e-3 && (axis.1 - 280.0).abs() < 1e-3, "{axis:?}");
        let ahead = camera.direction(axis.0, axis.1, 800, 600);
        assert!((ahead - Vec3::NEG_Z).length() < 1e-5, "{ahead}");
        // The focal length is the picture's width; 45 degrees up are 800 pixels.
        let (x, y) = (440.0, 280.0 - 800.0);
        let up = camera.direction(x, y, 800, 600);
        assert!((up - Vec3::new(0.0, 1.0, -1.0).normalize()).length() < 1e-5, "{up}");
    }

    #[test]
    fn the_axes_may_be_stated() {
        let (matched, _) = parse(&file(&project()), Some(Up::Y)).unwrap();
        assert!((matched.camera.origin() - 0.01 * Vec3::new(3.0, -5.0, 2.0)).length() < 1e-6);
    }

    #[test]
    fn lengths_without_meaning_are_reported() {
        let mut state = project();
        state["calibrationSettingsBase"]["referenceDistanceUnit"] = json!("No unit");
        assert!(parse(&file(&state), None).unwrap().1.0[0].contains("metres were taken"));
        state["calibrationSettingsBase"]["referenceDistanceAxis"] = Value::Null;
        assert!(parse(&file(&state), None).unwrap().1.0[0].contains("no reference distance"));
    }

    #[test]
    fn faults_are_told_and_no_length_is_too_short() {
        let fault = |state: &Value| parse(&file(state), None).unwrap_err();
        let mut state = project();
        state["cameraParameters"]["cameraTransform"]["rows"][0][0] = json!(-1.0);
        assert!(fault(&state).contains("mirrored"));
        state["cameraParameters"] = Value::Null;
        assert!(fault(&state).contains("has no camera"));
        let good = file(&project());
        let json_end = good.len() - b"a picture".len();
        for length in 0..json_end {
            assert!(parse(&good[..length], None).is_err(), "{length} bytes");
        }
        let mut newer = good.clone();
        newer[4] = 2;
        assert!(parse(&newer, None).unwrap_err().contains("version 2"));
        newer[0] = b'x';
        assert!(parse(&newer, None).unwrap_err().contains("is not an fSpy project"));
    }
}
