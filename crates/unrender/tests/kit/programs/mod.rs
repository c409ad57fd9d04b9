//! Other renderers, and pictures compared group by group.
//!
//! Tests use the programs that `.ci/programs` has installed beside the build's outputs; if one is
//! missing, [`need`] prints it, and the test is skipped or fails.

mod compare;
mod install;
mod render;

pub(crate) use compare::{Row, compare, compare_quadrants};
pub(crate) use install::{installed, python};
pub(crate) use render::{Program, our_picture};

/// Something that a test needs from outside the repository; none if it is missing, which is
/// printed. With `UNRENDER_REQUIRE_TOOLS=1` in the environment that is a failure.
///
/// # Panics
/// If it is missing and required.
#[track_caller]
pub(crate) fn need<T>(found: Result<T, String>) -> Option<T> {
    match found {
        Ok(found) => Some(found),
        Err(problem) => {
            let is_required = std::env::var("UNRENDER_REQUIRE_TOOLS").is_ok_and(|v| v == "1");
            assert!(!is_required, "required, but {problem}");
            println!("skipped: {problem}");
            None
        }
    }
}
