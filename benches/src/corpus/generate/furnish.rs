//! Places things on a floor or on a table, where the camera sees them, and sorts them into groups.

use super::super::dice::Dice;
use super::super::family::{Family, Renderer, Style};
use super::colors::color;
use super::materials::{self, Kind, Rules};
use super::things::{self, Spot, Thing};
use super::{Plan, PlannedGroup, foreign, lights, room, shapes};
use glam::{Affine3A, Vec3};
use unrender::render::Tracer;
use unrender::scene::Camera;

/// The fewest and the most groups of a scene.
const GROUPS: (f32, f32) = (5.0, 30.5);
/// Things that show in less than this share of the picture's pixels are removed. Half of it keeps
/// slivers; twice it removes small things in plain view.
const SEEN_SHARE: f32 = 5e-4;

/// Where the camera stands and where things may stand.
struct Stage {
    room: Vec3,
    /// The lower and the upper corner of the ground.
    ground: (Vec3, Vec3),
    /// The sides of the cells in which things stand, metres.
    cells: (f32, f32),
    /// The maximum heights of things in front and at the rear.
    heights: (f32, f32),
    table: Option<Thing>,
    cameras: [Camera; 2],
    target: Vec3,
}

/// The scene of `seed`; round things have `segments` sides.
pub(crate) fn plan(seed: u64, style: Style, size: (usize, usize), segments: u32) -> Plan {
    let mut dice = Dice::new(seed, "plan");
    let aspect = size.0 as f32 / size.1 as f32;
    let is_table = dice.chance(0.45);
    let stage = if is_table { table(&mut dice, aspect) } else { floor(&mut dice, aspect) };
    let wanted = dice.log_range(GROUPS.0, GROUPS.1) as usize;
    let rules = rules(&mut Dice::new(seed, "rules"), style);
    let place = lights::Place {
        room: stage.room,
        target: stage.target,
        clear: stage.ground.0.y + stage.heights.1,
        punctual: !rules.mirrors,
        opening: true,
        segments,
        eyes: [stage.cameras[0].origin(), stage.cameras[1].origin()],
    };
    let lights = lights::lights(&mut Dice::new(seed, "lights"), place, "");
    let elsewhere = lights::Place { opening: false, ..place };
    let other_lights = lights::lights(&mut Dice::new(seed, "other lights"), elsewhere, "_new");
    let shell_groups = dice.count(2, room::GROUPS_MAX.min(wanted / 2).max(2));
    let mut plan = Plan {
        seed,
        style,
        size,
        room: stage.room,
        shell_groups,
        groups: Vec::new(),
        things: Vec::new(),
        lights,
        other_lights,
        cameras: stage.cameras.clone(),
    };
    let mut paint = Dice::new(seed, "materials");
    add_shell(&mut plan, &mut paint, rules);
    if let Some(table) = stage.table.clone() {
        add_group(&mut plan, &mut paint, rules, "table", vec![table]);
    }
    let hangings = if wanted >= 8 { dice.index(4) } else { 0 };
    for _ in 0..hangings {
        let hanging = hanging(&mut dice, &stage);
        if !plan.things.iter().any(|old| touches(old, &hanging)) {
            let name = format!("picture_{}", plan.groups.len());
            add_group(&mut plan, &mut paint, rules, &name, vec![hanging]);
        }
    }
    let left = wanted.saturating_sub(plan.groups.len()).max(1);
    furnish(&mut plan, &mut dice, &mut paint, &stage, rules, (left, segments));
    drop_unseen(&mut plan);
    // Given groups have one colour.
    for group in plan.given() {
        plan.groups[group].material.texture = None;
    }
    plan
}

/// The materials that the seed allows, among those of the renderer.
fn rules(dice: &mut Dice, style: Style) -> Rules {
    let mirrors = dice.chance(0.35) && style.family == Family::InModel;
    Rules {
        mirrors,
        alpha_min: if mirrors { 0.05 } else { 0.08 },
        // Radiance needs a material for each direction, thousands on curved things.
        anisotropic: style.renderer != Renderer::Radiance,
    }
}

fn camera(name: &str, eye: Vec3, target: Vec3, fov_deg: f32, aspect: f32) -> Camera {
    let camera = Camera::look_at(name, eye, target, Vec3::Y, fov_deg.to_radians());
    Camera { aspect: Some(aspect), ..camera }
}

/// A room seen from near its front wall.
fn floor(dice: &mut Dice, aspect: f32) -> Stage {
    let room = room::size(dice);
    let half = 0.5 * room;
    let eye = Vec3::new(
        dice.range(-0.3, 0.3) * room.x,
        dice.range(1.3, 1.75),
        half.z - dice.range(0.15, 0.4),
    );
    let target = Vec3::new(dice.range(-0.12, 0.12) * room.x, dice.range(0.45, 0.75), -0.2 * room.z);
    let fov = dice.range(48.0, 60.0);
    let side = if eye.x > 0.0 { -1.0 } else { 1.0 };
    let other = Vec3::new(side * 0.36 * room.x, dice.range(1.1, 2.0), eye.z - dice.range(0.0, 0.5));
    Stage {
        room,
        ground: (
            Vec3::new(0.15 - half.x, 0.0, 0.15 - half.z),
            Vec3::new(half.x - 0.15, 0.0, half.z - 1.4),
        ),
        cells: (0.3, 0.9),
        heights: (0.4, 1.3),
        table: None,
        cameras: [
            camera("camera", eye, target, fov, aspect),
            camera("other_camera", other, target, fov, aspect),
        ],
        target,
    }
}

