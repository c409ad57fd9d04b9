//! Proves what the camera sees first: places and depths of a plane by closed form, normals of length one, reflectances as
//! they are stated, and the shares of groups by the place of an edge.

use crate::common::{Stage, camera, settings};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;
use unrender_render::adaptive::SampleAllocation;
use unrender_render::first_hits::NO_DEPTH;
use unrender_render::{Accumulator, FirstHits};
use unrender_scene::{LightKind, Material, Rgb};

const SIDE: usize = 8;
const SPP: u32 = 64;
/// The height of the camera over the floor.
const HEIGHT: f32 = 2.0;

/// A camera that looks straight down sees a floor of two groups, which meet at x = `edge`; beyond x = `end` there is
/// nothing. At the floor a pixel is half a metre wide.
fn seen(edge: f32, end: f32) -> FirstHits {
    let mut stage = Stage::default();
    let low = stage.group(Material::diffuse(Rgb::new(0.2, 0.4, 0.6)), Rgb::ZERO);
    let shiny = Material::isotropic(Rgb::splat(0.3), Rgb::splat(0.2), 0.2);
    let high = stage.group(shiny, Rgb::ZERO);
    let z = 9.0 * Vec3::Z;
    let at = |x: f32| x * Vec3::X;
    stage.quad(low, [at(-9.0) + z, at(edge) + z, at(edge) - z, at(-9.0) - z]);
    stage.quad(high, [at(edge) + z, at(end) + z, at(end) - z, at(edge) - z]);
    stage.light(LightKind::Point { position: HEIGHT * Vec3::Y, intensity: Rgb::ONE });
    let tracer = stage.tracer();
    let materials = stage.scene.materials();
    let camera = camera(HEIGHT * Vec3::Y, Vec3::ZERO, FRAC_PI_2);
    let settings = settings(SPP);
    let mut picture = Accumulator::new(SIDE, SIDE);
    let samples = SampleAllocation::Uniform(0..SPP);
    tracer.accumulate(&materials, &camera, &settings, &samples, &mut picture, &|_| ());
    tracer.first_hits(&materials, &camera, &settings, &picture)
}

/// The place on the floor behind the centre of a pixel.
fn place(x: usize, y: usize) -> Vec3 {
    let half = SIDE as f32 / 2.0;
    let at = (Vec2::new(x as f32, y as f32) + 0.5 - half) * HEIGHT / half;
    Vec3::new(at.x, 0.0, at.y)
}

#[test]
fn places_depths_and_normals_of_a_plane() {
    let seen = seen(0.0, 9.0);
    for y in 0..SIDE {
        for x in 0..SIDE {
            let found = seen.position.at(x, y).unwrap();
            assert!(found.abs_diff_eq(place(x, y), 1e-5), "{found} at {x}, {y}");
            // Along the line of sight, not along the ray.
            assert!((seen.depth.at(x, y) - HEIGHT).abs() < 1e-5);
            assert!(seen.normal.at(x, y).abs_diff_eq(Vec3::Y, 1e-6));
            let (group, albedo) =
                if x < SIDE / 2 { (0, Rgb::new(0.2, 0.4, 0.6)) } else { (1, Rgb::splat(0.5)) };
            assert!(seen.albedo.at(x, y).abs_diff_eq(albedo, 1e-6));
            assert_eq!(seen.groups.at(x, y)[..2], [(group, 1.0), (0, 0.0)]);
        }
    }
}

#[test]
fn an_edge_shares_a_pixel_and_nothing_is_nothing() {
    // The edge is a quarter into column 4, and the end a quarter into column 6.
    let seen = seen(0.125, 1.125);
    let mut shares = [0.0; 2];
    for y in 0..SIDE {
        let [first, second, third, ..] = *seen.groups.at(4, y);
        assert_eq!((first.0, second.0, first.1 + second.1, third.1), (1, 0, 1.0, 0.0));
        assert!((second.1 - 0.25).abs() < 0.1, "{}", second.1);
        let [end, none, ..] = *seen.groups.at(6, y);
        assert_eq!((end.0, none.1), (1, 0.0));
        assert!((seen.normal.at(6, y).y - end.1).abs() < 1e-6);
        shares = [shares[0] + second.1, shares[1] + end.1];
        // The pixel's centre sees nothing.
        assert_eq!((*seen.position.at(6, y), *seen.depth.at(6, y)), (None, NO_DEPTH));
        assert_eq!((seen.groups.at(7, y)[0].1, *seen.normal.at(7, y)), (0.0, Vec3::ZERO));
    }
    for share in shares {
        assert!((share / SIDE as f32 - 0.25).abs() < 0.02, "{share}");
    }
}
