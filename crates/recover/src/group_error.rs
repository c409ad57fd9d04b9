//! The error of a group: how far the re-rendering with its material is from the photograph, and whether that is too far.
//!
//! With two independent renderings A and B of a pixel, the product `(P - A)(P - B)` has the mean of the squared error of
//! the photograph `P`, less its own noise, without the variance of either. Where the noise of the last picture hides an
//! error that would matter, some pixels of the group are rendered with more paths.

use crate::compare::CERTAIN;
use crate::compare::residual::deviation_of_sum;
use crate::guess::Guess;
use crate::observe::blocks::spread;
use crate::problem::{Options, Role};
use crate::streams::Stream;
use unrender_render::Settings;
use unrender_scene::Rgb;

/// Sums over the valid pixels of a group that is no lamp; zero for lamps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Squares {
    /// Of photograph minus re-rendering: the products of the two halves' residuals hold the error
    /// without the rendering's noise.
    pub(crate) error: f64,
    /// The standard deviation of that.
    deviation: f64,
    /// The variance of the photograph's and the re-rendering's noise.
    noise: f64,
    /// Of the photograph.
    photo: f64,
}

/// The error of a group, by the last picture, and as it is reported.
pub(crate) struct GroupError {
    last: Squares,
    /// By the last picture, too, or, where its noise hides the error, by more paths.
    pub(crate) measured: Squares,
}

/// A group is doubtful above this relative error, as it is reported, whatever the noise: nobody is told that a material
/// which is so far off is right. In drafts of twelve rooms 14 of 27 groups of a wrong hypothesis are above it, and 3 of 130
/// right ones; above half of it are 17 and 21, above double 4 and none.
const DOUBTFUL: f64 = 0.15;
/// And above this many times its noise, where the error counts less [`CERTAIN`] of its standard deviations: a noisy last
/// picture is no reason to doubt. At double of it, errors that anyone sees pass.
const TIMES_NOISE: f64 = 5.0;
/// Noise and model error together are at least this, relatively. At half of it, photographs without
/// noise make every group doubtful.
const NOISE_MIN: f64 = 0.006;
/// An error is known well enough if noise alone would look like one of this size: half of what is doubtful. Half of
/// it takes four times the paths; at double noise alone makes right groups doubtful.
const KNOWN: f64 = 0.5 * DOUBTFUL;
/// Where it is not, at most so many pixels of the group are rendered anew. Of as many paths, fewer pixels with more paths
/// each know the error better, as the rendering's part of its deviation falls with the paths of a pixel and only the root
/// of the pixels. At half of it the photograph's part is 1.4 times as large; double of it takes twice the paths.
const PIXELS: usize = 400;
/// Paths a pixel at first. Half of it is hardly more than the 16 of a draft's last picture; double of it wastes paths where
/// the photograph's noise decides.
const SPP: u32 = 32;
/// So many times as many paths each time that this helps. Half of it needs twice the rounds, double of it overshoots.
const MORE: u32 = 4;
/// Rounds at most: 512 paths a pixel in the end. Without a limit a lamp that is hardly ever found would never end.
const TIMES: u32 = 3;
/// More paths help if they lower the noise below this share: a quarter where it is the rendering's alone, all of it where
/// it is the photograph's.
const HELPS: f64 = 0.5;

impl GroupError {
    /// That of `group`, with the two halves of the last picture; with options, by more paths where that matters.
    pub(crate) fn of(
        guess: &Guess<'_>,
        group: usize,
        halves: &[Vec<Rgb>; 2],
        options: Option<&Options>,
    ) -> Self {
        if guess.problem.groups[group].role == Role::Emitter {
            let none = Squares { error: 0.0, deviation: 0.0, noise: 0.0, photo: 0.0 };
            return Self { last: none, measured: none };
        }
        let pixels = &guess.observation.pixels_of_group[group];
        let of_last = |pixel: u32| halves.each_ref().map(|half| half[pixel as usize]);
        let last = Squares::of(guess, group, pixels.iter().map(|&pixel| (pixel, of_last(pixel))));
        let options = options.filter(|_| !last.is_known());
        Self { last, measured: options.map_or(last, |options| measured(guess, group, options)) }
    }

    /// Why the material is not to be trusted, if too much of the group's light is left unexplained.
    pub(crate) fn doubt(&self) -> Option<String> {
        let error = self.measured.relative()?;
        let noise = self.last.relative_noise();
        if self.last.certain() > TIMES_NOISE * noise.max(NOISE_MIN) {
            return Some(format!(
                "its error of {:.1} % is not explained by noise ({:.1} %) and model error",
                100.0 * error,
                100.0 * noise
            ));
        }
        (error > DOUBTFUL).then(|| {
            format!(
                "its error of {:.1} % is more than {:.0} % of its light",
                100.0 * error,
                100.0 * DOUBTFUL
            )
        })
    }
}

