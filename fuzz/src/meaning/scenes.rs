//! Mutates scenes by their meaning: cameras, lamps, shapes, materials, and the measures of all.

use super::rooms::{World, quad};
use crate::random::Random;
use glam::{Affine3A, Mat3, Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;
use unrender::scene::reflectance::Layering;
use unrender::scene::{Camera, Image, LightKind, Material, Mesh, Rgb, Texture, Wrap};

/// A mutation with its name.
type Mutation = (&'static str, fn(&mut World, &mut Random));

/// All of them; the camera has two shares, as what is seen decides most of what follows.
const ALL: [Mutation; 16] = [
    ("camera anywhere", camera_anywhere),
    ("camera anywhere", camera_anywhere),
    ("camera close", camera_close),
    ("lamp moved", lamp_moved),
    ("lamp scaled", lamp_scaled),
    ("lamp removed", lamp_removed),
    ("no lamps", no_lamps),
    ("lamp added", lamp_added),
    ("light from around", light_from_around),
    ("units", units),
    ("units of lamps", units_of_lamps),
    ("far from zero", far_from_zero),
    ("up axis", up_axis),
    ("shape changed", shape_changed),
    ("material", material),
    ("texture coordinates", texture_coordinates),
];

/// Changes `world` in one to four ways; returns their names.
pub(super) fn mutate(world: &mut World, random: &mut Random) -> Vec<&'static str> {
    let count = 1 + random.below(4);
    let mut one = || {
        let (name, mutation) = *random.one(&ALL);
        mutation(world, random);
        name
    };
    (0..count).map(|_| one()).collect()
}

/// The middle of all shapes, and half the length of their box's diagonal.
fn extent(world: &World) -> (Vec3, f32) {
    let [low, high] = world.scene.bounds().unwrap_or([Vec3::NEG_ONE, Vec3::ONE]);
    (0.5 * (low + high), 0.5 * (high - low).length())
}

/// A place in or near the scene.
fn place(world: &World, random: &mut Random) -> Vec3 {
    let (middle, radius) = extent(world);
    let far = *random.one(&[0.3, 0.6, 1.5, 20.0]);
    middle + random.vector(-1.0, 1.0) * radius * far
}

/// A direction, sometimes along an axis.
fn direction(random: &mut Random) -> Vec3 {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    let any = random.vector(-1.0, 1.0).normalize_or(Vec3::Y);
    if random.once_in(3) { *random.one(&axes) } else { any }
}

/// A power of ten, `decades` up or down at most.
pub(super) fn power(random: &mut Random, decades: f32) -> f32 {
    10f32.powf(random.between(-decades, decades))
}

/// A colour, sometimes without some channels.
pub(super) fn colour(random: &mut Random) -> Rgb {
    let any = random.vector(0.0, 1.0);
    match random.below(8) {
        0 => Rgb::ZERO,
        1 => Rgb::ONE,
        2 => Rgb::new(any.x, 0.0, 0.0),
        3 => Rgb::splat(any.x),
        _ => any,
    }
}

fn look(world: &mut World, eye: Vec3, target: Vec3, random: &mut Random) {
    let back = (eye - target).normalize_or(Vec3::Z);
    let up = direction(random);
    let up = if up.cross(back).length() < 1e-3 { back.any_orthogonal_vector() } else { up };
    let degrees = *random.one(&[2.0f32, 20.0, 45.0, 60.0, 90.0, 140.0, 170.0]);
    let camera = Camera::look_at("camera", eye, eye - back, up, degrees.to_radians());
    world.scene.cameras = vec![Camera { aspect: Some(4.0 / 3.0), ..camera }];
}

fn camera_anywhere(world: &mut World, random: &mut Random) {
    let (middle, radius) = extent(world);
    let (eye, elsewhere) = (place(world, random), place(world, random));
    let within = middle + random.vector(-0.5, 0.5) * radius;
    let target = if random.once_in(4) { elsewhere } else { within };
    look(world, eye, target, random);
}

/// A camera just before, on or behind a surface.
fn camera_close(world: &mut World, random: &mut Random) {
    let (_, radius) = extent(world);
    let Some(object) = some_object(world, random) else { return };
    let mesh = &world.scene.objects[object].mesh;
    let Some(index) = (!mesh.triangles.is_empty()).then(|| random.below(mesh.triangles.len()))
    else {
        return;
    };
    let [a, b, c] = mesh.corners(index);
    let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
    let target = (a + b + c) / 3.0;
    let away = radius * *random.one(&[-0.01f32, 0.0, 1e-6, 1e-3, 0.1, 1.0]);
    look(world, target + normal * away + direction(random) * away, target, random);
}

fn some_object(world: &World, random: &mut Random) -> Option<usize> {
    let count = world.scene.objects.len();
    (count > 0).then(|| random.below(count))
}

/// The index of a group that emits.
fn some_lamp(world: &World, random: &mut Random) -> Option<usize> {
    let groups = world.scene.groups.iter().enumerate();
    let lamps: Vec<usize> = groups.filter(|(_, g)| g.is_emitter()).map(|(i, _)| i).collect();
    (!lamps.is_empty()).then(|| *random.one(&lamps))
}

fn lamp_moved(world: &mut World, random: &mut Random) {
    let (to, turn) = (place(world, random), Quat::from_axis_angle(direction(random), PI));
    let count = world.scene.lights.len();
    if count > 0 && random.once_in(2) {
        let index = random.below(count);
        let direct = self::direction(random);
        match &mut world.scene.lights[index].kind {
            LightKind::Point { position, .. } => *position = to,
            LightKind::Spot { position, direction, .. } => (*position, *direction) = (to, direct),
            LightKind::Directional { direction, .. } => *direction = direct,
            LightKind::Profiled { position, direction, upright, .. } => {
                (*position, *direction) = (to, direct);
                *upright = LightKind::upright(direct, Vec3::Y);
            }
        }
    } else if let Some(group) = some_lamp(world, random) {
        let turn = if random.once_in(2) { turn } else { Quat::IDENTITY };
        for object in world.scene.objects.iter_mut().filter(|o| o.group == group) {
            let from = object.mesh.positions.first().copied().unwrap_or_default();
            let moved = Affine3A::from_rotation_translation(turn, to - turn * from);
            transform_mesh(&mut object.mesh, moved);
        }
    }
}

fn lamp_scaled(world: &mut World, random: &mut Random) {
    let factor = colour(random) * power(random, 4.0);
    let sources = world.scene.groups.len() + world.scene.lights.len();
    if let Some(strength) = world.scene.strength_mut(random.below(sources)) {
        *strength *= factor;
    }
}

fn lamp_removed(world: &mut World, random: &mut Random) {
    let count = world.scene.lights.len();
    if count > 0 && random.once_in(2) {
        world.scene.lights.remove(random.below(count));
    } else if let Some(group) = some_lamp(world, random) {
        world.scene.groups[group].emission = Rgb::ZERO;
    }
}

fn no_lamps(world: &mut World, _: &mut Random) {
    world.scene.lights.clear();
    world.around = None;
    world.scene.groups.iter_mut().for_each(|group| group.emission = Rgb::ZERO);
}

fn lamp_added(world: &mut World, random: &mut Random) {
    let (_, radius) = extent(world);
    let (at, towards) = (place(world, random), direction(random));
    let strength = colour(random) * power(random, 2.0);
    let name = format!("added {}", world.scene.lights.len() + world.scene.groups.len());
    let side = radius * power(random, 3.0).min(1.0);
    match random.below(5) {
        0 => {
            let position = at;
            world
                .shine(&name, LightKind::Point { position, intensity: strength * radius * radius });
        }
        1 => {
            let outer_rad = random.between(0.01, 0.5 * PI);
            let kind = LightKind::Spot {
                position: at,
                direction: towards,
                intensity: strength * radius * radius,
                inner_rad: outer_rad * random.between(0.0, 1.0),
                outer_rad,
            };
            world.shine(&name, kind);
        }
        2 => {
            world.shine(&name, LightKind::Directional { direction: towards, irradiance: strength })
        }
        3 => {
            let mesh = Mesh::sphere(at, side);
            world.add(&name, mesh, Material::diffuse(Rgb::ZERO), strength);
        }
        _ => {
            let along = towards.any_orthonormal_vector() * side;
            let up = towards.cross(along);
            let material = Material::diffuse(colour(random));
            world.add(&name, quad(at, along, up), material, strength);
        }
    }
}

fn light_from_around(world: &mut World, random: &mut Random) {
    world.around = (!random.once_in(4)).then(|| colour(random) * power(random, 3.0));
}

/// Another unit of length; the lamps that have a place are as bright as before, or not.
fn units(world: &mut World, random: &mut Random) {
    let scale = *random.one(&[1e-4f32, 1e-3, 1e-2, 0.0254, 0.3048, 12.0, 1e2, 1e3, 1e5]);
    transform(world, Affine3A::from_scale(Vec3::splat(scale)));
    if random.once_in(2) {
        for light in &mut world.scene.lights {
            if !matches!(light.kind, LightKind::Directional { .. }) {
                *light.kind.strength_mut() *= scale * scale;
            }
        }
    }
}

/// All lamps in another unit: lumens, candelas, watts of a bulb.
fn units_of_lamps(world: &mut World, random: &mut Random) {
    let factor = *random.one(&[1e-6f32, 1.0 / 683.0, 1.0 / (4.0 * PI), 54.35, 683.0, 1e6]);
    for light in &mut world.scene.lights {
        *light.kind.strength_mut() *= factor;
    }
    world.around = world.around.map(|around| around * factor);
    if random.once_in(2) {
        world.scene.groups.iter_mut().for_each(|group| group.emission *= factor);
    }
}

fn far_from_zero(world: &mut World, random: &mut Random) {
    let (_, radius) = extent(world);
    let away = random.vector(-1.0, 1.0) * radius * 10f32.powf(random.between(0.0, 6.0));
    transform(world, Affine3A::from_translation(away));
}

/// Another axis upwards, or any turn.
fn up_axis(world: &mut World, random: &mut Random) {
    let quarter = 0.25 * TAU;
    let turn = match random.below(4) {
        0 => Quat::from_rotation_x(quarter),
        1 => Quat::from_rotation_x(-quarter),
        2 => Quat::from_rotation_z(quarter),
        _ => Quat::from_axis_angle(direction(random), random.between(0.0, TAU)),
    };
    transform(world, Affine3A::from_quat(turn));
}

fn shape_changed(world: &mut World, random: &mut Random) {
    let Some(index) = some_object(world, random) else { return };
    let (to, (_, radius)) = (place(world, random), extent(world));
    let groups = world.scene.groups.len();
    let objects = &mut world.scene.objects;
    let mesh = &mut objects[index].mesh;
    match random.below(7) {
        0 => drop(objects.remove(index)),
        1 => transform_mesh(mesh, Affine3A::from_translation(0.2 * to)),
        2 => {
            // Flat in the limit, or a thin splinter.
            let scale = Vec3::new(1.0, *random.one(&[0.0, 1e-6, 0.01, 1.0]), power(random, 2.0));
            transform_mesh(mesh, Affine3A::from_scale(scale));
        }
        3 => mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2)),
        4 => {
            let mut copy = objects[index].clone();
            let shift = radius * *random.one(&[0.0f32, 1e-7, 1e-5, 1e-3]);
            transform_mesh(&mut copy.mesh, Affine3A::from_translation(Vec3::splat(shift)));
            copy.group = random.below(groups);
            objects.push(copy);
        }
        5 => mesh.normals.iter_mut().for_each(|normal| *normal = direction(random)),
        _ => objects[index].group = random.below(groups),
    }
}

