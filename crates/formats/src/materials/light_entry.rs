//! The lights in a `materials.json`, and how they are applied to a scene.

use super::drop_triple;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use unrender_scene::{ENVIRONMENT, Environment, Rgb, RgbImage, Scene, Warnings};

/// One light of a `materials.json`: a group that emits, or a light without a surface.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct LightEntry {
    /// Radiance of area lights, radiant intensity of point and spot lights, irradiance of
    /// directional ones, mean radiance of the environment, in the scene's units by channel.
    pub intensity: Option<[f32; 3]>,
    /// Standard deviations of the intensity; null if the photograph does not determine it.
    pub std: Option<[f32; 3]>,
    /// The picture of an environment that was recovered in parts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub panorama: Option<PanoramaEntry>,
}

/// A panorama of few pixels, bilinear between them, rows from straight up to straight down; its columns are those
/// of [`Environment`], which is not turned.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PanoramaEntry {
    /// Pixels from left to right.
    pub columns: usize,
    /// Pixels from the top to the bottom.
    pub rows: usize,
    /// The radiance of each pixel, row by row, W sr^-1 m^-2 per channel.
    pub radiance: Vec<[f32; 3]>,
    /// Its standard deviations.
    pub std: Vec<[f32; 3]>,
}

impl PanoramaEntry {
    fn environment(&self) -> Result<Environment, String> {
        let fault = |problem: &str| format!("the materials' environment: {problem}");
        if self.columns.checked_mul(self.rows) != Some(self.radiance.len()) {
            return Err(fault(&format!(
                "{} times {} differs from the number of colours of radiance, {}",
                self.columns,
                self.rows,
                self.radiance.len()
            )));
        }
        let pixels = self.radiance.iter().map(|rgb| Rgb::from_array(*rgb)).collect();
        let panorama = RgbImage::new(self.columns, self.rows, pixels);
        let environment = Environment::new(panorama, 0.0);
        environment.map(Environment::in_parts).map_err(|error| fault(&error.to_string()))
    }
}

impl LightEntry {
    pub(super) fn drop_not_finite(&mut self) {
        drop_triple(&mut self.intensity);
        drop_triple(&mut self.std);
        let is_finite = |triples: &[[f32; 3]]| triples.iter().flatten().all(|v| v.is_finite());
        self.panorama.take_if(|found| !is_finite(&found.radiance) || !is_finite(&found.std));
    }
}

/// Makes the lights of `scene` as bright as `lights` says; others stay as they are.
pub(super) fn apply(
    lights: &IndexMap<String, LightEntry>,
    scene: &mut Scene,
) -> Result<Warnings, String> {
    let mut warnings = Warnings::default();
    for (name, entry) in lights {
        if let (ENVIRONMENT, Some(panorama)) = (name.as_str(), &entry.panorama) {
            scene.environment = Some(panorama.environment()?.with_up(scene.up));
            continue;
        }
        let found = scene.sources().filter(|source| source.name == name);
        let (index, present) = match found.map(|s| (s.index, s.strength)).collect::<Vec<_>>()[..] {
            [found] => found,
            [] => {
                warnings
                    .push(format!("the scene has no light \"{name}\"; its numbers were not used"));
                continue;
            }
            _ => {
                warnings.push(format!(
                    "the scene has several lights called \"{name}\"; its numbers were not used"
                ));
                continue;
            }
        };
        let Some(intensity) = entry.intensity else { continue };
        if let Some(value) = intensity.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Err(format!(
                "the materials' light \"{name}\": intensity is {value}; it is zero or positive"
            ));
        }
        let intensity = Rgb::from_array(intensity);
        match scene.strength_mut(index) {
            Some(strength) => *strength = intensity,
            // A black light stays black.
            None => {
                scene.scale_source(index, intensity / present.max(Rgb::splat(f32::MIN_POSITIVE)))
            }
        }
    }
    Ok(warnings)
}
