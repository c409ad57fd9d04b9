//! Proves that probes stand in for rendering: for any material of the surface,
//! `E + rho_d D + rho_s S` with `S` summed from the incident samples is the rendered radiance; the
//! same with mirrors, behind mirrors, and on either side of a surface.

use crate::common::{Estimate, Random, Stage, assert_agree, camera, settings};
use glam::{DVec3, Vec3};
use unrender_render::probe::{Incident, ProposalLobe};
use unrender_render::{Film, GlossyLobe, Probe, ProbeSettings, Probes, Query, Settings, Tracer};
use unrender_scene::{BrdfModel, Camera, LightKind, Material, Rgb, WardModel};

const SIDE: usize = 16;
/// Paths a pixel of the renderings that probes are compared with.
const PATHS: u32 = 256;
/// The largest noise of what is compared, of its mean: that of so many paths.
const NOISE: f64 = 1.5e-2;

/// A coloured room with two lights and a plate whose front or back the camera sees.
struct Room {
    tracer: Tracer,
    materials: Vec<Material>,
    model: BrdfModel,
    /// The group of the plate.
    plate: usize,
    camera: Camera,
}

impl Room {
    fn new(front: bool, model: impl Into<BrdfModel>, emission: Rgb) -> Self {
        let model = model.into();
        let mut stage = Stage::default();
        stage.scene.brdf = model;
        let plate = stage.group(Material::diffuse(Rgb::ZERO), emission);
        let (x, y) = (0.5 * Vec3::X, 0.5 * Vec3::NEG_Z);
        let (x, y) = if front { (x, y) } else { (y, x) };
        stage.plate(plate, Vec3::new(0.0, -0.4, 0.0), x, y);
        for (i, (axis, sign)) in
            [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0f32)].iter().enumerate()
        {
            let colour = Rgb::new(0.8, 0.6, 0.4).lerp(Rgb::new(0.2, 0.5, 0.7), i as f32 / 5.0);
            let wall = stage.group(Material::diffuse(colour), Rgb::ZERO);
            let unit = |i: usize| 1.2 * Vec3::AXES[i % 3];
            stage.plate(wall, unit(*axis) * *sign, unit(axis + 1), unit(axis + 2) * *sign * -1.0);
        }
        let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::new(6.0, 5.0, 4.0));
        stage.plate(lamp, Vec3::new(-0.5, 1.0, -0.6), 0.3 * Vec3::X, 0.2 * Vec3::Z);
        let position = Vec3::new(0.7, 0.6, -0.3);
        stage.light(LightKind::Point { position, intensity: Rgb::new(0.2, 0.3, 0.4) });
        Self {
            tracer: stage.tracer(),
            materials: stage.scene.materials(),
            model,
            plate,
            camera: camera(Vec3::new(0.3, 0.5, 1.0), Vec3::new(0.0, -0.4, 0.0), 0.2),
        }
    }

    fn with(&self, plate: &Material) -> Vec<Material> {
        let mut materials = self.materials.clone();
        materials[self.plate] = plate.clone();
        materials
    }

    fn render(&self, plate: &Material, spp: u32) -> Film {
        self.render_with(plate, &settings(spp))
    }

    fn render_with(&self, plate: &Material, settings: &Settings) -> Film {
        self.tracer.render(&self.with(plate), &self.camera, (SIDE, SIDE), settings, &|_| ())
    }

    /// Probes of the whole picture. The plate is flat and alone gets no light from itself, so its
    /// own material matters little; but light that it sends to the walls does come back.
    fn probes(&self, plate: &Material, settings: &ProbeSettings) -> Probes {
        let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
        self.tracer.probe(
            &self.camera,
            (SIDE, SIDE),
            &Query::new(&self.with(plate), &pixels, settings),
        )
    }
}

/// `v` of the tangent frame in the frame turned by `theta`.
fn turned(v: Vec3, theta: f32) -> Vec3 {
    let (sin, cos) = theta.sin_cos();
    Vec3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
}

/// `S`: what the lobe turned by `theta` reflects of the incident light.
fn specular(lobe: &GlossyLobe, theta: f32, wo: Vec3, incident: &[Incident]) -> DVec3 {
    let wo = turned(wo, theta);
    let one = |i: &Incident| (i.irradiance * lobe.value(wo, turned(i.wi, theta))).as_dvec3();
    incident.iter().map(one).sum()
}

