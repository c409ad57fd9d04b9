//! A room of GGX materials, photographed by our renderer and recovered as such, from nothing but the lamp and the
//! geometry.

use crate::brushed_room::{BACK, CEILING, FLOOR, LAMP, camera, room, truth};
use unrender_recover::{
    Effort, Expected, ExposureRule, GroupSpec, Hypothesis, Observation, Options, Picture, Problem,
    Recovery, Renderer, Role, View, recover,
};
use unrender_render::{Settings, Tracer};
use unrender_scene::{BrdfModel, Group, Image, Layering, Material, Rgb, RgbImage, Scene};

const SIDE: usize = 64;

#[test]
fn surfaces_without_a_coat_get_none_though_the_format_has_one() {
    let mut scene = room(BrdfModel::Principled(Layering::AlbedoScaled));
    for group in scene.groups.iter_mut().filter(|group| !group.is_emitter()) {
        group.material = Material::diffuse(group.material.rho_d);
    }
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let found = recovered_by(&scene, &options);
    for group in (0..scene.groups.len()).filter(|&g| g != LAMP && g != CEILING) {
        let (found, truth) = (&found.groups[group], &scene.groups[group].material);
        assert_eq!(found.hypothesis, Hypothesis::Diffuse, "{}", found.name);
        assert_eq!(found.material.rho_s, Rgb::ZERO, "{}", found.name);
        let off = (found.material.rho_d - truth.rho_d).abs().max_element();
        assert!(off < 0.005, "{}: {off}", found.name);
    }
}

fn picture(scene: &Scene) -> RgbImage {
    let settings = Settings { spp: 1024, seed: 7, ..Settings::default() };
    let tracer = Tracer::new(scene);
    tracer.render(&scene.materials(), &camera(), (SIDE, SIDE), &settings, &|_| {}).mean
}

/// The recovery from a picture of `scene`, its materials unknown.
fn recovered_by(scene: &Scene, options: &Options) -> Recovery {
    let (tracer, camera) = (Tracer::new(scene), camera());
    let view = View::new(&tracer, &camera, (SIDE, SIDE), scene.brdf);
    let picture = Picture {
        values: picture(scene),
        valid: Image::new(SIDE, SIDE, vec![true; SIDE * SIDE]),
        saturated: Image::new(SIDE, SIDE, vec![false; SIDE * SIDE]),
        quantisation_step: RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; SIDE * SIDE]),
    };
    let observation = Observation::new(picture, view.geometry(), scene.groups.len());
    let spec = |(i, group): (usize, &Group)| GroupSpec {
        name: group.name.clone(),
        role: if i == LAMP { Role::Emitter } else { Role::Unknown },
        material: group.material.clone(),
        rungs: Hypothesis::ALL.to_vec(),
        expected: Expected::default(),
    };
    let problem = Problem {
        photometric_parameters: &[],
        observation: &observation,
        renderer: &view,
        groups: scene.groups.iter().enumerate().map(spec).collect(),
        exposure: ExposureRule::Fixed(Rgb::ONE),
        unknown_lights: Vec::new(),
        coloured_lights: Vec::new(),
        neighbouring_lights: Vec::new(),
        detail: None,
    };
    recover(&problem, options, &mut ()).unwrap()
}

// Fast: `ladder.rs` finds every rung with the numbers of GGX.
#[test]
#[ignore = "slow: all of a recovery with the path tracer"]
fn a_room_of_ggx_is_recovered() {
    let found = recovered_by(&room(BrdfModel::Ggx), &Options::default());
    let truth = truth();
    let hypotheses = [(FLOOR, Hypothesis::Anisotropic), (BACK, Hypothesis::Isotropic)];
    for (group, hypothesis) in hypotheses {
        let (found, truth) = (&found.groups[group], &truth[group]);
        println!("{}: {:?}", found.name, found.material);
        assert_eq!(found.hypothesis, hypothesis, "{}: {:#?}", found.name, found.selection_log);
        let found = &found.material;
        assert!((found.rho_s - truth.rho_s).abs().max_element() < 0.01, "{found:?}");
        assert!((found.alpha_x / truth.alpha_x - 1.0).abs() < 0.03, "{found:?}");
        assert!((found.alpha_y / truth.alpha_y - 1.0).abs() < 0.03, "{found:?}");
    }
    let turn = found.groups[FLOOR].material.theta_rad - truth[FLOOR].theta_rad;
    assert!(turn.to_degrees().abs() < 1.0, "{turn}");
    for group in (0..truth.len()).filter(|&g| g != LAMP && g != CEILING) {
        let (found, truth) = (&found.groups[group].material, &truth[group]);
        assert!((found.rho_d - truth.rho_d).abs().max_element() < 0.01, "{group}: {found:?}");
    }
}
