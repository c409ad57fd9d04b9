//! A measured isotropic BRDF: a table over the angles of half vector and difference [Rusinkiewicz 1998], as MERL's
//! database has it [Matusik et al. 2003].
//!
//! `h` is the unit half vector of `wi` and `wo`, `theta_h` its angle from the normal. The difference `d` is `wi` in the
//! frame whose z is `h`; `theta_d` and `phi_d` are its polar angles. An isotropic BRDF does not depend on `phi_h`, and
//! reciprocity makes `phi_d` and `phi_d + pi` the same. With `N` cells along an angle, cell `k` covers
//!
//! ```text
//! theta_h   pi/2 (k/N)^2  to  pi/2 ((k + 1)/N)^2      fine near the highlight
//! theta_d   pi/2 k/N      to  pi/2 (k + 1)/N
//! phi_d     pi k/N        to  pi (k + 1)/N
//! ```
//!
//! and its value is that of the cell's centre.

use crate::Rgb;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_2, PI};

/// A table of BRDF values, sr^-1.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredBrdf {
    counts: [usize; 3],
    /// By `theta_h`, then `theta_d`, then `phi_d`.
    cells: Vec<Rgb>,
}

impl MeasuredBrdf {
    /// The table of `cells`, by `theta_h`, then `theta_d`, then `phi_d`, of which there are `counts`. Values that are
    /// negative or not finite count as not measured. None if `cells` has another length, or is empty.
    pub fn new(counts: [usize; 3], cells: Vec<Rgb>) -> Option<Self> {
        let size = counts.iter().try_fold(1_usize, |size, count| size.checked_mul(*count))?;
        (size > 0 && size == cells.len()).then_some(Self { counts, cells })
    }

    /// The table whose cells have the values `f(wo, wi)` at their centres.
    pub fn from_fn(counts: [usize; 3], f: impl Fn(Vec3, Vec3) -> Rgb) -> Option<Self> {
        let size = counts.iter().try_fold(1_usize, |size, count| size.checked_mul(*count))?;
        let value = |index| {
            let (wo, wi) = directions(centre(counts, index));
            f(wo, wi)
        };
        Self::new(counts, (0..size).map(value).collect())
    }

    /// The number of cells along `theta_h`, `theta_d` and `phi_d`.
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// The number of cells.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// False: a table has at least one cell.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The value of the cell `index`; none if it was not measured.
    pub fn value(&self, index: usize) -> Option<Rgb> {
        let value = *self.cells.get(index)?;
        (value.is_finite() && value.min_element() >= 0.0).then_some(value)
    }

    /// `theta_h`, `theta_d` and `phi_d` of the centre of the cell `index`, radians.
    pub fn centre(&self, index: usize) -> [f32; 3] {
        centre(self.counts, index)
    }

    /// The solid angle of the pairs of directions in the cell `index`, up to a factor that all cells share:
    /// `dwi dwo = 4 cos theta_d dwh dwd`.
    pub fn weight(&self, index: usize) -> f32 {
        let [theta_h, theta_d, _] = self.centre(index);
        // The width of a cell grows with the root of theta_h.
        theta_d.cos() * theta_d.sin() * theta_h.sin() * theta_h.sqrt()
    }

    /// The value of the cell in which the unit vectors `wo` and `wi` lie, above a surface of the normal z; none if it
    /// was not measured.
    pub fn lookup(&self, wo: Vec3, wi: Vec3) -> Option<Rgb> {
        let [theta_h, theta_d, phi_d] = angles(wo, wi);
        let [n_h, n_d, n_p] = self.counts;
        let cell = |share: f32, count: usize| ((share * count as f32) as usize).min(count - 1);
        let h = cell((theta_h / FRAC_PI_2).sqrt(), n_h);
        let d = cell(theta_d / FRAC_PI_2, n_d);
        let p = cell(phi_d / PI, n_p);
        self.value((h * n_d + d) * n_p + p)
    }
}

/// The centre of the cell `index` of a table of `counts`.
fn centre([n_h, n_d, n_p]: [usize; 3], index: usize) -> [f32; 3] {
    let share = |cell: usize, count: usize| (cell as f32 + 0.5) / count as f32;
    let root = share(index / (n_d * n_p), n_h);
    let (d, p) = (share(index / n_p % n_d, n_d), share(index % n_p, n_p));
    [FRAC_PI_2 * root * root, FRAC_PI_2 * d, PI * p]
}

