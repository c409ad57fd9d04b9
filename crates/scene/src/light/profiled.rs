//! Closed forms of profiles, and tables that say the same in other words.

use crate::{LightKind, LightProfile, Photometry, Rgb};
use glam::Vec3;
use std::f64::consts::PI;

/// Angles from `from` to `to` in steps of `step` degrees.
fn steps(from: i16, to: i16, step: usize) -> Vec<f32> {
    (from..=to).step_by(step).map(f32::from).collect()
}

/// The profile with the intensities `of(vertical, horizontal)`, angles in radians.
fn profile(
    photometry: Photometry,
    vertical: Vec<f32>,
    horizontal: Vec<f32>,
    of: impl Fn(f64, f64) -> f64,
) -> LightProfile {
    let radians = |angle: &f32| f64::from(*angle).to_radians();
    let pairs = horizontal.iter().flat_map(|h| vertical.iter().map(move |v| (v, h)));
    let candela: Vec<f64> = pairs.map(|(v, h)| of(radians(v), radians(h))).collect();
    LightProfile::new(photometry, vertical, horizontal, &candela).unwrap()
}

fn lamp(profile: &LightProfile, direction: Vec3) -> LightKind {
    let (position, upright) = (Vec3::ZERO, LightKind::upright(direction, Vec3::Y));
    let (intensity, profile) = (Rgb::ONE, profile.clone());
    LightKind::Profiled { position, direction, upright, intensity, profile }
}

#[test]
fn the_same_in_all_directions_is_a_point_light_to_the_bit() {
    let all = profile(Photometry::C, steps(0, 180, 5), steps(0, 360, 30), |_, _| 120.0);
    assert!((all.lumens() / (4.0 * PI * 120.0) - 1.0).abs() < 1e-12, "{}", all.lumens());
    let (lamp, intensity) = (lamp(&all, Vec3::NEG_Y), Rgb::ONE);
    let point = LightKind::Point { position: Vec3::ZERO, intensity };
    for at in [Vec3::NEG_Y, Vec3::Y, Vec3::X, Vec3::new(0.3, -0.2, 0.9), Vec3::new(-2.0, 1.0, -1.0)]
    {
        assert_eq!(lamp.illuminate(at), point.illuminate(at), "{at}");
    }
}

#[test]
fn a_cosine_sends_pi_times_its_greatest_intensity() {
    let round = profile(Photometry::C, steps(0, 90, 1), vec![0.0], |v, _| 500.0 * v.cos());
    assert!((round.lumens() / (500.0 * PI) - 1.0).abs() < 1e-4, "{}", round.lumens());
    // Two steps of a line in the angle have a closed form: 2 pi I (1 - 2/pi), as f = 1 - 2v/pi.
    let line = profile(Photometry::C, vec![0.0, 90.0], vec![0.0], |v, _| 1.0 - v / (0.5 * PI));
    assert!((line.steradians() - 2.0 * PI * (1.0 - 2.0 / PI)).abs() < 1e-6);
    assert!((round.reach_rad() - 0.5 * PI as f32).abs() < 1e-6);
}

#[test]
fn the_three_types_say_the_same_of_the_same_light() {
    // A light that depends on all directions: with f the axis, u upwards, r to the right.
    let of = |f: f64, u: f64, r: f64| 100.0 + 40.0 * f + 30.0 * u + 20.0 * r;
    let (around, half) = (steps(0, 360, 2), steps(-90, 90, 2));
    let c = profile(Photometry::C, steps(0, 180, 2), around, |v, h| {
        of(v.cos(), v.sin() * h.cos(), -v.sin() * h.sin())
    });
    let b = profile(Photometry::B, steps(-180, 180, 2), half.clone(), |v, h| {
        of(h.cos() * v.cos(), h.cos() * v.sin(), h.sin())
    });
    let a = profile(Photometry::A, half, steps(-180, 180, 2), |v, h| {
        of(v.cos() * h.cos(), v.sin(), v.cos() * h.sin())
    });
    // The three slopes cancel over the sphere.
    for one in [&a, &b, &c] {
        assert!((one.lumens() / (400.0 * PI) - 1.0).abs() < 1e-3, "{}", one.lumens());
    }
    for direction in [Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8), Vec3::new(0.48, -0.6, 0.64)] {
        let upright = LightKind::upright(direction, Vec3::Y);
        let right = direction.cross(upright);
        for at in [Vec3::X, Vec3::new(0.2, -0.9, 0.4), Vec3::new(-0.7, 0.1, -0.5), Vec3::Z] {
            let way = at.normalize();
            let [f, u, r] = [direction, upright, right].map(|axis| f64::from(way.dot(axis)));
            for one in [&a, &b, &c] {
                let found = lamp(one, direction).illuminate(way).2.x;
                let due = (of(f, u, r) / one.peak_candela()) as f32;
                assert!((found - due).abs() < 1e-3, "{:?} {at}: {found} {due}", one.photometry());
            }
        }
    }
}

