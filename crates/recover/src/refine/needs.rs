//! Where the renderings' noise matters, and how many paths more it takes until it does not.
//!
//! It may have a share of a number's variance, or what is below what anyone would ask for (`precise_enough`):
//! more paths than that bring a result no nearer to the truth.

use super::blocks;
use super::unknowns::Unknowns;
use crate::state::State;
use nalgebra::{DMatrix, DVector};

/// Paths a pixel that a group gets in a pass, if any. At half of the least one more passes are made, at double more
/// paths than are needed; the most is what a pass of a small group may take.
const SPP: [f64; 2] = [8.0, 256.0];
/// The renderings may have this share of a number's variance. At half of it twice the paths are traced, for
/// standard deviations that are a tenth smaller; double of it makes them half as large again.
const RENDERING_SHARE: f64 = 0.35;

/// For each group: the variance that the renderings' noise gives its worst number, as a multiple of what it may
/// have; a number that `moved` by more than its standard deviation is looked at from where it is now, by as
/// many paths again. What the lights, the camera and groups without pixels lack, all groups do.
pub(super) fn of(
    state: &State<'_>,
    unknowns: &Unknowns,
    (covariance, rendering): (&DMatrix<f64>, &DVector<f64>),
    moved: &[f64],
    seen: &[(f64, f64)],
) -> Vec<f64> {
    let (mut needs, mut of_all) = (vec![0.0f64; seen.len()], 0.0f64);
    for (k, u) in unknowns.list.iter().enumerate() {
        let allowed = RENDERING_SHARE * covariance[(k, k)];
        let precise = blocks::of(u.quantity).precise_enough(state, u);
        let noise = rendering[k] / allowed.max(precise.powi(2));
        let need = if moved[k] > 1.0 { noise.max(2.0) } else { noise };
        let is_of_all = blocks::of(u.quantity).is_nuisance() || seen[u.of].0 == 0.0;
        let of = if is_of_all { &mut of_all } else { &mut needs[u.of] };
        *of = of.max(need);
    }
    needs.iter().map(|need| need.max(of_all)).collect()
}

/// The paths a pixel of every group for the next pass: as many as its `needs` ask for beyond those that it has,
/// none where it needs none, and not more in all than `mean_spp` a pixel of the whole picture. For each
/// group `seen` has the pixels, and the paths that each of them has.
pub(super) fn allocate(seen: &[(f64, f64)], needs: &[f64], mean_spp: u32) -> Vec<u32> {
    let lacking = |(need, (_, paths)): (&f64, &(f64, f64))| {
        let lacking = paths * (need - 1.0);
        if lacking > 0.0 { lacking.clamp(SPP[0], SPP[1]) } else { 0.0 }
    };
    let lacking: Vec<f64> = needs.iter().zip(seen).map(lacking).collect();
    let wanted: f64 = lacking.iter().zip(seen).map(|(spp, (pixels, _))| spp * pixels).sum();
    let most = f64::from(mean_spp) * seen.iter().map(|(pixels, _)| pixels).sum::<f64>();
    let share = (most / wanted.max(f64::MIN_POSITIVE)).min(1.0);
    lacking.iter().map(|spp| (share * spp).ceil() as u32).collect()
}

/// How many passes of `mean_spp` paths a pixel of the whole picture have as many paths as one with `spp` of each group.
pub(super) fn passes(seen: &[(f64, f64)], spp: &[u32], mean_spp: u32) -> f64 {
    let pixels: f64 = seen.iter().map(|(pixels, _)| pixels).sum();
    let paths: f64 = seen.iter().zip(spp).map(|((pixels, _), spp)| pixels * f64::from(*spp)).sum();
    paths / (f64::from(mean_spp) * pixels).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_go_where_they_are_lacking_and_no_further_than_the_budget() {
        let seen = [(1000.0, 32.0), (1000.0, 32.0), (10.0, 32.0), (0.0, 0.0)];
        // As many as are lacking: the variance of a mean falls with their number.
        assert_eq!(allocate(&seen, &[1.0, 1.5, 3.0, 0.5], 32), [0, 16, 64, 0]);
        // At least as many as make a pass worth its while, at most what one may take.
        assert_eq!(allocate(&seen, &[0.0, 1.01, 1e6, 9.0], 32), [0, 8, 256, 0]);
        // All together not more than the whole picture may take.
        let spp = allocate(&seen, &[100.0, 100.0, 0.0, 0.0], 32);
        let paths: f64 = spp.iter().zip(&seen).map(|(spp, seen)| f64::from(*spp) * seen.0).sum();
        assert!((passes(&seen, &spp, 32) - 1.0).abs() < 0.05);
        assert!(spp[0] == spp[1] && (paths - 32.0 * 2010.0).abs() < 2010.0, "{spp:?}");
    }
}
