//! Stripes that light each other: what one of them is made of shows in the other, too.

use crate::ladder::{close, recovered, says_why};
use crate::stripes::{self, Facing, Stripes};
use unrender_recover::{Effort, ExposureRule, Hypothesis, Options};
use unrender_scene::Rgb;

/// Equal, parallel squares whose distance is a side: their form factor in closed form is
/// `2 / pi (ln(2 / sqrt 3) + 2 sqrt 2 atan(1 / sqrt 2) - 2 atan 1)`.
const SQUARES: Facing = Facing { form_factor: 0.199_825 };

#[test]
fn every_rung_is_found_where_stripes_light_each_other() {
    let renderer = Stripes { facing: Some(SQUARES), ..Stripes::new(stripes::uniform().to_vec()) };
    let options = Options { effort: Effort::Draft, ..Options::default() };
    let recovery = recovered(&renderer, ExposureRule::Fixed(Rgb::ONE), 1.0, &options);
    for ((found, truth), hypothesis) in
        recovery.groups.iter().zip(&renderer.truth).zip(Hypothesis::ALL)
    {
        assert_eq!(found.hypothesis, hypothesis, "{}: {:#?}", found.name, found.decisions);
        says_why(found);
        assert!(close(found.material.rho_d, truth.rho_d, 0.002), "{:?}", found.material);
        assert!(close(found.material.rho_s, truth.rho_s, 0.002), "{:?}", found.material);
    }
}
