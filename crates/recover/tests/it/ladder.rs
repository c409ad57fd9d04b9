//! The ladder against a renderer in closed form: horizontal stripes of seven materials under a grid
//! of directional lights, without noise. Every rung must be found, with its numbers.

use crate::stripes::{self, Stripes};
use glam::Vec2;
use unrender_recover::{
    Effort, Expected, ExposureRule, GroupResult, GroupSpec, Hypothesis, Like, Observation, Options,
    ParameterBounds, Problem, Recovery, Role, Status, recover, refine_from,
};
use unrender_scene::{BrdfModel, Image, Material, Rgb, Texture, Wrap};

fn checkers() -> Material {
    let image = Image::from_fn(64, 24, |x, y| {
        if (x / 8 + y / 6) % 2 == 0 { Rgb::new(0.7, 0.5, 0.2) } else { Rgb::splat(0.1) }
    });
    let texture = Texture { image, wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat };
    Material { texture: Some(texture.into()), ..Material::diffuse(Rgb::new(0.4, 0.3, 0.15)) }
}

/// One material a rung, in the ladder's order.
pub(crate) fn one_of_each() -> Vec<Material> {
    stripes::uniform().into_iter().chain([checkers()]).collect()
}

pub(crate) fn recovered(
    renderer: &Stripes,
    exposure: ExposureRule,
    scale: f32,
    options: &Options,
) -> Recovery {
    with_problem(renderer, exposure, scale, |p| recover(p, options, &mut ()).unwrap())
}

