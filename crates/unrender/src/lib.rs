//! From one photograph and a 3D model of what it shows to the reflectance of every surface.
//!
//! The crates below are the parts: [`scene`] is the world as plain data, [`formats`] its files,
//! [`photo`] turns code values into radiance. This crate ties them together and is the `unrender`
//! command. One subcommand is one file in [`commands`]; to add another, write such a file and
//! name it in [`cli`].

pub mod cli;
pub mod commands;
mod engine;
pub mod error;
mod interrupt;
pub mod job;
mod output;
mod progress;
pub mod project;
mod results;
pub mod score;

pub use error::Error;
pub use job::Job;
pub use project::Project;
pub use unrender_formats as formats;
pub use unrender_photo as photo;
pub use unrender_recover as recover;
pub use unrender_render as render;
pub use unrender_scene as scene;
