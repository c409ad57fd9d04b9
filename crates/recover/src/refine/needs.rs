//! Where the renderings' noise matters, and how the paths of a pass are shared out among the groups.
//!
//! It may have a share of a number's variance, or what is below what anyone would ask for (`precise_enough`):
//! more paths than that bring a result no nearer to the truth.

use super::blocks;
use super::unknowns::Unknowns;
use crate::effort::Effort;
use crate::sample_budget::TOGETHER;
use crate::state::State;
use nalgebra::{DMatrix, DVector};

/// Paths a pixel that a group gets in a pass. The least is a full set of the sampler, which a group that lacks nothing
/// gets when others have moved; double of it was not tried. The most is what a small group may take.
const SPP: [f64; 2] = [16.0, 256.0];
/// The renderings may have this share of a number's variance. At half of it twice the paths are traced, for
/// standard deviations that are a tenth smaller; double of it makes them half as large again.
const RENDERING_SHARE: f64 = 0.35;
/// What the renderings' noise does not explain of a variance is taken as less by so many of its standard deviations: few
/// cells of heavy noise may look like it. At half of it the roughness of a thing in a room ends a third more uncertain; double
/// was not tried.
const DOUBTS: f64 = 2.0;

/// How many paths a pixel each group needs in the next pass, about `mean_spp` a pixel of the whole picture at most, none
/// where no group lacks any. What the lights, the camera and groups without pixels lack, all groups do. Where a number
/// has `moved` by more than its standard deviation, all groups are looked at again from there: what they showed
/// was carried along a straight line. For each group `seen` has the pixels, and `taken` the paths a pixel so far.
pub(super) fn of(
    state: &State<'_>,
    (unknowns, effort): (&Unknowns, Effort),
    (covariance, rendering, doubt): (&DMatrix<f64>, &DVector<f64>, &DVector<f64>),
    moved: &[f64],
    (seen, taken): (&[f64], &[u32]),
    mean_spp: u32,
) -> Vec<u32> {
    let has_moved = moved.iter().any(|moved| *moved > 1.0);
    let mut excess = vec![0.0f64; seen.len()];
    let mut of_all = 0.0f64;
    for (k, u) in unknowns.list.iter().enumerate() {
        let block = blocks::of(u.quantity);
        let precise = effort.deviation(block.precise_enough(state, u)).powi(2);
        let other = (covariance[(k, k)] - rendering[k] - DOUBTS * doubt[k]).max(0.0);
        let allowed = (RENDERING_SHARE / (1.0 - RENDERING_SHARE) * other).max(precise);
        let lacking = (rendering[k] / allowed - 1.0).max(0.0);
        let of_group =
            if block.is_nuisance() || seen[u.of] == 0.0 { &mut of_all } else { &mut excess[u.of] };
        *of_group = of_group.max(lacking);
    }
    let wanted = excess.iter().zip(taken).map(|(excess, taken)| {
        let more = excess.max(of_all) * f64::from(*taken);
        if more > 0.0 || has_moved { more.max(SPP[0]) } else { 0.0 }
    });
    allocate(seen, &wanted.collect::<Vec<f64>>(), mean_spp)
}

/// The `wanted` paths a pixel, all by the same factor fewer where they are more than about `mean_spp` a pixel of the whole
/// picture, of which each group has the pixels that were `seen`; in full sets of the sampler.
fn allocate(seen: &[f64], wanted: &[f64], mean_spp: u32) -> Vec<u32> {
    let clamped = |wanted: &f64| if *wanted > 0.0 { wanted.clamp(SPP[0], SPP[1]) } else { 0.0 };
    let total: f64 = seen.iter().zip(wanted).map(|(pixels, wanted)| pixels * clamped(wanted)).sum();
    let most = f64::from(mean_spp) * seen.iter().sum::<f64>();
    let share = (most / total.max(f64::MIN_POSITIVE)).min(1.0);
    let together = f64::from(TOGETHER);
    let spp = |wanted: &f64| match clamped(wanted) {
        0.0 => 0,
        wanted => ((share * wanted).max(SPP[0]) / together).ceil() as u32 * TOGETHER,
    };
    wanted.iter().map(spp).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_go_where_they_are_lacking() {
        let seen = [1000.0, 1000.0, 10.0, 500.0];
        // What is wanted is given, in full sets, and no more.
        assert_eq!(allocate(&seen, &[30.0, 0.0, 16.0, 3.0], 32), [32, 0, 16, 16]);
        assert_eq!(allocate(&seen, &[0.0; 4], 32), [0; 4]);
        // A small group takes no more than makes sense.
        assert_eq!(allocate(&seen, &[0.0, 0.0, 5000.0, 0.0], 32), [0, 0, 256, 0]);
        // Where that is too much, all get fewer; a group that is looked at is looked at well enough.
        let few = allocate(&seen, &[200.0, 100.0, 0.0, 8.0], 16);
        assert_eq!(few, [32, 16, 0, 16]);
    }
}
