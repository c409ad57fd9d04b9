//! Files to and from the plain data of `unrender-scene`.
//!
//! One file format is one module. To add another: write `read` and/or `write` in a module of its own
//! that knows nothing of its siblings, name it in [`scene_file`] (by extension), add its faults to
//! `tests/bad_input.rs`, and list what it reads in a table that it uses itself:
//! [`what_is_read`](mod@what_is_read).
//!
//! Writers never leave half a file: see [`atomic`].

pub mod ascii_json;
pub mod atomic;
pub mod axis_lines;
pub mod cameras;
mod entry;
pub mod error;
pub mod export;
pub mod fspy;
mod glasses;
pub mod gltf;
mod group_detail;
pub mod ies;
pub mod import;
pub mod input;
mod kind;
mod light_units;
pub mod material_file;
pub mod materials;
pub mod materialx;
pub mod merl;
mod missing;
mod names;
mod near;
mod numbers;
pub mod obj;
pub mod picture;
pub mod planes;
pub mod points;
mod polygon;
mod principled;
mod record;
mod relief;
pub mod response_curve;
pub mod scene_file;
mod separated;
mod texels;
mod told;
pub mod what_is_read;

pub use error::FileError;
pub use input::{Input, InputError, Limits};
pub use kind::Kind;
pub use light_units::LightUnits;
pub use scene_file::{assign_materials, load_model, load_scene, place};
pub use what_is_read::what_is_read;