/// The unit vectors `wo` and `wi` of these `theta_h`, `theta_d` and `phi_d`, radians, with the half vector in the plane of x
/// and z. One of them may lie below the surface.
pub fn directions([theta_h, theta_d, phi_d]: [f32; 3]) -> (Vec3, Vec3) {
    let (half, turn) = (Vec2::from_angle(theta_h), Vec2::from_angle(phi_d));
    let (sin_d, cos_d) = theta_d.sin_cos();
    let h = Vec3::new(half.y, 0.0, half.x);
    let across = Vec3::new(half.x, 0.0, -half.y) * turn.x + Vec3::Y * turn.y;
    (h * cos_d - across * sin_d, h * cos_d + across * sin_d)
}

/// `theta_h`, `theta_d` and `phi_d`, from zero to pi, of two unit vectors, radians.
pub fn angles(wo: Vec3, wi: Vec3) -> [f32; 3] {
    let h = (wo + wi).normalize_or(Vec3::Z);
    let theta_h = h.z.clamp(-1.0, 1.0).acos();
    let theta_d = h.dot(wi).clamp(-1.0, 1.0).acos();
    // The x of the frame of h points away from the normal.
    let x = (h * h.z - Vec3::Z).normalize_or(Vec3::X);
    let phi_d = h.cross(x).dot(wi).atan2(x.dot(wi));
    [theta_h, theta_d, phi_d.rem_euclid(PI)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_directions_invert_each_other() {
        for at in [[0.3, 0.4, 1.0], [1.2, 0.2, 2.9], [0.01, 1.4, 0.1], [0.8, 0.8, 1.6]] {
            let (wo, wi) = directions(at);
            let back = angles(wo, wi);
            for (a, b) in at.into_iter().zip(back) {
                assert!((a - b).abs() < 2e-4, "{at:?} {back:?}");
            }
            // The other way round is the same cell.
            assert!((angles(wi, wo)[2] - at[2]).abs() < 2e-4, "{at:?}");
        }
    }

    #[test]
    fn a_retroreflection_and_a_mirror_have_their_angles() {
        let tilted = Vec3::new(0.6, 0.0, 0.8);
        let [theta_h, theta_d, _] = angles(tilted, tilted);
        assert!((theta_h - 0.8_f32.acos()).abs() < 1e-6 && theta_d < 1e-3);
        let [theta_h, theta_d, _] = angles(tilted, Vec3::new(-0.6, 0.0, 0.8));
        assert!(theta_h < 1e-3 && (theta_d - 0.8_f32.acos()).abs() < 1e-6);
    }

    #[test]
    fn cells_are_found_by_their_centres_and_bad_values_are_not_measured() {
        let counts = [5, 4, 6];
        let cells: Vec<Rgb> = (0..120).map(|i| Rgb::splat(i as f32)).collect();
        let mut table = MeasuredBrdf::new(counts, cells).unwrap();
        for index in 0..120 {
            let (wo, wi) = directions(table.centre(index));
            if wo.z > 0.0 && wi.z > 0.0 {
                assert_eq!(table.lookup(wo, wi), Some(Rgb::splat(index as f32)));
            }
        }
        table.cells[3] = Rgb::new(1.0, -1.0, 1.0);
        table.cells[4] = Rgb::splat(f32::NAN);
        assert_eq!((table.value(3), table.value(4), table.value(120)), (None, None, None));
        assert!(MeasuredBrdf::new([2, 2, 2], vec![Rgb::ONE; 7]).is_none());
        assert!(MeasuredBrdf::new([usize::MAX, 2, 2], Vec::new()).is_none());
    }

    #[test]
    fn weights_are_solid_angles_of_pairs_of_directions() {
        // Of pairs above the horizon, the sum is proportional to the square of a hemisphere's solid angle; the mean of
        // both cosines over it is 1/4.
        let table = MeasuredBrdf::from_fn([60, 60, 60], |_, _| Rgb::ONE).unwrap();
        let (mut all, mut cosines) = (0.0_f64, 0.0_f64);
        for index in 0..table.len() {
            let (wo, wi) = directions(table.centre(index));
            if wo.z > 0.0 && wi.z > 0.0 {
                all += f64::from(table.weight(index));
                cosines += f64::from(table.weight(index) * wo.z * wi.z);
            }
        }
        assert!((cosines / all - 0.25).abs() < 2e-3, "{}", cosines / all);
    }
}
