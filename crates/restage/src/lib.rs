//! Edits of a scene: new pictures of it, and composites with the photograph.
//!
//! Edits are plain data ([`Edit`]), one kind per module. [`apply`] applies them to a scene and
//! returns a [`Change`], which maps the objects of the edited scene to those of the original one.
//! Then
//!  - the edited scene is rendered like any other, from the cameras of a [`camera::Path`];
//!  - or [`pair::render`] renders the scene before and after the edits with the same random
//!    numbers, and [`composite::composite`] puts the change into the photograph.
//!
//! To add a kind of edit, write a file beside [`remove`], name it in [`Edit`] and call it from
//! [`apply`]. Sources are cited by the keys of `docs/bibliography.md`.

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
pub mod size;
mod snap;
mod stage;
pub mod touched;

pub use edit::{Edit, EditError, apply};
pub use stage::Change;
