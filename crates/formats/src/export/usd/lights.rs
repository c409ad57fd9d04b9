//! Lights of USD. [OpenUSD, UsdLux]
//!
//! `inputs:intensity` is radiance; with `inputs:normalize` it is divided by the area of the light. A sphere of radius `r`
//! and radiance `L` has the radiant intensity `L pi r^2`; its area is `4 pi r^2`, so that a normalised sphere of any
//! radius has a quarter of `inputs:intensity`, W/sr. A distant light without an angle has it as irradiance.
//!
//! A cone is full up to the angle `s = (1 - softness) c` and falls as a smoothstep of the angle to zero at `c`; ours falls
//! as the square of a line in the cosine. `c` is our outer angle, and `s` the one by which both send the same light.

use super::stage::{Prim, Value};
use crate::export::environment::{self, Around};
use crate::export::layered::strength_and_color;
use crate::export::{Files, SceneView};
use glam::{DMat4, DVec3, Vec3};
use std::f64::consts::PI;
use unrender_scene::{LightKind, Rgb};

/// The radius of point lights and spots for programs that only know spheres, metres: 1 mm. Half or double of it has the same
/// penumbras, below what a picture of a room resolves.
const RADIUS: f32 = 1e-3;
/// Angles at which a cone's light is summed; their sum is within 1e-5. With half of them it is within 4e-5; double of them is
/// not seen in a softness.
const ANGLES: usize = 512;
/// Halvings of the interval in which a softness is sought: all digits of single precision. Half of them leave 1/4096 of the
/// cone; double of them change nothing.
const HALVINGS: usize = 24;

/// The prim called `id` of the light `name`; none of a profile, for which the caller puts a point.
pub(super) fn light(id: &str, name: &str, kind: &LightKind) -> Option<Prim> {
    Some(match *kind {
        LightKind::Point { position, intensity } => {
            let mut prim = point(id, name, intensity);
            prim.place(DMat4::from_translation(position.as_dvec3()));
            prim
        }
        LightKind::Spot { position, direction, intensity, inner_rad, outer_rad } => {
            let mut prim = point(id, name, intensity).with_schema("ShapingAPI");
            let softness = softness(f64::from(inner_rad), f64::from(outer_rad));
            let angle = f64::from(outer_rad).to_degrees() as f32;
            prim.set("float", "inputs:shaping:cone:angle", Value::Float(angle));
            prim.set("float", "inputs:shaping:cone:softness", Value::Float(softness as f32));
            prim.place(along(direction, position));
            prim
        }
        LightKind::Directional { direction, irradiance } => {
            let mut prim = Prim::new("DistantLight", id).named(name);
            prim.set("float", "inputs:angle", Value::Float(0.0));
            shine(&mut prim, irradiance, 1.0);
            prim.set("bool", "inputs:normalize", Value::Bool(true));
            prim.place(along(direction, Vec3::ZERO));
            prim
        }
        LightKind::Profiled { .. } => return None,
    })
}

/// A sphere of no size, of this radiant intensity.
fn point(id: &str, name: &str, intensity: Rgb) -> Prim {
    let mut prim = Prim::new("SphereLight", id).named(name);
    shine(&mut prim, intensity, 4.0);
    prim.set("bool", "inputs:normalize", Value::Bool(true));
    prim.set("float", "inputs:radius", Value::Float(RADIUS));
    prim.set("bool", "treatAsPoint", Value::Bool(true));
    prim
}

/// Gives `prim` the colour of `strength`, and `factor` times it as its intensity.
fn shine(prim: &mut Prim, strength: Rgb, factor: f32) {
    let (strength, color) = strength_and_color(strength);
    prim.set("color3f", "inputs:color", Value::Float3(color));
    prim.set("float", "inputs:intensity", Value::Float(factor * strength));
}

/// From a light's axes, of which -z is the way it shines, to the world.
fn along(direction: Vec3, position: Vec3) -> DMat4 {
    let back: DVec3 = -direction.as_dvec3().normalize_or(DVec3::NEG_Z);
    let (right, up) = back.any_orthonormal_pair();
    DMat4::from_cols(
        right.extend(0.0),
        up.extend(0.0),
        back.extend(0.0),
        position.as_dvec3().extend(1.0),
    )
}

/// The softness of a cone that sends as much light as ours of these half angles.
pub(super) fn softness(inner: f64, outer: f64) -> f64 {
    let cosines = [inner, outer].map(f64::cos);
    let ours = |angle: f64| {
        let share = (angle.cos() - cosines[1]) / (cosines[0] - cosines[1]).max(1e-3);
        share.clamp(0.0, 1.0).powi(2)
    };
    let wanted = sent(outer, ours);
    let [mut low, mut high] = [0.0, 1.0];
    for _ in 0..HALVINGS {
        let softness: f64 = 0.5 * (low + high);
        let sent = sent(outer, |angle| cone(angle, outer, softness));
        if sent > wanted { low = softness } else { high = softness }
    }
    0.5 * (low + high)
}

/// The share of its full intensity that a cone of USD has at `angle` from its axis.
pub(super) fn cone(angle: f64, outer: f64, softness: f64) -> f64 {
    let full = outer * (1.0 - softness);
    let share = ((angle - full) / (outer - full).max(1e-9)).clamp(0.0, 1.0);
    1.0 - share * share * (3.0 - 2.0 * share)
}

/// The light that a cone of a `falloff` sends, for one W/sr on its axis.
pub(super) fn sent(outer: f64, falloff: impl Fn(f64) -> f64) -> f64 {
    let step = outer / ANGLES as f64;
    let angles = (0..ANGLES).map(|k| (k as f64 + 0.5) * step);
    2.0 * PI * step * angles.map(|angle| falloff(angle) * angle.sin()).sum::<f64>()
}

/// The light from all around, its panorama among `files` under the path that `name` gives it.
///
/// # Errors
/// If the panorama is too large for its file.
pub(super) fn dome(
    shot: &SceneView,
    name: impl Fn(&str) -> String,
    files: &mut Files,
) -> Result<Option<Prim>, String> {
    let Some(around) = environment::around(shot.scene) else { return Ok(None) };
    let mut prim = Prim::new("DomeLight", "environment");
    match around {
        Around::Uniform(radiance) => shine(&mut prim, radiance, 1.0),
        Around::Panorama(environment) => {
            let (file, bytes) = environment::file(&environment::panorama(&environment))?;
            let file = name(&file);
            prim.set("color3f", "inputs:color", Value::Float3(Rgb::ONE));
            prim.set("float", "inputs:intensity", Value::Float(1.0));
            prim.set("asset", "inputs:texture:file", Value::Asset(format!("./{file}")));
            prim.set("token", "inputs:texture:format", Value::token("latlong"));
            // The middle of USD's panoramas lies along z, that of ours along -z.
            prim.place(DMat4::from_rotation_y(PI + f64::from(environment.rotation_rad())));
            files.push((file, bytes));
        }
    }
    Ok(Some(prim))
}
