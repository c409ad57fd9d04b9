//! Lacking specular parts: which diffuse group would explain most of the picture if it had one.
//!
//! A lobe of the floor lights the walls, and the floor's own pixels may hardly show it: tested by these alone, the
//! floor stays diffuse and the walls wrong. So where the whole picture stays unexplained, a score test
//! ([`crate::refine::score_test`]) says which diffuse group would explain most of it by a specular part, whatever its
//! own pixels say. The driver adds that part and keeps it if it explains the other groups' pixels better.

use super::proposal::Proposal;
use super::unexplained;
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::observe::model_error::ModelError;
use crate::problem::Options;
use crate::refine::score_test::{self, Gain};
use std::collections::BTreeMap;
use unrender_scene::Rgb;

/// The specular parts that are tried: a mirror's, a sharp lobe's and a broad one's. What a surface sends elsewhere changes
/// slowly with its roughness: a floor of 0.135 gains 685 by 0.1, 820 by 0.3 and 410 as a mirror, and no other group of its
/// scene gains 100. With 0.05 and 0.25 alone, drafts of two scenes of four lose what they find with these.
const SHAPES: [Option<f32>; 3] = [None, Some(0.1), Some(0.3)];

/// For each diffuse group that was not `tried`, the specular part by which it explains most of the whole picture, the
/// best first. None where no group stays unexplained beyond what is `allowed` for ([`unexplained`]).
pub(crate) fn all(
    guess: &Guess<'_>,
    options: &Options,
    allowed: ModelError,
    tried: &[usize],
) -> Vec<Proposal> {
    if unexplained::groups(guess, allowed).is_empty() {
        return Vec::new();
    }
    let mut most: BTreeMap<usize, (Option<f32>, Gain)> = BTreeMap::new();
    for alpha in SHAPES {
        let (hypothesis, _) = score_test::with_specular(Rgb::ZERO, Rgb::ONE, alpha);
        let may_be = |group: &usize| {
            guess.groups[*group].hypothesis == Hypothesis::Diffuse
                && guess.problem.groups[*group].allows(hypothesis)
        };
        let groups: Vec<usize> = guess.visible_unknowns().into_iter().filter(may_be).collect();
        for (group, gain) in groups.iter().zip(score_test::gains(guess, options, &groups, alpha)) {
            let before = most.get(group).map_or(0.0, |(_, before)| before.value);
            if gain.value > before && !tried.contains(group) {
                most.insert(*group, (alpha, gain));
            }
        }
    }
    let mut most: Vec<(usize, (Option<f32>, Gain))> = most.into_iter().collect();
    most.sort_by(|(_, (_, a)), (_, (_, b))| b.value.total_cmp(&a.value));
    let proposal = |(group, (alpha, gain)): (usize, (Option<f32>, Gain))| {
        let rho_d = (guess.materials[group].rho_d - gain.rho_s).max(Rgb::ZERO);
        let to = score_test::with_specular(rho_d, gain.rho_s, alpha);
        Some(Proposal::unasked(group, to, guess.groups[group].residual?))
    };
    most.into_iter().filter_map(proposal).collect()
}
