//! The file of a run's measurements.

use super::measure::SceneNoise;
use crate::Failure;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The numbers of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// A sentence: when, by which version, on how many cores.
    pub(super) measured: String,
    /// The scenes by name.
    pub(super) scenes: BTreeMap<String, SceneNoise>,
}

impl Record {
    /// A record without scenes.
    pub(super) fn new(measured: String) -> Self {
        Self { measured, scenes: BTreeMap::new() }
    }

    /// Reads what [`Record::write`] wrote.
    ///
    /// # Errors
    /// If the file cannot be read, or is not one of these.
    pub(super) fn read(file: &Path) -> Result<Self, Failure> {
        let in_file = |problem: &dyn std::fmt::Display, remedy: &str| {
            format!("{}: {problem}{remedy}", file.display())
        };
        let text = fs::read_to_string(file).map_err(|problem| in_file(&problem, ""))?;
        let written = "; give a file that `noise --save` wrote";
        Ok(serde_json::from_str(&text).map_err(|problem| in_file(&problem, written))?)
    }

    /// Writes all numbers.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn write(&self, file: &Path) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self)?;
        fs::write(file, text + "\n").map_err(|problem| format!("{}: {problem}", file.display()))?;
        Ok(())
    }
}
