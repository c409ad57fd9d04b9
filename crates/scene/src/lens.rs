//! The lens model: principal point and radial distortion.
//!
//! With the pinhole's image at distance one, `x = X/Z`, `y = Y/Z`, `r2 = x^2 + y^2`,
//!
//! ```text
//! (x_d, y_d) = (1 + k1 r2 + k2 r2^2) (x, y),      pixel = f (x_d, y_d) + principal point
//! ```
//!
//! the first two radial terms of [Brown 1966], with the signs of OpenCV: barrel distortion has `k1
//! < 0`.

use serde::Serialize;

/// A lens; the default is the pinhole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Lens {
    /// The principal point: from the picture's centre to the right and downwards, in heights of the
    /// picture.
    pub principal_point: [f32; 2],
    /// The coefficient k1 of the squared distance from the axis.
    pub k1: f32,
    /// The coefficient k2 of its fourth power.
    pub k2: f32,
}

/// Iterations of Newton's method, each of which bisects the interval if the step leaves it: enough
/// for all bits of single precision by bisection alone.
const ITERATIONS: usize = 60;

impl Lens {
    /// Whether there is any radial distortion.
    pub fn distorts(&self) -> bool {
        self.k1 != 0.0 || self.k2 != 0.0
    }

    /// The radial factor `1 + k1 r2 + k2 r2^2` of a point at the squared distance `r2` from the
    /// axis; none where the model folds over.
    pub fn factor(&self, r2: f32) -> Option<f32> {
        (f64::from(r2) < self.reach_r2()).then(|| self.polynomial(f64::from(r2)) as f32)
    }

    /// The undistorted position of a point on the image plane at distance one. Beyond the range of
    /// the model it is clamped to the end of the range.
    #[inline]
    pub fn undistorted(&self, x: f32, y: f32) -> (f32, f32) {
        if !self.distorts() {
            return (x, y);
        }
        let distance = f64::from(x).hypot(f64::from(y));
        if distance == 0.0 {
            return (x, y);
        }
        let scale = self.undistorted_distance(distance) / distance;
        ((f64::from(x) * scale) as f32, (f64::from(y) * scale) as f32)
    }

    /// Whether `distance` from the axis in the distorted picture, on the image plane at distance
    /// one, is in the range of the model.
    pub fn reaches(&self, distance: f32) -> bool {
        let reach = self.reach_r2().sqrt();
        reach.is_infinite() || f64::from(distance) < reach * self.polynomial(reach * reach)
    }

    fn polynomial(&self, r2: f64) -> f64 {
        1.0 + r2 * (f64::from(self.k1) + r2 * f64::from(self.k2))
    }

    /// The squared distance up to which the distorted distance increases: the root of `1 + 3 k1 r2
    /// + 5 k2 r2^2`.
    fn reach_r2(&self) -> f64 {
        let (a, b) = (5.0 * f64::from(self.k2), 3.0 * f64::from(self.k1));
        let discriminant = b * b - 4.0 * a;
        if discriminant < 0.0 {
            return f64::INFINITY;
        }
        let q = -0.5 * (b + discriminant.sqrt().copysign(b));
        [q / a, 1.0 / q].into_iter().filter(|root| *root > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// Solves `r (1 + k1 r^2 + k2 r^4) = distance` for r by Newton's method between bounds.
    fn undistorted_distance(&self, distance: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.reach_r2().sqrt());
        if high.is_finite() && distance >= high * self.polynomial(high * high) {
            return high;
        }
        let mut r = distance.min(high);
        for _ in 0..ITERATIONS {
            let r2 = r * r;
            let excess = r * self.polynomial(r2) - distance;
            if excess > 0.0 {
                high = r;
            } else {
                low = r;
            }
            let slope = 1.0 + r2 * (3.0 * f64::from(self.k1) + 5.0 * f64::from(self.k2) * r2);
            let newton = r - excess / slope;
            let next = if newton > low && newton < high {
                newton
            } else if high.is_finite() {
                0.5 * (low + high)
            } else {
                2.0 * r
            };
            if (next - r).abs() <= 1e-12 * distance {
                return next;
            }
            r = next;
        }
        r
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn undistortion_inverts_distortion() {
        for (k1, k2) in [(-0.3, 0.1), (-0.2, 0.0), (0.25, 0.05), (0.1, -0.05), (0.0, -0.02)] {
            let lens = Lens { k1, k2, ..Lens::default() };
            for (x, y) in [(0.0f32, 0.0f32), (1e-4, 0.0), (0.3, -0.2), (-0.7, 0.5), (0.1, 0.9)] {
                let factor = lens.factor(x * x + y * y).unwrap();
                let back = lens.undistorted(factor * x, factor * y);
                let error = (back.0 - x).abs().max((back.1 - y).abs());
                assert!(error < 2e-6, "{lens:?} at {x}, {y}: {back:?}");
            }
        }
    }

    #[test]
    fn beyond_the_fold_nothing_is_shown() {
        let lens = Lens { k1: -1.0 / 3.0, ..Lens::default() };
        assert!(lens.factor(0.99).is_some() && lens.factor(1.01).is_none());
        assert!(lens.reaches(0.66) && !lens.reaches(0.67));
        assert!((lens.undistorted(5.0, 0.0).0 - 1.0).abs() < 1e-6);
        assert!(Lens::default().reaches(1e9));
    }

    #[test]
    fn without_distortion_the_bits_stay() {
        assert_eq!(Lens::default().undistorted(0.1, 1e9), (0.1, 1e9));
        assert_eq!(Lens::default().factor(1e30), Some(1.0));
    }
}
