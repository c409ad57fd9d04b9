//! Exposure brackets: photographs of one scene by one camera at several exposures, merged into one picture
//! of linear values with their variances.
//!
//! 1. The codes must rise with the exposures (`order`); shifts between the frames are found and undone (`align`).
//! 2. The camera's response is fitted to pixels that several frames show (`debevec_malik`), unless it is
//!    known; a second method checks it (`mitsunaga_nayar`).
//! 3. The noise is measured on the differences between frames (`noise`).
//! 4. Motion is found (`ghosts`), and the frames are averaged with inverse variances (`combine`).
//! 5. What is doubtful is named (`doubts`).
//!
//! The unit of the result: 1 is the radiance of white (pixel value 1) in the reference frame, the one with
//! most pixels that are neither dark nor clipped. Time: proportional to pixels times frames; memory:
//! beside the frames some eight bytes for each of their pixels, and some forty for each pixel of the
//! result.

mod align;
mod combine;
mod debevec_malik;
mod doubts;
mod frame;
mod ghosts;
mod mitsunaga_nayar;
mod noise;
mod order;
mod patches;
mod scale;

use crate::{Curve, Response};
use frame::Exposed;
pub use noise::NoiseModel;
use scale::Scale;
use unrender_scene::{Depth, Picture, Rgb};

/// One photograph of a bracket.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Its name in messages.
    pub name: String,
    /// Its code values.
    pub picture: Picture,
    /// Its exposure, in any unit that all frames share: exposure time, times gain, divided by the square of
    /// the f-number.
    pub exposure: f64,
    /// The sensor's gain, in any unit that all frames share: the ISO number, or 1.
    pub gain: f64,
}

/// Prior knowledge of the frames beside their exposures.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The camera's response; if none, floating-point frames are linear, and that of others is
    /// fitted.
    pub response: Option<Response>,
    /// The code of no light, by channel.
    pub black_level: Rgb,
    /// The code from which on a frame is clipped, by channel; infinite if only the file's range limits
    /// it.
    pub white_level: Rgb,
}

impl Default for Settings {
    fn default() -> Self {
        Self { response: None, black_level: Rgb::ZERO, white_level: Rgb::INFINITY }
    }
}

/// A merged bracket.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Bracket {
    /// Linear values with their variances; colours as the frames declare them.
    pub picture: Picture,
    /// The response by which the frames were made linear.
    pub response: Response,
    /// The report.
    pub report: Report,
}

/// Results of the steps of merging. Lists have an entry for each frame, in the order given.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// The frame whose white is 1, and to which the others are aligned.
    pub reference: usize,
    /// The place in each frame that shows what the reference shows at (0, 0): columns to the right,
    /// rows down.
    pub shifts: Vec<[i32; 2]>,
    /// The share of the pixels at which the frame was left out because something moved.
    pub ghosts: Vec<f64>,
    /// The share of the pixels at which some frame was left out because something moved.
    pub moved: f64,
    /// The share of the pixels that are clipped in every frame, in some channel.
    pub clipped: f64,
    /// The brightness of each frame relative to its exposure and the next longer frame: about 1.
    pub brightness: Vec<f64>,
    /// The noise, if the frames show it.
    pub noise: Option<NoiseModel>,
    /// The fit of the response, if it was fitted.
    pub fit: Option<ResponseFit>,
}

/// A response that was fitted to a bracket.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ResponseFit {
    /// The codes of the rows, 0 to 1, ascending.
    pub codes: Vec<f64>,
    /// Their linear values by channel, ascending; the middle code is grey, and the code 1 has a value of
    /// about 1.
    pub linear: [Vec<f64>; 3],
    /// The codes between which frames show the same things at two exposures; beyond them the curve is
    /// extrapolated.
    pub covered: [f64; 2],
    /// The largest difference to the polynomial of Mitsunaga and Nayar between those codes, of white.
    pub disagreement: f64,
}

