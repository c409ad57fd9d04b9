//! Scenes from other programs: their own exports, and scenes to test on.
//!
//! One format is one module with a function `read`. What we cannot represent exactly is taken as
//! closely as possible, with a warning that says how.

pub mod mitsuba;
mod ply;
pub mod radiance;
mod shapes;

/// What is read of these formats.
pub(crate) fn tables() -> Vec<crate::entry::Table> {
    [vec![ply::table()], mitsuba::tables(), radiance::tables()].concat()
}
