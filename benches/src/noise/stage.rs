//! Builds scenes: named things, the sides of rooms, panels and openings.

use crate::corpus::generate::shapes::{merged, quad};
use glam::{Affine3A, Vec2, Vec3};
use unrender::scene::{Camera, Group, Light, LightKind, Material, Mesh, Object, Rgb, Scene};

/// A scene under construction: y is up, lengths are metres.
#[derive(Default)]
pub(super) struct Stage {
    /// The scene so far.
    pub(super) scene: Scene,
}

impl Stage {
    /// Adds a reflecting thing, with its own group.
    pub(super) fn add(&mut self, name: &str, material: Material, mesh: Mesh) {
        self.push(name, material, Rgb::ZERO, mesh);
    }

    /// Adds a lamp of this radiance, W sr^-1 m^-2.
    pub(super) fn lamp(&mut self, name: &str, radiance: Rgb, mesh: Mesh) {
        self.push(name, Material::diffuse(Rgb::ZERO), radiance, mesh);
    }

    /// Adds a light without a surface.
    pub(super) fn light(&mut self, name: &str, kind: LightKind) {
        self.scene.lights.push(Light { name: name.to_owned(), kind });
    }

    /// The scene with a camera at `eye` that looks at `target`.
    pub(super) fn seen(mut self, eye: Vec3, target: Vec3, fov_y_rad: f32) -> Scene {
        self.scene.cameras.push(Camera::look_at("camera", eye, target, Vec3::Y, fov_y_rad));
        self.scene
    }

    fn push(&mut self, name: &str, material: Material, emission: Rgb, mesh: Mesh) {
        let group = self.scene.groups.len();
        self.scene.groups.push(Group { name: name.to_owned(), material, emission });
        self.scene.objects.push(Object { name: name.to_owned(), group, mesh });
    }
}

/// A side of a room; all face inwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Floor,
    Ceiling,
    /// The wall at the least x.
    Left,
    /// The wall at the greatest x.
    Right,
    /// The wall at the least z.
    Back,
    /// The wall at the greatest z.
    Front,
}

/// A room between two corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// The corner of the least coordinates.
    pub(super) low: Vec3,
    /// That of the greatest.
    pub(super) high: Vec3,
}

impl Room {
    /// Some sides, as one mesh.
    pub(super) fn sides(&self, sides: &[Side]) -> Mesh {
        let side = |side: &Side| {
            let [corner, across, up] = self.edges(*side);
            quad(corner, across, up)
        };
        merged(&sides.iter().map(side).collect::<Vec<_>>())
    }

    /// One side with an opening, from `from` to `to` in shares of its width and height.
    pub(super) fn opened(&self, side: Side, from: Vec2, to: Vec2) -> Mesh {
        let [corner, across, up] = self.edges(side);
        let part = |from: Vec2, to: Vec2| {
            let size = to - from;
            quad(corner + across * from.x + up * from.y, across * size.x, up * size.y)
        };
        merged(&[
            part(Vec2::ZERO, Vec2::new(1.0, from.y)),
            part(Vec2::new(0.0, to.y), Vec2::ONE),
            part(Vec2::new(0.0, from.y), Vec2::new(from.x, to.y)),
            part(Vec2::new(to.x, from.y), Vec2::new(1.0, to.y)),
        ])
    }

    /// The lower left corner of a side, seen from inside, its width and its height.
    fn edges(&self, side: Side) -> [Vec3; 3] {
        let Self { low, high } = *self;
        let size = high - low;
        let [x, y, z] = [Vec3::X * size.x, Vec3::Y * size.y, Vec3::Z * size.z];
        match side {
            Side::Floor => [low, z, x],
            Side::Ceiling => [low + y, x, z],
            Side::Left => [low + z, -z, y],
            Side::Right => [low + x, z, y],
            Side::Back => [low, x, y],
            Side::Front => [low + x + z, -x, y],
        }
    }
}

/// A rectangle about `centre`; its half edges are `x` and `y`, and it faces along `x` cross `y`.
pub(super) fn panel(centre: Vec3, x: Vec3, y: Vec3) -> Mesh {
    quad(centre - x - y, 2.0 * x, 2.0 * y)
}

/// The motion of a thing from the origin to `place`, turned about +y by `angle_rad`.
pub(super) fn at(place: Vec3, angle_rad: f32) -> Affine3A {
    Affine3A::from_translation(place) * Affine3A::from_rotation_y(angle_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Side; 6] =
        [Side::Floor, Side::Ceiling, Side::Left, Side::Right, Side::Back, Side::Front];

    fn area(mesh: &Mesh) -> f32 {
        let of = |[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(c - a).length();
        (0..mesh.triangles.len()).map(|index| of(mesh.corners(index))).sum()
    }

    #[test]
    fn sides_face_inwards_and_close_the_room() {
        let room = Room { low: Vec3::new(-1.0, 0.0, -2.0), high: Vec3::new(1.0, 3.0, 2.0) };
        let middle = Vec3::new(0.0, 1.5, 0.0);
        let shell = room.sides(&ALL);
        for index in 0..shell.triangles.len() {
            let [a, b, c] = shell.corners(index);
            assert!((b - a).cross(c - a).dot(middle - a) > 0.0, "triangle {index}");
        }
        assert!((area(&shell) - 2.0 * (8.0 + 6.0 + 12.0)).abs() < 1e-4);
    }

    #[test]
    fn an_opening_takes_its_area() {
        let room = Room { low: Vec3::ZERO, high: Vec3::ONE };
        for side in ALL {
            let opened = room.opened(side, Vec2::new(0.2, 0.3), Vec2::new(0.7, 0.9));
            assert!((area(&opened) - 0.7).abs() < 1e-5, "{side:?}");
        }
    }
}
