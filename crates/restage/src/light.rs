//! Changing, adding and removing lights.
//!
//! An area light is a group that emits, with its objects; punctual lights are in `Scene::lights`.

use crate::stage::{Stage, some_names};
use glam::{DVec3, Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use unrender_scene::color::LUMINANCE;
use unrender_scene::{
    ENVIRONMENT, Group, LUMENS_PER_WATT, Light, LightKind, LightProfile, Material, Mesh, Object,
    Reach, Rgb, Scene, UpAxis,
};

/// Changes, adds or removes one light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightEdit {
    /// The name of the light: of a group that emits, of a punctual light, or `environment`.
    pub name: String,
    /// The change.
    pub change: LightChange,
    /// How bright it is afterwards, if that is stated in photometric units.
    pub photometric: Option<Photometric>,
}

/// The brightness of a light in photometric units, 683 lm/W; its colour stays as it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Photometric {
    /// The unit.
    pub unit: PhotometricUnit,
    /// The number in that unit.
    pub value: f64,
    /// Factor on the strength that this gives, by channel.
    pub scale: Rgb,
}

/// The unit of a light's brightness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PhotometricUnit {
    /// The flux of a lamp.
    Lumens,
    /// The greatest intensity of a lamp without a surface.
    Candela,
    /// The illuminance of a surface that faces a directional light.
    Lux,
}

/// A change of a light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LightChange {
    /// Changes its parameters.
    Alter(Alter),
    /// Removes it; for an area light, its objects, too.
    Remove,
    /// Adds it; its position counts from this place in the world of the scene's file, metres.
    Add(NewLight, DVec3),
}

/// A change of the parameters of a light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alter {
    /// Factor on its strength, by channel; zero switches it off.
    pub scale: Rgb,
    /// New strength before that factor, in the unit of its kind: radiance, radiant intensity or
    /// irradiance.
    pub strength: Option<Rgb>,
    /// Translation, metres.
    pub shift: Vec3,
    /// New axis of emission, a unit vector: spots, directional lights and lamps with a profile.
    pub direction: Option<Vec3>,
    /// The photometric profile that a point or spot light shines by from now on.
    pub profile: Option<LightProfile>,
    /// Rotation of a profile about its axis, counter-clockwise seen from behind the lamp, radians.
    pub turn_rad: Option<f32>,
}

/// A new light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum NewLight {
    /// A punctual light.
    Punctual(LightKind),
    /// A lamp that shines by a photometric profile.
    Profiled {
        /// Its place, metres.
        position: Vec3,
        /// The unit vector in which it is aimed; none for straight down.
        direction: Option<Vec3>,
        /// Rotation about that axis, counter-clockwise seen from behind the lamp, radians.
        turn_rad: f32,
        /// Radiant intensity where the profile has its greatest, W sr^-1 per channel.
        intensity: Rgb,
        /// The profile.
        profile: LightProfile,
    },
    /// A rectangle that emits from its front.
    Area {
        /// Its centre, metres.
        centre: Vec3,
        /// Unit normal of its front.
        normal: Vec3,
        /// Its two sides, metres.
        size: Vec2,
        /// Radiance, W sr^-1 m^-2 per channel.
        radiance: Rgb,
    },
    /// A sphere that emits from its outside.
    Sphere {
        /// Its centre, metres.
        centre: Vec3,
        /// Its radius, metres.
        radius: f32,
        /// Radiance, W sr^-1 m^-2 per channel.
        radiance: Rgb,
    },
}

/// An existing light.
enum LightRef {
    Area(usize),
    Punctual(usize),
    Environment,
}

pub(crate) fn apply(edit: &LightEdit, stage: &mut Stage<'_>) -> Result<(), String> {
    stage.claim("light", &edit.name)?;
    change(edit, stage)?;
    match &edit.photometric {
        Some(photometric) => shine(&edit.name, photometric, stage),
        None => Ok(()),
    }
}

fn change(edit: &LightEdit, stage: &mut Stage<'_>) -> Result<(), String> {
    if let LightChange::Add(new, place) = &edit.change {
        return add(&edit.name, moved(new.clone(), stage.scene.here(*place)), stage);
    }
    match (find(&edit.name, stage)?, &edit.change) {
        (found, LightChange::Alter(alter)) => alter_light(&edit.name, &found, alter, stage),
        (LightRef::Area(group), _) => {
            let of_group: Vec<bool> =
                stage.scene.objects.iter().map(|object| object.group == group).collect();
            stage.retain_objects(|index| !of_group[index]);
            Ok(())
        }
        (LightRef::Punctual(index), _) => {
            stage.scene.lights.remove(index);
            Ok(())
        }
        (LightRef::Environment, _) => {
            stage.scene.environment = None;
            Ok(())
        }
    }
}

