//! Parts of a rendering: the exact sums of some of its samples, with what they are samples of.
//!
//! A part is an EXR file of whole numbers (`unrender_formats::planes`). Its channels R, G and B show
//! the picture so far; `sum_r_0` to `sum_b_3` and `squares_r_0` to `squares_b_3` are the sums of
//! [`Moments`] in four pieces of 32 bits, the lowest first; `count` and `faulty` are its counts. A
//! [`Head`] in JSON says what the samples are of, so that only what belongs together is added.

use crate::Error;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use unrender_formats::FileError;
use unrender_formats::planes::{self, Planes};
use unrender_render::{Moments, Tally};
use unrender_scene::Image;

/// What a rendering is of. Two parts with the same are samples of one picture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Identity {
    /// The version of this program.
    pub(crate) version: String,
    /// Fingerprint of the scene with its materials, lights and environment.
    pub(crate) scene: String,
    /// Fingerprint of the camera.
    pub(crate) camera: String,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) seed: u64,
    /// The most reflections of a path.
    pub(crate) bounces: u32,
    /// Whether pixels get as many samples as they are noisy.
    pub(crate) adaptive: bool,
}

/// What a part says of itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Head {
    pub(crate) identity: Identity,
    /// The numbers of its samples; with adaptive sampling, of a pixel of mean noise.
    pub(crate) samples: Range<u32>,
}

/// A part as it was read.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) path: PathBuf,
    pub(crate) head: Head,
    pub(crate) tally: Tally,
}

impl Identity {
    /// What differs between this rendering and `other`, in words.
    pub(crate) fn difference(&self, other: &Self) -> Option<String> {
        let of = |what: &str, mine: &dyn ToString, theirs: &dyn ToString| {
            let (mine, theirs) = (mine.to_string(), theirs.to_string());
            (mine != theirs).then(|| format!("{what} ({mine}, not {theirs})"))
        };
        let size = |i: &Self| format!("{} x {}", i.width, i.height);
        let sampling = |i: &Self| if i.adaptive { "adaptive" } else { "even" };
        of("another version of unrender", &self.version, &other.version)
            .or_else(|| of("another size", &size(self), &size(other)))
            .or_else(|| of("another seed", &self.seed, &other.seed))
            .or_else(|| of("another --bounces", &self.bounces, &other.bounces))
            .or_else(|| of("another kind of sampling", &sampling(self), &sampling(other)))
            .or_else(|| of("another camera", &self.camera, &other.camera))
            .or_else(|| of("another scene, materials or lights", &self.scene, &other.scene))
    }
}

const COLOURS: [char; 3] = ['r', 'g', 'b'];

/// Writes the samples of `tally`, which are what `head` says.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write(path: &Path, head: &Head, tally: &Tally) -> Result<(), Error> {
    let text = serde_json::to_string(head)
        .map_err(|error| FileError::new(path, format!("cannot be written: {error}")))?;
    let pixels = tally.moments().pixels();
    let mut channels = vec![
        ("count".to_owned(), pixels.iter().map(|m| m.count).collect()),
        ("faulty".to_owned(), pixels.iter().map(|m| m.faulty).collect()),
    ];
    for (colour, name) in COLOURS.into_iter().enumerate() {
        for piece in 0..4 {
            let cut = |sum: u128| (sum >> (32 * piece)) as u32;
            let sums = pixels.iter().map(|m| cut(m.sum[colour])).collect();
            let squares = pixels.iter().map(|m| cut(m.squares[colour])).collect();
            channels.push((format!("sum_{name}_{piece}"), sums));
            channels.push((format!("squares_{name}_{piece}"), squares));
        }
    }
    let (width, height) = tally.size();
    let planes = Planes { width, height, text, channels };
    Ok(planes::write(path, planes, &tally.mean())?)
}

/// Reads a part.
///
/// # Errors
/// If the file cannot be read or is no part.
pub(crate) fn read(path: &Path) -> Result<Part, Error> {
    let planes = planes::read(path)?;
    let foreign = |what: &str| FileError::new(path, format!("is no part of a rendering: {what}"));
    let head: Head = serde_json::from_str(&planes.text)
        .map_err(|error| foreign(&format!("its description cannot be understood ({error})")))?;
    if (head.identity.width, head.identity.height) != (planes.width, planes.height) {
        return Err(foreign("its size is not the one that it describes").into());
    }
    let mut moments = vec![Moments::default(); planes.width * planes.height];
    let mut each = |name: &str, set: &dyn Fn(&mut Moments, u32)| match planes.channel(name) {
        Some(numbers) => {
            moments.iter_mut().zip(numbers).for_each(|(m, number)| set(m, *number));
            Ok(())
        }
        None => Err(foreign(&format!("it lacks the channel {name}"))),
    };
    each("count", &|m, number| m.count = number)?;
    each("faulty", &|m, number| m.faulty = number)?;
    for (colour, name) in COLOURS.into_iter().enumerate() {
        for piece in 0..4 {
            let put = |number: u32| u128::from(number) << (32 * piece);
            each(&format!("sum_{name}_{piece}"), &|m, n| m.sum[colour] |= put(n))?;
            each(&format!("squares_{name}_{piece}"), &|m, n| m.squares[colour] |= put(n))?;
        }
    }
    let count = head.samples.end.checked_sub(head.samples.start);
    let told = |m: &Moments| head.identity.adaptive || Some(m.count) == count;
    if count.is_none() || !moments.iter().all(told) {
        return Err(foreign("its pixels do not have the samples that it describes").into());
    }
    let tally = Tally::from_moments(Image::new(planes.width, planes.height, moments));
    Ok(Part { path: path.to_owned(), head, tally })
}
