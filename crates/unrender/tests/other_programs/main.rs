//! All tests that need something from outside the repository: other renderers, validators and a
//! browser, which `.ci/programs` installs in pinned versions, and photographs that lie beside it.
//!
//! They are slow tests: `cargo test -p unrender --test other_programs -- --ignored`. What is missing
//! is printed as skipped; with `UNRENDER_REQUIRE_TOOLS=1` it is a failure.

#[path = "../common/mod.rs"]
mod common;
#[path = "../export_scene/mod.rs"]
mod export_scene;
#[path = "../report_browser/pages.rs"]
mod pages;
#[path = "../programs/mod.rs"]
mod programs;
#[path = "../report_browser/recovered.rs"]
mod recovered;
#[path = "../report_browser/synthetic.rs"]
mod synthetic;

mod blender_room;
mod browser;
mod farm;
mod measured;
mod renderers;
mod validators;
