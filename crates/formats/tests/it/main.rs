//! Tests of the files: what is read means what its program meant, what is written reads back, and bad input gets a
//! clear error.

mod support;

mod bad_input;
mod bad_pictures;
mod export;
mod far;
mod gltf_exporters;
mod gltf_read;
mod hostile;
mod import;
mod light_units;
mod materials;
mod obj;
mod pictures;
mod planes;
mod round_trip;
