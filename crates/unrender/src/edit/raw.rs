//! The edit file as TOML has it. Values are checked where they are read (`toml_values`), so that an
//! error has the line of the value; names are checked against the scene later.

use crate::lighting::{RawEnvironment, RawLight};
use crate::toml_values::{Direction, Finite, NotNegative, Point, Positive, Reflectance, Size};
use serde::Deserialize;
use std::path::PathBuf;
use toml::{Spanned, Value};

/// All keys of an edit file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEdits {
    pub(super) recovered: Option<Spanned<PathBuf>>,
    pub(super) project: Option<Spanned<PathBuf>>,
    pub(super) scene: Option<Spanned<PathBuf>>,
    pub(super) materials: Option<Spanned<PathBuf>>,
    pub(super) camera: Option<Spanned<Value>>,
    pub(super) environment: Option<Spanned<RawEnvironment>>,
    #[serde(default)]
    pub(super) remove: Vec<Spanned<RawRemove>>,
    #[serde(default)]
    pub(super) repaint: Vec<Spanned<RawRepaint>>,
    #[serde(default)]
    pub(super) lights: Vec<Spanned<RawLight>>,
    #[serde(default)]
    pub(super) insert: Vec<Spanned<RawInsert>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRemove {
    pub(super) name: Option<String>,
    pub(super) object: Option<String>,
    pub(super) group: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRepaint {
    pub(super) group: String,
    pub(super) rho_d: Option<Reflectance>,
    pub(super) rho_s: Option<Reflectance>,
    pub(super) alpha: Option<NotNegative>,
    pub(super) alpha_x: Option<NotNegative>,
    pub(super) alpha_y: Option<NotNegative>,
    pub(super) theta_deg: Option<Finite>,
    pub(super) texture: Option<PathBuf>,
}

/// A material of an inserted model.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawMaterial {
    /// The model's own name of it; all of them if there is none.
    pub(super) name: Option<String>,
    pub(super) rho_d: Option<Reflectance>,
    pub(super) rho_s: Option<Reflectance>,
    pub(super) alpha: Option<NotNegative>,
    pub(super) alpha_x: Option<NotNegative>,
    pub(super) alpha_y: Option<NotNegative>,
    pub(super) theta_deg: Option<Finite>,
    pub(super) texture: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawInsert {
    pub(super) name: Option<String>,
    pub(super) file: PathBuf,
    pub(super) position: Option<Point>,
    pub(super) on: Option<String>,
    pub(super) at: Option<Size>,
    pub(super) pixel: Option<Size>,
    pub(super) rotation_deg: Option<Point>,
    pub(super) scale: Option<Positive>,
    #[serde(default)]
    pub(super) material: Vec<RawMaterial>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    pub(super) eye: Option<Point>,
    pub(super) target: Option<Point>,
    pub(super) up: Option<Direction>,
    pub(super) fov_y_deg: Option<Positive>,
    #[serde(default)]
    pub(super) keys: Vec<RawKey>,
    pub(super) frames: Option<usize>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawKey {
    pub(super) time: Option<Finite>,
    pub(super) eye: Point,
    pub(super) target: Point,
    pub(super) up: Option<Direction>,
    pub(super) fov_y_deg: Option<Positive>,
}