/// Why frames cannot be merged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BracketError {
    /// Too few frames.
    #[error("a bracket has two frames at least, and there is {0}; name all photographs of it")]
    OneFrame(usize),
    /// An exposure that is not a positive number.
    #[error("the exposure of {name} is {exposure}; it must be a positive number")]
    Exposure {
        /// The frame.
        name: String,
        /// Its exposure.
        exposure: f64,
    },
    /// No two exposures differ.
    #[error(
        "all frames have the same exposure; a bracket has different ones: check their times, or give \
         one photograph alone"
    )]
    EqualExposures,
    /// Frames of different sizes.
    #[error(
        "{other} has {} x {} pixels, but {first} has {} x {}; frames of a bracket are of one size, not cropped",
        sizes[1].0, sizes[1].1, sizes[0].0, sizes[0].1
    )]
    Sizes {
        /// The first frame.
        first: String,
        /// The one that differs.
        other: String,
        /// The sizes of both, pixels.
        sizes: [(usize, usize); 2],
    },
    /// Frames of different kinds of pixels or colours.
    #[error(
        "{other} has {what} than {first}; frames of a bracket are written by one camera in the same way"
    )]
    Kinds {
        /// The first frame.
        first: String,
        /// The one that differs.
        other: String,
        /// What differs.
        what: &'static str,
    },
    /// One picture twice.
    #[error("{first} and {second} are the same picture; name each photograph of the bracket once")]
    Twice {
        /// One of them.
        first: String,
        /// The other one.
        second: String,
    },
    /// Different exposures of equally bright frames.
    #[error(
        "{longer} is as bright as {shorter}, but its exposure is stated to be {ratio:.1} times as long; \
         check the exposure times and give each photograph its own"
    )]
    EquallyBright {
        /// The frame with the shorter exposure.
        shorter: String,
        /// The one with the longer exposure.
        longer: String,
        /// The ratio of their exposures, above 1.
        ratio: f64,
    },
    /// Exposures in another order than the frames.
    #[error(
        "{longer} is darker than {shorter}, but its exposure is stated to be longer. From dark to bright \
         the photographs are {found}; by their exposures they are {stated}. Give each photograph its own \
         exposure time, in the order of the photographs"
    )]
    Order {
        /// The frame with the shorter exposure, which is brighter.
        shorter: String,
        /// The one with the longer exposure.
        longer: String,
        /// All frames, from the darkest to the brightest.
        found: String,
        /// All frames, from the shortest exposure to the longest.
        stated: String,
    },
    /// No response can be fitted.
    #[error(
        "too few places are well exposed in two frames to find the camera's response: {0}, and \
         {needed} are needed; take exposures that are closer to each other, or state the \
         response",
        needed = patches::FEWEST
    )]
    Response(usize),
    /// All places are equally bright.
    #[error(
        "the frames show too few different brightnesses to find the camera's response; state the response, or take \
         a bracket of something with bright and dark surfaces"
    )]
    Undetermined,
}

/// Merges `frames`.
///
/// ```
/// use unrender_photo::Response;
/// use unrender_photo::bracket::{Frame, Settings, merge};
/// use unrender_scene::{Depth, Image, Picture, Rgb};
///
/// // A ramp whose bright end only the short exposure shows.
/// let frame = |name: &str, exposure: f32| {
///     let values = Image::from_fn(64, 8, |x, _| Rgb::splat(exposure * x as f32 / 32.0));
///     let picture = Picture::new(values, Depth::Float);
///     Frame { name: name.to_owned(), picture, exposure: exposure.into(), gain: 1.0 }
/// };
/// let settings = Settings { white_level: Rgb::splat(1.0), ..Settings::default() };
/// let merged = merge(&[frame("short", 0.25), frame("long", 1.0)], &settings)?;
/// let unit = merged.picture.values.at(16, 4).x / 0.5;
/// assert!((merged.picture.values.at(60, 4).x / unit - 60.0 / 32.0).abs() < 1e-3);
/// # Ok::<(), unrender_photo::bracket::BracketError>(())
/// ```
///
/// # Errors
/// If there are fewer than two frames, or they differ in size or kind; if an exposure is not a positive
/// number, or all are equal; if the frames contradict these exposures; or if no response can be fitted.
pub fn merge(frames: &[Frame], settings: &Settings) -> Result<Bracket, BracketError> {
    check(frames)?;
    let reference = reference(frames, settings);
    let mut exposed: Vec<Exposed<'_>> =
        frames.iter().map(|frame| Exposed::new(frame, settings, &frames[reference])).collect();
    // From the shortest exposure to the longest; equal ones as they were given.
    let mut order: Vec<usize> = (0..frames.len()).collect();
    order.sort_by(|&a, &b| exposed[a].exposure.total_cmp(&exposed[b].exposure));
    order::check(frames, &exposed, &order, settings.black_level)?;
    let shifts = align::shifts(&exposed, &order, reference);
    for (frame, shift) in exposed.iter_mut().zip(&shifts) {
        frame.shift = *shift;
    }
    let depth = frames[0].picture.depth;
    let (response, fit) = match (&settings.response, depth) {
        (Some(response), _) => (response.clone(), None),
        (None, Depth::Float) => (Response::Linear, None),
        (None, _) => {
            let (response, fit) = fit_response(&exposed, settings.black_level)?;
            (response, Some(fit))
        }
    };
    let scale = Scale::new(&response, settings.black_level, depth);
    let overlaps = noise::overlaps(&exposed, &order, &scale);
    let measured = noise::measure(&overlaps);
    let brightness = noise::brightness(&overlaps, &order);
    let noise = measured.unwrap_or(noise::USUAL);
    let ghosts = ghosts::find(&exposed, &order, reference, &scale, &noise);
    let combined = combine::combine(&exposed, &order, &ghosts, &scale, &noise);
    let profile = frames[0].picture.profile.clone();
    let report = Report {
        reference,
        shifts,
        moved: ghosts.share_of_any(),
        ghosts: ghosts.shares(),
        clipped: combined.clipped,
        brightness,
        noise: measured,
        fit,
    };
    Ok(Bracket { picture: Picture { profile, ..combined.picture }, response, report })
}

