//! Curves from code values to linear values, as samples at equal steps of the code.

/// Codes at which curves are sampled.
pub(super) const SAMPLES: u16 = 256;

/// Added from sample to sample, so that curves grow whose darkest codes are rounded to the same number: in all a
/// thousandth of a step of 16 bits.
pub(super) const DARKEST_STEP: f64 = 1e-10;

/// The samples of `curve`, which takes codes from 0 to 1.
pub(super) fn sampled(curve: impl Fn(f32) -> f32) -> Vec<f32> {
    let code = |k| f32::from(k) / f32::from(SAMPLES - 1);
    let darkest = |k| (DARKEST_STEP * f64::from(k)) as f32;
    (0..SAMPLES).map(|k| curve(code(k)) + darkest(k)).collect()
}
