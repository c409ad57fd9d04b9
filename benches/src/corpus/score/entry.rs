//! Materials as in files of any version of the command.

use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// A file of materials.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Materials {
    pub(crate) groups: BTreeMap<String, Entry>,
}

/// One group.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct Entry {
    pub(crate) hypothesis: Option<String>,
    pub(crate) status: Option<String>,
    pub(crate) rho_d: Option<[f64; 3]>,
    pub(crate) rho_s: Option<[f64; 3]>,
    pub(crate) alpha_x: Option<f64>,
    pub(crate) alpha_y: Option<f64>,
    pub(crate) theta_deg: Option<f64>,
    pub(crate) texture: Option<String>,
    pub(crate) std: Option<Stds>,
}

/// Standard deviations.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(crate) struct Stds {
    pub(crate) rho_d: Option<[f64; 3]>,
    pub(crate) rho_s: Option<[f64; 3]>,
    pub(crate) alpha_x: Option<f64>,
    pub(crate) alpha_y: Option<f64>,
    pub(crate) theta_deg: Option<f64>,
}

impl Materials {
    /// Reads a file.
    ///
    /// # Errors
    /// If it is missing or is not JSON of this kind.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    }
}

impl Entry {
    /// Its hypothesis.
    pub(crate) fn kind(&self) -> &str {
        self.hypothesis.as_deref().unwrap_or("none")
    }

    /// The same lobe with the smaller roughness first.
    pub(crate) fn smoother_first(&self) -> Self {
        let mut entry = self.clone();
        if self.alpha_x > self.alpha_y {
            (entry.alpha_x, entry.alpha_y) = (self.alpha_y, self.alpha_x);
            entry.theta_deg = self.theta_deg.map(|theta| theta + 90.0);
            if let Some(std) = &mut entry.std {
                (std.alpha_x, std.alpha_y) = (std.alpha_y, std.alpha_x);
            }
        }
        entry
    }
}
