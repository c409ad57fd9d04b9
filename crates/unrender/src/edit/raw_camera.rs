//! The table `[camera]` of an edit file, and which axis it says points upwards.

use super::edit_sheet::EditSheet;
use crate::toml_values::{Direction, Finite, Place, Positive};
use serde::Deserialize;
use unrender_scene::UpAxis;

/// The table `[camera]` as in TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    pub(super) eye: Option<Place>,
    pub(super) target: Option<Place>,
    pub(super) up: Option<Direction>,
    pub(super) fov_y_deg: Option<Positive>,
    #[serde(default)]
    pub(super) keys: Vec<RawKey>,
    pub(super) frames: Option<usize>,
}

/// One entry of `[[camera.keys]]`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawKey {
    pub(super) time: Option<Finite>,
    pub(super) eye: Place,
    pub(super) target: Place,
    pub(super) up: Option<Direction>,
    pub(super) fov_y_deg: Option<Positive>,
}

/// The axis of the scene that the last camera that `sheets` describe says points upwards.
pub(super) fn up_axis(sheets: &[EditSheet]) -> Option<UpAxis> {
    let table =
        sheets.iter().rev().find_map(|sheet| sheet.raw.camera.as_ref()?.get_ref().as_table());
    let raw: RawCamera = table?.clone().try_into().ok()?;
    let pose = raw.eye.zip(raw.target).map(|(eye, target)| (eye, target, None));
    let (eye, target, up) = pose.or(raw.keys.first().map(|key| (key.eye, key.target, key.up)))?;
    let ahead = (target.0 - eye.0).as_vec3().normalize_or_zero();
    UpAxis::of_camera(ahead, up.or(raw.up)?.0.normalize_or_zero())
}
