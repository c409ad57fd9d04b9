//! The subcommands: each file holds the arguments of one and its `run`; [`effort`] holds flags that
//! two share.

pub mod calibrate;
pub mod check;
pub mod effort;
pub mod export;
pub mod merge;
pub mod recover;
pub mod render;
pub mod report;
pub mod restage;
pub mod score;
