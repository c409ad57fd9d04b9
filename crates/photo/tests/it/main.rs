//! Tests of photographs: calibration of cameras, and brackets of exposures.

mod common;

mod bracket;
mod calibrate_accuracy;
mod calibrate_lines;
mod calibrate_photographs;
mod calibrate_robust;
