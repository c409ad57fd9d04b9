//! Reads the pixels of an EXR file, and which of them have a value.
//!
//! The picture is the display window. The file holds the data window: pixels of the display window outside of it
//! have no value, which is not the same as black, and data outside of the display window is left out.

use super::exr_channels::{Chosen, choose};
use super::exr_refused::fault;
use super::{Decoded, Depth, Picture, claims, coverage, exr_says, pixel_shape};
use crate::input::Scope;
use exr::block::UncompressedBlock;
use exr::block::lines::LineRef;
use exr::block::reader::ChunksReader;
use exr::meta::attribute::{EnvironmentMap, SampleType};
use exr::meta::header::Header;
use exr::prelude::{Vec2, f16};
use std::io::Cursor;
use unrender_scene::{Image, Rgb};

/// The marks of a pixel for which red, green and blue were read.
const ALL_COLOURS: u8 = 0b111;
/// Bytes for a pixel: colours, marks, coverage, and its index if it has no value.
const EACH: u64 = 12 + 1 + 4 + 8;

/// The picture in the EXR file `bytes`.
///
/// # Errors
/// If the file is cut short, corrupt, too large, or has no picture that is read, as the end of a sentence about it.
pub(super) fn read(scope: &Scope, bytes: &[u8]) -> Result<Decoded, String> {
    let reader =
        exr::block::read(Cursor::new(bytes), false).map_err(|error| fault(bytes, &error))?;
    let chosen = choose(reader.headers())?;
    let header = reader.headers()[chosen.part].clone();
    let mut canvas = Canvas::new(scope, &header, bytes.len() as u64)?;
    let wanted = |_: &_, _, block: exr::block::BlockIndex| {
        block.layer == chosen.part && block.level == Vec2(0, 0)
    };
    let blocks = reader
        .filter_chunks(false, wanted)
        .map_err(|error| fault(bytes, &error))?
        .sequential_decompressor(false);
    for block in blocks {
        let block = block.map_err(|error| fault(bytes, &error))?;
        canvas.put(&header, &chosen, &block);
    }
    let mut decoded = canvas.finish(&header)?;
    decoded.notes.extend(chosen.note);
    if header.own_attributes.environment_map == Some(EnvironmentMap::Cube) {
        decoded.notes.push("says that it is a cube map (envmap), which is ignored".into());
    }
    let aspect = Some(f64::from(header.shared_attributes.pixel_aspect));
    decoded.notes.extend(pixel_shape::note(aspect, "its pixelAspectRatio"));
    decoded.notes.extend(exr_says::notes(&header));
    decoded.picture.profile = exr_says::profile(&header);
    Ok(decoded)
}

/// The display window while it is filled.
struct Canvas {
    width: usize,
    height: usize,
    /// The offset of the data window in the display window.
    offset: [i64; 2],
    values: Vec<Rgb>,
    /// Which colours of each pixel were read, as bits.
    filled: Vec<u8>,
    alpha: Option<Vec<f32>>,
}

impl Canvas {
    fn new(scope: &Scope, header: &Header, file_bytes: u64) -> Result<Self, String> {
        let window = header.shared_attributes.display_window;
        let [width, height] = [window.size.width(), window.size.height()];
        let pixels = (width as u64).saturating_mul(height as u64);
        if pixels == 0 {
            return Err("has no pixels".into());
        }
        if pixels > claims::MAX_PIXELS || pixels.saturating_mul(12) > claims::plausible(file_bytes)
        {
            return Err(claims::unbelievable(width as u64, height as u64, file_bytes));
        }
        scope.charge(pixels.saturating_mul(EACH)).map_err(|problem| {
            format!("has {width} x {height} pixels and {problem}; or make the picture smaller")
        })?;
        let start = header.own_attributes.layer_position;
        let offset = [
            i64::from(start.x()) - i64::from(window.position.x()),
            i64::from(start.y()) - i64::from(window.position.y()),
        ];
        let values = vec![Rgb::ZERO; width * height];
        Ok(Self { width, height, offset, values, filled: vec![0; width * height], alpha: None })
    }

    fn put(&mut self, header: &Header, chosen: &Chosen, block: &UncompressedBlock) {
        for line in block.lines(&header.channels) {
            let channel = line.location.channel;
            let kind = header.channels.list[channel].sample_type;
            for (colour, _) in chosen.colours.iter().enumerate().filter(|(_, c)| **c == channel) {
                self.each(&line, kind, |canvas, at, value| {
                    canvas.values[at][colour] = value;
                    canvas.filled[at] |= 1 << colour;
                });
            }
            if chosen.alpha == Some(channel) {
                let pixels = self.values.len();
                self.alpha.get_or_insert_with(|| vec![1.0; pixels]);
                self.each(&line, kind, |canvas, at, value| {
                    if let Some(alpha) = &mut canvas.alpha {
                        alpha[at] = value;
                    }
                });
            }
        }
    }

    /// Calls `set` for the samples of a line that are within the display window.
    fn each(&mut self, line: &LineRef<'_>, kind: SampleType, set: impl Fn(&mut Self, usize, f32)) {
        let y = line.location.position.y() as i64 + self.offset[1];
        let Some(y) = usize::try_from(y).ok().filter(|y| *y < self.height) else { return };
        let first = line.location.position.x() as i64 + self.offset[0];
        let samples = line.value.chunks_exact(kind.bytes_per_sample());
        for (x, sample) in (first..).zip(samples) {
            if let Some(x) = usize::try_from(x).ok().filter(|x| *x < self.width) {
                set(self, y * self.width + x, number(kind, sample));
            }
        }
    }

    /// The picture, with notes for the user.
    fn finish(self, header: &Header) -> Result<Decoded, String> {
        let [mut outside, mut transparent, mut partly] = [0, 0, 0];
        let mut invalid = Vec::new();
        for (at, filled) in self.filled.iter().enumerate() {
            let alpha = self.alpha.as_ref().map_or(1.0, |alpha| alpha[at]);
            if *filled != ALL_COLOURS {
                if self.has_data(header, at) {
                    return Err("is cut short or corrupt (some of its blocks are missing)".into());
                }
                outside += 1;
                invalid.push(at);
            } else if alpha <= 0.0 {
                transparent += 1;
                invalid.push(at);
            } else if alpha < 1.0 {
                partly += 1;
            }
        }
        let mut notes = Vec::new();
        if outside > 0 {
            notes.push(format!(
                "{outside} pixel(s) lie outside of the file's data window; they have no value, \
                 which is not black"
            ));
        }
        notes.extend(coverage::note(transparent, partly > 0));
        let values = Image::new(self.width, self.height, self.values);
        let picture = Picture { invalid, is_linear: true, ..Picture::new(values, Depth::Float) };
        Ok(Decoded { picture, notes })
    }

    /// Whether the data window has the pixel.
    fn has_data(&self, header: &Header, at: usize) -> bool {
        let [x, y] = [at % self.width, at / self.width].map(|n| n as i64);
        let size = header.layer_size;
        (0..size.width() as i64).contains(&(x - self.offset[0]))
            && (0..size.height() as i64).contains(&(y - self.offset[1]))
    }
}

fn number(kind: SampleType, sample: &[u8]) -> f32 {
    match (kind, sample) {
        (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
        (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
        (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
        // Samples come in the size of their kind.
        _ => f32::NAN,
    }
}
