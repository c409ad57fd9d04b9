//! The project file as in TOML, before its values are checked.

use crate::lighting::{RawEnvironment, RawLight};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use toml::Value;
use unrender_scene::UpAxis;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawProject {
    pub(super) scene: PathBuf,
    photo: Option<RawPhoto>,
    mask: Option<PathBuf>,
    response: Option<Value>,
    black_level: Option<Value>,
    white_level: Option<Value>,
    exposure: Option<Value>,
    vignetting: Option<Value>,
    camera: Option<Value>,
    #[serde(default)]
    pub(super) photos: Vec<RawShot>,
    pub(super) anchor: Option<RawAnchor>,
    #[serde(default)]
    pub(super) groups: BTreeMap<String, RawGroup>,
    #[serde(default)]
    pub(super) lights: RawLights,
    pub(super) environment: Option<RawEnvironment>,
    #[serde(default)]
    pub(super) recover: RawRecover,
    pub(super) light_units: Option<String>,
    pub(super) up_axis: Option<UpAxis>,
}

/// The keys of a photograph: at the top of a project, or in an entry of `[[photos]]`.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawShot {
    pub(super) photo: Option<RawPhoto>,
    pub(super) mask: Option<PathBuf>,
    pub(super) response: Option<Value>,
    pub(super) black_level: Option<Value>,
    pub(super) white_level: Option<Value>,
    pub(super) exposure: Option<Value>,
    pub(super) vignetting: Option<Value>,
    pub(super) camera: Option<Value>,
    pub(super) lights_off: Option<Vec<String>>,
    pub(super) lights_on: Option<Vec<String>>,
}

impl RawShot {
    /// The same, with the keys of `top` where it has none.
    pub(super) fn or(self, top: &Self) -> Self {
        Self {
            photo: self.photo.or_else(|| top.photo.clone()),
            mask: self.mask.or_else(|| top.mask.clone()),
            response: self.response.or_else(|| top.response.clone()),
            black_level: self.black_level.or_else(|| top.black_level.clone()),
            white_level: self.white_level.or_else(|| top.white_level.clone()),
            exposure: self.exposure.or_else(|| top.exposure.clone()),
            vignetting: self.vignetting.or_else(|| top.vignetting.clone()),
            camera: self.camera.or_else(|| top.camera.clone()),
            lights_off: self.lights_off,
            lights_on: self.lights_on,
        }
    }
}

impl RawProject {
    /// The keys of photographs at its top.
    pub(super) fn top(&self) -> RawShot {
        RawShot {
            photo: self.photo.clone(),
            mask: self.mask.clone(),
            response: self.response.clone(),
            black_level: self.black_level.clone(),
            white_level: self.white_level.clone(),
            exposure: self.exposure.clone(),
            vignetting: self.vignetting.clone(),
            camera: self.camera.clone(),
            lights_off: None,
            lights_on: None,
        }
    }
}

/// The photograph: the name of a file, or a table.
#[derive(Clone, Debug)]
pub(super) enum RawPhoto {
    File(PathBuf),
    Bracket(RawBracket),
}

/// Its table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBracket {
    pub(super) bracket: Vec<PathBuf>,
    pub(super) times: Option<Vec<Value>>,
}

impl<'de> Deserialize<'de> for RawPhoto {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PhotoVisitor)
    }
}

/// Reads both forms. Unlike `#[serde(untagged)]`, it keeps the lines of errors.
struct PhotoVisitor;

impl<'de> Visitor<'de> for PhotoVisitor {
    type Value = RawPhoto;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the name of a file, or { bracket = [\"a.jpg\", \"b.jpg\"] }")
    }

    fn visit_str<E>(self, name: &str) -> Result<RawPhoto, E> {
        Ok(RawPhoto::File(name.into()))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RawPhoto, A::Error> {
        RawBracket::deserialize(MapAccessDeserializer::new(map)).map(RawPhoto::Bracket)
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawAnchor {
    pub(super) group: String,
    pub(super) rho_d: Value,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawGroup {
    pub(super) known: Option<RawKnown>,
    pub(super) max_rung: Option<String>,
    pub(super) rungs: Option<Vec<String>>,
    pub(super) same_as: Option<String>,
    pub(super) like: Option<RawLike>,
    pub(super) rho_d: Option<RawBounds>,
    pub(super) rho_s: Option<RawBounds>,
    pub(super) alpha_x: Option<RawBounds>,
    pub(super) alpha_y: Option<RawBounds>,
    pub(super) theta_deg: Option<RawStart>,
    #[serde(default)]
    pub(super) ignore: bool,
}

/// The group that another one is like: its name, or a table.
#[derive(Debug)]
pub(super) struct RawLike {
    pub(super) group: String,
    pub(super) within: Option<f32>,
}

/// Its table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLikeTable {
    group: String,
    within: Option<f32>,
}

impl<'de> Deserialize<'de> for RawLike {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(LikeVisitor)
    }
}

/// Reads both forms. Unlike `#[serde(untagged)]`, it keeps the lines of errors.
struct LikeVisitor;

impl<'de> Visitor<'de> for LikeVisitor {
    type Value = RawLike;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("the name of a group, or { group = \"NAME\", within = 0.1 }")
    }

    fn visit_str<E>(self, name: &str) -> Result<RawLike, E> {
        Ok(RawLike { group: name.to_owned(), within: None })
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RawLike, A::Error> {
        let table = RawLikeTable::deserialize(MapAccessDeserializer::new(map))?;
        Ok(RawLike { group: table.group, within: table.within })
    }
}

/// The initial value of a group's parameter, and its bounds.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawBounds {
    pub(super) start: Option<Value>,
    pub(super) min: Option<Value>,
    pub(super) max: Option<Value>,
}

/// The initial value of a group's parameter.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawStart {
    pub(super) start: Value,
}

