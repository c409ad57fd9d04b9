//! The paper's method (section 4 and its Figure 1): the baseline that ours is measured against.
//!
//! In every iteration the whole scene is rendered again, each group's error is read off the difference,
//! and its reflectance is corrected under its present hypothesis: by the ratio of eqs. 1 to 3 for
//! diffuse surfaces and mirrors, by the 2x2 system, by downhill simplex over re-renderings ([`lobe`]), or by
//! the radiosity texture. A group whose rung has had its iterations and still shows an error above its
//! threshold goes one rung up.
//!
//! Three things are not as written (`docs/method/paper.md` says why): the anisotropy direction is that of 64 whose
//! re-rendering differs least, and read off the mirror difference ([`brushed`]) only if the settings say so; the
//! corrections of all groups are combined with those before (`mixing`); and a surface that is taken for smooth becomes
//! rough where that leaves half of the squared error. Where the paper is silent: the difference is measured as the
//! product of two renderings' residuals, since otherwise our noise would count as error and every search would avoid
//! specular terms; groups with one are rendered from light that is gathered once in an iteration, and used by every
//! step of a search.

pub mod brushed;
pub mod lobe;
mod mixing;
mod texture;

use lobe::Lobes;
use mixing::Mixing;
use serde::{Deserialize, Serialize};
use unrender_recover::compare::WORSE;
use unrender_recover::compare::residual::{ResidualStats, deviation_of_sum, residual_stats};
use unrender_recover::evidence::{Evidence, SampleBudget};
use unrender_recover::hypothesis::{self, Hypothesis, Search};
use unrender_recover::observe::blocks::spread;
use unrender_recover::problem::UNSEEN;
use unrender_recover::sample_budget;
use unrender_recover::{
    Journal, Observer, Options, Problem, RecoverError, Recovery, Session, Termination, recover_by,
};
use unrender_render::{ProbeSettings, ProposalLobe};
use unrender_scene::{Material, Rgb};

/// The specular rungs without a roughness.
const SMOOTH: [Hypothesis; 3] =
    [Hypothesis::Mirror, Hypothesis::PartialMirror, Hypothesis::DiffuseSpecular];
/// The fewest iterations of a diffuse group (the paper finds four sufficient) ...
const RATIO_ITERATIONS: usize = 4;
/// ... and the most of any rung that waits for reflectances to rest.
const ITERATIONS_MAX: usize = 12;
/// Reflectances have come to rest when none of the group moves by more than this.
const AT_REST: f64 = 0.02;
/// Only groups with at least this share of the worst error climb: the others may be in error
/// because of the light that the worst one sends them.
const WORST: f64 = 0.75;
/// Pixels of a group that an iteration looks at.
const ITERATION_PIXELS: usize = 8000;
/// Paths a pixel of a diffuse group.
const SPP: u32 = 16;
/// A shiny group's pixels are looked at in so many points each, ...
const POINTS: u32 = 4;
/// ... with so many directions by the cosine, and as many light samples, in each, ...
const COSINE: u32 = 4;
/// ... and so many for each lobe that is looked for.
const PER_LOBE: u32 = 16;
/// Lobes of every roughness, for a group whose roughness is not known.
const ANY_ALPHA: [f32; 4] = [0.02, 0.06, 0.16, 0.4];
/// Lobes about the present one: so many times as wide.
const WIDER: [f32; 3] = [0.5, 1.0, 2.0];
/// The method ends when no reflectance moves by more than this: as a step takes half of a correction, half is left.
const SETTLED: f64 = 0.002;

/// How the anisotropy direction is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Direction {
    /// Of 64 sampled directions the one whose re-rendering differs least from the photograph.
    #[default]
    Rerender,
    /// As the text says: read off the difference of the photograph and a mirror.
    Text,
}

/// The settings of the method, beside the [`Options`] of every recovery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Paper {
    /// How the anisotropy direction is found.
    pub direction: Direction,
    /// The error above which a group leaves each of the rungs diffuse, mirror, partial mirror, diffuse-specular,
    /// isotropic, anisotropic. The paper states the fifth.
    pub thresholds: [f64; 6],
    /// Global re-renderings at most.
    pub max_iterations: usize,
}

impl Default for Paper {
    fn default() -> Self {
        Self {
            direction: Direction::default(),
            thresholds: [0.15, 0.15, 0.15, 0.15, 0.01, 0.15],
            max_iterations: 100,
        }
    }
}

