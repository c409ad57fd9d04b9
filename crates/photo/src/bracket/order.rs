//! Checks whether the stated exposures can be those of the frames.
//!
//! Whatever its response, a camera gives a longer exposure greater codes where nothing is clipped. So if mean codes
//! do not rise with the exposures, exposures were exchanged, or one frame was given twice. This is checked before
//! the response is fitted, since exposures in a wrong order give a meaningless response. Time: some ten thousand
//! pixels for each pair of frames.

use super::frame::Exposed;
use super::{BracketError, Frame};
use unrender_scene::{Depth, Rgb};

/// About this many pixels are compared per pair; far fewer would give means accurate enough for
/// exposures.
const PIXELS: usize = 20_000;
/// Frames with fewer common pixels are not compared.
const FEWEST: usize = 100;
/// Codes count where one of the two is above this share of the range: the black border of a picture is as bright in
/// all frames. At double of it dim rooms have too few pixels; at half of it borders with noise count.
const FLOOR: f32 = 0.02;
/// The logarithm of the mean code rises by at least this share of that of the exposure. A gamma of 2.2 gives 0.45,
/// curves for film about 0.2; two photographs of one exposure differ by flicker, some hundredths at most.
const RISE: f64 = 0.05;
/// Exposures that differ by less count as equal: times are rounded when they are written.
const EQUAL: f64 = 1.01;

/// Checks that the codes of `exposed` rise with the exposures of `frames`; `order` is by exposure.
///
/// # Errors
/// If two frames are the same picture, or one is as bright as another whose exposure is longer, or brighter.
pub(super) fn check(
    frames: &[Frame],
    exposed: &[Exposed<'_>],
    order: &[usize],
    black_level: Rgb,
) -> Result<(), BracketError> {
    for (place, &shorter) in order.iter().enumerate() {
        for &longer in &order[place + 1..] {
            let pair = [&exposed[shorter], &exposed[longer]];
            let Some(means) = means(pair, black_level) else { continue };
            let names = || [shorter, longer].map(|index| frames[index].name.clone());
            if pair[0].picture.values == pair[1].picture.values {
                let [first, second] = names();
                return Err(BracketError::Twice { first, second });
            }
            let ratio = pair[1].exposure / pair[0].exposure;
            if ratio < EQUAL {
                continue;
            }
            let (rise, least) = ((means[1] / means[0]).ln(), RISE * ratio.ln());
            let [shorter, longer] = names();
            if rise.abs() < least {
                return Err(BracketError::EquallyBright { shorter, longer, ratio });
            }
            if rise < 0.0 {
                let found = by_brightness(exposed);
                let listed = |order: &[usize]| {
                    let names = order.iter().map(|&index| frames[index].name.as_str());
                    names.collect::<Vec<_>>().join(", ")
                };
                let (found, stated) = (listed(&found), listed(order));
                return Err(BracketError::Order { shorter, longer, found, stated });
            }
        }
    }
    Ok(())
}

/// The mean codes above black of two frames, over pixels that both show well; none if these are too
/// few.
fn means(pair: [&Exposed<'_>; 2], black_level: Rgb) -> Option<[f64; 2]> {
    let floor = FLOOR * pair[0].top().max(pair[1].top());
    let count = pair[0].picture.values.pixels().len();
    let (mut sums, mut codes) = ([0.0; 2], 0);
    for index in (0..count).step_by((count / PIXELS).max(1)) {
        for channel in 0..3 {
            let code = pair.map(|frame| frame.code(index, channel) - black_level[channel]);
            let is_usable = pair.iter().all(|frame| frame.is_usable(index, channel));
            if is_usable && code[0].max(code[1]) > floor {
                sums.iter_mut().zip(code).for_each(|(sum, code)| *sum += f64::from(code.max(0.0)));
                codes += 1;
            }
        }
    }
    (codes >= FEWEST).then_some(sums)
}

/// The frames from the darkest to the brightest, by their mean code.
fn by_brightness(exposed: &[Exposed<'_>]) -> Vec<usize> {
    let mean = |frame: &Exposed<'_>| -> f64 {
        let pixels = frame.picture.values.pixels().iter();
        pixels.map(|code| f64::from(code.element_sum())).sum()
    };
    let means: Vec<f64> = exposed.iter().map(mean).collect();
    let mut order: Vec<usize> = (0..exposed.len()).collect();
    order.sort_by(|&a, &b| means[a].total_cmp(&means[b]));
    order
}

impl Exposed<'_> {
    /// The greatest code that a file of this kind can have; for floating-point files the greatest value in
    /// it.
    fn top(&self) -> f32 {
        match self.picture.depth {
            Depth::Float => {
                let pixels = self.picture.values.pixels().iter();
                pixels.map(|code| code.max_element()).fold(0.0, f32::max)
            }
            _ => 1.0,
        }
    }
}
