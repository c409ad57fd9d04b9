//! One to four lights of all kinds that light the room well.

use super::super::dice::Dice;
use super::shapes;
use glam::{Affine3A, Vec2, Vec3};
use std::f32::consts::{PI, TAU};
use unrender::scene::{Light, LightKind, Mesh, Rgb};

/// A lamp with a surface.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    pub(crate) name: String,
    pub(crate) mesh: Mesh,
    pub(crate) radiance: Rgb,
    /// Centre and radius of the ball that a round lamp approximates, which has the same area.
    pub(crate) ball: Option<(Vec3, f32)>,
}

/// All lights of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lights {
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) others: Vec<Light>,
    /// A hole in the wall at +x (its lower rear corner and its size in z and y), by which sunlight
    /// comes in.
    pub(crate) opening: Option<(Vec2, Vec2)>,
}

/// The kinds of lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Panel,
    Globe,
    Point,
    Spot,
    Sun,
}

/// The places where lights may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Width, height and length of the room, metres; its floor's centre is the origin.
    pub(crate) room: Vec3,
    /// The point at which the camera looks.
    pub(crate) target: Vec3,
    /// Everything that stands there is lower than this.
    pub(crate) clear: f32,
    /// Whether lights without a surface may be there.
    pub(crate) punctual: bool,
    /// Whether the wall at +x may have a hole.
    pub(crate) opening: bool,
    /// Segments of a round lamp.
    pub(crate) segments: u32,
    /// The places of the cameras, whose views a lamp must not fill.
    pub(crate) eyes: [Vec3; 2],
}

/// A globe is at least this far from a camera, metres: there the largest fills a third of the view's
/// height.
const AWAY: f32 = 1.1;
/// How often another place is tried for a globe; after that the last one is kept.
const TRIES: usize = 24;

/// Power of the lights per square metre of the room's floor, W.
const POWER: f32 = 14.0;

/// Random lights; `suffix` ends their names.
pub(crate) fn lights(dice: &mut Dice, place: Place, suffix: &str) -> Lights {
    let count = dice.weighted(&[(1, 0.3), (2, 0.35), (3, 0.22), (4, 0.13)]);
    let mut lights = Lights::default();
    let mut kinds = Vec::new();
    for _ in 0..count {
        let surface = [(Kind::Panel, 0.38), (Kind::Globe, 0.2)];
        let without = [(Kind::Point, 0.14), (Kind::Spot, 0.17), (Kind::Sun, 0.11)];
        let mut choice = surface.to_vec();
        if place.punctual {
            choice.extend(without.iter().filter(|(kind, _)| {
                let sun = place.opening && !kinds.contains(&Kind::Sun);
                *kind != Kind::Sun || sun
            }));
        }
        // Only one panel hangs under the ceiling; two would overlap.
        choice.retain(|(kind, _)| !(*kind == Kind::Panel && kinds.contains(kind)));
        kinds.push(dice.weighted(&choice));
    }
    // Sunlight alone leaves most of a room in the dark.
    if kinds == [Kind::Sun] || kinds == [Kind::Spot] {
        kinds.push(Kind::Panel);
    }
    let shares: Vec<f32> = kinds.iter().map(|_| dice.range(0.4, 1.0)).collect();
    let total = POWER * place.room.x * place.room.z / shares.iter().sum::<f32>();
    for (index, (kind, share)) in kinds.into_iter().zip(shares).enumerate() {
        let name = format!("light_{}{suffix}", index + 1);
        add(&mut lights, dice, place, kind, name, total * share);
    }
    lights
}

