//! Finds one of several photographs that the materials explain far worse than the others: its camera, its exposure
//! or its lamps are not as the project states, or something was moved between them.

use super::Recovered;
use crate::Job;
use unrender_recover::PixelStatus;
use unrender_scene::Warnings;
use unrender_scene::color::luminance;

/// A photograph is odd if its re-rendering has at least this relative error. None of the photographs of eight sets
/// of the corpus' rooms has it, and one with the camera of another has; half and double of it were not tried.
const OFF: f64 = 0.1;
/// And this many times the error of the best explained photograph: a wrong model is wrong in all of them. Half and
/// double of it were not tried.
const TIMES: f64 = 3.0;

impl Recovered {
    /// Warnings of photographs of `job` that are explained far worse than another.
    pub(crate) fn odd_photographs(&self, job: &Job) -> Vec<Warnings> {
        let errors: Vec<f64> = (0..job.photographs()).map(|k| self.error_of(job, k)).collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let one = |(k, error): (usize, &f64)| {
            let mut warnings = Warnings::default();
            if *error > OFF && *error > TIMES * least {
                warnings.push(format!(
                    "{}its re-rendering is off by {:.0} % and that of another photograph by {:.1} \
                     %: check its camera, its exposure and its lamps, and whether something was \
                     moved",
                    job.called(k),
                    100.0 * error,
                    100.0 * least
                ));
            }
            warnings
        };
        errors.iter().enumerate().map(one).collect()
    }

    /// The relative error of luminance in one photograph that noise does not explain.
    fn error_of(&self, job: &Job, photograph: usize) -> f64 {
        let alone = self.alone(job, photograph);
        let recovery = &alone.recovery;
        let photo = &job.photo_of(photograph).radiance;
        let scale = self.exposure_of(job, photograph) / job.transfer_of(photograph).exposure;
        let (mut squares, mut level) = (0.0, 0.0);
        for (index, status) in recovery.status.pixels().iter().enumerate() {
            if *status == PixelStatus::Valid {
                let seen = f64::from(luminance(photo.pixels()[index] * scale));
                let shown = f64::from(luminance(recovery.rerendered.pixels()[index]));
                let noise = f64::from(recovery.noise.pixels()[index]);
                squares += (seen - shown).powi(2) - noise * noise;
                level += seen * seen;
            }
        }
        if level > 0.0 { (squares.max(0.0) / level).sqrt() } else { 0.0 }
    }
}
