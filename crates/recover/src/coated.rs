//! The light of a gathering as the lobe of a dielectric reflects it, and as its base receives it.
//!
//! Fresnel's reflectance depends on the directions of a sample alone, not on the roughness, so that the lobe's sums are
//! those of a free lobe over samples that are weighted by it ([`LobeSums`]).

use unrender_render::{Incident, LobeSums, Probe, Probes};
use unrender_scene::reflectance::{IOR, f0_of_ior, fresnel};
use unrender_scene::{BrdfModel, Layering, LobeAlbedo};

/// Roughnesses at which it is known how much of the light enters a coupled base; between them it is interpolated, to 4 % for
/// light up to 80 degrees. With the middle one alone light at 80 degrees enters a smooth plastic 24 % too much; with one more it
/// is known to 3 %. The joint refinement has the exact one.
const ROUGHNESSES: [f32; 3] = [0.0, 0.25, 1.0];

/// What a gathering keeps for plastics.
#[derive(Clone, Debug)]
pub(crate) struct Coated {
    /// The incident samples, weighted by Fresnel's reflectance over that at normal incidence.
    pub(crate) lobes: LobeSums,
    /// For every probe the share of light that enters the base at each of [`ROUGHNESSES`], over the mean; one where bases are
    /// albedo-scaled.
    entering: Vec<[f32; 3]>,
}

impl Coated {
    /// Of `probes` in a scene of `model`; none if that knows no plastics.
    pub(crate) fn of(model: BrdfModel, probes: &Probes) -> Option<Self> {
        if !model.is_principled() || probes.incident.is_empty() {
            return None;
        }
        let mut weighted = probes.clone();
        for probe in &probes.probes {
            let range = probe.first as usize..(probe.first + probe.count) as usize;
            for Incident { wi, irradiance } in &mut weighted.incident[range] {
                *irradiance *= fresnel(0.5 * (probe.wo + *wi).length(), IOR) / f0_of_ior(IOR);
            }
        }
        let entering = probes.probes.iter().map(|probe| match model.layering() {
            Layering::AlbedoScaled => [1.0; 3],
            Layering::Coupled => entering(probes, probe),
        });
        Some(Self { entering: entering.collect(), lobes: LobeSums::new(model, &weighted) })
    }

    /// The factor of the base of the probe number `index` under a lobe of the roughness `alpha`, which has `taken` some of its
    /// light.
    pub(crate) fn base(&self, index: usize, probe: &Probe, alpha: f32, taken: &LobeAlbedo) -> f32 {
        (1.0 - taken.at(probe.wo.z)) * interpolated(self.entering[index], alpha)
    }

    /// Drops the probes that are not `kept`, in their order.
    pub(crate) fn retain(&mut self, kept: &[bool]) {
        let mut of_lobes = kept.iter();
        self.lobes.retain(|| of_lobes.next().copied().unwrap_or(true));
        let mut of_bases = kept.iter();
        self.entering.retain(|_| of_bases.next().copied().unwrap_or(true));
    }
}

/// The shares of the light of `probe` that enter its base, over the mean of even light.
fn entering(probes: &Probes, probe: &Probe) -> [f32; 3] {
    let taken = ROUGHNESSES.map(|alpha| LobeAlbedo::kept_out(IOR, alpha));
    let (mut all, mut through) = (0.0, [0.0; 3]);
    for Incident { wi, irradiance } in probes.incident_of(probe) {
        let light = irradiance.element_sum();
        all += light;
        through.iter_mut().zip(&taken).for_each(|(sum, of)| *sum += light * (1.0 - of.at(wi.z)));
    }
    let share = |k: usize| through[k] / (all * (1.0 - taken[k].mean().value));
    if all > 0.0 { [0, 1, 2].map(share) } else { [1.0; 3] }
}

/// The value at `alpha` of what has these at [`ROUGHNESSES`].
fn interpolated([smooth, middle, dull]: [f32; 3], alpha: f32) -> f32 {
    let between = |from: usize, low: f32, high: f32| {
        let [from, to] = [ROUGHNESSES[from], ROUGHNESSES[from + 1]];
        low + (high - low) * ((alpha - from) / (to - from)).clamp(0.0, 1.0)
    };
    if alpha < ROUGHNESSES[1] { between(0, smooth, middle) } else { between(1, middle, dull) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_enters_a_base_is_known_between_the_roughnesses() {
        let share = |alpha: f32, mu: f32| {
            let taken = LobeAlbedo::kept_out(IOR, alpha);
            (1.0 - taken.at(mu)) / (1.0 - taken.mean().value)
        };
        let mut worst = [0.0f32; 2];
        for degrees in [0.0f32, 30.0, 60.0, 70.0, 80.0] {
            let mu = degrees.to_radians().cos();
            let known = ROUGHNESSES.map(|alpha| share(alpha, mu));
            for alpha in [0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0] {
                let exact = share(alpha, mu);
                let errors =
                    [interpolated(known, alpha), known[1]].map(|found| found / exact - 1.0);
                worst = [0, 1].map(|k| worst[k].max(errors[k].abs()));
            }
        }
        let [found, middle] = worst;
        assert!(found < 0.045 && middle > 0.2, "{found} and, by the middle one alone, {middle}");
    }
}
