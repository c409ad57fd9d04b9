//! The worker's side: a scene with its tree, and answers to requests.

use super::kept::Kept;
use super::wire::{self, Appearances, Request, Setup};
use std::sync::{Arc, Mutex, PoisonError};
use unrender_render::Query;
use unrender_render::view::{Renderer, View};
use unrender_render::{Appearance, RadianceCache};
use unrender_scene::{Material, Rgb, SceneError};

/// Why a worker cannot answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The bytes mean nothing to this build.
    #[error("a request is not understood: install the same build of unrender on all machines")]
    NotUnderstood,
    /// The scene cannot be rendered.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

/// A scene and a camera, ready to answer.
pub struct Worker {
    view: View<'static>,
    groups: usize,
    /// The cache that was sent last, with its bytes: many requests refer to one.
    cache: Mutex<Option<(Vec<u8>, Arc<RadianceCache>)>>,
    /// Paths that are replayed.
    kept: Kept,
}

impl Worker {
    /// A worker built from the first of the shared data.
    ///
    /// # Errors
    /// If the bytes are not understood, or the scene cannot be rendered.
    pub fn new(setup: &[u8]) -> Result<Self, Fault> {
        let Setup { scene, camera, size } = wire::decode(setup).ok_or(Fault::NotUnderstood)?;
        let view = View::of_scene(&scene, camera, size)?;
        Ok(Self {
            view,
            groups: scene.groups.len(),
            cache: Mutex::default(),
            kept: Kept::default(),
        })
    }

    /// The answer to `request` under the second and the third of the shared data, `appearance` and
    /// `cache`.
    ///
    /// # Errors
    /// If the bytes are not understood.
    pub fn answer(
        &self,
        appearance: &[u8],
        cache: &[u8],
        request: &[u8],
    ) -> Result<Vec<u8>, Fault> {
        self.answered(appearance, cache, request).ok_or(Fault::NotUnderstood)
    }

    fn answered(&self, appearance: &[u8], cache: &[u8], request: &[u8]) -> Option<Vec<u8>> {
        let Appearances { now, drawn } = wire::decode(appearance)?;
        let appearance = self.appearance(&now)?;
        let cache = if cache.is_empty() { None } else { Some(self.cache(cache)?) };
        let (view, seen) = (&self.view, cache.as_deref());
        Some(match wire::decode(request)? {
            Request::Probe(pixels, settings) => {
                self.check(&pixels)?;
                wire::encode(
                    &view.probe(&Query { seen, ..Query::new(appearance, &pixels, &settings) }),
                )
            }
            Request::Jacobian(pixels, parameters, settings) => {
                self.check(&pixels.iter().map(|(pixel, _)| *pixel).collect::<Vec<u32>>())?;
                let query = Query::new(appearance, &pixels, &settings);
                wire::encode(&view.jacobian(&Query { parameters: &parameters, seen, ..query }))
            }
            Request::Replay(pixels, [traced, parameters], settings) => {
                self.check(&pixels)?;
                let drawn = drawn.as_ref().and_then(|drawn| self.appearance(drawn))?;
                let query = Query::new(drawn, pixels.as_slice(), &settings);
                let query = Query { parameters: &traced, seen, ..query };
                let paths = self.kept.paths(&query, || view.paths(&query));
                let found = view.replay(&paths, appearance, &parameters, seen);
                wire::encode(&found)
            }
            Request::Radiance(pixels, settings) => {
                self.check(&pixels)?;
                wire::encode(&view.rerender(appearance, &pixels, &settings))
            }
            Request::Samples(samples, settings) => {
                wire::of_sums(&view.samples(appearance, samples, &settings))
            }
        })
    }

    /// The appearance of these materials and factors on lights, if the scene has as many groups.
    fn appearance<'m>(
        &self,
        (materials, lights): &'m (Vec<Material>, Vec<Rgb>),
    ) -> Option<Appearance<'m>> {
        (materials.len() == self.groups).then_some(Appearance { materials, lights })
    }

    /// Whether the picture has these pixels.
    fn check(&self, pixels: &[u32]) -> Option<()> {
        let count = self.view.geometry().pixels().len();
        pixels.iter().all(|pixel| (*pixel as usize) < count).then_some(())
    }

    /// The cache of these bytes.
    fn cache(&self, bytes: &[u8]) -> Option<Arc<RadianceCache>> {
        let mut last = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, cache)) = last.as_ref().filter(|(known, _)| known == bytes) {
            return Some(Arc::clone(cache));
        }
        let cache: RadianceCache = wire::decode(bytes)?;
        let geometry = self.view.geometry();
        let size = (geometry.width(), geometry.height());
        let fits = (cache.radiance.width(), cache.radiance.height()) == size
            && (cache.valid.width(), cache.valid.height()) == size;
        let cache = fits.then(|| Arc::new(cache))?;
        *last = Some((bytes.to_vec(), Arc::clone(&cache)));
        Some(cache)
    }
}
