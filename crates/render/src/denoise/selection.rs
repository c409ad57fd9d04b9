//! Selection: for every pixel the candidate of least error, estimated from the halves.
//!
//! With both halves `a`, `b` of a pixel and both filtered, `F(a)` and `F(b)`, whose mean is the result, the squared
//! error of the mean is estimated without bias by
//!
//! ```text
//! e = ((F(a) - b)^2 + (F(b) - a)^2) / 2 - (F(a) - F(b))^2 / 4 - (a - b)^2 / 2
//! ```
//!
//! since the noise of the halves is independent [Bitterli et al. 2016]. The first term is the squared error
//! of a filtered half and the variance of the other one, which the last term removes; the second is how much less
//! variance the mean of two has than one. For no filter, `F(a) = a`, this is `(a - b)^2 / 4`, the variance of the mean.

use super::filter::{Filtered, POWERS};
use super::signal::{Signal, boxed};
use unrender_scene::Rgb;

/// The candidates and no filter.
const CHOICES: usize = POWERS.len() + 1;
/// Errors are averaged over squares of this many pixels on either side: estimates of single pixels are all noise.
/// With half of it the choice is noisy, with double of it one choice is made for an edge and what is beside it.
const ERROR_RADIUS: usize = 4;
/// The choice is averaged over squares of this many pixels on either side, so that no seams show.
const BLEND_RADIUS: usize = 2;

/// Both halves after the choice, radiance without visible emission.
pub(super) struct Selected {
    pub(super) halves: [Vec<Rgb>; 2],
    /// The estimated squared error of the halves' mean, summed over channels: unbiased, and so negative in places.
    pub(super) error: Vec<f64>,
    /// The share of the picture that has no filter.
    pub(super) untouched: f64,
}

/// Chooses between the candidates of both halves.
pub(super) fn select(signal: &Signal, filtered: &[Filtered; 2]) -> Selected {
    let (width, height) = signal.size();
    let pixels = 0..width * height;
    let blend = shares(signal, filtered);
    let halves = [0, 1].map(|half| -> Vec<Rgb> {
        let at = |pixel: usize| {
            let term = |choice: usize| {
                candidate(signal, filtered, (half, choice, pixel)) * blend[choice][pixel] as f32
            };
            (0..CHOICES).map(term).sum::<Rgb>() * signal.reflectance[pixel]
        };
        pixels.clone().map(at).collect()
    });
    let left = |pixel: usize| {
        let reflectance = signal.reflectance[pixel];
        let of = |half: usize| (halves[half][pixel] / reflectance, signal.halves[half].at(pixel));
        error(of(0), of(1), reflectance)
    };
    let error = pixels.clone().map(left).collect();
    let untouched = blend[CHOICES - 1].iter().sum::<f64>() / pixels.len().max(1) as f64;
    Selected { halves, error, untouched }
}

/// The signal of a half, a choice and a pixel.
fn candidate(
    signal: &Signal,
    filtered: &[Filtered; 2],
    (half, choice, pixel): (usize, usize, usize),
) -> Rgb {
    let filtered = filtered[half].get(choice).map(|values| values[pixel]);
    filtered.unwrap_or_else(|| signal.halves[half].at(pixel))
}

/// The share of each choice in each pixel; they add up to one.
fn shares(signal: &Signal, filtered: &[Filtered; 2]) -> [Vec<f64>; CHOICES] {
    let (width, height) = signal.size();
    let pixels = 0..width * height;
    // Errors are relative to the noise nearby, so that a bright edge does not decide for the pixels beside it.
    let noise = |pixel: usize| {
        let [a, b] = [0, 1].map(|half: usize| signal.halves[half].at(pixel));
        f64::from(((a - b) * signal.reflectance[pixel]).length_squared())
    };
    let noise = boxed(&pixels.clone().map(noise).collect::<Vec<_>>(), width, ERROR_RADIUS);
    let errors: [Vec<f64>; CHOICES] = std::array::from_fn(|choice| {
        let error = |pixel: usize| {
            let of = |half: usize| {
                let candidate = candidate(signal, filtered, (half, choice, pixel));
                (candidate, signal.halves[half].at(pixel))
            };
            error(of(0), of(1), signal.reflectance[pixel]) / noise[pixel].max(1e-30)
        };
        boxed(&pixels.clone().map(error).collect::<Vec<_>>(), width, ERROR_RADIUS)
    });
    let best: Vec<usize> = pixels
        .map(|pixel| {
            let by_error = |a: &usize, b: &usize| errors[*a][pixel].total_cmp(&errors[*b][pixel]);
            (0..CHOICES).min_by(by_error).unwrap_or(CHOICES - 1)
        })
        .collect();
    std::array::from_fn(|choice| {
        let is = |best: &usize| f64::from(u8::from(*best == choice));
        boxed(&best.iter().map(is).collect::<Vec<_>>(), width, BLEND_RADIUS)
    })
}

/// The squared error of the mean of two filtered halves, each given with what it was before, summed over channels.
fn error((filtered_a, a): (Rgb, Rgb), (filtered_b, b): (Rgb, Rgb), reflectance: Rgb) -> f64 {
    let squared = |x: Rgb, y: Rgb| f64::from(((x - y) * reflectance).length_squared());
    (squared(filtered_a, b) + squared(filtered_b, a)) / 2.0
        - squared(filtered_a, filtered_b) / 4.0
        - squared(a, b) / 2.0
}
