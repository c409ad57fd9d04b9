//! From codes to linear values, by tables where the codes are few.

use crate::Response;
use unrender_scene::{Depth, Rgb};

/// The linear values of the codes of all frames, and the variances of their rounding.
pub(super) struct Scale<'a> {
    response: &'a Response,
    black_level: Rgb,
    /// For each channel linear value and variance of every code; none for floating-point files.
    tables: Option<[Vec<[f64; 2]>; 3]>,
    max: f32,
}

impl<'a> Scale<'a> {
    pub(super) fn new(response: &'a Response, black_level: Rgb, depth: Depth) -> Self {
        let mut scale = Self { response, black_level, tables: None, max: 1.0 };
        if let Some(max) = depth.max_code() {
            let row = |channel: usize, code: u32| {
                let code = code as f32 / max;
                let step = response.step(
                    channel,
                    scale.above_black(channel, code),
                    1.0 / (max * (1.0 - black_level[channel])),
                );
                [scale.computed(channel, code), f64::from(step).powi(2) / 12.0]
            };
            let table = |channel| (0..=max as u32).map(|code| row(channel, code)).collect();
            scale.tables = Some([table(0), table(1), table(2)]);
            scale.max = max;
        }
        scale
    }

    /// The linear value of a code; 1 is white.
    pub(super) fn linear(&self, channel: usize, code: f32) -> f64 {
        match &self.tables {
            Some(tables) => tables[channel][self.row(code)][0],
            None => self.computed(channel, code),
        }
    }

    /// The variance of the linear value by the rounding of the code.
    pub(super) fn rounding(&self, channel: usize, code: f32) -> f64 {
        self.tables.as_ref().map_or(0.0, |tables| tables[channel][self.row(code)][1])
    }

    /// The slope of the linear value over the code, where 1 is the greatest code; zero for floating-point files.
    pub(super) fn per_code(&self, channel: usize, code: f32) -> f64 {
        f64::from(self.max) * (12.0 * self.rounding(channel, code)).sqrt()
    }

    /// As [`Scale::linear`], of a value between codes.
    pub(super) fn computed(&self, channel: usize, code: f32) -> f64 {
        self.response.linear_from_code(channel, self.above_black(channel, code)).into()
    }

    fn above_black(&self, channel: usize, code: f32) -> f32 {
        let black = self.black_level[channel];
        (code - black) / (1.0 - black)
    }

    fn row(&self, code: f32) -> usize {
        (code * self.max).round().clamp(0.0, self.max) as usize
    }
}