/// Gives the light `name` the brightness `photometric`, in its own colour, or white if it was black.
fn shine(name: &str, photometric: &Photometric, stage: &mut Stage<'_>) -> Result<(), String> {
    let Photometric { unit, value, scale } = *photometric;
    let found = find(name, stage)?;
    let scene = &mut stage.scene;
    // How much of the unit a strength of one makes, over the luminous efficacy.
    let of_one = match (&found, unit) {
        (LightRef::Area(group), PhotometricUnit::Lumens) => Some(PI * area(scene, *group)),
        (LightRef::Punctual(index), PhotometricUnit::Lumens) => {
            scene.lights[*index].kind.steradians()
        }
        (LightRef::Punctual(index), _) => {
            let is_directional = scene.lights[*index].kind.reach().is_none();
            (is_directional == (unit == PhotometricUnit::Lux)).then_some(1.0)
        }
        _ => None,
    };
    let Some(of_one) = of_one.filter(|of_one| *of_one > 0.0) else {
        return Err(format!(
            "\"{name}\" cannot be as bright as that unit says: lumens are for lamps and area lights, candela for point \
             and spot lights and lamps with a profile, lux for directional lights"
        ));
    };
    let strength = match found {
        LightRef::Area(group) => &mut scene.groups[group].emission,
        LightRef::Punctual(index) => scene.lights[index].kind.strength_mut(),
        LightRef::Environment => return Ok(()),
    };
    let now = strength.as_dvec3();
    let color = if now.max_element() > 0.0 { now } else { DVec3::ONE };
    let luminance = LUMINANCE.as_dvec3().dot(color);
    *strength = (color * (value / (LUMENS_PER_WATT * of_one * luminance))).as_vec3() * scale;
    let is_finite = strength.is_finite();
    is_finite.then_some(()).ok_or_else(|| format!("\"{name}\" would be infinitely bright"))
}

/// The area of the surfaces of a group, m^2.
fn area(scene: &Scene, group: usize) -> f64 {
    let objects = scene.objects.iter().filter(|object| object.group == group);
    let triangles = objects.flat_map(|object| {
        (0..object.mesh.triangles.len()).map(|index| object.mesh.corners(index))
    });
    let of_triangle = |corners: [Vec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    };
    triangles.map(of_triangle).sum()
}

fn find(name: &str, stage: &Stage<'_>) -> Result<LightRef, String> {
    let groups = stage.scene.groups.len();
    let around = groups + stage.scene.lights.len();
    let found = stage.scene.sources().filter(|s| s.name == name).map(|s| s.index);
    match found.collect::<Vec<usize>>()[..] {
        [index] if index < groups => Ok(LightRef::Area(index)),
        [index] if index < around => Ok(LightRef::Punctual(index - groups)),
        [_] => Ok(LightRef::Environment),
        [] => {
            let there = some_names(name, stage.scene.sources().map(|s| s.name));
            Err(format!(
                "the scene has no light \"{name}\"; it has {there}; add = \"...\" adds one"
            ))
        }
        _ => Err(format!("several lights are called \"{name}\"; rename them in the scene")),
    }
}

fn alter_light(
    name: &str,
    found: &LightRef,
    alter: &Alter,
    stage: &mut Stage<'_>,
) -> Result<(), String> {
    let change = &mut stage.change;
    let scene = &mut stage.scene;
    let strength = match *found {
        LightRef::Area(group) => {
            if alter.direction.is_some() {
                return Err(format!("\"{name}\" is an area light, which has no direction to set"));
            }
            if alter.profile.is_some() || alter.turn_rad.is_some() {
                return Err(format!(
                    "\"{name}\" is an area light, which has no profile; remove it, and add a point light with one"
                ));
            }
            let objects = scene.objects.iter_mut().zip(&mut change.origin);
            for (object, origin) in objects.filter(|(o, _)| o.group == group) {
                if alter.shift != Vec3::ZERO {
                    object.mesh.positions.iter_mut().for_each(|p| *p += alter.shift);
                    *origin = None;
                }
            }
            &mut scene.groups[group].emission
        }
        LightRef::Punctual(index) => {
            place(name, &mut scene.lights[index].kind, scene.up, alter)?;
            scene.lights[index].kind.strength_mut()
        }
        LightRef::Environment => return scale_environment(alter, scene),
    };
    *strength = alter.strength.unwrap_or(*strength) * alter.scale;
    Ok(())
}

/// All of the environment has one factor here; another edit replaces it.
fn scale_environment(alter: &Alter, scene: &mut Scene) -> Result<(), String> {
    let is_shaped =
        alter.direction.is_some() || alter.profile.is_some() || alter.turn_rad.is_some();
    if alter.strength.is_some() || is_shaped || alter.shift != Vec3::ZERO {
        return Err(format!(
            "\"{ENVIRONMENT}\" is the light from all around: give scale, or off; the table [environment] replaces it"
        ));
    }
    if alter.scale == Rgb::ZERO {
        scene.environment = None;
        return Ok(());
    }
    for part in scene.environment_parts() {
        scene.scale_source(part, alter.scale);
    }
    Ok(())
}

