//! The tiny scenes of `examples/corpus`, photographed by other renderers (docs/corpus.md): what is
//! recovered from them, end to end.

mod common;

use common::{Limits, beside_crates, recovers};

/// Eight bits by Cycles. The scene's worst are a group of 60 pixels and one whose lobe no lamp is
/// mirrored in: reached are 0.036 and 39 %.
#[test]
fn glossy_groups_of_a_tiny_photograph_by_another_renderer_are_recovered() {
    let limits = Limits { rho: 0.045, alpha_percent: 45.0, degrees: 0.0 };
    recovers(&beside_crates("examples/corpus/isotropic"), "project.toml", &["--spp", "2"], &limits);
}
