//! Pictures as codes of few bits, packed for a page.
//!
//! Codes are linear in the logarithm of a value, or in its root. They are predicted from their neighbours to the left and
//! above by the median edge detector of JPEG-LS [Weinberger et al. 2000]; the differences are packed as zlib.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;
use unrender_scene::RgbImage;

/// How values are coded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Code {
    /// The largest code is 2^bits - 1; at most 16.
    pub(crate) bits: u32,
    /// What codes are linear in.
    pub(crate) curve: Curve,
}

/// What codes are linear in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Curve {
    /// The logarithm, from so many factors of two below the largest value; what is less is zero. Values have the same
    /// relative error.
    Logarithm {
        /// The factors of two.
        octaves: f32,
    },
    /// The square root. The largest values have the least relative error, and all others a smaller absolute one.
    Root,
}

/// A packed picture.
#[derive(Clone, Debug)]
pub(crate) struct Coded {
    /// How it is coded.
    pub(crate) code: Code,
    /// Its largest value.
    pub(crate) max: f32,
    /// The differences of all codes, channel by channel and row by row: first all low bytes, then all high ones, as zlib.
    pub(crate) bytes: Vec<u8>,
}

impl Code {
    /// The largest relative error of the largest value: half a step.
    pub(crate) fn error(self) -> f64 {
        match self.curve {
            Curve::Logarithm { octaves } => (0.5 * f64::from(octaves) / self.steps()).exp2() - 1.0,
            Curve::Root => 1.0 / self.steps(),
        }
    }

    /// The steps between the codes of the least value above zero, or of zero, and the greatest.
    fn steps(self) -> f64 {
        match self.curve {
            Curve::Logarithm { .. } => f64::from((1u32 << self.bits) - 2),
            Curve::Root => f64::from((1u32 << self.bits) - 1),
        }
    }

    /// The code of `value`.
    fn of(self, value: f32, max: f32) -> u16 {
        if value <= 0.0 || max <= 0.0 {
            return 0;
        }
        let share = value.min(max) / max;
        let steps = self.steps() as f32;
        match self.curve {
            Curve::Root => (share.sqrt() * steps).round() as u16,
            Curve::Logarithm { octaves } => match 1.0 + share.log2() / octaves {
                place if place < 0.0 => 0,
                place => 1 + (place * steps).round() as u16,
            },
        }
    }
}

/// Packs `picture`, whose values are finite and not negative.
pub(crate) fn coded(picture: &RgbImage, code: Code) -> Coded {
    let max = picture.pixels().iter().fold(0.0, |max: f32, rgb| max.max(rgb.max_element()));
    let (width, count) = (picture.width(), picture.pixels().len());
    let (mut low, mut high) = (Vec::with_capacity(6 * count), Vec::with_capacity(3 * count));
    for channel in 0..3 {
        let codes: Vec<u16> =
            picture.pixels().iter().map(|rgb| code.of(rgb[channel], max)).collect();
        for (index, own) in codes.iter().enumerate() {
            let [least, most] =
                zigzag(own.wrapping_sub(predicted(&codes, width, index))).to_le_bytes();
            low.push(least);
            high.push(most);
        }
    }
    low.append(&mut high);
    Coded { code, max, bytes: packed(&low) }
}

/// `bytes` as zlib.
pub(crate) fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory takes all bytes")
}

/// The prediction for the code at `index` by those before it.
fn predicted(codes: &[u16], width: usize, index: usize) -> u16 {
    let (x, y) = (index % width, index / width);
    match (x, y) {
        (0, 0) => 0,
        (_, 0) => codes[index - 1],
        (0, _) => codes[index - width],
        _ => {
            let [left, above, corner] = [1, width, width + 1].map(|back| codes[index - back]);
            if corner >= left.max(above) {
                left.min(above)
            } else if corner <= left.min(above) {
                left.max(above)
            } else {
                left + above - corner
            }
        }
    }
}

/// Small differences of either sign as small numbers.
fn zigzag(difference: u16) -> u16 {
    (difference << 1) ^ ((difference as i16 >> 15) as u16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::ZlibDecoder;
    use std::io::Read;
    use unrender_scene::Rgb;

    /// The picture again, as the page reads it.
    fn decoded(coded: &Coded, width: usize, count: usize) -> Vec<[f32; 3]> {
        let mut bytes = Vec::new();
        ZlibDecoder::new(&coded.bytes[..]).read_to_end(&mut bytes).unwrap();
        let mut pixels = vec![[0.0; 3]; count];
        for channel in 0..3 {
            let mut codes = Vec::new();
            for index in 0..count {
                let at = channel * count + index;
                let zigzag = u16::from_le_bytes([bytes[at], bytes[3 * count + at]]);
                let difference = (zigzag >> 1) ^ (zigzag & 1).wrapping_neg();
                let prediction = predicted(&[&codes[..], &[0]].concat(), width, index);
                codes.push(prediction.wrapping_add(difference));
                let (code, steps) = (f32::from(codes[index]), coded.code.steps() as f32);
                let share = match coded.code.curve {
                    Curve::Root => (code / steps).powi(2),
                    Curve::Logarithm { .. } if code == 0.0 => 0.0,
                    Curve::Logarithm { octaves } => (((code - 1.0) / steps - 1.0) * octaves).exp2(),
                };
                pixels[index][channel] = coded.max * share;
            }
        }
        pixels
    }

    #[test]
    fn values_come_back_within_half_a_step() {
        let value = |x: usize, y: usize| ((x * 7 + y * 13) % 31) as f32 - 20.0;
        let at = |x, y| Rgb::new(value(x, y).exp2(), value(y, x).exp2(), 0.0);
        let picture = RgbImage::from_fn(13, 9, at);
        let logarithm = |bits, octaves| Code { bits, curve: Curve::Logarithm { octaves } };
        for code in [logarithm(12, 18.0), logarithm(10, 10.0), Code { bits: 9, curve: Curve::Root }]
        {
            let coded = coded(&picture, code);
            let found = decoded(&coded, 13, 117);
            for (pixel, found) in picture.pixels().iter().zip(found) {
                for (value, found) in pixel.to_array().into_iter().zip(found) {
                    let (least, error) = match code.curve {
                        Curve::Logarithm { octaves } => {
                            ((-octaves).exp2(), value * code.error() as f32)
                        }
                        Curve::Root => {
                            (0.0, (value * coded.max).sqrt() * code.error() as f32 + 1e-5)
                        }
                    };
                    let is_near = (found - value).abs() <= 1.002 * error;
                    let is_left_out = value < coded.max * least;
                    assert!(if is_left_out { found == 0.0 } else { is_near }, "{value} {found}");
                }
            }
        }
    }

    #[test]
    fn a_smooth_picture_is_small() {
        let smooth = RgbImage::from_fn(64, 64, |x, y| Rgb::splat(1.0 + 0.01 * (x + y) as f32));
        let bytes = coded(&smooth, Code { bits: 12, curve: Curve::Logarithm { octaves: 18.0 } })
            .bytes
            .len();
        assert!(bytes < 64 * 64 * 3 / 2, "{bytes}");
    }
}
