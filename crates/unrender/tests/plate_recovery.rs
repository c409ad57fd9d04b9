//! A box with a brushed plate in it. Its pictures are not part of the repository; where they are
//! missing, the tests say so and pass.

mod common;

use common::{Limits, beside_crates, recovers};

const LIMITS: Limits = Limits { rho: 0.01, alpha_percent: 4.0, degrees: 1.0 };

fn plate(file: &str) {
    let folder = beside_crates("../shared/data/plate");
    if folder.join(file).is_file() {
        recovers(&folder, file, &LIMITS);
    } else {
        println!("skipped: there is no {} in {}", file, folder.display());
    }
}

#[test]
fn the_plate_is_recovered_from_linear_radiance() {
    plate("project_exr.toml");
}

#[test]
fn the_plate_is_recovered_from_8_bits() {
    plate("project_png.toml");
}
