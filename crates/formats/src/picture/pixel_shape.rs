//! Pixels that are not square, by what files say of them: cameras here have square ones.

/// Resolutions are rounded; from this difference on pixels are meant to be not square.
const TOLERANCE: f64 = 0.01;

/// What the user should know of pixels that are `aspect` times as wide as high by `source`, as the end of a sentence
/// about the file; none if they are square, or if that is no number.
pub(super) fn note(aspect: Option<f64>, source: &str) -> Option<String> {
    let aspect = aspect.filter(|aspect| aspect.is_finite() && *aspect > 0.0)?;
    let is_square = (aspect.ln()).abs() < TOLERANCE;
    (!is_square).then(|| {
        format!(
            "has pixels that are {aspect:.3} times as wide as high, by {source}; they were read as square ones: if \
             that is so, scale the picture to square pixels"
        )
    })
}
