//! Whether the standard deviations are right: a small room is photographed again and again with
//! fresh noise, and each time all its numbers are refined. The truth must lie within two of the
//! stated standard deviations in 90 to 99 % of the cases, for every kind of number.
//!
//! The lamp's brightness or the exposure is unknown too.

use crate::brushed_room::{BACK, CEILING, FLOOR, LAMP, LEFT, camera, room, truth};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f32::consts::{FRAC_PI_2, TAU};
use unrender_recover::{
    Effort, Expected, ExposureRule, GroupResult, GroupSpec, Hypothesis, Observation, Options,
    Picture, Problem, Recovery, Role, Status, View, refine_from,
};
use unrender_render::sampler::mix;
use unrender_render::{Settings, Tracer};
use unrender_scene::{Group, Image, Material, Rgb, RgbImage, Scene, WardModel};

const SIDE: usize = 40;
/// Of the slow test, whose shares have standard deviations of about one percent.
const REALISATIONS: u64 = 72;
/// Of the fast one: they take a third of its time, their clean picture the rest.
const FEW: u64 = 8;
/// Of the photograph, relative.
const NOISE: f32 = 0.03;

/// A normal number for each `seed`.
fn normal(seed: u64) -> f32 {
    let uniform = |x: u64| ((mix(x) >> 40) as f32 + 0.5) / (1u64 << 24) as f32;
    let (u, v) = (uniform(2 * seed), uniform(2 * seed + 1));
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

fn noisy(clean: &RgbImage, realisation: u64) -> Picture {
    let value = |i: usize| {
        let noise = |c: u64| normal((realisation << 32) + 3 * i as u64 + c);
        clean.pixels()[i] * (Rgb::ONE + NOISE * Rgb::new(noise(0), noise(1), noise(2)))
    };
    let count = SIDE * SIDE;
    Picture {
        values: RgbImage::new(SIDE, SIDE, (0..count).map(value).collect()),
        valid: Image::new(SIDE, SIDE, vec![true; count]),
        saturated: Image::new(SIDE, SIDE, vec![false; count]),
        quantisation_step: RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; count]),
    }
}

/// Where the refinement starts: off in every number.
fn start() -> Vec<Material> {
    let off = |m: Material| Material {
        rho_d: m.rho_d * 0.9,
        rho_s: m.rho_s * 1.1,
        alpha_x: m.alpha_x * 1.15,
        alpha_y: m.alpha_y * 1.15,
        theta_rad: m.theta_rad + 0.08,
        ..m
    };
    truth().into_iter().map(off).collect()
}

/// Refines one realisation; with odd ones the lamp is unknown, with even ones the exposure.
fn refined(
    (scene, tracer): (&Scene, &Tracer),
    clean: &RgbImage,
    realisation: u64,
    effort: Effort,
) -> Recovery {
    let camera = camera();
    let view = View::new(tracer, &camera, (SIDE, SIDE), scene.brdf);
    let geometry = unrender_recover::Renderer::geometry(&view);
    let observation = Observation::new(noisy(clean, realisation), geometry, scene.groups.len());
    let unknown_lamp = realisation % 2 == 1;
    let spec = |(i, group): (usize, &Group)| GroupSpec {
        name: group.name.clone(),
        role: match i {
            LAMP => Role::Emitter,
            LEFT => Role::Known,
            _ => Role::Unknown,
        },
        material: group.material.clone(),
        rungs: Hypothesis::ALL.to_vec(),
        expected: Expected::default(),
    };
    let problem = Problem {
        photometric_parameters: &[],
        observation: &observation,
        renderer: &view,
        groups: scene.groups.iter().enumerate().map(spec).collect(),
        exposure: if unknown_lamp {
            ExposureRule::Fixed(Rgb::ONE)
        } else {
            ExposureRule::Anchor { group: LEFT, rho_d: truth()[LEFT].rho_d }
        },
        unknown_lights: if unknown_lamp { vec![LAMP] } else { Vec::new() },
        coloured_lights: Vec::new(),
        neighbouring_lights: Vec::new(),
        detail: None,
    };
    let options = Options { effort, seed: realisation, spp: 2, ..Options::default() };
    refine_from(&problem, &start(), &options, &mut ()).unwrap()
}

type Errors = BTreeMap<&'static str, Vec<f32>>;

/// The share of normally distributed numbers within two standard deviations.
const NORMAL_WITHIN_TWO: f32 = 0.9545;

fn note(errors: &mut Errors, kind: &'static str, found: Rgb, truth: Rgb, std: Option<Rgb>) {
    let std = std.expect(kind);
    errors.entry(kind).or_default().extend(((found - truth) / std).to_array());
}

