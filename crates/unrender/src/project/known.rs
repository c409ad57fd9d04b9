//! A project's known materials: the key `known` of `[groups.NAME]`, with numbers, or with a file that states them.

use super::raw::{RawGroup, RawKnown};
use super::values::reflectance;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::Value;
use unrender_formats::materials::ReflectanceEntry;
use unrender_formats::{FileError, Input, Limits, materialx, merl};
use unrender_measured::{Form, chosen, fit};
use unrender_scene::{BrdfModel, Layering, Material, Rgb, Scene, Warnings};

/// A known material in the project; parts that are left out do not exist: no texture, no lobe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// The file that states it instead of the numbers, if there is one.
    pub file: Option<KnownFile>,
    /// Diffuse reflectance.
    pub rho_d: Rgb,
    /// Specular reflectance; none if it is not stated.
    pub rho_s: Option<Rgb>,
    /// What `rho_s` means.
    #[serde(with = "crate::as_json")]
    pub reflectance: ReflectanceEntry,
    /// Roughness along the anisotropy direction.
    pub alpha_x: f32,
    /// Roughness across it.
    pub alpha_y: f32,
    /// Anisotropy direction, radians from the surface's tangent.
    pub theta_rad: f32,
}

/// A file that states the material of a group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum KnownFile {
    /// A MaterialX file, and the name of the material in it; that of the group if it is none.
    Materialx(PathBuf, Option<String>),
    /// A measured BRDF, which is fitted.
    Measured(PathBuf),
}

impl KnownFile {
    /// Where it is.
    pub fn path(&self) -> &Path {
        match self {
            Self::Materialx(path, _) | Self::Measured(path) => path,
        }
    }
}

impl Known {
    /// Where it is not zero, the group reflects light; that of a file is not read yet, and none is black.
    pub(super) fn reflecting(&self) -> Rgb {
        if self.file.is_some() { Rgb::ONE } else { self.rho_d + self.rho_s.unwrap_or(Rgb::ZERO) }
    }

    /// The material in a scene of the BRDF `model`.
    ///
    /// # Errors
    /// If the model knows no such reflectance.
    pub fn material(&self, model: BrdfModel) -> Result<Material, String> {
        let Self { rho_d, rho_s, alpha_x, alpha_y, theta_rad, .. } = *self;
        let shape = Material { alpha_x, alpha_y, theta_rad, ..Material::diffuse(rho_d) };
        let mut material = Material { rho_s: rho_s.unwrap_or(Rgb::ZERO), ..shape };
        self.reflectance.apply(rho_s.is_some(), model, &mut material)?;
        Ok(material)
    }
}

impl KnownFile {
    /// Gives the group at `index` in `scene` the material of this file.
    ///
    /// # Errors
    /// If the file cannot be read or has no such material.
    pub(crate) fn apply(
        &self,
        scene: &mut Scene,
        index: usize,
        limits: Limits,
    ) -> Result<Warnings, FileError> {
        let input = Input::new(self.path(), limits);
        match self {
            Self::Materialx(_, name) => materialx::apply_to(input, scene, (index, name.as_deref())),
            Self::Measured(path) => {
                let fits = fit(&merl::read(input)?, &Form::of(Some(scene.brdf)))
                    .map_err(|error| FileError::because(path, "cannot be fitted", error))?;
                let mut told = Warnings::default();
                if let Some(best) = chosen(&fits) {
                    let group = &mut scene.groups[index];
                    group.material = best.material.clone();
                    told.push(format!(
                        "{}: the group \"{}\" has the {} that fits it best, with an error of {:.3}; unrender fit-brdf \
                         shows all fits",
                        path.display(),
                        group.name,
                        best.form.hypothesis,
                        best.errors.compressed
                    ));
                }
                Ok(told)
            }
        }
    }
}

/// The materials that are stated, by the names of their groups; files are seen from `folder`.
pub(super) fn all(
    groups: &BTreeMap<String, RawGroup>,
    folder: &Path,
) -> Result<BTreeMap<String, Known>, String> {
    let stated = groups.iter().filter_map(|(name, group)| Some((name, group.known.as_ref()?)));
    let read = |(name, raw): (&String, &RawKnown)| {
        Ok((name.clone(), known(&format!("groups.{name}.known"), raw, folder)?))
    };
    stated.map(read).collect()
}

/// The file that states the material.
fn file(key: &str, raw: &RawKnown, folder: &Path) -> Result<Option<KnownFile>, String> {
    let has_numbers = raw.rho_d.is_some()
        || raw.rho_s.is_some()
        || raw.reflectance.is_some()
        || raw.ior.is_some()
        || raw.layering.is_some()
        || raw.multiscatter.is_some()
        || raw.alpha_x.is_some()
        || raw.alpha_y.is_some()
        || raw.theta_deg.is_some();
    let found = match (&raw.materialx, &raw.measured) {
        (Some(_), Some(_)) => return Err(format!("{key}: give materialx or measured, not both")),
        (Some(path), None) => KnownFile::Materialx(folder.join(path), raw.material.clone()),
        (None, Some(path)) => KnownFile::Measured(folder.join(path)),
        (None, None) if raw.material.is_some() => {
            return Err(format!("{key}: material is a name in a file; name the file by materialx"));
        }
        (None, None) => return Ok(None),
    };
    if has_numbers {
        return Err(format!("{key}: a file states the material; leave out the numbers"));
    }
    if raw.measured.is_some() && raw.material.is_some() {
        return Err(format!("{key}: a measured BRDF has no material names; leave out material"));
    }
    Ok(Some(found))
}

fn known(key: &str, raw: &RawKnown, folder: &Path) -> Result<Known, String> {
    let file = file(key, raw, folder)?;

    if file.is_none() && raw.rho_d.is_none() && raw.rho_s.is_none() {
        return Err(format!(
            "{key}: give rho_d or rho_s or both, or a file by materialx or measured"
        ));
    }
    let rho = |name: &str, value: &Option<Value>| {
        value.as_ref().map(|value| reflectance(&format!("{key}.{name}"), value)).transpose()
    };
    let alpha_x = raw.alpha_x.or(raw.alpha_y).unwrap_or(0.0);
    let alpha_y = raw.alpha_y.unwrap_or(alpha_x);
    for (name, alpha) in [("alpha_x", alpha_x), ("alpha_y", alpha_y)] {
        if !(alpha.is_finite() && alpha >= 0.0) {
            return Err(format!("{key}.{name} is {alpha}; a roughness is zero or positive"));
        }
    }
    if (alpha_x > 0.0) != (alpha_y > 0.0) {
        return Err(format!("{key}: alpha_x and alpha_y are both positive or both zero"));
    }
    let theta_deg = raw.theta_deg.unwrap_or(0.0);
    if !theta_deg.is_finite() {
        return Err(format!("{key}.theta_deg is {theta_deg}; give an angle in degrees"));
    }
    let known = Known {
        file,
        rho_d: rho("rho_d", &raw.rho_d)?.unwrap_or(Rgb::ZERO),
        rho_s: rho("rho_s", &raw.rho_s)?,
        reflectance: ReflectanceEntry {
            reflectance: raw.reflectance.clone(),
            ior: raw.ior,
            layering: raw.layering.clone(),
            multiscatter: raw.multiscatter,
        },
        alpha_x,
        alpha_y,
        theta_rad: theta_deg.to_radians(),
    };
    // Whatever the scene's model is, some model has to know it.
    let any = BrdfModel::Principled(Layering::default());
    known.material(any).map_err(|problem| format!("{key}: {problem}"))?;
    Ok(known)
}
