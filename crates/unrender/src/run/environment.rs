//! The environment of a run, which scene.glb lacks: a panorama beside run.json, and what run.json says of it.

use serde::{Deserialize, Serialize};
use std::path::Path;
use unrender_formats::{FileError, Input, Limits, picture};
use unrender_scene::{Environment, Rgb, RgbImage, Warnings};

/// The panorama's file in a folder of results.
pub(crate) const PANORAMA: &str = "environment.exr";

/// The environment of a recovery, as it was stated or recovered.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct EnvironmentEntry {
    /// The panorama beside the file, its radiance in the scene's units and not turned; left out if the radiance is the
    /// same from everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub panorama: Option<String>,
    /// How far it is turned about +y, counter-clockwise seen from above, degrees.
    pub rotation_deg: f64,
    /// The mean of its radiance over all directions, W sr^-1 m^-2.
    pub radiance: [f32; 3],
}

impl EnvironmentEntry {
    /// The entry of `environment`.
    pub(crate) fn of(environment: &Environment) -> Self {
        Self {
            panorama: environment.uniform().is_none().then(|| PANORAMA.to_owned()),
            rotation_deg: f64::from(environment.rotation_rad()).to_degrees(),
            radiance: environment.mean().to_array(),
        }
    }

    /// The environment, its panorama read from `folder`.
    fn read(
        &self,
        folder: &Path,
        limits: Limits,
    ) -> Result<(Option<Environment>, Warnings), FileError> {
        let Some(name) = &self.panorama else {
            let one = RgbImage::new(1, 1, vec![Rgb::from_array(self.radiance)]);
            let environment = Environment::new(one, 0.0);
            let named = |error| FileError::new(&folder.join(super::Run::FILE), error);
            return Ok((Some(environment.map_err(named)?), Warnings::default()));
        };
        // Recovery wrote the name; a file elsewhere would not be of these results.
        let path = folder.join(Path::new(name).file_name().unwrap_or_default());
        let turn = self.rotation_deg.to_radians() as f32;
        let (environment, warnings) =
            picture::read_environment(Input::new(&path, limits), turn, 1.0)?;
        Ok((Some(environment), warnings))
    }
}

/// Writes the panorama of `environment` into `folder`, unless its radiance is the same from everywhere.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write_panorama(environment: &Environment, folder: &Path) -> Result<(), FileError> {
    if environment.uniform().is_none() {
        picture::write_exr(&folder.join(PANORAMA), environment.panorama())?;
    }
    Ok(())
}

/// The environment of a folder of results.
#[derive(Debug, Default)]
pub(crate) struct RecoveredEnvironment {
    /// The environment; none if there was none, or if the folder lacks it.
    pub(crate) environment: Option<Environment>,
    /// What is to be said of its panorama.
    pub(crate) warnings: Warnings,
    /// In words, the environment that the recovery had and the folder lacks, as older ones do.
    pub(crate) lacking: Option<String>,
}

/// The environment of the results in `folder`. One that was recovered in parts may also stand in materials.json.
///
/// # Errors
/// If run.json or the panorama is damaged or missing.
pub(crate) fn recovered_environment(
    folder: &Path,
    limits: Limits,
) -> Result<RecoveredEnvironment, FileError> {
    let path = folder.join(super::Run::FILE);
    let run = super::camera::value(&path)?.unwrap_or_default();
    if run["environment"].is_null() {
        let is_in_materials = run["lights"]["environment"]["panorama"].is_object();
        let words = run["input"]["environment"].as_str().filter(|_| !is_in_materials);
        let lacking = words.map(str::to_owned);
        return Ok(RecoveredEnvironment { lacking, ..RecoveredEnvironment::default() });
    }
    let entry: EnvironmentEntry = serde_json::from_value(run["environment"].clone())
        .map_err(|error| FileError::new(&path, format!("environment: {error}")))?;
    let (environment, warnings) = entry.read(folder, limits)?;
    Ok(RecoveredEnvironment { environment, warnings, lacking: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_comes_back_with_the_same_bits() {
        let folder = tempfile::tempdir().unwrap();
        let motley = RgbImage::from_fn(8, 4, |x, y| Rgb::new(x as f32, 0.1 * y as f32, 1.0 / 3.0));
        let one = RgbImage::new(2, 1, vec![Rgb::new(0.1, 0.2, 0.3); 2]);
        for (panorama, turn) in [(motley.clone(), -1.234_567_9_f32), (motley, 0.0), (one, 0.0)] {
            let environment = Environment::new(panorama, turn).unwrap();
            write_panorama(&environment, folder.path()).unwrap();
            let entry = EnvironmentEntry::of(&environment);
            let run = serde_json::json!({ "environment": entry });
            std::fs::write(folder.path().join("run.json"), run.to_string()).unwrap();
            let back = recovered_environment(folder.path(), Limits::default()).unwrap();
            assert_eq!(back.warnings, Warnings::default());
            let back = back.environment.unwrap();
            assert_eq!((back.rotation_rad(), back.mean()), (turn, environment.mean()));
            let is_same = || back.panorama() == environment.panorama();
            assert!(environment.uniform().is_some() || is_same());
        }
    }

    #[test]
    fn older_results_say_what_they_lack() {
        let folder = tempfile::tempdir().unwrap();
        let lacking = |text: &str| {
            std::fs::write(folder.path().join("run.json"), text).unwrap();
            recovered_environment(folder.path(), Limits::default()).unwrap().lacking
        };
        let words = |panorama| {
            format!(
                r#"{{"input": {{"environment": "sky.hdr"}}, "lights": {{"environment": {{{panorama}}}}}}}"#
            )
        };
        assert_eq!(lacking(&words("")).as_deref(), Some("sky.hdr"));
        assert_eq!(lacking(&words(r#""panorama": {}"#)), None);
        assert_eq!(lacking("{}"), None);
    }
}
