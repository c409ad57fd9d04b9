//! Measured points of a scene and where a photograph shows them.

/// A point and where it is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Its name, or `line N`.
    pub name: String,
    /// Pixels from the picture's top left corner, to the right and down.
    pub pixel: [f64; 2],
    /// Metres, world space.
    pub point: [f64; 3],
}
