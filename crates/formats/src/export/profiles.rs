//! Photometric profiles for programs that have none, or only some of their types.

use unrender_scene::{Light, LightKind, LightProfile, Photometry, Warnings};

/// Degrees between the angles of a profile that is written in small steps. At half of it files have four times
/// the numbers, with double of it the edges of beams blur by two degrees.
const STEP_DEG: usize = 1;

/// The kind of `light` for `program`, whose exports have no profiles: a point with the same flux, and a warning.
pub(super) fn without(light: &Light, program: &str, warnings: &mut Warnings) -> LightKind {
    let LightKind::Profiled { position, intensity, profile, .. } = &light.kind else {
        return light.kind.clone();
    };
    warnings.push(format!(
        "light \"{}\": its photometric profile is not written for {program}; there it is a point light of the same flux",
        light.name
    ));
    let share = profile.steradians() / (4.0 * std::f64::consts::PI);
    LightKind::Point { position: *position, intensity: *intensity * share as f32 }
}

/// The same light as a profile of type C in small steps: Cycles is not linear between angles, which changes the light of
/// coarse tables by up to 30 %, and has only type C exactly.
pub(super) fn in_small_steps(profile: &LightProfile) -> LightProfile {
    let angles = |last: usize| (0..=last).step_by(STEP_DEG).map(|angle| angle as f32).collect();
    let (vertical, horizontal): (Vec<f32>, Vec<f32>) = (angles(180), angles(360));
    let mut candela = Vec::with_capacity(vertical.len() * horizontal.len());
    for turn in &horizontal {
        let (sin, cos) = turn.to_radians().sin_cos();
        for angle in &vertical {
            let (across, along) = angle.to_radians().sin_cos();
            let relative = profile.relative([across * cos, across * sin, along]);
            candela.push(f64::from(relative) * profile.peak_candela());
        }
    }
    // The angles are those of the type, so that this is always one.
    LightProfile::new(Photometry::C, vertical, horizontal, &candela).unwrap_or(profile.clone())
}
