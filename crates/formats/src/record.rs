//! Exact Ward parameters where a format has room for our data: glTF's extras, and comments in front of
//! what they describe.
//!
//! Such a comment says what follows (`group`, `object`, `light` or `camera`) and then, as JSON on
//! the same line, its name or, for groups, an object with `name` and the parameters.

use crate::materials::ReflectanceEntry;
use crate::numbers::{degrees, number, radians, triple, triple_at};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use unrender_scene::{BrdfModel, Group, Light, LightKind, Material, Reflectance, Rgb};

/// The comment about `group`.
pub(crate) fn group_note(group: &Group, brdf: BrdfModel) -> String {
    let mut json = json!(Record::of(&group.material, brdf));
    json["name"] = Value::from(group.name.as_str());
    format!("group {json}")
}

/// The comment about `light`, whose position counts from `origin`.
pub(crate) fn light_note(light: &Light, origin: DVec3) -> String {
    let vector = |v: Vec3| v.to_array().map(number);
    let strength = triple(light.kind.strength());
    let json = match light.kind {
        LightKind::Point { position, .. } => {
            json!({ "kind": "point", "position": triple_at(origin, position) })
        }
        LightKind::Directional { direction, .. } => {
            json!({ "kind": "directional", "direction": vector(direction) })
        }
        LightKind::Spot { position, direction, inner_rad, outer_rad, .. } => json!({
            "kind": "spot",
            "position": triple_at(origin, position),
            "direction": vector(direction),
            "inner_deg": degrees(inner_rad),
            "outer_deg": degrees(outer_rad),
        }),
        LightKind::Profiled { position, direction, upright, ref profile, .. } => json!({
            "kind": "profiled",
            "position": triple_at(origin, position),
            "direction": vector(direction),
            "upright": vector(upright),
            "profile": profile,
        }),
    };
    let mut json = json;
    json["name"] = Value::from(light.name.as_str());
    json["strength"] = json!(strength);
    format!("light {json}")
}

/// Three numbers of `json`.
fn vector(json: &Value, key: &str) -> Option<DVec3> {
    let list: Option<Vec<f64>> = json[key].as_array()?.iter().map(Value::as_f64).collect();
    <[f64; 3]>::try_from(list?).ok().map(DVec3::from_array)
}

/// The light that [`light_note`] has written down, its position counted from `origin`.
fn light(json: &Value, origin: DVec3) -> Option<Light> {
    let vector_from = |origin: DVec3, key: &str| {
        Some((vector(json, key)? - origin).as_vec3()).filter(|v| v.is_finite())
    };
    let vector = |key: &str| vector_from(DVec3::ZERO, key);
    let position = || vector_from(origin, "position");
    let angle = |key: &str| json[key].as_f64().map(radians);
    let strength = vector("strength").filter(|s| s.min_element() >= 0.0)?;
    let kind = match json["kind"].as_str()? {
        "point" => LightKind::Point { position: position()?, intensity: strength },
        "directional" => {
            LightKind::Directional { direction: vector("direction")?, irradiance: strength }
        }
        "spot" => LightKind::Spot {
            position: position()?,
            direction: vector("direction")?,
            intensity: strength,
            inner_rad: angle("inner_deg")?,
            outer_rad: angle("outer_deg")?,
        },
        "profiled" => LightKind::Profiled {
            position: position()?,
            direction: vector("direction")?,
            upright: vector("upright")?,
            intensity: strength,
            profile: serde_json::from_value(json["profile"].clone()).ok()?,
        },
        _ => return None,
    };
    Some(Light { name: json["name"].as_str()?.to_owned(), kind })
}

/// The contents of one of our comments.
#[derive(Clone, Debug, Default)]
pub(crate) struct Note {
    /// The name of what follows.
    pub(crate) name: Option<String>,
    /// The exact material, of groups; without its texture.
    pub(crate) material: Option<(Material, BrdfModel)>,
    /// The exact light.
    pub(crate) light: Option<Light>,
    /// Where the light is in the world, in double precision; zero if it has no place.
    pub(crate) light_at: DVec3,
    /// Whether nothing follows the comment yet.
    pub(crate) is_first: bool,
}

impl Note {
    /// The note in `comment`, if it is one; positions count from `origin`.
    pub(crate) fn parse(comment: &str, origin: DVec3) -> Option<Self> {
        let (kind, json) = comment.trim().split_once(' ')?;
        if !["group", "object", "light", "camera"].contains(&kind) {
            return None;
        }
        let json: Value = serde_json::from_str(json).ok()?;
        let name = json.as_str().or_else(|| json["name"].as_str()).map(str::to_owned);
        let record = serde_json::from_value::<Record>(json.clone()).ok();
        let material = record.and_then(|record| record.to_material().ok());
        let light = light(&json, origin);
        let light_at = vector(&json, "position").unwrap_or_default();
        Some(Self { name, material, light, light_at, is_first: true })
    }
}

/// Ward's parameters as `extras.unrender` has them; the numbers read back to the same bits.
#[derive(Serialize, Deserialize)]
pub(crate) struct Record {
    brdf: String,
    rho_d: [f64; 3],
    rho_s: [f64; 3],
    alpha_x: f64,
    alpha_y: f64,
    theta_deg: f64,
    #[serde(flatten)]
    reflectance: ReflectanceEntry,
}

impl Record {
    pub(crate) fn of(material: &Material, brdf: BrdfModel) -> Self {
        Self {
            brdf: brdf.name().into(),
            rho_d: triple(material.rho_d),
            rho_s: triple(material.rho_s),
            alpha_x: number(material.alpha_x),
            alpha_y: number(material.alpha_y),
            theta_deg: degrees(material.theta_rad),
            reflectance: ReflectanceEntry::of(material),
        }
    }

    /// The material (without a texture) and the BRDF model of the record.
    pub(crate) fn to_material(&self) -> Result<(Material, BrdfModel), String> {
        let brdf: BrdfModel = self.brdf.parse()?;
        let mut material = Material {
            rho_d: Rgb::from_array(self.rho_d.map(|c| c as f32)),
            rho_s: Rgb::from_array(self.rho_s.map(|c| c as f32)),
            reflectance: Reflectance::Free,
            alpha_x: self.alpha_x as f32,
            alpha_y: self.alpha_y as f32,
            theta_rad: radians(self.theta_deg),
            texture: None,
        };
        let lengths = [material.alpha_x, material.alpha_y].into_iter();
        let lengths = lengths.chain(material.rho_d.to_array()).chain(material.rho_s.to_array());
        if !material.theta_rad.is_finite() || !lengths.into_iter().all(|x| x.is_finite() && x >= 0.)
        {
            return Err("has numbers that are negative or not finite".into());
        }
        let brdf = brdf.with_layering(self.reflectance.layering());
        self.reflectance.apply(true, brdf, &mut material)?;
        Ok((material, brdf))
    }
}
