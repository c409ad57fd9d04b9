//! Parts of a rendering: the exact sums of some of its samples, with a description of the
//! rendering.
//!
//! A part is an EXR file of whole numbers (`unrender_formats::planes`). Its channels R, G and B show the
//! picture so far; `sum_r_0` to `sum_b_3` and `squares_r_0` to `squares_b_3` are the sums of
//! [`PixelAccumulator`] in four pieces of 32 bits, the lowest first; `count` and `faulty` are its counts. If
//! there are several layers, as for a composite, the second and later ones have theirs in `LAYER.count` and so
//! on, or in `layer NUMBER.count` where the name is not ASCII. A [`Head`] in JSON describes the rendering, so that only parts of one rendering are added.

use crate::Error;
use crate::fingerprint::fingerprint;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};
use unrender_formats::planes::{self, Planes};
use unrender_formats::{FileError, ascii_json};
use unrender_render::{Accumulator, PixelAccumulator};
use unrender_scene::{Camera, Image, Warnings};

/// The identity of a rendering. Two parts with the same one are samples of one picture.
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
    /// Whether noisier pixels get more samples.
    pub(crate) adaptive: bool,
    /// Whether neighbouring pixels share their paths.
    pub(crate) shared: bool,
}

/// The description of a part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Head {
    pub(crate) identity: Identity,
    /// The numbers of its samples; with adaptive sampling, those of a pixel of mean noise.
    pub(crate) samples: Range<u32>,
    /// The names of its layers.
    pub(crate) layers: Vec<String>,
}

impl Head {
    /// The prefix of the channels of each layer.
    fn prefixes(&self) -> impl Iterator<Item = String> + '_ {
        // The names of channels are ASCII.
        let later =
            self.layers.iter().enumerate().skip(1).map(|(index, layer)| match layer.is_ascii() {
                true => format!("{layer}."),
                false => format!("layer {index}."),
            });
        std::iter::once(String::new()).chain(later)
    }
}

/// A part that was read.
#[derive(Debug)]
pub(crate) struct Shard {
    pub(crate) path: PathBuf,
    pub(crate) head: Head,
    /// One for each layer.
    pub(crate) layers: Vec<Accumulator>,
}

impl Identity {
    /// The same with fingerprints, which distinguish it from renderings of other scenes or cameras.
    pub(crate) fn with_fingerprints(self, scene: &impl Serialize, camera: &Camera) -> Self {
        Self { scene: fingerprint(scene), camera: fingerprint(camera), ..self }
    }

