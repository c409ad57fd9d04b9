//! The keys of a material's reflectance: `reflectance`, `ior`, `layering` and `multiscatter`.

use serde::{Deserialize, Serialize};
use unrender_scene::reflectance::{IOR, IOR_MAX, f0_of_ior, ior_of_f0};
use unrender_scene::{BrdfModel, Layering, Material, Reflectance, Rgb};

/// How far `rho_s` may lie from the reflectance at normal incidence that `ior` means: rounding to three digits. With half of
/// it, hand-written numbers would be refused; with double of it, 0.04 would pass for 0.044.
const ROUNDED: f32 = 2e-3;

/// The reflectance of a lobe in a file; all keys are absent for the free one.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct ReflectanceEntry {
    /// `free`, `dielectric` or `metal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflectance: Option<String>,
    /// The refractive index of a dielectric.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ior: Option<f32>,
    /// How the base lies under a dielectric: `albedo-scaled` or `coupled`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layering: Option<String>,
    /// Whether a rough metal scatters light several times.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub multiscatter: Option<bool>,
}

impl ReflectanceEntry {
    /// That of `material`.
    pub fn of(material: &Material) -> Self {
        let named = |reflectance: Reflectance| Some(reflectance.name().to_owned());
        match material.reflectance {
            Reflectance::Free => Self::default(),
            reflectance @ Reflectance::Dielectric { ior, layering } => Self {
                reflectance: named(reflectance),
                ior: Some(ior),
                layering: Some(layering.name().to_owned()),
                multiscatter: None,
            },
            reflectance @ Reflectance::Metal { multiscatter } => Self {
                reflectance: named(reflectance),
                multiscatter: Some(multiscatter),
                ..Self::default()
            },
        }
    }

    /// The layering that it states, if it is one.
    pub(crate) fn layering(&self) -> Option<Layering> {
        self.layering.as_deref()?.parse().ok()
    }

    /// Sets the reflectance of `material`, whose `rho_s` is set already: `states_rho_s` says whether the file did. Where the
    /// file names no reflectance, it is free if `rho_s` is stated, and else stays as it is. A dielectric takes its `rho_s`
    /// from `ior`, or `ior` from `rho_s`; `model` has the layering of files that state none.
    ///
    /// # Errors
    /// If a key has no such value, or the model of the scene knows no such reflectance.
    pub fn apply(
        &self,
        states_rho_s: bool,
        model: BrdfModel,
        material: &mut Material,
    ) -> Result<(), String> {
        let was = material.reflectance;
        let named = match self.reflectance.as_deref() {
            Some(name) => name,
            None if self.ior.is_some() => "dielectric",
            None if states_rho_s => "free",
            None => was.name(),
        };
        material.reflectance = match named {
            "free" => Reflectance::Free,
            "dielectric" => self.dielectric(states_rho_s, was, model, material)?,
            "metal" => {
                let former = if let Reflectance::Metal { multiscatter } = was {
                    multiscatter
                } else {
                    model.layering() == Layering::AlbedoScaled
                };
                Reflectance::Metal { multiscatter: self.multiscatter.unwrap_or(former) }
            }
            other => {
                return Err(format!(
                    "reflectance is \"{other}\"; there are \"free\", \"dielectric\" and \"metal\""
                ));
            }
        };
        if !(material.reflectance.is_free() || model.is_principled()) {
            return Err(format!(
                "reflectance \"{named}\" is for brdf \"principled\"; the scene's is \"{model}\""
            ));
        }
        let unused = [
            ("ior", named != "dielectric" && self.ior.is_some()),
            ("layering", named != "dielectric" && self.layering.is_some()),
            ("multiscatter", named != "metal" && self.multiscatter.is_some()),
        ];
        match unused.iter().find(|(_, is)| *is) {
            Some((key, _)) => {
                Err(format!("{key} has no meaning for reflectance \"{named}\"; leave it out"))
            }
            None => Ok(()),
        }
    }

    fn dielectric(
        &self,
        states_rho_s: bool,
        was: Reflectance,
        model: BrdfModel,
        material: &mut Material,
    ) -> Result<Reflectance, String> {
        let (former_ior, former_layering) = match was {
            Reflectance::Dielectric { ior, layering } => (ior, layering),
            Reflectance::Free | Reflectance::Metal { .. } => (IOR, model.layering()),
        };
        let stated = material.rho_s;
        let mean = stated.element_sum() / 3.0;
        let is_grey = (stated - Rgb::splat(mean)).abs().max_element() <= ROUNDED;
        let ior = match self.ior {
            Some(ior) if ior > 1.0 && ior <= IOR_MAX => ior,
            Some(ior) => {
                return Err(format!(
                    "ior is {ior}; a dielectric's lies above 1 and up to {IOR_MAX}: what reflects more is a metal"
                ));
            }
            None if states_rho_s && !is_grey => {
                return Err("rho_s of a dielectric is grey; give ior in its place".into());
            }
            None if states_rho_s && mean > 0.0 && mean <= f0_of_ior(IOR_MAX) => ior_of_f0(mean),
            None if states_rho_s => {
                return Err(
                    "rho_s of a dielectric lies above 0 and up to 0.25; give ior in its place"
                        .into(),
                );
            }
            None => former_ior,
        };
        let f0 = Rgb::splat(f0_of_ior(ior));
        if states_rho_s && (stated - f0).abs().max_element() > ROUNDED {
            return Err(format!(
                "ior = {ior} means rho_s = {:.4}, not {:.4}; leave one of them out",
                f0.x, stated.x
            ));
        }
        material.rho_s = f0;
        let layering = self.layering.as_deref().map(str::parse).transpose()?;
        Ok(Reflectance::Dielectric { ior, layering: layering.unwrap_or(former_layering) })
    }
}
