//! What recovery needs from a renderer: one small trait, so that it can be tested against closed-form renderers in
//! milliseconds. [`View`] is the path tracer behind one camera, [`Views`] the renderer behind several.

mod views;

pub use views::Views;

use crate::adaptive::SampleAllocation;
use crate::radiance_cache::CacheLookup;
use crate::{
    Accumulator, Appearance, Film, GeometryBuffers, Integrator, Jacobian, Parameter, ProbeSettings,
    Probes, Query, RadianceCache, Settings, StoredPaths, Tracer,
};
use glam::Vec3;
use std::ops::{Deref, Range};
use unrender_scene::{BrdfModel, Camera, Rgb, Scene, SceneError};

/// A scene seen by the photograph's camera, to be rendered in any appearance.
pub trait Renderer: Sync {
    /// What each pixel shows.
    fn geometry(&self) -> &GeometryBuffers;
    /// The point of the surface behind the centre of `pixel`, metres in world space; none without a surface, or where the
    /// renderer cannot tell.
    fn point(&self, pixel: u32) -> Option<Vec3>;
    /// The lobe model of the materials.
    fn model(&self) -> BrdfModel;
    /// The light that arrives behind the pixels.
    fn probe(&self, query: &Query<'_, u32, ProbeSettings>) -> Probes;
    /// The radiance of the pixels and its derivatives, by the paths whose numbers stand beside each, zero where there
    /// are none.
    fn jacobian(&self, query: &Query<'_, (u32, Range<u32>)>) -> Jacobian;
    /// Keeps the paths of the pixels, drawn from the materials of the appearance.
    fn store<'s>(&'s self, query: &Query<'_>) -> Box<dyn Stored + 's>;
    /// The radiance of `pixels`, re-rendered.
    fn rerender(&self, appearance: Appearance<'_>, pixels: &[u32], settings: &Settings)
    -> Vec<Rgb>;
    /// The whole picture, with no more noise than `settings.spp` paths a pixel bring; pixels nearby
    /// may share what they find. `progress` hears the share done, 0 to 1.
    fn picture(
        &self,
        appearance: Appearance<'_>,
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Vec<Rgb>;
}

/// The paths of some pixels, to be evaluated under any appearance.
pub trait Stored {
    /// The radiance of the pixels under `appearance`, and its derivatives by `parameters`; paths that end in a cache
    /// bring the radiance that `seen` has there now.
    fn replay(
        &self,
        appearance: Appearance<'_>,
        parameters: &[Parameter],
        seen: Option<&RadianceCache>,
    ) -> Jacobian;
}

/// A reused path counts as this many at most: a few tiles of a picture do not show all, and with few paths the tiles
/// that share become visible.
const WORTH_MAX: f64 = 4.0;

/// The path tracer behind one camera.
#[derive(Debug)]
pub struct View<'a> {
    tracer: Held<'a, Tracer>,
    camera: Held<'a, Camera>,
    size: (usize, usize),
    model: BrdfModel,
    geometry: GeometryBuffers,
}

/// Something borrowed or owned.
#[derive(Debug)]
enum Held<'a, T> {
    Borrowed(&'a T),
    Owned(Box<T>),
}

impl<T> Deref for Held<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        match self {
            Self::Borrowed(value) => value,
            Self::Owned(value) => value,
        }
    }
}

impl<'a> View<'a> {
    /// The picture of `width` x `height` pixels that `camera` takes of the tracer's scene.
    pub fn new(
        tracer: &'a Tracer,
        camera: &'a Camera,
        (width, height): (usize, usize),
        model: BrdfModel,
    ) -> Self {
        let geometry = tracer.geometry(camera, width, height);
        let (tracer, camera) = (Held::Borrowed(tracer), Held::Borrowed(camera));
        Self { tracer, camera, size: (width, height), model, geometry }
    }

    /// The same of a scene, with a tracer of its own.
    ///
    /// # Errors
    /// Those of [`Tracer::try_new`].
    pub fn of_scene(
        scene: &Scene,
        camera: Camera,
        (width, height): (usize, usize),
    ) -> Result<View<'static>, SceneError> {
        let tracer = Tracer::try_new(scene)?;
        let geometry = tracer.geometry(&camera, width, height);
        let (tracer, camera) = (Held::Owned(Box::new(tracer)), Held::Owned(Box::new(camera)));
        Ok(View { tracer, camera, size: (width, height), model: scene.brdf, geometry })
    }

