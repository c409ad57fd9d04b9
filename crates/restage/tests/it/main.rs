//! Tests of edits and of composites.

mod common;

mod composite;
mod edits;
