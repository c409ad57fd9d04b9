//! Tests of the command, of the library behind it, and of the statements of the documents.

#[path = "../kit/mod.rs"]
mod kit;

mod architecture;
mod book;
mod bracket;
mod brightness;
mod calibrate;
mod calibrate_lines;
mod check;
mod command;
mod corpus_recovery;
mod export_command;
mod export_environment;
mod exports;
mod far;
mod farm;
mod fig8_recovery;
mod fig8_reference;
mod fit_brdf;
mod init;
mod interrupt;
mod large_photograph;
mod long_render;
mod mistakes;
mod passes;
mod photometric;
mod project;
mod project_camera;
mod project_groups;
mod project_light;
mod relight;
mod report;
mod restage;
mod restage_encoding;
mod resume;
mod room_recovery;
mod safe;
mod score;
mod several;
mod split;
mod view;