/// The radiance of the plate by the probes, if it had the material.
fn by_probes(room: &Room, material: &Material, probes: &Probes) -> Estimate {
    let radiance = |probe: &Probe| {
        let base = probe.emitted + material.rho_d * probe.diffuse;
        let specular = if material.is_delta() {
            probe.mirror.as_dvec3()
        } else if material.is_glossy() {
            let lobe = GlossyLobe::new(room.model, material.alpha_x, material.alpha_y);
            specular(&lobe, material.theta_rad, probe.wo, probes.incident_of(probe))
        } else {
            DVec3::ZERO
        };
        probe.throughput.as_dvec3() * (base.as_dvec3() + material.rho_s.as_dvec3() * specular)
    };
    let samples: Vec<_> = probes.probes.iter().map(radiance).collect();
    Estimate::of_samples(&samples)
}

fn gather_all() -> ProbeSettings {
    let lobe = |alpha_x, alpha_y, theta_rad| ProposalLobe { alpha_x, alpha_y, theta_rad };
    ProbeSettings {
        probes_per_pixel: 64,
        cosine: 4,
        per_lobe: 4,
        lobes: vec![lobe(0.1, 0.1, 0.0), lobe(0.3, 0.1, 0.7)],
        mirror: 1,
        keep_incident: true,
        seed: 6,
        ..ProbeSettings::default()
    }
}

/// Diffuse, glossy and brushed materials, some of them at random.
fn materials() -> Vec<Material> {
    let mut random = Random::new(21);
    let mut all = vec![
        Material::diffuse(Rgb::new(0.7, 0.3, 0.1)),
        Material::isotropic(Rgb::ZERO, Rgb::new(0.9, 0.6, 0.4), 0.15),
        Material::mirror(Rgb::new(0.9, 0.5, 0.2)),
        Material { rho_s: Rgb::splat(0.4), ..Material::diffuse(Rgb::new(0.5, 0.3, 0.2)) },
    ];
    for _ in 0..3 {
        all.push(Material {
            rho_s: random.rgb(0.2, 0.6),
            alpha_x: 0.25 + 0.15 * random.next(),
            alpha_y: 0.08 + 0.07 * random.next(),
            theta_rad: 0.4 + 2.0 * random.next(),
            ..Material::diffuse(random.rgb(0.05, 0.4))
        });
    }
    all
}

#[test]
fn probes_foretell_the_rendering_of_any_material_on_either_side() {
    let materials = materials();
    foretell(&materials, true, WardModel::WardGmd.into());
    // One of each kind from behind.
    let kinds = [0, 2, 4].map(|kind| materials[kind].clone());
    foretell(&kinds, false, WardModel::WardGmd.into());
}

#[test]
#[ignore = "slow: the other models of a lobe"]
fn probes_foretell_the_rendering_of_any_model() {
    for model in [WardModel::Ward1992.into(), BrdfModel::Ggx] {
        foretell(&materials(), true, model);
    }
}

fn foretell(materials: &[Material], front: bool, model: BrdfModel) {
    let room = Room::new(front, model, Rgb::ZERO);
    for (index, material) in materials.iter().enumerate() {
        let probes = room.probes(material, &gather_all());
        let found = by_probes(&room, material, &probes);
        let rendered = Estimate::of_film(&room.render(material, PATHS));
        let what = format!("material {index}, front {front}, {model}");
        assert_agree(&what, found, rendered, NOISE);
    }
}

#[test]
fn one_gathering_serves_all_materials_where_nothing_comes_back() {
    // In black walls the light at the plate does not depend on the plate.
    let mut room = Room::new(true, WardModel::WardGmd, Rgb::ZERO);
    room.materials.fill(Material::diffuse(Rgb::ZERO));
    let probes = room.probes(&Material::diffuse(Rgb::ZERO), &gather_all());
    for (index, material) in materials().iter().enumerate().filter(|(_, m)| !m.is_delta()) {
        let rendered = Estimate::of_film(&room.render(material, PATHS));
        let found = by_probes(&room, material, &probes);
        assert_agree(&format!("material {index}"), found, rendered, NOISE);
    }
}

#[test]
fn the_brushed_direction_matters_to_these_proofs() {
    let room = Room::new(false, WardModel::WardGmd, Rgb::ZERO);
    let material = &materials()[4];
    let probes = room.probes(material, &gather_all());
    let rendered = Estimate::of_film(&room.render(material, PATHS));
    for theta_rad in [-material.theta_rad, 0.0, material.theta_rad + 0.3] {
        let wrong = Material { theta_rad, ..material.clone() };
        let z = by_probes(&room, &wrong, &probes).z(&rendered);
        assert!(z > 8.0, "theta {theta_rad} is only {z} standard deviations off");
    }
}

