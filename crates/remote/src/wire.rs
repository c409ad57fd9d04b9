//! Requests, shared data and answers as bytes. Small structured data is written by `postcard`; long
//! lists of numbers as their bits, little-endian, four bytes a number.

use glam::Vec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use unrender_render::{
    Accumulator, Appearance, Incident, Mirrored, Parameter, Probe, ProbeSettings, Probes, Settings,
};
use unrender_scene::{Camera, Material, Rgb, Scene};

/// A request to a worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Request {
    /// The light that arrives behind these pixels.
    Probe(Vec<u32>, ProbeSettings),
    /// The radiance of these pixels, each by the paths of these numbers, and its derivatives.
    Jacobian(Vec<(u32, Range<u32>)>, Vec<Parameter>, Settings),
    /// The same on paths that were drawn from other materials, with the settings' sample numbers.
    Replay(Vec<u32>, [Vec<Parameter>; 2], Settings),
    /// The radiance of these pixels.
    Radiance(Vec<u32>, Settings),
    /// The sums of the samples of these numbers, of all pixels.
    Samples(Range<u32>, Settings),
}

/// What a worker is built from.
#[derive(Deserialize)]
pub(super) struct Setup {
    pub(super) scene: Scene,
    pub(super) camera: Camera,
    pub(super) size: (usize, usize),
}

/// The scene's appearance, and that from which replayed paths are drawn: materials, and factors on lights.
#[derive(Deserialize)]
pub(super) struct Appearances {
    pub(super) now: (Vec<Material>, Vec<Rgb>),
    pub(super) drawn: Option<(Vec<Material>, Vec<Rgb>)>,
}

/// [`Appearances`] as bytes.
pub(super) fn appearances(now: Appearance<'_>, drawn: Option<Appearance<'_>>) -> Vec<u8> {
    #[derive(Serialize)]
    struct Borrowed<'a> {
        now: (&'a [Material], &'a [Rgb]),
        drawn: Option<(&'a [Material], &'a [Rgb])>,
    }
    let drawn = drawn.map(|drawn| (drawn.materials, drawn.lights));
    encode(&Borrowed { now: (now.materials, now.lights), drawn })
}

/// A [`Setup`] as bytes.
pub(super) fn setup(scene: &Scene, camera: &Camera, size: (usize, usize)) -> Vec<u8> {
    #[derive(Serialize)]
    struct Borrowed<'a> {
        scene: &'a Scene,
        camera: &'a Camera,
        size: (usize, usize),
    }
    encode(&Borrowed { scene, camera, size })
}

/// Plain data as bytes.
pub(super) fn encode<T: Serialize>(value: &T) -> Vec<u8> {
    // Plain data of known lengths can always be written; no worker understands empty bytes.
    postcard::to_stdvec(value).unwrap_or_default()
}

/// Plain data from bytes.
pub(super) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

/// Writes numbers.
#[derive(Default)]
struct Writer(Vec<u8>);

impl Writer {
    fn number(&mut self, value: u32) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    fn vector(&mut self, value: Vec3) {
        value.to_array().into_iter().for_each(|v| self.number(v.to_bits()));
    }
}

/// Reads numbers; none at the end.
struct Reader<'a>(std::slice::ChunksExact<'a, u8>);

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self(bytes.chunks_exact(4))
    }

    fn number(&mut self) -> Option<u32> {
        let word = self.0.next()?;
        Some(u32::from_le_bytes(word.try_into().ok()?))
    }

    fn vector(&mut self) -> Option<Vec3> {
        let mut next = || self.number().map(f32::from_bits);
        Some(Vec3::new(next()?, next()?, next()?))
    }
}

/// Radiances as bytes.
pub(super) fn write_rgb<'a>(values: impl Iterator<Item = &'a Rgb>) -> Vec<u8> {
    let mut out = Writer::default();
    values.for_each(|value| out.vector(*value));
    out.0
}

/// `count` radiances from bytes.
pub(super) fn read_rgb(bytes: &[u8], count: usize) -> Option<Vec<Rgb>> {
    if bytes.len() != 12 * count {
        return None;
    }
    let mut input = Reader::new(bytes);
    (0..count).map(|_| input.vector()).collect()
}

/// Probes as bytes: their number, then the probes.
pub(super) fn write_probes(probes: &Probes) -> Vec<u8> {
    let words = 1 + 27 * probes.probes.len() + 6 * probes.incident.len();
    let mut out = Writer(Vec::with_capacity(4 * words));
    out.number(probes.probes.len() as u32);
    for probe in &probes.probes {
        let Probe { pixel, group, throughput, wo, point, emitted, diffuse, mirror, .. } = *probe;
        out.number(pixel);
        out.number(group);
        [throughput, wo, point, emitted, diffuse, mirror].iter().for_each(|v| out.vector(*v));
        out.number(u32::from(probe.mirrored.is_some()));
        let none = Mirrored { object: 0, point: Vec3::ZERO };
        let mirrored = probe.mirrored.unwrap_or(none);
        out.number(mirrored.object);
        out.vector(mirrored.point);
        out.number(probe.first);
        out.number(probe.count);
    }
    for incident in &probes.incident {
        out.vector(incident.wi);
        out.vector(incident.irradiance);
    }
    out.0
}

