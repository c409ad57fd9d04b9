//! All tests that need something from outside the repository: other renderers, validators and a
//! browser, which `.ci/programs` installs in pinned versions, and photographs that lie beside it.
//!
//! They are slow tests: `cargo test --release --test external -- --ignored`. What is missing
//! is printed as skipped; with `UNRENDER_REQUIRE_TOOLS=1` it is a failure.

#[path = "../kit/mod.rs"]
mod kit;

mod beside;
mod blender_room;
mod browser;
mod farm;
mod measured;
mod profiles;
mod renderers;
mod validators;
