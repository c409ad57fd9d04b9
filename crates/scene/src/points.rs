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

/// A straight line of the scene along one of its axes, and where it is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisLine {
    /// Its name, or `line N`.
    pub name: String,
    /// The axis that it is parallel to: 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// Whether it runs along the axis from its first to its second end, and not only parallel to it.
    pub is_directed: bool,
    /// Both ends, pixels from the picture's top left corner, to the right and down.
    pub ends: [[f64; 2]; 2],
    /// The distance between its ends in the scene, metres, if it is known.
    pub length_m: Option<f64>,
}
