//! The error of a group: how far the re-rendering with its material is from the photograph, and whether that is too far.
//!
//! With two independent renderings A and B of two neighbouring pixels 1 and 2, the product `(P1 - A1)(P2 - B2)` has the
//! mean of the product of their errors: a pixel's own noise is in neither of the factors of the other, so that neither the
//! renderings' nor the photograph's is in the mean, however large they are, and none of them has to be known. What is
//! wrong with a model changes little from one pixel to the next, but for patterns as fine as pixels. Some pairs of the
//! group are rendered for that, with as many paths as it takes until noise hides no error that would matter.

use crate::compare::CERTAIN;
use crate::compare::residual::deviation_of_sum;
use crate::guess::Guess;
use crate::problem::{Options, Role};
use crate::streams::Stream;
use glam::DVec3;
use std::collections::BTreeMap;
use unrender_render::Settings;
use unrender_render::sampler::mix;
use unrender_scene::Rgb;

/// The error of a group that is no lamp; zero for lamps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroupError {
    /// As it is reported.
    pub(crate) squares: Squares,
    /// Whether it is certainly one that matters.
    is_wrong: bool,
}

/// Sums over the valid pixels of a group.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Squares {
    /// Of the squares of photograph minus re-rendering, without the noise of either.
    pub(crate) square: f64,
    /// The standard deviation of that.
    deviation: f64,
    /// Of the squares of the photograph.
    photo: f64,
}

/// A group is doubtful if its relative error is certainly above this: a reflectance of one half may then be off by 0.015,
/// and so may what the group lights. In drafts of twelve rooms nine groups are above it, six of them of a wrong hypothesis;
/// at double of it two of the six are not. Half of it was not tried.
const DOUBTFUL: f64 = 0.03;
/// And above this as it is reported, whatever its noise: nobody is told that a material which may be so far off is right.
/// By an earlier measure, in drafts of twelve rooms, 14 of 27 groups of a wrong hypothesis and 3 of 130 right ones were
/// above it, 17 and 21 above half of it, 4 and none above double.
const OPEN: f64 = 0.15;
/// An error is known well enough if the deviation of its square is the square of this: half of what is doubtful. At half of
/// it four times the paths are traced; double of it was not tried.
const KNOWN: f64 = 0.5 * DOUBTFUL;
/// At most so many pairs of the group are rendered. Of as many paths, fewer pairs with more paths
/// each know the error better, as its deviation falls with the paths of a pixel and only the root of the pairs. Half and
/// double of it were not tried.
const PAIRS: usize = 400;
/// Paths a pixel at first, which say how many more it takes; a draft has half of it. Half and double of it were not
/// tried.
const SPP: u32 = 64;
/// So many times as many at most: without a limit a lamp that is hardly ever found would never end. Half and double of it
/// were not tried.
const MORE_MAX: f64 = 8.0;

impl GroupError {
    /// That of `group`, by the two halves of the last picture or, with options, by pairs that are rendered anew with as
    /// many paths as it takes, where these know it better. In the last picture neighbours may share paths, so that it says
    /// too little of its noise to be certain of anything.
    pub(crate) fn of(
        guess: &Guess<'_>,
        group: usize,
        halves: &[Vec<Rgb>; 2],
        options: Option<&Options>,
    ) -> Self {
        let pixels = &guess.observation.pixels_of_group[group];
        if guess.problem.groups[group].role == Role::Emitter || pixels.is_empty() {
            return Self::default();
        }
        let pairs = pairs(guess, pixels);
        let shown = |pixel: u32| halves.each_ref().map(|half| half[pixel as usize]);
        let last = Squares::over(&pairs, &photo(guess), &shown).times(pixels.len(), pairs.len());
        let Some(options) = options else {
            return Self { squares: last, is_wrong: false };
        };
        let chosen = some(&pairs, options.seed);
        let measured = measured(guess, group, &chosen, options).times(pixels.len(), chosen.len());
        let is_wrong = measured.is_wrong();
        let is_better = is_wrong || measured.relative() < last.relative();
        Self { squares: if is_better { measured } else { last }, is_wrong }
    }

    /// Why the material is not to be trusted, if too much of the group's light is left unexplained.
    pub(crate) fn doubt(&self) -> Option<String> {
        let error = self.squares.relative()?;
        if self.squares.is_of_black() {
            return Some(
                "the photograph is black where it shows it, and its re-rendering is not".into(),
            );
        }
        let most = if self.is_wrong { DOUBTFUL } else { OPEN };
        (error > most).then(|| {
            let [error, most] = [error, most].map(|share| 100.0 * share);
            format!("its error of {error:.1} % is more than {most:.0} % of its light")
        })
    }
}

