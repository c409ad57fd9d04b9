//! The paper's method against a renderer in closed form, without noise: the rungs must be found, with their numbers.

#[path = "../../../recover/tests/it/stripes.rs"]
mod stripes;

use stripes::Stripes;
use unrender_paper::{Paper, recover};
use unrender_recover::{
    GroupSpec, Hypothesis, Observation, Options, Picture, Problem, RecoverError, Recovery, Role,
};
use unrender_scene::{Material, Rgb};

/// What the method finds of the stripes, and of a group that no pixel shows.
fn recovered(renderer: &Stripes) -> Result<Recovery, RecoverError> {
    found(renderer, renderer.photograph())
}

/// The same from another photograph.
fn found(renderer: &Stripes, photograph: Picture) -> Result<Recovery, RecoverError> {
    let groups = renderer.truth.len() + 1;
    let observation = Observation::new(photograph, &renderer.geometry, groups);
    let spec = |group: usize| GroupSpec {
        name: format!("stripe {group}"),
        role: Role::Unknown,
        material: Material::diffuse(Rgb::new(0.2, 0.5, 0.8)),
        rungs: Hypothesis::ALL.to_vec(),
        expected: renderer.expected.get(group).copied().unwrap_or_default(),
    };
    let problem = Problem::new(&observation, renderer, (0..groups).map(spec).collect());
    // The picture has no noise: the thresholds may be strict.
    let paper = Paper { thresholds: [0.01; 6], ..Paper::default() };
    recover(&problem, &Options::default(), &paper, &mut (), None)
}

fn close(found: Rgb, truth: Rgb, tolerance: f32) -> bool {
    (found - truth).abs().max_element() <= tolerance
}

#[test]
fn where_no_light_arrives_an_error_names_what_is_dark() {
    let mut renderer = Stripes::new(vec![Material::diffuse(Rgb::new(0.2, 0.5, 0.8)); 2]);
    let lit = renderer.photograph();
    renderer.incident.clear();
    renderer.irradiance = Rgb::ZERO;
    let names = ["stripe 0", "stripe 1"].map(str::to_owned).to_vec();
    assert_eq!(found(&renderer, lit).unwrap_err(), RecoverError::NoLight(names));
}

#[test]
fn the_papers_ladder_finds_the_rungs_that_it_can_tell_apart() {
    let renderer = Stripes::new(stripes::uniform()[..4].to_vec());
    let recovery = recovered(&renderer).unwrap();
    for group in [0, 1, 2, 3] {
        let result = &recovery.groups[group];
        assert_eq!(result.hypothesis, Hypothesis::ALL[group], "{:#?}", result.selection_log);
        assert!(close(result.material.rho_d, renderer.truth[group].rho_d, 0.01));
        assert!(close(result.material.rho_s, renderer.truth[group].rho_s, 0.01));
    }
}

#[test]
fn the_papers_ladder_finds_a_lobe_and_the_brushed_direction_by_re_rendering() {
    let renderer = Stripes::new(stripes::uniform().to_vec());
    let recovery = recovered(&renderer).unwrap();
    for group in 0..6 {
        let (result, truth) = (&recovery.groups[group], &renderer.truth[group]);
        let found = &result.material;
        assert_eq!(result.hypothesis, Hypothesis::ALL[group], "{:#?}", result.selection_log);
        // The brushed stripe's direction lies between two of the 64, and the rest makes up for it.
        let within = if group == 5 { 0.02 } else { 0.005 };
        assert!(close(found.rho_d, truth.rho_d, within), "{found:?}");
        assert!(close(found.rho_s, truth.rho_s, within), "{found:?}");
        let off = |found: f32, truth: f32| (found - truth).abs() / truth.max(f32::MIN_POSITIVE);
        assert!(off(found.alpha_x, truth.alpha_x) < 0.02, "{found:?}");
        assert!(off(found.alpha_y, truth.alpha_y) < 0.02, "{found:?}");
    }
    let (found, truth) = (&recovery.groups[5].material, &renderer.truth[5]);
    assert!((found.theta_rad - truth.theta_rad).to_degrees().abs() < 3.0, "{found:?}");
    assert!(recovery.iterations.len() <= 24, "{} iterations", recovery.iterations.len());
}