/// The sums over a sample of the pixels of `group`, with as many paths as show an error that matters, if any number does.
fn measured(guess: &Guess<'_>, group: usize, options: &Options) -> Squares {
    let pixels = &guess.observation.pixels_of_group[group];
    let sample = spread(pixels, PIXELS, options.seed);
    let rendered = |time: u32| {
        let halves = [0, 1].map(|half| {
            let settings = Settings {
                spp: SPP * MORE.pow(time),
                seed: Stream::GroupErrors.seed(options.seed) ^ (group as u64) << 8 ^ half,
                max_bounces: options.max_bounces,
                ..Settings::default()
            };
            guess.problem.renderer.rerender(guess.appearance(), &sample, &settings)
        });
        let both = halves[0].iter().zip(&halves[1]).map(|(a, b)| [*a, *b]);
        Squares::of(guess, group, sample.iter().copied().zip(both))
    };
    let mut squares = rendered(0);
    for time in 1..TIMES {
        if squares.is_known() {
            break;
        }
        let before = squares.deviation;
        squares = rendered(time);
        if squares.deviation > HELPS * before {
            break;
        }
    }
    squares.times(pixels.len() as f64 / sample.len() as f64)
}

impl Squares {
    /// The sums over pixels of `group`, each re-rendered twice.
    fn of(
        guess: &Guess<'_>,
        group: usize,
        rendered: impl Iterator<Item = (u32, [Rgb; 2])>,
    ) -> Self {
        let mut squares = Self { error: 0.0, deviation: 0.0, noise: 0.0, photo: 0.0 };
        let mut products = Vec::new();
        for (pixel, [a, b]) in rendered {
            let photo = (guess.exposure * guess.value(pixel as usize)).as_dvec3();
            let noise = guess.observation.noise(group, pixel, guess.exposure);
            let noise = noise.variance(0.5 * (a + b)).as_dvec3();
            let [a, b] = [a, b].map(|half| half.as_dvec3());
            products.push(((photo - a) * (photo - b) - noise).element_sum());
            let rendering = 0.25 * (a - b) * (a - b);
            squares.noise += (noise + rendering).element_sum();
            squares.photo += (photo * photo).element_sum();
        }
        squares.error = products.iter().sum();
        squares.deviation = deviation_of_sum(&products);
        squares
    }

    /// The same over so many times as many pixels.
    fn times(self, share: f64) -> Self {
        let Self { error, deviation, noise, photo } = self;
        let [error, deviation] = [share * error, share * deviation];
        Self { error, deviation, noise: share * noise, photo: share * photo }
    }

    /// Whether noise hides no error that matters.
    fn is_known(&self) -> bool {
        self.deviation <= KNOWN * KNOWN * self.photo
    }

    /// The relative root mean square; where it is not significant, its standard deviation; infinite where a radiance is no
    /// finite number. None where no pixel shows the group.
    pub(crate) fn relative(&self) -> Option<f64> {
        let square = self.error.max(self.deviation).max(0.0);
        let square = if self.error.is_finite() { square } else { f64::INFINITY };
        (self.photo > 0.0).then(|| (square / self.photo).sqrt())
    }

    /// The relative error that is certainly there.
    fn certain(&self) -> f64 {
        ((self.error - CERTAIN * self.deviation).max(0.0) / self.photo).sqrt()
    }

    fn relative_noise(&self) -> f64 {
        (self.noise / self.photo).sqrt()
    }

    /// The share of the squared error `whole`.
    pub(crate) fn share_of(&self, whole: f64) -> Option<f64> {
        (self.photo > 0.0 && whole > 0.0).then(|| self.error.max(0.0) / whole)
    }
}

#[cfg(test)]
mod tests {
    use super::{GroupError, Squares};

    /// The squares of a group whose light is one, re-rendered with some noise.
    fn squares(error: f64, deviation: f64) -> Squares {
        Squares { error, deviation, noise: 0.0025, photo: 1.0 }
    }

    fn doubt(last: Squares, measured: Squares) -> Option<String> {
        GroupError { last, measured }.doubt()
    }

    #[test]
    fn a_small_error_that_noise_leaves_open_is_no_reason_to_doubt() {
        // Half of the photograph is unexplained, and that is certain.
        let certain = squares(0.25, 0.01);
        assert!(doubt(certain, certain).unwrap().contains("not explained by noise"));
        // A tenth of it, in a picture so noisy that this is not significant.
        let open = squares(0.0, 0.01);
        assert_eq!(open.relative(), Some(0.1));
        assert_eq!(doubt(open, open), None);
        // An error that is explained.
        assert_eq!(doubt(squares(0.01, 0.001), squares(0.01, 0.001)), None);
    }

    #[test]
    fn an_error_that_is_reported_as_large_is_doubted_whatever_its_noise() {
        let doubts = |error: f64, deviation| {
            let measured = squares(error * error, deviation);
            doubt(squares(0.0, 0.2), measured).is_some()
        };
        assert!(doubts(0.32, 0.001) && doubts(0.17, 0.001) && doubts(0.17, 0.02));
        assert!(doubts(0.0, 0.25), "it is reported as 50 %");
        assert!(doubts(f64::NAN, 0.0) && doubts(f64::INFINITY, 0.001), "it is no number");
        assert!(!doubts(0.14, 0.001));
    }
}
