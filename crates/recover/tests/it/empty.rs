//! Problems in which nothing is left to solve, or nothing to compare with: an answer or an error, and never a number that
//! is none.

use crate::stripes::Stripes;
use unrender_recover::{
    Effort, GroupSpec, Hypothesis, Observation, Options, Picture, Problem, RecoverError, Recovery,
    Role, Status, recover, refine_from,
};
use unrender_scene::{Material, Rgb};

const TRUTH: Rgb = Rgb::new(0.2, 0.5, 0.8);

fn stripes(count: usize) -> Stripes {
    Stripes::new(vec![Material::diffuse(TRUTH); count])
}

/// The recovery from `picture`, with the groups of the stripes, `known` or not, and one that no pixel shows.
fn recovered(
    renderer: &Stripes,
    picture: Picture,
    known: bool,
    options: &Options,
) -> Result<Recovery, RecoverError> {
    let count = renderer.truth.len() + 1;
    let observation = Observation::new(picture, &renderer.geometry, count);
    let spec = |group: usize| GroupSpec {
        name: format!("stripe {group}"),
        role: if known && group + 1 < count { Role::Known } else { Role::Unknown },
        material: Material::diffuse(TRUTH),
        rungs: Hypothesis::ALL.to_vec(),
        expected: Default::default(),
    };
    let problem = Problem::new(&observation, renderer, (0..count).map(spec).collect());
    recover(&problem, options, &mut ())
}

fn draft() -> Options {
    Options { effort: Effort::Draft, ..Options::default() }
}

fn is_finite(recovery: &Recovery) -> bool {
    recovery.groups.iter().all(|group| {
        let numbers = [group.material.rho_d, group.material.rho_s];
        let std = group.std.and_then(|std| std.rho_d).unwrap_or_default();
        numbers.iter().all(|rho| rho.is_finite()) && std.is_finite()
    })
}

#[test]
fn where_all_but_a_group_out_of_sight_is_known_it_is_assumed() {
    let renderer = stripes(2);
    for effort in [Effort::Draft, Effort::Normal] {
        let options = Options { effort, ..Options::default() };
        let recovery = recovered(&renderer, renderer.photograph(), true, &options).unwrap();
        let statuses: Vec<Status> = recovery.groups.iter().map(|group| group.status).collect();
        assert_eq!(statuses, [Status::Known, Status::Known, Status::Assumed]);
        assert!(recovery.groups[2].note.as_ref().unwrap().contains("no pixel shows"));
    }
    // The same from materials that are near, as `plan` asks.
    let observation = Observation::new(renderer.photograph(), &renderer.geometry, 3);
    let spec = |group: usize| GroupSpec {
        name: format!("stripe {group}"),
        role: if group < 2 { Role::Known } else { Role::Unknown },
        material: Material::diffuse(TRUTH),
        rungs: Hypothesis::ALL.to_vec(),
        expected: Default::default(),
    };
    let problem = Problem::new(&observation, &renderer, (0..3).map(spec).collect());
    let materials = vec![Material::diffuse(TRUTH); 3];
    let recovery = refine_from(&problem, &materials, &Options::default(), &mut ()).unwrap();
    assert_eq!(recovery.groups[2].status, Status::Assumed);
}

#[test]
fn where_no_light_arrives_an_error_names_what_is_dark() {
    let mut renderer = stripes(2);
    let photograph = renderer.photograph();
    renderer.incident.clear();
    renderer.irradiance = Rgb::ZERO;
    let error = recovered(&renderer, photograph, false, &draft()).unwrap_err();
    let names = ["stripe 0", "stripe 1"].map(str::to_owned).to_vec();
    assert_eq!(error, RecoverError::NoLight(names));
    assert!(error.to_string().contains("(\"stripe 0\", \"stripe 1\")"), "{error}");
}

#[test]
fn a_black_photograph_is_refused() {
    let renderer = stripes(2);
    let mut black = renderer.photograph();
    black.values = black.values.map(|_| Rgb::ZERO);
    assert_eq!(recovered(&renderer, black, false, &draft()).unwrap_err(), RecoverError::Black);
}

#[test]
fn a_stripe_that_is_black_in_bright_light_is_black_and_spoils_nothing() {
    // As a floating-point picture, whose noise is zero there.
    for scale in [1.0, 1e4] {
        let mut renderer = stripes(3);
        renderer.irradiance *= scale;
        renderer.incident.iter_mut().for_each(|light| light.irradiance *= scale);
        let mut picture = renderer.photograph();
        let geometry = &renderer.geometry;
        let values = picture.values.pixels_mut().iter_mut().zip(geometry.pixels());
        values.filter(|(_, p)| p.group == 1).for_each(|(value, _)| *value = Rgb::ZERO);
        let recovery = recovered(&renderer, picture, false, &draft()).unwrap();
        assert!(is_finite(&recovery), "{recovery:?}");
        assert!(
            recovery.iterations.iter().all(|i| i.worst_error < 1e4),
            "{:?}",
            recovery.iterations
        );
        assert!(recovery.groups[1].material.rho_d.max_element() < 1e-3);
        for lit in [0, 2] {
            let off = (recovery.groups[lit].material.rho_d - TRUTH).abs().max_element();
            assert!(off < 0.002, "{off}");
        }
    }
}

#[test]
fn a_stripe_that_no_light_reaches_is_assumed_and_not_recovered() {
    let renderer = Stripes { dark: Some(1), ..stripes(3) };
    for options in [draft(), Options { refine: false, ..draft() }] {
        let recovery = recovered(&renderer, renderer.photograph(), false, &options).unwrap();
        let statuses: Vec<Status> = recovery.groups.iter().map(|group| group.status).collect();
        assert_eq!(
            statuses,
            [Status::Recovered, Status::Assumed, Status::Recovered, Status::Assumed]
        );
        let dark = &recovery.groups[1];
        assert!(dark.pixels > 0 && dark.valid_pixels == 0);
        assert!(dark.note.as_ref().unwrap().contains("no light of the scene reaches"), "{dark:?}");
    }
}
