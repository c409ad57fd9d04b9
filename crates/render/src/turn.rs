//! Sine and cosine of a part of a turn, for directions drawn around an axis. They have the same bits on all machines,
//! unlike those of the systems' libraries.

/// Sine and cosine of `turns` times 2 pi, for `turns` in [0, 1]; off by at most 2e-7.
///
/// The nearest quarter of the turn is exact in single precision; what is left is at most pi/4, where
/// polynomials are near single precision (coefficients of the Cephes library, sinf.c and cosf.c).
#[inline]
pub(crate) fn sin_cos(turns: f32) -> (f32, f32) {
    let quarters = 4.0 * turns;
    let quarter = (quarters + 0.5) as u32;
    let x = (quarters - quarter as f32) * std::f32::consts::FRAC_PI_2;
    let x2 = x * x;
    let sin = x + x * x2 * (-1.666_665_5e-1 + x2 * (8.332_161e-3 - 1.951_529_6e-4 * x2));
    let cos =
        1.0 - 0.5 * x2 + x2 * x2 * (4.166_664_6e-2 + x2 * (-1.388_731_6e-3 + 2.443_315_7e-5 * x2));
    let (sin, cos) = if quarter & 1 == 0 { (sin, cos) } else { (cos, -sin) };
    if quarter & 2 == 0 { (sin, cos) } else { (-sin, -cos) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_double_precision() {
        let mut worst = 0.0f64;
        for step in 0..=1_000_000 {
            let turns = step as f32 / 1e6;
            let (sin, cos) = sin_cos(turns);
            let (exact_sin, exact_cos) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            worst = worst.max((f64::from(sin) - exact_sin).abs());
            worst = worst.max((f64::from(cos) - exact_cos).abs());
        }
        assert!(worst < 2e-7, "{worst}");
    }
}