fn check(frames: &[Frame]) -> Result<(), BracketError> {
    let [first, others @ ..] = frames else { return Err(BracketError::OneFrame(0)) };
    if others.is_empty() {
        return Err(BracketError::OneFrame(1));
    }
    let size = |frame: &Frame| (frame.picture.values.width(), frame.picture.values.height());
    let primaries = |frame: &Frame| frame.picture.profile.as_ref().and_then(|p| p.srgb_from_file);
    for other in others {
        let names = || (first.name.clone(), other.name.clone());
        if size(first) != size(other) {
            let (first_name, name) = names();
            let sizes = [size(first), size(other)];
            return Err(BracketError::Sizes { first: first_name, other: name, sizes });
        }
        let depths = first.picture.depth != other.picture.depth;
        if depths || primaries(first) != primaries(other) {
            let what = if depths { "another kind of pixels" } else { "other colours" };
            let (first, other) = names();
            return Err(BracketError::Kinds { first, other, what });
        }
    }
    for frame in frames {
        let good = |value: f64| value.is_finite() && value > 0.0;
        if !good(frame.exposure) || !good(frame.gain) {
            let (name, exposure) = (frame.name.clone(), frame.exposure);
            return Err(BracketError::Exposure { name, exposure });
        }
    }
    // Times are rounded when they are written, and the smallest step of a camera is 26 %.
    let equal = |frame: &Frame| (frame.exposure / first.exposure).ln().abs() < 0.01;
    if others.iter().all(equal) { Err(BracketError::EqualExposures) } else { Ok(()) }
}

/// Codes between which a pixel counts as well exposed for the choice of the reference frame. Only their
/// count matters: at 0.05 and 0.95 the same frames are chosen in all tests.
const WELL_EXPOSED: [f32; 2] = [0.1, 0.9];

/// The frame with most pixels that are well exposed in all channels; that with the middle exposure of
/// equal ones. Floating-point values have no range, so for them it is the middle one.
fn reference(frames: &[Frame], settings: &Settings) -> usize {
    let mut order: Vec<usize> = (0..frames.len()).collect();
    order.sort_by(|&a, &b| frames[a].exposure.total_cmp(&frames[b].exposure));
    let middle = order.len() / 2;
    let [low, high] = WELL_EXPOSED.map(Rgb::splat);
    let top = settings.white_level.min(Rgb::ONE);
    let is_good = |code: &&Rgb| code.cmpge(low * top).all() && code.cmple(high * top).all();
    let count = |index: usize| match frames[index].picture.depth {
        Depth::Float => 0,
        _ => frames[index].picture.values.pixels().iter().filter(is_good).count(),
    };
    let key = |place: usize| (count(order[place]), std::cmp::Reverse(place.abs_diff(middle)));
    let best = (0..order.len()).max_by_key(|&place| key(place)).unwrap_or(middle);
    order[best]
}

/// The response of the camera that took all frames, and the fit.
fn fit_response(
    exposed: &[Exposed<'_>],
    black_level: Rgb,
) -> Result<(Response, ResponseFit), BracketError> {
    let samples = patches::samples(exposed, black_level);
    let fewest = samples.iter().map(Vec::len).min().unwrap_or(0);
    if fewest < patches::FEWEST {
        return Err(BracketError::Response(fewest));
    }
    let covered = patches::covered(&samples);
    let codes: Vec<f64> = (0..=255).map(|k| f64::from(k) / 255.0).collect();
    let mut disagreement: f64 = 0.0;
    let found = samples.each_ref().map(|samples| {
        let (values, kept) = debevec_malik::fit(samples)?;
        let still = samples.iter().zip(kept).filter(|(_, kept)| *kept).map(|(sample, _)| sample);
        let other = mitsunaga_nayar::fit(&still.collect::<Vec<_>>());
        let differs = mitsunaga_nayar::disagreement(&other, &codes, &values, covered);
        disagreement = disagreement.max(differs);
        Some(values)
    });
    let [Some(red), Some(green), Some(blue)] = found else {
        return Err(BracketError::Undetermined);
    };
    let fitted = [red, green, blue];
    // The unit of each channel is arbitrary: as in the paper, the middle code is grey. White is extrapolated,
    // and scaled to 1 in the mean of the channels.
    let middle = codes.len() / 2;
    let unit = fitted.iter().map(|values| values[middle]).sum::<f64>() / 3.0;
    let linear = fitted.map(|values| {
        let factor = unit / values[middle];
        values.iter().map(|value| factor * value).collect::<Vec<f64>>()
    });
    let response = Response::measured(linear.each_ref().map(|values| Curve::new(&codes, values)));
    Ok((response, ResponseFit { codes, linear, covered, disagreement }))
}
