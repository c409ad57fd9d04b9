//! Reusable vertices: the second vertices of paths, with the light that they reflect.

use crate::bsdf::Specular;
use crate::guiding::VmfMixture;
use crate::path::{LocalBsdf, Start, Transport, VisibleLight};
use crate::sampler::Sampler;
use crate::surface::Surface;
use glam::Vec3;
use unrender_scene::Rgb;

/// Paths that continue from a diffuse reusable vertex, with one pool of lights and with several;
/// with several the choice of the light dominates the variance, and light samples at the receiver
/// are more useful. A path costs as much as thirty connections.
const PATHS: [u32; 2] = [2, 1];

/// The second vertex of a path.
pub(super) struct ReusableVertex {
    surface: Surface,
    /// Its point, off the surface, where connections end.
    pub(super) point: Vec3,
    pub(super) reflection: Reflection,
}

/// The light that a reusable vertex reflects.
#[expect(clippy::large_enum_variant, reason = "boxing would allocate per path")]
pub(super) enum Reflection {
    /// The same radiance in all directions.
    Diffuse(Rgb),
    /// By a glossy BRDF.
    Glossy(GlossyReflection),
}

/// A glossy BRDF, and the light that arrives there: from a light sample, and along one direction by
/// emission and by reflection.
pub(super) struct GlossyReflection {
    local: LocalBsdf,
    guide: VmfMixture,
    pub(super) incident: [Option<IncidentLight>; 3],
}

/// Light that arrives at a glossy reusable vertex.
#[derive(Clone, Copy)]
pub(super) struct IncidentLight {
    /// Unit vector towards its origin, in the frame of the BRDF.
    wi: Vec3,
    /// Its radiance; of a punctual light irradiance over probability.
    pub(super) radiance: Rgb,
    /// The density over solid angle with which light samples find it; one for a punctual light,
    /// zero for reflected light.
    light_pdf: f32,
    /// Whether directions drawn from the BRDF find it, too.
    by_bsdf: bool,
}

impl ReusableVertex {
    /// The vertex at `surface`, found from the direction `wo` (world space); none if it reflects
    /// nothing. The surface has no mirror term; its bounce is the number one.
    pub(super) fn new(
        transport: &Transport<'_>,
        surface: Surface,
        wo: Vec3,
        sampler: &mut Sampler,
    ) -> Option<Self> {
        let local = transport.bsdf(&surface);
        let point = surface.start();
        if local.bsdf.is_black() {
            return None;
        }
        let reflection = if local.bsdf.specular == Specular::None {
            let paths = PATHS[usize::from(transport.has_several_lights())];
            let each = (0..paths)
                .map(|_| transport.reflected(surface, wo, sampler, Start::after(1), None));
            let radiance = each.sum::<Rgb>() / paths as f32;
            (radiance != Rgb::ZERO).then_some(Reflection::Diffuse(radiance))
        } else {
            let guide = transport.guide(&local, &surface, 1);
            let mut glossy = GlossyReflection { local, guide, incident: [None; 3] };
            glossy.gather(transport, &surface, wo, sampler);
            glossy.incident.iter().any(Option::is_some).then_some(Reflection::Glossy(glossy))
        };
        Some(Self { surface, point, reflection: reflection? })
    }

    /// A unit vector.
    pub(super) fn geometric_normal(&self) -> Vec3 {
        self.surface.geometric_normal
    }
}

impl GlossyReflection {
    /// Takes one light sample and traces one direction.
    fn gather(
        &mut self,
        transport: &Transport<'_>,
        surface: &Surface,
        wo: Vec3,
        sampler: &mut Sampler,
    ) {
        if !transport.reflects(1) {
            return;
        }
        let [pick, u, v, _] = sampler.next4();
        if let Some(light) = transport.visible_light(surface, [pick, u, v]) {
            let VisibleLight { wi, weight, pdf, .. } = light;
            self.incident[0] = Some(IncidentLight {
                wi: self.local.frame.local_from_world(wi),
                radiance: weight * pdf.unwrap_or(1.0),
                light_pdf: pdf.unwrap_or(1.0),
                by_bsdf: pdf.is_some(),
            });
        }
        let [lobe, u, v, _] = sampler.next4();
        let bsdf = self.local.bsdf.guided_by(&self.guide);
        let Some(sample) = bsdf.sample(self.local.frame.local_from_viewer(wo), [lobe, u, v]) else {
            return;
        };
        let wi = self.local.frame.world_from_local(sample.wi);
        if !surface.is_above(wi) {
            return;
        }
        let hit = transport.hit(surface, wi, sampler);
        let incident = |radiance: Rgb, light_pdf: f32| {
            let light = IncidentLight { wi: sample.wi, radiance, light_pdf, by_bsdf: true };
            (radiance != Rgb::ZERO).then_some(light)
        };
        self.incident[1] =
            incident(transport.scaled(&hit.emission), transport.light_pdf(surface, &hit));
        if let Some(next) = hit.surface {
            self.incident[2] =
                incident(transport.reflected(next, -wi, sampler, Start::after(2), None), 0.0);
        }
    }

    /// The direction towards a receiver that connects along `wi` (world space).
    pub(super) fn towards(&self, wi: Vec3) -> Vec3 {
        self.local.frame.local_from_viewer(-wi)
    }

    /// The BRDF from `incident` towards `wo` times the cosine of the incident direction, and the
    /// density with which a path from `wo` finds that light.
    pub(super) fn f_cos_and_pdf(&self, incident: &IncidentLight, wo: Vec3) -> (Rgb, f32) {
        let bsdf = self.local.bsdf.guided_by(&self.guide);
        let (f, pdf) = bsdf.value_and_pdf(wo, incident.wi);
        let by_bsdf = if incident.by_bsdf { pdf } else { 0.0 };
        (f * incident.wi.z, incident.light_pdf + by_bsdf)
    }
}
