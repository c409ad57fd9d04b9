//! The scores as `benches/rooms/score.py` writes them.

use crate::Failure;
use crate::corpus::score::wilson;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// The version of the format that is read.
const VERSION: u32 = 2;

/// The scores of one estimate.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(crate) struct Score {
    pub(crate) version: u32,
    pub(crate) albedo_db: f64,
    pub(crate) roughness_db: f64,
    /// The share of the squared error of albedo in groups whose status is `recovered`.
    pub(crate) silent_share: f64,
    /// Groups that are counted.
    pub(crate) groups: usize,
    /// Those whose albedo is off by more than 0.05, and those of them whose status tells it.
    pub(crate) wrong: usize,
    pub(crate) wrong_and_told: usize,
    pub(crate) right_and_told: usize,
    /// Re-renderings by name.
    pub(crate) pictures: BTreeMap<String, Picture>,
    /// Renderings of the true materials by name.
    pub(crate) forward: BTreeMap<String, Forward>,
}

/// A re-rendering beside the truth.
#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) struct Picture {
    /// Of sRGB, decibels.
    pub(crate) psnr: f64,
    /// The median relative difference of blocks of 4 x 4 pixels.
    pub(crate) median: f64,
}

/// Our rendering of the true materials beside Mitsuba's.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Forward {
    /// Ours over Mitsuba's.
    pub(crate) mean: f64,
    pub(crate) rows: Vec<ForwardRow>,
}

/// One group of it.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct ForwardRow {
    pub(crate) group: String,
    pub(crate) pixels: usize,
    pub(crate) kind: String,
    /// Ours over Mitsuba's.
    pub(crate) ratio: f64,
    /// Its standard deviation by the noise of both.
    pub(crate) std: f64,
}

impl Score {
    /// Reads the file.
    ///
    /// # Errors
    /// If it cannot be read or is of another version.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        Self::parse(&std::fs::read_to_string(path)?)
            .map_err(|problem| format!("{}: {problem}", path.display()).into())
    }

    fn parse(text: &str) -> Result<Self, Failure> {
        let score: Self = serde_json::from_str(text)?;
        if score.version != VERSION {
            return Err(format!("scores of version {}; expected {VERSION}", score.version).into());
        }
        Ok(score)
    }

    /// The share of wrong groups with its interval.
    pub(crate) fn wrong_text(&self) -> String {
        wilson::text(self.wrong, self.groups)
    }

    /// The share of the wrong groups that are told, with its interval.
    pub(crate) fn told_text(&self) -> String {
        wilson::text(self.wrong_and_told, self.wrong)
    }
}

impl Forward {
    /// Groups of at least `pixels`, and those of them within 3 %.
    pub(crate) fn alike(&self, pixels: usize) -> (usize, usize) {
        /// Both programs sample other paths, and agree to 1 % where they compute the same.
        const ALIKE: f64 = 0.03;
        let large = self.rows.iter().filter(|row| row.pixels >= pixels);
        let alike = large.clone().filter(|row| (row.ratio - 1.0).abs() <= ALIKE).count();
        (alike, large.count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{"version": 2, "room": "cellar", "albedo_db": 20.5, "roughness_db": 9.25,
        "silent_share": 0.5, "groups": 10, "wrong": 4, "wrong_and_told": 1, "right_and_told": 2, "rows": [],
        "pictures": {"new_view": {"psnr": 25.0, "median": 0.1, "mean": 1.0}},
        "forward": {"photo": {"mean": 0.99, "rows": [
            {"group": "a", "pixels": 900, "kind": "diffuse", "ratio": 1.02, "std": 0.001},
            {"group": "b", "pixels": 900, "kind": "plastic", "ratio": 0.95, "std": 0.001},
            {"group": "c", "pixels": 100, "kind": "plastic", "ratio": 1.5, "std": 0.001}]}}}"#;

    #[test]
    fn scores_are_read_with_their_intervals() {
        let score = Score::parse(TEXT).unwrap();
        assert_eq!((score.albedo_db, score.wrong), (20.5, 4));
        assert!(
            score.wrong_text().starts_with("40.0 %") && score.told_text().starts_with("25.0 %")
        );
        assert_eq!(score.forward["photo"].alike(500), (1, 2));
    }

    #[test]
    fn another_version_is_refused() {
        assert!(Score::parse(&TEXT.replace("\"version\": 2", "\"version\": 1")).is_err());
    }
}