#[test]
fn emission_of_the_surface_is_its_own_term_and_only_in_front() {
    for front in [true, false] {
        let emission = Rgb::new(0.5, 0.2, 0.1);
        let room = Room::new(front, WardModel::WardGmd, emission);
        let material = Material::diffuse(Rgb::splat(0.5));
        let probes = room.probes(&material, &gather_all());
        let expected = if front { emission } else { Rgb::ZERO };
        assert!(probes.probes.iter().all(|p| p.emitted == expected));
        let rendered = Estimate::of_film(&room.render(&material, PATHS));
        assert_agree("emission", by_probes(&room, &material, &probes), rendered, NOISE);
    }
}

#[test]
fn light_in_two_lobes_of_any_width_is_counted_once() {
    // Another mixture of proposals must change the noise, not the sums.
    let room = Room::new(true, WardModel::WardGmd, Rgb::ZERO);
    let material = &materials()[5];
    let plain = ProbeSettings { cosine: 32, per_lobe: 0, lobes: Vec::new(), ..gather_all() };
    let a = by_probes(&room, material, &room.probes(material, &gather_all()));
    let b = by_probes(&room, material, &room.probes(material, &plain));
    assert_agree("two mixtures", a, b, NOISE);
}

#[test]
fn light_in_a_lobe_has_less_noise_along_its_own_directions() {
    let room = Room::new(true, WardModel::WardGmd, Rgb::ZERO);
    let brushed = Material { alpha_x: 0.3, theta_rad: 0.7, ..Material::mirror(Rgb::ONE) };
    let material = Material { alpha_y: 0.03, ..brushed };
    let noise = |lobes: Vec<ProposalLobe>| {
        let per_lobe = 12 / lobes.len() as u32;
        let settings = ProbeSettings { lobes, per_lobe, ..gather_all() };
        by_probes(&room, &material, &room.probes(&material, &settings)).sigma
    };
    let own = noise(vec![ProposalLobe::of(&material)]);
    let all = noise(ProposalLobe::round(&[0.02, 0.06, 0.16, 0.4]));
    let share = own / all;
    println!("{share}");
    assert!(share.max_element() < 0.95, "{share}");
}

#[test]
fn probes_end_paths_where_the_rendering_does() {
    let room = Room::new(true, WardModel::WardGmd, Rgb::ZERO);
    // Material 2 is a mirror; with a single reflection it shows black walls.
    for (index, max_bounces) in [(2, 2), (2, 3), (4, 1), (4, 2), (4, 3)] {
        let material = &materials()[index];
        let probes = room.probes(material, &ProbeSettings { max_bounces, ..gather_all() });
        let rendered = room.render_with(material, &Settings { max_bounces, ..settings(PATHS) });
        let found = by_probes(&room, material, &probes);
        let what = format!("material {index}, {max_bounces} bounces");
        assert_agree(&what, found, Estimate::of_film(&rendered), NOISE);
    }
}

#[test]
fn what_comes_straight_from_lights_is_all_light_of_one_bounce() {
    let room = Room::new(true, WardModel::default(), Rgb::ZERO);
    let plate = Material::diffuse(Rgb::splat(0.5));
    let gathered = |max_bounces| {
        let settings = ProbeSettings { max_bounces, ..gather_all() };
        room.probes(&plate, &settings).probes
    };
    let (all, direct) = (gathered(20), gathered(1));
    assert_eq!(all.len(), direct.len());
    for (all, direct) in all.iter().zip(&direct) {
        assert_eq!([all.straight, direct.straight], [direct.diffuse; 2]);
    }
    let sum = |of: &dyn Fn(&Probe) -> Rgb| all.iter().map(of).sum::<Rgb>();
    assert!(sum(&|probe| probe.diffuse).cmpgt(1.2 * sum(&|probe| probe.straight)).all());
}

#[test]
fn mirrors_on_the_way_count_as_bounces() {
    let (stage, view, target) = periscope();
    let (tracer, materials) = (stage.tracer(), stage.scene.materials());
    for (max_bounces, lit) in [(1, false), (2, false), (3, true)] {
        let render_settings = Settings { max_bounces, ..settings(16) };
        let rendered = Estimate::of_film(&stage.render(&view, 8, render_settings));
        assert_eq!(rendered.mean != DVec3::ZERO, lit);
        let settings = ProbeSettings {
            through_mirrors: true,
            mirror: 4,
            max_bounces,
            ..ProbeSettings::default()
        };
        for probe in
            tracer.probe(&view, (8, 8), &Query::new(&materials, &[0, 9, 63], &settings)).probes
        {
            assert_eq!(probe.group, target as u32);
            assert_eq!(probe.diffuse != Rgb::ZERO, lit, "{max_bounces} bounces");
        }
    }
}

