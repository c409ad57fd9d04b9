//! Hypotheses of one group, each fitted on paths that carry it, and their residuals on other paths.

use super::descent::{Descent, Evaluated};
use super::kept::{KeptPaths, is_near};
use super::means;
use super::unknowns::Unknowns;
use crate::compare::residual::BlockResiduals;
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::observe::model_error::{Allowance, ModelError};
use crate::observe::sample::Sample;
use crate::sample_budget::TOGETHER;
use crate::streams::Stream;
use unrender_render::{Parameter, Query, Settings, Stored};
use unrender_scene::{Material, Rgb};

/// Paths a pixel, at least and at most: pixels are as many as that allows. Fewer are not stratified among themselves;
/// half and double of the most were not tried.
const SPP: [u32; 2] = [TOGETHER, 1024];
/// Pixels that are looked at, at most: all those of a room's wall at 240 x 180. Half and double of it were not tried.
const PIXELS: usize = 16_000;
/// Steps of a fit at most: it begins where a search ended. Half and double of it were not tried.
const STEPS_MAX: usize = 8;
/// A fit goes on while one of its numbers moves by this many of its standard deviations: within that the squared
/// residual is hardly above its least. Half and double of it were not tried.
const SIGNIFICANT: f64 = 0.3;
/// How often paths are traced for one rung: again where its lobe has left the range that they carry. The joint
/// refinement has the same number; half and double of it were not tried.
const TRACED_MAX: usize = 3;

/// A hypothesis with its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Rung {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) material: Material,
}

/// A rung that was fitted, and what it leaves of the photograph.
pub(super) struct Contender {
    /// Its numbers after the fit.
    pub(super) rung: Rung,
    /// The number of the paths that it was fitted on.
    pub(super) drawn: usize,
    /// Two renderings of the pixels by each of the paths that carry it, until its residuals are known.
    pub(super) radiance: Vec<Option<[Vec<Rgb>; 2]>>,
    /// The residuals of the blocks on each of these.
    pub(super) residuals: Vec<Option<BlockResiduals>>,
    /// The weighted squared error that the noise of the paths that it was fitted on adds.
    pub(super) loss: f64,
}

/// The density that paths are drawn from which carry some of the rungs.
struct ProposalDensity {
    /// The material whose lobes it has.
    material: Material,
    /// The parameters by which derivatives are wanted on them.
    asked: Vec<Parameter>,
}

/// Paths that some of the rungs are fitted on.
struct DrawnPaths<'a> {
    density: ProposalDensity,
    fitting: KeptPaths<'a>,
}

impl Rung {
    /// `guess` with this as `group`.
    fn on<'a>(&self, guess: &Guess<'a>, group: usize) -> Guess<'a> {
        let mut guess = guess.clone();
        guess.groups[group].hypothesis = self.hypothesis;
        guess.materials[group] = self.material.clone();
        guess
    }
}

/// Some of the pixels of `group`, where the light of the others may be wrong by what `allowance` says.
fn sample_of(guess: &Guess<'_>, group: usize, allowance: Allowance, settings: &Settings) -> Sample {
    let valid = &guess.observation.informative_of_group[group];
    let photographs = guess.observation.sheet.of_all(1);
    let count = ((settings.spp / SPP[0]) as usize / photographs).min(PIXELS);
    let (pixels, grid) = Sample::choose(&guess.observation, group, valid, count, settings.seed);
    Sample::of(&guess.stage(), group, (&pixels, &grid), allowance.light)
}

/// Weights the residuals of `sample` by the light of the first of `contenders`.
fn reweigh(sample: &mut Sample, contenders: &[Contender]) {
    let own = |contender: &Contender| contender.radiance.get(contender.drawn)?.clone();
    let Some([a, b]) = contenders.first().and_then(own) else { return };
    let light: Vec<Rgb> = a.iter().zip(&b).map(|(a, b)| 0.5 * (*a + *b)).collect();
    sample.reweigh(&light, ModelError::START);
}

/// `settings`, which has all paths of a rendering, with those of one of so many pixels.
fn of_one_pixel(settings: Settings, pixels: usize) -> Settings {
    let [least, most] = SPP;
    let spp = (settings.spp / pixels.max(1) as u32).clamp(least, most);
    Settings { spp: spp.next_multiple_of(TOGETHER), ..settings }
}

/// Fits `rungs` of `group`, which go from simple to complex, and returns what each leaves; `settings` has all paths of
/// a rendering together.
pub(super) fn fit_and_render(
    guess: &Guess<'_>,
    group: usize,
    rungs: Vec<Rung>,
    allowance: Allowance,
    settings: Settings,
) -> (Vec<Contender>, Sample) {
    let mut sample = sample_of(guess, group, allowance, &settings);
    let settings = of_one_pixel(settings, sample.pixels.len());
    let (mut contenders, drawn) = fit_all(guess, group, rungs, (&sample, &settings));
    // The paths of the fits are no longer needed, and take as much memory as the next.
    let densities: Vec<ProposalDensity> = drawn.into_iter().map(|drawn| drawn.density).collect();
    for (place, density) in densities.iter().enumerate() {
        render_all(guess, group, &mut contenders, (place, density), (&sample, &settings));
    }
    reweigh(&mut sample, &contenders);
    for contender in &mut contenders {
        let all = std::mem::take(&mut contender.radiance).into_iter();
        contender.residuals =
            all.map(|model| model.map(|model| BlockResiduals::over(&sample, &model))).collect();
    }
    contenders.reverse();
    (contenders, sample)
}

