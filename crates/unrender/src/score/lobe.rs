//! A lobe has two descriptions: swapping the alphas and turning by 90 degrees changes nothing.

use unrender_formats::materials::GroupEntry;

/// The direction is not compared if the alphas differ by less than this share.
const ANISOTROPIC_SHARE: f64 = 0.01;

/// A lobe described so that the first alpha is the smaller one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// The smaller and the larger alpha.
    pub(super) alphas: [f64; 2],
    /// Their standard deviations.
    pub(super) stds: [Option<f32>; 2],
    /// True if alpha_x was the larger one: the smaller lies at 90 degrees to the direction.
    is_swapped: bool,
    theta_deg: Option<f64>,
    direction: Option<[f64; 3]>,
}

impl Lobe {
    /// The lobe of `entry`; none if an alpha is missing.
    pub(super) fn of(entry: &GroupEntry) -> Option<Self> {
        let std = entry.std.unwrap_or_default();
        let mut alphas = [f64::from(entry.alpha_x?), f64::from(entry.alpha_y?)];
        let mut stds = [std.alpha_x, std.alpha_y];
        let is_swapped = alphas[0] > alphas[1];
        if is_swapped {
            alphas.reverse();
            stds.reverse();
        }
        Some(Self {
            alphas,
            stds,
            is_swapped,
            theta_deg: entry.theta_deg.map(f64::from),
            direction: entry.direction.map(|d| d.map(f64::from)),
        })
    }

    /// The keys of the alphas, and their indices in [`Lobe::alphas`].
    pub(super) fn places(&self) -> [(&'static str, usize); 2] {
        let x = usize::from(self.is_swapped);
        [("alpha_x", x), ("alpha_y", 1 - x)]
    }

    /// True if the lobe has a direction.
    pub(super) fn is_anisotropic(&self) -> bool {
        self.alphas[1] > (1.0 + ANISOTROPIC_SHARE) * self.alphas[0]
    }

    /// The angle between the directions of two lobes, 0 to 90 degrees: by the directions in the
    /// world if both have one, else by theta; none if neither can be compared.
    pub(super) fn degrees_from(&self, other: &Self) -> Option<f64> {
        let straight = match (self.direction, other.direction) {
            (Some(a), Some(b)) => degrees_between_lines(a, b)?,
            _ => {
                let turned = (self.theta_deg? - other.theta_deg?).rem_euclid(180.0);
                turned.min(180.0 - turned)
            }
        };
        // If one of the two is swapped, its smaller alpha lies across the direction it states.
        Some(if self.is_swapped == other.is_swapped { straight } else { 90.0 - straight })
    }
}

fn degrees_between_lines(a: [f64; 3], b: [f64; 3]) -> Option<f64> {
    let (a, b) = (glam::DVec3::from_array(a), glam::DVec3::from_array(b));
    let (a, b) = (a.try_normalize()?, b.try_normalize()?);
    // The arc tangent stays precise where the arc cosine, near one, does not.
    Some(a.cross(b).length().atan2(a.dot(b).abs()).to_degrees())
}
