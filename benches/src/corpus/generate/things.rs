//! Things in a room: boxes, balls, cylinders, rings, vases, and tables with things on them.

use super::super::dice::Dice;
use super::shapes;
use glam::{Affine3A, Quat, Vec3};
use unrender::scene::Mesh;

/// A thing in its place.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    pub(crate) name: &'static str,
    pub(crate) mesh: Mesh,
    /// The same without its bevels, if it has any.
    pub(crate) sharp: Option<Mesh>,
    /// Whether it is a plate whose texture coordinates suit a picture.
    pub(crate) has_uvs: bool,
    /// Its group, which is set later.
    pub(crate) group: usize,
}

/// Room for a thing: a circle on the ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub(crate) foot: Vec3,
    pub(crate) radius: f32,
    /// The maximum height of a thing.
    pub(crate) height: f32,
}

/// The shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Box,
    Crate,
    Ball,
    Cylinder,
    Ring,
    Vase,
}

/// Almost a full turn, radians; another value would change the scenes of all seeds.
const TURN: f32 = 628.0 / 100.0;

/// A random thing that fits.
pub(crate) fn thing(dice: &mut Dice, spot: Spot, segments: u32) -> Thing {
    let shape = dice.weighted(&[
        (Shape::Box, 0.34),
        (Shape::Crate, 0.1),
        (Shape::Ball, 0.19),
        (Shape::Cylinder, 0.15),
        (Shape::Ring, 0.08),
        (Shape::Vase, 0.14),
    ]);
    let radius = spot.radius * dice.range(0.7, 1.0);
    let height = spot.height * dice.range(0.45, 1.0);
    let turn = Quat::from_rotation_y(dice.range(0.0, TURN));
    let motion = Affine3A::from_rotation_translation(turn, spot.foot);
    let mut sharp = None;
    let (name, mesh, has_uvs) = match shape {
        Shape::Box | Shape::Crate => {
            // The half diagonal of its ground is the radius.
            let angle = dice.range(0.5, 1.07f32);
            let size = Vec3::new(2.0 * radius * angle.cos(), height, 2.0 * radius * angle.sin());
            let plain = shapes::cuboid(size, 0.0);
            if shape == Shape::Crate {
                ("crate", plain, true)
            } else {
                let bevel = size.min_element() * dice.range(0.04, 0.12);
                sharp = Some(shapes::placed(&plain, motion));
                ("box", shapes::cuboid(size, bevel), false)
            }
        }
        Shape::Ball => ("ball", shapes::sphere(radius.min(0.5 * spot.height), segments), true),
        Shape::Cylinder => {
            ("cylinder", shapes::cylinder(0.85 * radius, height.min(5.0 * radius), segments), true)
        }
        Shape::Ring => {
            let thickness = (radius * dice.range(0.22, 0.34)).min(0.45 * spot.height);
            ("ring", shapes::torus(radius - thickness, thickness, segments), false)
        }
        Shape::Vase => {
            let waves = [dice.range(0.1, 0.4), dice.range(0.1, 0.45)];
            let height = height.clamp(1.2 * radius, 4.0 * radius);
            ("vase", shapes::vase(radius, height, waves, segments), true)
        }
    };
    let mesh = shapes::placed(&mesh, motion);
    Thing { name, mesh, sharp, has_uvs, group: 0 }
}

/// A flat box or picture before a wall: `centre` on the wall, `out` away from it, `across` in it.
pub(crate) fn hanging(dice: &mut Dice, centre: Vec3, out: Vec3, size: f32) -> Thing {
    let across = Vec3::Y.cross(out);
    let (width, height) = (size * dice.range(0.6, 1.0), size * dice.range(0.6, 1.0));
    let corner = centre + 0.012 * out - 0.5 * (width * across + height * Vec3::Y);
    let mesh = shapes::quad(corner, width * across, height * Vec3::Y);
    Thing { name: "picture", mesh, sharp: None, has_uvs: true, group: 0 }
}