/// Fits all `rungs` of `group`, the last one first, on paths that carry them, and returns the fitted ones.
fn fit_all<'a>(
    guess: &Guess<'a>,
    group: usize,
    rungs: Vec<Rung>,
    by: (&Sample, &Settings),
) -> (Vec<Contender>, Vec<DrawnPaths<'a>>) {
    let mut drawn: Vec<DrawnPaths<'a>> = Vec::new();
    let mut contenders: Vec<Contender> = Vec::new();
    for Rung { hypothesis, material } in rungs.into_iter().rev() {
        let mut rung = Rung { hypothesis, material };
        let mut loss = 0.0;
        let mut place = carrier(&mut drawn, guess, (group, &rung), by);
        for _ in 0..TRACED_MAX {
            (rung.material, loss) = fit(rung.on(guess, group), group, &drawn[place].fitting);
            let next = carrier(&mut drawn, guess, (group, &rung), by);
            if next == place {
                break;
            }
            place = next;
        }
        let (radiance, residuals) = (Vec::new(), Vec::new());
        contenders.push(Contender { rung, drawn: place, radiance, residuals, loss });
    }
    (contenders, drawn)
}

/// Renders the pixels of `sample` with each of the `contenders` that paths of the `density` number `place` carry, on
/// new paths that no fit has used.
fn render_all(
    guess: &Guess<'_>,
    group: usize,
    contenders: &mut [Contender],
    (place, density): (usize, &ProposalDensity),
    (sample, settings): (&Sample, &Settings),
) {
    let drawn = density.on(guess, group);
    let settings = Settings { seed: Stream::Judging.seed(settings.seed), ..*settings };
    let (pixels, seen) = (sample.numbers(), guess.seen.as_deref());
    let stored = means::halves(&settings).map(|settings| {
        let query = Query::new(drawn.appearance(), &pixels, &settings);
        guess.problem.renderer.store(&Query { parameters: &density.asked, seen, ..query })
    });
    for contender in contenders {
        let shown = contender.rung.on(guess, group);
        let radiance = |half: &dyn Stored| half.replay(shown.appearance(), &[], seen).radiance;
        let is_carried =
            place == contender.drawn || carries(&density.material, &contender.rung.material);
        let both = || stored.each_ref().map(|half| radiance(half.as_ref()));
        contender.radiance.push(is_carried.then(both));
    }
}

/// The number of the `drawn` paths that carry `rung` of `group`; of new ones if none of these do.
fn carrier<'a>(
    drawn: &mut Vec<DrawnPaths<'a>>,
    guess: &Guess<'a>,
    (group, rung): (usize, &Rung),
    by: (&Sample, &Settings),
) -> usize {
    let carried = drawn.iter().position(|drawn| carries(&drawn.density.material, &rung.material));
    carried.unwrap_or_else(|| {
        drawn.push(DrawnPaths::of(rung.on(guess, group), group, by));
        drawn.len() - 1
    })
}

impl<'a> DrawnPaths<'a> {
    /// Paths that carry the rung of `group` in `guess`, and simpler ones.
    fn of(guess: Guess<'a>, group: usize, (sample, settings): (&Sample, &Settings)) -> Self {
        let asked = Unknowns::of_group(&guess, group).parameters;
        let density = ProposalDensity { material: guess.materials[group].clone(), asked };
        let drawn = density.on(&guess, group);
        let cells = super::sample::of_group(&drawn, group, sample.pixels.len(), settings.seed);
        let fitting = KeptPaths::of_cells(&drawn, cells, &density.asked, settings);
        Self { density, fitting }
    }
}

impl ProposalDensity {
    /// `guess` with the material of `group` that such paths are drawn from: with a specular part, half are drawn by a
    /// cosine.
    fn on<'a>(&self, guess: &Guess<'a>, group: usize) -> Guess<'a> {
        let half = Rgb::splat(0.5);
        let mut guess = guess.clone();
        guess.materials[group] = if self.material.rho_s == Rgb::ZERO {
            self.material.clone()
        } else {
            Material { rho_d: half, rho_s: half, ..self.material.clone() }
        };
        guess
    }
}

/// The material of `group` where it explains that best on `paths`, and the mean squared error that the noise of these
/// adds, at most one a number.
fn fit<'a>(guess: Guess<'a>, group: usize, paths: &KeptPaths<'a>) -> (Material, f64) {
    let unknowns = Unknowns::of_group(&guess, group);
    if unknowns.len() == 0 {
        return (guess.materials[group].clone(), 0.0);
    }
    let prior = unknowns.prior_mean(&guess);
    let descent = Descent {
        unknowns: &unknowns,
        prior: &prior,
        steps_max: STEPS_MAX,
        significant: SIGNIFICANT,
        worse: 0.0,
    };
    let show = |guess: &Guess<'a>| paths.means(guess, &unknowns);
    let (guess, shown) = descent.run(guess, &show, &mut |_, _| true);
    let all = unknowns.len() as f64;
    let lost =
        |shown: Evaluated| (shown.inverse * shown.normal.g_rendering).trace().clamp(0.0, all);
    (guess.materials[group].clone(), shown.map_or(all, lost))
}

/// Whether paths that were drawn for `drawn` carry `material`: only paths of mirrors carry a
/// mirror.
fn carries(drawn: &Material, material: &Material) -> bool {
    let is_matt = material.rho_s == Rgb::ZERO;
    let are_mirrors = drawn.is_delta() && material.is_delta();
    let are_lobes = drawn.is_glossy() && material.is_glossy() && is_near(material, drawn);
    is_matt || are_mirrors || are_lobes
}
