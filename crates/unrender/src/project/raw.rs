//! The project file as TOML has it, before any value is understood.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use toml::Value;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProject {
    pub(super) scene: PathBuf,
    pub(super) photo: PathBuf,
    pub(super) response: Option<Value>,
    pub(super) black_level: Option<Value>,
    pub(super) exposure: Option<Value>,
    pub(super) vignetting: Option<Value>,
    pub(super) anchor: Option<RawAnchor>,
    #[serde(default)]
    pub(super) groups: BTreeMap<String, RawGroup>,
    #[serde(default)]
    pub(super) lights: BTreeMap<String, RawLight>,
    #[serde(default)]
    pub(super) recover: RawRecover,
    pub(super) camera: Option<Value>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAnchor {
    pub(super) group: String,
    pub(super) rho_d: Value,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawGroup {
    pub(super) known: Option<RawKnown>,
    pub(super) max_rung: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLight {
    pub(super) unknown: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawKnown {
    pub(super) rho_d: Option<Value>,
    pub(super) rho_s: Option<Value>,
    pub(super) alpha_x: Option<f32>,
    pub(super) alpha_y: Option<f32>,
    pub(super) theta_deg: Option<f32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRecover {
    pub(super) brdf: Option<String>,
    pub(super) max_rung: Option<String>,
    #[serde(default)]
    pub(super) thresholds: BTreeMap<String, f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    pub(super) eye: [f32; 3],
    pub(super) target: [f32; 3],
    pub(super) up: Option<[f32; 3]>,
    pub(super) fov_y_deg: f32,
    pub(super) principal_point: Option<[f32; 2]>,
    pub(super) k1: Option<f32>,
    pub(super) k2: Option<f32>,
}
