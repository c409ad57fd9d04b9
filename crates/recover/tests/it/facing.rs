//! Stripes that light each other: what one of them is made of shows in the other, too.

use crate::ladder::{close, recovered, says_why, with_problem};
use crate::stripes::{self, Facing, Stripes};
use unrender_recover::{
    Decision, Effort, ExposureRule, GroupSpec, Hypothesis, Options, Problem, Rule, recover,
};
use unrender_scene::{Material, Rgb};

/// Equal, parallel squares whose distance is a side: their form factor in closed form is
/// `2 / pi (ln(2 / sqrt 3) + 2 sqrt 2 atan(1 / sqrt 2) - 2 atan 1)`.
const SQUARES: Facing = Facing { form_factor: 0.199_825, hidden: None };

#[test]
fn every_rung_is_found_where_stripes_light_each_other() {
    let renderer = Stripes { facing: Some(SQUARES), ..Stripes::new(stripes::uniform().to_vec()) };
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let recovery = recovered(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, &options);
    for ((found, truth), hypothesis) in
        recovery.groups.iter().zip(&renderer.truth).zip(Hypothesis::ALL)
    {
        assert_eq!(found.hypothesis, hypothesis, "{}: {:#?}", found.name, found.decisions);
        says_why(found);
        assert!(close(found.material.rho_d, truth.rho_d, 0.002), "{:?}", found.material);
        assert!(close(found.material.rho_s, truth.rho_s, 0.002), "{:?}", found.material);
    }
}

/// A stripe whose specular part no pixel shows, beside one that it lights.
fn with_hidden_lobe() -> Stripes {
    let floor = Material { rho_d: Rgb::splat(0.2), ..Material::mirror(Rgb::splat(0.6)) };
    let wall = Material::diffuse(Rgb::new(0.6, 0.5, 0.4));
    let facing = Facing { form_factor: 0.5, hidden: Some(0) };
    Stripes { facing: Some(facing), ..Stripes::new(vec![floor, wall]) }
}

#[test]
fn a_lobe_that_shows_in_another_stripe_alone_is_found_and_the_record_says_by_what() {
    let renderer = with_hidden_lobe();
    let recovery = with_problem(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, |problem| {
        let groups = problem.groups.iter().enumerate().map(|(group, spec)| GroupSpec {
            rungs: match group {
                1 => vec![Hypothesis::Diffuse],
                _ => Hypothesis::ALL[..6].to_vec(),
            },
            ..spec.clone()
        });
        let problem = Problem { groups: groups.collect(), ..problem.clone() };
        recover(&problem, &Options::default(), &mut ()).unwrap()
    });
    let [floor, wall] = [0, 1].map(|group| &recovery.groups[group]);
    assert_ne!(floor.hypothesis, Hypothesis::Diffuse, "{:#?}", floor.decisions);
    assert!(close(floor.material.rho_s, renderer.truth[0].rho_s, 0.01), "{:?}", floor.material);
    assert!(close(wall.material.rho_d, renderer.truth[1].rho_d, 0.01), "{:?}", wall.material);
    says_why(floor);
    let is_by_others = |of: &Decision| of.rule == Rule::OtherGroups && of.accepted;
    assert!(floor.decisions.iter().any(is_by_others), "{:#?}", floor.decisions);
}
