//! Photometric profiles as Radiance's patterns: a file of relative intensities over the angles of the profile's own type,
//! linear between them, and the angles of a ray as expressions.

use glam::Vec3;
use std::fmt::Write;
use unrender_scene::{LightProfile, Photometry};

/// How far outside a table's angles its light has ended, degrees. Half and double of it are as far below what any
/// goniometer tells apart.
const EDGE_DEG: f32 = 1e-3;

/// The file of `profile`: the lists of vertical and horizontal angles, and the intensities over the greatest one.
pub(super) fn data(profile: &LightProfile) -> String {
    let [low, high] = match profile.photometry() {
        Photometry::C => [[0.0, 180.0], [0.0, 360.0]],
        Photometry::B => [[-180.0, 180.0], [-90.0, 90.0]],
        Photometry::A => [[-90.0, 90.0], [-180.0, 180.0]],
    };
    let vertical = to_ends(profile.vertical_deg().to_vec(), low);
    let horizontal = to_ends(unfolded(profile), high);
    let mut text = String::from("2\n");
    for list in [&vertical, &horizontal] {
        let _ = writeln!(text, "0 0 {}", list.len());
        list.iter().for_each(|angle| {
            let _ = writeln!(text, "{angle}");
        });
    }
    for v in &vertical {
        for h in &horizontal {
            let _ = writeln!(text, "{}", profile.at(*v, *h));
        }
    }
    text
}

/// The horizontal angles all around, or on both sides.
fn unfolded(profile: &LightProfile) -> Vec<f32> {
    let given = profile.horizontal_deg();
    let mirrored: Vec<f32> = match (profile.photometry(), given) {
        (Photometry::C, [_]) => return vec![0.0, 360.0],
        (Photometry::C, [0.0, .., 90.0]) => {
            given.iter().flat_map(|h| [*h, 180.0 - h, 180.0 + h, 360.0 - h]).collect()
        }
        (Photometry::C, [0.0, .., 180.0]) => given.iter().flat_map(|h| [*h, 360.0 - h]).collect(),
        (Photometry::C, [90.0, .., 270.0]) => given
            .iter()
            .flat_map(|h| [*h, (540.0 - h) % 360.0, (900.0 - h) % 360.0])
            .chain([0.0, 360.0])
            .collect(),
        (Photometry::A | Photometry::B, [0.0, ..]) => given.iter().flat_map(|h| [*h, -h]).collect(),
        _ => given.to_vec(),
    };
    ascending(mirrored)
}

fn ascending(mut angles: Vec<f32>) -> Vec<f32> {
    angles.sort_by(f32::total_cmp);
    angles.dedup_by(|a, b| a == b);
    angles
}

/// `angles`, and the ends of their range with no light.
fn to_ends(mut angles: Vec<f32>, [low, high]: [f32; 2]) -> Vec<f32> {
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    if first - low > EDGE_DEG {
        angles.extend([low, first - EDGE_DEG]);
    }
    if high - last > EDGE_DEG {
        angles.extend([last + EDGE_DEG, high]);
    }
    ascending(angles)
}

/// The pattern `id` by `file`, of a lamp with this axis and horizontal angle 0. A ray that sees the lamp goes along `D`,
/// against the light's way.
pub(super) fn pattern(
    id: &str,
    file: &str,
    photometry: Photometry,
    [direction, upright]: [Vec3; 2],
) -> String {
    let along = |v: Vec3| format!("(Dx*({})+Dy*({})+Dz*({}))", -v.x, -v.y, -v.z);
    let (c, a, b) = (along(direction), along(upright), along(upright.cross(direction)));
    let r = along(direction.cross(upright));
    let degrees = |y: &str, x: &str| format!("atan2({y},{x})*{}", 180.0 / std::f64::consts::PI);
    let length = |x: &str, y: &str| format!("sqrt({x}*{x}+{y}*{y})");
    let [vertical, horizontal] = match photometry {
        Photometry::C => {
            let turn = degrees(&b, &a);
            [degrees(&length(&a, &b), &c), format!("if({b},{turn},360+{turn})")]
        }
        Photometry::B => [degrees(&a, &c), degrees(&r, &length(&a, &c))],
        Photometry::A => [degrees(&a, &length(&r, &c)), degrees(&r, &c)],
    };
    format!("void brightdata {id}\n5 noop ./{file} . {vertical} {horizontal}\n0\n0\n")
}
