//! Curves from code values to linear values, as samples at equal steps of the code.

/// Codes at which curves are sampled.
pub(super) const SAMPLES: u16 = 256;

/// The samples of `curve`, which takes codes from 0 to 1.
pub(super) fn sampled(curve: impl Fn(f32) -> f32) -> Vec<f32> {
    let code = |k| f32::from(k) / f32::from(SAMPLES - 1);
    (0..SAMPLES).map(|k| curve(code(k))).collect()
}