fn material(world: &mut World, random: &mut Random) {
    let index = random.below(world.scene.groups.len());
    let is_principled = world.scene.brdf.is_principled();
    world.scene.groups[index].material = any_material(is_principled, random);
}

/// Any material; of the principled model or with a free lobe.
pub(super) fn any_material(is_principled: bool, random: &mut Random) -> Material {
    let (rho, lobe) = (colour(random), colour(random));
    let alpha = *random.one(&[0.0f32, 0.005, 0.02, 0.1, 0.3, 0.6, 1.0]);
    match random.below(7) {
        0 => Material::mirror(lobe),
        1 => Material::isotropic(rho * (Rgb::ONE - lobe), lobe, alpha),
        2 => Material {
            alpha_y: 1.0,
            theta_rad: random.between(-PI, PI),
            ..glossy(rho, lobe, alpha)
        },
        3 if is_principled => {
            Material::plastic(rho, random.between(1.01, 3.0), Layering::default(), alpha)
        }
        4 if is_principled => Material::metal(lobe, random.once_in(2), alpha),
        5 => {
            let image = Image::from_fn(3, 2, |_, _| colour(random));
            let texture = Texture { image, wrap_u: Wrap::ClampToEdge, wrap_v: Wrap::Repeat };
            Material { texture: Some(Arc::new(texture)), ..Material::diffuse(rho) }
        }
        _ => Material::diffuse(rho),
    }
}

