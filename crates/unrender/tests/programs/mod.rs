//! Other renderers, installed where tests can use them, and pictures compared group by group.
//!
//! Each comes from a package registry into a folder of its own beside the build's outputs, and stays
//! there. Where that cannot be, the reason is told and the test skipped.

#![allow(dead_code, unused_imports)]

mod compare;
mod install;
mod render;

pub(crate) use compare::{Row, compare};
pub(crate) use install::{npm, python};
pub(crate) use render::{Program, our_picture};
