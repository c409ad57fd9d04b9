//! Other renderers, and pictures compared group by group.
//!
//! Tests use what `.ci/programs` has installed beside the build's outputs; where something of it is
//! missing, [`need`] says so, and the test is skipped or fails.

mod compare;
mod install;
mod render;

pub(crate) use compare::{Row, compare, compare_quadrants};
pub(crate) use install::{installed, python};
pub(crate) use render::{Program, our_picture};

/// What a test needs from outside the repository; none where it is missing, which is printed. With
/// `UNRENDER_REQUIRE_TOOLS=1` in the environment that is a failure instead.
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