    /// The camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// How [`Renderer::picture`] renders with no more noise than `settings` say.
    pub fn plan(&self, appearance: Appearance<'_>, settings: &Settings) -> Settings {
        let (camera, size) = (&*self.camera, self.size);
        let worth = self.tracer.path_reuse_efficiency(appearance, camera, size, settings);
        let paths = f64::from(settings.spp) / worth.unwrap_or(1.0).min(WORTH_MAX);
        let integrator = Integrator::with_path_reuse(worth.is_some());
        Settings { spp: paths.ceil() as u32, integrator, ..*settings }
    }

    /// The samples with these numbers of the whole picture; those of all numbers add up to it.
    pub fn samples(
        &self,
        appearance: Appearance<'_>,
        samples: Range<u32>,
        settings: &Settings,
    ) -> Accumulator {
        let mut sums = Accumulator::new(self.size.0, self.size.1);
        let samples = SampleAllocation::Uniform(samples);
        self.tracer.accumulate(appearance, &self.camera, settings, &samples, &mut sums, &|_| {});
        sums
    }

    /// The paths of [`Renderer::store`].
    pub fn paths(&self, query: &Query<'_>) -> StoredPaths {
        let lookup = self.lookup(query.seen);
        self.tracer.store(&self.camera, self.size, &query.with_seen(lookup))
    }

    /// `paths` of this view, replayed.
    pub fn replay(
        &self,
        paths: &StoredPaths,
        appearance: Appearance<'_>,
        parameters: &[Parameter],
        seen: Option<&RadianceCache>,
    ) -> Jacobian {
        paths.replay(&self.tracer, appearance, parameters, seen)
    }

    fn lookup<'s>(&'s self, seen: Option<&'s RadianceCache>) -> Option<CacheLookup<'s>> {
        seen.map(|seen| CacheLookup { cache: seen, camera: &self.camera, geometry: &self.geometry })
    }

    /// The whole picture, with its variance.
    pub fn render<'m>(
        &self,
        appearance: impl Into<Appearance<'m>>,
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Film {
        self.tracer.render(appearance, &self.camera, self.size, settings, progress)
    }
}

/// The paths of a view.
struct ViewPaths<'v, 'a> {
    view: &'v View<'a>,
    paths: StoredPaths,
}

impl Stored for ViewPaths<'_, '_> {
    fn replay(
        &self,
        appearance: Appearance<'_>,
        parameters: &[Parameter],
        seen: Option<&RadianceCache>,
    ) -> Jacobian {
        self.view.replay(&self.paths, appearance, parameters, seen)
    }
}

impl Renderer for View<'_> {
    fn geometry(&self) -> &GeometryBuffers {
        &self.geometry
    }

    fn point(&self, pixel: u32) -> Option<Vec3> {
        let (width, height) = self.size;
        let depth = self.geometry.pixels()[pixel as usize].depth;
        let (x, y) = ((pixel as usize % width) as f32 + 0.5, (pixel as usize / width) as f32 + 0.5);
        let towards = self.camera.direction(x, y, width, height);
        depth.is_finite().then(|| self.camera.origin() + depth * towards)
    }

    fn model(&self) -> BrdfModel {
        self.model
    }

    fn probe(&self, query: &Query<'_, u32, ProbeSettings>) -> Probes {
        let lookup = self.lookup(query.seen);
        self.tracer.probe(&self.camera, self.size, &query.with_seen(lookup))
    }

    fn jacobian(&self, query: &Query<'_, (u32, Range<u32>)>) -> Jacobian {
        let query = query.with_seen(self.lookup(query.seen));
        self.tracer.jacobian_of_samples(&self.camera, self.size, &query)
    }

    fn store<'s>(&'s self, query: &Query<'_>) -> Box<dyn Stored + 's> {
        let paths = self.paths(query);
        Box::new(ViewPaths { view: self, paths })
    }

    fn rerender(
        &self,
        appearance: Appearance<'_>,
        pixels: &[u32],
        settings: &Settings,
    ) -> Vec<Rgb> {
        let estimates =
            self.tracer.render_pixels(appearance, &self.camera, self.size, pixels, settings);
        estimates.into_iter().map(|(mean, _)| mean).collect()
    }

    fn picture(
        &self,
        appearance: Appearance<'_>,
        settings: &Settings,
        progress: &(dyn Fn(f64) + Sync),
    ) -> Vec<Rgb> {
        let settings = self.plan(appearance, settings);
        self.render(appearance, &settings, progress).mean.pixels().to_vec()
    }
}
