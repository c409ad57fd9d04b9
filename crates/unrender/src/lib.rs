//! From one photograph and a 3D model of what it shows to the reflectance of every surface.
//!
//! This page is a tour of the library; its code is tested. This crate connects the others and is
//! the `unrender` command. One subcommand is one file in [`commands`]; to add another, write such a
//! file and name it in [`cli`].
//!
//! # The parts
//!
//! - [`scene`] is the world as plain data. A [`Scene`](scene::Scene) is meshes in world space, sorted
//!   into groups that share one reflectance; area lights are groups that emit.
//! - [`formats`] reads and writes files: [`formats::load_scene`], [`formats::picture::read`].
//! - [`photo`] turns code values into radiance: [`photo::develop`] takes the camera's response out
//!   and says which pixels are clipped; [`photo::calibrate`](photo::calibrate::calibrate) finds the
//!   camera from measured points.
//! - [`render`] computes light. A [`Tracer`](render::Tracer) is built once for geometry and lights;
//!   materials are given with each call.
//! - [`recover`] is the inverse. An [`Observation`](recover::Observation) is the photograph sorted by
//!   groups, a [`Problem`](recover::Problem) states what is unknown, and [`recover::recover`] solves
//!   it.
//! - [`engine`] connects them: from a [`Project`] and its files to [`Recovered`](engine::Recovered).
//!
//! # All the way round
//!
//! A scene in code, a picture of it, and from the picture back to the materials:
//!
//! ```
//! use glam::Vec3;
//! use unrender::recover::{
//!     GroupSpec, Hypothesis, Observation, Options, Picture, Problem, Renderer, View,
//! };
//! use unrender::render::{Settings, Tracer};
//! use unrender::scene::{Camera, Group, Material, Mesh, Object, Rgb, Scene};
//!
//! // The scene: a floor, a wall and a lamp. Corners go counter-clockwise seen from the
//! // front; y is up; metres.
//! let quads = [
//!     ("floor", [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]]),
//!     ("wall", [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 2.0, -1.0], [-1.0, 2.0, -1.0]]),
//!     ("lamp", [[-0.4, 2.0, -0.4], [0.4, 2.0, -0.4], [0.4, 2.0, 0.4], [-0.4, 2.0, 0.4]]),
//! ];
//! let mut scene = Scene::default();
//! for (group, (name, corners)) in quads.into_iter().enumerate() {
//!     let mesh = Mesh::flat(&corners.map(Vec3::from_array), &[], &[[0, 1, 2], [0, 2, 3]]);
//!     scene.objects.push(Object { name: name.into(), group, mesh });
//!     let emission = if name == "lamp" { Rgb::splat(8.0) } else { Rgb::ZERO };
//!     let material = Material::diffuse(Rgb::ZERO);
//!     scene.groups.push(Group { name: name.into(), material, emission });
//! }
//! scene.validate()?;
//! let camera =
//!     Camera::look_at("camera", Vec3::new(0.0, 1.4, 3.0), Vec3::new(0.0, 0.6, 0.0), Vec3::Y, 0.6);
//!
//! // The photograph: 16 x 16 pixels of the scene with the materials that are to be found.
//! let truth = [Rgb::new(0.6, 0.3, 0.1), Rgb::splat(0.7), Rgb::ZERO].map(Material::diffuse);
//! let tracer = Tracer::new(&scene);
//! let view = View::new(&tracer, &camera, (16, 16), scene.brdf);
//! let settings = Settings { spp: 256, ..Settings::default() };
//! let photograph = view.render(&truth, &settings, &|_| {}).mean;
//!
//! // Floating-point values: nothing is clipped, and there is no step between two codes.
//! let picture = Picture {
//!     valid: photograph.map(|_| true),
//!     saturated: photograph.map(|_| false),
//!     quantisation_step: photograph.map(|_| Rgb::ZERO),
//!     values: photograph,
//! };
//! let observation = Observation::new(picture, view.geometry(), scene.groups.len());
//!
//! // Floor and wall are unknown; the lamp is given.
//! let groups = scene.groups.iter().map(GroupSpec::of).collect();
//! let problem = Problem::new(&observation, &view, groups);
//! // The observer `()` ignores the iterations.
//! let recovery = unrender::recover::recover(&problem, &Options::default(), &mut ())?;
//!
//! for group in 0..2 {
//!     let found = &recovery.groups[group];
//!     assert_eq!(found.hypothesis, Hypothesis::Diffuse, "{}", found.name);
//!     let error = (found.material.rho_d - truth[group].rho_d).abs().max_element();
//!     assert!(error < 0.01, "{}: rho_d is {}", found.name, found.material.rho_d);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # With files
//!
//! The same from a project file is four calls. What the project leaves open is found too: the exact place
//! of the camera, and its response if that is "auto".
//!
//! ```no_run
//! use unrender::engine::{self, Asked};
//! use unrender::{Job, Project};
//!
//! let (project, warnings) = Project::read("room/project.toml".as_ref())?;
//! let mut job = Job::load(project, warnings)?;
//! let asked = Asked::of(&job);
//! // The follower `()` ignores all messages.
//! let recovered = engine::recover(&mut job, &asked, &mut ())?;
//! println!("{:?}", recovered.materials(&job).groups);
//! # Ok::<(), unrender::Error>(())
//! ```
//!
//! `unrender recover` does that, shows its progress, and writes the results. [`score`] compares two such
//! results.
//!
//! # Features
//!
//! `cli` (on by default) is the command with its terminal, its signals and its folders of results; `report`
//! the pages that it makes. A library needs neither: `default-features = false` leaves out their twelve
//! dependencies, with [`cli`], [`commands`], [`edit`] and [`report`]. Whole recoveries stay: [`check`]
//! checks their input, and [`engine`] finds the camera's place and its response as the command does.

