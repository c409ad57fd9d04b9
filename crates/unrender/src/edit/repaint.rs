//! `[[repaint]]` and `[[insert.material]]`: materials that are changed.

use super::written::Written;
use crate::toml_values::{Channels, Finite, NotNegative, Reflectance};
use serde::Deserialize;
use std::path::PathBuf;
use std::sync::Arc;
use unrender_formats::{Input, materials};
use unrender_restage::Edit;
use unrender_restage::repaint::{Paint, Repaint};
use unrender_scene::{Texture, Warnings, Wrap};

/// One entry as in TOML.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPaint {
    /// In `[[repaint]]`: the group of the scene.
    pub(super) group: Option<String>,
    /// In `[[insert.material]]`: the model's own name of the material; all of them if there is none.
    pub(super) name: Option<String>,
    pub(super) rho_d: Option<Reflectance>,
    rho_s: Option<Reflectance>,
    alpha: Option<NotNegative>,
    alpha_x: Option<NotNegative>,
    alpha_y: Option<NotNegative>,
    theta_deg: Option<Finite>,
    pub(super) texture: Option<PathBuf>,
    tint: Option<Channels>,
}

impl RawPaint {
    /// The edit of an entry of `[[repaint]]`.
    pub(super) fn edit(&self, written: &Written, notes: &mut Warnings) -> Result<Edit, String> {
        match (&self.group, &self.name) {
            (Some(group), None) => {
                let paint = self.paint(written, notes)?;
                Ok(Edit::Repaint(Repaint { group: group.clone(), paint }))
            }
            _ => Err("repaint: name the group to repaint by group = \"GROUP\"".into()),
        }
    }

    /// The paint of an entry of `[[insert.material]]`, and the material that gets it.
    pub(super) fn of_model(
        &self,
        written: &Written,
        notes: &mut Warnings,
    ) -> Result<(Option<String>, Paint), String> {
        match &self.group {
            None => Ok((self.name.clone(), self.paint(written, notes)?)),
            Some(_) => Err("material: name the model's material by name = \"NAME\"".into()),
        }
    }

    fn paint(&self, written: &Written, notes: &mut Warnings) -> Result<Paint, String> {
        if self.alpha.is_some() && (self.alpha_x.is_some() || self.alpha_y.is_some()) {
            return Err("give alpha, or alpha_x and alpha_y".into());
        }
        if self.texture.is_some() && self.rho_d.is_some() {
            return Err("give rho_d or a texture, not both".into());
        }
        let texture = match &self.texture {
            Some(path) => {
                let read = materials::read_texture(Input::new(&written.path(path), written.limits));
                let (image, warnings) = read.map_err(|error| error.to_string())?;
                notes.extend(warnings);
                let (wrap_u, wrap_v) = (Wrap::Repeat, Wrap::Repeat);
                Some(Arc::new(Texture { image, wrap_u, wrap_v }))
            }
            None => None,
        };
        let alpha = |own: Option<NotNegative>| own.or(self.alpha).map(|alpha| alpha.0);
        Ok(Paint {
            rho_d: self.rho_d.map(|rho| rho.0),
            rho_s: self.rho_s.map(|rho| rho.0),
            alpha_x: alpha(self.alpha_x),
            alpha_y: alpha(self.alpha_y),
            theta_rad: self.theta_deg.map(|theta| theta.0.to_radians()),
            texture,
            tint: self.tint.map(|tint| tint.0),
        })
    }
}
