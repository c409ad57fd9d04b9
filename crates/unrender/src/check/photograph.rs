//! Checks of the photograph, alone and against a grey rendering: codes that no camera writes,
//! brightness that no lamp here can cause.
//!
//!  - **Steps of 8 bits in a deeper file**: the file was made from an 8-bit picture, and likely has
//!    its encoding.
//!  - **Gaps in the histogram**: codes that never occur between frequent ones. Contrast or
//!    brightness were changed after the camera had written its codes.
//!  - **The slope** of the photograph over the light ([`mod@super::identifiability`]), which a wrong
//!    response bends.
//!  - **Brightness**: clipped, black, or far from what the lights can do on middle grey.

use super::finding::{Finding, Findings, Gravity};
use super::identifiability::Identifiability;
use super::{GREY, Subject};
use crate::project::ResponseChoice;
use unrender_formats::picture::{Depth, Picture};
use unrender_photo::{Exposure, Response, squares};
use unrender_recover::{PixelStatus, Role};
use unrender_scene::Rgb;
use unrender_scene::color::luminance;

/// Values are steps of 8 bits if all except this share of them are.
const OTHERS: f32 = 0.001;
/// How far a value may be from such a step: a tenth of a step of 16 bits, and rounding.
const STEP: f32 = 1e-6;
/// A code that never occurs is a gap if both of its neighbours occur at least this often.
const OFTEN: usize = 40;
/// This many gaps in a channel are not random.
const GAPS: usize = 4;
/// A photograph with this share of clipped or dark pixels causes a warning.
const CLIPPED: f32 = 0.05;
/// From this share on groups are lost. At half of it a room with a window is told of before each recovery, at double half of
/// the photograph is gone without a word.
const MANY: f32 = 0.3;
/// The mean of a photograph that is too dark, as a share of its white.
const DARK: f32 = 0.01;
/// Plausible slopes, with room for specular reflection and for roughly modelled lamps.
const SLOPES: [f32; 2] = [0.55, 1.8];
/// The share of the pixels, by groups, that have to say so. At a half a room with a smooth floor looks encoded; of all, one
/// group with a texture is enough to hide a wrong response.
const AGREE: f32 = 0.75;
/// Photograph and grey rendering agree up to this factor.
const FACTOR: f32 = 10.0;

/// Warnings of the photograph.
pub(super) fn warnings(subject: &Subject<'_>) -> Findings {
    let codes = &subject.job.picture;
    let graded =
        |gravity: Gravity, told: Option<String>| told.map(|told| Finding::new(gravity, told));
    // Codes of integers explain any slope and brightness.
    if let Some(sentence) = codes_of_integers(codes) {
        return [Finding::new(Gravity::All, sentence)]
            .into_iter()
            .chain(clipped(subject))
            .collect();
    }
    let all = [
        graded(Gravity::All, slope(subject)),
        graded(Gravity::All, brightness(subject)),
        graded(Gravity::Part, steps(subject, codes)),
        graded(Gravity::Part, gaps(codes)),
        graded(Gravity::All, too_dark(subject, codes)),
    ];
    all.into_iter().flatten().chain(clipped(subject)).collect()
}

/// The values of the pixels that have a measurement.
fn measured(codes: &Picture) -> impl Iterator<Item = Rgb> {
    let measured = codes.measured();
    let values = codes.values.pixels().iter().copied().enumerate();
    values.filter(move |(index, _)| measured.pixels()[*index]).map(|(_, value)| value)
}

/// The warning of floating-point values that are the codes of an integer picture.
fn codes_of_integers(codes: &Picture) -> Option<String> {
    if codes.depth != Depth::Float {
        return None;
    }
    let values = || measured(codes).flat_map(|value| value.to_array());
    let greatest = values().fold(0.0, f32::max);
    let is_code = |value: f32| value >= 0.0 && value.fract() == 0.0;
    let white = [255u16, u16::MAX].into_iter().find(|white| greatest <= f32::from(*white))?;
    // Zeros and ones are a drawing, which is right as it is.
    if greatest <= 1.0 || !values().all(is_code) {
        return None;
    }
    let bits = if white == 255 { 8 } else { 16 };
    Some(format!(
        "the photo's values look like codes of 0 to {white} of an integer picture: all are whole \
         numbers, the greatest {greatest}, in a floating-point picture, where white is 1. Use the \
         picture of {bits} bits itself (in Python an array of uint{bits}), or divide the values by \
         {white} and state the response, mostly \"srgb\""
    ))
}