// Code that only the command uses is unused without it.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]
#![deny(clippy::print_stdout, clippy::print_stderr)]

mod as_json;
mod bracket;
pub mod check;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod commands;
pub mod converted;
#[cfg(feature = "cli")]
pub mod edit;
pub mod engine;
pub mod error;
#[cfg(feature = "cli")]
mod fingerprint;
#[cfg(feature = "cli")]
mod global;
#[cfg(feature = "cli")]
mod growing_picture;
#[cfg(feature = "cli")]
mod interrupt;
pub mod job;
pub mod lighting;
#[cfg(feature = "cli")]
pub mod listener;
mod mask;
#[cfg(feature = "cli")]
pub mod measured;
#[cfg(feature = "cli")]
mod output;
#[cfg(feature = "cli")]
mod own_project;
#[cfg(feature = "cli")]
mod passes;
mod photograph;
mod photometric;
pub mod plan;
#[cfg(feature = "cli")]
mod playable;
mod problem;
#[cfg(feature = "cli")]
mod progress;
#[cfg(feature = "cli")]
mod progressive;
#[cfg(feature = "cli")]
mod progressive_render;
pub mod project;
#[cfg(feature = "cli")]
pub mod proposed;
mod readings;
mod recovered;
#[cfg(feature = "cli")]
mod recovery_journal;
#[cfg(feature = "cli")]
mod recovery_progress;
mod registered;
mod registration;
#[cfg(feature = "report")]
pub mod report;
#[cfg(feature = "cli")]
pub mod result_folder;
#[cfg(feature = "cli")]
mod results;
pub mod run;
mod same_as;
pub mod score;
#[cfg(feature = "cli")]
mod shard;
mod shell_word;
mod shot;
mod sketch;
mod text_file;
mod text_table;
mod toml_values;
mod ungrouped;
mod unusable;
mod up_axis;
mod working_size;

pub use error::Error;
pub use job::Job;
pub use project::Project;
pub use shot::Shot;
pub use unrender_formats as formats;
pub use unrender_measured as fit_brdf;
pub use unrender_photo as photo;
pub use unrender_recover as recover;
pub use unrender_register as register;
pub use unrender_remote as remote;
pub use unrender_render as render;
pub use unrender_restage as restage;
pub use unrender_scene as scene;