/// A table seen from beside it.
fn table(dice: &mut Dice, aspect: f32) -> Stage {
    let room = room::size(dice);
    let size = Vec3::new(dice.range(1.1, 1.6), dice.range(0.68, 0.78), dice.range(0.7, 1.0));
    let centre = Vec3::new(0.0, 0.0, -0.5 * room.z + 0.5 * size.z + dice.range(0.05, 0.7));
    let thickness = 0.05;
    let top = centre + size.y * Vec3::Y;
    let slab = Vec3::new(size.x, thickness, size.z);
    let motion = Affine3A::from_translation(top - thickness * Vec3::Y);
    let plain = shapes::cuboid(slab, 0.0);
    let mesh = shapes::placed(&shapes::cuboid(slab, 0.006), motion);
    let sharp = Some(shapes::placed(&plain, motion));
    let table = Thing { name: "table", mesh, sharp, has_uvs: false, group: 0 };
    let distance = dice.range(0.9, 1.2);
    let eye = top + Vec3::new(dice.range(-0.5, 0.5), dice.range(0.35, 0.7), distance);
    let target = top + Vec3::new(dice.range(-0.1, 0.1), dice.range(0.0, 0.1), 0.0);
    let fov = dice.range(42.0, 52.0);
    let side = if eye.x > 0.0 { -1.0 } else { 1.0 };
    let other = top + Vec3::new(side * 0.75, dice.range(0.3, 0.8), distance * 0.9);
    Stage {
        room,
        ground: (
            top - 0.46 * Vec3::new(size.x, 0.0, size.z),
            top + 0.46 * Vec3::new(size.x, 0.0, size.z),
        ),
        cells: (0.1, 0.3),
        heights: (0.1, 0.32),
        table: Some(table),
        cameras: [
            camera("camera", eye, target, fov, aspect),
            camera("other_camera", other, target, fov, aspect),
        ],
        target,
    }
}

/// A group for each part of the shell.
fn add_shell(plan: &mut Plan, paint: &mut Dice, rules: Rules) {
    let parts = room::shell(plan.room, &plan.lights, plan.shell_groups);
    for part in parts {
        if plan.groups.iter().any(|group| group.name == part.group) {
            continue;
        }
        let textured = if part.has_uvs { 1.0 } else { 0.0 };
        let kind = if part.group == "floor" {
            let brushed = if rules.anisotropic { 0.1 } else { 0.0 };
            paint.weighted(&[
                (Kind::Diffuse, 0.42),
                (Kind::Isotropic, 0.3),
                (Kind::Anisotropic, brushed),
                (Kind::Textured, 0.18),
            ])
        } else {
            paint.weighted(&[
                (Kind::Diffuse, 0.82),
                (Kind::Isotropic, 0.1),
                (Kind::Textured, 0.08 * textured),
            ])
        };
        let mut material = materials::material(paint, kind, rules);
        let mut foreign = None;
        if plan.style.family == Family::Foreign && material.is_glossy() {
            let renderer = plan.style.renderer;
            (material, foreign) = foreign::reflectance(paint, renderer, rules, part.has_uvs);
        } else if kind == Kind::Diffuse {
            // Walls are brighter than things.
            material.rho_d = color(paint, 0.25, 0.85);
        }
        plan.groups.push(PlannedGroup {
            name: part.group.to_owned(),
            material,
            foreign,
            is_shell: true,
        });
    }
}

/// A new group of `things`.
fn add_group(plan: &mut Plan, paint: &mut Dice, rules: Rules, name: &str, things: Vec<Thing>) {
    let has_uvs = things.iter().all(|thing| thing.has_uvs);
    let (material, foreign) = match plan.style.family {
        Family::InModel => {
            let kind = materials::kind(paint, rules, has_uvs);
            (materials::material(paint, kind, rules), None)
        }
        Family::Foreign => foreign::reflectance(paint, plan.style.renderer, rules, has_uvs),
    };
    let group = plan.groups.len();
    plan.groups.push(PlannedGroup { name: name.to_owned(), material, foreign, is_shell: false });
    plan.things.extend(things.into_iter().map(|thing| Thing { group, ..thing }));
}

/// A picture on the rear or a side wall.
fn hanging(dice: &mut Dice, stage: &Stage) -> Thing {
    let half = 0.5 * stage.room;
    let height = dice.range(1.15, 1.7);
    let along = dice.range(-0.35, 0.35);
    let size = dice.range(0.35, 0.75);
    // The wall at +x may have an opening.
    let (centre, out) = if dice.chance(0.65) {
        (Vec3::new(along * stage.room.x, height, -half.z), Vec3::Z)
    } else {
        let end = half.z - 0.5 * size - 0.05;
        let z = ((along - 0.15) * stage.room.z).clamp(-end, end);
        (Vec3::new(-half.x, height, z), Vec3::X)
    };
    things::hanging(dice, centre, out, size)
}