/// Probes from bytes.
pub(super) fn read_probes(bytes: &[u8]) -> Option<Probes> {
    let mut input = Reader::new(bytes);
    let count = input.number()? as usize;
    let incident = (bytes.len() / 4).checked_sub(1 + count.checked_mul(27)?)? / 6;
    let probes = (0..count).map(|_| read_probe(&mut input, incident)).collect::<Option<_>>()?;
    let one = |_| Some(Incident { wi: input.vector()?, irradiance: input.vector()? });
    Some(Probes { probes, incident: (0..incident).map(one).collect::<Option<_>>()? })
}

/// A probe whose samples are among the first `incident`.
fn read_probe(input: &mut Reader<'_>, incident: usize) -> Option<Probe> {
    let probe = Probe {
        pixel: input.number()?,
        group: input.number()?,
        throughput: input.vector()?,
        wo: input.vector()?,
        point: input.vector()?,
        emitted: input.vector()?,
        diffuse: input.vector()?,
        mirror: input.vector()?,
        mirrored: {
            let is_some = input.number()? != 0;
            let mirrored = Mirrored { object: input.number()?, point: input.vector()? };
            is_some.then_some(mirrored)
        },
        first: input.number()?,
        count: input.number()?,
    };
    let end = probe.first.checked_add(probe.count)?;
    (end as usize <= incident).then_some(probe)
}

/// The sums of all pixels as bytes: how many bytes a number has, then the numbers without leading
/// zeros.
pub(super) fn write_sums(sums: &Accumulator) -> Vec<u8> {
    let numbers = || sums.image().pixels().iter().flat_map(|pixel| pixel.sum);
    let largest = numbers().max().unwrap_or(0);
    let width = (16 - largest.leading_zeros() as usize / 8).max(1);
    let mut out = vec![width as u8];
    numbers().for_each(|number| out.extend_from_slice(&number.to_le_bytes()[..width]));
    out
}

/// The sums of `count` pixels from bytes.
pub(super) fn read_sums(bytes: &[u8], count: usize) -> Option<Vec<[u128; 3]>> {
    let (width, bytes) = bytes.split_first()?;
    let width = usize::from(*width);
    if !(1..=16).contains(&width) || bytes.len() != 3 * count * width {
        return None;
    }
    let number = |bytes: &[u8]| {
        let mut number = [0; 16];
        number[..width].copy_from_slice(bytes);
        u128::from_le_bytes(number)
    };
    let pixel = |bytes: &[u8]| [0, 1, 2].map(|c| number(&bytes[c * width..(c + 1) * width]));
    Some(bytes.chunks_exact(3 * width).map(pixel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_read_back_to_the_bit_and_false_ones_are_refused() {
        let v = |i: u32| Vec3::new(f32::from_bits(i), -0.0, f32::from_bits(0x7FC0_0001 + i));
        let probe = |i: u32| Probe {
            pixel: i,
            group: 2 * i,
            throughput: v(1),
            wo: v(2),
            point: v(3),
            emitted: v(4),
            diffuse: v(5),
            mirror: v(6),
            mirrored: (i == 1).then(|| Mirrored { object: 7, point: v(8) }),
            first: 2 * i,
            count: 2,
        };
        let incident = (0..4).map(|i| Incident { wi: v(i), irradiance: v(9 + i) }).collect();
        let probes = Probes { probes: vec![probe(0), probe(1)], incident };
        let bytes = write_probes(&probes);
        let read = read_probes(&bytes).unwrap();
        assert_eq!(write_probes(&read), bytes);
        assert_eq!(read.probes[1].mirrored.unwrap().object, 7);
        assert!(read.probes[0].mirrored.is_none());
        // Samples that are not there.
        assert!(read_probes(&bytes[..bytes.len() - 24]).is_none());
        assert!(read_probes(&bytes[..40]).is_none() && read_probes(&[]).is_none());
        assert!(read_probes(&[255; 8]).is_none());
    }

    #[test]
    fn sums_read_back_whatever_their_size() {
        for largest in [0, 1, 255, 256, 1 << 90, u128::MAX] {
            let mut sums = Accumulator::new(2, 1);
            sums.image_mut().pixels_mut()[1].sum = [largest, 3, 0];
            let bytes = write_sums(&sums);
            assert_eq!(read_sums(&bytes, 2).unwrap(), [[0; 3], [largest, 3, 0]]);
            assert!(read_sums(&bytes, 3).is_none());
        }
        assert!(read_sums(&[17], 0).is_none() && read_sums(&[], 0).is_none());
        assert!(read_rgb(&[0; 13], 1).is_none());
    }
}