pub(crate) fn with_problem(
    renderer: &Stripes,
    exposure: ExposureRule,
    scale: f32,
    solve: impl Fn(&Problem<'_>) -> Recovery,
) -> Recovery {
    let mut picture = renderer.photograph();
    picture.values = picture.values.map(|v| *v * scale);
    let groups = renderer.truth.len() + 1;
    let observation = Observation::new(picture, &renderer.geometry, groups);
    let anchor = match exposure {
        ExposureRule::Anchor { group, .. } => Some(group),
        ExposureRule::Fixed(_) => None,
    };
    let spec = |group: usize| GroupSpec {
        name: format!("stripe {group}"),
        role: if anchor == Some(group) { Role::Known } else { Role::Unknown },
        material: Material::diffuse(Rgb::new(0.2, 0.5, 0.8)),
        rungs: Hypothesis::ALL.to_vec(),
        expected: renderer.expected.get(group).copied().unwrap_or_default(),
    };
    let problem = Problem {
        photometric_parameters: &[],
        observation: &observation,
        renderer,
        groups: (0..groups).map(spec).collect(),
        exposure,
        unknown_lights: Vec::new(),
        coloured_lights: Vec::new(),
        neighbouring_lights: Vec::new(),
        detail: None,
    };
    solve(&problem)
}

pub(crate) fn close(found: Rgb, truth: Rgb, tolerance: f32) -> bool {
    (found - truth).abs().max_element() <= tolerance
}

/// Fails unless the last change that was made of a group's hypothesis is the one to what it is: whoever asks why reads
/// what happened.
pub(crate) fn says_why(group: &GroupResult) {
    let last = group.decisions.iter().rev().find(|decision| decision.accepted);
    let made = last.map_or(Hypothesis::Diffuse, |decision| decision.to);
    assert_eq!(made, group.hypothesis, "{}: {:#?}", group.name, group.decisions);
}

/// Every stripe's hypothesis, reflectances, roughness and direction.
fn check(recovery: &Recovery, truth: &[Material]) {
    for (group, (truth, hypothesis)) in
        recovery.groups.iter().zip(truth.iter().zip(Hypothesis::ALL))
    {
        let found = &group.material;
        assert_eq!(group.hypothesis, hypothesis, "{}: {:#?}", group.name, group.selection_log);
        assert_eq!(group.status, Status::Recovered, "{}: {:?}", group.name, group.note);
        says_why(group);
        let tolerance = if hypothesis == Hypothesis::Textured { 0.02 } else { 0.002 };
        assert!(close(found.rho_d, truth.rho_d, tolerance), "{}: {found:?}", group.name);
        assert!(close(found.rho_s, truth.rho_s, 0.002), "{}: {found:?}", group.name);
        if truth.is_glossy() {
            assert!((found.alpha_x / truth.alpha_x - 1.0).abs() < 0.005, "{found:?}");
            assert!((found.alpha_y / truth.alpha_y - 1.0).abs() < 0.005, "{found:?}");
        }
        if hypothesis == Hypothesis::Anisotropic {
            assert!((found.theta_rad - truth.theta_rad).to_degrees().abs() < 0.2, "{found:?}");
        }
    }
}

#[test]
fn every_rung_is_found_with_its_numbers() {
    let renderer = Stripes::new(one_of_each());
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let recovery = recovered(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, &options);
    check(&recovery, &renderer.truth);
    let checkers = recovery.groups[6].material.texture.as_ref().unwrap();
    let light = checkers.sample(Vec2::new(4.0 / 64.0, 3.0 / 24.0));
    let dark = checkers.sample(Vec2::new(12.0 / 64.0, 3.0 / 24.0));
    assert!(close(light, Rgb::new(0.7, 0.5, 0.2), 0.01), "{light}");
    assert!(close(dark, Rgb::splat(0.1), 0.01), "{dark}");
    // Without noise a group's light as a whole is uncertain by 0.3 %.
    let diffuse = &recovery.groups[0];
    let std = diffuse.std.and_then(|std| std.rho_d).unwrap() / diffuse.material.rho_d;
    assert!(close(std, Rgb::splat(0.003), 2e-4), "{std}");
    // A group that no pixel shows is assumed to be as light as walls are.
    let unseen = recovery.groups.last().unwrap();
    assert_eq!((unseen.status, unseen.pixels), (Status::Assumed, 0));
    assert_eq!(unseen.material, Material::diffuse(Rgb::splat(0.7)));
    assert!(unseen.note.as_ref().unwrap().contains("no pixel"));
}

#[test]
fn every_rung_is_found_with_the_numbers_of_ggx() {
    let renderer = Stripes { model: BrdfModel::Ggx, ..Stripes::new(one_of_each()) };
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let recovery = recovered(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, &options);
    check(&recovery, &renderer.truth);
}

#[test]
fn bounds_are_kept_whatever_the_photograph_says() {
    let truth = one_of_each();
    let truth = [0, 4, 6, 2].map(|stripe| truth[stripe].clone()).to_vec();
    let free = ParameterBounds::default();
    let bounds = [
        ParameterBounds {
            rho_d: [Rgb::ZERO, Rgb::new(1.0, 0.4, 1.0)],
            rho_s: [Rgb::ZERO, Rgb::ZERO],
            ..free
        },
        ParameterBounds { alpha_x: [0.124, 1.0], ..free },
        ParameterBounds { rho_d: [Rgb::splat(0.15), Rgb::splat(0.6)], ..free },
        ParameterBounds { alpha_x: [0.05, 1.0], ..free },
    ];
    let expected = bounds.map(|bounds| Expected { bounds, ..Expected::default() }).to_vec();
    let renderer = Stripes { expected, ..Stripes::new(truth) };
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let recovery = recovered(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, &options);
    for (group, bounds) in recovery.groups.iter().zip(&bounds) {
        assert!(bounds.allow(group.hypothesis), "{} is {}", group.name, group.hypothesis);
        assert_eq!(group.material, bounds.nearest(&group.material), "{}", group.name);
    }
    let [diffuse, lobe] = [0, 1].map(|group| &recovery.groups[group]);
    assert!(close(diffuse.material.rho_d, Rgb::new(0.2, 0.4, 0.8), 1e-3), "{:?}", diffuse.material);
    let note = diffuse.note.as_deref().unwrap_or_default();
    assert!(note.contains("rho_d lies on its bound max = [1, 0.4, 1] in green"), "{note}");
    assert_eq!(lobe.hypothesis, Hypothesis::Isotropic);
    assert!((lobe.material.alpha_x - 0.124).abs() < 1e-6, "{:?}", lobe.material);
    let note = lobe.note.as_deref().unwrap_or_default();
    assert!(note.contains("alpha_x lies on its bound min = 0.124, which std leaves out"), "{note}");
}

#[test]
fn what_is_certainly_negligible_is_left_out() {
    // A diffuse stripe that starts slightly specular, and a round lobe that starts brushed.
    let round = Material::isotropic(Rgb::splat(0.2), Rgb::splat(0.4), 0.2);
    let diffuse = Material::diffuse(Rgb::new(0.2, 0.5, 0.8));
    let renderer = Stripes::new(vec![diffuse.clone(), round.clone()]);
    let shiny = Material { rho_s: Rgb::splat(0.03), alpha_x: 0.3, alpha_y: 0.3, ..diffuse.clone() };
    let brushed = Material { alpha_x: 0.19, alpha_y: 0.21, theta_rad: 1.0, ..round };
    let thought = [shiny, brushed, diffuse];
    let recovery = with_problem(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, |problem| {
        refine_from(problem, &thought, &Options::default(), &mut ()).unwrap()
    });
    let hypotheses = [Hypothesis::Diffuse, Hypothesis::Isotropic];
    for ((found, truth), hypothesis) in recovery.groups.iter().zip(&renderer.truth).zip(hypotheses)
    {
        assert_eq!(found.hypothesis, hypothesis, "{}", found.name);
        assert!(close(found.material.rho_d, truth.rho_d, 1e-3), "{:?}", found.material);
        assert!((found.material.alpha_x - truth.alpha_x).abs() < 2e-3, "{:?}", found.material);
        let note = found.note.as_deref().unwrap_or_default();
        assert!(note.contains("negligible"), "{note}");
    }
}

#[test]
fn mirrors_that_are_thought_a_little_diffuse_are_mirrors() {
    let (perfect, dim) = (Material::mirror(Rgb::ONE), Material::mirror(Rgb::splat(0.4)));
    let renderer = Stripes::new(vec![perfect.clone(), dim.clone()]);
    let thought = [&perfect, &dim].map(|mirror| Material {
        rho_d: Rgb::splat(0.02),
        rho_s: 0.97 * mirror.rho_s,
        ..mirror.clone()
    });
    let [a, b] = thought;
    let thought = [a, b, Material::diffuse(Rgb::ONE)];
    let recovery = with_problem(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, |problem| {
        refine_from(problem, &thought, &Options::default(), &mut ()).unwrap()
    });
    let [first, second] = [0, 1].map(|group| &recovery.groups[group]);
    assert_eq!(first.hypothesis, Hypothesis::Mirror);
    assert_eq!(first.material, perfect);
    assert_eq!(second.hypothesis, Hypothesis::PartialMirror);
    assert!(close(second.material.rho_s, dim.rho_s, 1e-3), "{:?}", second.material);
    assert_eq!(second.material.rho_d, Rgb::ZERO);
}

#[test]
fn a_faint_lobe_is_found_beside_groups_that_no_hypothesis_explains() {
    let faint = Material::isotropic(Rgb::splat(0.4), Rgb::splat(0.03), 0.15);
    let renderer = Stripes::new(vec![checkers(), checkers(), faint.clone()]);
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let recovery = with_problem(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, |problem| {
        let mut problem = problem.clone();
        for group in &mut problem.groups[..2] {
            group.rungs.retain(|rung| *rung != Hypothesis::Textured);
        }
        recover(&problem, &options, &mut ()).unwrap()
    });
    let found = &recovery.groups[2];
    assert_eq!(found.hypothesis, Hypothesis::Isotropic, "{:#?}", found.decisions);
    assert!(close(found.material.rho_s, faint.rho_s, 0.002), "{:?}", found.material);
}

#[test]
fn an_anchor_fixes_an_unknown_exposure() {
    let of_each = one_of_each();
    let renderer = Stripes::new(vec![of_each[0].clone(), of_each[4].clone()]);
    let rule = ExposureRule::Anchor { group: 0, rho_d: Rgb::new(0.2, 0.5, 0.8) };
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let recovery = recovered(&renderer, rule, 0.4, &options);
    assert!(close(recovery.exposure, Rgb::splat(2.5), 1e-3), "{}", recovery.exposure);
    assert_eq!(recovery.groups[0].status, Status::Known);
    assert!(close(recovery.groups[1].material.rho_d, renderer.truth[1].rho_d, 0.002));
}

#[test]
fn a_group_out_of_sight_is_as_bright_as_one_that_it_is_like() {
    let truth = one_of_each()[..2].to_vec();
    let like = Expected { like: Some(Like { group: 0, within: 0.1 }), ..Expected::default() };
    let expected = vec![Expected::default(), Expected::default(), like];
    let renderer = Stripes { expected, ..Stripes::new(truth) };
    let options = Options::default();
    let known = ExposureRule::Anchor { group: 0, rho_d: renderer.truth[0].rho_d };
    for rule in [ExposureRule::Fixed(Rgb::ONE), known] {
        let recovery = recovered(&renderer, rule, 1.0, &options);
        assert!(close(recovery.groups[0].material.rho_d, renderer.truth[0].rho_d, 1e-3));
        let unseen = &recovery.groups[2];
        assert_eq!((unseen.status, unseen.pixels), (Status::Recovered, 0), "{:?}", unseen.note);
        // Its own prior, 0.7 +- 0.2, and that of being alike are weighed by their variances.
        let (same, within) = (renderer.truth[0].rho_d, 0.1 * renderer.truth[0].rho_d);
        let (near, far) = ((within * within).recip(), Rgb::splat(0.2).powf(-2.0));
        let expected = (near * same + far * 0.7) / (near + far);
        assert!(close(unseen.material.rho_d, expected, 0.003), "{unseen:?}");
        let std = unseen.std.and_then(|std| std.rho_d).unwrap();
        assert!(close(std, (near + far).recip().powf(0.5), 0.003), "{std}");
        let note = unseen.note.as_deref().unwrap_or_default();
        assert!(note.contains("like \"stripe 0\" within 10 %, as the project says"), "{note}");
    }
}
