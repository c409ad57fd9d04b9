//! glTF 2.0 (`.glb`, `.gltf`) to and from scenes.
//!
//! - [`read`] bakes the nodes of the default scene into world space.
//! - [`assign_materials`] gives back the file that was read, with the recovered materials.
//! - [`place`](place()) gives it back with one more camera.
//! - [`to_glb`] writes a scene that has no such file.
//!
//! Ward materials are converted to and from glTF's in one file, `ward.rs`. To understand another
//! extension: name it in the table of `extensions`, give it a field in `document` and rows in
//! `elements`, and use the field where its owner (material, node, camera) is read. A property
//! without a field is warned of (`tell`).

mod accessor;
mod assign;
mod container;
mod detail;
mod detailed;
mod document;
mod elements;
mod extensions;
mod geometry;
mod glass;
mod glb;
mod graph;
mod lights;
mod material;
mod names;
mod panes;
mod place;
mod principled;
mod profiles;
mod read;
mod source;
mod tell;
mod texture;
mod transform;
mod two_sided;
mod units;
mod unread;
mod ward;
mod write;

pub use assign::assign_materials;
pub use place::place;
pub use read::read;
pub use units::light_units;
pub use write::{GlbError, to_glb, to_glb_as};

/// What is read of glTF.
pub(crate) fn tables() -> Vec<crate::entry::Table> {
    let [used, required] = extensions::tables();
    vec![elements::table(), elements::attributes(), used, required]
}

/// What is wrong with a file and what to do, in one sentence without a full stop.
type Problem = String;