#[test]
fn symmetric_tables_are_those_that_are_written_out() {
    // Alike on both sides of the plane of 0 and 180, or 90 and 270, or both.
    let halves = |v: f64, h: f64| 10.0 + v.sin() * (4.0 * h.cos() + (2.0 * h).cos());
    let ends = |v: f64, h: f64| 10.0 + v.sin() * (4.0 * h.sin() + (2.0 * h).cos());
    let both = |v: f64, h: f64| 10.0 + v.sin() * (2.0 * h).cos();
    type Law<'a> = &'a dyn Fn(f64, f64) -> f64;
    let laws: [(i16, i16, Law<'_>); 3] = [(0, 180, &halves), (90, 270, &ends), (0, 90, &both)];
    for (from, to, law) in laws {
        let all = profile(Photometry::C, steps(0, 180, 10), steps(0, 360, 15), law);
        let part = profile(Photometry::C, steps(0, 180, 10), steps(from, to, 15), law);
        assert!((all.lumens() / part.lumens() - 1.0).abs() < 1e-6, "{from} to {to}");
        let [all, part] = [all, part].map(|profile| lamp(&profile, Vec3::NEG_Y));
        for i in 0..24 {
            let turn = 0.26 * i as f32;
            let at = Vec3::new(turn.cos(), 0.3, turn.sin());
            let [all, part] = [&all, &part].map(|lamp| lamp.illuminate(at).2.x);
            assert!((all - part).abs() < 1e-5, "{from} to {to}, {turn}: {all} {part}");
        }
    }
}

#[test]
fn there_is_no_light_outside_the_angles() {
    let below = profile(Photometry::C, vec![0.0, 90.0], vec![0.0], |_, _| 1.0);
    let lamp = lamp(&below, Vec3::NEG_Y);
    assert_eq!(lamp.illuminate(Vec3::new(0.1, 1e-2, 0.0)).2, Rgb::ZERO);
    assert!(lamp.illuminate(Vec3::new(0.1, -1e-2, 0.0)).2.x > 0.0);
    assert!((below.steradians() - 2.0 * PI).abs() < 1e-6);
}

#[test]
fn a_lamp_is_aimed_upright_and_serialised_to_the_bit() {
    let across = profile(Photometry::C, vec![0.0, 33.3, 90.0], vec![0.0, 90.0], |v, h| {
        (v + 0.1) / (h + 0.3)
    });
    let bytes = postcard::to_allocvec(&across).unwrap();
    assert_eq!(postcard::from_bytes::<LightProfile>(&bytes).unwrap(), across);
    // Its second angle behind the third: no profile can be that.
    let [old, new] = [33.3f32, 133.3].map(f32::to_le_bytes);
    let at = bytes.windows(4).position(|four| four == old).unwrap();
    let bytes = [&bytes[..at], &new, &bytes[at + 4..]].concat();
    assert!(postcard::from_bytes::<LightProfile>(&bytes).is_err());
    assert_eq!(LightKind::upright(Vec3::NEG_Y, Vec3::Y), Vec3::X);
    assert_eq!(LightKind::upright(Vec3::X, Vec3::Y), Vec3::Y);
    let tilted = LightKind::upright(Vec3::new(0.6, -0.8, 0.0), Vec3::Y);
    assert!(tilted.distance(Vec3::new(0.8, 0.6, 0.0)) < 1e-6);
}

#[test]
fn tables_that_cannot_be_are_refused() {
    let of = |photometry, vertical: &[f32], horizontal: &[f32], candela: &[f64]| {
        LightProfile::new(photometry, vertical.to_vec(), horizontal.to_vec(), candela).is_err()
    };
    use Photometry::{A, B, C};
    assert!(!of(C, &[0.0, 90.0], &[0.0], &[1.0, 0.0]));
    assert!(of(C, &[0.0, 90.0], &[0.0], &[0.0, 0.0]));
    assert!(of(C, &[0.0, 90.0], &[0.0], &[1.0, -1.0]));
    assert!(of(C, &[0.0, 90.0], &[0.0], &[1.0, f64::INFINITY]));
    assert!(of(C, &[0.0, 90.0], &[0.0], &[1.0]));
    assert!(of(C, &[0.0, 190.0], &[0.0], &[1.0, 1.0]));
    assert!(of(C, &[90.0, 0.0], &[0.0], &[1.0, 1.0]));
    assert!(of(C, &[0.0], &[0.0], &[1.0]));
    assert!(of(C, &[0.0, f32::NAN], &[0.0], &[1.0, 1.0]));
    assert!(of(C, &[0.0, 90.0], &[0.0, 100.0], &[1.0; 4]));
    assert!(of(A, &[0.0, 90.0], &[0.0], &[1.0, 1.0]));
    assert!(of(B, &[0.0, 90.0], &[0.0, 100.0], &[1.0; 4]));
    assert!(of(C, &[0.0, 90.0], &[], &[]));
}
