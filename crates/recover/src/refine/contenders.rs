//! Hypotheses of one group, each fitted on paths that carry it, and their residuals on other paths.

use super::descent::Descent;
use super::kept::{KeptPaths, is_near};
use super::means;
use super::unknowns::Unknowns;
use crate::block_residuals::BlockResiduals;
use crate::blocks::{Blocks, Grid};
use crate::evidence::{Observed, observe, reweigh};
use crate::hypothesis::Hypothesis;
use crate::model_error::{Allowance, LightError, LightField, ModelError};
use crate::observation::Reading;
use crate::rerender::Stored;
use crate::same_place;
use crate::sample_budget::TOGETHER;
use crate::state::State;
use glam::BVec3;
use unrender_render::sampler::mix;
use unrender_render::{Parameter, RadianceCache, Settings};
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
/// Changes the seed: the paths of the comparison differ from those of the fits.
const JUDGING: u64 = 0x7D6E;

/// A hypothesis with its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Rung {
    pub(crate) hypothesis: Hypothesis,
    pub(crate) material: Material,
}

/// The pixels of a group by which its rungs are compared.
pub(super) struct PixelSample {
    pub(super) blocks: Blocks,
    /// How the light of the others may be wrong.
    pub(super) field: LightField,
    pixels: Vec<Observed>,
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
    /// Where they end.
    seen: Option<RadianceCache>,
}

/// Paths that some of the rungs are fitted on.
struct DrawnPaths<'a> {
    density: ProposalDensity,
    fitting: KeptPaths<'a>,
}

impl Rung {
    /// Gives it to `group`.
    pub(super) fn put(&self, state: &mut State<'_>, group: usize) {
        state.groups[group].hypothesis = self.hypothesis;
        state.materials[group] = self.material.clone();
    }
}

impl PixelSample {
    /// Some of the pixels of `group`, where the light of the others may be wrong by what `allowance` says and at most by
    /// `most`.
    fn of(
        state: &State<'_>,
        group: usize,
        (allowance, most): (Allowance, LightError),
        settings: &Settings,
    ) -> Self {
        let valid = &state.observation.informative_of_group[group];
        let pixels_max = state.observation.sheet.of_all(PIXELS);
        let count = ((settings.spp / SPP[0]) as usize).min(pixels_max);
        let grid = Grid::of(&state.observation, group, valid, count);
        let pixels = grid.sample(valid, count, settings.seed ^ group as u64);
        let renderer = state.problem.renderer;
        let blocks = same_place::paired(Blocks::of(&pixels, &grid), renderer, &pixels);
        let geometry = (&state.observation.sheet, renderer.geometry());
        let field = LightField::of(&blocks, &pixels, geometry, allowance.light);
        let pixels = observe(&state.observation, state.exposure, group, &pixels);
        Self { blocks, field: LightField { most, ..field }, pixels }
    }

    #[cfg(test)]
    pub(super) fn new(blocks: Blocks, field: LightField) -> Self {
        Self { blocks, field, pixels: Vec::new() }
    }

    /// The numbers of its pixels.
    fn pixels(&self) -> Vec<u32> {
        self.pixels.iter().map(|seen| seen.pixel).collect()
    }

    /// Takes noise and levels at the brightness of the most complex of the `contenders`, which is the first.
    fn reweigh(&mut self, contenders: &[Contender]) {
        let own = |contender: &'_ Contender| contender.radiance.get(contender.drawn)?.clone();
        let Some([a, b]) = contenders.first().and_then(own) else { return };
        let light: Vec<Rgb> = a.iter().zip(&b).map(|(a, b)| 0.5 * (*a + *b)).collect();
        reweigh(&mut self.pixels, &self.blocks, &light, ModelError::START);
    }

    /// The residuals of the blocks where the two renderings of its pixels are `model`. A clipped pixel has none where
    /// the model is brighter.
    fn residuals(&self, mut model: [Vec<Rgb>; 2]) -> BlockResiduals {
        for (i, seen) in self.pixels.iter().enumerate() {
            let mean = 0.5 * (model[0][i] + model[1][i]);
            let is_met = mean.cmpge(seen.radiance) & BVec3::splat(seen.reading == Reading::AtLeast);
            for half in &mut model {
                half[i] = Rgb::select(is_met, seen.radiance, half[i]);
            }
        }
        BlockResiduals::over(&self.blocks, &self.pixels, &model)
    }

    /// `settings`, which has all paths of a rendering, with the paths of one pixel.
    fn settings(&self, settings: Settings) -> Settings {
        let [least, most] = SPP;
        let spp = (settings.spp / self.pixels.len().max(1) as u32).clamp(least, most);
        Settings { spp: spp.next_multiple_of(TOGETHER), ..settings }
    }
}

/// Fits `rungs` of `group`, which go from simple to complex, and returns what each leaves; `settings` has all paths of
/// a rendering together. The group is one of them afterwards.
pub(super) fn fit_and_render<'a>(
    state: &mut State<'a>,
    group: usize,
    rungs: Vec<Rung>,
    allowed: (Allowance, LightError),
    settings: Settings,
) -> (Vec<Contender>, PixelSample) {
    let mut sample = PixelSample::of(state, group, allowed, &settings);
    let settings = sample.settings(settings);
    let (mut contenders, drawn) = fit_all(state, group, rungs, (&sample, &settings));
    // The paths of the fits are no longer needed, and take as much memory as the next.
    let densities: Vec<ProposalDensity> = drawn.into_iter().map(|drawn| drawn.density).collect();
    for (place, density) in densities.iter().enumerate() {
        render_all(state, group, &mut contenders, (place, density), (&sample, &settings));
    }
    sample.reweigh(&contenders);
    for contender in &mut contenders {
        let all = std::mem::take(&mut contender.radiance).into_iter();
        contender.residuals = all.map(|model| model.map(|model| sample.residuals(model))).collect();
    }
    contenders.reverse();
    (contenders, sample)
}

