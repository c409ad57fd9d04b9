//! Lights without a surface, in Radiance's words: small glowing spheres, and distant sources.
//!
//! A sphere of radius `r` and radiance `I / (pi r^2)` has the radiant intensity `I` in every
//! direction, and exactly the irradiance of a point; what a spot or a photometric profile sends into a direction is a
//! pattern on the sphere, by the direction of the ray.

use super::{place, profiles, triple};
use crate::export::identifiers::identifiers;
use crate::export::{Files, SceneView};
use crate::record::light_note;
use glam::{DVec3, Vec3};
use std::f32::consts::PI;
use unrender_scene::LightKind;

/// Radius of the spheres that stand for points, metres.
const RADIUS: f32 = 1e-3;
/// Angular diameter of distant sources, degrees.
const DISTANT_DEG: f32 = 0.1;

/// All of them as primitives.
pub(super) fn text(shot: &SceneView, files: &mut Files) -> String {
    let lights = &shot.scene.lights;
    let ids = identifiers("l_", lights.iter().map(|l| l.name.as_str()));
    let texts = lights.iter().zip(&ids).map(|(light, id)| {
        let origin = shot.scene.origin;
        if let LightKind::Profiled { profile, .. } = &light.kind {
            files.push((data_file(id), profiles::data(profile).into_bytes()));
        }
        format!("\n# {}\n{}", light_note(light, origin), primitives(&light.kind, id, origin))
    });
    texts.collect()
}

fn primitives(kind: &LightKind, id: &str, origin: DVec3) -> String {
    let per_area = 1.0 / (PI * RADIUS * RADIUS);
    match *kind {
        LightKind::Profiled { position, direction, upright, intensity, ref profile } => {
            let pattern = format!("{id}.profile");
            let axes = [direction, upright];
            profiles::pattern(&pattern, &data_file(id), profile.photometry(), axes)
                + &light(&pattern, id, intensity * per_area)
                + &sphere(id, &place(position, origin))
        }
        LightKind::Point { position, intensity } => {
            light("void", id, intensity * per_area) + &sphere(id, &place(position, origin))
        }
        LightKind::Spot { position, direction, intensity, inner_rad, outer_rad } => {
            let cone = format!("{id}.cone");
            falloff(&cone, direction, inner_rad, outer_rad)
                + &light(&cone, id, intensity * per_area)
                + &sphere(id, &place(position, origin))
        }
        LightKind::Directional { direction, irradiance } => {
            // The projected solid angle of the disk: pi sin^2 of its angular radius.
            let sin = (0.5 * DISTANT_DEG).to_radians().sin();
            let radiance = irradiance / (PI * sin * sin);
            let to_light = triple(-direction);
            light("void", id, radiance)
                + &format!("{id} source {id}.disk\n0\n0\n4 {to_light} {DISTANT_DEG}\n")
        }
    }
}

/// The file of the profile of the lamp with the identifier `id`.
fn data_file(id: &str) -> String {
    format!("profiles/{id}.dat")
}

fn light(modifier: &str, id: &str, radiance: Vec3) -> String {
    format!("{modifier} light {id}\n0\n0\n3 {}\n", triple(radiance))
}

fn sphere(id: &str, place: &str) -> String {
    format!("{id} sphere {id}.sphere\n0\n0\n4 {place} {RADIUS}\n")
}

/// The formula that `KHR_lights_punctual` recommends: the square of a line in the cosine. A ray
/// that sees the light goes along `D`, against the light's way.
fn falloff(id: &str, direction: Vec3, inner_rad: f32, outer_rad: f32) -> String {
    let (cos_inner, cos_outer) = (inner_rad.cos(), outer_rad.cos());
    let slope = 1.0 / (cos_inner - cos_outer).max(1e-3);
    let d = direction;
    let line = format!("({slope}*(-(Dx*({})+Dy*({})+Dz*({}))-({cos_outer})))", d.x, d.y, d.z);
    format!("void brightfunc {id}\n2 if({line},if({line}-1,1,{line}*{line}),0) .\n0\n0\n")
}