impl Squares {
    /// Whether the error is certainly one that matters.
    fn is_wrong(&self) -> bool {
        self.square - CERTAIN * self.deviation > DOUBTFUL * DOUBTFUL * self.photo
    }

    /// The sums over `pairs` of pixels, of which each is `shown` twice, and by the photograph.
    fn over(
        pairs: &[[u32; 2]],
        photo: &dyn Fn(u32) -> DVec3,
        shown: &dyn Fn(u32) -> [Rgb; 2],
    ) -> Self {
        let mut products = Vec::with_capacity(pairs.len());
        let mut light = 0.0;
        for pair in pairs {
            let [one, two] =
                pair.map(|pixel| shown(pixel).map(|half| photo(pixel) - half.as_dvec3()));
            products.push(0.5 * (one[0].dot(two[1]) + one[1].dot(two[0])));
            light += 0.5 * pair.map(|pixel| photo(pixel).length_squared()).iter().sum::<f64>();
        }
        let (square, deviation) = (products.iter().sum(), deviation_of_sum(&products));
        Self { square, deviation, photo: light }
    }

    /// The sums over so many `pixels` by those over so many `pairs`.
    fn times(self, pixels: usize, pairs: usize) -> Self {
        let share = pixels as f64 / pairs.max(1) as f64;
        let Self { square, deviation, photo } = self;
        Self { square: share * square, deviation: share * deviation, photo: share * photo }
    }

    /// Whether the error is certainly none that matters.
    fn is_right(&self) -> bool {
        self.square + CERTAIN * self.deviation < DOUBTFUL * DOUBTFUL * self.photo
    }

    /// How many times as many paths it takes until noise hides no error that matters; one or less if it hides none. The
    /// deviation is that of a product of two noises, and falls with the paths.
    fn lacks(&self) -> f64 {
        let is_known = self.is_wrong() || self.is_right();
        if is_known { 0.0 } else { self.deviation / (KNOWN * KNOWN * self.photo) }
    }

    /// The relative root mean square; where it is not significant, its standard deviation; infinite where a radiance is no
    /// finite number, and where the re-rendering of what is black in the photograph is not. None where both are, and where no
    /// pixel shows the group.
    pub(crate) fn relative(&self) -> Option<f64> {
        let square = self.square.max(self.deviation).max(0.0);
        let square = if self.square.is_finite() { square } else { f64::INFINITY };
        (self.photo > 0.0 || square > 0.0).then(|| (square / self.photo).sqrt())
    }

    /// Whether the photograph is black where it shows the group.
    fn is_of_black(&self) -> bool {
        self.photo <= 0.0
    }

    /// The share of the squared error `whole`.
    pub(crate) fn share_of(&self, whole: f64) -> Option<f64> {
        (self.photo > 0.0 && whole > 0.0).then(|| self.square.max(0.0) / whole)
    }
}

/// The error over `pairs` of the pixels of `group`, with as many paths as show one that matters, if any number does.
fn measured(guess: &Guess<'_>, group: usize, pairs: &[[u32; 2]], options: &Options) -> Squares {
    let mut pixels: Vec<u32> = pairs.as_flattened().to_vec();
    pixels.sort_unstable();
    pixels.dedup();
    let place: BTreeMap<u32, usize> = pixels.iter().enumerate().map(|(i, p)| (*p, i)).collect();
    let rendered = |spp: u32| {
        let halves = [0, 1].map(|half| {
            let settings = Settings {
                spp,
                seed: Stream::GroupErrors.seed(options.seed) ^ (group as u64) << 8 ^ half,
                max_bounces: options.max_bounces,
                ..Settings::default()
            };
            guess.problem.renderer.rerender(guess.appearance(), &pixels, &settings)
        });
        let shown = |pixel: u32| halves.each_ref().map(|half| half[place[&pixel]]);
        Squares::over(pairs, &photo(guess), &shown)
    };
    let spp = options.effort.samples(SPP);
    let first = rendered(spp);
    let more = first.lacks().min(MORE_MAX);
    if more > 1.0 { rendered((more * f64::from(spp)).ceil() as u32) } else { first }
}

/// What the photograph shows of a pixel, as radiance.
fn photo(guess: &Guess<'_>) -> impl Fn(u32) -> DVec3 {
    |pixel| (guess.exposure * guess.value(pixel as usize)).as_dvec3()
}

