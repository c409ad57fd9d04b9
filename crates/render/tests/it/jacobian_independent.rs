//! Proves the derivatives of pictures without the paths that they come from: against differences of
//! ordinary renderings, closed forms, and scenes in which light is linear in the parameter.

use crate::common::{Estimate, Stage, assert_agree, camera, settings};
use glam::{DVec3, Vec3};
use unrender_render::{Appearance, Parameter, Query, Settings, Tracer};
use unrender_scene::{BrdfModel, Camera, LightKind, Material, Rgb, WardModel};

const FLOOR: u32 = 0;
const WALLS: u32 = 1;
const MIRROR: u32 = 2;

const SIDE: usize = 12;
const SIZE: (usize, usize) = (SIDE, SIDE);
const SEEDS: u64 = 8;

/// A scene with materials and a camera.
struct TestView {
    tracer: Tracer,
    materials: Vec<Material>,
    camera: Camera,
}

impl TestView {
    fn new(stage: &Stage, camera: Camera) -> Self {
        Self { tracer: stage.tracer(), materials: stage.scene.materials(), camera }
    }

    /// The picture's mean derivatives.
    fn derivatives(&self, parameters: &[Parameter], settings: Settings) -> Vec<Estimate> {
        let pixels: Vec<u32> = (0..(SIDE * SIDE) as u32).collect();
        let (materials, camera) = (&self.materials, &self.camera);
        let one = |seed| {
            let settings = Settings { seed, ..settings };
            self.tracer.jacobian(
                camera,
                SIZE,
                &Query { parameters, ..Query::new(materials, &pixels, &settings) },
            )
        };
        // Other seeds than those of the renderings.
        let jacobians: Vec<_> = (100..100 + SEEDS).map(one).collect();
        let of = |k: usize| {
            let column = |derivatives: &[Rgb]| {
                let rows = derivatives.chunks(parameters.len());
                rows.map(|row| row[k].as_dvec3()).sum::<DVec3>() / pixels.len() as f64
            };
            let samples: Vec<_> = jacobians.iter().map(|j| column(&j.derivatives)).collect();
            Estimate::of_samples(&samples)
        };
        (0..parameters.len()).map(of).collect()
    }

    /// The mean of a rendered picture with a parameter moved.
    fn rendered(&self, (parameter, step): (Parameter, f32), settings: Settings) -> DVec3 {
        let mut materials = self.materials.clone();
        let mut lights = vec![Rgb::ONE; materials.len()];
        match parameter {
            Parameter::RhoD(group) => materials[group as usize].rho_d += step,
            Parameter::RhoS(group) => materials[group as usize].rho_s += step,
            Parameter::AlphaX(group) => materials[group as usize].alpha_x += step,
            Parameter::AlphaY(group) => materials[group as usize].alpha_y += step,
            Parameter::Theta(group) => materials[group as usize].theta_rad += step,
            Parameter::Light(source) => lights[source as usize] += step,
            Parameter::Cache => unreachable!("no cache here"),
        }
        let appearance = Appearance { materials: &materials, lights: &lights };
        let film = self.tracer.render(appearance, &self.camera, SIZE, &settings, &|_| ());
        Estimate::of_film(&film).mean
    }

    /// The picture's mean derivative by the difference of two renderings, each of which draws its
    /// own paths from the same random numbers.
    fn difference(&self, parameter: Parameter, step: f32, settings: Settings) -> Estimate {
        let one = |seed| {
            let settings = Settings { seed, ..settings };
            let [plus, minus] = [step, -step].map(|s| self.rendered((parameter, s), settings));
            (plus - minus) / (2.0 * f64::from(step))
        };
        Estimate::of_samples(&(0..SEEDS).map(one).collect::<Vec<_>>())
    }
}

