//! The subcommands: each file has the arguments of one and its `run`; [`sampling`] and [`encoding`] have
//! flags that some share.

pub mod calibrate;
pub mod check;
pub mod completions;
pub mod encoding;
pub mod export;
pub mod farm;
pub mod fit_brdf;
pub mod init;
pub mod man;
pub mod merge;
pub mod merge_exposures;
pub mod plan;
pub mod recover;
pub mod relight;
pub mod render;
pub mod report;
pub mod restage;
pub mod sampling;
pub mod score;
pub mod split;
pub mod view;
