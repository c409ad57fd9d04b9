//! A texture that re-rendered pixels speak against is not taken, not even at the end, and all comparisons see the same
//! photograph.

use crate::ladder::{close, one_of_each, recovered, with_problem};
use crate::stripes::{self, Stripes};
use unrender_recover::{ExposureRule, Hypothesis, Options, PhotometricParameter, Problem, recover};
use unrender_scene::{Image, Rgb};

#[test]
fn a_last_texture_that_explains_the_photograph_worse_is_not_taken() {
    let of_each = one_of_each();
    let truth = vec![of_each[0].clone(), of_each[6].clone()];
    let renderer = Stripes { misleads: true, ..Stripes::new(truth) };
    let recovery = recovered(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, &Options::default());
    let checkers = &recovery.groups[1];
    assert_eq!(checkers.hypothesis, Hypothesis::Textured, "{:#?}", checkers.decisions);
    // The last extraction comes to twice as much.
    let found = checkers.material.rho_d;
    assert!(close(found, renderer.truth[1].rho_d, 0.02), "{found}");
}

#[test]
fn hypotheses_are_chosen_by_the_photograph_as_the_camera_numbers_have_it() {
    let renderer = Stripes::new(stripes::uniform().to_vec());
    let shown = renderer.photograph().values;
    let (width, height) = (shown.width(), shown.height());
    // A vignette of up to 40 %, as it would be estimated; the photograph has it.
    let slope = |x: usize, y: usize| {
        let [u, v] = [x as f32 / width as f32 - 0.5, y as f32 / height as f32 - 0.5];
        -1.6 * (u * u + v * v) * *shown.at(x, y)
    };
    let derivative = Image::from_fn(width, height, slope);
    let parameters = [PhotometricParameter {
        photograph: 0,
        derivative,
        prior_mean: 0.0,
        deviation: 2.0,
        reach: 2.0,
    }];
    let mut shaded = renderer.photograph();
    let pairs = shaded.values.pixels_mut().iter_mut().zip(parameters[0].derivative.pixels());
    pairs.for_each(|(value, by)| *value += 0.5 * *by);
    let recovery = with_problem(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, |problem| {
        let mut observation = problem.observation.clone();
        observation.picture = shaded.clone();
        let problem = Problem {
            observation: &observation,
            photometric_parameters: &parameters,
            ..problem.clone()
        };
        recover(&problem, &Options::default(), &mut ()).unwrap()
    });
    assert!((recovery.photometric.steps[0] + 0.5).abs() < 0.01, "{:?}", recovery.photometric);
    for ((found, truth), hypothesis) in
        recovery.groups.iter().zip(&renderer.truth).zip(Hypothesis::ALL)
    {
        assert_eq!(found.hypothesis, hypothesis, "{}: {:#?}", found.name, found.decisions);
        assert!(close(found.material.rho_d, truth.rho_d, 0.005), "{:?}", found.material);
    }
    // The shade is the camera's: no fit of a hypothesis sees it.
    let diffuse = recovery.groups[0].selection_log.last().unwrap();
    assert!(diffuse.residual.relative() < 0.01, "{diffuse:?}");
}
