//! Scene to radiance: global illumination by path tracing, its derivatives, and the incident light
//! that recovery needs.
//!
//! A [`Tracer`] is built once for a scene's geometry and lights. For any [`Appearance`] (materials
//! and brightness of lights) it computes
//!  - [`Tracer::render`]: the picture that a camera sees (module [`integrator`]); in shards that
//!    add up to the same bits, by [`Tracer::accumulate`] into an [`Accumulator`] (module [`film`]);
//!    with more samples where the variance is high, by [`Tracer::adaptive_sampling`] (module
//!    [`adaptive`]); with path reuse among neighbouring pixels ([`Integrator::PathReuse`], module
//!    `path_reuse`);
//!  - [`Tracer::geometry`]: object, group, depth and normal of each pixel (module [`geometry`]);
//!  - [`Tracer::features`]: what the camera sees at first hit, averaged over each pixel (module [`features`]), and
//!    with it [`Tracer::denoise`]: a picture with less noise and a small bias (module [`denoise`]);
//!  - [`Tracer::first_hits`]: reflectance, normal, position, depth and groups, for compositing (module [`first_hits`]);
//!  - [`Tracer::accumulate_layers`]: what each light source contributes to a picture (module [`layers`]);
//!  - [`Tracer::probe`]: the light incident at the surfaces behind given pixels, so that any
//!    reflectance can be evaluated there without tracing again (module [`probe`]), lobe after lobe by [`LobeSums`];
//!  - [`Tracer::jacobian`]: the derivative of the picture by every parameter (module [`jacobian`]);
//!  - [`Tracer::store`]: paths that are traced once and evaluated under any appearance ([`StoredPaths`]);
//!  - [`View`] and [`Views`]: one camera, or several, behind the trait [`Renderer`] (module [`view`]);
//!  - [`Tracer::bright_paths`]: the paths that make a picture noisy, and what happened along each (module [`explain`]).
//!
//! Reading order: [`path`] is the light transport; [`surface`] and [`bsdf`] are what a ray hits,
//! [`emitters`] and [`environment`] the lights, `virtual_lamps` samples them by way of planar
//! mirrors, [`guiding`] directs samples to them by way of glossy planes, [`sampler`] draws the
//! random numbers, [`accel`] intersects rays with triangles.
//!
//! Sources are cited by the keys of `docs/bibliography.md`.
//!
//! Results depend on the input and the seed alone, never on the number of threads: every pixel has
//! its own random numbers, and sums are exact or in a fixed order.

pub mod accel;
pub mod adaptive;
pub mod appearance;
pub mod bsdf;
pub mod camera_sample;
pub mod coplanar;
pub mod denoise;
mod distribution;
pub mod emitters;
pub mod environment;
pub mod explain;
pub mod features;
pub mod film;
pub mod first_hits;
pub mod geometry;
pub mod guiding;
pub mod integrator;
pub mod jacobian;
mod lanes;
pub mod layers;
pub mod lobe_sums;
pub mod path;
mod path_reuse;
pub mod probe;
pub mod query;
pub mod radiance_cache;
pub mod sampler;
pub mod settings;
mod shapes;
pub mod surface;
#[cfg(test)]
mod test_meshes;
pub mod tracer;
mod turn;
mod veil;
pub mod view;
mod virtual_lamps;

pub use appearance::Appearance;
pub use bsdf::lobe::GlossyLobe;
pub use bsdf::ward::WardLobe;
pub use explain::BrightPath;
pub use features::{FeatureBuffers, PixelFeatures};
pub use film::{Accumulator, Film, PixelAccumulator};
pub use first_hits::{FirstHits, GROUPS};
pub use geometry::{GeometryBuffers, NOTHING, PixelGeometry};
pub use jacobian::{Jacobian, StoredPaths};
pub use lobe_sums::LobeSums;
pub use probe::{Incident, Mirrored, Probe, ProbeSettings, Probes, ProposalLobe};
pub use query::{Parameter, Query};
pub use radiance_cache::RadianceCache;
pub use settings::{Integrator, Settings};
pub use tracer::Tracer;
pub use view::{Renderer, Stored, View, Views};