#[test]
fn without_the_samples_the_sums_stay_the_same() {
    let room = Room::new(true, WardModel::WardGmd, Rgb::ZERO);
    let kept = ProbeSettings { probes_per_pixel: 2, ..gather_all() };
    let dropped = ProbeSettings { keep_incident: false, ..kept.clone() };
    let material = Material::diffuse(Rgb::splat(0.5));
    let (kept, dropped) = (room.probes(&material, &kept), room.probes(&material, &dropped));
    assert!(dropped.incident.is_empty() && !kept.incident.is_empty());
    for (a, b) in kept.probes.iter().zip(&dropped.probes) {
        assert_eq!((a.diffuse, a.mirror, b.count), (b.diffuse, b.mirror, 0));
    }
}

/// What two tilted mirrors show of a diffuse floor under a point light.
fn periscope() -> (Stage, Camera, usize) {
    let mut stage = Stage::default();
    let target = stage.group(Material::diffuse(Rgb::new(0.6, 0.4, 0.3)), Rgb::ZERO);
    stage.plate(target, Vec3::new(3.0, 1.0, 0.0), Vec3::NEG_Z, Vec3::Y);
    stage.light(LightKind::Point { position: Vec3::new(2.0, 1.5, 0.0), intensity: Rgb::ONE });
    for (y, tint) in [(0.0, Rgb::new(0.9, 0.5, 0.2)), (1.0, Rgb::new(0.3, 0.8, 0.5))] {
        let mirror = stage.group(Material::mirror(tint), Rgb::ZERO);
        let across = Vec3::new(0.3, 0.3, 0.0);
        stage.plate(mirror, Vec3::new(0.0, y, 0.0), across, 0.3 * Vec3::Z);
    }
    let view = camera(Vec3::new(-2.0, 0.0, 0.0), Vec3::ZERO, 0.05);
    (stage, view, target)
}

#[test]
fn probes_go_through_mirrors_with_what_the_mirrors_leave() {
    let (stage, view, target) = periscope();
    let tracer = stage.tracer();
    let materials = stage.scene.materials();
    let pixels: Vec<u32> = (0..64).collect();
    let settings =
        ProbeSettings { through_mirrors: true, probes_per_pixel: 512, ..ProbeSettings::default() };
    let probes = tracer.probe(&view, (8, 8), &Query::new(&materials, &pixels, &settings));
    assert_eq!(probes.probes.len(), 64 * 512);
    let throughput = Rgb::new(0.9, 0.5, 0.2) * Rgb::new(0.3, 0.8, 0.5);
    for probe in &probes.probes {
        assert_eq!(probe.group, target as u32);
        assert!((probe.throughput - throughput).abs().max_element() < 1e-6);
    }
    let rendered = Estimate::of_film(&stage.render(&view, 16, crate::common::settings(512)));
    let radiance = |p: &Probe| (p.throughput * materials[target].rho_d * p.diffuse).as_dvec3();
    let samples: Vec<_> = probes.probes.iter().map(radiance).collect();
    assert_agree("periscope", Estimate::of_samples(&samples), rendered, 2e-3);
    let settings = ProbeSettings { through_mirrors: false, ..settings };
    let probes = tracer.probe(&view, (8, 8), &Query::new(&materials, &pixels, &settings));
    assert!(probes.probes.iter().all(|p| p.group != target as u32 && p.throughput == Rgb::ONE));
}

#[test]
fn two_seeds_are_independent() {
    let room = Room::new(true, WardModel::WardGmd, Rgb::ZERO);
    let material = Material::diffuse(Rgb::splat(0.5));
    let brightness = |seed| -> Vec<f64> {
        let settings = ProbeSettings { probes_per_pixel: 1, cosine: 2, seed, ..gather_all() };
        room.probes(&material, &settings).probes.iter().map(|p| f64::from(p.diffuse.x)).collect()
    };
    // The noise is the difference from the picture, which a long run shows.
    let many: Vec<Vec<f64>> = (100..164).map(brightness).collect();
    let noise = |seed| -> Vec<f64> {
        let mean = |i: usize| many.iter().map(|m| m[i]).sum::<f64>() / many.len() as f64;
        brightness(seed).iter().enumerate().map(|(i, d)| d - mean(i)).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for (one, other) in [(1, 2), (0, 1), (7, 8), (3, 1 << 40)] {
        let (a, b) = (noise(one), noise(other));
        let correlation = dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt();
        let sigma = 1.0 / ((SIDE * SIDE) as f64).sqrt();
        assert!(correlation.abs() < 4.0 * sigma, "seeds {one} and {other}: {correlation}");
    }
}