/// Fits all `rungs` of `group`, the last one first, on paths that carry them, and returns the fitted ones.
fn fit_all<'a>(
    state: &mut State<'a>,
    group: usize,
    rungs: Vec<Rung>,
    by: (&PixelSample, &Settings),
) -> (Vec<Contender>, Vec<DrawnPaths<'a>>) {
    let mut drawn: Vec<DrawnPaths<'a>> = Vec::new();
    let mut contenders: Vec<Contender> = Vec::new();
    for mut rung in rungs.into_iter().rev() {
        rung.put(state, group);
        let mut loss = 0.0;
        let mut place = carrier(&mut drawn, state, group, by);
        for _ in 0..TRACED_MAX {
            loss = fit(state, group, &drawn[place].fitting);
            let next = carrier(&mut drawn, state, group, by);
            if next == place {
                break;
            }
            place = next;
        }
        rung.material = state.materials[group].clone();
        let (radiance, residuals) = (Vec::new(), Vec::new());
        contenders.push(Contender { rung, drawn: place, radiance, residuals, loss });
    }
    (contenders, drawn)
}

/// Renders the pixels of `sample` with each of the `contenders` that paths of the `density` number `place` carry, on
/// new paths that no fit has used.
fn render_all(
    state: &mut State<'_>,
    group: usize,
    contenders: &mut [Contender],
    (place, density): (usize, &ProposalDensity),
    (sample, settings): (&PixelSample, &Settings),
) {
    density.put(state, group);
    let settings = Settings { seed: mix(settings.seed ^ JUDGING), ..*settings };
    let (pixels, seen) = (sample.pixels(), density.seen.as_ref());
    let stored = means::halves(&settings).map(|settings| {
        state.problem.renderer.store(state.appearance(), &pixels, &density.asked, &settings, seen)
    });
    for contender in contenders {
        contender.rung.put(state, group);
        let radiance = |half: &dyn Stored| half.replay(state.appearance(), &[], seen).radiance;
        let is_carried =
            place == contender.drawn || carries(&density.material, &contender.rung.material);
        let both = || stored.each_ref().map(|half| radiance(half.as_ref()));
        contender.radiance.push(is_carried.then(both));
    }
}

/// The number of the `drawn` paths that carry the present rung of `group`; of new ones if none of these do.
fn carrier<'a>(
    drawn: &mut Vec<DrawnPaths<'a>>,
    state: &mut State<'a>,
    group: usize,
    by: (&PixelSample, &Settings),
) -> usize {
    let material = &state.materials[group];
    let carried = drawn.iter().position(|drawn| carries(&drawn.density.material, material));
    carried.unwrap_or_else(|| {
        drawn.push(DrawnPaths::of(state, group, by));
        drawn.len() - 1
    })
}

impl<'a> DrawnPaths<'a> {
    /// Paths that carry the present rung of `group`, and simpler ones.
    fn of(
        state: &mut State<'a>,
        group: usize,
        (sample, settings): (&PixelSample, &Settings),
    ) -> Self {
        let material = state.materials[group].clone();
        let asked = Unknowns::of_group(state, group).parameters;
        let density = ProposalDensity { material, asked, seen: state.seen.clone() };
        density.put(state, group);
        let cells = super::sample::of_group(state, group, sample.pixels.len(), settings.seed);
        let fitting = KeptPaths::of_cells(state, cells, &density.asked, settings);
        state.materials[group] = density.material.clone();
        Self { density, fitting }
    }
}

impl ProposalDensity {
    /// Gives `group` the material that such paths are drawn from: with a specular part, half are drawn by a cosine.
    fn put(&self, state: &mut State<'_>, group: usize) {
        let half = Rgb::splat(0.5);
        state.materials[group] = if self.material.rho_s == Rgb::ZERO {
            self.material.clone()
        } else {
            Material { rho_d: half, rho_s: half, ..self.material.clone() }
        };
    }
}

/// Moves the numbers of `group` to where they explain it best on `paths`, and returns the mean squared error that the
/// noise of these adds, at most one a number.
fn fit<'a>(state: &mut State<'a>, group: usize, paths: &KeptPaths<'a>) -> f64 {
    let unknowns = Unknowns::of_group(state, group);
    if unknowns.len() == 0 {
        return 0.0;
    }
    let prior = unknowns.prior_mean(state);
    let descent = Descent {
        unknowns: &unknowns,
        prior: &prior,
        steps_max: STEPS_MAX,
        significant: SIGNIFICANT,
        worse: 0.0,
    };
    let show = |state: &State<'a>| paths.means(state, &unknowns);
    let shown = descent.run(state, &show, &mut |_, _| true);
    let all = unknowns.len() as f64;
    shown.map_or(all, |shown| (shown.inverse * shown.normal.g_rendering).trace().clamp(0.0, all))
}

/// Whether paths that were drawn for `drawn` carry `material`: only paths of mirrors carry a
/// mirror.
fn carries(drawn: &Material, material: &Material) -> bool {
    let is_matt = material.rho_s == Rgb::ZERO;
    let are_mirrors = drawn.is_delta() && material.is_delta();
    let are_lobes = drawn.is_glossy() && material.is_glossy() && is_near(material, drawn);
    is_matt || are_mirrors || are_lobes
}