/// Each of `pixels` with its neighbours to the right and below, of the same object in the same photograph; with itself
/// where there are no such pairs, so that noise counts as an error.
fn pairs(guess: &Guess<'_>, pixels: &[u32]) -> Vec<[u32; 2]> {
    let (geometry, sheet) = (guess.problem.renderer.geometry(), &guess.observation.sheet);
    let width = geometry.width() as u32;
    let at = |pixel: u32| (geometry.pixels()[pixel as usize].object, sheet.photograph_of(pixel));
    let beside = |&pixel: &u32| {
        let is_last = (pixel + 1) % width == 0;
        let others = [(!is_last).then_some(pixel + 1), Some(pixel + width)];
        let others = others.into_iter().flatten();
        others
            .filter(move |other| pixels.binary_search(other).is_ok() && at(*other) == at(pixel))
            .map(move |other| [pixel, other])
    };
    let all: Vec<[u32; 2]> = pixels.iter().flat_map(beside).collect();
    if all.is_empty() { pixels.iter().map(|pixel| [*pixel; 2]).collect() } else { all }
}

/// At most [`PAIRS`] of `pairs`, spread over all of them.
fn some(pairs: &[[u32; 2]], seed: u64) -> Vec<[u32; 2]> {
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    order.sort_by_key(|i| mix(seed ^ (*i as u64) << 20));
    order.truncate(PAIRS);
    order.into_iter().map(|i| pairs[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::{GroupError, Squares};
    use glam::DVec3;
    use unrender_render::sampler::mix;
    use unrender_scene::Rgb;

    /// The error that is measured of 2000 pixels side by side which are off by `error`, where the photograph and both
    /// renderings have noise of this standard deviation.
    fn measured(error: impl Fn(u32) -> f32, noise: f32) -> Squares {
        let scatter = |stream: u64, pixel: u32| {
            let uniform = (mix(stream ^ u64::from(pixel) << 8) >> 40) as f32 / (1u64 << 23) as f32;
            noise * 3f32.sqrt() * (uniform - 1.0)
        };
        let photo = |pixel: u32| DVec3::splat(f64::from(1.0 + scatter(1, pixel)));
        let shown =
            |pixel: u32| [2, 3].map(|half| Rgb::splat(1.0 - error(pixel) + scatter(half, pixel)));
        let pairs: Vec<[u32; 2]> = (0..2000).map(|pixel| [pixel, pixel + 1]).collect();
        Squares::over(&pairs, &photo, &shown)
    }

    #[test]
    fn an_error_is_measured_without_the_noise_of_the_photograph_or_the_renderings() {
        let wave = |pixel: u32| 0.05 * 2f32.sqrt() * (0.1 * pixel as f32).sin();
        for noise in [0.0, 0.1] {
            let none = measured(|_| 0.0, noise);
            assert!(none.square.abs() <= 3.0 * none.deviation + 1e-9, "{none:?}");
            let error = measured(wave, noise);
            let relative = error.relative().unwrap();
            assert!(
                (relative - 0.05).abs() < 0.002 + 0.05 * f64::from(noise),
                "{relative} beside {noise}"
            );
            assert!(error.is_wrong());
        }
    }

    fn doubt(square: f64, deviation: f64) -> Option<String> {
        let squares = Squares { square, deviation, photo: 1.0 };
        GroupError { squares, is_wrong: squares.is_wrong() }.doubt()
    }

    #[test]
    fn a_small_error_that_noise_leaves_open_is_no_reason_to_doubt() {
        // A twentieth of the light, and that is certain.
        assert!(doubt(0.0025, 0.0005).unwrap().contains("5.0 % is more than 3 %"));
        // The same in a picture so noisy that it is not significant.
        assert_eq!(doubt(0.0025, 0.001), None);
        // An error that is explained.
        assert_eq!(doubt(0.0001, 0.00001), None);
        assert_eq!(doubt(-0.002, 0.001), None, "by chance");
    }

    #[test]
    fn what_is_black_in_the_photograph_alone_is_doubted() {
        let doubt = |square, deviation| {
            let squares = Squares { square, deviation, photo: 0.0 };
            GroupError { squares, is_wrong: squares.is_wrong() }.doubt()
        };
        assert_eq!(doubt(0.0, 0.0), None, "both are black, or no pixel shows it");
        for (square, deviation) in [(0.01, 0.001), (0.0, 0.01), (f64::NAN, 0.0)] {
            assert!(doubt(square, deviation).unwrap().contains("black"));
        }
    }

    #[test]
    fn an_error_that_is_reported_as_large_is_doubted_whatever_its_noise() {
        assert!(doubt(0.03, 0.02).is_some());
        assert!(doubt(0.0, 0.04).is_some(), "it is reported as 20 %");
        assert!(doubt(f64::NAN, 0.0).is_some() && doubt(f64::INFINITY, 0.001).is_some());
        assert!(doubt(0.015, 0.015).is_none());
    }
}
