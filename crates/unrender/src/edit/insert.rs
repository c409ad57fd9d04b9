//! `[[insert]]`: models that are put into the scene.

use super::developed::Photograph;
use super::repaint::RawPaint;
use super::written::Written;
use crate::toml_values::{Ground, Place as At, Positive, Size, Way};
use glam::{EulerRot, Quat, Vec3};
use serde::Deserialize;
use std::path::PathBuf;
use unrender_formats::Input;
use unrender_restage::Edit;
use unrender_restage::insert::{Insert, Place};
use unrender_scene::{Scene, Warnings};

/// One entry as in TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawInsert {
    name: Option<String>,
    pub(super) file: PathBuf,
    position: Option<At>,
    on: Option<String>,
    at: Option<Ground>,
    pixel: Option<Size>,
    rotation_deg: Option<Way>,
    scale: Option<Positive>,
    #[serde(default)]
    pub(super) material: Vec<RawPaint>,
}

impl RawInsert {
    /// The edit of `scene`, which `photograph` shows, by this entry; reads the model.
    pub(super) fn edit(
        &self,
        written: &Written,
        (scene, photograph): (&Scene, Option<&Photograph>),
        notes: &mut Warnings,
    ) -> Result<Edit, String> {
        let path = written.path(&self.file);
        let input = Input::new(&path, written.limits).with_brdf(scene.brdf);
        let (model, warnings) =
            unrender_formats::load_model(input).map_err(|error| error.to_string())?;
        notes.extend(warnings);
        let stem = || self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let turn = self.rotation_deg.map_or(Vec3::ZERO, |turn| turn.0.map(f32::to_radians));
        let paint = self.material.iter().map(|material| material.of_model(written, notes));
        Ok(Edit::Insert(Insert {
            paint: paint.collect::<Result<_, String>>()?,
            name: self.name.clone().unwrap_or_else(stem),
            model,
            rotation: Quat::from_euler(EulerRot::ZYX, turn.z, turn.y, turn.x),
            scale: self.scale.map_or(1.0, |scale| scale.0),
            place: self.place(photograph)?,
        }))
    }

    fn place(&self, photograph: Option<&Photograph>) -> Result<Place, String> {
        match (self.position, self.at, self.pixel) {
            (Some(position), None, None) if self.on.is_none() => Ok(Place::At(position.0)),
            (None, Some(at), None) => {
                let group =
                    self.on.clone().ok_or("at = [x, z] needs on = \"GROUP\" to stand on")?;
                Ok(Place::Onto { group, at: at.0.to_array() })
            }
            (None, None, Some(pixel)) => self
                .seen_at(pixel, photograph.ok_or("pixel needs the photograph; name the project")?),
            _ => Err("give one place: position = [x, y, z]; on = \"GROUP\" with at = [x, z]; or \
                      pixel = [x, y]"
                .into()),
        }
    }

    /// The place that the photograph shows at `pixel`.
    fn seen_at(&self, Size(pixel): Size, photograph: &Photograph) -> Result<Place, String> {
        let (camera, (width, height)) = (&photograph.camera, photograph.size());
        if !(0.0..width as f32).contains(&pixel.x) || !(0.0..height as f32).contains(&pixel.y) {
            return Err(format!("pixel is {pixel}, outside the photograph of {width} x {height}"));
        }
        let direction = camera.direction(pixel.x, pixel.y, width, height);
        Ok(Place::Seen { origin: camera.origin(), direction, group: self.on.clone() })
    }
}
