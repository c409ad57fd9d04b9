//! What recovery asks of a renderer: one small trait, so that the ladder can be tested against
//! closed-form renderers in milliseconds.

use unrender_render::{
    Film, GeometryBuffers, ProbeSettings, Probes, ProposalLobe, SeenRadiance, Settings, Tracer,
    seen::Lookup,
};
use unrender_scene::{Camera, Material, Rgb, WardModel};

/// A scene seen by the photograph's camera, to be rendered with any materials of its groups.
pub trait Renderer: Sync {
    /// What stands in each pixel.
    fn geometry(&self) -> &GeometryBuffers;
    /// Which form of Ward's lobe the materials mean.
    fn model(&self) -> WardModel;
    /// The light that arrives behind `pixels`; paths end where `seen` knows the radiance.
    fn probe(
        &self,
        materials: &[Material],
        pixels: &[u32],
        settings: &ProbeSettings,
        seen: Option<&SeenRadiance>,
    ) -> Probes;
    /// The radiance of `pixels`, re-rendered.
    fn rerender(&self, materials: &[Material], pixels: &[u32], settings: &Settings) -> Vec<Rgb>;
}

/// The path tracer behind one camera.
#[derive(Debug)]
pub struct View<'a> {
    tracer: &'a Tracer,
    camera: &'a Camera,
    size: (usize, usize),
    model: WardModel,
    geometry: GeometryBuffers,
}

impl<'a> View<'a> {
    /// The picture of `width` x `height` pixels that `camera` takes of the tracer's scene.
    pub fn new(
        tracer: &'a Tracer,
        camera: &'a Camera,
        (width, height): (usize, usize),
        model: WardModel,
    ) -> Self {
        let geometry = tracer.geometry(camera, width, height);
        Self { tracer, camera, size: (width, height), model, geometry }
    }

    /// The whole picture, with its variance.
    pub fn render(
        &self,
        materials: &[Material],
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Film {
        self.tracer.render(materials, self.camera, self.size, settings, progress)
    }
}

impl Renderer for View<'_> {
    fn geometry(&self) -> &GeometryBuffers {
        &self.geometry
    }

    fn model(&self) -> WardModel {
        self.model
    }

    fn probe(
        &self,
        materials: &[Material],
        pixels: &[u32],
        settings: &ProbeSettings,
        seen: Option<&SeenRadiance>,
    ) -> Probes {
        let lookup =
            seen.map(|seen| Lookup { seen, camera: self.camera, geometry: &self.geometry });
        self.tracer.probe(materials, self.camera, self.size, pixels, settings, lookup)
    }

    fn rerender(&self, materials: &[Material], pixels: &[u32], settings: &Settings) -> Vec<Rgb> {
        let estimates =
            self.tracer.render_pixels(materials, self.camera, self.size, pixels, settings);
        estimates.into_iter().map(|(mean, _)| mean).collect()
    }
}

/// Proposal lobes of one width in all directions.
pub(crate) fn round_lobes(alphas: &[f32]) -> Vec<ProposalLobe> {
    let lobe = |&alpha: &f32| ProposalLobe { alpha_x: alpha, alpha_y: alpha, theta_rad: 0.0 };
    alphas.iter().map(lobe).collect()
}
