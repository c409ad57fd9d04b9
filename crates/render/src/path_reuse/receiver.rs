//! Receivers: the first vertices of the paths of a tile, and the light that they reflect on their
//! own.

use crate::accel::Ray;
use crate::bsdf::{Bsdf, lambert};
use crate::guiding::VmfMixture;
use crate::path::{LocalBsdf, PathObserver, RadianceSum, Start, Transport, Vertex};
use crate::path_reuse::reused::ReusableVertex;
use crate::sampler::Sampler;
use crate::surface::{Frame, Surface};
use glam::Vec3;
use unrender_scene::Rgb;

/// Light samples at a receiver, with one pool of lights and with several. Reuse reduces the
/// variance of indirect light by up to the number of pixels of a tile; with a single light sample
/// direct light would be most of the variance. Half of these are noisier at equal time, double of
/// them slower.
const LIGHTS: [u32; 2] = [4, 16];

/// A surface that the camera sees.
pub(super) struct Receiver {
    /// The place of its pixel in the tile.
    pub(super) pixel: usize,
    surface: Surface,
    /// The origin of rays that leave it.
    origin: Vec3,
    local: LocalBsdf,
    guide: VmfMixture,
    /// Unit vector back to the camera, in the frame of `local`.
    wo: Vec3,
}

/// The first step of a sample: a receiver, or the radiance of a sample that takes no part in reuse.
#[expect(clippy::large_enum_variant, reason = "boxing would allocate per path")]
pub(super) enum CameraHit {
    Receiver(Receiver),
    Radiance(Rgb),
}

/// What a receiver contributes without reuse, and the vertex that others may reuse.
pub(super) struct Contribution {
    pub(super) radiance: Rgb,
    pub(super) reusable: Option<ReusableVertex>,
}

/// The BRDF of a receiver in one direction.
#[derive(Clone, Copy)]
pub(super) struct ReceiverBsdf {
    /// Unit vector in that direction, world space.
    pub(super) wi: Vec3,
    /// The BRDF towards the camera times the cosine, sr^-1.
    pub(super) f_cos: Rgb,
    /// The density over solid angle with which the receiver draws that direction.
    pub(super) pdf: f32,
}

impl Receiver {
    /// The receiver of a camera ray. Black surfaces, perfect mirrors and the environment are none.
    pub(super) fn trace(
        transport: &Transport<'_>,
        ray: &Ray,
        pixel: usize,
        sampler: &mut Sampler,
    ) -> CameraHit {
        let Some(surface) = transport.tracer.surface(ray) else {
            return CameraHit::Radiance(transport.environment(ray.direction));
        };
        let local = transport.bsdf(&surface);
        let LocalBsdf { bsdf, frame } = &local;
        if !transport.reflects(0) || bsdf.is_black() || bsdf.is_pure_mirror() {
            let reflected =
                transport.reflected(surface, -ray.direction, sampler, Start::after(0), None);
            return CameraHit::Radiance(transport.emitted(&surface) + reflected);
        }
        CameraHit::Receiver(Self {
            pixel,
            origin: surface.start(),
            guide: transport.guide(&local, &surface, 0),
            wo: frame.local_from_viewer(-ray.direction),
            surface,
            local,
        })
    }

    fn bsdf(&self) -> Bsdf<'_> {
        self.local.bsdf.guided_by(&self.guide)
    }

    /// The radiance towards the camera by emission, light samples, and paths that cannot be reused.
    pub(super) fn contribution(
        &self,
        transport: &Transport<'_>,
        sampler: &mut Sampler,
    ) -> Contribution {
        let bsdf = self.bsdf();
        let frame = &self.local.frame;
        let at = Vertex { surface: &self.surface, bsdf: &bsdf, frame, wo: self.wo };
        let lights = LIGHTS[usize::from(transport.has_several_lights())];
        let mut sum = RadianceSum::new(transport);
        sum.radiance = transport.emitted(&self.surface);
        for numbers in sampler.next4_each(lights) {
            transport.sample_lights(Rgb::ONE, &at, numbers, (lights, 0), &mut sum);
        }
        let [lobe, u, v, _] = sampler.next4();
        let sample = bsdf.sample(self.wo, [lobe, u, v]);
        let sample = sample.map(|sample| (sample, frame.world_from_local(sample.wi)));
        let Some((sample, wi)) = sample.filter(|(_, wi)| self.surface.is_above(*wi)) else {
            return Contribution { radiance: sum.radiance, reusable: None };
        };
        let trail = transport.trail(None, &self.surface, &bsdf, sample.pdf, lights);
        let hit = transport.hit(&self.surface, wi, sampler);
        if hit.emission.radiance != Rgb::ZERO {
            let drawn = (sample.pdf, lights);
            let mis = transport.share_of_direction(&self.surface, &hit, drawn, trail);
            sum.record_emission(sample.weight, &hit.emission, mis);
        }
        let radiance = sum.radiance;
        let Some(surface) = hit.surface else {
            return Contribution { radiance, reusable: None };
        };
        if sample.pdf.is_finite() && transport.is_reusable(&surface) {
            let reusable = ReusableVertex::new(transport, surface, -wi, sampler);
            return Contribution { radiance, reusable };
        }
        let reflected = transport.reflected(surface, -wi, sampler, Start::after(1), trail);
        Contribution { radiance: radiance + sample.weight * reflected, reusable: None }
    }

    /// The origin of rays that leave it.
    pub(super) fn origin(&self) -> Vec3 {
        self.origin
    }

    /// The geometric and the shading normal, unit vectors.
    pub(super) fn normals(&self) -> [Vec3; 2] {
        [self.surface.geometric_normal, self.local.frame.normal]
    }

    /// The mixture that guides its diffuse term, and the frame that it is given in.
    pub(super) fn guide(&self) -> (&VmfMixture, &Frame) {
        (&self.guide, &self.local.frame)
    }

    /// The BRDF along the unit vector `wi` (world space) of the cosine `cosine`; `diffuse_pdf` is
    /// the density with which a diffuse receiver draws `wi`. None where the density is zero.
    #[inline]
    pub(super) fn evaluated(
        &self,
        wi: Vec3,
        cosine: f32,
        diffuse_pdf: f32,
    ) -> Option<ReceiverBsdf> {
        let LocalBsdf { bsdf, frame } = &self.local;
        let (f, pdf) = if bsdf.is_lambertian() {
            (bsdf.rho_d * lambert::VALUE, diffuse_pdf)
        } else {
            self.bsdf().value_and_pdf(self.wo, frame.local_from_world(wi))
        };
        (pdf > 0.0 && pdf.is_finite()).then_some(ReceiverBsdf { wi, f_cos: f * cosine, pdf })
    }
}
