//! Scene to radiance: global illumination by path tracing, and the evidence that recovery reads.
//!
//! Everything starts at a [`Tracer`], built once for a scene's geometry and lights. It then answers
//! four questions, each for any [`Appearance`] (materials and brightness of lights):
//!  - [`Tracer::render`]: what does the camera see? (module [`film`])
//!    In parts that add up to the same bits: [`Tracer::accumulate`] (module [`tally`]), and
//!    more of it where the noise is: [`Tracer::shares`] (module [`adaptive`]).
//!    With [`Settings::shared`] neighbouring pixels share what their paths find (module [`sharing`]).
//!  - [`Tracer::geometry`]: which object, group, depth and normal stands in each pixel?
//!    (module [`geometry`])
//!  - [`Tracer::probe`]: what light arrives at the surfaces in these pixels, so that any reflectance
//!    can be tried on them without tracing again? (module [`probe`])
//!  - [`Tracer::jacobian`]: how does what the camera sees change with every parameter? (module
//!    [`jacobian`])
//!
//! Reading order: [`path`] is the light transport, [`surface`] and [`bsdf`] what it meets,
//! [`emitters`] and [`environment`] where it ends, [`sampler`] the numbers that steer it, [`accel`] how rays find
//! triangles.
//!
//! Results depend on the input and the seed alone, never on the number of threads: every pixel has
//! its own sequence of sample points, and sums are exact or in one order.

pub mod accel;
pub mod adaptive;
pub mod bsdf;
pub mod caustic;
pub mod emitters;
pub mod environment;
pub mod film;
pub mod geometry;
pub mod jacobian;
mod lanes;
pub mod path;
pub mod probe;
pub mod sampler;
pub mod seen;
pub mod sharing;
pub mod surface;
pub mod tally;
pub mod tracer;

pub use bsdf::lobe::GlossyLobe;
pub use bsdf::ward::WardLobe;
pub use film::{Film, Settings};
pub use geometry::{GeometryBuffers, NOTHING, PixelGeometry};
pub use jacobian::{Jacobian, Parameter};
pub use probe::{Probe, ProbeSettings, Probes, ProposalLobe};
pub use seen::SeenRadiance;
pub use tally::{Moments, Tally};
pub use tracer::{Appearance, Tracer};
