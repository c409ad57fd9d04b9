//! The camera of a run, which scene.glb beside it lacks, for commands that continue from it. Only this part of run.json is read, so that files of other versions can be used.

use crate::project::CameraTable;
use glam::DVec3;
use serde::Deserialize;
use serde_json::Value;
use std::path::Path;
use unrender_formats::{FileError, input};
use unrender_scene::{Lens, UpAxis};

/// The camera that the recovery with the run file at `path` used; none if the file does not state
/// it.
///
/// # Errors
/// If the file is damaged.
pub(crate) fn recovered_camera(path: &Path) -> Result<Option<CameraTable>, FileError> {
    let Some(run) = value(path)? else { return Ok(None) };
    let camera = &run["registration"]["camera"];
    let number = |value: &Value| value.as_f64().map(|number| number as f32);
    let place = |key: &str| {
        let [x, y, z] = [0, 1, 2].map(|index| camera[key][index].as_f64());
        Some(DVec3::new(x?, y?, z?))
    };
    let vector = |key: &str| place(key).map(|v| v.as_vec3());
    let table = || {
        let [right, down] = [0, 1].map(|index| number(&camera["principal_point"][index]));
        let (k1, k2) = (number(&camera["k1"])?, number(&camera["k2"])?);
        // Files of earlier versions have only these.
        let or = |key: &str, usual: f32| number(&camera[key]).unwrap_or(usual);
        let [k3, p1, p2] = ["k3", "p1", "p2"].map(|key| or(key, 0.0));
        let fx_over_fy = or("fx_over_fy", 1.0);
        let lens = Lens { principal_point: [right?, down?], fx_over_fy, k1, k2, k3, p1, p2 };
        let (eye, target, up) = (place("eye")?, place("target")?, vector("up")?);
        let (fov_y_deg, near) = (number(&camera["fov_y_deg"])?, or("near", 0.0));
        Some(CameraTable { eye, target, up, fov_y_deg, lens, near })
    };
    Ok(table())
}

/// The width and height of the photograph of the recovery with the run file at `path`; none if the
/// file does not state them.
///
/// # Errors
/// If the file is damaged.
pub(crate) fn recovered_size(path: &Path) -> Result<Option<(usize, usize)>, FileError> {
    let Some(run) = value(path)? else { return Ok(None) };
    let side = |key: &str| run["input"][key].as_u64().filter(|side| *side > 0);
    let sides = side("width").zip(side("height"));
    Ok(sides.map(|(width, height)| (width as usize, height as usize)))
}

/// Which axis of the scene points upwards in the recovery with the run file at `path`.
///
/// # Errors
/// If the file is damaged.
pub(crate) fn recovered_up(path: &Path) -> Result<UpAxis, FileError> {
    let run = value(path)?.unwrap_or_default();
    Ok(UpAxis::deserialize(&run["input"]["up_axis"]).unwrap_or_default())
}

/// The file at `path` as JSON; none if it is missing.
pub(super) fn value(path: &Path) -> Result<Option<Value>, FileError> {
    if !path.exists() {
        return Ok(None);
    }
    let text = input::text(path).map_err(|error| FileError::because(path, "", error))?;
    let run = serde_json::from_str(&text)
        .map_err(|error| FileError::new(path, format!("is not JSON: {error}")))?;
    Ok(Some(run))
}
