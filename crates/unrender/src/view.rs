//! The photograph's camera and size as `run.json` keeps them, for what is done with results later.

use crate::project::CameraTable;
use serde::{Deserialize, Serialize};
use std::path::Path;
use unrender_formats::FileError;
use unrender_scene::{Camera, Lens};

/// Metres from the camera to the target that the record names.
const TARGET_DISTANCE: f32 = 1.0;

/// The key `view` of `run.json`: as the table `[camera]` of a project, with a name and a size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ViewRecord {
    camera: String,
    eye: [f32; 3],
    target: [f32; 3],
    up: [f32; 3],
    fov_y_deg: f32,
    principal_point: [f32; 2],
    k1: f32,
    k2: f32,
    width: usize,
    height: usize,
}

impl ViewRecord {
    /// The record of a picture of `width` x `height` pixels by `camera`.
    pub(crate) fn of(camera: &Camera, (width, height): (usize, usize)) -> Self {
        let table = CameraTable::of(camera, TARGET_DISTANCE);
        let Lens { principal_point, k1, k2 } = table.lens;
        Self {
            camera: camera.name.clone(),
            eye: table.eye.to_array(),
            target: table.target.to_array(),
            up: table.up.to_array(),
            fov_y_deg: table.fov_y_deg,
            principal_point,
            k1,
            k2,
            width,
            height,
        }
    }

    fn camera(&self) -> Camera {
        let table = CameraTable {
            eye: self.eye.into(),
            target: self.target.into(),
            up: self.up.into(),
            fov_y_deg: self.fov_y_deg,
            lens: Lens { principal_point: self.principal_point, k1: self.k1, k2: self.k2 },
        };
        table.camera(&self.camera)
    }
}

/// A camera, and the width and height of its picture.
pub(crate) type View = (Camera, (usize, usize));

#[derive(Deserialize)]
struct Run {
    view: Option<ViewRecord>,
}

/// The camera and the size of the photograph that the `run.json` at `path` is about; none if there
/// is no such file, or if it was written before it kept them.
///
/// # Errors
/// If the file cannot be read or is damaged.
pub(crate) fn read(path: &Path) -> Result<Option<View>, FileError> {
    if !path.exists() {
        return Ok(None);
    }
    let text = std::fs::read_to_string(path)
        .map_err(|error| FileError::new(path, format!("cannot be read: {error}")))?;
    let run: Run = serde_json::from_str(&text).map_err(|error| FileError::new(path, error))?;
    Ok(run.view.map(|view| (view.camera(), (view.width, view.height))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_camera_comes_back_as_it_was() {
        let eye = Vec3::new(1.0, 2.0, 3.0);
        let mut camera = Camera::look_at("é \"c\"", eye, Vec3::new(0.2, 0.1, -1.0), Vec3::Y, 0.9);
        camera.lens = Lens { principal_point: [0.05, -0.03], k1: -0.15, k2: 0.02 };
        let record = ViewRecord::of(&camera, (64, 48));
        let text = serde_json::to_string(&record).unwrap();
        let back: ViewRecord = serde_json::from_str(&text).unwrap();
        assert_eq!(back, record);
        let back = back.camera();
        assert_eq!((&back.name, back.lens), (&camera.name, camera.lens));
        for (x, y) in [(0.5, 0.5), (60.0, 40.0)] {
            let off = back.direction(x, y, 64, 48) - camera.direction(x, y, 64, 48);
            assert!(off.length() < 1e-6, "{off}");
        }
    }
}
