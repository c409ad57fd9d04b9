//! The warning about scenes that lie far from zero, for programs that compute in single precision.

use unrender_scene::{Scene, Warnings};

/// For files that keep the scene at its place.
pub(super) const WRITTEN_THERE: &str =
    "it was written where it is; render it with a variant in double precision, or move it";

/// For files whose root moves it to its place.
pub(super) const WRITTEN_BY_ROOT: &str = "it was written with that point at zero, and the transform of the root prim moves it; clear that to look at it closely";

/// For files that move it to zero.
pub(super) const WRITTEN_NEARER: &str = "it was written with that point at zero";

/// Warns that `program` resolves the positions of `scene` coarsely, if `scene` lies far from zero.
pub(super) fn warn(scene: &Scene, program: &str, what: &str, warnings: &mut Warnings) {
    let farthest = scene.origin.abs().max_element();
    if farthest > 0.0 {
        let [x, y, z] = scene.origin.to_array();
        let step = (farthest as f32).next_up() - farthest as f32;
        warnings.push(format!(
            "the scene lies about ({x}, {y}, {z}) m, where {program}, which computes in single precision, has \
             steps of {step} m: {what}"
        ));
    }
}
