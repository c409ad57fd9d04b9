//! A surface that the camera sees, and the light that it reflects without its neighbours' help.

use crate::accel::{self, Ray};
use crate::bsdf::Bsdf;
use crate::caustic::Images;
use crate::path::{Sum, Transport, Vertex};
use crate::sampler::Sampler;
use crate::sharing::second::Second;
use crate::surface::{Frame, Surface};
use glam::Vec3;
use unrender_scene::Rgb;

/// Light samples at the first surface, where there is one place that light comes from and where there
/// are several. Paths that share bring so much together that the light of a single sample would be
/// most of the noise.
const LIGHTS: [u32; 2] = [4, 16];

/// A surface that the camera sees.
pub(super) struct First {
    /// The index in its set of the pixel that looks at it.
    pub(super) pixel: usize,
    surface: Surface,
    /// Where rays leave it.
    origin: Vec3,
    bsdf: Bsdf<'static>,
    images: Images,
    frame: Frame,
    /// Unit vector back to the camera, in `frame`.
    wo: Vec3,
}

/// How a first surface looks in a direction.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// Unit vector there.
    pub(super) wi: Vec3,
    /// The reflectance towards the camera times the cosine here, sr^-1.
    pub(super) f_cos: Rgb,
    /// The density over solid angle with which the first surface looks there.
    pub(super) pdf: f32,
}

impl First {
    /// What a camera's ray meets; else the radiance that arrives along it from what does not share.
    pub(super) fn met(
        transport: &Transport<'_>,
        ray: &Ray,
        pixel: usize,
        sampler: &mut Sampler,
    ) -> Result<Self, Rgb> {
        let Some(surface) = transport.surface(ray) else {
            return Err(transport.environment(ray.direction));
        };
        let (bsdf, frame) = transport.bsdf(&surface);
        if !transport.reflects(0) || bsdf.is_black() || bsdf.is_pure_mirror() {
            let reflected = transport.reflected(surface, -ray.direction, sampler, 0);
            return Err(transport.emitted(&surface) + reflected);
        }
        Ok(Self {
            pixel,
            origin: accel::offset(surface.point, surface.geometric_normal),
            images: transport.images(&bsdf, &surface, &frame, 0),
            wo: frame.local_from_world(-ray.direction),
            surface,
            bsdf,
            frame,
        })
    }

    fn bsdf(&self) -> Bsdf<'_> {
        self.bsdf.looking_at(&self.images)
    }

    /// The radiance that goes to the camera, but for what comes by way of a second surface that is
    /// to be shared: that one is handed back.
    pub(super) fn radiance(
        &self,
        transport: &Transport<'_>,
        sampler: &mut Sampler,
    ) -> (Rgb, Option<Second>) {
        let bsdf = self.bsdf();
        let at = Vertex { surface: &self.surface, bsdf: &bsdf, frame: &self.frame, wo: self.wo };
        let lights = LIGHTS[usize::from(transport.has_several_lights())];
        let mut sum = Sum::new(transport.appearance());
        sum.radiance = transport.emitted(&self.surface);
        for [pick, u, v, _] in sampler.next4_each(lights) {
            transport.direct(Rgb::ONE, &at, [pick, u, v], lights, &mut sum);
        }
        let [lobe, u, v, _] = sampler.next4();
        let sample = bsdf.sample(self.wo, [lobe, u, v]);
        let sample = sample.map(|sample| (sample, self.frame.world_from_local(sample.wi)));
        let Some((sample, wi)) = sample.filter(|(_, wi)| self.surface.is_above(*wi)) else {
            return (sum.radiance, None);
        };
        let met = transport.meet(&self.surface, wi);
        met.tell(sample.weight, sample.pdf, lights, &mut sum);
        let Some(surface) = met.surface else { return (sum.radiance, None) };
        if sample.pdf.is_finite() && transport.is_smooth(&surface) {
            return (sum.radiance, Second::new(transport, surface, -wi, sampler));
        }
        let reflected = transport.reflected(surface, -wi, sampler, 1);
        (sum.radiance + sample.weight * reflected, None)
    }

    /// The unit vector to `point` and the distance, if this surface turns its front there.
    pub(super) fn direction(&self, point: Vec3) -> Option<(Vec3, f32)> {
        let to_point = point - self.origin;
        let distance = to_point.length();
        let wi = to_point / distance;
        self.surface.is_above(wi).then_some((wi, distance))
    }

    /// Whether nothing stands between this surface and what lies at `distance` along `wi`.
    pub(super) fn is_free(&self, transport: &Transport<'_>, wi: Vec3, distance: f32) -> bool {
        transport.is_free(self.origin, wi, distance)
    }

    /// How this surface looks along `wi`, if it could have.
    pub(super) fn view(&self, wi: Vec3) -> Option<View> {
        let local = self.frame.local_from_world(wi);
        let bsdf = self.bsdf();
        let pdf = bsdf.pdf(self.wo, local);
        let f_cos = bsdf.value(self.wo, local) * local.z;
        (pdf > 0.0 && pdf.is_finite()).then_some(View { wi, f_cos, pdf })
    }
}
