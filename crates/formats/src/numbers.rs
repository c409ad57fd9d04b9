//! Single-precision numbers as short text and JSON that reads back to the same bits.

use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use unrender_scene::Rgb;
use unrender_scene::origin::in_digits;

/// Vertices in steps above this share of their mesh's size cause a warning: half a millimetre for a room of 5 m.
/// Half of it would warn of meshes that look exact; double of it would bend edges without a warning.
const COARSE: f64 = 1e-4;

/// The step between positions in single precision in a mesh from `low` to `high`, if it is coarse for a mesh of
/// this size.
pub(crate) fn coarse_step(low: Vec3, high: Vec3) -> Option<f64> {
    let farthest = low.abs().max(high.abs()).max_element();
    let step = f64::from(farthest.next_up() - farthest);
    (step > COARSE * f64::from(low.distance(high))).then_some(step)
}

/// The shortest decimal that rounds to `value`.
pub(crate) fn number(value: f32) -> f64 {
    let short = value.to_string().parse().unwrap_or(f64::from(value));
    if short as f32 == value { short } else { f64::from(value) }
}

/// Three coordinates in the world that are read back as `here`, which counts from `origin`.
pub(crate) fn triple_at(origin: DVec3, here: Vec3) -> [f64; 3] {
    [0, 1, 2].map(|axis| in_digits(origin[axis], here[axis]))
}

/// Three numbers, as [`number`] writes them.
pub(crate) fn triple(rgb: Rgb) -> [f64; 3] {
    rgb.to_array().map(number)
}

/// `rgb` as a colour of at most one and a factor, whose product is exactly `rgb`: the factor is
/// one, or a power of two.
pub(crate) fn color_and_factor(rgb: Rgb) -> (Value, f64) {
    let mut factor = 1.0f64;
    while factor < f64::from(rgb.max_element()) && factor.is_finite() {
        factor *= 2.0;
    }
    if factor == 1.0 {
        return (json!(triple(rgb)), factor);
    }
    (json!(rgb.to_array().map(|channel| f64::from(channel) / factor)), factor)
}

/// An angle in degrees that [`radians`] turns into exactly `angle`.
pub(crate) fn degrees(angle: f32) -> f64 {
    let exact = f64::from(angle).to_degrees();
    let short = (0..12).map(|digits| format!("{exact:.digits$}"));
    let short = short.filter_map(|text| text.parse::<f64>().ok());
    short.into_iter().find(|&degrees| radians(degrees) == angle).unwrap_or(exact)
}

/// `degrees` in radians.
pub(crate) fn radians(degrees: f64) -> f32 {
    degrees.to_radians() as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_return_to_the_same_bits() {
        assert_eq!(number(0.07).to_string(), "0.07");
        assert_eq!(degrees(90f32.to_radians()), 90.0);
        let mut value = 1e-9f32;
        while value < 1e9 {
            assert_eq!(number(value) as f32, value);
            assert_eq!(radians(degrees(value)), value);
            let (color, factor) = color_and_factor(Rgb::new(value, value / 3.0, 0.0));
            let back = |i: usize| (color[i].as_f64().unwrap() * factor) as f32;
            assert_eq!([back(0), back(1)], [value, value / 3.0]);
            value *= 1.37;
        }
    }
}
