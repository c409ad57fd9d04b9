//! The error of a renderer over time.

/// One picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    pub(crate) seconds: f64,
    /// Root mean square, W sr^-1 m^-2.
    pub(crate) error: f64,
}

/// The pictures of one renderer in one round.
pub(crate) struct Curve(Vec<Point>);

impl Curve {
    /// The points in any order; at least one.
    pub(crate) fn new(points: impl IntoIterator<Item = Point>) -> Self {
        let mut points: Vec<Point> = points.into_iter().collect();
        points.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        Self(points)
    }

    /// The error after `seconds`: between two points, interpolated linearly in logarithms; beyond
    /// them, proportional to `seconds^(-1/2)`.
    pub(crate) fn error_at(&self, seconds: f64) -> f64 {
        let beyond = |p: &Point| p.error * (p.seconds / seconds).sqrt();
        let after = self.0.partition_point(|p| p.seconds < seconds);
        match (after.checked_sub(1).and_then(|i| self.0.get(i)), self.0.get(after)) {
            (Some(a), Some(b)) => {
                let share = (seconds / a.seconds).ln() / (b.seconds / a.seconds).ln();
                (a.error.ln() * (1.0 - share) + b.error.ln() * share).exp()
            }
            (Some(p), None) | (None, Some(p)) => beyond(p),
            (None, None) => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_lie_on_the_law_of_the_points() {
        let at = |seconds: f64| Point { seconds, error: 2.0 / seconds };
        let curve = Curve::new([at(4.0), at(1.0)]);
        assert!((curve.error_at(2.0) - 1.0).abs() < 1e-12);
        assert!((curve.error_at(4.0) - 0.5).abs() < 1e-12);
        assert!((curve.error_at(16.0) - 0.25).abs() < 1e-12);
        assert!((curve.error_at(0.25) - 4.0).abs() < 1e-12);
    }
}