    /// The difference between this rendering and `other`, in words.
    pub(crate) fn difference(&self, other: &Self) -> Option<String> {
        let of = |what: &str, mine: &dyn ToString, theirs: &dyn ToString| {
            let (mine, theirs) = (mine.to_string(), theirs.to_string());
            (mine != theirs).then(|| format!("{what} ({mine}, not {theirs})"))
        };
        let size = |i: &Self| format!("{} x {}", i.width, i.height);
        let sampling = |i: &Self| {
            let kind = if i.adaptive { "adaptive" } else { "uniform" };
            let sharing = if i.shared { "shared" } else { "independent" };
            format!("{kind}, {sharing}")
        };
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

/// Writes the samples of `layers`, which `head` describes.
///
/// # Errors
/// If the file cannot be written.
pub(crate) fn write(path: &Path, head: &Head, layers: &[Accumulator]) -> Result<(), Error> {
    let text = serde_json::to_string(head)
        .map(|text| ascii_json::escaped(&text))
        .map_err(|error| FileError::new(path, format!("cannot be written: {error}")))?;
    let mut channels = Vec::new();
    for (prefix, accumulator) in head.prefixes().zip(layers) {
        let pixels = accumulator.image().pixels();
        let mut add = |name: &str, of: &dyn Fn(&PixelAccumulator) -> u32| {
            channels.push((format!("{prefix}{name}"), pixels.iter().map(of).collect()));
        };
        add("count", &|m| m.count);
        add("faulty", &|m| m.faulty);
        for (colour, name) in COLOURS.into_iter().enumerate() {
            for piece in 0..4 {
                let cut = |sum: u128| (sum >> (32 * piece)) as u32;
                add(&format!("sum_{name}_{piece}"), &|m| cut(m.sum[colour]));
                add(&format!("squares_{name}_{piece}"), &|m| cut(m.squares[colour]));
            }
        }
    }
    let (width, height) = layers[0].size();
    let planes = Planes { width, height, text, channels };
    Ok(planes::write(path, planes, &layers[0].mean())?)
}

/// Reads a part.
///
/// # Errors
/// If the file cannot be read or is not a part.
pub(crate) fn read(path: &Path) -> Result<Shard, Error> {
    let planes = planes::read(path)?;
    let foreign =
        |what: String| FileError::new(path, format!("is not a part of a rendering: {what}"));
    let head: Head = serde_json::from_str(&planes.text)
        .map_err(|error| foreign(format!("its description is not valid ({error})")))?;
    if (head.identity.width, head.identity.height) != (planes.width, planes.height) {
        return Err(foreign("its size differs from its description".into()).into());
    }
    let layers: Vec<Accumulator> = head
        .prefixes()
        .map(|prefix| layer(&planes, &prefix))
        .collect::<Result<_, _>>()
        .map_err(foreign)?;
    let count = head.samples.end.checked_sub(head.samples.start);
    let is_complete = |m: &PixelAccumulator| head.identity.adaptive || Some(m.count) == count;
    // A picture to be denoised has half of its samples as a second layer.
    let is_part = |m: &PixelAccumulator| head.identity.adaptive || Some(m.count) <= count;
    let all = |layer: &Accumulator, of: &dyn Fn(&PixelAccumulator) -> bool| {
        layer.image().pixels().iter().all(of)
    };
    let (picture, others) = (&layers[0], &layers[1..]);
    let all_complete =
        all(picture, &is_complete) && others.iter().all(|other| all(other, &is_part));
    if count.is_none() || !all_complete {
        let problem = "the numbers of samples of its pixels differ from its description";
        return Err(foreign(problem.into()).into());
    }
    Ok(Shard { path: path.to_owned(), head, layers })
}

/// The sums of the layer whose channels begin with `prefix`, or an error.
fn layer(planes: &Planes, prefix: &str) -> Result<Accumulator, String> {
    let mut moments = vec![PixelAccumulator::default(); planes.width * planes.height];
    let mut each = |name: &str, set: &dyn Fn(&mut PixelAccumulator, u32)| {
        let name = format!("{prefix}{name}");
        let numbers = planes.channel(&name).ok_or(format!("it lacks the channel {name}"))?;
        moments.iter_mut().zip(numbers).for_each(|(m, number)| set(m, *number));
        Ok::<(), String>(())
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
    Ok(Accumulator::from_image(Image::new(planes.width, planes.height, moments)))
}

/// The samples of all parts in `paths`, in any order, as one part; with `allow_gaps`, samples
/// between them may be missing.
///
/// # Errors
/// If a part cannot be read, or if the parts are not of one rendering, overlap or leave gaps.
pub(crate) fn join(paths: &[PathBuf], allow_gaps: bool) -> Result<(Shard, Warnings), Error> {
    let mut sum: Option<Shard> = None;
    let mut ranges = Vec::new();
    for path in paths {
        let part = read(path)?;
        ranges.push((part.head.samples.clone(), path));
        match &mut sum {
            None => sum = Some(part),
            Some(sum) => add(sum, &part)?,
        }
    }
    let Some(mut sum) = sum else {
        return Err(Error::Request("there are no parts to merge".into()));
    };
    ranges.sort_by_key(|(samples, _)| (samples.start, samples.end));
    let mut warnings = Warnings::default();
    let mut end = 0;
    for (index, (samples, path)) in ranges.iter().enumerate() {
        if samples.start < end {
            let (before, other) = &ranges[index - 1];
            let problem = format!(
                "has the samples {}..{}, and {} has some of them too ({}..{}); leave one of the two out",
                samples.start,
                samples.end,
                other.display(),
                before.start,
                before.end
            );
            return Err(FileError::new(path, problem).into());
        }
        if samples.start > end {
            let gap = format!("the samples {end}..{} are in no part", samples.start);
            if !allow_gaps {
                let remedy = "render them, or merge the others by --allow-gaps";
                return Err(Error::Request(format!("{gap}; {remedy}")));
            }
            warnings.push(format!("{gap}; the picture was made without them"));
        }
        end = samples.end;
    }
    sum.head.samples = 0..ranges.iter().map(|(samples, _)| samples.end - samples.start).sum();
    Ok((sum, warnings))
}

/// Adds the samples of `part`, if both are of one rendering.
fn add(sum: &mut Shard, part: &Shard) -> Result<(), Error> {
    let problem = if part.head.layers != sum.head.layers {
        format!(
            "does not belong to {}: one of the two was made with --denoise, --layers, --aov or \
             --composite, the other without",
            sum.path.display()
        )
    } else if let Some(difference) = part.head.identity.difference(&sum.head.identity) {
        format!("does not belong to {}: it has {difference}", sum.path.display())
    } else if part.head.identity.adaptive {
        "was sampled adaptively, which is not possible in parts; it can only be merged alone".into()
    } else {
        sum.layers.iter_mut().zip(&part.layers).for_each(|(sum, part)| sum.add(part));
        return Ok(());
    };
    Err(FileError::new(&part.path, problem).into())
}
