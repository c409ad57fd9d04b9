//! Tests of the files: they are read as their program means them, written files read back, and bad input gets a
//! clear error.

mod support;

mod bad_input;
mod bad_pictures;
mod bmp;
mod camera_files;
mod declared_colours;
mod export;
mod export_glass;
mod exr_kinds;
mod far;
mod glass;
mod glass_and_detail;
mod gltf_exporters;
mod gltf_read;
mod gltf_unread;
mod hostile;
mod ies;
mod import;
mod light_units;
mod materials;
mod materialx;
mod missing_files;
mod mitsuba;
mod mitsuba_meshes;
mod mitsuba_rooms;
mod mitsuba_shapes;
mod no_data;
mod obj;
mod passes;
mod pictures;
mod planes;
mod radiance;
mod relief;
mod round_trip;
mod what_is_read;