/// Recovers the material of every group of `problem` by the paper's method; steps that are in the `journal` are not done
/// again.
///
/// # Errors
/// As those of [`unrender_recover::recover`].
pub fn recover(
    problem: &Problem<'_>,
    options: &Options,
    paper: &Paper,
    observer: &mut dyn Observer,
    journal: Option<&dyn Journal>,
) -> Result<Recovery, RecoverError> {
    recover_by(problem, options, observer, journal, |session| climb(session, (options, paper)))
}

/// The materials as they are, with the groups that no pixel shows white where nothing else is expected of them.
fn white_where_unseen(session: &Session<'_, '_, '_>) -> Vec<Material> {
    let mut materials = session.materials().to_vec();
    for (group, material) in materials.iter_mut().enumerate() {
        let is_unseen = session.pixels(group).is_empty();
        if is_unseen && *material == Material::diffuse(Rgb::splat(UNSEEN)) {
            *material = Material::diffuse(Rgb::ONE);
        }
    }
    materials
}

/// Climbs one rung at a time.
fn climb(
    session: &mut Session<'_, '_, '_>,
    (options, paper): (&Options, &Paper),
) -> Result<Termination, RecoverError> {
    let mut rungs = vec![Standing::default(); session.materials().len()];
    session.set_materials(white_where_unseen(session));
    let mut mixing = Mixing::default();
    for iteration in 1..=paper.max_iterations {
        session.update_exposure(options)?;
        let climber = PaperIteration { options, paper, iteration };
        let views = session.value("paper's iteration", || climber.look(session));
        for view in &views {
            session.set_residual(view.group, view.error);
        }
        let leaving = climber.leaving(session, &views, &rungs);
        // Before that, a group that has to leave its rung may still be on it.
        let was_at_rest = climber.are_at_rest(session, &views, &rungs);
        let mut next = session.materials().to_vec();
        for view in &views {
            let group = view.group;
            let leaves = leaving.contains(&group);
            next[group] = climber.correct(session, view, leaves, &mut rungs[group]);
        }
        if leaving.is_empty() {
            next = mixing.step(session.materials(), &next);
        } else {
            mixing.forget();
        }
        for group in views.iter().map(|view| view.group) {
            next[group] = session.problem().groups[group].expected.bounds.nearest(&next[group]);
            rungs[group].change = distance(&session.materials()[group], &next[group]);
        }
        session.set_materials(next);
        let change = rungs.iter().map(|r| r.change).fold(0.0, f64::max);
        let done = iteration as f64 / (iteration as f64 + 8.0);
        let open: Vec<usize> = climber.in_error(session, &views);
        session.end_iteration(change, &open, done);
        if session.is_cancelled() {
            return Ok(Termination::Interrupted);
        }
        if leaving.is_empty() && was_at_rest && change < SETTLED {
            return Ok(Termination::Settled);
        }
    }
    Ok(Termination::IterationLimit)
}

/// How long a group has stood on its rung, and how far its last iteration moved it.
#[derive(Clone, Copy, Default)]
struct Standing {
    iterations: usize,
    change: f64,
}

impl Standing {
    /// Whether the rung has had its iterations under `hypothesis`.
    fn has_had_its_iterations(self, hypothesis: Hypothesis) -> bool {
        let is_at_rest = self.change < AT_REST || self.iterations >= ITERATIONS_MAX;
        match hypothesis {
            Hypothesis::Diffuse => self.iterations >= RATIO_ITERATIONS && is_at_rest,
            // There is nothing to correct, or it was solved for at once.
            Hypothesis::Mirror | Hypothesis::DiffuseSpecular => true,
            _ => self.iterations >= 1 && is_at_rest,
        }
    }
}

/// A group's pixels in the present re-rendering.
#[derive(Serialize, Deserialize)]
struct GroupView {
    group: usize,
    pixels: Vec<u32>,
    rerendered: Vec<Rgb>,
    error: ResidualStats,
    /// Whether it stands on the smooth rung of section 4.2.3, and the photograph says that it is not smooth.
    is_rough: bool,
    /// The light that a shiny group was re-rendered from; none where the rest is from a journal.
    #[serde(skip)]
    evidence: Option<Evidence>,
}

struct PaperIteration<'o> {
    options: &'o Options,
    paper: &'o Paper,
    iteration: usize,
}

