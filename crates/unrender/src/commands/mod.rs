//! The subcommands: each file holds the arguments of one and its `run`.

pub mod calibrate;
pub mod merge;
pub mod recover;
pub mod render;
pub mod report;
pub mod score;
