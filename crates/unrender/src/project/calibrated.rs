//! The camera of a photograph from the file of another program, turned if the photograph is.

use super::camera_choice::NAME;
use super::{CalibratedCamera, CameraFile};
use glam::{Affine3A, DAffine3, DVec3};
use std::path::PathBuf;
use unrender_formats::cameras::{Intrinsics, Pixels, Pose, colmap, opencv};
use unrender_formats::picture::Orientation;
use unrender_formats::{FileError, Input, Limits};
use unrender_scene::{Camera, Warnings};

/// A photograph to which a camera belongs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Photographed {
    /// Width and height of the upright picture, pixels.
    pub(crate) size: (usize, usize),
    /// How its file stores the picture.
    pub(crate) orientation: Orientation,
}

/// The camera of a photograph.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    /// The camera.
    pub(crate) camera: Camera,
    /// Whether it belongs to the photograph with left and right exchanged: the upright one is a mirror
    /// image of what the camera saw.
    pub(crate) is_mirrored: bool,
    /// Warnings of it.
    pub(crate) warnings: Warnings,
}

/// The contents of a file.
struct Calibration<'a> {
    path: &'a PathBuf,
    intrinsics: Intrinsics,
    pose: Option<Pose>,
}

impl CalibratedCamera {
    /// The camera of `photo`, its position counted from `origin`.
    ///
    /// # Errors
    /// If a file cannot be read, has no such camera, or one of another picture; or if nothing states whether
    /// it is for the stored pixels of a turned photograph.
    pub(crate) fn read(
        &self,
        photo: Photographed,
        origin: DVec3,
        limits: Limits,
    ) -> Result<Found, FileError> {
        let calibration = self.calibration(limits)?;
        let fault = |problem: String| FileError::new(calibration.path, problem);
        let mut warnings = Warnings::default();
        let pixels = self.pixels_of(&calibration, photo, &mut warnings).map_err(fault)?;
        let turn = match pixels {
            Pixels::Stored => photo.orientation,
            Pixels::Upright => Orientation::UPRIGHT,
        };
        // A pose of the project is for the upright picture; that of a file for the pixels that it was made from.
        let is_mirrored = turn.mirrors() && self.stand.is_none();
        let turn = if is_mirrored { turn.mirrored_back() } else { turn };
        let pose = self.pose(&calibration, turn, origin).map_err(fault)?;
        let (width, height) = photo.size;
        let stored = if turn.swaps_sides() { (height, width) } else { (width, height) };
        let intrinsics = match self.crop {
            Some(corner) => within(&calibration.intrinsics, corner, stored).map_err(fault)?,
            None => calibration.intrinsics,
        };
        let intrinsics = intrinsics.turned(turn, [stored.0 as f64, stored.1 as f64]);
        let camera = intrinsics.camera(NAME, pose, photo.size).map_err(fault)?;
        if is_mirrored {
            warnings.push(format!(
                "the photo's EXIF orientation {} shows it mirrored, and its camera saw it as it is stored: left \
                 and right of the upright photo were exchanged",
                photo.orientation.number()
            ));
        }
        Ok(Found { camera, is_mirrored, warnings })
    }

    fn calibration(&self, limits: Limits) -> Result<Calibration<'_>, FileError> {
        match &self.file {
            CameraFile::Opencv { path, view } => {
                let (intrinsics, pose) = opencv::read(Input::new(path, limits), *view)?;
                Ok(Calibration { path, intrinsics, pose })
            }
            CameraFile::Colmap { cameras, images, image } => {
                let (intrinsics, pose) = colmap::read(cameras, images, image, limits)?;
                Ok(Calibration { path: cameras, intrinsics, pose: Some(pose) })
            }
        }
    }

    /// The pose, its position counted from `origin`.
    fn pose(
        &self,
        calibration: &Calibration<'_>,
        turn: Orientation,
        origin: DVec3,
    ) -> Result<Affine3A, String> {
        let of_file = calibration.pose.and_then(|pose| pose.turned(turn));
        let here_from_world = DAffine3::from_translation(-origin) * self.scene_from_world;
        let of_file = of_file.map(|pose| pose.world_from_camera(&here_from_world));
        let stated = self.stand.map(|stand| stand.camera(NAME, origin, 1.0).world_from_camera);
        stated.or(of_file).ok_or_else(|| {
            "has no pose: write rvec and tvec into it as cv2.solvePnP gives them, or give eye and \
             target in [camera]"
                .into()
        })
    }

    /// The pixels of `photo` that the calibration is for: as the project states, as the sizes show, or as
    /// its program does it.
    fn pixels_of(
        &self,
        calibration: &Calibration<'_>,
        photo: Photographed,
        warnings: &mut Warnings,
    ) -> Result<Pixels, String> {
        let Photographed { size: (width, height), orientation } = photo;
        let upright = [width as f64, height as f64];
        let whole = calibration.intrinsics.size.filter(|_| self.crop.is_none());
        let told = whole.and_then(|size| Pixels::by_size(size, upright, orientation));
        if let Some(pixels) = self.pixels.or(told) {
            return Ok(pixels);
        }
        let has_pose = self.stand.is_some();
        let turned = calibration.intrinsics.turned(orientation, upright);
        if orientation == Orientation::UPRIGHT || has_pose && turned == calibration.intrinsics {
            return Ok(Pixels::Upright);
        }
        let number = orientation.number();
        if matches!(self.file, CameraFile::Opencv { .. }) {
            return Err(format!(
                "may be for the photo as it is stored or as its EXIF orientation {number} turns it \
                 upright, and the sizes do not decide it: give pixels = \"upright\" in [camera] \
                 (cv2.imread turns pictures upright), or pixels = \"stored\" (with \
                 IMREAD_IGNORE_ORIENTATION, cv2.VideoCapture and many other programs)"
            ));
        }
        warnings.push(format!(
            "the photo is turned by its EXIF orientation {number}, which COLMAP ignores: the \
             camera was taken to be for the pixels as they are stored, and turned with them; if it \
             is for the upright photo, give pixels = \"upright\" in [camera]"
        ));
        Ok(Pixels::Stored)
    }
}

/// The intrinsics of a photograph of `size` that was cropped at `corner`.
fn within(
    intrinsics: &Intrinsics,
    corner: [f64; 2],
    (width, height): (usize, usize),
) -> Result<Intrinsics, String> {
    let [left, top] = corner;
    if let Some([w, h]) = intrinsics.size
        && (left + width as f64 > w || top + height as f64 > h)
    {
        return Err(format!(
            "it is for a picture of {w} x {h} pixels, and by camera.crop the photo's {width} x \
             {height} begin at {left}, {top}, and reach beyond it; crop the photo without scaling \
             it"
        ));
    }
    Ok(intrinsics.cropped(corner))
}