/// A bright room without caustics: the camera sees the lamp in the brushed floor and in a mirror.
fn calm_room(model: impl Into<BrdfModel>) -> TestView {
    let mut stage = Stage::default();
    stage.scene.brdf = model.into();
    let brushed = Material {
        rho_s: Rgb::new(0.5, 0.4, 0.3),
        alpha_x: 0.2,
        alpha_y: 0.4,
        theta_rad: 0.5,
        ..Material::diffuse(Rgb::new(0.2, 0.3, 0.4))
    };
    let floor = stage.group(brushed, Rgb::ZERO);
    stage.plate(floor, Vec3::NEG_Y, 2.0 * Vec3::Z, 2.0 * Vec3::X);
    let walls = stage.group(Material::diffuse(Rgb::new(0.8, 0.7, 0.6)), Rgb::ZERO);
    stage.room(walls, Vec3::new(1.0, 1.1, 1.0));
    let mirror = stage.group(Material::mirror(Rgb::new(0.9, 0.8, 0.7)), Rgb::ZERO);
    stage.plate(mirror, Vec3::new(0.0, 0.0, -0.95), 0.9 * Vec3::X, 0.9 * Vec3::Y);
    let lamp = stage.group(Material::diffuse(Rgb::splat(0.3)), Rgb::splat(2.0));
    stage.plate(lamp, Vec3::new(0.3, 1.05, -0.3), 0.4 * Vec3::X, 0.6 * Vec3::Z);
    TestView::new(&stage, camera(Vec3::new(0.0, 0.3, 0.9), Vec3::new(0.1, -0.7, -0.4), 0.9))
}

#[test]
fn derivatives_are_the_differences_of_renderings() {
    derivatives_are_differences(64, 3.0, 2.5);
}

#[test]
#[ignore = "slow: eight times as many paths"]
fn derivatives_are_the_differences_of_renderings_to_two_percent() {
    derivatives_are_differences(512, 1.0, 6.0);
}

/// Compares derivatives by `spp` paths a pixel; their noise may be `noisier` times that of 512
/// paths, and those without later bounces have to differ by more than `far` standard deviations.
fn derivatives_are_differences(spp: u32, noisier: f64, far: f64) {
    // Parameter, step, and the largest noise as a share of the derivative.
    let all = [
        (Parameter::RhoD(FLOOR), 0.05, 0.02),
        (Parameter::RhoD(WALLS), 0.02, 0.02),
        (Parameter::RhoS(FLOOR), 0.05, 0.02),
        (Parameter::RhoS(MIRROR), 0.05, 0.02),
        (Parameter::AlphaX(FLOOR), 0.02, 0.15),
        (Parameter::AlphaY(FLOOR), 0.04, 0.1),
    ];
    let view = calm_room(WardModel::WardGmd);
    let settings = settings(spp);
    let parameters = all.map(|a| a.0);
    let found = view.derivatives(&parameters, settings);
    let short = view.derivatives(&parameters, Settings { max_bounces: 3, ..settings });
    for (k, (parameter, step, noise_max)) in all.into_iter().enumerate() {
        // Renderings under two roughnesses share less of their noise: more paths for these.
        let rough = matches!(parameter, Parameter::AlphaX(_) | Parameter::AlphaY(_));
        let of_difference = if rough { crate::common::settings(3 * spp) } else { settings };
        let expected = view.difference(parameter, step, of_difference);
        assert_agree(&format!("{parameter:?}"), found[k], expected, noisier * noise_max);
        // Light of the fourth bounce and later is not lost in the noise.
        let z = short[k].z(&expected);
        assert!(z > far, "{parameter:?}: after three bounces only {z} standard deviations off");
    }
}

