//! Paths that workers keep: what identifies them, and requests on them.

use super::Remote;
use super::wire::Request;
use unrender_recover::rerender::{Renderer, Stored};
use unrender_render::{Appearance, Jacobian, Parameter, RadianceCache, Settings};
use unrender_scene::{Material, Rgb};

/// What identifies the paths: those of a tracer depend on nothing else.
pub(super) struct Paths<'r, 'a> {
    remote: &'r Remote<'a>,
    materials: Vec<Material>,
    lights: Vec<Rgb>,
    pixels: Vec<u32>,
    parameters: Vec<Parameter>,
    settings: Settings,
    seen: Option<RadianceCache>,
}

impl<'r, 'a> Paths<'r, 'a> {
    pub(super) fn new(
        remote: &'r Remote<'a>,
        drawn: Appearance<'_>,
        (pixels, parameters): (&[u32], &[Parameter]),
        settings: &Settings,
        seen: Option<RadianceCache>,
    ) -> Self {
        let (materials, lights) = (drawn.materials.to_vec(), drawn.lights.to_vec());
        let (pixels, parameters) = (pixels.to_vec(), parameters.to_vec());
        Self { remote, materials, lights, pixels, parameters, settings: *settings, seen }
    }
}

impl Stored for Paths<'_, '_> {
    fn replay(
        &self,
        appearance: Appearance<'_>,
        parameters: &[Parameter],
        seen: Option<&RadianceCache>,
    ) -> Jacobian {
        let drawn = Appearance { materials: &self.materials, lights: &self.lights };
        let both = [&self.parameters, parameters].map(|parameters| parameters.to_vec());
        let request = |tile: &[u32]| Request::Replay(tile.to_vec(), both.clone(), self.settings);
        let asked = (self.pixels.as_slice(), parameters.len());
        let found = self.remote.asked_jacobian((appearance, Some(drawn)), asked, seen, request);
        found.unwrap_or_else(|| {
            let (view, settings) = (&self.remote.view, &self.settings);
            let traced = (&self.pixels, &self.parameters);
            let stored = view.store(drawn, traced.0, traced.1, settings, self.seen.as_ref());
            stored.replay(appearance, parameters, seen)
        })
    }
}