/// Puts, turns and shapes the light `kind` of a scene of which `up` points upwards.
fn place(name: &str, kind: &mut LightKind, up: UpAxis, alter: &Alter) -> Result<(), String> {
    if let Some(profile) = &alter.profile {
        *kind = profiled(name, kind, profile, up)?;
    }
    match kind {
        LightKind::Point { .. } | LightKind::Spot { .. } | LightKind::Directional { .. }
            if alter.turn_rad.is_some() =>
        {
            return Err(format!(
                "\"{name}\" has no profile; turn_deg turns a lamp with a profile about its axis"
            ));
        }
        LightKind::Point { .. } if alter.direction.is_some() => {
            return Err(format!("\"{name}\" is a point light, which has no direction"));
        }
        LightKind::Directional { .. } if alter.shift != Vec3::ZERO => {
            return Err(format!(
                "\"{name}\" shines from infinitely far away and cannot be moved; give a direction"
            ));
        }
        LightKind::Point { position, .. } => *position += alter.shift,
        LightKind::Spot { position, direction, .. } => {
            *position += alter.shift;
            *direction = alter.direction.unwrap_or(*direction);
        }
        LightKind::Profiled { position, direction, upright, .. } => {
            *position += alter.shift;
            *direction = alter.direction.unwrap_or(*direction);
            if alter.direction.is_some() || alter.turn_rad.is_some() {
                *upright = turned(*direction, up, alter.turn_rad.unwrap_or(0.0));
            }
        }
        LightKind::Directional { direction, .. } => {
            *direction = alter.direction.unwrap_or(*direction);
        }
    }
    Ok(())
}

/// The lamp `kind` with a profile; one that had no direction is aimed straight down.
fn profiled(
    name: &str,
    kind: &LightKind,
    profile: &LightProfile,
    up: UpAxis,
) -> Result<LightKind, String> {
    let Some(Reach { position, .. }) = kind.reach() else {
        return Err(format!(
            "\"{name}\" shines from infinitely far away, where no lamp with a profile is"
        ));
    };
    let direction = match *kind {
        LightKind::Spot { direction, .. } | LightKind::Profiled { direction, .. } => direction,
        _ => -up.unit(),
    };
    let upright = match *kind {
        LightKind::Profiled { upright, .. } => upright,
        _ => turned(direction, up, 0.0),
    };
    let (intensity, profile) = (kind.strength(), profile.clone());
    Ok(LightKind::Profiled { position, direction, upright, intensity, profile })
}

/// The horizontal angle 0 of a profile with the axis `direction`, turned about it.
fn turned(direction: Vec3, up: UpAxis, turn_rad: f32) -> Vec3 {
    Quat::from_axis_angle(-direction, turn_rad) * LightKind::upright(direction, up.unit())
}

/// The light `new`, moved by `place`.
fn moved(mut new: NewLight, place: Vec3) -> NewLight {
    match &mut new {
        NewLight::Punctual(
            LightKind::Point { position, .. }
            | LightKind::Spot { position, .. }
            | LightKind::Profiled { position, .. },
        )
        | NewLight::Profiled { position, .. }
        | NewLight::Area { centre: position, .. }
        | NewLight::Sphere { centre: position, .. } => *position += place,
        NewLight::Punctual(LightKind::Directional { .. }) => {}
    }
    new
}

fn add(name: &str, new: NewLight, stage: &mut Stage<'_>) -> Result<(), String> {
    let scene = &mut stage.scene;
    if scene.sources().any(|s| s.name == name) || scene.group_index(name).is_some() {
        return Err(format!(
            "the scene has a light or a group \"{name}\" already; call the new light differently"
        ));
    }
    let (mesh, emission) = match new {
        NewLight::Punctual(kind) => {
            scene.lights.push(Light { name: name.to_owned(), kind });
            return Ok(());
        }
        NewLight::Profiled { position, direction, turn_rad, intensity, profile } => {
            let direction = direction.unwrap_or(-scene.up.unit());
            let upright = turned(direction, scene.up, turn_rad);
            let kind = LightKind::Profiled { position, direction, upright, intensity, profile };
            scene.lights.push(Light { name: name.to_owned(), kind });
            return Ok(());
        }
        NewLight::Area { centre, normal, size, radiance } => {
            (rectangle(centre, normal, size), radiance)
        }
        NewLight::Sphere { centre, radius, radiance } => (Mesh::sphere(centre, radius), radiance),
    };
    let group = scene.groups.len();
    let material = Material::diffuse(Rgb::ZERO);
    scene.groups.push(Group { name: name.to_owned(), material, emission });
    scene.objects.push(Object { name: name.to_owned(), group, mesh });
    stage.change.origin.push(None);
    Ok(())
}

/// A rectangle about `centre` that faces `normal`; its first side is level.
fn rectangle(centre: Vec3, normal: Vec3, size: Vec2) -> Mesh {
    let across = Vec3::Y.cross(normal).try_normalize().unwrap_or(Vec3::X);
    let turn = Quat::from_mat3(&glam::Mat3::from_cols(across, normal.cross(across), normal));
    let corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    let positions = corners.map(|(x, y)| centre + turn * Vec3::new(x * size.x, y * size.y, 0.0));
    Mesh::flat(&positions, &[], &[[0, 1, 2], [0, 2, 3]])
}
