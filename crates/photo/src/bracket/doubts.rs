//! Warnings of a merged bracket: shifts, motion, clipping, times that do not fit, a response that is a guess.

use super::Report;
use unrender_scene::Warnings;

/// Motion in more than this share of the pixels causes a warning: below, it is edges and single
/// pixels.
const MOVED: f64 = 1e-3;
/// The two fits of a response agree if they differ by less than this share of white. At two thirds of it some JPEG
/// files with a right response cause a warning; at double a wrong exposure time passes.
const DISAGREEMENT: f64 = 0.03;
/// Exposure times are accepted up to this relative error. Cameras round 1/64 to 1/60, which is 6 %.
const TIMES: f64 = 0.03;
/// If a fitted response is extrapolated within these codes, there is a warning.
const COVERED: [f64; 2] = [0.15, 0.85];

impl Report {
    /// Warnings of the merged bracket, whose frames are called `names`.
    ///
    /// # Panics
    /// If there are fewer names than frames.
    pub fn doubts(&self, names: &[&str]) -> Warnings {
        let mut warnings = Warnings::default();
        let percent = |share: f64| 100.0 * share;
        let reference = names[self.reference];
        for (name, shift) in names.iter().zip(&self.shifts).filter(|(_, shift)| **shift != [0, 0]) {
            let [right, down] = shift;
            warnings.push(format!(
                "{name} is shifted against {reference} by {} pixel(s) to the {} and {} {}; this was undone",
                right.abs(),
                if *right < 0 { "left" } else { "right" },
                down.abs(),
                if *down < 0 { "up" } else { "down" },
            ));
        }
        if self.moved > MOVED {
            warnings.push(format!(
                "something moved between the photographs of the bracket, in {:.1} % of the pixels: \
                 there, photographs that differ from {reference} were left out",
                percent(self.moved)
            ));
        }
        if self.clipped > 0.0 {
            warnings.push(format!(
                "{:.2} % of the pixels are clipped in every photograph of the bracket, and stay clipped",
                percent(self.clipped)
            ));
        }
        for (name, brightness) in names.iter().zip(&self.brightness) {
            if (brightness - 1.0).abs() > TIMES {
                warnings.push(format!(
                    "{name} is {brightness:.2} times as bright as its exposure and the next longer one \
                     imply; is its exposure time right? Cameras round it: 1/60 may be 1/64"
                ));
            }
        }
        if self.noise.is_none() {
            warnings.push(
                "too few pixels are well exposed in two photographs of the bracket to measure their \
                 noise; that of a usual camera was taken",
            );
        }
        warnings.extend(doubts_of_fit(self));
        warnings
    }
}

/// Warnings of a fitted response.
fn doubts_of_fit(report: &Report) -> Warnings {
    let mut warnings = Warnings::default();
    let Some(fit) = &report.fit else { return warnings };
    if fit.disagreement > DISAGREEMENT {
        warnings.push(format!(
            "two fits of the camera's response differ by {:.1} % of white; take more exposures, or \
             measure the response and state it",
            100.0 * fit.disagreement
        ));
    }
    let [low, high] = fit.covered;
    if low > COVERED[0] || high < COVERED[1] {
        warnings.push(format!(
            "the photographs show the same things at two exposures only between the pixel values \
             {low:.2} and {high:.2} (of 1); beyond, the camera's response is a guess"
        ));
    }
    warnings
}