#[test]
fn a_highlight_changes_as_its_differences_say() {
    // A point light on a plate in the void: the same light in every rendering, without noise.
    for model in BrdfModel::ALL {
        let mut stage = Stage::default();
        stage.scene.brdf = model;
        let brushed = Material {
            rho_s: Rgb::new(0.5, 0.4, 0.3),
            alpha_x: 0.2,
            alpha_y: 0.4,
            theta_rad: 0.5,
            ..Material::diffuse(Rgb::ZERO)
        };
        let floor = stage.group(brushed, Rgb::ZERO);
        stage.plate(floor, Vec3::ZERO, Vec3::Z, Vec3::X);
        stage.light(LightKind::Point { position: Vec3::new(0.5, 1.0, -0.3), intensity: Rgb::ONE });
        let view = TestView::new(&stage, camera(Vec3::new(0.1, 0.8, 1.0), Vec3::ZERO, 0.3));
        for parameter in [Parameter::AlphaX(0), Parameter::AlphaY(0), Parameter::Theta(0)] {
            let seeds = 100..100 + SEEDS;
            let found = view.derivatives(&[parameter], settings(16))[0].mean;
            let difference = |seed| {
                let settings = Settings { seed, ..settings(16) };
                let [plus, minus] =
                    [2e-3, -2e-3].map(|step| view.rendered((parameter, step), settings));
                (plus - minus) / (2.0 * f64::from(2e-3f32))
            };
            let expected = seeds.map(difference).sum::<DVec3>() / SEEDS as f64;
            let error = ((found - expected) / expected).abs().max_element();
            assert!(error < 1e-3, "{model}, {parameter:?}: {found} is not {expected}, {error}");
        }
    }
}

/// A closed room whose walls all emit and reflect alike.
fn enclosure(emission: Rgb, rho: Rgb) -> Stage {
    let mut stage = Stage::default();
    let wall = stage.group(Material::diffuse(rho), emission);
    stage.room(wall, Vec3::new(1.0, 0.7, 1.5));
    stage
}

fn in_the_enclosure(stage: &Stage) -> TestView {
    TestView::new(stage, camera(Vec3::new(0.3, 0.1, 1.2), Vec3::new(0.0, -0.3, 0.0), 1.0))
}

#[test]
fn an_enclosure_has_the_derivative_of_the_geometric_series() {
    // L = E/(1 - rho); the last channel reflects nothing and still would.
    let (emission, rho) = (Rgb::new(1.0, 0.5, 0.1), Rgb::new(0.5, 0.9, 0.0));
    let view = in_the_enclosure(&enclosure(emission, rho));
    let [by_rho, by_light] =
        &view.derivatives(&[Parameter::RhoD(0), Parameter::Light(0)], settings(128))[..]
    else {
        unreachable!()
    };
    let rest = Rgb::ONE - rho;
    assert_agree("rho_d", *by_rho, Estimate::exactly(emission / (rest * rest)), 7e-3);
    assert_agree("light", *by_light, Estimate::exactly(emission / rest), 7e-3);
    // With n bounces: E (1 + rho + ... + rho^n).
    for max_bounces in 0..4 {
        let settings = Settings { max_bounces, ..settings(64) };
        let found = view.derivatives(&[Parameter::RhoD(0)], settings)[0];
        let powers = (1..=max_bounces).map(|n| n as f32 * rho.powf(n as f32 - 1.0));
        let expected = Estimate::exactly(emission * powers.sum::<Rgb>());
        assert_agree(&format!("{max_bounces} bounces"), found, expected, 5e-3);
    }
}

#[test]
fn a_furnace_does_not_care_how_its_floor_reflects() {
    furnace_does_not_care(128, 2.9);
}

#[test]
#[ignore = "slow: eight times as many paths"]
fn a_furnace_does_not_care_how_its_floor_reflects_by_a_thousand_paths() {
    furnace_does_not_care(1024, 1.0);
}

