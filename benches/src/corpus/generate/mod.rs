//! Random scenes, each from one seed: a room with things on its floor, or a table with things on it.
//!
//! A [`Plan`] has the places of things and their groups; [`Plan::scene`] makes the scene from it, with the lights
//! of the photograph, [`Plan::relit`] with others. Each kind of random choice has its own stream, so that a
//! change of one leaves the others as they are.

mod colors;
mod foreign;
mod furnish;
pub(crate) mod lights;
pub(crate) mod materials;
mod room;
pub(crate) mod shapes;
mod textures;
mod things;

pub(crate) use foreign::Foreign;
pub(crate) use furnish::plan;

use super::family::Style;
use glam::Vec3;
use lights::Lights;
use room::ShellPart;
use things::Thing;
use unrender::render::Tracer;
use unrender::scene::{Camera, Group, Material, Object, Rgb, Scene};

/// Groups of fewer inner pixels than this share of the picture (65 of 43 200) are given, as a user would
/// give groups that the picture does not show. With half of it, groups of a few pixels are unknown; with
/// twice it, groups that could be recovered are given.
const GIVEN_SHARE: f32 = 1.5e-3;

/// A group of a plan.
#[derive(Clone, Debug)]
pub(crate) struct PlannedGroup {
    pub(crate) name: String,
    /// Its reflectance; for the foreign family, the most similar one of ours.
    pub(crate) material: Material,
    /// The reflectance of another model that the photograph shows instead, if it does.
    pub(crate) foreign: Option<Foreign>,
    /// Whether it belongs to the shell.
    pub(crate) is_shell: bool,
}

/// The things and their places.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) seed: u64,
    pub(crate) style: Style,
    pub(crate) size: (usize, usize),
    pub(crate) room: Vec3,
    pub(crate) shell_groups: usize,
    pub(crate) groups: Vec<PlannedGroup>,
    pub(crate) things: Vec<Thing>,
    pub(crate) lights: Lights,
    /// Other lights, for tests of the recovered materials.
    pub(crate) other_lights: Lights,
    /// The photograph's camera, then another.
    pub(crate) cameras: [Camera; 2],
}

impl Plan {
    /// The scene in the photograph's light.
    pub(crate) fn scene(&self) -> Scene {
        self.scene_in(&self.lights)
    }

    /// The scene in the other light.
    pub(crate) fn relit(&self) -> Scene {
        self.scene_in(&self.other_lights)
    }

    fn scene_in(&self, lights: &Lights) -> Scene {
        let mut scene = Scene { brdf: self.style.brdf, ..Scene::default() };
        for group in &self.groups {
            scene.groups.push(Group {
                name: group.name.clone(),
                material: group.material.clone(),
                emission: Rgb::ZERO,
            });
        }
        for ShellPart { group, name, mesh, .. } in
            room::shell(self.room, &self.lights, self.shell_groups)
        {
            if let Some(group) = scene.group_index(group) {
                scene.objects.push(Object { name: name.to_owned(), group, mesh });
            }
        }
        for (index, thing) in self.things.iter().enumerate() {
            let name = format!("{}_{}", thing.name, index + 1);
            scene.objects.push(Object { name, group: thing.group, mesh: thing.mesh.clone() });
        }
        for lamp in &lights.lamps {
            let group = scene.groups.len();
            let (name, material) = (lamp.name.clone(), Material::diffuse(Rgb::ZERO));
            scene.groups.push(Group { name: name.clone(), material, emission: lamp.radiance });
            scene.objects.push(Object { name, group, mesh: lamp.mesh.clone() });
        }
        scene.lights = lights.others.clone();
        scene.cameras = self.cameras.to_vec();
        scene
    }

    /// The groups that the picture does not show well enough to recover them.
    pub(crate) fn given(&self) -> Vec<usize> {
        let least = (GIVEN_SHARE * (self.size.0 * self.size.1) as f32) as usize;
        let inner = self.inner_pixels();
        (0..self.groups.len()).filter(|&group| inner[group] < least).collect()
    }

    /// How many pixels show each group and have only that group around them.
    pub(crate) fn inner_pixels(&self) -> Vec<usize> {
        let scene = self.scene();
        let (width, height) = self.size;
        let geometry = Tracer::new(&scene).geometry(&self.cameras[0], width, height);
        let group_of = |i: usize| geometry.pixels()[i].group;
        let mut counts = vec![0; scene.groups.len()];
        for index in 0..width * height {
            let group = group_of(index);
            let inside = geometry.neighbourhood(index).all(|beside| group_of(beside) == group);
            if let Some(count) = counts.get_mut(group as usize).filter(|_| inside) {
                *count += 1;
            }
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::super::family::{Family, Style};
    use super::*;

    fn plan_of(seed: u64) -> Plan {
        plan(seed, Style::new(seed, Family::InModel, None), (120, 90), 24)
    }

    #[test]
    fn a_seed_gives_one_scene_to_the_bit() {
        for seed in [0, 7] {
            assert_eq!(plan_of(seed).scene(), plan_of(seed).scene());
        }
        assert_ne!(plan_of(1).scene(), plan_of(2).scene());
    }

    #[test]
    fn scenes_are_sound() {
        for seed in 0..12 {
            let plan = plan_of(seed);
            let mut scene = plan.scene();
            assert_eq!(scene.validate().unwrap().0, Vec::<String>::new(), "seed {seed}");
            let groups = plan.groups.len();
            assert!((3..=30).contains(&groups), "seed {seed} has {groups} groups");
            assert!(scene.sources().count() > 0, "seed {seed} is lit");
            let eye = plan.cameras[0].origin();
            let half = 0.5 * plan.room;
            assert!(eye.abs().cmplt(Vec3::new(half.x, plan.room.y, half.z)).all(), "seed {seed}");
            for object in &scene.objects {
                let outside = object.mesh.positions.iter().filter(|p| {
                    p.x.abs() > half.x + 1e-3
                        || p.z.abs() > half.z + 1e-3
                        || !(-1e-3..=plan.room.y + 1e-3).contains(&p.y)
                });
                assert_eq!(outside.count(), 0, "seed {seed}: {} is in the room", object.name);
            }
        }
    }
}
