//! Paths that workers keep: what identifies them, and requests on them.

use super::Remote;
use super::wire::Request;
use unrender_render::Query;
use unrender_render::view::{Renderer, Stored};
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
    pub(super) fn new(remote: &'r Remote<'a>, query: &Query<'_>) -> Self {
        Self {
            remote,
            materials: query.appearance.materials.to_vec(),
            lights: query.appearance.lights.to_vec(),
            pixels: query.pixels.to_vec(),
            parameters: query.parameters.to_vec(),
            settings: *query.settings,
            seen: query.seen.cloned(),
        }
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
            let stored = self.remote.view.store(&Query {
                parameters: &self.parameters,
                seen: self.seen.as_ref(),
                ..Query::new(drawn, &self.pixels, &self.settings)
            });
            stored.replay(appearance, parameters, seen)
        })
    }
}
