//! The albedo of rough diffuse surfaces, `roughdiffuse` of Mitsuba 0.5 and 0.6, by quadrature.
//! [Oren and Nayar 1994, equations 26 to 30; Mitsuba 0.6 documentation, `roughdiffuse`]

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

/// Steps of each angle in the quadrature of an albedo. Half as many are off by 2e-4, twice as many by 1e-5.
const STEPS: u32 = 48;

/// The albedo of Oren and Nayar's surface of slopes `alpha` under even light, as factors of its reflectance and of the
/// square of that.
pub(super) fn albedo(alpha: f64, is_fast: bool) -> [f64; 2] {
    // Mitsuba's alpha is the slope of a Beckmann distribution.
    let variance = (alpha * FRAC_1_SQRT_2).powi(2);
    let step = |k: u32, whole: f64| (f64::from(k) + 0.5) / f64::from(STEPS) * whole;
    let mut sums = [0.0; 2];
    for i in 0..STEPS {
        for o in 0..STEPS {
            let angles = [step(i, FRAC_PI_2), step(o, FRAC_PI_2)];
            let weight = angles.map(|angle| angle.sin() * angle.cos()).iter().product::<f64>();
            for turn in 0..STEPS {
                let parts = reflectance(variance, angles, step(turn, PI).cos(), is_fast);
                sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += weight * part);
            }
        }
    }
    // The mean over the third angle times 4 for the integrals of sin cos, which are a half each.
    let cell = (FRAC_PI_2 / f64::from(STEPS)).powi(2) / f64::from(STEPS);
    sums.map(|sum| 4.0 * cell * sum)
}

/// Oren and Nayar's reflectance times pi over its reflectance and over the square of that, for the two angles from the
/// normal and the cosine of the turn between them.
fn reflectance(variance: f64, angles: [f64; 2], cos_turn: f64, is_fast: bool) -> [f64; 2] {
    let [low, high] = [angles[0].min(angles[1]), angles[0].max(angles[1])];
    let one = 1.0 - 0.5 * variance / (variance + 0.33);
    let two = 0.45 * variance / (variance + 0.09);
    if is_fast {
        return [one + two * cos_turn.max(0.0) * high.sin() * low.tan(), 0.0];
    }
    let opposite = if cos_turn >= 0.0 { 0.0 } else { (2.0 * low / PI).powi(3) };
    let three = 0.125 * variance / (variance + 0.09) * (4.0 * low * high / (PI * PI)).powi(2);
    let slope = (0.5 * (low + high)).tan();
    let first = one
        + cos_turn * two * (high.sin() - opposite) * low.tan()
        + (1.0 - cos_turn.abs()) * three * slope;
    let again = 0.17 * variance / (variance + 0.13) * (1.0 - cos_turn * (2.0 * low / PI).powi(2));
    [first, again]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_surface_is_lambertian() {
        let [once, twice] = albedo(0.0, false);
        assert!((once - 1.0).abs() < 1e-3 && twice == 0.0, "{once} {twice}");
    }

    /// The integral of the first two terms is known: 2/3 - 64 / (45 pi) for the second.
    #[test]
    fn the_albedo_is_the_integral() {
        let variance = 0.5 * 0.3f64.powi(2);
        let wanted = 1.0 - 0.5 * variance / (variance + 0.33)
            + 0.45 * variance / (variance + 0.09) * (2.0 / 3.0 - 64.0 / (45.0 * PI));
        assert!((albedo(0.3, true)[0] - wanted).abs() < 1e-3);
    }

    #[test]
    fn rough_surfaces_lose_light_and_gain_some_of_it_between_their_facets() {
        let [once, twice] = albedo(0.5, false);
        assert!(once < 0.97 && once > 0.7 && twice > 0.01 && once + twice < 1.0, "{once} {twice}");
    }
}