impl PaperIteration<'_> {
    /// Renders all groups again and measures their errors.
    fn look(&self, session: &Session<'_, '_, '_>) -> Vec<GroupView> {
        let mut views = Vec::new();
        for group in session.asked() {
            let material = &session.materials()[group];
            let shines = material.rho_s != Rgb::ZERO;
            let evidence = shines.then(|| self.gather(session, group));
            let (pixels, halves) = match &evidence {
                Some(evidence) => {
                    let pixels = evidence.sample.pixels.iter().map(|p| p.pixel).collect();
                    (pixels, evidence.light.radiance(material))
                }
                None => self.rerender_sample(session, group),
            };
            let observed = session.stage().observe(group, &pixels);
            let error = residual_stats(&observed, &halves);
            let rerendered =
                halves[0].iter().zip(&halves[1]).map(|(a, b)| 0.5 * (*a + *b)).collect();
            let hypothesis = session.hypothesis(group);
            let is_rough = hypothesis == Hypothesis::DiffuseSpecular
                && evidence.as_ref().is_some_and(|evidence| is_rough(evidence, material));
            views.push(GroupView { group, pixels, rerendered, error, is_rough, evidence });
        }
        views
    }

    /// Pixels of a group without a specular part, re-rendered twice.
    fn rerender_sample(
        &self,
        session: &Session<'_, '_, '_>,
        group: usize,
    ) -> (Vec<u32>, [Vec<Rgb>; 2]) {
        let valid = session.pixels(group);
        let whole = session.hypothesis(group) == Hypothesis::Textured;
        let count = if whole { usize::MAX } else { ITERATION_PIXELS };
        let pixels = spread(valid, count, self.options.seed);
        let halves = [0u64, 1].map(|half| {
            let seed = self.options.seed.wrapping_mul(2).wrapping_add(half);
            self.rerender(session, &pixels, seed)
        });
        (pixels, halves)
    }

    /// Whether all rungs have had their iterations, and no reflectance moved in the last one.
    fn are_at_rest(
        &self,
        session: &Session<'_, '_, '_>,
        views: &[GroupView],
        rungs: &[Standing],
    ) -> bool {
        views.iter().map(|view| view.group).all(|group| {
            let (rung, hypothesis) = (rungs[group], session.hypothesis(group));
            rung.has_had_its_iterations(hypothesis) && rung.change < AT_REST
        })
    }

    /// The groups that leave their rungs: those in error above its threshold, and among the worst, once the rung has
    /// had its iterations. Smooth rungs do not wait for others; the error of any other rung says little while the
    /// reflectances of other groups move, and that of a diffuse group little while a shiny one climbs.
    fn leaving(
        &self,
        session: &Session<'_, '_, '_>,
        views: &[GroupView],
        rungs: &[Standing],
    ) -> Vec<usize> {
        let hypothesis = |group: usize| session.hypothesis(group);
        let in_error = self.in_error(session, views);
        let errors = views.iter().filter(|view| in_error.contains(&view.group));
        let worst = errors.clone().map(|v| v.error.total()).fold(0.0, f64::max);
        let since_last = views.iter().map(|v| rungs[v.group].iterations).min().unwrap_or(0);
        let others_rest = |group: usize| {
            let mut others = views.iter().map(|v| v.group).filter(|other| *other != group);
            since_last >= ITERATIONS_MAX || others.all(|other| rungs[other].change < AT_REST)
        };
        let is_ready = |group: usize| {
            let is_smooth = SMOOTH.contains(&hypothesis(group));
            rungs[group].has_had_its_iterations(hypothesis(group))
                && (is_smooth || others_rest(group))
        };
        let among_worst = errors.filter(|v| v.error.total() >= WORST * worst);
        let mut leaving: Vec<usize> =
            among_worst.map(|v| v.group).filter(|group| is_ready(*group)).collect();
        let is_shiny = |group: &usize| hypothesis(*group) != Hypothesis::Diffuse;
        if leaving.iter().any(is_shiny) {
            leaving.retain(is_shiny);
        }
        leaving
    }

    /// The groups in error above the threshold of their rungs, and those that are taken for smooth and are not.
    fn in_error(&self, session: &Session<'_, '_, '_>, views: &[GroupView]) -> Vec<usize> {
        let hypothesis = |v: &GroupView| session.hypothesis(v.group);
        let in_error = |v: &&GroupView| {
            let threshold = || self.paper.thresholds[hypothesis(v) as usize];
            hypothesis(v) != Hypothesis::Textured && (v.is_rough || v.error.total() > threshold())
        };
        views.iter().filter(in_error).map(|v| v.group).collect()
    }

    /// Corrects a group under its hypothesis, or under the next one if it `leaves` its rung.
    fn correct(
        &self,
        session: &mut Session<'_, '_, '_>,
        seen: &GroupView,
        leaves: bool,
        rung: &mut Standing,
    ) -> Material {
        let GroupView { group, error, .. } = seen;
        let hypothesis = session.hypothesis(*group);
        if leaves || (rung.iterations == 1 && session.is_new_to(*group, hypothesis)) {
            session.log(*group, self.iteration, *error, !leaves);
        }
        let next = if leaves { next_rung(hypothesis) } else { hypothesis };
        let parameters = || self.parameters(session, next, seen);
        let material = session.value("paper's parameters", parameters);
        // A group without texture coordinates stays where it is.
        rung.iterations = if leaves && material.is_some() { 0 } else { rung.iterations + 1 };
        session.set_hypothesis(*group, if material.is_some() { next } else { hypothesis });
        material.unwrap_or_else(|| session.materials()[*group].clone())
    }

    fn rerender(&self, session: &Session<'_, '_, '_>, pixels: &[u32], seed: u64) -> Vec<Rgb> {
        let settings = sample_budget::paths(SPP, seed, self.options);
        session.problem().renderer.rerender(session.appearance(), pixels, &settings)
    }

    /// The group's parameters on `rung`, from its present re-rendering.
    fn parameters(
        &self,
        session: &Session<'_, '_, '_>,
        rung: Hypothesis,
        seen: &GroupView,
    ) -> Option<Material> {
        let GroupView { group, pixels, rerendered, .. } = seen;
        let now = &session.materials()[*group];
        let stays = rung == session.hypothesis(*group);
        let ratio = || self.ratio(session, pixels, rerendered);
        let evidence = || seen.evidence.clone().unwrap_or_else(|| self.gather(session, *group));
        let lobes = || Lobes::new(evidence());
        Some(match rung {
            Hypothesis::Diffuse => {
                Material::diffuse((now.rho_d * ratio()).clamp(Rgb::ZERO, Rgb::ONE))
            }
            Hypothesis::Mirror => Material::mirror(Rgb::ONE),
            Hypothesis::PartialMirror if stays => {
                Material::mirror((now.rho_s * ratio()).clamp(Rgb::ZERO, Rgb::ONE))
            }
            Hypothesis::PartialMirror => Material::mirror(ratio().clamp(Rgb::ZERO, Rgb::ONE)),
            Hypothesis::Isotropic => lobes().isotropic(now).material,
            Hypothesis::Anisotropic => self.brushed(session, now, stays, evidence()),
            Hypothesis::Textured => {
                let before = if stays { now.texture.as_deref() } else { None };
                let ones = vec![Rgb::ONE; pixels.len()];
                let shown = if stays { rerendered } else { &ones };
                let found = texture::rebalance(&session.stage(), before, pixels, shown)?;
                let rho_d = unrender_recover::texture::mean(&found);
                Material { texture: Some(found.texture), ..Material::diffuse(rho_d) }
            }
            // The diffuse-specular rung has nothing to search for.
            _ => hypothesis::fit(rung, &evidence(), now, Search::Local).material,
        })
    }

    /// Section 4.2.5, with the direction found as the settings say.
    fn brushed(
        &self,
        session: &Session<'_, '_, '_>,
        now: &Material,
        stays: bool,
        evidence: Evidence,
    ) -> Material {
        if self.paper.direction == Direction::Rerender {
            return Lobes::new(evidence).anisotropic(now).material;
        }
        let read = || brushed::direction(&evidence, session.problem().renderer.geometry());
        let theta_rad = if stays { now.theta_rad } else { read().unwrap_or(0.0) };
        Lobes::new(evidence).along(&Material { theta_rad, ..now.clone() }).material
    }

    /// Eqs. 1 to 3: the mean over the group's objects of mean photograph over mean re-rendering,
    /// weighted by pixels; objects far from the median do not count.
    fn ratio(&self, session: &Session<'_, '_, '_>, pixels: &[u32], rerendered: &[Rgb]) -> Rgb {
        let stage = session.stage();
        let geometry = stage.renderer.geometry();
        let mut objects: std::collections::BTreeMap<u32, (Rgb, Rgb, f32)> = Default::default();
        for (&pixel, &radiance) in pixels.iter().zip(rerendered) {
            let entry = objects.entry(geometry.pixels()[pixel as usize].object).or_default();
            entry.0 += stage.exposure * stage.value(pixel);
            entry.1 += radiance;
            entry.2 += 1.0;
        }
        Rgb::from_array(std::array::from_fn(|c| {
            let ratios: Vec<(f32, f32)> = objects
                .values()
                .filter(|(_, synthetic, _)| synthetic[c] > 0.0)
                .map(|(photo, synthetic, pixels)| (photo[c] / synthetic[c], *pixels))
                .collect();
            mean_near_median(ratios, self.options.thresholds.dispersion as f32)
        }))
    }

    /// The light that arrives at a sample of the group's pixels, for any material on it.
    fn gather(&self, session: &Session<'_, '_, '_>, group: usize) -> Evidence {
        let probe = ProbeSettings {
            probes_per_pixel: POINTS,
            cosine: COSINE,
            per_lobe: PER_LOBE,
            lobes: proposals(&session.materials()[group]),
            mirror: 1,
            keep_incident: true,
            seed: self.options.seed,
            max_bounces: self.options.max_bounces,
            ..ProbeSettings::default()
        };
        let pixels = session.pixels(group);
        let allowance = sample_budget::allowance(sample_budget::Level::Refined, self.options);
        let budget =
            SampleBudget { pixels: ITERATION_PIXELS, pixels_seed: probe.seed, allowance, probe };
        Evidence::gather(&session.stage(), session.appearance(), group, pixels, &budget)
            .expecting(session.problem().groups[group].expected)
    }
}

