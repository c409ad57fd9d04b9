//! Writes projects and edits by their meaning: what they say of the photograph, the groups and the lamps may be true or
//! not.

use super::photographs::{SIZE, Taken};
use super::rooms::World;
use super::scenes::{any_material, colour, power};
use crate::random::Random;
use std::io;
use std::path::Path;
use toml::{Table, Value};
use unrender::formats::picture;
use unrender::scene::{Camera, Image, Material, Reflectance, Rgb, Scene};

/// The hypotheses that a project may name.
const RUNGS: [&str; 7] = [
    "diffuse",
    "mirror",
    "partial-mirror",
    "diffuse-specular",
    "isotropic",
    "anisotropic",
    "textured",
];

/// The project of a scene `world` and a photograph; its mask is written into `folder`.
///
/// # Errors
/// If the mask cannot be written.
pub(super) fn project(
    world: &World,
    taken: &Taken,
    folder: &Path,
    random: &mut Random,
) -> io::Result<Table> {
    let mut project = Table::new();
    set(&mut project, "scene", "scene.glb");
    set(&mut project, "photo", taken.name);
    response(&mut project, taken, random);
    exposure(&mut project, world, taken, random);
    if random.once_in(4) {
        mask(folder, random)?;
        set(&mut project, "mask", "mask.png");
    }
    camera(&mut project, &world.scene, random);
    groups(&mut project, &world.scene, random);
    lights(&mut project, world, random);
    recover(&mut project, random);
    Ok(project)
}

fn set(table: &mut Table, key: &str, value: impl Into<Value>) {
    table.insert(key.to_owned(), value.into());
}

/// Three numbers.
fn triple(rgb: Rgb) -> Value {
    numbers(&rgb.to_array())
}

fn numbers(numbers: &[f32]) -> Value {
    numbers.iter().map(|number| f64::from(*number)).collect::<Vec<_>>().into()
}

