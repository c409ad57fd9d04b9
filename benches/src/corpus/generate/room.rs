//! The shell of the room: floor, walls and ceiling, sorted into two to five groups.

use super::super::dice::Dice;
use super::lights::Lights;
use super::shapes;
use glam::{Vec2, Vec3};
use unrender::scene::Mesh;

/// A part of the shell: the name of its group, and whether its texture coordinates suit a texture.
#[derive(Clone, Debug)]
pub(crate) struct ShellPart {
    pub(crate) group: &'static str,
    pub(crate) name: &'static str,
    pub(crate) mesh: Mesh,
    pub(crate) has_uvs: bool,
}

/// The most groups of a shell.
pub(crate) const GROUPS_MAX: usize = 5;

/// Floor, walls and ceiling of a room of `size` about the origin, whose fronts look inwards; the wall
/// at +x has the lights' opening.
pub(crate) fn shell(size: Vec3, lights: &Lights, groups: usize) -> Vec<ShellPart> {
    let half = 0.5 * size;
    let (x, y, z) = (size.x * Vec3::X, size.y * Vec3::Y, size.z * Vec3::Z);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x * half.x, y * size.y, z * half.z);
    let name = |own: &'static str, from: usize, shared: &'static str| {
        if groups >= from { own } else { shared }
    };
    let right = match lights.opening {
        None => shapes::quad(at(1.0, 0.0, -1.0), z, y),
        Some(hole) => wall_with_hole(size, hole),
    };
    let part = |group, name, mesh, has_uvs| ShellPart { group, name, mesh, has_uvs };
    vec![
        part("floor", "floor", shapes::quad(at(-1.0, 0.0, 1.0), x, -z), true),
        part(
            name("back_wall", 3, "walls"),
            "back_wall",
            shapes::quad(at(-1.0, 0.0, -1.0), x, y),
            groups >= 3,
        ),
        part(
            name("left_wall", 5, "walls"),
            "left_wall",
            shapes::quad(at(-1.0, 0.0, 1.0), -z, y),
            groups >= 5,
        ),
        part(
            name("right_wall", 5, "walls"),
            "right_wall",
            right,
            groups >= 5 && lights.opening.is_none(),
        ),
        part(
            name("ceiling", 4, "walls"),
            "front_wall",
            shapes::quad(at(1.0, 0.0, 1.0), -x, y),
            false,
        ),
        part(
            name("ceiling", 4, "walls"),
            "ceiling",
            shapes::quad(at(-1.0, 1.0, -1.0), x, z),
            false,
        ),
    ]
}

/// The wall at +x around a hole: its corner and size in z and y.
fn wall_with_hole(size: Vec3, (corner, hole): (Vec2, Vec2)) -> Mesh {
    let half = 0.5 * size;
    let piece = |low: Vec2, high: Vec2| {
        let corner = Vec3::new(half.x, low.y, low.x);
        shapes::quad(corner, (high.x - low.x) * Vec3::Z, (high.y - low.y) * Vec3::Y)
    };
    let (far, end) = (corner, corner + hole);
    shapes::merged(&[
        piece(Vec2::new(-half.z, 0.0), Vec2::new(half.z, far.y)),
        piece(Vec2::new(-half.z, end.y), Vec2::new(half.z, size.y)),
        piece(Vec2::new(-half.z, far.y), Vec2::new(far.x, end.y)),
        piece(Vec2::new(end.x, far.y), Vec2::new(half.z, end.y)),
    ])
}

/// The size of a room, metres.
pub(crate) fn size(dice: &mut Dice) -> Vec3 {
    Vec3::new(dice.range(3.0, 4.6), dice.range(2.3, 2.9), dice.range(3.2, 4.8))
}
