//! The lights in a `materials.json`, and how they are put onto a scene.

use super::drop_triple;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use unrender_scene::{Rgb, Scene, Warnings};

/// One light of a `materials.json`: a group that emits, or a light without a surface.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct LightEntry {
    /// Radiance of area lights, radiant intensity of point and spot lights, irradiance of
    /// directional ones, in the scene's units by channel.
    pub intensity: Option<[f32; 3]>,
    /// Standard deviations of the intensity; null if the photograph does not tell.
    pub std: Option<[f32; 3]>,
}

impl LightEntry {
    pub(super) fn drop_not_finite(&mut self) {
        drop_triple(&mut self.intensity);
        drop_triple(&mut self.std);
    }
}

/// Makes the lights of `scene` as bright as `lights` says; what is not named stays as it is.
pub(super) fn apply(
    lights: &IndexMap<String, LightEntry>,
    scene: &mut Scene,
) -> Result<Warnings, String> {
    let mut warnings = Warnings::default();
    for (name, entry) in lights {
        let found = scene.sources().filter(|source| source.name == name);
        let index = match found.map(|source| source.index).collect::<Vec<_>>()[..] {
            [index] => index,
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
        if let Some(strength) = scene.strength_mut(index) {
            *strength = Rgb::from_array(intensity);
        }
    }
    Ok(warnings)
}