impl RawGroup {
    /// The key that states the hypotheses of the group, if there is one.
    pub(super) fn rungs_key(&self) -> Option<&'static str> {
        match (&self.rungs, &self.max_rung) {
            (Some(_), _) => Some("rungs"),
            (None, Some(_)) => Some("max_rung"),
            (None, None) => None,
        }
    }
}

/// The lights of a project: `[lights.NAME]`, or a list `[[lights]]`. If a light has two entries,
/// the second is an error when it is applied to the scene.
#[derive(Debug, Default)]
pub(super) struct RawLights {
    /// The entries of the list.
    pub(super) list: Vec<RawLight>,
    /// The lights stated as unknown (or known), by their names.
    pub(super) unknown: Vec<(String, bool)>,
}

/// The table `[lights.NAME]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawUnknown {
    unknown: bool,
}

impl<'de> Deserialize<'de> for RawLights {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(LightsVisitor)
    }
}

/// Reads both forms. Unlike `#[serde(untagged)]`, it keeps the lines of errors.
struct LightsVisitor;

impl<'de> Visitor<'de> for LightsVisitor {
    type Value = RawLights;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("tables [lights.NAME] or a list [[lights]]")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawLights, A::Error> {
        let mut lights = RawLights::default();
        while let Some((name, RawUnknown { unknown })) = map.next_entry()? {
            lights.unknown.push((name, unknown));
        }
        Ok(lights)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<RawLights, A::Error> {
        let mut lights = RawLights::default();
        while let Some(light) = list.next_element::<RawLight>()? {
            lights.unknown.extend(light.unknown.map(|unknown| (light.name.clone(), unknown)));
            lights.list.push(light);
        }
        Ok(lights)
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawKnown {
    pub(super) materialx: Option<PathBuf>,
    pub(super) material: Option<String>,
    pub(super) measured: Option<PathBuf>,
    pub(super) rho_d: Option<Value>,
    pub(super) rho_s: Option<Value>,
    pub(super) reflectance: Option<String>,
    pub(super) ior: Option<f32>,
    pub(super) layering: Option<String>,
    pub(super) multiscatter: Option<bool>,
    pub(super) alpha_x: Option<f32>,
    pub(super) alpha_y: Option<f32>,
    pub(super) theta_deg: Option<f32>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawRecover {
    pub(super) brdf: Option<String>,
    pub(super) layering: Option<String>,
    pub(super) max_rung: Option<String>,
    pub(super) rungs: Option<Vec<String>>,
    #[serde(default)]
    pub(super) thresholds: BTreeMap<String, f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    pub(super) eye: Option<[f64; 3]>,
    pub(super) target: Option<[f64; 3]>,
    pub(super) up: Option<[f32; 3]>,
    pub(super) fov_y_deg: Option<f32>,
    pub(super) near: Option<f32>,
    pub(super) principal_point: Option<[f32; 2]>,
    pub(super) fx_over_fy: Option<f32>,
    pub(super) fx: Option<f64>,
    pub(super) fy: Option<f64>,
    pub(super) cx: Option<f64>,
    pub(super) cy: Option<f64>,
    pub(super) k1: Option<f32>,
    pub(super) k2: Option<f32>,
    pub(super) k3: Option<f32>,
    pub(super) p1: Option<f32>,
    pub(super) p2: Option<f32>,
    pub(super) opencv: Option<PathBuf>,
    pub(super) view: Option<usize>,
    pub(super) colmap: Option<PathBuf>,
    pub(super) image: Option<String>,
    pub(super) scene_from_world: Option<Value>,
    pub(super) crop: Option<[f64; 2]>,
    pub(super) pixels: Option<String>,
}

impl RawCamera {
    /// Focal lengths and principal point in pixels, by their keys.
    pub(super) fn in_pixels(&self) -> [(&'static str, Option<f64>); 4] {
        [("fx", self.fx), ("fy", self.fy), ("cx", self.cx), ("cy", self.cy)]
    }

    /// The terms of the distortion, by their keys.
    pub(super) fn distortion(&self) -> [(&'static str, Option<f32>); 5] {
        let Self { k1, k2, k3, p1, p2, .. } = *self;
        [("k1", k1), ("k2", k2), ("k3", k3), ("p1", p1), ("p2", p2)]
    }
}