/// The noise of `spp` paths a pixel may be `noisier` times that of 1024.
fn furnace_does_not_care(spp: u32, noisier: f64) {
    // Under uniform light a change of rho_d and one of rho_s do the same, and if all change
    // together, so does the room.
    let (emission, rho) = (Rgb::ONE, Rgb::new(0.3, 0.5, 0.7));
    for rho_s in [0.5 * rho, Rgb::ZERO] {
        let mut stage = enclosure(emission, rho);
        let floor = stage.group(Material { rho_s, ..Material::diffuse(rho - rho_s) }, emission);
        stage.plate(floor, -0.69 * Vec3::Y, 1.5 * Vec3::Z, Vec3::X);
        let asked = [Parameter::RhoD(0), Parameter::RhoD(1), Parameter::RhoS(1)];
        let all = in_the_enclosure(&stage).derivatives(&asked, settings(spp));
        assert_agree("rho_s as rho_d", all[1], all[2], noisier * 2e-2);
        let rest = Rgb::ONE - rho;
        let whole =
            Estimate { mean: all[0].mean + all[1].mean, sigma: all[0].sigma + all[1].sigma };
        assert_agree(
            "all together",
            whole,
            Estimate::exactly(emission / (rest * rest)),
            noisier * 1e-2,
        );
    }
}

/// A ball of `material` in a black room with a lamp: light is linear in its reflectances.
fn lonely_ball(material: Material) -> TestView {
    let mut stage = Stage::default();
    let ball = stage.group(material, Rgb::ZERO);
    stage.sphere(ball, Vec3::ZERO, 0.5, 24);
    let walls = stage.group(Material::diffuse(Rgb::ZERO), Rgb::new(0.3, 0.2, 0.1));
    stage.room(walls, Vec3::splat(2.0));
    let lamp = stage.group(Material::diffuse(Rgb::ZERO), Rgb::new(3.0, 4.0, 5.0));
    stage.plate(lamp, Vec3::new(-0.5, 1.5, 1.0), 0.4 * Vec3::X, 0.4 * Vec3::Z);
    TestView::new(&stage, camera(Vec3::new(0.3, 0.4, 1.8), Vec3::new(0.03, 0.02, 0.0), 0.3))
}

#[test]
fn what_reflects_nothing_still_says_what_it_would_reflect() {
    let glossy = |rho_d: f32, rho_s: f32| Material {
        alpha_y: 0.3,
        ..Material::isotropic(Rgb::splat(rho_d), Rgb::splat(rho_s), 0.15)
    };
    let mirror = |rho_d: f32, rho_s: f32| Material {
        rho_s: Rgb::splat(rho_s),
        ..Material::diffuse(Rgb::splat(rho_d))
    };
    let render = |material: Material| {
        let view = lonely_ball(material);
        let one = |seed| {
            let settings = Settings { seed, ..settings(128) };
            view.rendered((Parameter::Light(0), 0.0), settings)
        };
        Estimate::of_samples(&(0..SEEDS).map(one).collect::<Vec<_>>())
    };
    // The derivatives are the pictures of what reflects all in one way.
    let (diffuse, lobe, reflection) =
        (render(mirror(1.0, 0.0)), render(glossy(0.0, 1.0)), render(mirror(0.0, 1.0)));
    for (name, material, specular) in [
        ("black", mirror(0.0, 0.0), reflection),
        ("diffuse", mirror(0.5, 0.0), reflection),
        ("mirror", mirror(0.0, 0.8), reflection),
        ("black with a roughness", glossy(0.0, 0.0), lobe),
        ("diffuse with a roughness", glossy(0.5, 0.0), lobe),
        ("glossy", glossy(0.0, 0.5), lobe),
        ("hardly glossy", glossy(0.9, 0.01), lobe),
    ] {
        let asked = [Parameter::RhoD(0), Parameter::RhoS(0)];
        let found = lonely_ball(material).derivatives(&asked, settings(128));
        assert_agree(&format!("{name}, rho_d"), found[0], diffuse, 1.5e-2);
        assert_agree(&format!("{name}, rho_s"), found[1], specular, 1.5e-2);
    }
}
