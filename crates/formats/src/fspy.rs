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
//! fSpy does not look at the EXIF orientation of its photograph (its issues 44 and 57): the camera is of the
//! pixels as they are stored, unless the sizes say otherwise, and is turned with them.
//!
//! Which of fSpy's axes points upwards is up to whoever labelled the vanishing points; see [`Up`].
//! Sources: fSpy's `project_file_format.md`, and what its own importer for Blender makes of it.

use crate::cameras::{Pixels, turn};
use crate::entry::{Entry, Table, passed, read as row};
use crate::picture::{Orientation, stored_in};
use crate::{FileError, input};
use glam::{Affine3A, DMat3, DVec2, DVec3, Mat3};
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
    /// The size of the upright photograph, pixels.
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

const SIZE: &str = "the size of the photograph as fSpy shows it";

/// What is read of the project's JSON.
const ROWS: [Entry; 8] = [
    row("cameraTransform", "camera to world"),
    row("horizontalFieldOfView", "radians"),
    row("principalPoint", "how far the axis is off the middle"),
    row("imageWidth", SIZE),
    row("imageHeight", SIZE),
    row(
        "referenceDistanceUnit",
        "the unit of its lengths; without one metres are taken, with a warning",
    ),
    row("referenceDistanceAxis", "without one lengths mean nothing, which a warning says"),
    passed("others", "such as the vanishing points, from which fSpy made the camera"),
];

/// What is read of fSpy's projects.
pub(crate) fn table() -> Table {
    Table::new("Cameras: fSpy", "property", &ROWS)
}

/// Reads the fSpy project at `path`. Without `up`, fSpy's y or z is taken, whichever is nearer to
/// the picture's up direction.
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
    let (state, photograph) = parts(bytes)?;
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
    let turned = turn_of(photograph, (width, height), &mut warnings)?;
    let metres = metres(state.calibration_settings_base.as_ref(), &mut warnings);
    // The camera's own axes are right, up, backwards; those of pixels right, down, forwards.
    let flip = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let axes = axes * (flip * turn(turned) * flip).transpose();
    let upwards = axes.y_axis;
    let up = up.unwrap_or(if upwards.z.abs() > upwards.y.abs() { Up::Z } else { Up::Y });
    let ours_from_fspy = match up {
        Up::Y => DMat3::IDENTITY,
        Up::Z => DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y),
    };
    let axes: Mat3 = (ours_from_fspy * axes).as_mat3();
    let eye = (ours_from_fspy * eye * metres).as_vec3();
    let stored_px = DVec2::new(width as f64, height as f64);
    let upright_from_stored = turned.upright_from_stored();
    let [width_px, height_px] = (upright_from_stored * stored_px).abs().to_array();
    let focal_px = 0.5 * stored_px.x / (0.5 * fov_x).tan();
    let Point { x: right, y: above } = parameters.principal_point;
    let off_px = upright_from_stored * DVec2::new(right, -above) * 0.5 * stored_px.max_element();
    let principal_point = (off_px / height_px).as_vec2().to_array();
    let camera = Camera {
        name: "fspy".into(),
        world_from_camera: Affine3A::from_mat3_translation(axes, eye),
        fov_y_rad: (2.0 * (0.5 * height_px / focal_px).atan()) as f32,
        aspect: Some((width_px / height_px) as f32),
        size: None,
        lens: Lens { principal_point, ..Lens::default() },
        near: 0.0,
    };
    let size = if turned.swaps_sides() { (height, width) } else { (width, height) };
    Ok((Matched { camera, size, up }, warnings))
}