/// Whether a lobe leaves at most half of the squared error that the smooth `material` leaves, and significantly less: a
/// surface that mirrors blurred may be within its rung's threshold, and still be no mirror.
fn is_rough(evidence: &Evidence, material: &Material) -> bool {
    let mut lobes = Lobes::new(evidence.clone());
    let lobe = lobes.isotropic(material).material;
    let [smooth, rough] = [material, &lobe].map(|material| lobes.squares(material));
    let gained: Vec<f64> = smooth.iter().zip(&rough).map(|(a, b)| a - b).collect();
    let [left, gain] = [&rough, &gained].map(|terms| terms.iter().sum::<f64>());
    gain > left && gain > WORSE * deviation_of_sum(&gained)
}

/// How far two materials are apart: the largest difference of a reflectance, or of the logarithm
/// of a roughness.
fn distance(a: &Material, b: &Material) -> f64 {
    let rho = (a.rho_d - b.rho_d).abs().max((a.rho_s - b.rho_s).abs()).max_element();
    let log = |x: f32, y: f32| if x > 0.0 && y > 0.0 { (x / y).ln().abs() } else { 0.0 };
    let visible = a.rho_s.max(b.rho_s).max_element().min(1.0);
    let alpha = log(a.alpha_x, b.alpha_x).max(log(a.alpha_y, b.alpha_y)) * visible;
    f64::from(rho.max(0.1 * alpha))
}

