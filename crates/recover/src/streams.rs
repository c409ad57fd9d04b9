//! The streams of random numbers: steps that must not share noise draw from different ones. Each is a number that changes
//! the seed of the recovery; no value is better than another, and they stay as they are so that results do.

use unrender_render::sampler::mix;

/// What random numbers are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stream {
    /// The light samples of searches: those of the budget's own seed.
    Searching = 0,
    /// The light and paths by which hypotheses are compared: others than those that they were fitted to.
    Judging = 0x7D6E,
    /// The light of a second comparison.
    JudgingAgain = 0x41AF,
    /// Whether any light arrives.
    Darkness = 0x117,
    /// The fit of exposure, lights and camera before the first iteration.
    Nuisances = 0x11687,
    /// The joint fits and the refinement: pixels and paths.
    Refinement = 0x4EF1_4E00,
    /// The pixels of the verification ...
    VerifiedPixels = 0x7E57,
    /// ... and its paths.
    Verification = 0x5C04E,
    /// The search for other minima.
    OtherMinima = 0xBA51,
    /// The errors of the groups in the end.
    GroupErrors = 0xE220,
    /// The last picture.
    LastPicture = 0x5EED,
    /// The pictures that are shown while it works.
    RoughPicture = 0x6_20E1,
    /// The sketch by which a camera is judged.
    Sketch = 0x5_E7C4,
}

impl Stream {
    /// A seed of this stream for a recovery of this `seed`.
    pub(crate) fn seed(self, seed: u64) -> u64 {
        mix(self.change(seed))
    }

    /// The same without the mixing, where the receiver mixes seeds or adds another change.
    pub(crate) fn change(self, seed: u64) -> u64 {
        seed ^ self as u64
    }
}