/// The warning of a deep file with steps of 8 bits.
fn steps(subject: &Subject<'_>, codes: &Picture) -> Option<String> {
    if codes.depth == Depth::Eight {
        return None;
    }
    let values = || measured(codes).flat_map(|v| v.to_array());
    let is_step = |v: f32| {
        let code = 255.0 * v;
        (0.0..=255.5).contains(&code) && (code - code.round()).abs() < 255.0 * STEP
    };
    let others = values().filter(|&v| !is_step(v)).count();
    let varies = codes.values.pixels().windows(2).any(|w| w[0] != w[1]);
    if !varies || others as f32 > OTHERS * values().count() as f32 {
        return None;
    }
    let deep = if codes.depth == Depth::Float { "floating-point" } else { "16-bit" };
    let response = match subject.job.transfer.response {
        Response::Linear => "; if the response is that of the 8-bit picture, it is \"srgb\"",
        _ => "",
    };
    Some(format!(
        "the photo is a {deep} file, but all its values are steps of 8 bits: it was made from an \
         8-bit picture. Use the original{response}"
    ))
}

/// The warning of gaps in the histogram of an 8-bit file.
fn gaps(codes: &Picture) -> Option<String> {
    if codes.depth != Depth::Eight {
        return None;
    }
    let gaps = (0..3).map(|channel| {
        let mut histogram = [0usize; 256];
        for value in measured(codes) {
            histogram[(255.0 * value[channel]).round().clamp(0.0, 255.0) as usize] += 1;
        }
        let is_gap = |w: &&[usize]| w[1] == 0 && w[0] >= OFTEN && w[2] >= OFTEN;
        histogram.windows(3).filter(is_gap).count()
    });
    let gaps = gaps.max().unwrap_or(0);
    (gaps >= GAPS).then(|| {
        format!(
            "the photo's histogram has {gaps} gaps: its contrast or colours were changed after it \
             was taken, so that no simple response describes it. Use the picture as the camera \
             wrote it"
        )
    })
}

/// The warning of an implausible slope in most of the groups.
fn slope(subject: &Subject<'_>) -> Option<String> {
    if subject.job.project.response == Some(ResponseChoice::Auto) {
        return None;
    }
    let pixels = |g: usize| subject.observation.pixels_of_group[g].len();
    let slopes = subject.identifiabilities.iter().enumerate();
    let mut slopes: Vec<(f32, usize)> = slopes
        .filter_map(|(g, p)| p.and_then(|p| p.slope).map(|slope| (slope, pixels(g))))
        .collect();
    slopes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let all: usize = slopes.iter().map(|s| s.1).sum();
    let quantile = |share: f32| {
        let mut so_far = 0;
        let reached = slopes.iter().find(|(_, pixels)| {
            so_far += pixels;
            so_far as f32 >= share * all as f32
        });
        reached.map(|(slope, _)| *slope)
    };
    // A wrong response bends all groups; reflections bend some.
    let [low, high] = SLOPES;
    let [few, middle, most] = [quantile(1.0 - AGREE)?, quantile(0.5)?, quantile(AGREE)?];
    if most >= low && few <= high {
        return None;
    }
    let like = match (middle < low, &subject.job.transfer.response) {
        (true, Response::Linear) => "encoded; is the response \"srgb\"?",
        (true, _) => "encoded by a steeper curve than the response says.",
        (false, Response::Linear) => "decoded twice, or its contrast raised.",
        (false, _) => "linear already; is the response \"linear\"?",
    };
    Some(format!(
        "within groups the photo grows as the light to the power of {middle:.2} instead of 1, as if \
         it were {like} Lamps or objects that the model lacks could do that too"
    ))
}