/// Errors in units of their stated standard deviation, by kind.
fn errors(recovery: &Recovery, errors: &mut Errors) {
    let truth = truth();
    for (group, result) in recovery.groups.iter().enumerate() {
        let Some(std) = result.std else { continue };
        let found = &result.material;
        let kind = if group == CEILING { "rho_d out of sight" } else { "rho_d" };
        note(errors, kind, found.rho_d, truth[group].rho_d, std.rho_d);
        if group != FLOOR && group != BACK {
            continue;
        }
        note(errors, "rho_s", found.rho_s, truth[group].rho_s, std.rho_s);
        let mut one = |kind, error: f32, std: Option<f32>| {
            errors.entry(kind).or_default().push(error / std.expect(kind));
        };
        let ln = |found: f32, truth: f32| (found / truth).ln();
        let alpha_x = ln(found.alpha_x, truth[group].alpha_x);
        if group == BACK {
            one("alpha", alpha_x, std.ln_alpha_x);
            continue;
        }
        one("alpha_x", alpha_x, std.ln_alpha_x);
        one("alpha_y", ln(found.alpha_y, truth[group].alpha_y), std.ln_alpha_y);
        let turn = found.theta_rad - truth[group].theta_rad + FRAC_PI_2;
        one("theta", turn.rem_euclid(2.0 * FRAC_PI_2) - FRAC_PI_2, std.theta_rad);
    }
    for light in &recovery.lights {
        note(errors, "light", light.factor, Rgb::ONE, Some(light.std));
    }
    if recovery.exposure_std.is_some() {
        note(errors, "exposure", recovery.exposure, Rgb::ONE, recovery.exposure_std);
    }
}

/// The recoveries of the first `realisations` with so much `effort`, and their errors in units of the
/// stated standard deviations.
fn realised(realisations: u64, effort: Effort) -> (Vec<Recovery>, Errors) {
    let scene = room(WardModel::WardGmd.into());
    let tracer = Tracer::new(&scene);
    let settings = Settings { spp: 1024, seed: 99, ..Settings::default() };
    let clean = tracer.render(&scene.materials(), &camera(), (SIDE, SIDE), &settings, &|_| {}).mean;
    let recoveries: Vec<Recovery> = (0..realisations)
        .into_par_iter()
        .map(|realisation| refined((&scene, &tracer), &clean, realisation, effort))
        .collect();
    let mut all = Errors::new();
    recoveries.iter().for_each(|recovery| errors(recovery, &mut all));
    for (kind, errors) in &all {
        let n = errors.len() as f32;
        let within = errors.iter().filter(|e| e.abs() <= 2.0).count() as f32 / n;
        let rms = (errors.iter().map(|e| e * e).sum::<f32>() / n).sqrt();
        let mean = errors.iter().sum::<f32>() / n;
        println!("{kind}: {n} numbers, {within:.3} within two, rms {rms:.2}, mean {mean:.2}");
    }
    (recoveries, all)
}

/// The share of `errors` within two standard deviations.
fn share_within<'a>(errors: impl Iterator<Item = &'a f32>) -> f32 {
    let (within, all) = errors
        .fold((0, 0), |(within, all), error| (within + usize::from(error.abs() <= 2.0), all + 1));
    within as f32 / all as f32
}

/// All kinds of numbers together, some two hundred: their share's standard deviation is 1.5 %.
#[test]
fn a_few_photographs_lie_within_two_standard_deviations() {
    let (_, all) = realised(FEW, Effort::Draft);
    assert_eq!(all.len(), 9, "{:?}", all.keys());
    let within = share_within(all.values().flatten());
    assert!((0.88..=1.0).contains(&within), "{within}");
    let (sum, count) = all.values().flatten().fold((0.0, 0.0), |(s, n), e| (s + e * e, n + 1.0));
    let rms = f32::sqrt(sum / count);
    assert!((0.7..1.4).contains(&rms), "{rms}");
}

#[test]
#[ignore = "slow: 72 photographs"]
fn the_truth_lies_within_two_standard_deviations_as_often_as_it_should() {
    let (recoveries, all) = realised(REALISATIONS, Effort::Normal);
    let unseen = recoveries.iter().map(|r| &r.groups[CEILING]);
    let recovered: Vec<&GroupResult> = unseen.filter(|g| g.status == Status::Recovered).collect();
    println!("ceiling recovered in {} of {REALISATIONS}", recovered.len());
    assert!(recovered.iter().all(|g| g.pixels == 0));
    assert!(2 * recovered.len() as u64 > REALISATIONS);
    assert_eq!(all.len(), 9, "{:?}", all.keys());
    for (kind, errors) in &all {
        let n = errors.len() as f32;
        let within = errors.iter().filter(|e| e.abs() <= 2.0).count() as f32 / n;
        // Three standard deviations of how many of n there are.
        let deviation = (NORMAL_WITHIN_TWO * (1.0 - NORMAL_WITHIN_TWO) / n).sqrt();
        assert!((within - NORMAL_WITHIN_TWO).abs() <= 3.0 * deviation, "{kind}: {within}");
    }
}
