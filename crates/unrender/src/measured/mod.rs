//! What `unrender fit-brdf` says of its fits: a table, JSON, the lines of a project file, and pictures of spheres.

mod document;
mod spheres;
mod words;

pub(crate) use document::document;
pub use document::{Document, FitEntry};
pub(crate) use spheres::spheres;
pub(crate) use words::{known, materials, table};