fn clipped(subject: &Subject<'_>) -> Option<Finding> {
    let observation = subject.observation;
    let reflecting = (0..subject.specs.len()).filter(|&g| subject.specs[g].role != Role::Emitter);
    let (mut all, mut off) = (0usize, 0usize);
    let seen = (&subject.registered.camera, subject.geometry);
    let counts = subject.job.counts(0, seen);
    let measured =
        squares(&subject.job.picture.measured(), subject.job.side, |of| !of.contains(&false));
    let pixels = reflecting.flat_map(|g| &observation.all_pixels_of_group[g]);
    let counts = |pixel: usize| counts[pixel] && measured.pixels()[pixel];
    for &pixel in pixels.filter(|pixel| counts(**pixel as usize)) {
        all += 1;
        off += usize::from(observation.status.pixels()[pixel as usize] == PixelStatus::Clipped);
    }
    let share = off as f32 / all.max(1) as f32;
    let gravity = if share > MANY { Gravity::Part } else { Gravity::Note };
    let told = || {
        format!(
            "{:.0} % of the photo (lamps not counted) are clipped, beside a clipped pixel or in \
             the noise near black, and cannot be used: take a photo of another exposure",
            100.0 * share
        )
    };
    (share > CLIPPED).then(|| Finding::new(gravity, told()))
}

fn too_dark(subject: &Subject<'_>, codes: &Picture) -> Option<String> {
    codes.depth.max_code()?;
    let exposure = subject.job.transfer.exposure;
    let photo = &subject.job.photo;
    let measured = squares(&codes.measured(), subject.job.side, |of| !of.contains(&false));
    let pixels = photo.radiance.pixels().iter().zip(measured.pixels());
    let pixels = pixels.filter(|(_, measured)| **measured);
    let (sum, count) =
        pixels.fold((0.0, 0usize), |(sum, n), (r, _)| (sum + luminance(*r / exposure), n + 1));
    let mean = sum / count.max(1) as f32;
    (mean < DARK).then(|| {
        format!(
            "the photo is very dark, {:.2} % of white in the mean, where codes are coarse and \
             noise is large: take a longer exposure, or a raw picture developed to 16 bits",
            100.0 * mean
        )
    })
}

/// The brightness of the photograph relative to the grey scene, whose `identifiabilities` these are; none if
/// the photograph's brightness is not known.
pub(super) fn factor(
    subject: &Subject<'_>,
    identifiabilities: &[Option<Identifiability>],
) -> Option<f64> {
    let job = subject.job;
    if job.project.exposure == Exposure::Auto || !job.unknown_lights.is_empty() {
        return None;
    }
    let (mut photo, mut grey) = (0.0f64, 0.0f64);
    for (group, identifiability) in identifiabilities.iter().enumerate() {
        let pixels = subject.observation.pixels_of_group[group].len() as f64;
        if let Some(identifiability) = identifiability {
            photo += pixels * f64::from(identifiability.photo);
            grey += pixels * f64::from(identifiability.light * luminance(GREY));
        }
    }
    (grey > 0.0 && photo > 0.0).then_some(photo / grey)
}

/// The warning of a brightness far from that of the grey scene.
fn brightness(subject: &Subject<'_>) -> Option<String> {
    let factor = factor(subject, subject.identifiabilities)?;
    let [low, high] = [1.0 / f64::from(FACTOR), f64::from(FACTOR)];
    if (low..=high).contains(&factor) {
        return None;
    }
    Some(format!(
        "the photo is {} the scene in middle grey: the exposure, the strength of the lights or the \
         scene's units (point and spot lights depend on them) look wrong. If the exposure is not \
         known, say exposure = \"auto\" and give an [anchor]",
        if factor > 1.0 {
            format!("{factor:.0} times as bright as")
        } else {
            format!("{:.0} times darker than", 1.0 / factor)
        }
    ))
}
