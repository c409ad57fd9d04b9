//! A surface that the camera sees, and the light that it reflects without its neighbours' help.

use crate::accel::{self, Ray};
use crate::bsdf::{Bsdf, Specular, lambert};
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

    /// Where rays leave it.
    pub(super) fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The unit normals of the triangle and of the shading.
    pub(super) fn normals(&self) -> [Vec3; 2] {
        [self.surface.geometric_normal, self.surface.frame.normal]
    }

    /// The images that the diffuse part looks for, and the frame that they are given in.
    pub(super) fn images(&self) -> (&Images, &Frame) {
        (&self.images, &self.frame)
    }

    /// How this surface looks along the unit vector `wi` (world space), of the cosine `cosine`; if it
    /// has no lobe, it would do so with the density `diffuse_pdf`. None if it could not have.
    #[inline]
    pub(super) fn view(&self, wi: Vec3, cosine: f32, diffuse_pdf: f32) -> Option<View> {
        let (f, pdf) = if self.bsdf.specular == Specular::None {
            (self.bsdf.rho_d * lambert::VALUE, diffuse_pdf)
        } else {
            self.bsdf().value_and_pdf(self.wo, self.frame.local_from_world(wi))
        };
        (pdf > 0.0 && pdf.is_finite()).then_some(View { wi, f_cos: f * cosine, pdf })
    }
}
