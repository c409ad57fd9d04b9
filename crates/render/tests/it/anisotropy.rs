//! Proves the meaning of the anisotropy angle on pictures: the highlight of a lamp at the camera is
//! stretched along the direction in which the roughness is large, and that direction is where the
//! conventions say: counter-clockwise seen from the front, from TANGENT, else from growing u, else
//! from world +x, else from world +z.

use crate::common::{Stage, camera, plate_corners, quad_mesh, settings};
use glam::{DVec2, Vec2, Vec3, Vec4};
use unrender_scene::{LightKind, Material, Mesh, Rgb};

/// The world direction along which the highlight on `mesh` is longest, seen along its normal from
/// the point `eye`.
fn long_axis(mesh: Mesh, eye: Vec3, theta_rad: f32) -> Vec3 {
    let mut stage = Stage::default();
    let brushed = Material {
        rho_s: Rgb::ONE,
        alpha_x: 0.16,
        alpha_y: 0.06,
        theta_rad,
        ..Material::diffuse(Rgb::ZERO)
    };
    let group = stage.group(brushed, Rgb::ZERO);
    stage.mesh(group, mesh);
    stage.light(LightKind::Point { position: eye, intensity: Rgb::ONE });
    let camera = camera(eye, Vec3::ZERO, 0.9);
    let side = 64;
    let film = stage.render(&camera, side, settings(16));
    let (mut xx, mut xy, mut yy, mut all) = (0.0, 0.0, 0.0, 0.0);
    for (i, radiance) in film.mean.pixels().iter().enumerate() {
        let centre = DVec2::splat(0.5 * side as f64 - 0.5);
        let at = DVec2::new((i % side) as f64, (i / side) as f64) - centre;
        let weight = f64::from(radiance.x);
        (xx, xy, yy) =
            (xx + weight * at.x * at.x, xy + weight * at.x * at.y, yy + weight * at.y * at.y);
        all += weight;
    }
    assert!(all > 0.0, "the plate is dark");
    let spread = ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt() / (xx + yy);
    assert!(spread > 0.5, "the highlight is not stretched: {spread}");
    let angle = (0.5 * (2.0 * xy).atan2(xx - yy)) as f32;
    // Rows grow downwards in the picture.
    let axes = camera.world_from_camera.matrix3;
    Vec3::from(axes.x_axis) * angle.cos() - Vec3::from(axes.y_axis) * angle.sin()
}

/// Checks the long axis from both sides of the plate spanned by `x` and `y` (its front looks
/// along `x` cross `y`), whose anisotropy angle counts from `zero`.
fn check(what: &str, mesh: &Mesh, (x, y): (Vec3, Vec3), zero: Vec3) {
    let front = x.cross(y).normalize();
    for theta in [0.0, 0.5, 1.2, 2.3f32] {
        let expected = zero * theta.cos() + front.cross(zero) * theta.sin();
        for side in [1.0, -1.0] {
            let found = long_axis(mesh.clone(), 2.0 * side * front, theta);
            let cos = found.dot(expected).abs();
            assert!(
                cos > 0.02f32.cos(),
                "{what}, theta {theta}, side {side}: along {found}, not {expected}"
            );
        }
    }
}

/// Half the sides of plates in three planes; the plates are larger than the view.
const PLATES: [(Vec3, Vec3); 3] = [
    (Vec3::new(2.0, 0.0, 0.0), Vec3::new(0.0, 2.0, 0.0)),
    (Vec3::new(0.0, 2.0, 0.0), Vec3::new(0.0, 0.0, 2.0)),
    (Vec3::new(0.0, 0.0, 2.0), Vec3::new(2.0, 0.0, 0.0)),
];

fn plate((x, y): (Vec3, Vec3), uvs: &[Vec2]) -> Mesh {
    quad_mesh(plate_corners(Vec3::ZERO, x, y), uvs)
}

/// Texture coordinates whose u grows along the angle `psi` from the plate's x to its y; `hand`
/// mirrors the texture.
fn uvs(psi: f32, hand: f32) -> [Vec2; 4] {
    let (sin, cos) = psi.sin_cos();
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Vec2::new(cos * x + sin * y, hand * (cos * y - sin * x)))
}

#[test]
fn the_angle_counts_from_tangent_first() {
    for (x, y) in PLATES {
        let tangent = (0.8 * x + 0.5 * y).normalize();
        let mut mesh = plate((x, y), &uvs(1.5, 1.0));
        // The handedness in w is for normal maps and must not matter.
        for w in [1.0, -1.0] {
            mesh.tangents = vec![tangent.extend(w); mesh.positions.len()];
            check("TANGENT", &mesh, (x, y), tangent);
        }
    }
}

#[test]
fn the_angle_counts_from_growing_u_next() {
    for (x, y) in PLATES {
        for hand in [1.0, -1.0] {
            let zero = (x * 0.7f32.cos() + y * 0.7f32.sin()).normalize();
            check("growing u", &plate((x, y), &uvs(0.7, hand)), (x, y), zero);
        }
    }
}

#[test]
fn the_angle_counts_from_world_x_or_z_last() {
    for ((x, y), zero) in PLATES.into_iter().zip([Vec3::X, Vec3::Z, Vec3::X]) {
        check("world axis", &plate((x, y), &[]), (x, y), zero);
    }
    // On a tilted plate the zero is the projection of +x.
    let (x, y) = (Vec3::new(1.5, 0.0, -1.5), 2.0 * Vec3::Y);
    check("projection", &plate((x, y), &[]), (x, y), x.normalize());
}

#[test]
fn useless_tangents_and_texture_coordinates_are_passed_over() {
    let (x, y) = PLATES[0];
    let point = [Vec2::splat(0.5); 4];
    check("one point of the texture", &plate((x, y), &point), (x, y), Vec3::X);
    // All of the plate on one line of the texture, across which u does not grow by v.
    let line = [(0.0, 0.0), (0.3, 0.6), (1.0, 2.0), (0.7, 1.4)].map(|(u, v)| Vec2::new(u, v));
    check("a line of the texture", &plate((x, y), &line), (x, y), Vec3::X);
    let mut mesh = plate((x, y), &uvs(0.7, 1.0));
    mesh.tangents = vec![Vec4::Z; mesh.positions.len()];
    let zero = (x * 0.7f32.cos() + y * 0.7f32.sin()).normalize();
    check("a tangent along the normal", &mesh, (x, y), zero);
}
