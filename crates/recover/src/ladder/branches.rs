//! Branches: other kinds of hypothesis for a group that stays unexplained, each with its own model selection.
//!
//! Groups that light each other depend on each other: a wall's lobe is found only if the table that mirrors it is a
//! mirror, and the table is found to be one only if the wall has its lobe. Tested one after the other, each keeps its
//! hypothesis. So the group that leaves most of the picture unexplained gets another kind of hypothesis, whether its
//! own evidence speaks for it or not, and the groups whose light it changes are tested again; the driver keeps the
//! result if it explains the whole picture better.

use super::proposal::Proposal;
use super::unexplained;
use crate::guess::Guess;
use crate::hypothesis::Hypothesis;
use crate::observe::model_error::ModelError;

/// The kinds of uniform hypotheses, by their specular part: none, a mirror, a lobe with a width.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Diffuse,
    Mirror,
    Lobe,
}

impl Kind {
    /// That of `hypothesis`; none for a texture, which is not uniform.
    pub(crate) fn of(hypothesis: Hypothesis) -> Option<Self> {
        match hypothesis {
            Hypothesis::Diffuse => Some(Self::Diffuse),
            Hypothesis::Mirror | Hypothesis::PartialMirror | Hypothesis::DiffuseSpecular => {
                Some(Self::Mirror)
            }
            Hypothesis::Isotropic | Hypothesis::Anisotropic => Some(Self::Lobe),
            _ => None,
        }
    }
}

/// The hypothesis of another kind that came nearest to the present one, for the group that leaves most of the picture
/// unexplained beyond what is `allowed` for ([`unexplained`]); not those of `tried`.
pub(crate) fn next(
    guess: &Guess<'_>,
    allowed: ModelError,
    tried: &[(usize, Kind)],
) -> Option<Proposal> {
    let unexplained = unexplained::groups(guess, allowed).into_iter();
    let mut groups =
        unexplained.filter(|group| Kind::of(guess.groups[*group].hypothesis).is_some());
    groups.find_map(|group| other_kind(guess, group, tried))
}

/// The nearest hypothesis of `group` of a kind that is neither its own nor was tried.
fn other_kind(guess: &Guess<'_>, group: usize, tried: &[(usize, Kind)]) -> Option<Proposal> {
    let of_group = &guess.groups[group];
    let own = Kind::of(of_group.hypothesis);
    let is_new = |kind: Kind| Some(kind) != own && !tried.contains(&(group, kind));
    let is_allowed = |hypothesis| {
        guess.problem.groups[group].allows(hypothesis) && Kind::of(hypothesis).is_some_and(is_new)
    };
    let last = of_group.last_candidates().filter(|record| is_allowed(record.hypothesis));
    let nearest = last.min_by(|a, b| a.criterion.total_cmp(&b.criterion))?;
    Some(Proposal::of_record(guess, group, nearest))
}
