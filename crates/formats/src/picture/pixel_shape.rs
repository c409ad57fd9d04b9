//! Pixels that are not square, as files state it: cameras here have square ones.

/// Resolutions are rounded; only from this difference on pixels count as not square.
const TOLERANCE: f64 = 0.01;

/// The warning of pixels that are `aspect` times as wide as high according to `source`, as the end of a sentence
/// about the file; none if they are square, or if `aspect` is not valid.
pub(super) fn note(aspect: Option<f64>, source: &str) -> Option<String> {
    let aspect = aspect.filter(|aspect| aspect.is_finite() && *aspect > 0.0)?;
    let is_square = (aspect.ln()).abs() < TOLERANCE;
    (!is_square).then(|| {
        format!(
            "has pixels that are {aspect:.3} times as wide as high, by {source}; they were read as \
             square ones: if that is true, scale the picture to square pixels"
        )
    })
}