/// Whether the bounding boxes of two things intersect.
fn touches(a: &Thing, b: &Thing) -> bool {
    let bounds = |thing: &Thing| {
        thing
            .mesh
            .positions
            .iter()
            .fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(*p), high.max(*p)))
    };
    let ((low_a, high_a), (low_b, high_b)) = (bounds(a), bounds(b));
    let gap = Vec3::splat(0.01);
    (low_a - gap).cmple(high_b).all() && (low_b - gap).cmple(high_a).all()
}

/// Things on the ground, `left` groups of them.
fn furnish(
    plan: &mut Plan,
    dice: &mut Dice,
    paint: &mut Dice,
    stage: &Stage,
    rules: Rules,
    (left, segments): (usize, u32),
) {
    let count = left + dice.index(left / 2 + 1);
    let mut spots = spots(dice, stage, count, plan.size);
    dice.shuffle(&mut spots);
    let mut things: Vec<Thing> =
        spots.into_iter().take(count).map(|spot| things::thing(dice, spot, segments)).collect();
    let rest = things.split_off(left.min(things.len()));
    let first = plan.groups.len();
    for (index, thing) in things.into_iter().enumerate() {
        let name = format!("group_{}", index + 1);
        add_group(plan, paint, rules, &name, vec![thing]);
    }
    let last = plan.groups.len();
    for thing in rest {
        let able = |group: &usize| thing.has_uvs || plan.groups[*group].material.texture.is_none();
        let able: Vec<usize> = (first..last).filter(able).collect();
        if !able.is_empty() {
            let group = able[dice.index(able.len())];
            plan.things.push(Thing { group, ..thing });
        }
    }
}

/// Cells of the ground that the camera sees: as large as possible with enough of them.
fn spots(dice: &mut Dice, stage: &Stage, count: usize, size: (usize, usize)) -> Vec<Spot> {
    let (low, high) = stage.ground;
    let mut cell = stage.cells.1;
    loop {
        let across = ((high.x - low.x) / cell).floor().max(1.0) as usize;
        let along = ((high.z - low.z) / cell).floor().max(1.0) as usize;
        let mut spots = Vec::new();
        for (i, j) in (0..across).flat_map(|i| (0..along).map(move |j| (i, j))) {
            let share = |k: usize, n: usize| (k as f32 + 0.5) / n as f32;
            let (s, t) = (share(i, across), share(j, along));
            let cell = ((high.x - low.x) / across as f32).min((high.z - low.z) / along as f32);
            let foot = Vec3::new(low.x + s * (high.x - low.x), low.y, low.z + t * (high.z - low.z));
            let height = stage.heights.1 + t * (stage.heights.0 - stage.heights.1);
            let height = height.min(1.8 * cell);
            let radius = 0.46 * cell;
            let middle = foot + 0.4 * height * Vec3::Y;
            let camera = &stage.cameras[0];
            let seen = [-0.7, 0.7].iter().all(|side| {
                camera.project(middle + *side * radius * Vec3::X, size.0, size.1).is_some()
            });
            if seen {
                let slack = 0.04 * cell;
                let shift = Vec3::new(dice.range(-slack, slack), 0.0, dice.range(-slack, slack));
                spots.push(Spot { foot: foot + shift, radius, height });
            }
        }
        if spots.len() >= count || cell <= stage.cells.0 {
            return spots;
        }
        cell *= 0.92;
    }
}

/// Removes things that the camera does not see, and groups that are then empty.
fn drop_unseen(plan: &mut Plan) {
    let scene = plan.scene();
    let (width, height) = plan.size;
    let geometry = Tracer::new(&scene).geometry(&plan.cameras[0], width, height);
    let mut pixels = vec![0usize; scene.objects.len()];
    for pixel in geometry.pixels() {
        if let Some(count) = pixels.get_mut(pixel.object as usize) {
            *count += 1;
        }
    }
    let least = (SEEN_SHARE * (width * height) as f32) as usize;
    let first = scene.objects.iter().position(|o| o.name == thing_name(plan, 0)).unwrap_or(0);
    let mut index = 0;
    plan.things.retain(|thing| {
        index += 1;
        thing.name == "table" || pixels[first + index - 1] >= least
    });
    let used = |group: usize| {
        plan.groups[group].is_shell || plan.things.iter().any(|thing| thing.group == group)
    };
    let kept: Vec<usize> = (0..plan.groups.len()).filter(|&group| used(group)).collect();
    for thing in &mut plan.things {
        thing.group = kept.iter().position(|&group| group == thing.group).unwrap_or(0);
    }
    plan.groups = kept.iter().map(|&group| plan.groups[group].clone()).collect();
}

fn thing_name(plan: &Plan, index: usize) -> String {
    plan.things.get(index).map_or(String::new(), |thing| format!("{}_{}", thing.name, index + 1))
}
