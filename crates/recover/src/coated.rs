//! The light of a gathering as the lobe of a dielectric reflects it, and as its base receives it.
//!
//! Fresnel's reflectance depends on the directions of a sample alone, not on the roughness, so that the lobe's sums are
//! those of a free lobe over samples that are weighted by it ([`LobeSums`]).

use unrender_render::{Incident, LobeSums, Probe, Probes};
use unrender_scene::reflectance::{IOR, f0_of_ior, fresnel};
use unrender_scene::{BrdfModel, Layering, LobeAlbedo};

/// The roughness whose albedo stands for all in the light that enters a coupled base: that albedo changes by 0.02 between
/// smooth and rough lobes. The joint refinement has the exact one.
const ENTERING_ALPHA: f32 = 0.2;

/// What a gathering keeps for plastics.
#[derive(Clone, Debug)]
pub(crate) struct Coated {
    /// The incident samples, weighted by Fresnel's reflectance over that at normal incidence.
    pub(crate) lobes: LobeSums,
    /// For every probe the share of light that enters the base, over the mean `1 - Eavg`; one where bases are
    /// albedo-scaled.
    entering: Vec<f32>,
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
            Layering::AlbedoScaled => 1.0,
            Layering::Coupled => entering(probes, probe),
        });
        Some(Self { entering: entering.collect(), lobes: LobeSums::new(model, &weighted) })
    }

    /// The factor of the base of the probe number `index`, of the lobe's `albedo`.
    pub(crate) fn base(&self, index: usize, probe: &Probe, albedo: &LobeAlbedo) -> f32 {
        (1.0 - albedo.at(probe.wo.z)) * self.entering[index]
    }

    /// Drops the probes that are not `kept`, in their order.
    pub(crate) fn retain(&mut self, kept: &[bool]) {
        let mut of_lobes = kept.iter();
        self.lobes.retain(|| of_lobes.next().copied().unwrap_or(true));
        let mut of_bases = kept.iter();
        self.entering.retain(|_| of_bases.next().copied().unwrap_or(true));
    }
}

/// The share of the light of `probe` that enters its base, over the mean of even light.
fn entering(probes: &Probes, probe: &Probe) -> f32 {
    let albedo = LobeAlbedo::dielectric(IOR, ENTERING_ALPHA);
    let (mut all, mut through) = (0.0, 0.0);
    for Incident { wi, irradiance } in probes.incident_of(probe) {
        let light = irradiance.element_sum();
        all += light;
        through += light * (1.0 - albedo.at(wi.z));
    }
    if all > 0.0 { through / (all * (1.0 - albedo.mean().value)) } else { 1.0 }
}
