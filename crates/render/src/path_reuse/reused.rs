//! A surface that a path finds from what the camera sees, and the light that arrives there.

use crate::accel;
use crate::bsdf::{Bsdf, Specular};
use crate::caustic::Images;
use crate::path::Transport;
use crate::sampler::Sampler;
use crate::surface::{Frame, Surface};
use glam::Vec3;
use unrender_scene::Rgb;

/// Paths that go on from a diffuse surface, where light comes from one place and where from several:
/// there the most noise is which light is seen. One costs as much as thirty pixels' view of it.
const PATHS: [u32; 2] = [2, 1];

/// A surface that a path found.
pub(super) struct Second {
    surface: Surface,
    /// Where rays meet it.
    pub(super) point: Vec3,
    pub(super) reflection: Reflection,
}

/// What it does with the light that arrives.
#[expect(clippy::large_enum_variant, reason = "a box for each would be an allocation a path")]
pub(super) enum Reflection {
    /// Reflects this radiance to all sides.
    Even(Rgb),
    /// Reflects it by a lobe.
    Lobe(Lobe),
}

/// A surface with a lobe, and the light that arrives there in up to three ways.
pub(super) struct Lobe {
    bsdf: Bsdf<'static>,
    images: Images,
    frame: Frame,
    pub(super) arrivals: [Option<Arrival>; 3],
}

/// Light that arrives at a second surface.
#[derive(Clone, Copy)]
pub(super) struct Arrival {
    /// Unit vector towards where it comes from, in the surface's frame.
    wi: Vec3,
    /// Its radiance; for a light without a surface irradiance over probability.
    pub(super) radiance: Rgb,
    /// The density over solid angle with which light samples would find it; one for a light without
    /// a surface, zero for light that comes from no light.
    light_pdf: f32,
    /// Whether directions drawn from the reflectance would find it, too.
    by_direction: bool,
}

impl Second {
    /// What reflects at `surface` towards `wo` (both in world space) and others; none if that is
    /// nothing. The surface is no mirror, and of the reflection number one.
    pub(super) fn new(
        transport: &Transport<'_>,
        surface: Surface,
        wo: Vec3,
        sampler: &mut Sampler,
    ) -> Option<Self> {
        let (bsdf, frame) = transport.bsdf(&surface);
        let point = accel::offset(surface.point, surface.geometric_normal);
        if !surface.is_above(wo) || bsdf.is_black() {
            return None;
        }
        let reflection = if bsdf.specular == Specular::None {
            let paths = PATHS[usize::from(transport.has_several_lights())];
            let each = (0..paths).map(|_| transport.reflected(surface, wo, sampler, 1));
            let radiance = each.sum::<Rgb>() / paths as f32;
            (radiance != Rgb::ZERO).then_some(Reflection::Even(radiance))
        } else {
            let images = transport.images(&bsdf, &surface, &frame, 1);
            let mut lobe = Lobe { bsdf, images, frame, arrivals: [None; 3] };
            lobe.gather(transport, &surface, wo, sampler);
            lobe.arrivals.iter().any(Option::is_some).then_some(Reflection::Lobe(lobe))
        };
        Some(Self { surface, point, reflection: reflection? })
    }

    /// The unit normals of the triangle and of the shading.
    pub(super) fn normals(&self) -> [Vec3; 2] {
        [self.surface.geometric_normal, self.surface.frame.normal]
    }
}

impl Lobe {
    /// One light sample and one direction.
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
        if let Some((wi, weight, pdf)) = transport.visible_light(surface, [pick, u, v]) {
            self.arrivals[0] = Some(Arrival {
                wi: self.frame.local_from_world(wi),
                radiance: weight * pdf.unwrap_or(1.0),
                light_pdf: pdf.unwrap_or(1.0),
                by_direction: pdf.is_some(),
            });
        }
        let [lobe, u, v, _] = sampler.next4();
        let bsdf = self.bsdf.looking_at(&self.images);
        let Some(sample) = bsdf.sample(self.frame.local_from_world(wo), [lobe, u, v]) else {
            return;
        };
        let wi = self.frame.world_from_local(sample.wi);
        if !surface.is_above(wi) {
            return;
        }
        let met = transport.meet(surface, wi);
        let arrival = |radiance: Rgb, light_pdf: f32| {
            let arrival = Arrival { wi: sample.wi, radiance, light_pdf, by_direction: true };
            (radiance != Rgb::ZERO).then_some(arrival)
        };
        self.arrivals[1] =
            arrival(met.emission * transport.appearance().light(met.source), met.light_pdf);
        if let Some(next) = met.surface {
            self.arrivals[2] = arrival(transport.reflected(next, -wi, sampler, 2), 0.0);
        }
    }

    /// The direction towards a viewer who looks along `wi` (world space).
    pub(super) fn towards(&self, wi: Vec3) -> Vec3 {
        self.frame.local_from_world(-wi)
    }

    /// The reflectance from `arrival` towards `wo` times the cosine of its direction, and the
    /// density with which it would be found on a path from there.
    pub(super) fn f_cos_and_pdf(&self, arrival: &Arrival, wo: Vec3) -> (Rgb, f32) {
        let bsdf = self.bsdf.looking_at(&self.images);
        let (f, pdf) = bsdf.value_and_pdf(wo, arrival.wi);
        let by_direction = if arrival.by_direction { pdf } else { 0.0 };
        (f * arrival.wi.z, arrival.light_pdf + by_direction)
    }
}
