//! The lens model: principal point, pixels that are not square, radial and tangential distortion.
//!
//! With the pinhole's image at distance one, `x = X/Z` to the right, `y = Y/Z` downwards, `r2 = x^2 +
//! y^2`,
//!
//! ```text
//! x_d = (1 + k1 r2 + k2 r2^2 + k3 r2^3) x + 2 p1 x y + p2 (r2 + 2 x^2)
//! y_d = (1 + k1 r2 + k2 r2^2 + k3 r2^3) y + p1 (r2 + 2 y^2) + 2 p2 x y
//! pixel = (fx x_d, fy y_d) + principal point
//! ```
//!
//! the terms of [Brown 1966] with the names and signs of OpenCV: barrel distortion has `k1 < 0`.

use serde::{Deserialize, Serialize};

/// A lens; the default is the pinhole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lens {
    /// The principal point: from the picture's centre to the right and downwards, in heights of the
    /// picture.
    pub principal_point: [f32; 2],
    /// The focal length in pixels across over that in pixels down: one for square pixels.
    pub fx_over_fy: f32,
    /// The coefficient k1 of the squared distance from the axis.
    pub k1: f32,
    /// The coefficient k2 of its fourth power.
    pub k2: f32,
    /// The coefficient k3 of its sixth power.
    pub k3: f32,
    /// The tangential coefficient p1, of a lens that is tilted about the horizontal axis.
    pub p1: f32,
    /// The tangential coefficient p2, of one that is tilted about the vertical axis.
    pub p2: f32,
}

impl Default for Lens {
    fn default() -> Self {
        Self {
            principal_point: [0.0; 2],
            fx_over_fy: 1.0,
            k1: 0.0,
            k2: 0.0,
            k3: 0.0,
            p1: 0.0,
            p2: 0.0,
        }
    }
}

/// Iterations of Newton's method, each of which bisects the interval if the step leaves it: enough
/// for all bits of single precision by bisection alone.
const ITERATIONS: usize = 60;

/// Steps of Newton's method in two dimensions for tangential terms. Each squares the error, which
/// begins at the size of these terms, about 1e-3: three reach single precision, half of them would
/// not, and double are never taken, as the iteration ends when a step is below [`CLOSE`].
const TANGENTIAL_ITERATIONS: usize = 12;
/// A step that is this small, relatively to the distance one of the image plane, changes no bit of a
/// single-precision direction.
const CLOSE: f64 = 1e-10;

impl Lens {
    /// Whether there is any distortion.
    pub fn distorts(&self) -> bool {
        self.k1 != 0.0 || self.k2 != 0.0 || self.k3 != 0.0 || self.is_tangential()
    }

    fn is_tangential(&self) -> bool {
        self.p1 != 0.0 || self.p2 != 0.0
    }

    /// Whether all its numbers are finite and its pixels have a width.
    pub fn is_valid(&self) -> bool {
        let Self { principal_point: [x, y], fx_over_fy, k1, k2, k3, p1, p2 } = *self;
        [x, y, k1, k2, k3, p1, p2].iter().all(|number| number.is_finite())
            && fx_over_fy.is_finite()
            && fx_over_fy > 0.0
    }

    /// The radial factor `1 + k1 r2 + k2 r2^2 + k3 r2^3` of a point at the squared distance `r2` from
    /// the axis; none where the model folds over.
    pub fn factor(&self, r2: f32) -> Option<f32> {
        (f64::from(r2) < self.reach_r2()).then(|| self.polynomial(f64::from(r2)) as f32)
    }

    /// Where the point `right`, `down` of the pinhole's image plane at distance one comes to lie; none
    /// where the model folds over.
    pub fn distorted(&self, right: f32, down: f32) -> Option<(f32, f32)> {
        let factor = self.factor(right * right + down * down)?;
        if !self.is_tangential() {
            return Some((factor * right, factor * down));
        }
        let (x, y) = self.bent(f64::from(right), f64::from(down));
        Some((x as f32, y as f32))
    }