/// A free lobe over a base, which together reflect no more than what comes.
fn glossy(rho: Rgb, lobe: Rgb, alpha: f32) -> Material {
    Material::isotropic(rho * (Rgb::ONE - lobe), lobe, alpha.max(0.005))
}

fn texture_coordinates(world: &mut World, random: &mut Random) {
    let Some(index) = some_object(world, random) else { return };
    let mesh = &mut world.scene.objects[index].mesh;
    let scale = *random.one(&[0.0f32, 1e-6, 1.0, 100.0, 1e9]);
    if random.once_in(3) {
        mesh.uvs.clear();
    } else {
        let any =
            |_: &Vec3| Vec2::new(random.between(-scale, scale), random.between(-scale, scale));
        mesh.uvs = mesh.positions.iter().map(any).collect();
    }
}

/// Moves all of `world`; its sun and its spots turn with it.
fn transform(world: &mut World, moved: Affine3A) {
    let scene = &mut world.scene;
    scene.objects.iter_mut().for_each(|object| transform_mesh(&mut object.mesh, moved));
    let turned = |direction: Vec3| moved.transform_vector3(direction).normalize_or(Vec3::NEG_Y);
    for light in &mut scene.lights {
        match &mut light.kind {
            LightKind::Point { position, .. } => *position = moved.transform_point3(*position),
            LightKind::Spot { position, direction, .. } => {
                *position = moved.transform_point3(*position);
                *direction = turned(*direction);
            }
            LightKind::Directional { direction, .. } => *direction = turned(*direction),
            LightKind::Profiled { position, direction, upright, .. } => {
                *position = moved.transform_point3(*position);
                (*direction, *upright) = (turned(*direction), turned(*upright));
            }
        }
    }
    for camera in &mut scene.cameras {
        let axes = camera.world_from_camera.matrix3;
        let columns = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| turned(axis.into()));
        let axes = Mat3::from_cols(columns[0], columns[1], columns[2]);
        let origin = moved.transform_point3(camera.origin());
        camera.world_from_camera = Affine3A::from_mat3_translation(axes, origin);
    }
}

fn transform_mesh(mesh: &mut Mesh, moved: Affine3A) {
    for position in &mut mesh.positions {
        *position = moved.transform_point3(*position);
    }
    for normal in &mut mesh.normals {
        // Exact for turns; a shape that is squeezed gets shading normals that are a little wrong.
        *normal = moved.transform_vector3(*normal).normalize_or(Vec3::Y);
    }
}