/// Adds a light of the kind that emits `power` watts.
fn add(lights: &mut Lights, dice: &mut Dice, place: Place, kind: Kind, name: String, power: f32) {
    let room = place.room;
    let tint = tint(dice);
    let across = |dice: &mut Dice, size: f32| dice.range(-0.34, 0.34) * size;
    match kind {
        Kind::Panel => {
            let (width, length) = (dice.range(0.4, 1.3), dice.range(0.4, 1.1));
            let centre = Vec3::new(
                across(dice, room.x - width),
                room.y - 0.015,
                across(dice, room.z - length),
            );
            let corner = centre - 0.5 * Vec3::new(width, 0.0, length);
            // Its front faces down.
            let mesh = shapes::quad(corner, width * Vec3::X, length * Vec3::Z);
            let radiance = tint * power / (PI * width * length);
            lights.lamps.push(Lamp { name, mesh, radiance, ball: None });
        }
        Kind::Globe => {
            let radius = dice.range(0.1, 0.17);
            let low = (place.clear + 0.1).min(room.y - 2.0 * radius - 0.15);
            let mut foot = Vec3::ZERO;
            for _ in 0..TRIES {
                let height = dice.range(low, room.y - 2.0 * radius - 0.1);
                foot = Vec3::new(across(dice, room.x), height, across(dice, room.z));
                if place.eyes.iter().all(|eye| eye.distance(foot) > AWAY) {
                    break;
                }
            }
            let ball = shapes::sphere(radius, place.segments);
            let mesh = shapes::placed(&ball, Affine3A::from_translation(foot));
            let radiance = tint * power / (PI * 2.0 * TAU * radius * radius);
            let ball = Some((foot + radius * Vec3::Y, (area(&mesh) / (2.0 * TAU)).sqrt()));
            lights.lamps.push(Lamp { name, mesh, radiance, ball });
        }
        Kind::Point => {
            let position =
                Vec3::new(across(dice, room.x), dice.range(place.clear + 0.2, room.y - 0.15), {
                    across(dice, room.z)
                });
            let intensity = tint * power / (2.0 * TAU);
            lights.others.push(Light { name, kind: LightKind::Point { position, intensity } });
        }
        Kind::Spot => {
            let position = Vec3::new(across(dice, room.x), room.y - 0.1, across(dice, room.z));
            let aim =
                place.target + 0.4 * Vec3::new(dice.range(-1.0, 1.0), 0.0, dice.range(-1.0, 1.0));
            let outer_rad = dice.range(0.5, 0.9);
            let inner_rad = outer_rad * dice.range(0.3, 0.8);
            // With all the power in the cone it would be too bright.
            let intensity = tint * 0.5 * power / (TAU * (1.0 - outer_rad.cos()));
            let direction = (aim - position).normalize();
            let kind = LightKind::Spot { position, direction, intensity, inner_rad, outer_rad };
            lights.others.push(Light { name, kind });
        }
        Kind::Sun => {
            let size = Vec2::new(dice.range(0.6, 1.1), dice.range(0.6, 1.0));
            let corner = Vec2::new(
                dice.range(-0.4, 0.1) * room.z,
                (room.y - 0.25 - size.y).max(0.8).min(room.y - size.y - 0.1),
            );
            let direction =
                Vec3::new(-1.0, -dice.range(0.5, 1.1), dice.range(-0.4, 0.4)).normalize();
            let irradiance = tint * 0.8 * power / (size.x * size.y * -direction.x);
            lights.opening = Some((corner, size));
            let kind = LightKind::Directional { direction, irradiance };
            lights.others.push(Light { name, kind });
        }
    }
}

/// Warm, neutral or cool white; the mean of its channels is one.
fn tint(dice: &mut Dice) -> Rgb {
    let warmth = dice.range(-0.25, 0.35);
    let color = Rgb::new(1.0 + warmth, 1.0, 1.0 - warmth);
    3.0 * color / color.element_sum()
}

/// The area of a mesh, square metres.
fn area(mesh: &Mesh) -> f32 {
    let of = |index: usize| {
        let [a, b, c] = mesh.corners(index);
        0.5 * (b - a).cross(c - a).length()
    };
    (0..mesh.triangles.len()).map(of).sum()
}
