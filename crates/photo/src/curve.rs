//! A measured response curve, interpolated so that it stays monotone.
//!
//! Between two rows the curve is a cubic Hermite polynomial. Its slope at a row is the weighted
//! harmonic mean of the slopes of the adjacent chords, so that the curve is monotone [Fritsch and
//! Butland 1984; PCHIP in MATLAB and SciPy].

use serde::{Deserialize, Serialize};

/// A strictly increasing curve from codes to linear values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    codes: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Curve {
    /// The curve through (`codes`, `values`). Without a row for the code zero one of linear value
    /// zero is added, unless the first row has a value of zero itself.
    ///
    /// # Panics
    /// If there are fewer than two rows, or either list is not strictly increasing.
    pub fn new(codes: &[f64], values: &[f64]) -> Self {
        let (mut codes, mut values) = (codes.to_vec(), values.to_vec());
        if codes[0] > 0.0 && values[0] > 0.0 {
            codes.insert(0, 0.0);
            values.insert(0, 0.0);
        }
        let grows = |list: &[f64]| list.len() > 1 && list.windows(2).all(|w| w[0] < w[1]);
        assert!(grows(&codes) && grows(&values), "a response curve grows");
        let slopes = slopes(&codes, &values);
        Self { codes, values, slopes }
    }

    /// The linear value of a code, clamped to the range of the rows.
    pub fn linear(&self, code: f64) -> f64 {
        let code = code.clamp(self.codes[0], self.last_code());
        self.hermite(segment(&self.codes, code), code)
    }

    /// The code of a linear value, clamped to the range of the rows.
    pub fn code(&self, linear: f64) -> f64 {
        let linear = linear.clamp(self.values[0], self.values[self.values.len() - 1]);
        let row = segment(&self.values, linear);
        let (mut low, mut high) = (self.codes[row], self.codes[row + 1]);
        // The cubic is monotone: bisection finds its only crossing, to the last bit.
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = 0.5 * (low + high);
            *if self.hermite(row, middle) < linear { &mut low } else { &mut high } = middle;
        }
        0.5 * (low + high)
    }

    /// The largest measured code.
    pub fn last_code(&self) -> f64 {
        self.codes[self.codes.len() - 1]
    }

    /// The cubic between `row` and the next at `code`.
    fn hermite(&self, row: usize, code: f64) -> f64 {
        let width = self.codes[row + 1] - self.codes[row];
        let t = (code - self.codes[row]) / width;
        let s = 1.0 - t;
        let [value, next] = [self.values[row], self.values[row + 1]];
        let [slope, next_slope] = [self.slopes[row], self.slopes[row + 1]].map(|d| d * width);
        s * s * ((1.0 + 2.0 * t) * value + t * slope)
            + t * t * ((1.0 + 2.0 * s) * next - s * next_slope)
    }
}

/// The row at the lower end of the interval that contains `at`.
fn segment(grid: &[f64], at: f64) -> usize {
    grid.partition_point(|x| *x <= at).clamp(1, grid.len() - 1) - 1
}

fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let widths: Vec<f64> = x.windows(2).map(|w| w[1] - w[0]).collect();
    let chords: Vec<f64> = y.windows(2).zip(&widths).map(|(w, h)| (w[1] - w[0]) / h).collect();
    let last = chords.len() - 1;
    let inner = (0..last).map(|k| {
        let (a, b) = (2.0 * widths[k + 1] + widths[k], widths[k + 1] + 2.0 * widths[k]);
        (a + b) / (a / chords[k] + b / chords[k + 1])
    });
    if last == 0 {
        return vec![chords[0]; 2];
    }
    let start = end_slope([widths[0], widths[1]], [chords[0], chords[1]]);
    let end = end_slope([widths[last], widths[last - 1]], [chords[last], chords[last - 1]]);
    std::iter::once(start).chain(inner).chain([end]).collect()
}

/// The slope of the parabola through the three rows at an end, clamped so that the curve is
/// monotone.
fn end_slope([width, next_width]: [f64; 2], [chord, next_chord]: [f64; 2]) -> f64 {
    let slope = ((2.0 * width + next_width) * chord - width * next_chord) / (width + next_width);
    slope.clamp(0.0, 3.0 * chord)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_curve_is_followed_and_inverted() {
        let codes: Vec<f64> = (0..=16).map(|k| f64::from(k) / 16.0).collect();
        let values: Vec<f64> = codes.iter().map(|c| c.powf(2.2)).collect();
        let curve = Curve::new(&codes, &values);
        for k in 0..=1000 {
            let code = f64::from(k) / 1000.0;
            let linear = curve.linear(code);
            assert!((linear - code.powf(2.2)).abs() < 3e-4, "{code}: {linear}");
            assert!((curve.code(linear) - code).abs() < 1e-9, "{code}");
        }
    }

    #[test]
    fn it_grows_where_the_data_make_a_corner() {
        let curve = Curve::new(&[0.0, 0.1, 0.2, 0.9, 1.0], &[0.0, 1e-4, 0.5, 0.50001, 1.0]);
        let values: Vec<f64> = (0..=5000).map(|k| curve.linear(f64::from(k) / 5000.0)).collect();
        assert!(values.windows(2).all(|w| w[1] > w[0]), "monotone");
    }

    #[test]
    fn two_rows_make_a_line_and_black_is_black() {
        let line = Curve::new(&[0.0, 1.0], &[0.0, 2.0]);
        assert!((line.linear(0.3) - 0.6).abs() < 1e-12);
        let without_black = Curve::new(&[0.2, 0.8], &[0.1, 0.7]);
        assert_eq!((without_black.linear(0.0), without_black.linear(0.9)), (0.0, 0.7));
    }
}
