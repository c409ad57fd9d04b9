//! Where the renderings' noise matters, and how the paths of a pass are shared out among the groups.
//!
//! It may have a share of a number's variance, or what is below what anyone would ask for (`precise_enough`):
//! more paths than that bring a result no nearer to the truth.

use super::blocks;
use super::unknowns::Unknowns;
use crate::effort::Effort;
use crate::state::State;
use nalgebra::{DMatrix, DVector};

/// Paths a pixel that a group gets in a pass. At half of the least what groups showed is carried too far along a
/// straight line, at double more paths are traced than are needed; the most is what a small group may take.
const SPP: [f64; 2] = [8.0, 256.0];
/// The renderings may have this share of a number's variance. At half of it twice the paths are traced, for
/// standard deviations that are a tenth smaller; double of it makes them half as large again.
const RENDERING_SHARE: f64 = 0.35;

/// What one group needs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Need {
    /// Whether it lacks paths.
    pub(super) lacks: bool,
    /// The variance that the renderings' noise gives its worst number, as a multiple of what anyone would ask for.
    pub(super) noise: f64,
}

/// The need of each group. What the lights, the camera and groups without pixels lack, all groups do. Where a number
/// has `moved` by more than its standard deviation, all groups are looked at again from there: what they showed
/// was carried along a straight line. For each group `seen` has the pixels.
pub(super) fn of(
    state: &State<'_>,
    (unknowns, effort): (&Unknowns, Effort),
    (covariance, rendering): (&DMatrix<f64>, &DVector<f64>),
    moved: &[f64],
    seen: &[f64],
) -> Vec<Need> {
    let mut needs = vec![Need::default(); seen.len()];
    let mut all_lack = moved.iter().any(|moved| *moved > 1.0);
    for (k, u) in unknowns.list.iter().enumerate() {
        let block = blocks::of(u.quantity);
        let allowed = RENDERING_SHARE * covariance[(k, k)];
        let precise = effort.deviation(block.precise_enough(state, u)).powi(2);
        let lacks = rendering[k] > allowed && rendering[k] > precise;
        let is_of_all = block.is_nuisance() || seen[u.of] == 0.0;
        all_lack |= lacks && is_of_all;
        if !block.is_nuisance() {
            let need = &mut needs[u.of];
            *need =
                Need { lacks: need.lacks || lacks, noise: need.noise.max(rendering[k] / precise) };
        }
    }
    needs.iter().map(|need| Need { lacks: need.lacks || all_lack, ..*need }).collect()
}

/// The paths a pixel of every group for the next pass: few where it lacks none, to the others in proportion to
/// their noise, in all about `mean_spp` a pixel of the whole picture. For each group `seen` has the pixels.
pub(super) fn allocate(seen: &[f64], needs: &[Need], mean_spp: u32) -> Vec<u32> {
    let lacking = seen.iter().zip(needs).filter(|(_, need)| need.lacks);
    let wanted: f64 = lacking.map(|(pixels, need)| pixels * need.noise).sum();
    let paths = f64::from(mean_spp) * seen.iter().sum::<f64>();
    let spp = |need: &Need| {
        let spp = (paths * need.noise / wanted.max(f64::MIN_POSITIVE)).round();
        if need.lacks { spp.clamp(SPP[0], SPP[1]) as u32 } else { SPP[0] as u32 }
    };
    needs.iter().map(spp).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_go_where_they_are_lacking() {
        let seen = [1000.0, 1000.0, 10.0, 500.0];
        let need = |lacks: bool, noise: f64| Need { lacks, noise };
        let whole = [need(true, 1.0); 4];
        assert_eq!(allocate(&seen, &whole, 32), [32; 4]);
        // The budget goes to the groups that lack paths, by their noise.
        let some = [need(true, 3.0), need(true, 1.0), need(false, 9.0), need(false, 9.0)];
        let spp = allocate(&seen, &some, 32);
        assert_eq!(spp, [60, 20, 8, 8]);
        // A small group takes no more than makes sense; nor does one get less.
        let small = [need(false, 1.0), need(false, 1.0), need(true, 50.0), need(false, 1.0)];
        assert_eq!(allocate(&seen, &small, 32), [8, 8, 256, 8]);
        let unlike = [need(true, 1e4), need(true, 1.0), need(false, 1.0), need(false, 1.0)];
        assert_eq!(allocate(&seen, &unlike, 32)[1], 8);
    }
}
