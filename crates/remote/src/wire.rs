//! Requests, shared data and answers as bytes, by `postcard`: a floating-point number is four bytes, a whole number as
//! few as it needs. What a worker sends is looked at before it is used.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use unrender_render::{
    Accumulator, Appearance, Jacobian, Parameter, Probe, ProbeSettings, Probes, Settings,
};
use unrender_scene::{Camera, Material, Rgb, Scene};

/// A request to a worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Request {
    /// The light that arrives behind these pixels.
    Probe(Vec<u32>, ProbeSettings),
    /// The radiance of these pixels, each by the paths of these numbers, and its derivatives.
    Jacobian(Vec<(u32, Range<u32>)>, Vec<Parameter>, Settings),
    /// The same on paths that were drawn from other materials, of the settings' numbers.
    Replay(Vec<u32>, [Vec<Parameter>; 2], Settings),
    /// The radiance of these pixels.
    Radiance(Vec<u32>, Settings),
    /// The sums of the samples of these numbers, of all pixels.
    Samples(Range<u32>, Settings),
}

/// What a worker is made of.
#[derive(Deserialize)]
pub(super) struct Setup {
    pub(super) scene: Scene,
    pub(super) camera: Camera,
    pub(super) size: (usize, usize),
}

/// What the scene looks like, and what paths are drawn from that are replayed: materials, and factors on lights.
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
    // Plain data of known lengths can always be written; nothing is what no worker understands.
    postcard::to_stdvec(value).unwrap_or_default()
}

/// Plain data of bytes.
pub(super) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

/// Radiances from bytes, if they are `count`.
pub(super) fn radiances(bytes: &[u8], count: usize) -> Option<Vec<Rgb>> {
    decode(bytes).filter(|values: &Vec<Rgb>| values.len() == count)
}

/// A Jacobian from bytes, if it is of `count` pixels by so many parameters.
pub(super) fn jacobian(bytes: &[u8], count: usize, parameters: usize) -> Option<Jacobian> {
    decode(bytes).filter(|found: &Jacobian| {
        (found.radiance.len(), found.derivatives.len()) == (count, count * parameters)
    })
}

/// Probes from bytes, if all their samples are there.
pub(super) fn probes(bytes: &[u8]) -> Option<Probes> {
    let probes: Probes = decode(bytes)?;
    let is_whole = |probe: &Probe| {
        let end = probe.first.checked_add(probe.count);
        end.is_some_and(|end| end as usize <= probes.incident.len())
    };
    probes.probes.iter().all(is_whole).then_some(probes)
}

/// The sums of all pixels as bytes.
pub(super) fn of_sums(sums: &Accumulator) -> Vec<u8> {
    let all: Vec<[u128; 3]> = sums.image().pixels().iter().map(|pixel| pixel.sum).collect();
    encode(&all)
}

/// Sums from bytes, if they are of `count` pixels.
pub(super) fn sums(bytes: &[u8], count: usize) -> Option<Vec<[u128; 3]>> {
    decode(bytes).filter(|sums: &Vec<[u128; 3]>| sums.len() == count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use unrender_render::{Incident, Mirrored};

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
            straight: v(16),
            mirror: v(6),
            mirrored: (i == 1).then(|| Mirrored { object: 7, point: v(8) }),
            first: 2 * i,
            count: 2,
        };
        let incident = (0..4).map(|i| Incident { wi: v(i), irradiance: v(9 + i) }).collect();
        let mut all = Probes { probes: vec![probe(0), probe(1)], incident };
        let bytes = encode(&all);
        let read = probes(&bytes).unwrap();
        assert_eq!(encode(&read), bytes);
        assert_eq!(read.probes[1].mirrored.unwrap().object, 7);
        assert!(read.probes[0].mirrored.is_none());
        assert!(probes(&bytes[..bytes.len() - 24]).is_none());
        assert!(probes(&bytes[..40]).is_none() && probes(&[]).is_none());
        assert!(probes(&[255; 8]).is_none());
        // Samples that are not there, and more than can be.
        all.incident.pop();
        assert!(probes(&encode(&all)).is_none());
        all.probes[0].first = u32::MAX;
        assert!(probes(&encode(&all)).is_none());
    }

    #[test]
    fn sums_read_back_whatever_their_size() {
        for largest in [0, 1, 255, 256, 1 << 90, u128::MAX] {
            let mut of_two = Accumulator::new(2, 1);
            of_two.image_mut().pixels_mut()[1].sum = [largest, 3, 0];
            let bytes = of_sums(&of_two);
            assert_eq!(sums(&bytes, 2).unwrap(), [[0; 3], [largest, 3, 0]]);
            assert!(sums(&bytes, 3).is_none());
        }
        assert!(sums(&[17], 17).is_none() && sums(&[], 0).is_none());
        assert!(radiances(&[1, 0, 0, 0], 1).is_none());
        let found = Jacobian { radiance: vec![Rgb::ONE; 2], derivatives: vec![Rgb::ZERO; 6] };
        assert_eq!(jacobian(&encode(&found), 2, 3), Some(found.clone()));
        assert!(jacobian(&encode(&found), 3, 2).is_none());
    }
}
