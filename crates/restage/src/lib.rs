//! A scene and edits to new pictures, and back into the photograph.
//!
//! Edits are plain data ([`Edit`]); [`apply`] puts them onto a scene, one kind a module, and says in
//! a [`Change`] which objects are still what they were. From there on there are two ways:
//!  - the changed scene is rendered like any other, from where a [`camera::Path`] leads;
//!  - [`pair::render`] renders the scene before and after with the same random numbers, and
//!    [`composite::composite`] puts the change, and nothing else, into the photograph.
//!
//! To add a kind of edit, write a file beside [`remove`], name it in [`Edit`] and send it from
//! [`apply`].

pub mod camera;
pub mod composite;
pub mod edit;
pub mod environment;
pub mod grain;
pub mod insert;
pub mod light;
pub mod pair;
pub mod remove;
pub mod repaint;
pub mod snap;
pub mod touched;

pub use edit::{Change, Edit, EditError, apply};
