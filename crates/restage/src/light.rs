//! Changing, adding and removing lights.
//!
//! An area light is a group that emits, with its objects; punctual lights are in `Scene::lights`.

use crate::stage::{Stage, some_names};
use glam::{DVec3, Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use unrender_scene::{ENVIRONMENT, Group, Light, LightKind, Material, Mesh, Object, Rgb, Scene};

/// Changes, adds or removes one light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightEdit {
    /// The name of the light: of a group that emits, of a punctual light, or `environment`.
    pub name: String,
    /// The change.
    pub change: LightChange,
}

/// A change of a light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LightChange {
    /// Changes its parameters.
    Alter(Alter),
    /// Removes it; for an area light, its objects, too.
    Remove,
    /// Adds it; its position counts from this place in the world of the scene's file, metres.
    Add(NewLight, DVec3),
}

/// A change of the parameters of a light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Alter {
    /// Factor on its strength, by channel; zero switches it off.
    pub scale: Rgb,
    /// New strength before that factor, in the unit of its kind: radiance, radiant intensity or
    /// irradiance.
    pub strength: Option<Rgb>,
    /// Translation, metres.
    pub shift: Vec3,
    /// New axis of emission, a unit vector: spots and directional lights.
    pub direction: Option<Vec3>,
}

/// A new light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum NewLight {
    /// A punctual light.
    Punctual(LightKind),
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
    if let LightChange::Add(new, place) = edit.change {
        return add(&edit.name, moved(new, stage.scene.here(place)), stage);
    }
    match (find(&edit.name, stage)?, edit.change) {
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
    alter: Alter,
    stage: &mut Stage<'_>,
) -> Result<(), String> {
    let change = &mut stage.change;
    let scene = &mut stage.scene;
    let strength = match *found {
        LightRef::Area(group) => {
            if alter.direction.is_some() {
                return Err(format!("\"{name}\" is an area light, which has no direction to set"));
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
            place(name, &mut scene.lights[index].kind, alter)?;
            scene.lights[index].kind.strength_mut()
        }
        LightRef::Environment => return scale_environment(alter, scene),
    };
    *strength = alter.strength.unwrap_or(*strength) * alter.scale;
    Ok(())
}

/// All of the environment has one factor here; another edit replaces it.
fn scale_environment(alter: Alter, scene: &mut Scene) -> Result<(), String> {
    if alter.strength.is_some() || alter.direction.is_some() || alter.shift != Vec3::ZERO {
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

fn place(name: &str, kind: &mut LightKind, alter: Alter) -> Result<(), String> {
    match kind {
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
        LightKind::Directional { direction, .. } => {
            *direction = alter.direction.unwrap_or(*direction);
        }
    }
    Ok(())
}

/// The light `new`, moved by `place`.
fn moved(mut new: NewLight, place: Vec3) -> NewLight {
    match &mut new {
        NewLight::Punctual(
            LightKind::Point { position, .. } | LightKind::Spot { position, .. },
        )
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
