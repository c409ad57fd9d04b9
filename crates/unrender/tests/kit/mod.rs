//! Code that the tests of this crate share: folders in which the command runs, small scenes, examples that are
//! recovered and scored, scenes to export, made-up results of recoveries, and other programs.

// Each test binary uses a part of it.
#![allow(dead_code, unused_imports)]

pub(crate) mod channels;
pub(crate) mod coloured_room;
pub(crate) mod encoded;
pub(crate) mod example;
pub(crate) mod export_scene;
pub(crate) mod floor_and_lamp;
pub(crate) mod folder;
pub(crate) mod meshes;
pub(crate) mod pages;
pub(crate) mod programs;
pub(crate) mod project_text;
pub(crate) mod recovered;
pub(crate) mod synthetic;
