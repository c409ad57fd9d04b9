//! How much work a recovery is worth: an answer at once, the usual one, or one with less noise.

use serde::{Deserialize, Serialize};

/// How many pixels, light samples and paths are spent on every comparison.
///
/// A draft compares the hypotheses of each group once, in the light of the first common fit. The others make the same
/// comparisons with more samples: then more differences are significant. The standard deviations of a draft are larger,
/// and somewhat too small for its errors (`docs/guides/results.md`). The paper's ladder has its own sample counts, and
/// heeds this only in the choice of the camera, the exposure by an anchor, and the last picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Effort {
    /// A first answer, for an eighth of the samples and without second thoughts: faint and small lobes may be missed, and
    /// groups that light each other may keep each other wrong.
    Draft,
    /// The usual one.
    #[default]
    Normal,
    /// Four times as many samples.
    High,
}

/// A last picture of more pixels than this has fewer paths in each. Half and double of it were not tried.
const LAST_PIXELS: usize = 1 << 18;
/// Paths a pixel at least, however many pixels there are: half of them in each of two pictures that show the noise. At
/// double of it all of 12 megapixels take twice as long; half of it was not tried.
const LAST_SPP_MIN: u32 = 8;

impl Effort {
    /// The number of pixels, if [`Effort::Normal`] uses `normal`. Half of a draft's share, and double of it, were not
    /// tried.
    #[must_use]
    pub(crate) fn pixels(self, normal: usize) -> usize {
        match self {
            Self::Draft => normal / 4,
            Self::Normal => normal,
            Self::High => normal.saturating_mul(2),
        }
    }

    /// Light samples or paths a pixel, at least one, if [`Effort::Normal`] takes `normal`. Other shares than a half
    /// were not tried for a draft.
    #[must_use]
    pub(crate) fn samples(self, normal: u32) -> u32 {
        match self {
            Self::Draft => normal.div_ceil(2),
            Self::Normal => normal,
            Self::High => normal.saturating_mul(2),
        }
    }

    /// The standard deviation that is small enough, if for [`Effort::Normal`] `normal` is: twice the paths make it 0.7.
    /// At double of a draft's a small Figure 8 takes as long and its direction is a fifth further off; half of it was
    /// not tried.
    #[must_use]
    pub(crate) fn deviation(self, normal: f64) -> f64 {
        match self {
            Self::Draft => 1.5 * normal,
            Self::Normal => normal,
            Self::High => 0.5 * normal,
        }
    }

    /// Whether hypotheses are compared again under the refined light.
    /// A draft that did took 2 to 4 times as long in rooms by another renderer; without it six such rooms have 39 of 43
    /// hypotheses right, the usual effort all.
    #[must_use]
    pub(crate) fn asks_again(self) -> bool {
        self != Self::Draft
    }

    /// Paths a pixel of a last picture of so many `pixels`, by default: a large one has so many fewer that all of it
    /// takes as long as one of 512 x 512. Seen as a whole, both look equally noisy.
    #[must_use]
    pub fn last_spp(self, pixels: usize) -> u32 {
        let usual = match self {
            Self::Draft => 16.0,
            Self::Normal | Self::High => 64.0,
        };
        let share = (LAST_PIXELS as f64 / pixels.max(1) as f64).min(1.0);
        ((usual * share).round() as u32).max(LAST_SPP_MIN)
    }

    /// Its name in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Normal => "normal",
            Self::High => "high",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Effort;

    #[test]
    fn more_effort_is_never_less_work() {
        let all = [Effort::Draft, Effort::Normal, Effort::High];
        for count in [1, 2, 7, 1000] {
            let grows = |of: &dyn Fn(Effort) -> usize| all.map(of).is_sorted();
            assert!(grows(&|e| e.pixels(count)));
            assert!(grows(&|e| e.samples(count as u32) as usize));
            assert!(grows(&|e| e.last_spp(count * 10_000) as usize));
            assert!(Effort::Draft.samples(count as u32) > 0);
            assert_eq!(Effort::Normal.pixels(count), count);
            let deviations = all.map(|effort| effort.deviation(count as f64));
            assert!(deviations.is_sorted_by(|a, b| a > b) && deviations[1] == count as f64);
        }
    }
}
