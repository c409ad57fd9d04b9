//! Proofs of the renderer: closed forms, laws of reflectance, derivatives against differences of renderings, and
//! the same bits on any number of threads.

mod common;

mod adaptive;
mod anisotropy;
mod bsdf_laws;
mod closed_form;
mod coats;
mod denoise;
mod detail;
mod determinism;
mod environment;
mod explain;
mod first_hits;
mod glass;
mod guiding;
mod jacobian;
mod jacobian_independent;
mod layers;
mod path_reuse;
mod probes;
mod scale;
mod virtual_lamps;
mod ward_table;
