//! Warns if all recovered groups are nearly black: if the lamps are read too bright, reflectances that are too
//! dark by the same factor explain the photograph equally well.

use unrender_recover::{GroupResult, Status};
use unrender_scene::color::luminance;

/// A surface that reflects less than this is dark: soot 4 %, asphalt 7 %, dark wood 10 %. At half of it lamps that are
/// ten times too bright are not noticed where a wall reflects more than half; double of it was not tried.
const DARK: f32 = 0.1;
/// Fewer dark groups may be chance. Other numbers were not tried.
const GROUPS_MIN: usize = 3;

/// The warning, if all `groups` are dark.
pub(super) fn doubt(groups: &[GroupResult]) -> Option<String> {
    let recovered = groups.iter().filter(|group| {
        matches!(group.status, Status::Recovered | Status::Doubtful) && group.pixels > 0
    });
    let reflected: Vec<f32> =
        recovered.map(|g| luminance(g.material.rho_d + g.material.rho_s)).collect();
    said(&reflected)
}

/// The same for groups of these reflectances.
fn said(reflected: &[f32]) -> Option<String> {
    let most = reflected.iter().copied().fold(0.0, f32::max);
    (reflected.len() >= GROUPS_MIN && most < DARK).then(|| {
        format!(
            "all {} groups reflect at most {:.1} % of the light (soot reflects 4 %, white walls 80 \
             %): if they are not that dark, the lights are read too bright, or the exposure is too \
             low",
            reflected.len(),
            100.0 * most
        )
    })
}

#[cfg(test)]
mod tests {
    use super::said;

    #[test]
    fn a_room_that_is_all_dark_is_doubtful_and_one_bright_wall_is_enough() {
        assert!(said(&[0.01, 0.04, 0.02]).unwrap().contains("at most 4.0 %"));
        assert_eq!(said(&[0.01, 0.04, 0.02, 0.6]), None);
        assert_eq!(said(&[0.01, 0.04]), None);
    }
}
