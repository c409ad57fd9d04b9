//! Lights without a surface, and the light from all around.

use super::{float, point, rgb, safe, to_world, vector};
use crate::export::environment::{self, Around};
use crate::export::identifiers::identifiers;
use crate::export::{Files, SceneView, profiles};
use crate::record::light_note;
use crate::texels;
use glam::{Affine3A, DVec3, Mat3, Vec3};
use unrender_scene::{Environment, Image, LightKind, Rgb, RgbImage, Warnings};

/// Texels of the picture of a spot's cone, across and down.
const CONE_TEXELS: usize = 512;

/// All of them, and the pictures that they name.
pub(super) fn text(shot: &SceneView, warnings: &mut Warnings) -> Result<(String, Files), String> {
    let (lights, origin) = (&shot.scene.lights, shot.scene.origin);
    let ids = identifiers("l_", lights.iter().map(|l| l.name.as_str()));
    let (mut text, mut files) = (String::new(), Files::new());
    for (light, id) in lights.iter().zip(&ids) {
        let picture = format!("textures/{id}.exr");
        if let LightKind::Spot { outer_rad, .. } = light.kind {
            files.push((picture.clone(), texels::exr(&cone(&light.kind, outer_rad))?));
        }
        text.push_str(&format!(
            "    {}\n    {}\n",
            safe(&light_note(light, origin)),
            emitter(&profiles::without(light, "Mitsuba", warnings), &picture, origin)
        ));
    }
    match environment::around(shot.scene) {
        None => {}
        Some(Around::Uniform(radiance)) => {
            let radiance = rgb("radiance", radiance);
            text.push_str(&format!("    <emitter type=\"constant\">{radiance}</emitter>\n"));
        }
        Some(Around::Panorama(environment)) => {
            text.push_str(&envmap(&environment));
            files.push(environment::file(&from_pole_to_pole(&environment))?);
        }
    }
    Ok((text, files))
}

/// The emitter of a panorama. The middle of Mitsuba's lies along +z, that of ours along -z.
fn envmap(environment: &Environment) -> String {
    let turn = 180.0 + environment.rotation_rad().to_degrees();
    format!(
        "    <emitter type=\"envmap\">\n\
         \x20       <string name=\"filename\" value=\"{}\"/>\n\
         \x20       <transform name=\"to_world\"><rotate y=\"1\" angle=\"{turn}\"/></transform>\n\
         \x20   </emitter>\n",
        environment::FILE
    )
}

/// The panorama with its first and last row at the poles, where Mitsuba takes them to be; ours lie half a row off them.
/// In an even multiple of its rows ([`environment::size`]) every row of ours is one of these; one that is written in
/// its own rows is interpolated half a row off them.
fn from_pole_to_pole(environment: &Environment) -> RgbImage {
    let (width, height) = environment::size(environment);
    Image::from_fn(width, height + 1, |x, y| {
        environment.radiance_at(((x as f32 + 0.5) / width as f32, y as f32 / height as f32))
    })
}

fn emitter(kind: &LightKind, picture: &str, origin: DVec3) -> String {
    match *kind {
        LightKind::Point { position, intensity } => format!(
            "<emitter type=\"point\">{}{}</emitter>",
            point("position", position, origin),
            rgb("intensity", intensity)
        ),
        LightKind::Directional { direction, irradiance } => format!(
            "<emitter type=\"directional\">{}{}</emitter>",
            vector("direction", direction),
            rgb("irradiance", irradiance)
        ),
        LightKind::Spot { position, direction, intensity, outer_rad, .. } => {
            let right = direction.any_orthonormal_vector();
            let axes = Mat3::from_cols(right, direction.cross(right), direction);
            let angle = outer_rad.to_degrees();
            format!(
                "<emitter type=\"spot\">{}{}{}{}<texture type=\"bitmap\" name=\"texture\">\
                 <string name=\"filename\" value=\"{picture}\"/>\
                 <boolean name=\"raw\" value=\"true\"/>\
                 <string name=\"wrap_mode\" value=\"clamp\"/></texture></emitter>",
                to_world(Affine3A::from_mat3_translation(axes, position), origin),
                rgb("intensity", intensity),
                float("cutoff_angle", angle),
                float("beam_width", 0.999_9 * angle)
            )
        }
        // The caller has put a point in its place.
        LightKind::Profiled { .. } => String::new(),
    }
}

/// What a spot of intensity one sends into each direction, on a plane across its axis; Mitsuba's own
/// fall-off goes by the angle, that of glTF by its cosine.
fn cone(kind: &LightKind, outer_rad: f32) -> Image<Rgb> {
    let LightKind::Spot { inner_rad, .. } = *kind else { return Image::default() };
    let (position, direction, intensity) = (Vec3::ZERO, Vec3::NEG_Z, Rgb::ONE);
    let spot = LightKind::Spot { position, direction, intensity, inner_rad, outer_rad };
    Image::from_fn(CONE_TEXELS, CONE_TEXELS, |x, y| {
        let across =
            |i: usize| (2.0 * (i as f32 + 0.5) / CONE_TEXELS as f32 - 1.0) * outer_rad.tan();
        let towards = Vec3::new(across(x), across(y), -1.0).normalize();
        spot.illuminate(towards).2
    })
}