fn table<const N: usize>(entries: [(&str, Value); N]) -> Table {
    entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// The name of one of the groups; seldom of one that emits or has no shape, which few statements may name.
fn some_name(scene: &Scene, random: &mut Random) -> Value {
    let is_usual = |index: &usize| {
        let has_shape = scene.objects.iter().any(|object| object.group == *index);
        has_shape && !scene.groups[*index].is_emitter()
    };
    let usual: Vec<usize> = (0..scene.groups.len()).filter(is_usual).collect();
    let any = random.below(scene.groups.len());
    let index = if usual.is_empty() || random.once_in(20) { any } else { *random.one(&usual) };
    scene.groups[index].name.clone().into()
}

fn response(project: &mut Table, taken: &Taken, random: &mut Random) {
    let stated: Value = match (random.below(12), taken.gamma) {
        (0, _) => "linear".into(),
        (1, _) => "auto".into(),
        (2, _) => table([("gamma", f64::from(random.between(0.3, 4.0)).into())]).into(),
        (_, None) => "srgb".into(),
        (_, Some(1.0)) => "linear".into(),
        (_, Some(gamma)) => table([("gamma", f64::from(gamma).into())]).into(),
    };
    set(project, "response", stated);
    if random.once_in(8) {
        set(project, "black_level", f64::from(random.between(0.0, 0.5)));
    }
    if random.once_in(8) {
        set(project, "white_level", f64::from(random.between(0.5, 1.1)));
    }
    match random.below(12) {
        0 => set(project, "vignetting", "cos4"),
        1 => set(project, "vignetting", "auto"),
        2 => {
            let radial = random.vector(-0.3, 0.2).to_array();
            set(project, "vignetting", table([("radial", numbers(&radial))]));
        }
        _ => {}
    }
}

fn exposure(project: &mut Table, world: &World, taken: &Taken, random: &mut Random) {
    let truth = taken.exposure;
    let stated: Value = match random.below(8) {
        0 => f64::from(truth * power(random, 3.0)).into(),
        1 => triple(truth * random.vector(0.5, 1.5)),
        2 => {
            let group = some_name(&world.scene, random);
            let rho = triple(Rgb::splat(random.between(0.01, 1.0)));
            set(project, "anchor", table([("group", group), ("rho_d", rho)]));
            "auto".into()
        }
        3 => return,
        _ => f64::from(truth).into(),
    };
    set(project, "exposure", stated);
}

/// A mask: nothing, all, one pixel, a half, or any pixels.
fn mask(folder: &Path, random: &mut Random) -> io::Result<()> {
    let kind = random.below(5);
    let (width, height) = if random.once_in(8) { (5, 7) } else { SIZE };
    let mask = Image::from_fn(width, height, |x, y| {
        let is_used = match kind {
            0 => false,
            1 => true,
            2 => (x, y) == (width / 2, height / 2),
            3 => x < width / 2,
            _ => random.once_in(2),
        };
        if is_used { Rgb::ONE } else { Rgb::ZERO }
    });
    picture::write(&folder.join("mask.png"), &mask).map(drop).map_err(io::Error::other)
}

/// The camera as a table: as in the scene, nearly so, or with another lens.
fn camera(project: &mut Table, scene: &Scene, random: &mut Random) {
    let Some(camera) = scene.cameras.first().filter(|_| random.once_in(2)) else { return };
    let mut stated = pose(camera);
    let fov = f64::from(camera.fov_y_rad.to_degrees());
    match random.below(4) {
        0 => set(&mut stated, "fov_y_deg", fov * f64::from(random.between(0.5, 1.5))),
        1 => {
            set(&mut stated, "fov_y_deg", fov);
            set(&mut stated, "k1", f64::from(random.between(-0.5, 0.5)));
            set(&mut stated, "p2", f64::from(random.between(-0.05, 0.05)));
        }
        2 => {
            set(&mut stated, "fov_y_deg", fov);
            set(&mut stated, "fx_over_fy", f64::from(power(random, 1.0)));
            let point = random.vector(-1.0, 1.0).to_array();
            set(&mut stated, "principal_point", numbers(&point[..2]));
        }
        _ => set(&mut stated, "fov_y_deg", fov),
    }
    set(project, "camera", stated);
}

fn pose(camera: &Camera) -> Table {
    let axes = camera.world_from_camera.matrix3;
    let eye = camera.origin();
    let ahead = -axes.z_axis * eye.length().max(1.0);
    table([
        ("eye", numbers(&eye.to_array())),
        ("target", numbers(&(eye + glam::Vec3::from(ahead)).to_array())),
        ("up", numbers(&axes.y_axis.to_array())),
    ])
}

/// Statements about some groups.
fn groups(project: &mut Table, scene: &Scene, random: &mut Random) {
    let mut groups = Table::new();
    let share = *random.one(&[2, 3, 6, 100]);
    for group in &scene.groups {
        if random.once_in(share) {
            let name = some_name(scene, random);
            let stated = group_table(scene, &group.material, random);
            // What a group is told of itself is seldom meant.
            let is_of_itself = stated.get("same_as") == Some(&name);
            if !is_of_itself || random.once_in(20) {
                set(&mut groups, name.as_str().unwrap_or_default(), stated);
            }
        }
    }
    set(project, "groups", groups);
}

fn group_table(scene: &Scene, truth: &Material, random: &mut Random) -> Table {
    let is_principled = scene.brdf.is_principled();
    match random.below(10) {
        0 | 1 => table([("ignore", true.into())]),
        2 => table([("known", known(truth).into())]),
        3 => table([("known", known(&any_material(is_principled, random)).into())]),
        4 => table([("max_rung", (*random.one(&RUNGS)).into())]),
        5 => {
            let rungs = (0..=random.below(3)).map(|_| Value::from(*random.one(&RUNGS)));
            table([("rungs", rungs.collect::<Vec<_>>().into())])
        }
        6 => table([("same_as", some_name(scene, random))]),
        7 => {
            let within = f64::from(random.between(0.01, 1.1));
            let like = table([("group", some_name(scene, random)), ("within", within.into())]);
            table([("like", like.into())])
        }
        _ => {
            let (low, high) = (random.between(0.0, 0.5), random.between(0.5, 1.0));
            let (low, high) = if random.once_in(4) { (high, high) } else { (low, high) };
            let bounds = table([("min", f64::from(low).into()), ("max", f64::from(high).into())]);
            table([(*random.one(&["rho_d", "rho_s", "alpha_x", "alpha_y"]), bounds.into())])
        }
    }
}

/// The table `known` of a material.
fn known(material: &Material) -> Table {
    let mut known = table([
        ("rho_d", triple(material.rho_d)),
        ("rho_s", triple(material.rho_s)),
        ("alpha_x", f64::from(material.alpha_x).into()),
        ("alpha_y", f64::from(material.alpha_y).into()),
        ("theta_deg", f64::from(material.theta_rad.to_degrees()).into()),
        ("reflectance", material.reflectance.name().into()),
    ]);
    if let Reflectance::Dielectric { ior, .. } = material.reflectance {
        known.remove("rho_s");
        set(&mut known, "ior", f64::from(ior));
    }
    known
}

/// Lamps that are unknown, or otherwise than in the scene; and the light from all around.
fn lights(project: &mut Table, world: &World, random: &mut Random) {
    let names: Vec<String> = world.scene.sources().map(|source| source.name.to_owned()).collect();
    if !names.is_empty() && random.once_in(4) {
        let unknown = table([("unknown", true.into())]);
        let lights = names.iter().filter(|_| random.once_in(2));
        let lights: Table = lights.map(|name| (name.clone(), unknown.clone().into())).collect();
        set(project, "lights", lights);
    } else if !names.is_empty() && random.once_in(4) {
        let lights: Vec<Value> = names.iter().map(|name| light(name, random).into()).collect();
        set(project, "lights", lights);
    }
    let stated = match (world.around, random.below(10)) {
        (_, 0) => table([("color", triple(colour(random)))]),
        (_, 1) => table([("unknown", true.into())]),
        (_, 2) => table([("unknown", "uniform".into())]),
        (Some(around), _) => table([("color", triple(around))]),
        (None, _) => return,
    };
    set(project, "environment", stated);
}

/// An entry that changes a lamp of the scene.
fn light(name: &str, random: &mut Random) -> Table {
    let mut light = table([("name", name.into())]);
    match random.below(5) {
        0 => set(&mut light, "scale", f64::from(power(random, 4.0))),
        1 => set(&mut light, "strength", triple(colour(random) * power(random, 4.0))),
        2 => set(&mut light, "move", numbers(&random.vector(-2.0, 2.0).to_array())),
        3 => set(&mut light, "remove", true),
        _ => set(&mut light, "scale", 0.0),
    }
    light
}

/// The table `[recover]`.
fn recover(project: &mut Table, random: &mut Random) {
    let mut recover = Table::new();
    if random.once_in(3) {
        let brdf = *random.one(&["principled", "ggx", "ward-gmd", "ward-1992", "ward-duer"]);
        set(&mut recover, "brdf", brdf);
    }
    if random.once_in(6) {
        set(&mut recover, "max_rung", *random.one(&RUNGS));
    }
    set(project, "recover", recover);
}

/// The flags of the recovery.
pub(super) fn flags(random: &mut Random) -> Vec<&'static str> {
    let mut flags = Vec::new();
    if random.once_in(6) {
        flags.extend(["--ladder", "paper"]);
    }
    // It takes half of the time of a run.
    if !random.once_in(3) {
        flags.push("--no-refine");
    }
    flags.extend(*random.one(&[
        None,
        None,
        Some("--keep-camera"),
        Some("--no-filter"),
        Some("--refine-camera"),
    ]));
    if random.once_in(3) {
        flags.push("--force");
    }
    flags
}

/// The edits of the restaging: a group, a lamp and an object are changed at random.
pub(super) fn edits(world: &World, random: &mut Random) -> Table {
    let mut edits = Table::new();
    set(&mut edits, "recovered", "recovered");
    set(&mut edits, "project", "project.toml");
    if random.once_in(2) {
        let mut paint = table([("group", some_name(&world.scene, random))]);
        set(&mut paint, "rho_d", triple(0.5 * colour(random)));
        set(&mut edits, "repaint", vec![Value::from(paint)]);
    }
    let names: Vec<String> = world.scene.sources().map(|source| source.name.to_owned()).collect();
    let names: Vec<String> = names.into_iter().filter(|name| name != "environment").collect();
    if !names.is_empty() && random.once_in(2) {
        let name: &String = random.one(&names);
        let light = light(name, random);
        set(&mut edits, "lights", vec![Value::from(light)]);
    }
    if random.once_in(3) {
        set(
            &mut edits,
            "remove",
            vec![Value::from(table([("name", some_name(&world.scene, random))]))],
        );
    }
    edits
}
