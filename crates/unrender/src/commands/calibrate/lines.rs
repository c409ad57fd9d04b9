//! `unrender calibrate --lines`: the camera from lines along the axes, marked or found in the photograph.

use super::{Args, Found, Measured, Target, focal};
use crate::check::{drawn_over, white};
use crate::global::Global;
use crate::{Error, output};
use glam::{DVec3, Vec2, Vec3};
use std::path::{Path, PathBuf};
use unrender_formats::{FileError, atomic, axis_lines, picture};
use unrender_photo::calibrate::{
    Calibration, LinesRequest, calibrate_lines, sort_to_axes, straight_lines,
};
use unrender_scene::color::{linear_from_srgb, luminance, srgb_from_linear};
use unrender_scene::{
    AxisLine, Camera, Group, Material, Mesh, Object, Rgb, RgbImage, Scene, Warnings,
};

/// The word for lines that are found in the photograph.
const AUTO: &str = "auto";
/// Lines are drawn through dots this far apart, pixels of the photograph: less than a dot's width.
const DOTS_APART: f64 = 0.5;
/// sRGB colours of lines along x, y and z, as in Blender, and of rejected ones.
const COLOURS: [Rgb; 4] = [
    Rgb::new(1.00, 0.20, 0.25),
    Rgb::new(0.45, 0.85, 0.10),
    Rgb::new(0.25, 0.55, 1.00),
    Rgb::new(1.00, 0.90, 0.10),
];

/// A file that is written beside the camera.
pub(super) enum Further {
    Lines(PathBuf, String),
    Picture(PathBuf, RgbImage),
}

impl Further {
    pub(super) fn write(&self) -> Result<(), Error> {
        match self {
            Self::Lines(path, text) => atomic::write(path, text.as_bytes())?,
            Self::Picture(path, drawn) => drop(picture::write(path, drawn)?),
        }
        Ok(())
    }
}

/// Checks the names of what is written beside the camera.
pub(super) fn check_outputs<'a>(
    args: &'a Args,
    inputs: impl Iterator<Item = &'a Path> + Clone,
) -> Result<(), Error> {
    let kinds = [(&args.show_lines, "png", "picture"), (&args.save_lines, "csv", "table")];
    for (path, ending, what) in kinds {
        let Some(path) = path else { continue };
        output::check_inputs(path, inputs.clone().chain([args.out.as_path()]))?;
        output::check_file(path, &[ending], &format!("end the name of the {what} in .{ending}"))?;
    }
    Ok(())
}

pub(super) fn from_lines(
    args: &Args,
    path: &Path,
    target: &Target,
    global: &Global,
) -> Result<Found, Error> {
    let photo = Measured::read(target, global.limits())?;
    if let Some(height) = args.camera_height.filter(|height| !(*height > 0.0 && height.is_finite()))
    {
        return Err(Error::Request(format!(
            "--camera-height is {height}; it is positive, in metres"
        )));
    }
    let request = LinesRequest {
        focal: focal(args.fov_y_deg, photo.exif, photo.size.1)?,
        principal_point: args.principal_point,
        height_m: args.camera_height,
        seed: args.seed,
    };
    let shown = shown(&photo);
    let is_auto = path.as_os_str() == AUTO;
    let of = if is_auto { target.photo.as_deref().unwrap_or(path) } else { path };
    let failed = |problem| Error::Calibrate { path: of.to_owned(), problem };
    let lines = if is_auto {
        let white = white(&shown);
        let encoded = shown.map(|value| srgb_from_linear((luminance(*value) / white).min(1.0)));
        sort_to_axes(&straight_lines(&encoded), photo.size, &request).map_err(failed)?
    } else {
        axis_lines::read(path)?
    };
    if lines.iter().any(|line| line.length_m.is_some()) && args.camera_height.is_some() {
        let problem =
            "has a length_m, from which the camera's position follows; leave --camera-height out";
        return Err(FileError::new(path, problem).into());
    }
    let calibration = calibrate_lines(&lines, photo.size, &request).map_err(failed)?;
    let mut further = Vec::new();
    if let Some(path) = &args.show_lines {
        further.push(Further::Picture(path.clone(), drawn(&shown, &lines, &calibration)));
    }
    if let Some(path) = &args.save_lines {
        further.push(Further::Lines(path.clone(), axis_lines::to_csv(&lines)));
    }
    let count = (lines.len(), "lines");
    let found = photo.found(calibration, DVec3::ZERO, count, of, Warnings::default(), global);
    Ok(Found { further, ..found })
}

/// A scene from which to model: the camera, and a square metre on the floor, from the origin along x and z.
pub(super) fn begun(camera: Camera) -> Scene {
    let floor = Group {
        name: "floor".into(),
        material: Material::diffuse(Rgb::splat(0.5)),
        emission: Rgb::ZERO,
    };
    let corners = [Vec3::ZERO, Vec3::Z, Vec3::X + Vec3::Z, Vec3::X];
    let mesh = Mesh::flat(&corners, &[], &[[0, 1, 2], [0, 2, 3]]);
    let objects = vec![Object { name: "square metre".into(), group: 0, mesh }];
    Scene { groups: vec![floor], objects, cameras: vec![camera], ..Scene::default() }
}

/// The photograph in about linear values; what its response is does not matter for its lines.
fn shown(photo: &Measured) -> RgbImage {
    let values = &photo.picture.values;
    if photo.picture.is_linear {
        values.map(|value| value.max(Rgb::ZERO))
    } else {
        values.map(|code| code.map(linear_from_srgb))
    }
}

/// The lines over the photograph, in the colours of their axes.
fn drawn(shown: &RgbImage, lines: &[AxisLine], found: &Calibration) -> RgbImage {
    let is_rejected = |index: usize| found.rejected.iter().any(|out| out.index == index);
    let mut layers = COLOURS.map(|colour| (Vec::new(), colour));
    for (index, line) in lines.iter().enumerate() {
        let layer = if is_rejected(index) { 3 } else { line.axis };
        let [p, q] = line.ends.map(glam::DVec2::from);
        let dots = (p.distance(q) / DOTS_APART).ceil().clamp(1.0, 1e5) as usize;
        let dot = |at: usize| p.lerp(q, at as f64 / dots as f64).as_vec2();
        layers[layer].0.extend((0..=dots).map(dot).collect::<Vec<Vec2>>());
    }
    drawn_over(shown, &layers)
}