/// How the pixels that fSpy showed, `shown` across and down, are turned to stand upright.
fn turn_of(
    photograph: &[u8],
    shown: (usize, usize),
    warnings: &mut Warnings,
) -> Result<Orientation, String> {
    let Some(stored) = stored_in(photograph) else { return Ok(Orientation::UPRIGHT) };
    let orientation = stored.orientation;
    let [shown, size] = [shown, stored.size].map(|(width, height)| [width as f64, height as f64]);
    let upright = if orientation.swaps_sides() { [size[1], size[0]] } else { size };
    let is_upright = Pixels::by_size(shown, upright, orientation) == Some(Pixels::Upright);
    if orientation == Orientation::UPRIGHT || is_upright {
        return Ok(Orientation::UPRIGHT);
    }
    let number = orientation.number();
    if orientation.mirrors() {
        return Err(format!(
            "has a photograph whose EXIF orientation {number} shows it mirrored, which fSpy does not look at; save \
             the photograph as it is shown, without EXIF data, and match that"
        ));
    }
    warnings.push(format!(
        "fSpy does not look at EXIF orientations, and its photograph's is {number}: the camera was turned with the photo"
    ));
    Ok(orientation)
}

/// The parsed JSON, and the bytes of the photograph.
fn parts(bytes: &[u8]) -> Result<(State, &[u8]), String> {
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
    let rest = bytes.get(HEADER..).unwrap_or_default();
    let (json, photograph) = rest.split_at_checked(size).ok_or_else(cut_short)?;
    let state = serde_json::from_slice(json)
        .map_err(|error| format!("has no valid project data ({error}); save it again in fSpy"))?;
    Ok((state, photograph))
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
        file_with(state, b"a picture")
    }

    fn file_with(state: &Value, picture: &[u8]) -> Vec<u8> {
        let json = serde_json::to_vec(state).unwrap();
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

    /// A grey PNG of this size and EXIF orientation.
    fn photograph(width: u32, height: u32, orientation: u8) -> Vec<u8> {
        use image::ImageEncoder;
        let mut exif = b"MM\0*\0\0\0\x08\0\x01".to_vec();
        exif.extend([1, 0x12, 0, 3, 0, 0, 0, 1, 0, orientation, 0, 0, 0, 0, 0, 0]);
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        encoder.set_exif_metadata(exif).unwrap();
        let codes = vec![9; (width * height) as usize];
        encoder.write_image(&codes, width, height, image::ExtendedColorType::L8).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn a_camera_of_stored_pixels_turns_with_them() {
        let (plain, _) = parse(&file(&project()), None).unwrap();
        // Where the upright photograph shows a pixel of the stored one, which has 800 x 600.
        for (orientation, upright) in [
            (3, (|x, y| (800.0 - x, 600.0 - y)) as fn(f32, f32) -> (f32, f32)),
            (6, |x, y| (600.0 - y, x)),
            (8, |x, y| (y, 800.0 - x)),
        ] {
            let bytes = file_with(&project(), &photograph(80, 60, orientation));
            let (turned, warnings) = parse(&bytes, Some(Up::Z)).unwrap();
            assert!(warnings.0[0].contains("EXIF"), "{warnings:?}");
            let size = if orientation == 3 { (800, 600) } else { (600, 800) };
            assert_eq!(turned.size, size);
            assert_eq!(turned.camera.origin(), plain.camera.origin());
            for (x, y) in [(0.5, 0.5), (700.0, 40.0), (300.0, 580.0)] {
                let (u, v) = upright(x, y);
                let stored = plain.camera.direction(x, y, 800, 600);
                let seen = turned.camera.direction(u, v, size.0, size.1);
                assert!((stored - seen).length() < 1e-5, "{orientation}: {stored} {seen}");
            }
        }
        // A later fSpy that shows pictures upright says their sizes.
        let upright = file_with(&project(), &photograph(60, 80, 6));
        let (same, warnings) = parse(&upright, None).unwrap();
        assert_eq!((same.camera, warnings.0.len()), (plain.camera, 0));
        let mirrored = file_with(&project(), &photograph(80, 60, 2));
        assert!(parse(&mirrored, None).unwrap_err().contains("mirrored"));
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
