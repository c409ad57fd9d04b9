//! Photographs by Cycles, whose GGX is the same as ours, and whose Principled BSDF is foreign.

use super::{Halves, Photograph, SampleBudget};
use crate::Failure;
use crate::corpus::generate::Plan;
use crate::peers::{Shot, cycles, shot};
use serde_json::{Map, Value};
use std::path::Path;
use unrender::formats::atomic;
use unrender::formats::export::Target;
use unrender::scene::{Camera, Scene};

/// Samples of a pixel at once, as in [`super::mitsuba`].
const SPP: u32 = 64;

/// As [`super::take`].
///
/// # Errors
/// If Blender is not available or fails.
pub(super) fn take(
    plan: &Plan,
    scene: &Scene,
    camera: &Camera,
    budget: SampleBudget,
    work: &Path,
) -> Result<Photograph, Failure> {
    let python = cycles::python()?;
    shot::export(&Shot { scene, camera, size: plan.size }, Target::Blender, work)?;
    let foreign: Map<String, Value> = plan
        .groups
        .iter()
        .filter_map(|group| Some((group.name.clone(), group.foreign.as_ref()?.principled()?)))
        .collect();
    atomic::write(&work.join("foreign.json"), Value::Object(foreign).to_string().as_bytes())?;
    let mut program = cycles::Cycles::load(&python, work)?;
    let mut halves = Halves::new(plan.size);
    for pass in 0..(budget.spp_max / SPP).max(2) {
        halves.add(&program.render(SPP, pass)?);
        let photograph = halves.photograph(SPP);
        if pass % 2 == 1 && photograph.noise() <= budget.noise {
            return Ok(photograph);
        }
    }
    Ok(halves.photograph(SPP))
}