/// Lobes to draw directions from: about the material's own, or of every roughness where it has none.
fn proposals(material: &Material) -> Vec<ProposalLobe> {
    let Material { alpha_x, alpha_y, theta_rad, .. } = *material;
    if !material.is_glossy() {
        return ProposalLobe::round(&ANY_ALPHA);
    }
    let wider = |by: f32| ProposalLobe {
        alpha_x: (by * alpha_x).min(1.0),
        alpha_y: (by * alpha_y).min(1.0),
        theta_rad,
    };
    WIDER.map(wider).to_vec()
}

fn next_rung(hypothesis: Hypothesis) -> Hypothesis {
    let up = hypothesis::UNIFORM.iter().position(|h| *h == hypothesis).map(|i| i + 1);
    up.and_then(|i| hypothesis::UNIFORM.get(i).copied()).unwrap_or(Hypothesis::Textured)
}

/// Eq. 3 for one channel: `sum f m eps / sum f m`, with f = 0 for ratios further than
/// `dispersion` from the median, relatively.
fn mean_near_median(mut ratios: Vec<(f32, f32)>, dispersion: f32) -> f32 {
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(median) = ratios.get(ratios.len() / 2).map(|r| r.0) else { return 1.0 };
    let near = ratios.iter().filter(|r| (r.0 - median).abs() <= dispersion * median);
    let (sum, count) = near.fold((0.0, 0.0), |(s, n), (ratio, m)| (s + ratio * m, n + m));
    if count > 0.0 { sum / count } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_far_from_their_group_do_not_count() {
        let ratios = vec![(1.0, 100.0), (1.2, 100.0), (9.0, 5.0)];
        assert!((mean_near_median(ratios, 0.5) - 1.1).abs() < 1e-6);
        assert_eq!(mean_near_median(Vec::new(), 0.5), 1.0);
    }

    #[test]
    fn the_rungs_follow_each_other_up_to_the_texture() {
        let mut rung = Hypothesis::Diffuse;
        for next in [1, 2, 3, 4, 5].map(|i| hypothesis::UNIFORM[i]) {
            rung = next_rung(rung);
            assert_eq!(rung, next);
        }
        assert_eq!(next_rung(rung), Hypothesis::Textured);
    }
}
