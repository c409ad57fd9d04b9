//! Inserting a model into the scene.

use crate::repaint::Paint;
use crate::stage::Stage;
use crate::{size, snap};
use glam::{Affine3A, DVec3, Quat, Vec3};
use unrender_scene::{Light, LightKind, Mesh, Scene};

/// Inserts a model. Its objects and groups get the prefix `name.`.
#[derive(Clone, Debug, PartialEq)]
pub struct Insert {
    /// The name of the inserted model.
    pub name: String,
    /// Its meshes, groups and lights, which passed `Scene::validate_meshes`.
    pub model: Scene,
    /// Rotation about its own origin, before it is set upright in the scene: its own y points upwards.
    pub rotation: Quat,
    /// Scale factor, above zero.
    pub scale: f32,
    /// Position.
    pub place: Place,
    /// Replacements of its materials: for the named group of the model, or for all groups.
    pub paint: Vec<(Option<String>, Paint)>,
}

/// The position of a model.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// The position of its origin in the world of the scene's file, metres.
    At(DVec3),
    /// On the highest upward-facing surface of a group at given horizontal coordinates.
    Onto {
        /// The group.
        group: String,
        /// The horizontal world coordinates, metres: x and z, or x and y where z points upwards.
        at: [f64; 2],
    },
    /// At the first hit of a ray.
    Seen {
        /// Origin of the ray, metres, as positions of the scene count.
        origin: Vec3,
        /// Unit vector along the ray.
        direction: Vec3,
        /// The group that the ray must hit, if stated.
        group: Option<String>,
    },
}

pub(crate) fn apply(insert: &Insert, stage: &mut Stage<'_>) -> Result<(), String> {
    let name = insert.name.as_str();
    let prefix = format!("{name}.");
    let scene = &*stage.scene;
    let groups = scene.groups.iter().map(|g| &g.name);
    let mut names = groups
        .chain(scene.objects.iter().map(|o| &o.name))
        .chain(scene.ungrouped.iter().map(|shape| &shape.material));
    if names.any(|there| there == name || there.starts_with(&prefix)) {
        return Err(format!(
            "something in the scene is called \"{name}\" already; give the inserted object another \
             name"
        ));
    }
    let mut model = insert.model.clone();
    paint(insert, &mut model)?;
    let rotation = scene.up.rotation() * insert.rotation;
    let turned =
        Affine3A::from_scale_rotation_translation(Vec3::splat(insert.scale), rotation, Vec3::ZERO);
    model.meshes_mut().for_each(|mesh| transform_mesh(mesh, &turned));
    let Some([low, high]) = model.bounds() else {
        return Err(format!("the model of \"{name}\" has no triangles"));
    };
    let up = scene.up.unit();
    let foot = 0.5 * (low + high) - 0.5 * (high - low).dot(up) * up;
    let shift = match &insert.place {
        Place::At(position) => {
            // A model far from its own zero has its positions relative to its middle.
            let scale = f64::from(insert.scale);
            let midst = rotation.as_dquat() * (scale * insert.model.origin);
            scene.here(*position + midst)
        }
        Place::Onto { group, at } => snap::highest(scene, group, *at)? - foot,
        Place::Seen { origin, direction, group } => {
            snap::seen(scene, *origin, *direction, group.as_deref())? - foot
        }
    };
    let moved = Affine3A::from_translation(shift);
    model.meshes_mut().for_each(|mesh| transform_mesh(mesh, &moved));
    if let Some([a, b]) = scene.bounds() {
        let doubt = size::doubt((name, insert.scale), low.distance(high), a.distance(b));
        if (low + shift).cmpgt(b).any() || (high + shift).cmplt(a).any() {
            return Err(format!(
                "\"{name}\" stands outside the scene, which reaches from {} to {}: it would reach \
                 from {} to {}{}",
                scene.shown(a),
                scene.shown(b),
                scene.shown(low + shift),
                scene.shown(high + shift),
                doubt.map(|doubt| format!("; {doubt}")).unwrap_or_default()
            ));
        }
        doubt.into_iter().for_each(|doubt| stage.change.warnings.push(doubt));
    }
    let world_from_model = moved * turned;
    model
        .lights
        .iter_mut()
        .for_each(|light| transform_light(light, &world_from_model, insert.scale));
    join(insert, model, stage);
    Ok(())
}

/// Replaces the materials of the model's groups.
fn paint(insert: &Insert, model: &mut Scene) -> Result<(), String> {
    for (group, paint) in &insert.paint {
        let wanted = |name: &str| group.as_ref().is_none_or(|g| g == name);
        if !model.groups.iter().any(|g| wanted(&g.name)) {
            let there = crate::stage::some_names(
                group.as_deref().unwrap_or_default(),
                model.groups.iter().map(|g| g.name.as_str()),
            );
            return Err(format!(
                "the model has no material \"{}\"; it has {there}",
                group.as_deref().unwrap_or_default()
            ));
        }
        for of_model in model.groups.iter_mut().filter(|g| wanted(&g.name)) {
            paint.onto(&mut of_model.material).map_err(|error| error.to_string())?;
        }
    }
    Ok(())
}

/// Adds the transformed model to the scene.
fn join(insert: &Insert, model: Scene, stage: &mut Stage<'_>) {
    let first = stage.scene.groups.len();
    let prefix = &insert.name;
    let glossy = model.groups.iter().any(|g| g.material.is_glossy());
    if glossy && model.brdf != stage.scene.brdf {
        stage.change.warnings.push(format!(
            "the materials of \"{prefix}\" are for the lobe {}; the scene's, {}, was taken",
            model.brdf, stage.scene.brdf
        ));
    }
    for mut group in model.groups {
        group.name = format!("{prefix}.{}", group.name);
        stage.scene.groups.push(group);
    }
    for mut object in model.objects {
        object.name = format!("{prefix}.{}", object.name);
        object.group += first;
        stage.scene.objects.push(object);
        stage.change.origin.push(None);
    }
    for mut shape in model.ungrouped {
        shape.material = format!("{prefix}.{}", shape.material);
        stage.scene.ungrouped.push(shape);
    }
    for mut light in model.lights {
        light.name = format!("{prefix}.{}", light.name);
        stage.scene.lights.push(light);
    }
}

/// Transforms a mesh by a similarity.
fn transform_mesh(mesh: &mut Mesh, transform: &Affine3A) {
    let turn = |v: Vec3| transform.transform_vector3(v).normalize_or(v);
    mesh.positions.iter_mut().for_each(|p| *p = transform.transform_point3(*p));
    mesh.normals.iter_mut().for_each(|n| *n = turn(*n));
    mesh.tangents.iter_mut().for_each(|t| *t = turn(t.truncate()).extend(t.w));
}

/// Transforms a light by a similarity of the given scale. Radiance is invariant, so radiant
/// intensity is proportional to the area.
fn transform_light(light: &mut Light, transform: &Affine3A, scale: f32) {
    let turn = |v: Vec3| transform.transform_vector3(v).normalize_or(v);
    match &mut light.kind {
        LightKind::Point { position, intensity } => {
            *position = transform.transform_point3(*position);
            *intensity *= scale * scale;
        }
        LightKind::Spot { position, direction, intensity, .. } => {
            *position = transform.transform_point3(*position);
            *direction = turn(*direction);
            *intensity *= scale * scale;
        }
        LightKind::Directional { direction, .. } => *direction = turn(*direction),
        LightKind::Profiled { position, direction, upright, intensity, .. } => {
            *position = transform.transform_point3(*position);
            (*direction, *upright) = (turn(*direction), turn(*upright));
            *intensity *= scale * scale;
        }
    }
}