    /// The undistorted position of a point on the image plane at distance one, to the right and
    /// downwards. Beyond the range of the model it is clamped to the end of the range.
    #[inline]
    pub fn undistorted(&self, right: f32, down: f32) -> (f32, f32) {
        if !self.distorts() {
            return (right, down);
        }
        let (x, y) = (f64::from(right), f64::from(down));
        let distance = x.hypot(y);
        let scale =
            if distance > 0.0 { self.undistorted_distance(distance) / distance } else { 1.0 };
        let (x, y) = (x * scale, y * scale);
        if !self.is_tangential() {
            return (x as f32, y as f32);
        }
        self.untilted([f64::from(right), f64::from(down)], [x, y])
    }

    /// Whether `distance` from the axis in the distorted picture, on the image plane at distance
    /// one, is in the range of the radial terms.
    pub fn reaches(&self, distance: f32) -> bool {
        let reach = self.reach_r2().sqrt();
        reach.is_infinite() || f64::from(distance) < reach * self.polynomial(reach * reach)
    }

    fn polynomial(&self, r2: f64) -> f64 {
        1.0 + r2 * (f64::from(self.k1) + r2 * (f64::from(self.k2) + r2 * f64::from(self.k3)))
    }

    /// The derivative of the distorted by the undistorted distance.
    fn slope(&self, r2: f64) -> f64 {
        let [k1, k2, k3] = [self.k1, self.k2, self.k3].map(f64::from);
        1.0 + r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3))
    }

    /// All terms of the model.
    fn bent(&self, x: f64, y: f64) -> (f64, f64) {
        let (p1, p2) = (f64::from(self.p1), f64::from(self.p2));
        let r2 = x * x + y * y;
        let radial = self.polynomial(r2);
        (
            radial * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            radial * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    }

    /// Solves `bent(x, y) = image` by Newton's method from `start`, which solves it without the
    /// tangential terms.
    fn untilted(&self, image: [f64; 2], start: [f64; 2]) -> (f32, f32) {
        let (p1, p2) = (f64::from(self.p1), f64::from(self.p2));
        let [mut x, mut y] = start;
        for _ in 0..TANGENTIAL_ITERATIONS {
            let r2 = x * x + y * y;
            let radial = self.polynomial(r2);
            // Twice the derivative of `radial` by r2.
            let [k1, k2, k3] = [self.k1, self.k2, self.k3].map(f64::from);
            let bend = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));
            let (bent_x, bent_y) = self.bent(x, y);
            let xx = radial + bend * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
            let yy = radial + bend * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
            let xy = bend * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
            let (off_x, off_y) = (image[0] - bent_x, image[1] - bent_y);
            let determinant = xx * yy - xy * xy;
            let step_x = (yy * off_x - xy * off_y) / determinant;
            let step_y = (xx * off_y - xy * off_x) / determinant;
            // Beyond the fold there is no solution; the radial one stays.
            let step = step_x.hypot(step_y);
            if step.is_nan() || step >= 1.0 {
                return (start[0] as f32, start[1] as f32);
            }
            (x, y) = (x + step_x, y + step_y);
            if step < CLOSE {
                break;
            }
        }
        (x as f32, y as f32)
    }

    /// The squared distance up to which the distorted distance increases: the smallest positive root
    /// of `1 + 3 k1 r2 + 5 k2 r2^2 + 7 k3 r2^3`.
    fn reach_r2(&self) -> f64 {
        if self.k3 != 0.0 {
            return self.reach_r2_of_three();
        }
        let (a, b) = (5.0 * f64::from(self.k2), 3.0 * f64::from(self.k1));
        let discriminant = b * b - 4.0 * a;
        if discriminant < 0.0 {
            return f64::INFINITY;
        }
        let q = -0.5 * (b + discriminant.sqrt().copysign(b));
        [q / a, 1.0 / q].into_iter().filter(|root| *root > 0.0).fold(f64::INFINITY, f64::min)
    }

    /// The same with all three terms: between its extrema the cubic is monotonic, so the first of
    /// these intervals at whose end it is not positive has the root, which bisection finds.
    fn reach_r2_of_three(&self) -> f64 {
        let [k1, k2, k3] = [self.k1, self.k2, self.k3].map(f64::from);
        // The extrema are the roots of 3 k1 + 10 k2 r2 + 21 k3 r2^2.
        let discriminant = 100.0 * k2 * k2 - 252.0 * k1 * k3;
        let mut ends = [f64::INFINITY; 3];
        if discriminant >= 0.0 {
            let q = -0.5 * (10.0 * k2 + discriminant.sqrt().copysign(k2));
            let mut roots = [q / (21.0 * k3), 3.0 * k1 / q];
            roots.sort_by(f64::total_cmp);
            for (end, root) in ends.iter_mut().zip(roots.into_iter().filter(|root| *root > 0.0)) {
                *end = root;
            }
        }
        let mut low = 0.0;
        for end in ends {
            // Beyond the last extremum, a falling cubic passes zero before its terms' common bound.
            let end = if end.is_finite() {
                end
            } else if k3 < 0.0 {
                let bound = [3.0 * k1, 5.0 * k2, 1.0].map(|c| (c / (7.0 * k3)).abs());
                low + 1.0 + bound.into_iter().fold(0.0, f64::max)
            } else {
                return f64::INFINITY;
            };
            if self.slope(end) <= 0.0 {
                let mut high = end;
                for _ in 0..ITERATIONS {
                    let middle = 0.5 * (low + high);
                    if self.slope(middle) > 0.0 { low = middle } else { high = middle }
                }
                return 0.5 * (low + high);
            }
            low = end;
        }
        f64::INFINITY
    }

    /// Solves `r (1 + k1 r^2 + k2 r^4 + k3 r^6) = distance` for r by Newton's method between bounds.
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
            let newton = r - excess / self.slope(r2);
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
    fn undistortion_inverts_all_terms() {
        let lens =
            Lens { k1: -0.29, k2: 0.11, k3: -0.02, p1: 1.5e-3, p2: -8e-4, ..Lens::default() };
        for (x, y) in [(0.0f32, 0.0f32), (1e-4, 0.0), (0.3, -0.2), (-0.7, 0.5), (0.1, 0.6)] {
            let (right, down) = lens.distorted(x, y).unwrap();
            let back = lens.undistorted(right, down);
            let error = (back.0 - x).abs().max((back.1 - y).abs());
            assert!(error < 2e-6, "at {x}, {y}: {back:?}");
        }
        // By hand, at (0.5, -0.25): r2 = 0.3125.
        let radial = 1.0 - 0.29 * 0.3125 + 0.11 * 0.3125f64.powi(2) - 0.02 * 0.3125f64.powi(3);
        let x = 0.5 * radial - 2.0 * 1.5e-3 * 0.125 - 8e-4 * (0.3125 + 0.5);
        let y = -0.25 * radial + 1.5e-3 * (0.3125 + 0.125) + 2.0 * 8e-4 * 0.125;
        let (right, down) = lens.distorted(0.5, -0.25).unwrap();
        assert!((f64::from(right) - x).abs() < 1e-7 && (f64::from(down) - y).abs() < 1e-7);
    }

    #[test]
    fn three_radial_terms_reach_to_their_first_fold() {
        // Derivatives with known roots: (1 - s)(1 + s)(1 + s/2), (1 - s/2)(1 - s/3)(1 - s/4), and
        // one that only grows.
        let of = |a: f64, b: f64, c: f64| Lens {
            k1: (a / 3.0) as f32,
            k2: (b / 5.0) as f32,
            k3: (c / 7.0) as f32,
            ..Lens::default()
        };
        let close =
            |lens: Lens, root: f64| assert!((lens.reach_r2() - root).abs() < 1e-4, "{lens:?}");
        close(of(0.5, -1.0, -0.5), 1.0);
        close(of(-13.0 / 12.0, 9.0 / 24.0, -1.0 / 24.0), 2.0);
        assert_eq!(of(0.1, 0.2, 0.3).reach_r2(), f64::INFINITY);
        let lens = of(0.5, -1.0, -0.5);
        assert!(lens.factor(0.99).is_some() && lens.factor(1.01).is_none());
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
        assert_eq!(Lens::default().distorted(0.1, 1e9), Some((0.1, 1e9)));
    }
}
