//! Photographs by Mitsuba 3, with our lobes as a plugin: its light transport, and the lobes in
//! closed form.

use super::{Halves, Photograph, SampleBudget};
use crate::Failure;
use crate::corpus::generate::Plan;
use crate::peers::{Shot, mitsuba};
use std::fmt::Write;
use std::path::Path;
use unrender::scene::{Camera, Scene};

/// Plugins in Python need a compiled variant.
const VARIANT: &str = "llvm_ad_rgb";
/// Samples of a pixel at once: 2.8 million paths of 43 200 pixels, half a gigabyte. Twice as many
/// take twice the memory, half as many a tenth more time.
const SPP: u32 = 64;

/// As [`super::take`].
///
/// # Errors
/// If Mitsuba is not available or fails.
pub(super) fn take(
    plan: &Plan,
    scene: &Scene,
    camera: &Camera,
    budget: SampleBudget,
    work: &Path,
) -> Result<Photograph, Failure> {
    let python = mitsuba::python()?;
    let shot = Shot { scene, camera, size: plan.size };
    let path = mitsuba::write(&shot, work, mitsuba::Lobe::Ward, "multijitter")?;
    let text = with_balls(&std::fs::read_to_string(&path)?, plan);
    let text = with_foreign(&text, plan);
    std::fs::write(&path, text)?;
    let mut program = mitsuba::Mitsuba::load(&python, VARIANT, &path)?;
    let mut halves = Halves::new(plan.size);
    for pass in 0..(budget.spp_max / SPP).max(2) {
        halves.add(&program.render(SPP, pass)?.0);
        let photograph = halves.photograph(SPP);
        if pass % 2 == 1 && photograph.noise() <= budget.noise {
            return Ok(photograph);
        }
    }
    Ok(halves.photograph(SPP))
}

/// The scene with round lamps as Mitsuba's own spheres, of which it samples the visible part. With
/// triangles, half of the samples would be on the far side, which causes most of a picture's noise.
fn with_balls(text: &str, plan: &Plan) -> String {
    let lamps = plan.lights.lamps.iter().chain(&plan.other_lights.lamps);
    let balls: Vec<_> = lamps.filter_map(|lamp| Some((&lamp.name, lamp.ball?))).collect();
    let mut out = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        let mesh = lines.peek().copied().unwrap_or_default();
        let is = |name: &str| mesh.contains(&format!("\"mesh/o_{name}.ply\""));
        let ball = balls.iter().find(|(name, _)| is(name));
        if let (true, Some((_, (centre, radius)))) = (line.contains("type=\"ply\""), ball) {
            let _ = writeln!(
                out,
                "<shape type=\"sphere\"><point name=\"center\" x=\"{}\" y=\"{}\" z=\"{}\"/>\
                 <float name=\"radius\" value=\"{radius}\"/>",
                centre.x, centre.y, centre.z
            );
            lines.next();
            continue;
        }
        out.push_str(line);
        out.push('\n');
    }
    out
}

/// The scene with the foreign reflectances in place of the most similar ones of ours.
fn with_foreign(text: &str, plan: &Plan) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let group = plan.groups.iter().find_map(|group| {
            let id = format!("id=\"m_{}\"", group.name);
            let starts = line.trim_start().starts_with("<bsdf ") && line.contains(&id);
            group.foreign.as_ref().filter(|_| starts).map(|foreign| (id, foreign))
        });
        match group {
            Some((id, foreign)) => {
                let texture = line.find("<texture ").and_then(|start| {
                    let end = line[start..].find("</texture>")?;
                    Some(&line[start..start + end + "</texture>".len()])
                });
                let inside = foreign.mitsuba(texture);
                let _ = writeln!(out, "<bsdf type=\"twosided\" {id}>{inside}</bsdf>");
            }
            None => {
                out.push_str(line);
                out.push('\n');
            }
        }
    }
    out
}
