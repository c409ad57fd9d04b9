//! Initial cameras: POSIT over a range of focal lengths.

use super::layout::Layout;
use super::model::{Free, Model, Sight};
use super::posit::Posit;
use super::refine::{ROUGH, refine};

/// The shortest and the longest focal length that are tried, in the picture's longer side: fields
/// of view across it from 103 to 7 degrees.
const FOCALS: (f64, f64) = (0.4, 8.0);
const FOCAL_COUNT: usize = 13;
/// The number of poses by POSIT that are refined.
const REFINED: usize = 3;

/// The initial focal lengths, pixels: the known one, or a guess, if any, and the whole range.
pub(super) fn focals(known: Option<f64>, guess: Option<f64>, longer_side: f64) -> Vec<f64> {
    if let Some(focal) = known {
        return vec![focal];
    }
    let ratio = (FOCALS.1 / FOCALS.0).powf(1.0 / (FOCAL_COUNT - 1) as f64);
    let scan = (0..FOCAL_COUNT).map(|n| FOCALS.0 * ratio.powi(n as i32) * longer_side);
    guess.into_iter().chain(scan).collect()
}

/// Cameras that may have seen `sights`, the best first: poses for each of `focals`, the best of
/// them refined over pose and, where it is free, focal length.
pub(super) fn starts(sights: &[Sight], focals: &[f64], free: Free) -> Vec<Model> {
    let layout = Layout::of(sights);
    let mut found: Vec<(f64, Model)> = Vec::new();
    for planar in [false, true] {
        if if planar { !layout.nearly_planar() } else { layout.is_planar() } {
            continue;
        }
        let Some(posit) = Posit::new(sights, planar) else { continue };
        let poses = focals.iter().flat_map(|focal| posit.poses(*focal));
        found.extend(poses.map(|pose| (pose.cost(sights), pose)));
    }
    sort(&mut found);
    found.truncate(REFINED);
    for (cost, model) in &mut found {
        *model = refine(model, sights, free.without_lens(), ROUGH);
        *cost = model.cost(sights);
    }
    sort(&mut found);
    found.into_iter().map(|(_, model)| model).collect()
}

fn sort(found: &mut [(f64, Model)]) {
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
}
