//! Emitters without a surface: points, spots, directions, and environments.

use super::paint::{Context, color};
use super::spectrum::Use;
use super::tree::Node;
use super::{sky, spot};
use crate::picture;
use glam::{DAffine3, Mat3, Vec3};
use std::f32::consts::{PI, TAU};
use unrender_scene::{Depth, Environment, Light, LightKind, Rgb, RgbImage};

/// What an emitter is.
pub(super) enum Emitter {
    Light(Light),
    Environment(Environment),
}

/// The emitters that `node` is; none if its file is missing.
pub(super) fn read(context: &Context, node: Node) -> Result<Vec<Emitter>, String> {
    match node.kind() {
        "envmap" => Ok(panorama(context, node)?.map(Emitter::Environment).into_iter().collect()),
        "sunsky" | "sky" | "sun" => {
            let (light, around) = sky::read(context, node)?;
            let light = light.map(Emitter::Light);
            Ok(light.into_iter().chain(around.map(Emitter::Environment)).collect())
        }
        _ => plain(context, node).map(|emitter| vec![emitter]),
    }
}

fn plain(context: &Context, node: Node) -> Result<Emitter, String> {
    if let Some(light) = &node.note().light {
        return Ok(Emitter::Light(light.clone()));
    }
    let id = if node.id().is_empty() { "light" } else { node.id() };
    let name = node.note().name.clone().unwrap_or_else(|| id.into());
    let world = || node.motion("to_world");
    let kind = match node.kind() {
        "point" => {
            let position = match node.point("position")? {
                Some(position) => position,
                None => node.place("to_world")?,
            };
            let position = (position - context.scope.origin()).as_vec3();
            LightKind::Point { position, intensity: light(context, node, "intensity")? }
        }
        "directional" => {
            let direction = match node.vector("direction")? {
                Some(direction) => direction,
                None => world()?.matrix3.z_axis.as_vec3(),
            };
            let direction = direction.try_normalize();
            let direction = direction.ok_or_else(|| node.fail("its direction is zero"))?;
            LightKind::Directional { direction, irradiance: light(context, node, "irradiance")? }
        }
        "spot" => {
            let name = format!("light \"{name}\"");
            spot_light(context, node, &name, &world()?)?
        }
        "constant" => {
            let radiance = light(context, node, "radiance")?;
            let panorama = RgbImage::new(2, 1, vec![radiance; 2]);
            let around = Environment::new(panorama, 0.0).map_err(|error| node.fail(error))?;
            return Ok(Emitter::Environment(around));
        }
        "area" => return Err(node.fail("an emitter of type \"area\" stands outside of a shape")),
        _ => {
            return Err(node.refused(
                "supported are area, point, spot, directional, constant, envmap, sunsky, sky and sun",
            ));
        }
    };
    Ok(Emitter::Light(Light { name, kind }))
}

fn light(context: &Context, node: Node, name: &str) -> Result<Rgb, String> {
    color(context, node, name, Use::Emission, 1.0)
}

fn spot_light(
    context: &Context,
    node: Node,
    name: &str,
    world: &DAffine3,
) -> Result<LightKind, String> {
    let outer = node.positive("cutoff_angle", 20.0)?;
    let inner = node.number("beam_width", 0.75 * outer)?;
    let [beam, cutoff] =
        [inner.clamp(0.0, outer), outer].map(|angle| f64::from(angle).to_radians());
    let cone = spot::nearest(beam, cutoff);
    if cone.off > 0.0 {
        context.warn(format!(
            "{name}: Mitsuba's spots fade linearly in the angle from beam_width to cutoff_angle; \
             the nearest cone was taken, which fades from {:.1} to {:.1} degrees: it sends the \
             same light in all, and differs at some angles by up to {:.0} % of the intensity",
            cone.inner_rad.to_degrees(),
            cone.outer_rad.to_degrees(),
            (100.0 * cone.off).ceil()
        ));
    }
    let texture = color(context, node, "texture", Use::Index, 1.0)?;
    let direction = world.matrix3.z_axis.as_vec3().try_normalize();
    Ok(LightKind::Spot {
        position: (world.translation - context.scope.origin()).as_vec3(),
        direction: direction.ok_or_else(|| node.fail("its direction is zero"))?,
        intensity: light(context, node, "intensity")? * texture,
        inner_rad: cone.inner_rad,
        outer_rad: cone.outer_rad,
    })
}

/// Resamples a panorama whose first and last row lie at the poles, as Mitsuba's, to one whose rows lie half a row off
/// them, as ours. Without it, with 16 rows, a sun halfway up is 3 degrees off, and a floor 3 % too dark.
fn between_poles(theirs: &RgbImage) -> RgbImage {
    let (width, height) = (theirs.width(), theirs.height());
    RgbImage::from_fn(width, height, |column, row| {
        let place = (row as f32 + 0.5) * (height - 1) as f32 / height as f32;
        let above = place as usize;
        let below = (above + 1).min(height - 1);
        theirs.at(column, above).lerp(*theirs.at(column, below), place - above as f32)
    })
}

/// The panorama of an `envmap`, whose middle lies along +z, up along +y, before `to_world`; none if its file is
/// missing.
fn panorama(context: &Context, node: Node) -> Result<Option<Environment>, String> {
    let Some(path) = node.file(context.scope, "filename")? else {
        let file = node.text("filename")?.unwrap_or_default();
        context
            .warn(node.fail(format!("the picture \"{file}\" is missing; its envmap was left out")));
        node.pass_all();
        return Ok(None);
    };
    let (read, told) =
        picture::read_in(context.scope, &path).map_err(|error| node.fail(error.to_string()))?;
    context.warnings.borrow_mut().extend(told);
    if read.depth != Depth::Float {
        let what = "an envmap that is an sRGB picture lacks what was brighter than its white";
        context.warn(node.fail(what));
    }
    let scale = node.number("scale", 1.0)?;
    let radiance = between_poles(&read.to_linear().map(|rgb| rgb.max(Rgb::ZERO) * scale));
    let world = node.motion("to_world")?.matrix3;
    let axes = [world.x_axis, world.y_axis, world.z_axis];
    let [x, y, z] = axes.map(|axis| axis.normalize_or_zero().as_vec3());
    let around = |image, turn| Environment::new(image, turn).map_err(|error| node.fail(error));
    let is_upright = (y - Vec3::Y).length() < 1e-6 && x.cross(y).dot(z) > 0.0;
    if is_upright {
        // Ours has its middle along -z.
        let turn = z.x.atan2(z.z) - PI;
        return around(radiance, if turn <= -PI { turn + TAU } else { turn }).map(Some);
    }
    let local_from_world = Mat3::from_cols(x, y, z).inverse();
    if !local_from_world.is_finite() {
        return Err(node.wrong("to_world", "a motion: it makes the panorama flat"));
    }
    let size = (radiance.width(), radiance.height());
    let bytes = (size.0 * size.1 * size_of::<Rgb>()) as u64;
    context.scope.charge(bytes).map_err(|problem| node.fail(problem))?;
    let [local, upright] =
        [around(radiance, -PI)?, around(RgbImage::new(1, 1, vec![Rgb::ZERO]), 0.0)?];
    let turned = RgbImage::from_fn(size.0, size.1, |column, row| {
        let u = (column as f32 + 0.5) / size.0 as f32;
        let v = (row as f32 + 0.5) / size.1 as f32;
        let direction = upright.direction(u, Environment::cos_polar(v));
        local.radiance((local_from_world * direction).normalize_or(Vec3::Y))
    });
    around(turned, 0.0).map(Some)
}
