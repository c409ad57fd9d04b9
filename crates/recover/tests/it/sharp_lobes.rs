//! A mirror that is thought to be a sharp lobe is found to be a mirror: no photograph distinguishes it from the
//! sharpest lobe that is searched.

use crate::brushed_room::{BACK, LEFT, camera, room, truth};
use unrender_recover::{
    GroupSpec, Hypothesis, Observation, Options, Picture, Problem, Recovery, Role, View,
    refine_from,
};
use unrender_render::{Settings, Tracer};
use unrender_scene::{Image, Material, Rgb, RgbImage, Scene, WardModel};

const SIDE: usize = 64;
/// Paths a pixel of the photograph.
const PATHS: u32 = 256;

/// The photograph of `scene`, taken by a camera without any noise but that of the paths.
fn photograph(scene: &Scene) -> Picture {
    let settings = Settings { spp: PATHS, seed: 77, ..Settings::default() };
    let tracer = Tracer::new(scene);
    let film = tracer.render(&scene.materials(), &camera(), (SIDE, SIDE), &settings, &|_| ());
    let count = SIDE * SIDE;
    Picture {
        values: film.mean,
        valid: Image::new(SIDE, SIDE, vec![true; count]),
        saturated: Image::new(SIDE, SIDE, vec![false; count]),
        quantisation_step: RgbImage::new(SIDE, SIDE, vec![Rgb::ZERO; count]),
    }
}

/// The room with this back wall, refined from a lobe of the roughness `alpha` there.
fn refined(back: Material, alpha: f32) -> Recovery {
    let mut materials = truth();
    materials[BACK] = back;
    let mut scene = room(WardModel::WardGmd.into());
    scene.groups.iter_mut().zip(&materials).for_each(|(g, m)| g.material.clone_from(m));
    let tracer = Tracer::new(&scene);
    let camera = camera();
    let view = View::new(&tracer, &camera, (SIDE, SIDE), scene.brdf);
    let geometry = unrender_recover::Renderer::geometry(&view);
    let observation = Observation::new(photograph(&scene), geometry, scene.groups.len());
    let mut groups: Vec<GroupSpec> = scene.groups.iter().map(GroupSpec::of).collect();
    groups[LEFT].role = Role::Known;
    let problem = Problem::new(&observation, &view, groups);
    let mut thought = materials.clone();
    (thought[BACK].alpha_x, thought[BACK].alpha_y) = (alpha, alpha);
    let options = Options { spp: 2, ..Options::default() };
    refine_from(&problem, &thought, &options, &mut ()).unwrap()
}

#[test]
#[ignore = "slow: three refinements with the path tracer"]
fn lobes_as_sharp_as_any_that_is_searched_are_mirrors() {
    let dim = Material::mirror(Rgb::new(0.7, 0.6, 0.5));
    let glazed = Material { rho_d: Rgb::splat(0.3), ..dim.clone() };
    for (back, hypothesis) in
        [(dim, Hypothesis::PartialMirror), (glazed, Hypothesis::DiffuseSpecular)]
    {
        let found = &refined(back.clone(), 0.006).groups[BACK];
        let off = |a: Rgb, b: Rgb| (a - b).abs().max_element();
        assert_eq!(found.hypothesis, hypothesis, "{:?}", found.material);
        assert!(found.material.is_delta(), "{:?}", found.material);
        assert!(off(found.material.rho_s, back.rho_s) < 0.006, "{:?}", found.material);
        assert!(off(found.material.rho_d, back.rho_d) < 0.006, "{:?}", found.material);
    }
    // A lobe that differs significantly from a mirror stays one.
    let glossy = Material::isotropic(Rgb::splat(0.1), Rgb::splat(0.6), 0.05);
    let found = &refined(glossy, 0.03).groups[BACK];
    assert_eq!(found.hypothesis, Hypothesis::Isotropic);
    assert!((found.material.alpha_x / 0.05 - 1.0).abs() < 0.1, "{:?}", found.material);
}
